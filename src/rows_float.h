/*
 * Rows of a matrix in floating point, where a row needs no exponent: the twin of rows_q31.h, which
 * says what each operation is.
 */
#ifndef KALMANQ_ROWS_H
#define KALMANQ_ROWS_H

#include "scaled_float.h"
#include "triangle.h"

typedef num sum;

#define ROW_LEN(width) (width)
#define ROOT_LEN(n) KQ_TRIANGLE(n)
#define SCALED_WORDS 1

static const int32_t lowest_exponent = 0;
static const int32_t one_exponent = 0;
static const num num_one = 1;

static inline const num *exponents_of(const num *S, int n) { return S + KQ_TRIANGLE(n); }

/* Two rows at a time save loads, which count; in fixed point multiplications do. */
enum { rows_in_pairs = 1 };

/* Where sizes are known, S is in registers: a row of it cannot be selected.  Up to so many states a
   step works on a copy that is in registers, and up to so many its components are unrolled. */
enum { select_always = 0, states_in_registers = 3, states_unrolled = 4 };

static inline int32_t entry_exponent(scaled h, const num *E)
{
    (void)h, (void)E;
    return 0;
}

static inline void row_set_exponent(num *row, int width, int32_t exponent)
{
    (void)row, (void)width, (void)exponent;
}

static inline scaled row_entry(const num *row, int width, int k)
{
    (void)width;
    return row[k];
}

static inline sum add_product(sum total, num a, num b) { return total + a * b; }

KQ_INLINE sum dot(sum total, const num *a, const num *b, int count)
{
    KQ_UNROLL
    for (int k = 0; k < count; k++) total = add_product(total, a[k], b[k]);
    return total;
}

/* rows_q31.h */
KQ_INLINE void row_times_triangle(num *out, const num *c, const num *s, int from, int n)
{
    KQ_UNROLL
    for (int j = n - 1; j >= from; j--) {
        out[j - from] = dot(c[0] * s[0], c + 1, s + 1, j - from);
        s -= j;
    }
}

KQ_INLINE void short_row_times_triangle(num *out, const num *c, int count, const num *s, int n)
{
    KQ_UNROLL
    for (int j = n - 1; j >= 0; j--) {
        out[j] = dot(c[0] * s[0], c + 1, s + 1, (j < count ? j + 1 : count) - 1);
        s -= j;
    }
}

/* A column is loaded once for both. */
KQ_INLINE void two_rows_times_triangle(num *w, num *v, const num *a, const num *b, const num *s,
                                       int from, int n)
{
    KQ_UNROLL
    for (int j = n - 1; j >= from; j--) {
        num of_a = a[0] * s[0], of_b = b[0] * s[0];
        KQ_UNROLL
        for (int k = 1; k <= j - from; k++) {
            of_a = add_product(of_a, a[k], s[k]);
            of_b = add_product(of_b, b[k], s[k]);
        }
        w[j - from] = of_a;
        v[j - from] = of_b;
        s -= j;
    }
}

static inline scaled row_product(const num *a, const num *b, int width)
{
    return dot(0, a, b, width);
}

/* r + f'f */
static inline scaled add_square(scaled r, const num *f, int n)
{
    const num first = n > 0 ? f[0] * f[0] : 0; /* not added to 0 */
    return r + dot(first, f + 1, f + 1, n - 1);
}

static inline const num *align(num *c, const scaled *row, const num *E, int stride, int count,
                               int32_t *exponent)
{
    (void)c, (void)E, (void)stride, (void)count, (void)exponent;
    return row;
}

static inline scaled root_entry(const num *S, int n, int i, int k)
{
    (void)n;
    return S[column(k) + i];
}

static inline scaled root_sum(sum total, const num *S, int n, int i, int j)
{
    (void)S, (void)n, (void)i, (void)j;
    return total;
}

/* S <- c S; the caller renormalises it */
static inline void root_scale(num *S, scaled c, int n)
{
    for (int k = 0; k < KQ_TRIANGLE(n); k++) S[k] *= c;
}

