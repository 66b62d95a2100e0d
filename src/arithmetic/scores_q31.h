/* Scores (log-likelihoods, NIS) in fixed point, Q39.24, and sums of many of them. */
#ifndef KQ_SRC_ARITHMETIC_SCORES_Q31_H
#define KQ_SRC_ARITHMETIC_SCORES_Q31_H

#include "mean_q31.h"

typedef T(kq_compensated) compensated;

static score not_a_score(void) { return KQ_NOT_A_SCORE_Q31; }

static const int64_t score_max = INT64_C(1) << 61; /* two of them add up below 2^63 */

static int64_t score_saturated(int64_t a) { return held_within(a, score_max); }

/* a as Q39.24 */
static int64_t score_of(scaled a) { return wide_from(a.mantissa, a.exponent + 24, 61); }

static scaled score_number(score a) { return scaled_of(a, -24); }

static int score_is_finite(score a)
{
    (void)a;
    return 1;
}

/* Words of memory of a score: it is within +-2^61. */
#define SCORE_WORDS 2

static void store_score(num *word, score a)
{
    word[0] = (num)(a >> 31);
    word[1] = (num)(a & INT32_MAX);
}

static score load_score(const num *word)
{
    return sum_of(shift_up_wide(word[0], 31, 61), word[1], 62);
}

static void compensated_clear(compensated *t) { t->sum = 0; }

static void compensated_add(compensated *t, score a) { t->sum = score_saturated(sum_of(t->sum, a, 62)); }

/* c < 1: the upper and the lower bits of the sum apart.  One that was held stays where it is: it is
   no sum any more, and can be told from one. */
static void compensated_forget(compensated *t, scaled c)
{
    if (t->sum >= score_max) return;
    const int64_t high = product((num)(t->sum >> 31), c.mantissa);
    const int64_t low = shift_down_rounded_wide(product((num)(t->sum & INT32_MAX), c.mantissa), 31);
    t->sum = shift_down_rounded_wide(sum_of(high, low, 62), -31 - c.exponent);
}

static score compensated_score(const compensated *t) { return t->sum; }

#endif
