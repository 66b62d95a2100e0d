#include "fixed_size.h"

#include "kq_fixed_f32.h"

#include "calm.h"

#define SIZES(of) of(1) of(2) of(3) of(4) of(5) of(6)
#define PAIRS(of)                                                                                  \
    of(1, 1) of(1, 2) of(2, 1) of(2, 2) of(3, 1) of(3, 2) of(3, 3) of(4, 1) of(4, 2) of(4, 3)      \
    of(5, 1) of(5, 2) of(5, 3) of(6, 1) of(6, 2) of(6, 3)

#include "fixed_size_table.h"
