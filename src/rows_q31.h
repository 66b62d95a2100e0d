/*
 * Rows of mantissas with one exponent: the root S and everything that is made of it.
 *
 * A ROW of a dense matrix is its `width` words and, behind them, its exponent.  A ROOT is its
 * triangle by columns and, behind it, the exponents of its n rows.  The norm of a row, in units of
 * 2^exponent, is below 2^30; orthogonal maps keep it, and that is the bound of everything here.
 */
#ifndef KALMANQ_ROWS_H
#define KALMANQ_ROWS_H

#include "scaled_q31.h"
#include "triangle.h"

#include "kalmanq/port/vectors.h"

typedef int64_t sum;

#define ROW_LEN(width) ((width) + 1)
#define ROOT_LEN(n) KQ_ROOT_LEN_Q31(n)
#define SCALED_WORDS 2

/* One in a row of coordinates: those have norm 1 at most */
static const int32_t num_one = INT32_C(1) << 29;
static const int32_t one_exponent = -29;

/* rows_float.h */
enum { rows_in_pairs = 0 };

static inline const int32_t *exponents_of(const int32_t *S, int n) { return S + KQ_TRIANGLE(n); }
/* Up to how many states a step of known size works on a copy, and up to how many it unrolls components */
enum { select_always = 1, states_in_registers = 0, states_unrolled = 1 };

/* Of words of a row of exponent *E times h, where h is 2^k */
static inline int32_t entry_exponent(scaled h, const int32_t *E) { return h.exponent + 30 + *E; }

static inline void row_set_exponent(int32_t *row, int width, int32_t exponent)
{
    row[width] = exponent;
}

/* Entry k of a row as a number of its own */
static inline scaled row_entry(const int32_t *row, int width, int k)
{
    return scaled_of(row[k], row[width]);
}

KQ_INLINE sum add_product(sum total, int32_t a, int32_t b) { return accumulate(total, a, b, 62); }

/* a'b of two rows as a number */
static inline scaled row_product(const int32_t *a, const int32_t *b, int width)
{
    return scaled_of(dot(0, a, b, width), a[width] + b[width]);
}

/* r + f'f, r > 0: mostly in one sum, with r in units of the square */
static inline scaled add_square(scaled r, const int32_t *f, int n)
{
    const sum square = squares(0, f, n); /* < 2^60.4 */
    const int32_t exponent = 2 * f[n], up = r.exponent - exponent;
    if (up < 0 || up > 29 || square == 0) return scaled_plus(r, scaled_of(square, exponent));
    return scaled_of_positive((uint64_t)sum_of(square, raise_word(r.mantissa, (int)up, 60), 62),
                              exponent);
}

static inline int32_t moved(int32_t a, int32_t down)
{
    return down >= 0 ? lower(a, down) : raise(a, (int)-down, 30);
}

/*
 * The coefficients of a combination sum_k row_k R_k of rows R_k on one scale:
 *     c_k = row_k 2^(E_k - scale),  sum |c_k| <= 2^30,
 * E_k (`stride` apart) being the exponents of the rows.  Then |sum_k c_k R_k| < 2^60: narrowed by
 * 30 it is a row of norm up to 2^30 with the exponent scale + 30, which is left in *exponent and is
 * not below what was there.
 */
KQ_APART const int32_t *align(int32_t *c, const scaled *row, const int32_t *E, int stride,
                              int count, int32_t *exponent)
{
    int32_t top = lowest_exponent;
    uint32_t total = 0; /* of the sizes in units of 2^(top + 4) */
    KQ_UNROLL
    for (int k = 0; k < count; k++) {
        if (row[k].mantissa == 0) continue;
        const int32_t own = row[k].exponent + E[k * stride];
        if (own > top) {
            total = own - top < 32 ? total >> (own - top) : 0;
            top = own;
        }
        if (top - own < 28) total += magnitude(row[k].mantissa) >> 4 >> (top - own);
    }
    total += (uint32_t)(2 * count); /* >= what the shifts and the rounding leave out */
    const int32_t fit = top + 4 + (32 - leading_zeros(total)) - 30;
    const int32_t scale = fit > *exponent - 30 ? fit : *exponent - 30;
    KQ_UNROLL
    for (int k = 0; k < count; k++) {
        const int32_t mantissa = row[k].mantissa;
        c[k] = mantissa ? moved(mantissa, scale - row[k].exponent - E[k * stride]) : 0;
    }
    *exponent = scale + 30;
    return c;
}

