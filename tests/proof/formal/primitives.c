/*
 * Frama-C's EVA looks at every primitive of the q31 number layer, with any input that its comment lets through.
 * What it has to show: no overflow, no shift out of range, no word cut, each `bits` kept (acsl.txt), and what is asserted here.
 */
#include "arithmetic/q31.h"
#include "arithmetic/arithmetic.h"
#include "__fc_builtin.h"

#define WORD(most) Frama_C_interval(-(most), most)
#define WIDE(most) Frama_C_long_long_interval(-(most), most)
#define ANY_WORD Frama_C_interval(INT32_MIN, INT32_MAX)
#define ANY_WIDE Frama_C_long_long_interval(INT64_MIN, INT64_MAX)
#define P(k) (INT64_C(1) << (k))
enum { FAR = 1 << 20, N = 3 };

/* A normalised number, each sign apart */
#define NUMBER(a, from, to)                                                                     \
    scaled a = {0, 0};                                                                          \
    switch (Frama_C_interval(0, 2)) {                                                           \
    case 1: a = (scaled){Frama_C_interval(1 << 30, INT32_MAX), Frama_C_interval(from, to)}; break; \
    case 2: a = (scaled){Frama_C_interval(-INT32_MAX, -(1 << 30)), Frama_C_interval(from, to)}; break; \
    default: break;                                                                             \
    }
#define NORMAL(a) /*@ assert normal: a.mantissa == 0 || 0x40000000 <= \abs(a.mantissa) <= 0x7fffffff; */

/* ------------------------------------------------------------------ fixed.h, integer.h */

static void shifts_down(void)
{
    const int32_t a = ANY_WORD, down = Frama_C_interval(0, INT32_MAX);
    const int64_t b = WIDE(INT64_MAX - 1);
    const int32_t c = shift_down_rounded(a, down);
    shift_down_rounded_wide(b, down);
    magnitude(a);
    /*@ assert no_larger: \abs(c) <= 0x80000000; */
}

static void words(void)
{
    NUMBER(a, -FAR, FAR)
    const int32_t w = word_of(a);
    /*@ assert \abs(w) <= 0x7fffffff; */
    is_weak(a, a);
    num_folded(num_nan());
    low_noise_share(a);
}

/* ------------------------------------------------------------------ scaled_q31.h */

static void numbers(void)
{
    NUMBER(a, -FAR, FAR)
    NUMBER(b, -FAR, FAR)
    const scaled p = scaled_times(a, b);
    NORMAL(p)
    const scaled s = scaled_plus(a, b);
    NORMAL(s)
    const scaled d = scaled_minus(a, b);
    NORMAL(d)
    scaled_add(&a, &b);
    NORMAL(a)
}

static void numbers_more(void)
{
    NUMBER(a, -FAR, FAR)
    NUMBER(b, -FAR, FAR)
    NUMBER(c, -FAR, FAR)
    NUMBER(d, -FAR, FAR)
    const scaled t = scaled_products(a, b, c, d);
    NORMAL(t)
    const scaled q = scaled_add_square(a, b);
    NORMAL(q)
    scaled_add_times(&a, &b, &c);
    NORMAL(a)
}

static void quotients(void)
{
    NUMBER(a, -FAR, FAR)
    NUMBER(b, -FAR, FAR)
    if (b.mantissa != 0) {
        const scaled q = scaled_over(a, b);
        NORMAL(q)
    }
    const scaled r = scaled_root(a);
    NORMAL(r)
    const scaled m = scaled_magnitude(a), l = scaled_saturated(b);
    scaled_is_less(m, scaled_magnitude(b));
    scaled_log(a);
    /*@ assert l.exponent <= 8192; */
}

static void any_wide(void)
{
    const int64_t a = ANY_WIDE;
    const scaled s = scaled_of(a, WORD(FAR));
    NORMAL(s)
    const int64_t held = held_within(a, P(61));
    /*@ assert \abs(held) <= (1 << 61); */
}

/* ------------------------------------------------------------------ mean_q31.h */

