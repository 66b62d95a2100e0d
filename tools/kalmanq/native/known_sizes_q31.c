#include "known_sizes.h"

#include "kq_fixed_q31.h"

#define SIZES(of) of(1) of(2) of(3) of(4)
#define PAIRS(of) of(1, 1) of(2, 1) of(2, 2) of(3, 1) of(4, 1) of(4, 2)

#include "known_sizes_table.h"
