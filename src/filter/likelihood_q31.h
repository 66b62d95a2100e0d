/*
 * In fixed point: NIS as Q39.24 and det S as a number of any size; the logarithm is taken when
 * it is asked for.
 */
#ifndef KQ_SRC_FILTER_LIKELIHOOD_Q31_H
#define KQ_SRC_FILTER_LIKELIHOOD_Q31_H

#include "../arithmetic/q31.h"
#include "../arithmetic/arithmetic.h"

typedef T(kq_likelihood) likelihood;
typedef T(kq_likelihood_run) likelihood_run;

/* The exponent of an update's determinant: 16 variances of less than 2^18800, twice at a start */
static const int32_t likelihood_reach = INT32_C(1) << 20;

static void likelihood_clear(likelihood *p)
{
    p->nis = 0;
    p->determinant = (scaled)SCALED_POWER(0);
    p->count = 0;
}

KQ_INLINE int variance_overflows(scaled s)
{
    (void)s;
    return 0;
}

/* Nothing overflows: an innovation is below 2^63, a variance above 2^-200. */
KQ_INLINE int likelihood_overflows(scaled e, scaled s)
{
    (void)e, (void)s;
    return 0;
}

static void likelihood_multiply(likelihood *p, scaled s)
{
    p->determinant = scaled_times(p->determinant, s);
}

/* One scalar measurement: NIS a 2^p, innovation variance b 2^q */
KQ_OF_WORDS void likelihood_add_words(int32_t a, int32_t p, int32_t b, int32_t q, likelihood *to)
{
    const scaled nis = {a, p}, s = {b, q};
    const score sum = sum_of(to->nis, score_of(nis), 62); /* >= 0 */
    to->nis = sum < score_max ? sum : score_max;
    if (to->count++ == 0) to->determinant = s;
    else likelihood_multiply(to, s);
}

KQ_OF_NUMBERS void likelihood_add(likelihood *p, scaled nis, scaled s)
{
    likelihood_add_words(nis.mantissa, nis.exponent, s.mantissa, s.exponent, p);
}

KQ_KERNEL void likelihood_join(likelihood *p, const likelihood *other)
{
    p->nis = score_saturated(sum_of(p->nis, other->nis, 62));
    likelihood_multiply(p, other->determinant);
    p->count += other->count;
}

static score likelihood_nis(const likelihood *p) { return p->nis; }

/* log2 m of m in [1, 2), given and returned in Q30: each squaring gives one bit more */
static int32_t log2_of(uint32_t mantissa)
{
    uint32_t m = mantissa << 1; /* Q31 */
    int32_t bits = 0;
    for (int k = 0; k < 30; k++) {
        const uint64_t square = (uint64_t)m * m; /* Q62, in [1, 4) */
        const int above = (int)(square >> 63);
        m = (uint32_t)(square >> (31 + above));
        bits = bits << 1 | above;
    }
    return bits;
}

/* count times a constant given in Q39, |count| <= 2^32, in Q24 */
static int64_t times_constant(int64_t count, int64_t constant)
{
    return count * (constant >> 15) + ((count * (constant & 0x7fff)) >> 15);
}

static const int64_t log_2 = INT64_C(381061692393), log_2_pi = INT64_C(1010383602470); /* Q39 */

/* a > 0; in Q24 */
static int64_t log_of_number(scaled a)
{
    const int32_t fraction = log2_of((uint32_t)a.mantissa);
    return times_constant(a.exponent + 30, log_2) +
           ((fraction * (log_2 >> 9)) >> 36); /* Q30 Q30 = Q60 */
}

static int64_t log_of_units(int32_t count) { return times_constant(count, log_2_pi); }

static score likelihood_log(const likelihood *p)
{
    if (p->count == 0) return 0;
    return -((log_of_units(p->count) + log_of_number(p->determinant) + p->nis) / 2);
}

