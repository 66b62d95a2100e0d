/*
 * Frama-C's EVA looks at whole steps of the q31 filter: kq_predict, and kq_update of independent components, of STATES states and two
 * components, with any state, model and measurement that init and earlier calls leave.
 *
 * What rests on the norm of a row, which EVA does not know, is a CONTRACT here: what the callers of a function give, which EVA has to
 * show where the step calls it, and what it answers, which harnesses of primitives.c, WP or lemmas.py show of the function itself.
 */
#include "arithmetic/q31.h"
#include "arithmetic/rows_q31.h"
#include "__fc_builtin.h"

#define WORD(most) Frama_C_interval(-(most), most)
enum { N = STATES, M = 2, EDGE = (1 << 30) + (1 << 12), FAR = 1 << 20 };

#ifdef PLANTED /* states beyond what a call leaves: to be found */
enum { HIGHEST = FAR };
#else
enum { HIGHEST = 8192 };
#endif

/* A number of any size; its sign is known where it is made */
static scaled any_number(int32_t low, int32_t high)
{
    scaled a = {0, 0};
    switch (Frama_C_interval(0, 2)) {
    case 1: a.mantissa = Frama_C_interval(1 << 30, INT32_MAX), a.exponent = Frama_C_interval(low, high); break;
    case 2: a.mantissa = Frama_C_interval(-INT32_MAX, -(1 << 30)), a.exponent = Frama_C_interval(low, high); break;
    default: break;
    }
    return a;
}

static scaled any_variance(int32_t far) { return (scaled){Frama_C_interval(1 << 30, INT32_MAX), WORD(far)}; }

/* Words of a root, and exponents: what init takes, or lowest_exponent */
static void set_root(int32_t *root, int32_t low, int32_t high)
{
    //@ loop unroll 300;
    for (int k = 0; k < KQ_TRIANGLE(N); k++) root[k] = WORD(1 << 30);
    //@ loop unroll 16;
    for (int i = 0; i < N; i++) {
        root[column(i) + i] = Frama_C_interval(0, 1 << 30);
        root[KQ_TRIANGLE(N) + i] = Frama_C_interval(low, high);
    }
}

/* The mean, which may have carries within a call, and the root */
static void set_state(int32_t *memory, int carried)
{
    //@ loop unroll 16;
    for (int i = 0; i < N; i++) {
        memory[i] = WORD(INT32_MAX);
        memory[N + i] = carried ? Frama_C_interval(-(1 << 29), (33 << 24) - 1) : Frama_C_interval(0, (1 << 24) - 1);
    }
    set_root(memory + 2 * N, lowest_exponent, HIGHEST);
}

/* ------------------------------------------------------------------ contracts: rows */

/* lemmas.py: aligned.  The scale is above what was there, and 36 bits above the largest term at most. */
static const int32_t *contract_align(int32_t *c, const scaled *row, const int32_t *E, int stride, int count, int32_t *exponent)
{
    int32_t top = *exponent;
    //@ loop unroll 16;
    for (int k = 0; k < count; k++) {
        const int32_t own = row[k].exponent + E[k * stride] + 36;
        //@ assert exponents: -FAR <= own <= FAR;
        if (row[k].mantissa != 0 && own > top) top = own;
        c[k] = WORD(1 << 30);
    }
    *exponent = Frama_C_interval(lowest_exponent, FAR);
    if (*exponent > top) *exponent = top;
    return c;
}

/* Coefficients of which the sizes add up to 2^30, of words: no sum is larger than a word, but for rounding */
static void contract_row_times_triangle(int32_t *out, const int32_t *c, const int32_t *s, int from, int n)
{
    //@ loop unroll 16;
    for (int j = n - 1; j >= from; j--) {
        //@ loop unroll 16;
        for (int k = 0; k <= j - from; k++) {
            const int32_t a = c[k], b = s[k];
            //@ assert words: \abs(a) <= 1 << 30 && \abs(b) <= EDGE;
        }
        out[j - from] = WORD(EDGE);
        s -= j;
    }
}