static inline scaled root_entry(const int32_t *S, int n, int i, int k)
{
    return (scaled){S[column(k) + i], S[KQ_TRIANGLE(n) + i]};
}

/* A sum of products of the entries of rows i and j as a number */
static inline scaled root_sum(sum total, const int32_t *S, int n, int i, int j)
{
    return scaled_of(total, S[KQ_TRIANGLE(n) + i] + S[KQ_TRIANGLE(n) + j]);
}

/* S <- c S, c > 0 normalised, so that rows become no longer in a unit of 2^31; the caller
   renormalises it.  A power of 2 moves the exponents alone. */
KQ_SHARED void root_scale(int32_t *S, scaled c, int n)
{
    const int unit = scaled_is_unit(c);
    for (int k = 0; !unit && k < KQ_TRIANGLE(n); k++) {
        S[k] = narrow(product(S[k], c.mantissa), 31, 31);
    }
    for (int i = 0; i < n; i++) S[KQ_TRIANGLE(n) + i] += c.exponent + (unit ? 30 : 31);
}

/* S <- S + c S, c >= 0, rounded at the increment; the caller renormalises it.  c < 1/2, or it is a
   factor: the norm of a row stays below 1.5 2^30. */
static inline void root_grow(int32_t *S, scaled c, int n)
{
    if (c.exponent > -32) {
        root_scale(S, scaled_plus(scaled_one, c), n);
        return;
    }
    for (int k = 0; k < KQ_TRIANGLE(n); k++) {
        const int64_t increment = lower_wide(product(S[k], c.mantissa), -c.exponent);
        S[k] = (int32_t)sum_of(S[k], increment, 31);
    }
}

/*
 * The exponent of a row of these entries as long as it may be: its norm is in 2^29 .. 2^30, but for
 * rounding.
 */
KQ_SHARED int32_t fitted_exponent(const scaled *entries, int width)
{
    int32_t top = lowest_exponent;
    for (int k = 0; k < width; k++) {
        if (entries[k].mantissa && entries[k].exponent > top) top = entries[k].exponent;
    }
    int64_t square = 0; /* of 16 words below 2^27 */
    for (int k = 0; k < width; k++) {
        if (entries[k].mantissa == 0) continue;
        const int32_t word = lower(entries[k].mantissa, top + 4 - entries[k].exponent);
        square = accumulate(square, word, word, 58);
    }
    if (square == 0) return lowest_exponent;
    return top + 4 - ((leading_zeros_wide((uint64_t)square) - 4) >> 1);
}

static inline int32_t fitted_word(scaled entry, int32_t exponent)
{
    return entry.mantissa ? lower(entry.mantissa, exponent - entry.exponent) : 0;
}

/* Numbers into one row as long as it may be */
static inline void row_fitted(int32_t *row, const scaled *entries, int width)
{
    const int32_t exponent = fitted_exponent(entries, width);
    for (int k = 0; k < width; k++) row[k] = fitted_word(entries[k], exponent);
    row[width] = exponent;
}

/* Row i of S <- its n - i entries */
static inline void root_set_row(int32_t *S, const scaled *entries, int n, int i)
{
    const int32_t exponent = fitted_exponent(entries, n - i);
    int32_t *s = S + column(i) + i;
    for (int j = i; j < n; j++) {
        *s = fitted_word(entries[j - i], exponent);
        s += j + 1;
    }
    S[KQ_TRIANGLE(n) + i] = exponent;
}

/* Row i of S, columns i .. end - 1, += rest / h, its exponent becoming that of what it is then */
static inline void mend_root_row(int32_t *S, const scaled *rest, scaled h, scaled *entries, int n,
                                 int i, int end)
{
    const int32_t exponent = S[KQ_TRIANGLE(n) + i], *s = S + column(i) + i;
    for (int j = i; j < n; j++) {
        entries[j - i] = scaled_of(*s, exponent);
        if (j < end) entries[j - i] = scaled_plus(entries[j - i], scaled_over(rest[j], h));
        s += j + 1;
    }
    root_set_row(S, entries, n, i);
}

/* A cosine or sine in Q31 */
static inline int32_t turn_word(scaled a) { return word_of(scaled_shift(a, 31)); }

