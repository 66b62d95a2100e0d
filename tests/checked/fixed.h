/*
 * The checked number layer: the operations of src/arithmetic/fixed.h, which stop the program with the caller's
 * file and line where a promise is not kept.
 *
 * Give it to the compiler by -include: the include guard is that of src/arithmetic/fixed.h, which is then
 * skipped.  Link checked.c with it.  Every call site also remembers the largest magnitude that it
 * made, and checked_report prints how close each came to its bound.
 */
#ifndef KQ_SRC_ARITHMETIC_FIXED_H
#define KQ_SRC_ARITHMETIC_FIXED_H

#include <stdint.h>

#include "../../src/arithmetic/compiler.h"

#include "kalmanq/port/integer.h"

#include "sites.h"

_Static_assert((-3 >> 1) == -2, "kalmanq needs arithmetic right shifts");

#define CHECKED_SITE(name)                                                                         \
    static checked_site site = {name, __FILE__, __LINE__, 0, 0, 0, 0};                             \
    if (!site.seen) checked_enter(&site)

/* Where an argument holds a call itself, that call's `site` is in a block of its own. */
#define round_to_word(a, shift, bits)                                                                     \
    __extension__({                                                                                \
        CHECKED_SITE("round_to_word");                                                                    \
        checked_narrow(&site, a, shift, bits);                                                     \
    })
#define shift_down_rounded(a, shift)                                                                            \
    __extension__({                                                                                \
        CHECKED_SITE("shift_down_rounded");                                                                     \
        checked_lower(&site, a, shift);                                                            \
    })
#define shift_down_rounded_wide(a, shift)                                                                       \
    __extension__({                                                                                \
        CHECKED_SITE("shift_down_rounded_wide");                                                                \
        checked_lower_wide(&site, a, shift);                                                       \
    })
#define shift_up(a, shift, bits)                                                                      \
    __extension__({                                                                                \
        CHECKED_SITE("shift_up");                                                                     \
        checked_raise(&site, a, shift, bits);                                                      \
    })
#define shift_up_wide(a, shift, bits)                                                                 \
    __extension__({                                                                                \
        CHECKED_SITE("shift_up_wide");                                                                \
        checked_raise_wide(&site, a, shift, bits);                                                 \
    })
#define shift_up_word(a, shift, bits) shift_up_wide(a, shift, bits)
#define accumulate(total, a, b, bits) sum_of(total, product(a, b), bits)
#define round_product_to_word(a, b, shift, bits) round_to_word(product(a, b), shift, bits)
#define round_products_to_word(a, b, c, d, shift, bits)                                                   \
    round_to_word(accumulate(product(a, b), c, d, 62), shift, bits)
#define sum_of(a, b, bits)                                                                         \
    __extension__({                                                                                \
        CHECKED_SITE("sum_of");                                                                    \
        checked_sum_of(&site, a, b, bits);                                                         \
    })

static inline uint32_t magnitude(int32_t a) { return a < 0 ? 0 - (uint32_t)a : (uint32_t)a; }

static inline uint64_t checked_magnitude(int64_t a)
{
    return a < 0 ? 0 - (uint64_t)a : (uint64_t)a;
}

/* The result of a call with the arguments a and b, which has to be within 2^bits */
static inline int64_t checked_result(checked_site *site, int64_t result, int64_t a, int64_t b,
                                     int bits)
{
    const uint64_t size = checked_magnitude(result);
    if (bits < 0 || bits > 63 || size > UINT64_C(1) << bits) {
        checked_stop(site, "beyond its bound", a, b, bits, result);
    }
    if (size > site->most) site->most = size;
    site->bits = bits;
    return result;
}

static inline int64_t checked_round(checked_site *site, int64_t a, int shift)
{
    int64_t sum;
    if (__builtin_add_overflow(a, INT64_C(1) << (shift - 1), &sum)) {
        checked_stop(site, "rounding overflows", a, shift, 63, a);
    }
    return sum >> shift;
}

static inline int32_t checked_narrow(checked_site *site, int64_t a, int shift, int bits)
{
    if (shift < 1 || shift > 62) checked_stop(site, "shift out of 1..62", a, shift, bits, 0);
    const int64_t result = checked_result(site, checked_round(site, a, shift), a, shift, bits);
    if (result != (int32_t)result) checked_stop(site, "not a word", a, shift, bits, result);
    return (int32_t)result;
}

static inline int32_t checked_lower(checked_site *site, int32_t a, int32_t shift)
{
    if (shift < 0) checked_stop(site, "negative shift", a, shift, 31, 0);
    if (shift == 0) return a;
    if (shift > 31) return 0;
    return (int32_t)checked_result(site, ((int64_t)(a >> (shift - 1)) + 1) >> 1, a, shift, 31);
}

static inline int64_t checked_lower_wide(checked_site *site, int64_t a, int32_t shift)
{
    if (shift < 0) checked_stop(site, "negative shift", a, shift, 63, 0);
    if (shift == 0) return a;
    if (shift > 63) return 0;
    return checked_result(site, checked_round(site, a >> (shift - 1), 1), a, shift, 63);
}

static inline int32_t checked_raise(checked_site *site, int32_t a, int shift, int bits)
{
    if (shift < 0 || shift > 31) checked_stop(site, "shift out of 0..31", a, shift, bits, 0);
    const int64_t result = a * (INT64_C(1) << shift);
    if (result != (int32_t)result) checked_stop(site, "bits lost", a, shift, bits, result);
    return (int32_t)checked_result(site, result, a, shift, bits);
}

static inline int64_t checked_raise_wide(checked_site *site, int64_t a, int shift, int bits)
{
    if (shift < 0 || shift > 63) checked_stop(site, "shift out of 0..63", a, shift, bits, 0);
    const int64_t result = (int64_t)((uint64_t)a << shift);
    if (result >> shift != a) checked_stop(site, "bits lost", a, shift, bits, result);
    return checked_result(site, result, a, shift, bits);
}

static inline int64_t checked_sum_of(checked_site *site, int64_t a, int64_t b, int bits)
{
    int64_t result;
    if (__builtin_add_overflow(a, b, &result)) checked_stop(site, "overflow", a, b, bits, 0);
    return checked_result(site, result, a, b, bits);
}

#endif
