/*
 * What least squares and consistency have of their own in fixed point: scores (NIS, normalised
 * innovations) in Q39.24, sums of them, a row of H as a sensor.  statistics_float.h is the twin.
 */
#ifndef KQ_SRC_STATISTICS_STATISTICS_Q31_H
#define KQ_SRC_STATISTICS_STATISTICS_Q31_H

#include <stdint.h>

#include "kalmanq/filter.h"
#include "kalmanq/fixed_point.h"
#include "kalmanq/least_squares.h"
#include "kalmanq/sensor.h"
#include "kalmanq/status.h"

#include "../arithmetic/q31.h"
#include "../arithmetic/fixed.h"
#include "../arithmetic/scaled.h"
#include "../model/definitions.h"
#include "../model/types.h"
#include "../filter/likelihood.h"

typedef T(kq_tally) tally;
typedef T(kq_least_squares) least_squares;

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
    return sum_of(raise_wide(word[0], 31, 61), word[1], 62);
}

static void tally_clear(tally *t) { t->sum = 0; }
static void tally_add(tally *t, score a) { t->sum = score_held(sum_of(t->sum, a, 62)); }

/* c < 1: the upper and the lower bits of the sum apart.  One that was held stays where it is: it is
   no sum any more, and can be told from one. */
static void tally_fade(tally *t, scaled c)
{
    if (t->sum >= score_max) return;
    const int64_t high = product((num)(t->sum >> 31), c.mantissa);
    const int64_t low = lower_wide(product((num)(t->sum & INT32_MAX), c.mantissa), 31);
    t->sum = lower_wide(sum_of(high, low, 62), -31 - c.exponent);
}

static score tally_score(const tally *t) { return t->sum; }

/* A normalised innovation as a word in Q7.24 */
static num unit_word(scaled a) { return word_of(scaled_shift(a, 24)); }
static int unit_is_none(num a) { return a == KQ_NOT_A_WORD_Q31; }
static score unit_score(num a) { return a; }
static score unit_product(num a, num b) { return lower_wide(product(a, b), 24); }

/* ------------------------------------------------------------------ least squares */

static kq_status number_check(scaled a) { return coefficients_check(&a, 1); }

/* A row of H with noise r, for as long as `memory` (1) and h are there */
static kq_status row_sensor(sensor *row, scaled *memory, const least_squares *q, const scaled *h,
                            scaled r)
{
    memory[0] = r;
    const kq_sensor_table_q31 table = {.states = q->filter->states,
                                       .components = 1,
                                       .state_format = q->filter->state_format,
                                       .measurement_format = q->measurement_format,
                                       .measurement = h,
                                       .noise = memory};
    return kq_sensor_init_q31(row, &table, 0);
}

#endif