/* S <- S + c S, c >= 0, rounded at the increment; the caller renormalises it */
static inline void root_grow(num *S, scaled c, int n)
{
    for (int k = 0; k < KQ_TRIANGLE(n); k++) S[k] += c * S[k];
}

static inline void row_fitted(num *row, const scaled *entries, int width)
{
    for (int k = 0; k < width; k++) row[k] = entries[k];
}

/* Row i of S through the rotations of cosines c and sines t.  Answers entry i of S f / sqrt(s). */
static inline scaled turn_root_row(num *S, const scaled *c, const scaled *t, scaled *scratch, int n,
                                   int i)
{
    num *s = S + column(i) + i, b = 0;
    (void)scratch;
    for (int j = i; j < n; j++) {
        const num old = *s;
        *s = c[j] * old - t[j] * b;
        b = c[j] * b + t[j] * old;
        s += j + 1;
    }
    return b;
}

/* Row i of S, columns i .. end - 1, += rest / h */
static inline void mend_root_row(num *S, const scaled *rest, scaled h, scaled *scratch, int n, int i,
                                 int end)
{
    num *s = S + column(i) + i;
    (void)scratch, (void)n;
    for (int j = i; j < end; j++) {
        *s += rest[j] / h;
        s += j + 1;
    }
}

/*
 * f = S'h in numbers.  Answers what rounding alone makes of f'f, squared sums of its terms' sizes: a
 * variance below it says nothing.  (64 eps)^2: f's own rounding, and that of S
 * from earlier updates, whose rows were longer.
 */
static num project_exactly(num *f, const num *S, const num *h, num *rests, int n)
{
    num total = 0;
    (void)rests;
    for (int j = 0; j < n; j++) {
        num sum = 0, size = 0;
        for (int i = 0; i <= j; i++) {
            const num term = h[i] * *S++;
            sum += term;
            size += num_magnitude(term);
        }
        f[j] = sum;
        total += size * size;
    }
    return 4096 * num_epsilon * num_epsilon * total;
}

static inline num combined(sum total) { return total; }

static inline int32_t noise_exponent(const num *G, int n, int l)
{
    (void)G, (void)n, (void)l;
    return 0;
}

static inline int32_t noise_shift(const num *G, int n, int l, const num *row, int width)
{
    (void)G, (void)n, (void)l, (void)row, (void)width;
    return 0;
}

static inline num noise_word(const num *g, int32_t shift)
{
    (void)shift;
    return *g;
}

static inline num reflector_pivot(const num *g) { return *g; }

/* r and g_pivot are not normalised: p = 1 / s and q = 1 / (s + g_pivot), s their norm */
KQ_INLINE num reflect(num *restrict w, num g, const num *restrict r, num g_pivot, const num *pq,
                      int count)
{
    const num entry = dot(g * g_pivot, w, r, count) * pq[0];
    const num factor = -(entry + g) * pq[1];
    KQ_UNROLL
    for (int k = 0; k < count; k++) w[k] += factor * r[k];
    return entry;
}

KQ_INLINE num reflect_unit(num *restrict w, const num *restrict r, const num *pq, int at, int count)
{
    const num entry = r[at] * pq[0], factor = -entry * pq[1];
    KQ_UNROLL
    for (int k = 0; k < count; k++) w[k] = factor * r[k];
    w[at] += 1;
    return entry;
}

KQ_INLINE num reflect_longer(num *restrict w, const num *restrict r, const num *pq, int zeros,
                             int count)
{
    const int first = zeros + 1;
    const num entry = dot(w[zeros] * r[zeros], w + first, r + first, count - first) * pq[0];
    const num factor = -entry * pq[1];
    KQ_UNROLL
    for (int k = 0; k < zeros; k++) w[k] = factor * r[k];
    KQ_UNROLL
    for (int k = zeros; k < count; k++) w[k] += factor * r[k];
    return entry;
}

