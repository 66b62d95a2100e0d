/* The start's prior in fixed point. */
#ifndef KQ_SRC_DIFFUSE_PRIOR_Q31_H
#define KQ_SRC_DIFFUSE_PRIOR_Q31_H

#include "../arithmetic/q31.h"
#include "diffuse.h"

/* A root of which the rows in `unknown` are 0, and so is what they have in common with others */
static void known_root(num *known, const num *root, int n, uint32_t unknown)
{
    copy(known, root, ROOT_LEN(n));
    for (int i = 0; i < n; i++) {
        if (!(unknown >> i & 1)) continue;
        for (int j = i; j < n; j++) known[column(j) + i] = 0;
        known[KQ_TRIANGLE(n) + i] = lowest_exponent;
    }
}

kq_status T(kq_diffuse_init)(start *s, filter *f, const kq_prior_table_q31 *prior,
                           uint32_t unknown, kq_range_error_q31 *range_error)
{
    num root[ROOT_LEN(KQ_SIZE_MAX)];
    kq_status status = diffuse_check_memory(s, f);
    if (status) return status;
    if (!prior || !prior->root) return KQ_ERR_NULL;
    if (prior->states != s->states) return KQ_ERR_MISMATCH;
    known_root(root, prior->root, s->states, unknown);
    kq_prior_table_q31 known = *prior;
    known.root = root;
    status = T(kq_filter_init)(f, &known, range_error);
    if (status) return status;
    diffuse_begin(s, f, unknown);
    return KQ_OK;
}

#endif
