/* The diffuse start: what rounding has left in D (unknown.h). */
#ifndef KQ_SRC_DIFFUSE_ROUNDING_H
#define KQ_SRC_DIFFUSE_ROUNDING_H

#include "../model/model.h"
#include "entries.h"

static num *rounding_row(num *rounding, int n, int i) { return rounding + i * n * SCALED_WORDS; }

/* The standard error of D_i, any of its entries */
static scaled row_error(num *rounding, int n, int i)
{
    return scaled_root(entry_get(rounding_row(rounding, n, i), i));
}

/* w = F F'h; answers the standard error of h'F, no less than what F F' itself rounds it by */
static scaled rounding_seen(scaled *w, num *rounding, const scaled *h, int n)
{
    terms all = terms_begin();
    for (int i = 0; i < n; i++) {
        terms t = terms_begin();
        for (int j = 0; j < n; j++) terms_add(&t, h[j], entry_get(rounding_row(rounding, n, i), j));
        w[i] = t.value;
        terms_add(&all, h[i], t.value);
        all.size = scaled_plus(all.size, scaled_times(scaled_magnitude(h[i]), t.size));
    }
    const scaled least = scaled_times(all.size, scaled_rounding());
    const int is_rounding = scaled_is_negative(all.value) || scaled_is_less(all.value, least);
    return scaled_root(is_rounding ? least : all.value);
}

/* The error of row i grows. */
static void rounding_add(num *rounding, int n, int i, scaled variance)
{
    num *row = rounding_row(rounding, n, i);
    entry_set(row, i, scaled_plus(entry_get(row, i), variance));
}

/* Row <- row - c pivot, so that entry k is 0 */
static void eliminate(scaled *row, const scaled *pivot, int k, int n)
{
    const scaled zero = scaled_zero();
    const scaled factor = scaled_negative(scaled_over(row[k], pivot[k]));
    for (int j = k + 1; j < n; j++) {
        terms t = terms_begin();
        terms_add(&t, scaled_one, row[j]);
        terms_add(&t, factor, pivot[j]);
        row[j] = is_significant(t.value, t.size) ? t.value : zero;
    }
    row[k] = zero;
}

/* |det A|, by elimination, an entry being 0 where it is rounding of what it is the difference of */
KQ_NOINLINE static scaled volume_of(const process *p)
{
    scaled a[KQ_SIZE_MAX][KQ_SIZE_MAX], volume = scaled_one;
    const int n = p->states;
    for (int k = 0; k < n * n; k++) a[k / n][k % n] = p->transition[k];
    for (int k = 0; k < n; k++) {
        int pivot = k;
        for (int i = k; i < n; i++) {
            const scaled most = scaled_magnitude(a[pivot][k]);
            if (scaled_is_less(most, scaled_magnitude(a[i][k]))) pivot = i;
        }
        volume = scaled_saturated(scaled_times(volume, scaled_magnitude(a[pivot][k])));
        if (scaled_is_zero(volume)) return volume;
        for (int i = k; i < n; i++) {
            if (i != pivot) eliminate(a[i], a[pivot], k, n);
        }
        for (int j = k; j < n; j++) a[pivot][j] = a[k][j];
    }
    return volume;
}

#endif
