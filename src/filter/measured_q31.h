/* What the rounding of a predicted measurement leaves, in fixed point; measured_float.h is the
   twin. */
#ifndef KQ_SRC_FILTER_MEASURED_Q31_H
#define KQ_SRC_FILTER_MEASURED_Q31_H

#include "likelihood_q31.h"
#include "readings.h"

/* H_c x less the z that kq_measurement answers, in 2^-24 of a word, held at +-(2^31 - 1).  The sum
   is below 2^61, by init's check of H. */
num T(kq_measurement_low)(const filter *f, const sensor *s, int c)
{
    if (sensor_check_reading(f, s) != KQ_OK || c < 0 || c >= s->components) return num_nan();
    const int n = f->states;
    const scaled *h = s->measurement + c * n;
    int64_t sum = 0;
    for (int k = 0; k < n; k++) {
        sum = sum_of(sum, wide_product(h[k], f->memory[k], f->memory[n + k]), 62);
    }
    const int64_t low = shift_down_rounded_wide(sum, 2) - shift_up_wide(measured(f, s, c), 24, 55);
    return low > INT32_MAX ? INT32_MAX : low < -INT32_MAX ? -INT32_MAX : (num)low;
}

kq_status T(kq_log_likelihood_scaled)(const filter *f, scaled *value)
{
    const kq_status status = filter_check(f);
    if (status) return status;
    if (!value) return KQ_ERR_NULL;
    *value = likelihood_run_log_scaled(&f->run);
    return KQ_OK;
}

#endif
