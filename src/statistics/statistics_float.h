/*
 * What least squares and consistency have of their own in floating point: scores (NIS, normalised
 * innovations), sums of them, a row of H as a sensor.  statistics_q31.h is the twin.
 */
#ifndef KQ_SRC_STATISTICS_STATISTICS_FLOAT_H
#define KQ_SRC_STATISTICS_STATISTICS_FLOAT_H

#include "../model/model.h"

typedef T(kq_least_squares) least_squares;

/* A normalised innovation as a word, or "none" where the squares of a window might add up to what is not representable */
static num unit_word(scaled a) { return a * a <= num_most_variance ? a : num_nan(); }
static int unit_is_none(num a) { return a != a; }
static score unit_score(num a) { return a; }
static score unit_product(num a, num b) { return a * b; }

/* ------------------------------------------------------------------ least squares */

static kq_status number_check(num a) { return num_is_finite(a) ? KQ_OK : KQ_ERR_NOT_FINITE; }

/* A row of H with noise r, for as long as `memory` (1) and h are there */
static kq_status row_sensor(sensor *row, num *memory, const least_squares *q, const num *h, num r)
{
    const kq_status status =
        T(kq_sensor_assign)(row, q->filter->states, 1, memory, KQ_SENSOR_DIAGONAL_LEN(1));
    return status ? status : sensor_init_diagonal(row, &T(kq_sensor_independent), h, &r);
}

#endif
