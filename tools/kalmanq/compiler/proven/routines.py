"""The few functions that the C of q31 calls, each in the file that needs it."""

from __future__ import annotations

from kalmanq.compiler.word_routines import PRODUCT, QUOTIENT, ZEROS_BEFORE, called

WIDE = """\
/* c x 2^-32, c >= 0.  The high word by an unsigned shift: of a signed one gcc makes a product of 64 bits by 64. */
static inline int64_t wide(int32_t c, int64_t x)
{
    uint32_t factor = (uint32_t)c;
#if defined __GNUC__ && !defined __CC_ARM && defined __ARM_ARCH_ISA_THUMB && __ARM_ARCH_ISA_THUMB == 2
    /* One instruction; of a constant such as 0x33333333 gcc makes twenty, shifts and sums. */
    __asm__("" : "+r"(factor));
#endif
    return product((int32_t)factor, (int32_t)(uint32_t)((uint64_t)x >> 32)) +
           (int64_t)(((uint64_t)factor * (uint32_t)x) >> 32);
}
"""

INVERSE = ZEROS_BEFORE.replace("INT_OF_32_BITS", "UINT_MAX == 0xffffffffu") + """
/* 2^(62 - most) / s, to 2^-29 of it; s > 0 has at most so many leading zeros.  A quotient of 16 bits and one step of
   Newton's. */
static int32_t inverse(uint32_t s, int most)
{
    const int zeros = zeros_before(s);
    const uint32_t v = s << zeros, r = quotient(v >> 16);
    const int64_t rest = (INT64_C(1) << 48) - (int64_t)((uint64_t)v * r);
    const int64_t more = product((int32_t)r, (int32_t)(rest >> 2)) >> 32;
    return (int32_t)(((int64_t)r << 14) + more) >> (most - zeros);
}
"""

ROUTINES = (("inverse", INVERSE), ("quotient", QUOTIENT), ("wide", WIDE), ("product", PRODUCT))


def routines(text: str) -> str:
    return called(text, ROUTINES)
