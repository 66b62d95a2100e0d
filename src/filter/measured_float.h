/* What the rounding of a predicted measurement leaves, in floating point; measured_q31.h is the
   twin. */
#ifndef KQ_SRC_FILTER_MEASURED_FLOAT_H
#define KQ_SRC_FILTER_MEASURED_FLOAT_H

#include "readings.h"

/*
 * H_c x less the z that kq_measurement answers.  Numbers are taken apart into halves whose products
 * are exact, so that a compiler may fuse them with the sums or not; the sum has three times the
 * bits of a number.
 */
num T(kq_measurement_low)(const filter *f, const sensor *s, int c)
{
    if (sensor_check_for(f, s) != KQ_OK || c < 0 || c >= s->components) return num_nan();
    const int n = f->states;
    const num *h = s->measurement + c * n;
    compensated rest;
    compensated_clear(&rest);
    compensated_add(&rest, -measured(f, s, c));
    for (int k = 0; k < n; k++) {
        const num x = mean_get(f->memory, n, k);
        const num x_upper = num_upper(x), x_lower = x - x_upper;
        const num h_upper = num_upper(h[k]), h_lower = h[k] - h_upper;
        compensated_add(&rest, h_upper * x_upper);
        compensated_add(&rest, h_upper * x_lower);
        compensated_add(&rest, h_lower * x_upper);
        compensated_add(&rest, h_lower * x_lower);
        compensated_add(&rest, h[k] * mean_low(f->memory, n, k));
    }
    return compensated_value(&rest);
}

#endif