static void contract_noise(scaled r)
{
    //@ assert noise: r.mantissa >= 0;
}

/* A row of norm 2^30.2 at most: its square is below 2^60.4 */
static scaled contract_add_square(scaled r, const int32_t *f, int n)
{
    const int32_t exponent = f[n];
    //@ assert exponent: -FAR <= exponent <= FAR;
    contract_noise(r);
    const int32_t top = 2 * exponent + 31 > r.exponent ? 2 * exponent + 31 : r.exponent;
    scaled sum = {Frama_C_interval(1 << 30, INT32_MAX), Frama_C_interval(-2 * FAR - 31, 2 * FAR + 31)};
    if (sum.exponent > top + 1) sum.exponent = top + 1;
    if (sum.exponent < -2 * -lowest_exponent - 31) sum.exponent = -2 * -lowest_exponent - 31;
    return r.mantissa == 0 && Frama_C_interval(0, 1) ? r : sum;
}

/* lemmas.py: renormalised */
static void contract_renormalise(int32_t *S, int n)
{
    //@ loop unroll 16;
    for (int k = 0; k < KQ_TRIANGLE(n); k++) {
        const int32_t a = S[k];
        //@ assert words: \abs(a) <= 0x7fffffff;
        S[k] = WORD(1 << 30);
    }
    //@ loop unroll 16;
    for (int i = 0; i < n; i++) {
        const int32_t exponent = S[KQ_TRIANGLE(n) + i];
        //@ assert exponent: -FAR <= exponent <= FAR;
        S[KQ_TRIANGLE(n) + i] = Frama_C_interval(lowest_exponent, high_exponent + 1);
    }
}

/* lemmas.py: renormalised, of the words that fitted_exponent makes of the entries */
static void contract_root_set_row(int32_t *S, const scaled *entries, int n, int i)
{
    int32_t top = lowest_exponent;
    //@ loop unroll 16;
    for (int j = i; j < n; j++) {
        const scaled entry = entries[j - i];
        //@ assert exponent: -FAR <= entry.exponent <= FAR;
        if (entry.mantissa != 0 && entry.exponent > top) top = entry.exponent;
        S[column(j) + i] = WORD(1 << 30);
    }
    S[KQ_TRIANGLE(n) + i] = Frama_C_interval(lowest_exponent, FAR);
    if (S[KQ_TRIANGLE(n) + i] > top + 4) S[KQ_TRIANGLE(n) + i] = top + 4;
}

#define align contract_align
#define row_times_triangle contract_row_times_triangle
#define add_square contract_add_square
#define renormalise contract_renormalise
#define root_set_row contract_root_set_row

#include "arithmetic/mending_q31.h"
#include "arithmetic/mean_q31.h"
#include "arithmetic/rotor_q31.h"
#include "arithmetic/reflector_q31.h"

/* ------------------------------------------------------------------ contracts: rotations, reflectors, means */

/* lemmas.py: begun, turned, added */
static void contract_rotor_begin(rotor *t, scaled r, scaled s, const int32_t *f, int n)
{
    const int32_t exponent = f[n];
    //@ assert numbers: r.mantissa >= 0 && s.mantissa >= 0 && -FAR <= exponent <= FAR && -4 * FAR <= s.exponent <= 4 * FAR;
    t->exponent = (s.exponent - 29) >> 1;
    t->down = t->exponent - exponent;
    t->zeros = 2 * Frama_C_interval(1, 31);
    t->root = Frama_C_unsigned_int_interval(1u << 30, UINT32_MAX);
    t->inverse = Frama_C_unsigned_int_interval(1u << 31, UINT32_MAX);
}

static rotation contract_rotor_turn(rotor *t, int32_t f)
{
    //@ assert word: \abs(f) <= EDGE;
    t->zeros = 2 * Frama_C_interval(1, 31);
    t->inverse = Frama_C_unsigned_int_interval(1u << 31, UINT32_MAX);
    return (rotation){Frama_C_interval(0, INT32_MAX), WORD(INT32_MAX)};
}