/* A mean as calls leave it, or with carries of at most 2^5 */
static void set_mean(int32_t *x, int carried)
{
    for (int i = 0; i < N; i++) {
        x[i] = ANY_WORD;
        x[N + i] = carried ? Frama_C_interval(-(1 << 29), (33 << 24) - 1) : Frama_C_interval(0, (1 << 24) - 1);
    }
}

static void mean_words(void)
{
    int32_t x[2 * N];
    set_mean(x, 0);
    const wide a = wide_get(x, N, 0);
    /*@ assert wide: \abs(a) <= 1 << 55; */
    const int32_t near = mean_get(x, N, 0);
    /*@ assert near: \abs(near) <= 0x7fffffff; */
    mean_set(x, N, 1, ANY_WORD);
    wide_set(x, N, 2, WIDE(wide_max));
    mean_is_possible(x, N, 0);
    mean_extent(x, N, 0);
    int32_t copy[2 * N];
    mean_copy(copy, x, N);
    mean_settle(x, N);
}

static void mean_held(void)
{
    int32_t x[2 * N];
    wide_set_saturated(x, N, ANY_WIDE);
    /*@ assert low: 0 <= x[N] < 1 << 24; */
    wide_set_carried(x, N, 1, ANY_WIDE);
    /*@ assert carry: -(1 << 29) <= x[N + 1] < 33 << 24; */
    set_mean(x, 1);
    const wide a = carried_get(x, N, 0);
    /*@ assert carried: \abs(a) <= (1 << 61) + (1 << 57); */
    mean_saturate(x, N, 0);
    /*@ assert low: 0 <= x[N] < 1 << 24; */
}

static void products(void)
{
    int32_t x[2 * N];
    set_mean(x, 0);
    NUMBER(c, -1000, -27)
    if (c.mantissa != 0) {
        const int64_t p = wide_product(c, x[0], x[N]);
        /*@ assert product: \abs(p) <= 1 << 61; */
    }
    const scaled most = SCALED_POWER(4);
    const int64_t q = wide_product(most, x[0], x[N]);
    /*@ assert product: \abs(q) <= 1 << 61; */
    word_product((scaled){WORD(INT32_MAX), 0}, ANY_WORD, ANY_WORD);
    const wide w = wide_from(WIDE(INT64_MAX - 1), WORD(FAR), 62);
    /*@ assert cut: \abs(w) <= 1 << 62; */
    was_cut(w, 62);
    wide_from(WIDE(INT64_MAX - 1), WORD(FAR), 55);
    wide_from(WIDE(INT64_MAX - 1), WORD(FAR), 61);
}

static void mean_moves_by(void)
{
    int32_t x[2 * N], d[2 * N];
    set_mean(x, 0), set_mean(d, 0);
    mean_shift(x, N, d, d + N);
    mean_shift(x, N, d, 0);
    const scaled b = {WORD((1 << 30) + (1 << 10)), WORD(FAR)};
    NUMBER(w, -FAR, FAR)
    mean_correct(x, N, 0, b, w);
    set_mean(x, 1);
    mean_correct_exactly(x, N, 0, b, w);
}

/*
 * A row whose sizes add up to 16 at most, by octaves: octave o is 2^o <= |c| < 2^(o + 1), and -1 all below 1.  Where the least
 * sizes are 16 together these are the sizes.  Answers whether there is such a row.
 */
static int set_row(scaled *row, const int *octave)
{
    int least = 0;
    /*@ loop unroll N; */
    for (int k = 0; k < N; k++) least += octave[k] < 0 ? 0 : 1 << octave[k];
    /*@ loop unroll N; */
    for (int k = 0; k < N; k++) {
        const int32_t exponent = octave[k] < 0 ? Frama_C_interval(-1000, -31) : octave[k] - 30;
        row[k] = (scaled){WORD(least == 16 ? 1 << 30 : INT32_MAX), exponent};
        if (least == 16 && octave[k] < 0) row[k] = scaled_zero();
    }
    return least <= 16;
}

static void row_of_16(const scaled *row)
{
    int32_t x[2 * N], t[2 * N], u[N];
    set_mean(x, 0), set_mean(t, 0);
    for (int k = 0; k < N; k++) u[k] = WORD(INT32_MAX);
    mean_residual(WORD(INT32_MAX), row, x, N, 0, N);
    control_drive(row, u, N);
    mean_advance(x, N, 0, row, 0, t, 0);
    wide known[N];
    for (int k = 0; k < N; k++) known[k] = WIDE(wide_max);
    steady_row(known, N, row, 0, x);
    steady_residual(WORD(INT32_MAX), row, 0, known, N);
}