/* Can a call have left it? */
KQ_COLD static int likelihood_is_possible(const likelihood *p)
{
    const int32_t exponent = p->determinant.exponent;
    return p->nis >= 0 && p->nis <= score_max && p->determinant.mantissa >= INT32_C(1) << 30 && p->count >= 0 &&
           p->count <= KQ_SIZE_MAX && exponent <= likelihood_reach && exponent >= -likelihood_reach;
}

/* ------------------------------------------------------------------ a run */

static void likelihood_run_clear(likelihood_run *p)
{
    p->sum = 0;
    p->carried = 0;
    p->count = 0;
    p->determinant = scaled_one;
}

/* Measurements that are taken into the sum at once, and powers of 2, in multiples of `likelihood_powers`: what is
   left of the exponent is below that.  Each measurement adds less than `likelihood_variance` to it. */
static const int32_t likelihood_part = INT32_C(1) << 15;
static const int32_t likelihood_powers = INT32_C(1) << 20;
static const int32_t likelihood_variance = 18800;

/* 2^15 times log 2 pi, and so many times 2^20 log 2, in Q24 */
static int64_t likelihood_run_part(likelihood_run *p)
{
    const int32_t times = p->determinant.exponent / likelihood_powers; /* below 2^11 */
    p->count -= likelihood_part;
    p->determinant.exponent -= times * likelihood_powers;
    const int64_t step = log_2 << 5; /* in two parts: small cores would link a product of 64 bits */
    const int64_t high = shift_up_wide(product(times, (int32_t)(step >> 31)), 31, 55);
    return log_2_pi + high + product(times, (int32_t)(step & INT32_MAX));
}

/* What is full is emptied.  2^68 is as far as `carried` reaches: a NIS of 2^23 at every one of 2^45
   updates, 10 kHz for 100 years.  At its end it stays there.  Downwards it takes 2^53 scalar
   measurements or more. */
KQ_COLD KQ_NOINLINE static void likelihood_run_fold(likelihood_run *p)
{
    if (p->count >= likelihood_part) p->sum = sum_of(p->sum, likelihood_run_part(p), 62);
    if (p->sum >= score_max) {
        p->sum -= score_max;
        if (p->carried < INT32_MAX) p->carried++;
    } else if (p->sum <= -score_max) {
        p->sum += score_max;
        p->carried--;
    }
}

/* A NIS is 2^61 at most. */
KQ_KERNEL void likelihood_run_add(likelihood_run *p, const likelihood *last)
{
    p->sum = sum_of(p->sum, last->nis, 62);
    p->determinant = scaled_times(p->determinant, last->determinant);
    p->count += last->count;
    if (p->sum >= score_max || p->count >= likelihood_part) likelihood_run_fold(p);
}

/* Can a call have left it?  Its exponent is what the last part has left of it, less than `likelihood_powers`,
   what a start has added without a measurement, `likelihood_reach`, and what was measured since. */
KQ_COLD static int likelihood_run_is_possible(const likelihood_run *p)
{
    const int32_t exponent = p->determinant.exponent;
    const int64_t most = likelihood_powers + likelihood_reach + (int64_t)p->count * likelihood_variance;
    return p->sum <= score_max && p->sum >= -score_max && p->determinant.mantissa >= INT32_C(1) << 30 &&
           p->count >= 0 && p->count < likelihood_part && exponent <= most && exponent >= -most;
}

/* With everything in the sum */
static likelihood_run likelihood_run_whole(const likelihood_run *p)
{
    likelihood_run whole = *p;
    const int64_t logs = log_of_units(p->count) + log_of_number(p->determinant);
    whole.sum = sum_of(p->sum, logs, 62);
    likelihood_run_fold(&whole);
    return whole;
}

/* Held at +-2^61 */
static score likelihood_run_log(const likelihood_run *p)
{
    const likelihood_run whole = likelihood_run_whole(p);
    if (whole.carried > 2) return -score_max;
    if (whole.carried < -2) return score_max;
    return score_saturated(-((whole.carried * score_max + whole.sum) / 2)); /* < 3 2^61 / 2 */
}

#endif