/* Two rows w and v, their entries into s and the word before it */
KQ_INLINE void reflect_two(num *s, num *restrict w, num *restrict v, num g_w, num g_v,
                           const num *restrict r, num g_pivot, const num *pq, int count)
{
    num of_w = g_w * g_pivot, of_v = g_v * g_pivot;
    KQ_UNROLL
    for (int k = 0; k < count; k++) {
        of_w = add_product(of_w, w[k], r[k]);
        of_v = add_product(of_v, v[k], r[k]);
    }
    of_w *= pq[0];
    of_v *= pq[0];
    s[0] = of_w;
    s[-1] = of_v;
    of_w = -(of_w + g_w) * pq[1];
    of_v = -(of_v + g_v) * pq[1];
    KQ_UNROLL
    for (int k = 0; k < count; k++) {
        w[k] += of_w * r[k];
        v[k] += of_v * r[k];
    }
}

/* The pivot of a row without noise.  G_ii >= num_tiny_root, so no norm is ever 0 and nothing needs
   a test. */
#define num_no_noise num_tiny_root

KQ_INLINE num close_reflector(const num *w, num g, num *pq, int count)
{
    const num s = num_root(dot(g * g, w, w, count));
    pq[0] = 1 / s;
    pq[1] = 1 / (s + g);
    return s;
}

static inline void root_take_exponent(num *S, int n, int l, const num *row, int width)
{
    (void)S, (void)n, (void)l, (void)row, (void)width;
}

static inline void renormalise(num *S, int n) { (void)S, (void)n; }

/* ------------------------------------------------------------------ update */

static inline scaled least_noise(scaled r, scaled s, const scaled *h, int n)
{
    (void)s, (void)h, (void)n;
    return r;
}

/* Is there nothing that the careful update is for: rounding, sharpness, overflow? */
static inline int is_ordinary(scaled r, scaled s, scaled e)
{
    return r >= sharp_share(s) + num_zero_variance && e * (e / s) <= num_most_nis;
}

/* May a sensor without the careful path take it? */
static inline int is_blunt(scaled r, scaled s, scaled e) { return is_ordinary(r, s, e); }

/* Is a noise large enough for the variance of an innovation, which is no smaller, to count? */
static inline int noise_is_ordinary(scaled r) { return r >= 2 * num_zero_variance; }

/* The same for such a noise in one comparison, which some ordinary ones fail, too: r is not below twice
   its share of s, and e^2 / s is below 2^16 or, in double, 2^48. */
static inline int is_surely_ordinary(scaled r, scaled s, scaled e)
{
    return r > num_sure_share * (s + e * e);
}

typedef struct {
    num a;
} rotor;

typedef struct {
    num c, g, f;
} rotation;

static inline rotor rotor_begin(scaled r, scaled s, const num *f, int n)
{
    (void)s, (void)f, (void)n;
    return (rotor){.a = r};
}

/* A turn by 0 costs less than the question. */
static inline int is_no_turn(num f)
{
    (void)f;
    return 0;
}

/* Two divisions, not one reciprocal: its rounding would add up in steady operation. */
KQ_INLINE rotation rotor_turn(rotor *t, num f)
{
    const num before = t->a;
    t->a += f * f;
    const num c = num_root(before / t->a);
    return (rotation){.c = c, .g = c * (f / before), .f = f};
}

/* Column s of S, b_last being 0 before: s <- c s - g b,  b <- b + f s, which is S f so far. */
KQ_INLINE void rotate(num *restrict s, num *restrict b, rotation turn, int last)
{
    KQ_UNROLL
    for (int i = 0; i < last; i++) {
        const num old = s[i];
        s[i] = turn.c * old - turn.g * b[i];
        b[i] += turn.f * old;
    }
    b[last] = turn.f * s[last];
    s[last] *= turn.c;
}

/* With b in units of it, S f is complete. */
static inline scaled rotor_unit(const rotor *t)
{
    (void)t;
    return 1;
}

/* The x of the state is to move by b times this. */
static inline scaled rotor_weight(const rotor *t, scaled e, scaled s)
{
    (void)t;
    return e / s;
}

static inline scaled weight_nis(scaled w, scaled e) { return w * e; }

static inline scaled column_entry(const num *b, const num *S, int n, int i)
{
    (void)S, (void)n;
    return b[i];
}

static inline void renormalise_if_strong(num *S, scaled r, scaled s, int n)
{
    (void)S, (void)r, (void)s, (void)n;
}

#endif
