/*
 * What least squares and consistency have of their own in fixed point: normalised innovations as words,
 * a row of H as a sensor.  statistics_float.h is the twin.
 */
#ifndef KQ_SRC_STATISTICS_STATISTICS_Q31_H
#define KQ_SRC_STATISTICS_STATISTICS_Q31_H

#include "../arithmetic/q31.h"
#include "../model/model.h"

typedef T(kq_least_squares) least_squares;

/* A normalised innovation as a word in Q7.24 */
static num unit_word(scaled a) { return word_of(scaled_shift(a, 24)); }
static int unit_is_none(num a) { return a == KQ_NOT_A_VALUE_Q31; }
static score unit_score(num a) { return a; }
static score unit_product(num a, num b) { return shift_down_rounded_wide(product(a, b), 24); }

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
