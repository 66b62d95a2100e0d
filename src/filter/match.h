/*
 * The update of the root by a measurement that may be far sharper than what was known: the rotations
 * of Carlson's form in numbers of any size, row by row, so that a row that becomes short gets its
 * new exponent before it is rounded.  One pass, however sharp it is.
 */
#ifndef KQ_SRC_FILTER_MATCH_H
#define KQ_SRC_FILTER_MATCH_H

#include "../arithmetic/arithmetic.h"

/* Scratch, n numbers each */
typedef struct {
    scaled *f;       /* S'h; then the sines t_j = f_j / sqrt(a_j) */
    scaled *b;       /* S f */
    scaled *c;       /* the cosines c_j = sqrt(a_{j-1} / a_j); then |h_j| sigma_j, sigma_j as before the update */
    scaled *left;    /* what must be left of f */
    scaled *entries; /* a row of S */
    scaled *floor;   /* all but f, before they are needed */
} low_noise_work;

/* FLOOR_PARTS: what project_with_floor and rounding_before (low_noise.h) need */
enum { FLOOR_PARTS = 4, LOW_NOISE_PARTS = 1 + FLOOR_PARTS };

static low_noise_work low_noise_work_at(scaled *memory, int n)
{
    return (low_noise_work){.f = memory,
                        .b = memory + n,
                        .c = memory + 2 * n,
                        .left = memory + 3 * n,
                        .entries = memory + 4 * n,
                        .floor = memory + n};
}

KQ_COLD static scaled square_of(const scaled *f, int n)
{
    scaled total = scaled_times(f[0], f[0]);
    for (int j = 1; j < n; j++) total = scaled_add_square(total, f[j]);
    return total;
}

/*
 * f becomes the rotations of a measurement of noise r, and what S'h must be after them is
 *     f_j r / sqrt(a_{j-1} a_j),
 * in which nothing cancels.  Answers sqrt(s).
 */
KQ_COLD static scaled turns_of(const low_noise_work *w, scaled r, int n)
{
    scaled variance = r, sigma = scaled_root(r);
    for (int j = 0; j < n; j++) {
        const scaled entry = w->f[j];
        variance = scaled_add_square(variance, entry);
        const scaled next = scaled_root(variance);
        w->c[j] = scaled_over(sigma, next);
        w->f[j] = scaled_over(entry, next);
        w->left[j] = scaled_times(w->f[j], scaled_over(r, sigma));
        sigma = next;
    }
    return sigma;
}

/* Row i is mended from column i up to the first of a state that has more part than i. */
KQ_COLD static int mended_end(const scaled *part, int i, int n)
{
    int end = i + 1;
    while (end < n && !scaled_is_less(part[i], part[end])) end++;
    return end;
}

/* The rows of h by `rest`, or what they lack is forgotten. */
KQ_COLD static void mend_rows(num *S, const scaled *h, const scaled *rest, const low_noise_work *w, int n)
{
    const scaled *part = w->c;
    for (int i = 0, end; i < n; i = end) {
        end = mended_end(part, i, n);
        if (!scaled_is_zero(h[i])) mend_root_row(S, rest, h[i], w->entries, n, i, end);
    }
}

/*
 * After a sharp update the row of a measured state is the difference of numbers that agree to
 * sqrt(r / s), and rounding is as large as they are.  What S'h must be is known without it: what each
 * column lacks goes into the entry of the state up to it that h sees most of, by its sigma before the update: there it
 * is no more than that sigma's rounding.  That entry is forgotten before where its last bit is beyond what will be left
 * of it.
 */
KQ_COLD static void match_root(num *S, const scaled *h, const low_noise_work *w, int forgets, int n)
{
    scaled *rest = w->f; /* the rotations are done */
    if (forgets) mend_rows(S, h, 0, w, n);
    project_exactly(rest, S, h, w->entries, n);
    for (int i = 0; i < n; i++) rest[i] = scaled_minus(w->left[i], rest[i]);
    mend_rows(S, h, rest, w, n);
}

/*
 * A component without noise may tell all of a state that it does not measure: what is left of that
 * one's row is what rounding makes of the row that it was, in whatever direction.  To keep it would be
 * to believe that the state knows something of the others, which a later noise-free component could ask.
 */
KQ_COLD static void drop_rounding(num *S, scaled lost, int n, int i)
{
    const scaled most = scaled_times(num_row_rounding, scaled_magnitude(lost));
    for (int j = i; j < n; j++) {
        if (scaled_is_less(most, scaled_magnitude(root_number(S, n, i, j)))) return;
    }
    row_clear(S, n, i);
}

/* By h with noise r, f being S'h; exact: the component has none */
KQ_COLD KQ_NOINLINE static void rotate_root_apart(num *S, const scaled *h, scaled r, int exact,
                                                  const low_noise_work *w, int sharp, int n)
{
    const scaled sigma = turns_of(w, r, n);
    for (int i = 0; i < n; i++) {
        scaled reach;
        const scaled lost = turn_root_row(S, w->c, w->f, w->entries, n, i, &reach);
        w->b[i] = scaled_times(sigma, lost);
        if (exact) drop_rounding(S, lost, n, i);
        w->c[i] = scaled_times(scaled_magnitude(h[i]), reach); /* no later row is turned by it */
    }
    if (sharp) match_root(S, h, w, mending_rounds(r, sigma), n);
}

#endif
