/*
 * Consistency over a window of updates: a ring of W + 1 entries, the last of them for the update
 * that is on its way.  An entry is its NIS, the number of scalar measurements taken, and a
 * normalised innovation for every component.
 */
#ifndef KQ_SRC_STATISTICS_CONSISTENCY_H
#define KQ_SRC_STATISTICS_CONSISTENCY_H

#include "twins.h"

typedef T(kq_consistency) consistency;

static int entry_words(const consistency *c) { return SCORE_WORDS + 1 + c->components; }

static num *entry_at(const consistency *c, int slot)
{
    return c->memory + (size_t)slot * (size_t)entry_words(c);
}

/* Entry k of those in the window, from the oldest */
static const num *entry_of(const consistency *c, int k)
{
    const int slot = c->next - c->count + k; /* -W .. W */
    return entry_at(c, slot < 0 ? slot + c->window + 1 : slot);
}

kq_status T(kq_consistency_assign)(consistency *c, int m, size_t window, num *memory, size_t length)
{
    if (!c || !memory) return KQ_ERR_NULL;
    if (!size_is_valid(m) || window < 1 || window > KQ_WINDOW_MAX) return KQ_ERR_SIZE;
    if (length < CONSISTENCY_LEN(m, window)) return KQ_ERR_MEMORY;
    *c = (consistency){.components = (uint8_t)m, .window = (int16_t)window, .memory = memory};
    return KQ_OK;
}

static kq_status consistency_check(const consistency *c)
{
    if (!c) return KQ_ERR_NULL;
    return c->memory && c->window ? KQ_OK : KQ_ERR_NOT_READY;
}

kq_status T(kq_consistency_clear)(consistency *c)
{
    const kq_status status = consistency_check(c);
    if (status) return status;
    c->watched = 0;
    c->count = 0;
    c->next = 0;
    return KQ_OK;
}

/* e_c / sqrt(S_cc) of z_c, as a word; none where S_cc is as good as 0 */
static num normalised_innovation(const filter *f, const sensor *s, num z, int c)
{
    num F[ROW_LEN(KQ_SIZE_MAX)];
    const int n = f->states;
    const scaled *h = s->measurement + c * n;
    project(F, filter_root(f), h, n);
    const scaled variance = scaled_plus(row_product(F, F, n), noise_entry(s, c, c));
    if (!scaled_is_less(num_zero_variance, variance)) return num_nan();
    return unit_word(scaled_over(mean_residual(z, h, f->memory, n, 0, n), scaled_root(variance)));
}

kq_status T(kq_consistency_watch)(consistency *c, const filter *f, const sensor *s, const num *z,
                                  uint32_t present)
{
    kq_status status = consistency_check(c);
    if (status) return status;
    status = update_check(f, s, z, present);
    if (status) return status;
    if (s->components != c->components) return KQ_ERR_MISMATCH;
    num *unit = entry_at(c, c->next) + SCORE_WORDS + 1;
    for (int k = 0; k < c->components; k++) {
        unit[k] = present >> k & 1 ? normalised_innovation(f, s, z[k], k) : num_nan();
    }
    c->watched = 1;
    return KQ_OK;
}

kq_status T(kq_consistency_record)(consistency *c, const filter *f)
{
    kq_status status = consistency_check(c);
    if (status) return status;
    status = filter_check(f);
    if (status) return status;
    if (!c->watched || is_resting(f)) return KQ_ERR_NOT_READY;
    c->watched = 0;
    if (f->last.count == 0) return KQ_OK;
    num *entry = entry_at(c, c->next);
    store_score(entry, likelihood_nis(&f->last));
    entry[SCORE_WORDS] = (num)f->last.count;
    c->next = (int16_t)(c->next == c->window ? 0 : c->next + 1);
    if (c->count < c->window) c->count++;
    return KQ_OK;
}

/* ------------------------------------------------------------------ what is read */

static kq_status quantile_check(score q)
{
    if (!score_is_finite(q)) return KQ_ERR_NOT_FINITE;
    return q < 0 ? KQ_ERR_RANGE : KQ_OK;
}

static scaled cube(scaled a) { return scaled_times(scaled_times(a, a), a); }

/* Quantiles of chi-square with d degrees of freedom, over d (Wilson and Hilferty): its cube root is
   nearly N(1 - a, a), a = 2 / (9 d). */
