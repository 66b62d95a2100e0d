/*
 * Models of q31, of numbers that count raw values, and what must hold of the numbers of a state: the twin of models_float.h.
 * In a corrupted input bits of the tables are turned over: they are refused, or run without harm.  Their arrays are then
 * as long as any size needs, otherwise exactly as long as theirs.
 */
#ifndef KALMANQ_FUZZ_MODELS_Q31_H
#define KALMANQ_FUZZ_MODELS_Q31_H

#include "input.h"
#include "kalmanq/prepare.h"

static int is_tame, is_corrupted;
static kq_format_q31 plain[MOST], state_format[MOST], other_format[MOST];

static size_t room(int size) { return (size_t)(is_corrupted ? MOST : size); }

/* The state's and the others' formats: of anything, or of 20 bits behind the point */
static void choose_formats(int are_tame)
{
    is_tame = are_tame;
    is_corrupted = !are_tame && byte() > 220;
    const int is_plain = is_tame || byte() < 128;
    if (!is_plain) spin();
    for (int i = 0; i < 2 * MOST; i++) {
        kq_format_q31 *f = i < MOST ? state_format + i : other_format + (i - MOST);
        plain[i % MOST] = (kq_format_q31){.fraction = 0, .range = INT32_MAX};
        *f = (kq_format_q31){.fraction = 20, .range = INT32_MAX};
        if (is_plain || byte() < 128) continue;
        f->fraction = KQ_FRACTION_MIN_Q31 + (int)below(KQ_FRACTION_MAX_Q31 - KQ_FRACTION_MIN_Q31 + 1);
        f->range = INT32_MAX >> below(31);
    }
    spin_ends();
}

static void flip(const void *bytes, size_t size)
{
    if (!is_corrupted || !size || byte() < 200) return;
    const size_t bit = (byte() | byte() << 8) % (8 * size);
    ((uint8_t *)(uintptr_t)bytes)[bit / 8] ^= (uint8_t)(1u << bit % 8);
}

static kq_format_q31 *formats(const kq_format_q31 *of, int count)
{
    kq_format_q31 *made = KEEP(kq_format_q31, room(count));
    memcpy(made, of, sizeof *made * room(count));
    flip(made, sizeof *made * (size_t)(count ? count : 1));
    return made;
}

/* Rows whose sums of magnitudes are within what a table may have, mostly */
static void limit_rows(num *M, int rows, int columns)
{
    const double most = byte() < 230 ? 15.99 : 20;
    for (int i = 0; i < rows; i++) {
        double sum = 0;
        for (int j = 0; j < columns; j++) sum += fabs(M[i * columns + j]);
        for (int j = 0; sum > most && j < columns; j++) M[i * columns + j] *= most / sum;
    }
}

static kq_scaled_q31 *table_of(const num *M, int rows, int columns)
{
    kq_scaled_q31 *made = KEEP(kq_scaled_q31, room(rows) * room(columns));
    num limited[SQUARE];
    if (columns <= 0) return made;
    memcpy(limited, M, sizeof *M * (size_t)(rows * columns));
    if (!is_tame) limit_rows(limited, rows, columns);
    (void)!kq_matrix_prepare_q31(made, limited, rows, columns, plain, plain);
    flip(made, sizeof *made * (size_t)(rows * columns));
    return made;
}

/* As numbers, but in raw values of any size; of a tame model in units of 2^-20 */
static double unit(void) { return is_tame ? 0x1p40 : ldexp(1, 2 * (int)below(50) - 50); }

static int32_t *root_of(const num *P, int n)
{
    int32_t *made = KEEP(int32_t, KQ_ROOT_LEN_Q31(room(n)));
    num scaled[SQUARE];
    const double size = unit();
    for (int k = 0; k < n * n; k++) scaled[k] = P[k] * size;
    if (kq_root_prepare_q31(made, scaled, n, plain) != KQ_OK) (void)!kq_root_prepare_factor_q31(made, NULL, n, 0, plain);
    flip(made, sizeof *made * (size_t)KQ_ROOT_LEN_Q31(n));
    return made;
}

