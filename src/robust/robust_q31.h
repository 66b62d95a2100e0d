/* What steps against outliers and jumps need of fixed point (update.h). */
#ifndef KQ_SRC_ROBUST_ROBUST_Q31_H
#define KQ_SRC_ROBUST_ROBUST_Q31_H

#include "../arithmetic/q31.h"
#include "../model/model.h"

/* A number that the user gives: k, nu, g */
static kq_status parameter_check(scaled a)
{
    const kq_status status = coefficients_check(&a, 1);
    if (status) return status;
    return a.mantissa > 0 ? KQ_OK : KQ_ERR_RANGE;
}

static kq_status noise_weight_check(scaled q)
{
    const kq_status status = coefficients_check(&q, 1);
    if (status) return status;
    return q.mantissa < 0 ? KQ_ERR_NOT_SEMIDEFINITE : KQ_OK;
}

static score score_of_fraction(int32_t a) { return a; }

/* Has target room for source's noise, and do the exponents times c stay within those of a table? */
static kq_status scaled_noise_check(const process *target, const process *source, num *root,
                                    scaled c)
{
    const int n = source->states;
    (void)target;
    if (!root) return KQ_ERR_NULL;
    if (root == source->noise_root) return KQ_ERR_MISMATCH;
    for (int i = 0; i < n; i++) {
        const int32_t exponent = exponents_of(source->noise_root, n)[i], moved_by = c.exponent + 30;
        if (exponent == lowest_exponent || scaled_is_zero(c)) continue;
        if (exponent + moved_by > KQ_EXPONENT_MAX_Q31 - 2) return KQ_ERR_COEFFICIENT;
        if (exponent + moved_by < 32 - KQ_EXPONENT_MAX_Q31) return KQ_ERR_COEFFICIENT;
    }
    return KQ_OK;
}

/* The source with c G.  A row that holds nothing keeps its exponent. */
static void set_scaled_noise(process *target, const process *source, num *root, scaled c)
{
    const int n = source->states;
    *target = *source;
    target->noise_root = root;
    copy(root, source->noise_root, ROOT_LEN(n));
    root_scale(root, c, n);
    target->fingerprint = scaled_fingerprint(source, c);
    target->seal = 0;
    if (!scaled_is_unit(c)) renormalise(root, n);
    for (int i = 0; i < n; i++) {
        if (exponents_of(source->noise_root, n)[i] != lowest_exponent) continue;
        root[KQ_TRIANGLE(n) + i] = lowest_exponent;
    }
}

#endif
