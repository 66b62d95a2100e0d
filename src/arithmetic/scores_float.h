/* Scores (log-likelihoods, NIS) in floating point, and sums of many of them. */
#ifndef KQ_SRC_ARITHMETIC_SCORES_FLOAT_H
#define KQ_SRC_ARITHMETIC_SCORES_FLOAT_H

#include "scaled_float.h"

typedef T(kq_compensated) compensated;

static num not_a_score(void) { return num_nan(); }

static score score_of(scaled a) { return a; }

static scaled score_number(score a) { return a; }

static int score_is_finite(score a) { return num_is_finite(a); }

/* Words of memory of a score */
#define SCORE_WORDS 1

static void store_score(num *word, score a) { *word = a; }

static score load_score(const num *word) { return *word; }

static void compensated_clear(compensated *t)
{
    t->high = 0;
    t->sum = 0;
    t->low = 0;
}

/* What the rounding of total = a + b has left */
static num sum_rest(num a, num b, num total)
{
    const num moved = total - a;
    return (a - (total - moved)) + (b - moved);
}

/* Each part is left below the last bit of the part before it: nothing is lost that is not below the
   last bit of the third. */
static void compensated_add(compensated *t, num a)
{
    const num some = t->sum + a, rest = t->low + sum_rest(t->sum, a, some);
    const num sum = some + rest, low = sum_rest(some, rest, sum);
    const num high = t->high + sum;
    t->sum = sum_rest(t->high, sum, high);
    t->low = low;
    t->high = high;
}

static num compensated_value(const compensated *t) { return (t->low + t->sum) + t->high; }

/* c < 1; rounded at the increment, so that a long memory does not drift */
static void compensated_forget(compensated *t, scaled c) { compensated_add(t, (c - 1) * compensated_value(t)); }

static score compensated_score(const compensated *t) { return compensated_value(t); }

/* compensated_add into the lower two parts alone, at a fifth of the additions: `a` loses what is below its
   own last bit or that of `low`, an eps of it as long as compensated_carry is called now and then. */
KQ_KERNEL void compensated_add_next(compensated *t, num a)
{
    const num low = t->low + a, sum = t->sum + low;
    t->low = low - (sum - t->sum);
    t->sum = sum;
}

KQ_KERNEL void compensated_carry(compensated *t)
{
    const num high = t->high + t->sum;
    t->sum -= high - t->high;
    t->high = high;
}

#endif