/* WP: rotate_words */
static void contract_rotate(int32_t *s, int32_t *b, rotation turn, int last)
{
    //@ assert turn: 0 <= turn.c && turn.t > -0x80000000;
    //@ loop unroll 16;
    for (int i = 0; i <= last; i++) {
        const int32_t old = s[i];
        //@ assert word: \abs(old) <= EDGE;
        s[i] = WORD(EDGE);
        b[i] = WORD(EDGE);
    }
}

/* lemmas.py: reflectors.  A row and its noise keep their norm, below 2^30.2. */
enum { ROW = 1233300000 };

static int32_t contract_reflect(int32_t *w, int32_t g, const int32_t *V, int32_t g_pivot, const int32_t *pq, int count)
{
    const int32_t p = pq[0], q = pq[1];
    //@ assert reflector: 0 <= p <= (1 << 30) + 2 && 0x20000000 <= q <= 0x40000000 && \abs(g) <= 1 << 30;
    (void)g_pivot;
    //@ loop unroll 16;
    for (int k = 0; k < count; k++) {
        const int32_t a = w[k], b = V[k];
        //@ assert words: \abs(a) <= ROW && \abs(b) <= (1 << 30) + 2;
        w[k] = WORD(ROW);
    }
    return WORD(ROW);
}

static int32_t contract_close_reflector(int32_t *w, int32_t g, int32_t *pq, int count)
{
    //@ assert noise: 0 <= g <= 1 << 30;
    //@ loop unroll 16;
    for (int k = 0; k < count; k++) {
        const int32_t a = w[k];
        //@ assert word: \abs(a) <= ROW;
        w[k] = WORD((1 << 30) + 2);
    }
    pq[0] = Frama_C_interval(0, (1 << 30) + 2);
    pq[1] = Frama_C_interval(1 << 29, 1 << 30);
    return Frama_C_interval(0, ROW);
}

/* primitives.c: rows_of_16 */
static extent contract_mean_advance(int32_t *x, int n, int i, const scaled *row, int first, const int32_t *t, const int64_t *drive)
{
    //@ loop unroll 16;
    for (int k = first; k < n; k++) {
        const scaled c = row[k];
        const int32_t low = t[n + k];
        //@ assert entry: c.exponent <= -26 && 0 <= low < 1 << 24;
    }
    (void)drive;
    x[i] = WORD(INT32_MAX);
    x[n + i] = Frama_C_interval(0, (1 << 24) - 1);
    return Frama_C_interval(0, 1) ? KQ_EVENT_SATURATED : 0;
}

static scaled contract_mean_residual(int32_t z, const scaled *h, const int32_t *x, int n, int from, int to)
{
    //@ loop unroll 16;
    for (int k = from; k < to; k++) {
        const scaled c = h[k];
        const int32_t low = x[n + k];
        //@ assert entry: c.exponent <= -26 && -0x20000000 <= low < 33 << 24;
    }
    (void)z;
    return any_number(-56, 8);
}

#define rotor_begin contract_rotor_begin
#define rotor_turn contract_rotor_turn
#define rotate contract_rotate
#define reflect contract_reflect
#define close_reflector contract_close_reflector
#define mean_advance contract_mean_advance
#define mean_residual contract_mean_residual
#define mean_residual_carried(z, h, x, n) contract_mean_residual(z, h, x, n, 0, n)

#include "model/api.h"
#include "filter/low_noise.h"

/* What the careful path leaves, which is looked at by itself */
static void contract_take_with_care(filter *f, const reading *z, int c, const scaled *h, scaled e)
{
    //@ assert component: 0 <= c < M;
    //@ assert innovation: -64 <= e.exponent <= 64;
    (void)z, (void)h;
    set_state(f->memory, 1);
    f->events = (uint16_t)(f->events | Frama_C_interval(0, 0x3fff));
    f->ready = (uint8_t)(f->ready | Frama_C_interval(0, 31));
}

static void (*const careful)(filter *, const reading *, int, const scaled *, scaled) = take_with_care;

