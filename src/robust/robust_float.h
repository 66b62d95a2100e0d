/* What steps against outliers and jumps need of floating point (update.h). */
#ifndef KQ_SRC_ROBUST_ROBUST_FLOAT_H
#define KQ_SRC_ROBUST_ROBUST_FLOAT_H

#include "../model/model.h"

/* A number that the user gives: k, nu, g */
static kq_status parameter_check(num a)
{
    if (!num_is_finite(a)) return KQ_ERR_NOT_FINITE;
    return a > 0 ? KQ_OK : KQ_ERR_RANGE;
}

static kq_status noise_weight_check(num q)
{
    if (!num_is_finite(q)) return KQ_ERR_NOT_FINITE;
    return q < 0 ? KQ_ERR_NOT_SEMIDEFINITE : KQ_OK;
}

static num score_of_fraction(int32_t a) { return (num)a * (num)0x1p-24; }

/* Has target room for source's noise, and can the arithmetic hold it times c? */
static kq_status scaled_noise_check(const process *target, const process *source, num *root, num c)
{
    const int n = source->states;
    (void)root;
    if (!size_is_valid(target->states)) return KQ_ERR_SIZE;
    if (!target->memory || target->length < (unsigned)KQ_PROCESS_LEN(target->states)) {
        return KQ_ERR_MEMORY;
    }
    if (target->states != n || target->memory == source->noise_root) return KQ_ERR_MISMATCH;
    for (int k = 0; k < KQ_TRIANGLE(n); k++) {
        if (!num_is_finite(c * source->noise_root[k])) return KQ_ERR_NOT_FINITE;
    }
    return KQ_OK;
}

/* The source with c G; what was no noise is none. */
static void set_scaled_noise(process *target, const process *source, num *root, num c)
{
    const int n = source->states;
    num *G = target->memory;
    const uint16_t length = target->length;
    (void)root;
    *target = *source;
    target->memory = G;
    target->length = length;
    target->noise_root = G;
    copy(G, source->noise_root, KQ_TRIANGLE(n));
    root_scale(G, c, n);
    target->fingerprint = scaled_fingerprint(source, c);
    target->seal = 0;
    for (int i = 0; i < n; i++) {
        num *pivot = G + column(i) + i;
        if (*pivot < num_tiny_root || source->noise_root[column(i) + i] <= num_tiny_root) {
            *pivot = num_tiny_root;
        }
    }
}

#endif