/* Row i of S through the rotations of cosines c and sines t, its exponent becoming that of what is
   left of it.  Answers entry i of S f / sqrt(s), which is as long as the row was at most. */
static inline scaled turn_root_row(int32_t *S, const scaled *c, const scaled *t, scaled *entries,
                                   int n, int i)
{
    const int32_t exponent = S[KQ_TRIANGLE(n) + i], *s = S + column(i) + i;
    int32_t b = 0;
    for (int j = i; j < n; j++) {
        const scaled old = {*s, exponent}, other = {-b, exponent};
        entries[j - i] = scaled_products(c[j], old, t[j], other);
        b = narrow_products(turn_word(c[j]), b, turn_word(t[j]), *s, 31, 30);
        s += j + 1;
    }
    root_set_row(S, entries, n, i);
    return scaled_of(b, exponent);
}

/* One entry of a combination as align has prepared it */
KQ_INLINE int32_t combined(sum total) { return narrow(total, 30, 31); }

/* out_j = c'(column j) for j = n-1 .. from, the columns' entries from row `from` on; s: the last
   column's.  Downwards, because c may be in out. */
KQ_APART void row_times_triangle(int32_t *out, const int32_t *c, const int32_t *s, int from, int n)
{
    KQ_UNROLL
    for (int j = n - 1; j >= from; j--) {
        out[j - from] = combined(dot(0, c, s, j + 1 - from));
        s -= j;
    }
}

/* The same for all columns and a c that is 0 from `count` >= 1 on */
KQ_INLINE void short_row_times_triangle(int32_t *out, const int32_t *c, int count, const int32_t *s,
                                        int n)
{
    KQ_UNROLL
    for (int j = n - 1; j >= 0; j--) {
        out[j] = combined(dot(0, c, s, j < count ? j + 1 : count));
        s -= j;
    }
}

/* Two of them, into w and v */
KQ_INLINE void two_rows_times_triangle(int32_t *w, int32_t *v, const int32_t *a, const int32_t *b,
                                       const int32_t *s, int from, int n)
{
    row_times_triangle(w, a, s, from, n);
    row_times_triangle(v, b, s, from, n);
}

/* The noise block G of predict: its rows, of norm 2^30 at most, are brought to the exponent of
   their row of A S, at least one above their own: the norm of both is below 2^30.2. */
static inline int32_t noise_exponent(const int32_t *G, int n, int l)
{
    return G[KQ_TRIANGLE(n) + l] + 1;
}

static inline int32_t noise_shift(const int32_t *G, int n, int l, const int32_t *row, int width)
{
    return row[width] - G[KQ_TRIANGLE(n) + l];
}

static inline int32_t noise_word(const int32_t *g, int32_t shift) { return lower(*g, shift); }

static const int32_t num_no_noise = 0;

/* The pivot of a reflector in G, which here is in its p. */
static inline int32_t reflector_pivot(const int32_t *g)
{
    (void)g;
    return 0;
}

/*
 * One row (w, g), |w| < 2^30.2 and g <= 2^29, through the reflector (V, p) of norm 1 in Q30, with
 * q = 1 / (1 + p) in Q31: returns its entry in the pivot's column.
 *     |entry| < 2^30.2,  |entry + g| <= sqrt(1 - p^2) |w| + (1 + p) g < 1.75 2^30 < 2^31,
 *     |d| = |g + V'w / (1 + p)| < 2^31
 */
KQ_APART int32_t reflect(int32_t *restrict w, int32_t g, const int32_t *restrict V, int32_t g_pivot,
                         const int32_t *pq, int count)
{
    (void)g_pivot;
    const int32_t entry = narrow(dot(product(g, pq[0]), w, V, count), 30, 31);
    const int32_t d = narrow_product((int32_t)sum_of(entry, g, 31), pq[1], 31, 31);
    subtract_multiple(w, V, d, count);
    return entry;
}

/* The same for a row of coordinates that is num_one at `at` and 0 elsewhere, g = 0 */
KQ_INLINE int32_t reflect_unit(int32_t *restrict w, const int32_t *restrict V, const int32_t *pq,
                               int at, int count)
{
    const int32_t entry = lower(V[at], 1), d = narrow(product(entry, pq[1]), 31, 31);
    KQ_UNROLL
    for (int k = 0; k < count; k++) w[k] = -narrow(product(V[k], d), 30, 31);
    w[at] += num_one;
    return entry;
}

