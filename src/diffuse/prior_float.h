/* The start's prior in floating point. */
#ifndef KQ_SRC_DIFFUSE_PRIOR_FLOAT_H
#define KQ_SRC_DIFFUSE_PRIOR_FLOAT_H

#include "diffuse.h"

/* P with the rows and columns in `unknown` as 0, whatever they hold; all: P may be NULL */
static void known_covariance(num *known, const num *P, int n, uint32_t unknown)
{
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) {
            const int is_known = !((unknown >> i | unknown >> j) & 1);
            known[i * n + j] = is_known ? P[i * n + j] : 0;
        }
    }
}

kq_status T(kq_diffuse_init)(start *s, filter *f, const num *x0, const num *P0,
                           uint32_t unknown)
{
    num P[KQ_SIZE_MAX * KQ_SIZE_MAX];
    kq_status status = diffuse_check_memory(s, f);
    if (status) return status;
    if (!x0) return KQ_ERR_NULL;
    const int n = s->states;
    const uint32_t all = (UINT32_C(1) << n) - 1;
    if (!P0 && (unknown & all) != all) return KQ_ERR_NULL;
    known_covariance(P, P0, n, unknown);
    status = T(kq_filter_init)(f, x0, P);
    if (status) return status;
    diffuse_begin(s, f, unknown);
    return KQ_OK;
}

#endif