static kq_status put_process(kq_process_q31 *p, int n, int l, const num *A, const num *B, const num *Q)
{
    kq_process_table_q31 *t = KEEP(kq_process_table_q31, 1);
    *t = (kq_process_table_q31){.states = n, .controls = l, .state_format = formats(state_format, n), .control_format = formats(other_format, l),
        .transition = table_of(A, n, n), .control = table_of(B, n, l), .noise_root = root_of(Q, n)};
    flip(&t->states, sizeof t->states), flip(&t->controls, sizeof t->controls);
    return kq_process_init_q31(p, t, NULL);
}

static kq_status put_sensor(kq_sensor_q31 *s, unsigned kind, int n, int m, const num *H, const num *R)
{
    kq_sensor_table_q31 *t = KEEP(kq_sensor_table_q31, 1);
    kq_scaled_q31 *noise = KEEP(kq_scaled_q31, KQ_TRIANGLE(room(m)));
    num scaled[SQUARE], r[MOST];
    const double size = unit();
    for (int k = 0; k < m * m; k++) scaled[k] = R[k] * size;
    for (int c = 0; c < m; c++) r[c] = scaled[c * m + c];
    if (kind % 3 == 0) (void)!kq_noise_prepare_q31(noise, scaled, m, plain);
    else (void)!kq_noise_prepare_diagonal_q31(noise, r, m, plain);
    flip(noise, sizeof *noise * (size_t)m);
    *t = (kq_sensor_table_q31){.states = n, .components = m, .correlated = kind % 3 == 0, .state_format = formats(state_format, n),
        .measurement_format = formats(other_format, m), .measurement = table_of(H, m, n), .noise = noise};
    flip(&t->components, sizeof t->components), flip(&t->correlated, sizeof t->correlated);
    if (kind == 3) return kq_sensor_init_extended_q31(s, t, NULL);
    if (kind == 4) return kq_sensor_init_lean_extended_q31(s, t, NULL);
    if (kind == 5) return kq_sensor_init_diagonal_extended_q31(s, t, NULL);
    return kind == 0 ? kq_sensor_init_q31(s, t, NULL) : kind == 1 ? kq_sensor_init_lean_q31(s, t, NULL) : kq_sensor_init_diagonal_q31(s, t, NULL);
}

static kq_prior_table_q31 prior_of(int n, const word *x, const num *P)
{
    int32_t *mean = KEEP(int32_t, room(n));
    memcpy(mean, x, sizeof *x * (size_t)n);
    flip(mean, sizeof *mean * (size_t)n);
    return (kq_prior_table_q31){.states = n, .state_format = formats(state_format, n), .mean = mean, .root = root_of(P, n)};
}

static kq_status put_prior(kq_filter_q31 *f, int n, const word *x, const num *P)
{
    const kq_prior_table_q31 t = prior_of(n, x, P);
    return kq_filter_init_q31(f, &t, NULL);
}

static kq_status begin_start(kq_diffuse_q31 *s, kq_filter_q31 *f, int n, const word *x, const num *P, unsigned unknown)
{
    const kq_prior_table_q31 t = prior_of(n, x, P);
    return kq_diffuse_init_q31(s, f, &t, unknown, NULL);
}

/* Within the range, at its end, or now and then beyond it, which is refused */
static word word_in(const kq_format_q31 *f)
{
    const unsigned kind = byte();
    if (kind >= 253) return f->range < INT32_MAX && kind < 255 ? f->range + 1 : INT32_MIN;
    if (kind >= 245) return kind & 1 ? f->range : -f->range;
    return (word)(ldexp((double)kind - 122, -(int)below(32)) / 128 * f->range);
}

static void words_in(word *x, const kq_format_q31 *f, int count)
{
    spin_if_many(count);
    for (int k = 0; k < count; k++) x[k] = word_in(f + k);
    spin_ends();
}

static void state_words(word *x, int n) { words_in(x, state_format, n); }
static void sensor_words(word *z, const kq_sensor_q31 *s) { words_in(z, s->measurement_format ? s->measurement_format : other_format, s->components); }
static void control_words(word *u, const kq_process_q31 *p) { words_in(u, p->control_format ? p->control_format : other_format, p->controls); }
static word word_of(num a) { return (word)ldexp(a, 20); }

