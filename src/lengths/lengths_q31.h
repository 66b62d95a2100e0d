/* The length of a root, which a q31 table has */
#ifndef KQ_SRC_LENGTHS_LENGTHS_Q31_H
#define KQ_SRC_LENGTHS_LENGTHS_Q31_H

#include <stddef.h>

#include "kalmanq/lengths.h"
#include "kalmanq/size.h"

#include "../arithmetic/arithmetic.h"
#include "../arithmetic/size.h"

kq_length T(kq_root_length)(int n)
{
    return size_is_valid(n) ? (kq_length)KQ_ROOT_LEN_Q31(n) : 0;
}

#endif
