/* What linearised steps have of their own in floating point: the process, the increment, the inits of sensors. */
#ifndef KQ_SRC_LINEARISED_LINEARISED_FLOAT_H
#define KQ_SRC_LINEARISED_LINEARISED_FLOAT_H

#include "innovation.h"

/* Is it a process, and f's? */
static kq_status jacobian_check(const process *p, const filter *f) { return predict_check(f, p, 0); }

/* As the root is predicted by it */
KQ_INLINE const process *jacobian_process(const process *p, process *own)
{
    (void)own;
    return p;
}

/* Could the mean go through A, too? */
static kq_status jacobian_check_mean(const process *p)
{
    (void)p;
    return KQ_OK;
}

static kq_status increment_check(const num *d, int n) { return all_finite(d, n) ? KQ_OK : KQ_ERR_NOT_FINITE; }

KQ_COLD kq_status T(kq_sensor_init_extended)(sensor *s, const num *H, const num *R)
{
    const kq_status status = T(kq_sensor_init)(s, H, R);
    if (status) return status;
    return sensor_extend(s, sensor_is_correlated(s) ? &T(kq_sensor_correlated_extended) : &independent_extended, KQ_OK);
}

KQ_COLD kq_status T(kq_sensor_init_diagonal_extended)(sensor *s, const num *H, const num *r)
{
    return sensor_extend(s, &independent_extended, T(kq_sensor_init_diagonal)(s, H, r));
}

KQ_COLD kq_status T(kq_sensor_init_lean_extended)(sensor *s, const num *H, const num *r)
{
    return sensor_extend(s, &lean_extended, T(kq_sensor_init_lean)(s, H, r));
}

#endif
