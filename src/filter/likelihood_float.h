/*
 * In floating point: NIS and det S as sums and products over scalar measurements; the logarithm is
 * taken when it is asked for.
 */
#ifndef KQ_SRC_FILTER_LIKELIHOOD_FLOAT_H
#define KQ_SRC_FILTER_LIKELIHOOD_FLOAT_H

#include "../arithmetic/arithmetic.h"

typedef T(kq_likelihood) likelihood;
typedef T(kq_likelihood_run) likelihood_run;

/* The exponent of an update's determinant: 16 variances of less than 2^1100, and a start's */
static const int32_t likelihood_reach = INT32_C(1) << 16;

/* ------------------------------------------------------------------ an update */

static void likelihood_clear(likelihood *p)
{
    p->nis = 0;
    p->exponent = 0;
    p->determinant = 1;
    p->count = 0;
}

/* Is an innovation variance infinite, or not a number? */
KQ_INLINE int variance_overflows(num s) { return !(s <= num_max); }

/* Can the arithmetic not hold an innovation e, its variance s or e^2 / s? */
KQ_INLINE int likelihood_overflows(num e, num s)
{
    return variance_overflows(s) || !(e * (e / s) <= num_most_nis);
}

/* The determinant is kept within 1/2 .. 1, so that the product with any s is within the numbers. */
KQ_KERNEL void likelihood_multiply(likelihood *p, num s)
{
    p->determinant = num_split(p->determinant * s, &p->exponent);
}

/* One scalar measurement of innovation variance s, of the few of an update */
KQ_KERNEL void likelihood_add(likelihood *p, num nis, num s)
{
    p->nis += nis;
    likelihood_multiply(p, s);
    p->count++;
}

KQ_KERNEL void likelihood_join(likelihood *p, const likelihood *other)
{
    p->nis += other->nis;
    likelihood_multiply(p, other->determinant);
    p->exponent += other->exponent;
    p->count += other->count;
}

/* log a for a > 0: a = m 2^e with m in [1/sqrt 2, sqrt 2), log m = 2 artanh((m - 1)/(m + 1)),
   |t| < 0.172: the first term left out is below t^25 / 25 < 4e-21 */
static num log_of(num a, int32_t exponent)
{
    while (a >= 2 * num_root_half) {
        a *= num_half;
        exponent++;
    }
    while (a < num_root_half) {
        a *= 2;
        exponent--;
    }
    const num t = (a - 1) / (a + 1);
    num sum = 0;
    for (int k = 23; k >= 1; k -= 2) sum = sum * t * t + 1 / (num)k;
    return 2 * t * sum + (num)exponent * num_log_2;
}

static num likelihood_nis(const likelihood *p) { return p->nis; }

static num likelihood_log(const likelihood *p)
{
    if (p->count == 0) return 0;
    const num log_determinant = log_of(p->determinant, p->exponent);
    return -num_half * (((num)p->count * num_log_2_pi + log_determinant) + p->nis);
}

/* Can a call have left it? */
KQ_COLD static int likelihood_is_possible(const likelihood *p)
{
    return p->nis >= 0 && p->determinant >= num_half && p->determinant <= 1 && p->count >= 0 &&
           p->count <= KQ_SIZE_MAX && p->exponent <= likelihood_reach && p->exponent >= -likelihood_reach;
}

/* ------------------------------------------------------------------ a run */

static void likelihood_run_clear(likelihood_run *p)
{
    compensated_clear(&p->sum);
    p->exponent = 0;
    p->determinant = 1;
    p->count = 0;
}

/* Scalar measurements and powers of 2 that are taken into the sum at once, so that their counts do
   not wrap: so many measurements change the exponent by less than 2200 each, 2^27 together. */
static const int32_t likelihood_part = INT32_C(1) << 15;
static const int32_t likelihood_powers = INT32_C(1) << 28;

KQ_COLD KQ_NOINLINE static void likelihood_run_fold(likelihood_run *p)
{
    num part = (num)likelihood_part * num_log_2_pi;
    p->count -= likelihood_part;
    if (p->exponent > likelihood_powers) {
        p->exponent -= likelihood_powers;
        part += (num)likelihood_powers * num_log_2;
    } else if (p->exponent < -likelihood_powers) {
        p->exponent += likelihood_powers;
        part -= (num)likelihood_powers * num_log_2;
    }
    compensated_add_next(&p->sum, part);
    compensated_carry(&p->sum);
}

KQ_KERNEL void likelihood_run_add(likelihood_run *p, const likelihood *last)
{
    compensated_add_next(&p->sum, last->nis);
    p->determinant = num_split(p->determinant * last->determinant, &p->exponent);
    p->exponent += last->exponent;
    p->count += last->count;
    if (p->count >= likelihood_part) likelihood_run_fold(p);
}

KQ_COLD static int likelihood_run_is_possible(const likelihood_run *p)
{
    const int32_t most = likelihood_powers + likelihood_powers / 2;
    return p->determinant >= num_half && p->determinant <= 1 && p->count >= 0 && p->count < likelihood_part &&
           p->exponent <= most && p->exponent >= -most;
}

static num likelihood_run_log(const likelihood_run *p)
{
    compensated sum = p->sum;
    compensated_add(&sum, (num)p->count * num_log_2_pi);
    compensated_add(&sum, (num)p->exponent * num_log_2);
    compensated_add(&sum, log_of(p->determinant, 0));
    return 0 - num_half * compensated_value(&sum);
}

#endif