/* ... and for one that is 0 (and need not be set) in its first `zeros` words */
KQ_INLINE int32_t reflect_longer(int32_t *restrict w, const int32_t *restrict V, const int32_t *pq,
                                 int zeros, int count)
{
    const int32_t entry = narrow(dot(0, w + zeros, V + zeros, count - zeros), 30, 31);
    const int32_t d = narrow(product(entry, pq[1]), 31, 31);
    KQ_UNROLL
    for (int k = 0; k < zeros; k++) w[k] = -narrow(product(V[k], d), 30, 31);
    KQ_UNROLL
    for (int k = zeros; k < count; k++) {
        w[k] = (int32_t)sum_of(w[k], -narrow(product(V[k], d), 30, 31), 31);
    }
    return entry;
}

/* Two rows w and v, their entries into s and the word before it */
KQ_INLINE void reflect_two(int32_t *s, int32_t *restrict w, int32_t *restrict v, int32_t g_w,
                           int32_t g_v, const int32_t *restrict V, int32_t g_pivot,
                           const int32_t *pq, int count)
{
    s[0] = reflect(w, g_w, V, g_pivot, pq, count);
    s[-1] = reflect(v, g_v, V, g_pivot, pq, count);
}

/*
 * The reflector of a row (w, g), g >= 0: w <- V = w / s in Q30, p = g / s, q = 1 / (1 + p);
 * returns s, the row's norm.  w 2^h and g 2^h are below 2^31, and the square of s 2^h, with
 * 2h + 2 zeros on top, is normalised to [2^62, 2^64).  By rounding an entry of V or p may be 2
 * units above 1.
 */
KQ_APART int32_t close_reflector(int32_t *w, int32_t g, int32_t *pq, int count)
{
    const uint64_t square = (uint64_t)squares(product(g, g), w, count); /* < 2^60.4 */
    if (square == 0) { /* a reflector that leaves everything alone */
        pq[0] = INT32_C(1) << 30;
        pq[1] = INT32_C(1) << 30;
        return 0;
    }
    const int zeros = leading_zeros_wide(square) & ~1, h = zeros / 2 - 1;
    const uint32_t v = upper_word_raised(square, zeros), inverse = inverse_root(v);
    const int32_t half = (int32_t)(inverse >> 1); /* 2^h / s = half 2^-61 */
    scale(w, h, half, count);
    const int32_t p = narrow_product(raise(g, h, 31), half, 31, 31);
    const uint32_t one_plus = (UINT32_C(1) << 30) + (uint32_t)p; /* Q30, 1 .. 2 */
    const uint32_t share = one_plus >> 31 ? UINT32_C(1) << 31 : reciprocal(one_plus << 1);
    pq[0] = p;
    pq[1] = (int32_t)(share >> 1);
    return lower((int32_t)root_by_inverse(v, inverse), h);
}

/* The row's result takes the exponent of the row it was made in. */
static inline void root_take_exponent(int32_t *S, int n, int l, const int32_t *row, int width)
{
    S[KQ_TRIANGLE(n) + l] = row[width];
}

/* Brings every row's norm into [2^29, 2^30), the mantissas as long as they may be. */
KQ_APART void renormalise(int32_t *S, int n)
{
    int32_t *E = S + KQ_TRIANGLE(n), *row = S; /* at its diagonal entry */
    KQ_UNROLL
    for (int i = 0; i < n; i++) {
        const sum square = row_squares(row, i, n);                      /* < 2^60.4 */
        const int up = (leading_zeros_wide((uint64_t)square) - 4) >> 1; /* -1: down by one */
        if (square == 0) E[i] = lowest_exponent;
        if (E[i] > high_exponent) E[i] = high_exponent;
        if (square != 0 && up != 0 && E[i] >= low_exponent) {
            int32_t *t = row;
            KQ_UNROLL
            for (int j = i; j < n; j++) {
                *t = up > 0 ? raise(*t, up, 30) : lower(*t, 1);
                t += j + 1;
            }
            E[i] -= up;
        }
        row += i + 2;
    }
}

/* ------------------------------------------------------------------ update */