#define take_with_care contract_take_with_care
#include "filter/api.h"

/* ------------------------------------------------------------------ objects as init and calls leave them */

static kq_format_q31 formats[KQ_SIZE_MAX];
static scaled A[N * N], H[M * N], R[M];
static int32_t G[ROOT_LEN(N)], z[M], memory[FILTER_LEN(N)];
static process p;
static sensor s;
static filter f;

/* Entries of a row whose sizes add up to 16 at most */
static void set_coefficients(scaled *a, int count)
{
    //@ loop unroll 300;
    for (int k = 0; k < count; k++) a[k] = (scaled){WORD(INT32_MAX), Frama_C_interval(-KQ_EXPONENT_MAX_Q31, -26)};
}

static void set_models(void)
{
    //@ loop unroll 16;
    for (int i = 0; i < KQ_SIZE_MAX; i++) formats[i] = (kq_format_q31){INT32_MAX, 0};
    set_coefficients(A, N * N);
    set_coefficients(H, M * N);
    set_root(G, lowest_exponent, KQ_EXPONENT_MAX_Q31);
    p.states = N, p.transition = A, p.noise_root = G, p.state_format = formats;
    s.states = N, s.components = M, s.state_format = formats, s.measurement_format = formats, s.measurement = H, s.noise = R;
    s.kind = &kq_sensor_independent_q31;
    //@ loop unroll 16;
    for (int c = 0; c < M; c++) {
        R[c] = Frama_C_interval(0, 1) ? any_variance(KQ_EXPONENT_MAX_Q31) : scaled_zero();
        s.selects[c] = (uint8_t)Frama_C_interval(0, N);
        z[c] = WORD(INT32_MAX);
    }
}

static void set_filter(void)
{
    f.states = N, f.memory = memory, f.attached = 0, f.state_format = formats;
    f.ready = (uint8_t)(FILTER_READY | (Frama_C_interval(0, 1) ? FILTER_LOW_NOISE | (Frama_C_interval(0, 1) ? FILTER_NARROW : 0) : 0));
    f.weak = Frama_C_unsigned_int_interval(0, UINT32_MAX);
    f.losses = Frama_C_unsigned_int_interval(0, UINT32_MAX);
    f.last = (likelihood){Frama_C_long_long_interval(0, score_max), any_variance(likelihood_reach), Frama_C_interval(0, 16)};
    f.run = (likelihood_run){Frama_C_long_long_interval(-score_max, score_max), WORD(INT32_MAX),
                             Frama_C_interval(0, likelihood_part - 1), any_variance(620000000)};
    set_state(memory, 0);
}

/* Where the rows of A begin: each row no further left than the ones above it, or all of it 0 */
static void predict_from(int first, int second, int third)
{
    const int from[3] = {first, second, third};
    set_models();
    set_filter();
    //@ loop unroll 16;
    for (int i = 0; i < N; i++) p.first[i] = (uint8_t)from[i];
    const kq_status status = kq_predict_q31(&f, &p, 0);
    //@ assert taken: status == 0;
}

void predict(void)
{
    //@ loop unroll 16;
    for (int first = 0; first <= N; first++) {
        //@ loop unroll 16;
        for (int second = first; second <= (N > 1 ? N : first); second++) {
            //@ loop unroll 16;
            for (int third = second; third <= (N > 2 ? N : second); third++) predict_from(first, second, third);
        }
    }
}

void update(void)
{
    set_models();
    set_filter();
    const kq_status status = kq_update_q31(&f, &s, z);
    //@ assert taken: status == 0;
}

/* One component on the careful path */
void care(void)
{
    const reading now = {&s, R, z, UINT32_MAX};
    set_models();
    set_filter();
    set_state(memory, 1);
    f.ready = (uint8_t)Frama_C_interval(1, 31);
    likelihood_clear(&f.last);
    careful(&f, &now, Frama_C_interval(0, M - 1), H, any_number(-56, 8));
    //@ assert taken: f.states == N;
}