static void rows_of_16(void)
{
    int octave[N];
    scaled row[N];
    /*@ loop unroll 6; */
    for (octave[0] = -1; octave[0] < 5; octave[0]++) {
        /*@ loop unroll 6; */
        for (octave[1] = -1; octave[1] < 5; octave[1]++) {
            /*@ loop unroll 6; */
            for (octave[2] = -1; octave[2] < 5; octave[2]++) {
                if (set_row(row, octave)) row_of_16(row);
            }
        }
    }
}

/* A carry of 2^5 at most beside every word */
static void residuals_carried(void)
{
    int32_t x[2 * N];
    set_mean(x, 1);
    scaled h[N];
    for (int k = 0; k < N; k++) {
        NUMBER(c, -1000, -28)
        h[k] = c;
    }
    mean_residual_carried(WORD(INT32_MAX), h, x, N);
    scaled e = {0, 0};
    mean_take_carries(&e, h, x, N);
}

/* ------------------------------------------------------------------ gains_q31.h, scores_q31.h */

static void steady(void)
{
    int32_t x[2 * N];
    scaled row[N];
    steady_number e[N];
    for (int k = 0; k < N; k++) {
        NUMBER(c, -FAR, FAR)
        row[k] = c;
        e[k] = steady_mantissa(WIDE(P(61)));
    }
    set_mean(x, 0);
    steady_add(x, WIDE(wide_max), N, 0, row, e, N);
    steady_word_of(e[0]);
    steady_set(x, N, 0, WORD(INT32_MAX));
    steady_keep(x, N, 0, WIDE(wide_max));
    wide t;
    steady_saturate(&t, ANY_WIDE);
    /*@ assert held: \abs(t) < 1 << 55; */
}

static void scores(void)
{
    NUMBER(a, -FAR, FAR)
    const score s = score_of(a);
    /*@ assert score: \abs(s) <= 1 << 61; */
    num word[2];
    store_score(word, WIDE(P(61)));
    word[0] = Frama_C_interval(-(1 << 30), 1 << 30), word[1] = Frama_C_interval(0, INT32_MAX);
    load_score(word);
    compensated t = {WIDE(score_max)};
    compensated_add(&t, WIDE(P(61)));
    /*@ assert sum: \abs(t.sum) <= 1 << 61; */
    const scaled c = {Frama_C_interval(1 << 30, INT32_MAX), Frama_C_interval(-FAR, -31)};
    compensated_forget(&t, c);
    /*@ assert sum: \abs(t.sum) <= 1 << 62; */
}

/* ------------------------------------------------------------------ coordinates_q31.h, maps_q31.h */

static void coordinates(void)
{
    int32_t a[2 * N];
    set_mean(a, 0);
    wide b = WIDE(wide_max);
    NUMBER(c, -61, -31)
    NUMBER(s, -61, -31)
    coordinate_turn(a, N, 0, &b, c, s);
    coordinate_turn(a, N, 0, &b, scaled_one, scaled_zero());
    NUMBER(value, -FAR, FAR)
    coordinate_of(&b, value);
    coordinate_scaled(b);
    set_mean(a, 0);
    coordinate_move(a, N, 0, WORD(1 << 29), value);
    coordinate_saturate(&b, ANY_WIDE);
}

static void coordinate_rows(void)
{
    int32_t a[2 * N], row[N * N], V[N], pq[2] = {WORD((1 << 30) + 2), Frama_C_interval(1 << 30, INT32_MAX)};
    set_mean(a, 0);
    for (int k = 0; k < N * N; k++) row[k] = WORD(1 << 29);
    for (int k = 0; k < N; k++) V[k] = WORD((1 << 30) + 2);
    coordinate_dot(row, a, N, N);
    coordinate_through(row, 0, a, a, N);
    reflect_back(a, N, 0, WIDE(wide_max), V, pq);
    unit_room(row, N);
}