/* h'h 2^-48: what the mean's last bit of 2^-24 word in each state makes of h'P h */
KQ_SHARED scaled mean_resolution(const scaled *h, int n)
{
    scaled total = {0, 0};
    for (int k = 0; k < n; k++) total = scaled_plus(total, scaled_times(h[k], h[k]));
    return scaled_shift(total, -48);
}

/*
 * f = S'h, every entry to its own last bit: on the scale of all of h a coefficient that is small
 * beside others has but a few.  What they lack is in `rests`, n words of at most 2^26, in units of 2^-27:
 * its product with 16 words of a column is below 2^60.  Answers
 * what rounding alone makes of f'f, 16 units of each entry, or 2 last bits of the mean: a variance
 * below either says nothing.
 */
static scaled project_exactly(scaled *f, const int32_t *S, const scaled *h, scaled *rests, int n)
{
    int32_t *c = &f[0].mantissa, *low = &rests[0].mantissa, exponent = lowest_exponent;
    uint32_t size = 0;
    align(c, h, exponents_of(S, n), 1, n, &exponent);
    const int32_t scale = exponent - 30;
    for (int k = 0; k < n; k++) {
        const int32_t down = scale - h[k].exponent - S[KQ_TRIANGLE(n) + k];
        const int64_t all = raise_wide(h[k].mantissa, 27, 58); /* 2^-down is still to come */
        const int known = h[k].mantissa == 0 || down <= 0 || down >= 62;
        low[k] = known ? 0 : (int32_t)(lower_wide(all, down) - raise_wide(c[k], 27, 58));
        size += magnitude(c[k]);
    }
    for (int j = n - 1; j >= 0; j--) { /* downwards, because c is in f */
        const int32_t *s = S + column(j);
        const scaled rest = scaled_of(dot(0, low, s, j + 1), scale - 27);
        f[j] = scaled_plus(scaled_of(dot(0, c, s, j + 1), scale), rest);
    }
    const scaled length = scaled_of(size, scale);
    const scaled of_root = scaled_times(scaled_of_count(512 * n), scaled_times(length, length));
    const scaled of_mean = scaled_shift(mean_resolution(h, n), 2);
    return scaled_is_less(of_root, of_mean) ? of_mean : of_root;
}

/* No measurement is sharper than the mean's last bit, unless s is not far above that itself: a
   noise-free one leaves a variance below the floor. */
static inline scaled least_noise(scaled r, scaled s, const scaled *h, int n)
{
    const scaled sharp = scaled_shift(s, -30);
    if (!scaled_is_less(r, sharp)) return r;
    const scaled last_bit = mean_resolution(h, n);
    const scaled least = scaled_is_less(sharp, last_bit) ? sharp : last_bit;
    return scaled_is_less(r, least) ? least : r;
}

/* Is there nothing that the careful update is for: rounding, sharpness?  r >= 2^-8 s, and s above
   the variance that counts as 0 */
static inline int is_ordinary(scaled r, scaled s, scaled e)
{
    (void)e;
    return r.mantissa > 0 && r.exponent > s.exponent - 8 && s.exponent > num_zero_variance.exponent;
}

/* May a sensor without the careful path take it?  It may where r >= 2^-16 s, and where r < 2^-17 s it
   may not: up to 9 more of 31 bits are lost than to what is ordinary. */
static inline int is_blunt(scaled r, scaled s, scaled e)
{
    (void)e;
    return r.mantissa > 0 && r.exponent >= s.exponent - 16 && s.exponent > num_zero_variance.exponent;
}

static inline int noise_is_ordinary(scaled r) { return r.mantissa > 0; }

static inline int is_surely_ordinary(scaled r, scaled s, scaled e) { return is_ordinary(r, s, e); }

/*
 * The state of Carlson's sums a_j = r + f_0^2 + ... + f_j^2.  All in units of 2^(2 exponent),
 * where the last of them, the innovation variance, is in [2^59, 2^61); f moves by `down`.
 * root = sqrt(a) 2^(zeros/2 - 1), inverse = 2^(63 - zeros/2) / sqrt(a).
 */
typedef struct {
    uint64_t a;
    uint32_t root, inverse;
    int zeros;
    int32_t exponent, down;
} rotor;

/* The cosine and the sine of a rotation in Q31 */
typedef struct {
    int32_t c, t;
} rotation;