static entry entry_of(num a)
{
    entry made = {0, 0};
    (void)!kq_matrix_prepare_q31(&made, &a, 1, 1, plain, plain);
    return made;
}

static kq_status change_transition(kq_process_q31 *p, int n)
{
    num A[SQUARE];
    return numbers(A, n * n), kq_process_change_transition_q31(p, table_of(A, n, n), NULL);
}

static kq_status change_jacobian(kq_process_q31 *p, int n)
{
    num A[SQUARE];
    return numbers(A, n * n), kq_process_change_jacobian_q31(p, table_of(A, n, n), NULL);
}

static kq_status change_measurement(kq_sensor_q31 *s, int n)
{
    num H[SQUARE];
    return numbers(H, s->components * n), kq_sensor_change_measurement_q31(s, table_of(H, s->components, n), NULL);
}

static int32_t scaled_root[KQ_ROOT_LEN_Q31(MOST)];

static kq_status scale_noise(kq_process_q31 *to, const kq_process_q31 *from, int n, entry q)
{
    return (void)n, kq_process_scale_noise_q31(to, from, scaled_root, q);
}

static kq_status smooth_reweighted(kq_history_q31 *h, kq_process_q31 *to, const kq_process_q31 *from, entry nu, entry *q)
{
    return kq_smooth_reweighted_q31(h, to, from, scaled_root, nu, q);
}

static void assign_adaptation(kq_adaptation_q31 *a, int n, int m)
{
    const size_t length = (size_t)KQ_ADAPTATION_LEN_Q31(n, m);
    DEMAND(kq_adaptation_assign_q31(a, n, m, KEEP(kq_scaled_q31, length), length, words((size_t)KQ_ROOT_LEN_Q31(n))) == KQ_OK);
}

static int64_t limit_of(num a) { return a > 0 && a < 1e9 ? (int64_t)ldexp(a, 24) : INT64_MAX; }

/* ------------------------------------------------------------------ what must hold of numbers */

static double value_of(entry a) { return ldexp(a.mantissa, a.exponent); }
static int is_none(entry variance) { return variance.mantissa == 0; }
static int is_negative(entry variance) { return variance.mantissa < 0; }

static double ratio(entry p, entry a, entry b)
{
    const int32_t sum = a.exponent + b.exponent;
    const double m = p.mantissa / sqrt((double)a.mantissa * b.mantissa);
    return ldexp(sum & 1 ? m * sqrt(0.5) : m, p.exponent - (sum >> 1));
}

/* Norms of the rows of the root at S, and the exponents behind it */
static void check_root(const int32_t *S, int n)
{
    for (int i = 0; i < n; i++) {
        double square = 0;
        for (int j = i; j < n; j++) square += (double)S[j * (j + 1) / 2 + i] * S[j * (j + 1) / 2 + i];
        DEMAND(square < 0x1p60 && abs(S[KQ_TRIANGLE(n) + i]) <= 20000);
    }
}

static void check_entries(const entry *a, int count)
{
    for (int k = 0; k < count; k++) {
        const int64_t size = llabs((long long)a[k].mantissa);
        DEMAND((size == 0 && a[k].exponent == 0) || (size >= INT64_C(1) << 30 && size < INT64_C(1) << 31));
    }
}

/* A mean within its word, in two planes; rows of the root, readings, normalised numbers */
static void check_numbers(const kq_filter_q31 *f, const entry *P)
{
    const int n = f->states;
    for (int i = 0; f->memory && i < n; i++) {
        const int64_t whole = (int64_t)f->memory[i] * (1 << 24) + f->memory[n + i];
        DEMAND(f->memory[n + i] >= 0 && f->memory[n + i] < 1 << 24 && llabs(whole) < INT64_C(1) << 55);
    }
    if (f->memory) check_root(f->memory + 2 * n, n);
    for (int i = 0; i < n; i++) {
        DEMAND(kq_mean_q31(f, i) != KQ_NOT_A_VALUE_Q31 && kq_sigma_q31(f, i) >= 0);
        DEMAND(llabs((long long)kq_mean_low_q31(f, i)) <= 1 << 24);
    }
    check_entries(P, n * n);
}

#endif