static void tape(void)
{
    const scaled before = {Frama_C_interval(1 << 30, INT32_MAX), WORD(16384)}, after = {Frama_C_interval(1 << 30, INT32_MAX), WORD(16384)};
    NUMBER(f, -16384, 16384)
    rotation_word(f, before, after);
    scaled c, s;
    rotation_of(ANY_WORD, &c, &s);
    int32_t record[3];
    store_noise(record, f, after);
    load_noise(record, &c, &s);
}

/* ------------------------------------------------------------------ rows_q31.h, mending_q31.h */

enum { ROOT = ROOT_LEN(N), EDGE = (1 << 30) + (1 << 10) };

/* Words of rows of norm 2^30 at most, but for rounding, of any exponents */
static void set_root(int32_t *S, int32_t most)
{
    for (int k = 0; k < KQ_TRIANGLE(N); k++) S[k] = WORD(most);
    for (int k = 0; k < N; k++) S[KQ_TRIANGLE(N) + k] = Frama_C_interval(-16384, 16384);
}

static void rows(void)
{
    int32_t S[ROOT], f[ROW_LEN(N)];
    set_root(S, EDGE);
    for (int k = 0; k < N; k++) f[k] = WORD(INT32_C(1) << 30);
    f[N] = WORD(40000);
    const scaled r = {Frama_C_interval(1 << 30, INT32_MAX), WORD(100000)};
    add_square(r, f, N);
    row_product(f, f, N);
    row_entry(f, N, 0);
    root_product(S, N, 0, 1);
    root_number(S, N, 0, 1);
    scaled P[N * N], out[N];
    root_square(P, S, N);
    root_times_row(out, S, f, N);
    NUMBER(a, -1000, 1000)
    entry_exponent(a, exponents_of(S, N));
    state_is_within(S, N, 0);
    root_lower(S, Frama_C_interval(0, 30), N);
    row_clear(S, N, 1);
}

static void roots_scaled(void)
{
    int32_t S[ROOT];
    set_root(S, 1 << 30);
    const scaled c = {Frama_C_interval(1 << 30, INT32_MAX), Frama_C_interval(-1000, 1000)};
    root_scale(S, c, N);
    set_root(S, 1 << 30);
    const scaled small = {Frama_C_interval(1 << 30, INT32_MAX), Frama_C_interval(-1000, -32)};
    root_grow(S, small, N);
    root_grow(S, scaled_one, N);
}

/* ------------------------------------------------------------------ rotor_q31.h, reflector_q31.h */

static void reflections(void)
{
    int32_t w[N], V[N], pq[2] = {Frama_C_interval(0, (1 << 30) + 2), Frama_C_interval(1 << 30, 1 << 30)};
    for (int k = 0; k < N; k++) w[k] = WORD(1 << 29), V[k] = WORD((1 << 30) + 2);
    reflect_unit(w, V, pq, 0, N);
    int32_t G[ROOT], row[ROW_LEN(N)];
    set_root(G, 1 << 30);
    row[N] = noise_exponent(G, N, 0);
    noise_word(G, Frama_C_interval(1, 100000));
}

/* What project_exactly asks of a coefficient that was shifted down by 1 .. 31 */
static void remainders_rounded(void)
{
    for (int32_t down = 1; down < 32; down++) remainder_word(WORD(INT32_MAX), down - 27);
}

/* A word of a number by its row's exponent, at least 4 above the largest; one of an inverse */
static void fitted(void)
{
    NUMBER(a, -FAR, FAR)
    const int32_t word = shift_down_rounded(a.mantissa, Frama_C_interval(4, INT32_MAX));
    /*@ assert word: \abs(word) <= 1 << 27; */
    const int32_t entry = entry_of_inverse(WIDE(P(62)), WORD(1 << 30));
    /*@ assert held: \abs(entry) <= 1 << 30; */
}

int main(void)
{
    shifts_down();
    words();
    numbers();
    numbers_more();
    quotients();
    any_wide();
    mean_words();
    mean_held();
    products();
    mean_moves_by();
    rows_of_16();
    residuals_carried();
    steady();
    scores();
    coordinates();
    coordinate_rows();
    tape();
    rows();
    roots_scaled();
    reflections();
    remainders_rounded();
    fitted();
    return 0;
}
