/* The length of a root, which a q31 table has */
#ifndef KQ_SRC_LENGTHS_LENGTHS_Q31_H
#define KQ_SRC_LENGTHS_LENGTHS_Q31_H

#include <stddef.h>

#include "kalmanq/lengths.h"
#include "kalmanq/size.h"

#include "../arithmetic/arithmetic.h"

static kq_length length_of_own(kq_object object, int n, int m, size_t k)
{
    (void)m, (void)k;
    return object == KQ_OBJECT_ROOT ? (kq_length)KQ_ROOT_LEN_Q31(n) : 0;
}

static size_t size_of_own(kq_object object)
{
    (void)object;
    return 0;
}

#endif