static inline void rotor_take_root(rotor *t)
{
    t->zeros = leading_zeros_wide(t->a) & ~1;
    const uint32_t v = upper_word_raised(t->a, t->zeros);
    t->inverse = inverse_root(v);
    t->root = root_by_inverse(v, t->inverse);
}

/* s = r + f'f, normalised */
KQ_INLINE rotor rotor_begin(scaled r, scaled s, const int32_t *f, int n)
{
    rotor t;
    t.exponent = (s.exponent - 29) >> 1;
    t.down = t.exponent - f[n];
    const int32_t up = r.exponent - 2 * t.exponent; /* <= 31, since r <= s */
    t.a = (uint64_t)(up >= 0 ? raise_word(r.mantissa, (int)up, 62) : lower(r.mantissa, -up));
    if (t.a == 0) t.a = 1;
    rotor_take_root(&t);
    return t;
}

static inline int is_no_turn(int32_t f) { return f == 0; }

/* (p + 2^30) 2^-31 2^-down, rounded down, at most 1 in Q31 */
static inline int32_t cosine_of(uint64_t p, int down)
{
    p += UINT32_C(1) << 30;
    const uint32_t high = upper_word(p);
    const uint32_t c = down ? high >> (down - 1) : high << 1 | (uint32_t)p >> 31;
    if (down ? c > INT32_MAX : high >> 30) return INT32_MAX;
    return (int32_t)c;
}

/* p 2^-30, rounded, held within -1 and 1 in Q31, which the upper word alone tells of most */
static inline int32_t sine_of(int64_t p)
{
    const uint32_t most = (UINT32_C(1) << 29) - 2;
    if (upper_word((uint64_t)p) + most < 2 * most) return narrow(p, 30, 31);
    const int64_t sine = (p + (INT32_C(1) << 29)) >> 30;
    return sine > INT32_MAX ? INT32_MAX : sine < -INT32_MAX ? -INT32_MAX : (int32_t)sine;
}

/* c = sqrt(a_before / a),  t = f / sqrt(a); |f| < sqrt(a), which is below 2^(32 - zeros/2) */
static inline rotation rotor_turn(rotor *t, int32_t f)
{
    const uint32_t root = t->root;
    const int zeros = t->zeros;
    rotation turn;
    f = t->down >= 0 ? lower(f, t->down) : raise(f, (int)-t->down, 31);
    t->a += (uint64_t)product(f, f); /* <= s < 2^61, and its rounding */
    rotor_take_root(t);
    turn.c = cosine_of(product_unsigned(root, t->inverse), (zeros - t->zeros) >> 1);
    const int32_t tall = raise(f, t->zeros / 2 - 1, 31), half = (int32_t)(t->inverse >> 1);
    turn.t = sine_of(product(tall, half));
    return turn;
}

/*
 * Column s of S, b_last being 0 before: s <- c s - t b,  b <- c b + t s: a row of S and its b are
 * together as long as the row was, so no row's norm grows.  At the end b = S f / sqrt(a).
 */
KQ_INLINE void rotate(int32_t *restrict s, int32_t *restrict b, rotation turn, int last)
{
    rotate_words(s, b, turn.c, turn.t, last);
}

/* sqrt(a): with b in units of it, S f is complete. */
static inline scaled rotor_unit(const rotor *t)
{
    return scaled_of(t->root, t->exponent + 1 - t->zeros / 2);
}

/* The mean is to move by b times e / sqrt(a). */
static inline scaled rotor_weight(const rotor *t, scaled e, scaled s)
{
    (void)s;
    const int32_t half = (int32_t)(t->inverse >> 1);
    return scaled_of_product(e.mantissa, half, e.exponent + t->zeros / 2 - 62 - t->exponent);
}

static inline scaled weight_nis(scaled w, scaled e)
{
    (void)e;
    return scaled_times(w, w);
}

/* b_i in units of word i: not normalised */
static inline scaled column_entry(const int32_t *b, const int32_t *S, int n, int i)
{
    return (scaled){b[i], S[KQ_TRIANGLE(n) + i]};
}

/* Rows are at most sqrt(r / s) as long as before: where that may be below 1/2 they are renormalised
   at once, not only at the end of the update. */
static inline void renormalise_if_strong(int32_t *S, scaled r, scaled s, int n)
{
    if (r.exponent < s.exponent) renormalise(S, n);
}

#endif
