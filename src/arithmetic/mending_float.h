/* Rows and what a low-noise measurement does to them: the twin of mending_q31.h */
#ifndef KQ_SRC_ARITHMETIC_MENDING_FLOAT_H
#define KQ_SRC_ARITHMETIC_MENDING_FLOAT_H

#include "rows_float.h"

/* Row i of S through the rotations of cosines c and sines t.  Answers entry i of S f / sqrt(s); reach: the sizes of that and
   of what is left, the row's sigma before but for a factor of up to 5. */
KQ_COLD static inline scaled turn_root_row(num *S, const scaled *c, const scaled *t, scaled *scratch, int n,
                                   int i, scaled *reach)
{
    num *s = S + column(i) + i, b = 0, total = 0;
    (void)scratch;
    for (int j = i; j < n; j++) {
        const num old = *s, turned = c[j] * old - t[j] * b;
        *s = turned;
        total += num_magnitude(turned);
        b = c[j] * b + t[j] * old;
        s += j + 1;
    }
    *reach = total + num_magnitude(b);
    return b;
}

static inline void row_clear(num *S, int n, int i)
{
    for (int j = i; j < n; j++) S[column(j) + i] = 0;
}

/* A sum of numbers that cancel is not rounded here. */
static inline int mending_rounds(scaled r, scaled sigma)
{
    (void)r, (void)sigma;
    return 0;
}

/* Row i of S, columns i .. end - 1, += rest / h */
KQ_COLD static inline void mend_root_row(num *S, const scaled *rest, scaled h, scaled *scratch, int n, int i,
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
 * variance below it says nothing.  (64 eps)^2: the rounding of f, and the rounding
 * of S in earlier updates, whose rows were longer.
 */
KQ_COLD static num project_exactly(num *f, const num *S, const num *h, num *rests, int n)
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

/* That alone */
KQ_COLD static num floor_of_square(const num *S, const num *h, int n)
{
    num f[KQ_SIZE_MAX];
    return project_exactly(f, S, h, f, n);
}

#endif