static void chi_square_bounds(int32_t degrees, score q, score *low, score *high)
{
    const scaled a =
        scaled_over(scaled_of_count(2), scaled_times(scaled_of_count(9), scaled_of_count(degrees)));
    const scaled middle = scaled_minus(scaled_one, a);
    const scaled reach = scaled_times(score_number(q), scaled_root(a));
    *low = scaled_is_less(reach, middle) ? score_of(cube(scaled_minus(middle, reach))) : 0;
    *high = score_of(cube(scaled_plus(middle, reach)));
}

kq_status T(kq_consistency_nis)(const consistency *c, score q, score *nis, score *low, score *high)
{
    kq_status status = consistency_check(c);
    if (status) return status;
    if (!nis || !low || !high) return KQ_ERR_NULL;
    status = quantile_check(q);
    if (status) return status;
    if (c->count == 0) return KQ_ERR_NOT_READY;
    compensated total;
    int32_t degrees = 0;
    compensated_clear(&total);
    for (int k = 0; k < c->count; k++) {
        const num *entry = entry_of(c, k);
        compensated_add(&total, load_score(entry));
        degrees += (int32_t)entry[SCORE_WORDS];
    }
    *nis = score_of(scaled_over(score_number(compensated_score(&total)), scaled_of_count(degrees)));
    chi_square_bounds(degrees, q, low, high);
    return KQ_OK;
}

/* Sums over the normalised innovations of one component */
typedef struct {
    compensated total, square, along; /* of nu, nu^2 and nu_t nu_t-1 */
    int32_t count, pairs;       /* of nu, and of those one after the other */
} unit_sums;

static void sum_units(unit_sums *sums, const consistency *c, int component)
{
    num before = num_nan();
    compensated_clear(&sums->total);
    compensated_clear(&sums->square);
    compensated_clear(&sums->along);
    sums->count = 0;
    sums->pairs = 0;
    for (int k = 0; k < c->count; k++) {
        const num unit = entry_of(c, k)[SCORE_WORDS + 1 + component];
        if (!unit_is_none(unit)) {
            sums->count++;
            compensated_add(&sums->total, unit_score(unit));
            compensated_add(&sums->square, unit_product(unit, unit));
            if (!unit_is_none(before)) {
                sums->pairs++;
                compensated_add(&sums->along, unit_product(unit, before));
            }
        }
        before = unit;
    }
}

/* along over square, which is not below it but for rounding: all of that where the innovations are next to nothing */
static scaled correlation_of(scaled along, scaled square)
{
    if (scaled_is_zero(square)) return scaled_zero();
    if (scaled_is_less(scaled_magnitude(along), square)) return scaled_over(along, square);
    return scaled_is_negative(along) ? scaled_negative(scaled_one) : scaled_one;
}

/* The mean of `count` numbers N(0, 1) has the variance 1 / count; the sum of `pairs` products of
   two of them, over that of their squares, pairs / count^2. */
kq_status T(kq_consistency_innovation)(const consistency *c, int component, score q, score *mean,
                                       score *mean_bound, score *correlation,
                                       score *correlation_bound)
{
    unit_sums sums;
    kq_status status = consistency_check(c);
    if (status) return status;
    if (!mean || !mean_bound || !correlation || !correlation_bound) return KQ_ERR_NULL;
    if (component < 0 || component >= c->components) return KQ_ERR_SIZE;
    status = quantile_check(q);
    if (status) return status;
    sum_units(&sums, c, component);
    if (sums.count == 0) return KQ_ERR_NOT_READY;
    const scaled count = scaled_of_count(sums.count), reach = score_number(q);
    const scaled spread = scaled_root(scaled_of_count(sums.pairs));
    const scaled square = score_number(compensated_score(&sums.square));
    const scaled along = score_number(compensated_score(&sums.along));
    *mean = score_of(scaled_over(score_number(compensated_score(&sums.total)), count));
    *mean_bound = score_of(scaled_over(reach, scaled_root(count)));
    *correlation = score_of(correlation_of(along, square));
    *correlation_bound = score_of(scaled_over(scaled_times(reach, spread), count));
    return KQ_OK;
}

size_t T(kq_consistency_count)(const consistency *c) { return c ? (size_t)c->count : 0; }

#endif
