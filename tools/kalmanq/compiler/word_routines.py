"""The functions that the C of q31 calls, in the file that needs them: products, rounding, roots and inverses."""

from __future__ import annotations

import math
import re
from typing import Iterable

PRODUCT = """\
#if defined __ARM_ARCH_6M__ && defined __GNUC__
/* This core multiplies to 32 bits: a b, of halves. */
__attribute__((noinline)) static int64_t product(int32_t a, int32_t b)
{
    const uint32_t a_low = (uint16_t)a, b_low = (uint16_t)b, low = a_low * b_low;
    const int32_t a_high = a >> 16, b_high = b >> 16;
    const int32_t first = a_high * (int32_t)b_low + (int32_t)(low >> 16);
    const int32_t second = (int32_t)a_low * b_high + (int32_t)(uint16_t)first;
    const int32_t high = a_high * b_high + (first >> 16) + (second >> 16);
    return (int64_t)((uint64_t)(uint32_t)high << 32 | (uint32_t)second << 16 | (uint16_t)low);
}
#else
static inline int64_t product(int32_t a, int32_t b) { return (int64_t)a * b; }
#endif
"""

HIGH = """\
/* a b 2^-32, rounded down */
#if defined __ARM_ARCH_6M__
static uint32_t high(uint32_t a, uint32_t b)
{
    const uint32_t a_low = (uint16_t)a, b_low = (uint16_t)b, a_high = a >> 16, b_high = b >> 16;
    const uint32_t first = a_high * b_low + (a_low * b_low >> 16), second = a_low * b_high + (uint16_t)first;
    return a_high * b_high + (first >> 16) + (second >> 16);
}
#else
static inline uint32_t high(uint32_t a, uint32_t b) { return (uint32_t)((uint64_t)a * b >> 32); }
#endif
"""

WIDE = """\
/* c x 2^-32, c >= 0 */
static inline int64_t wide(int32_t c, int64_t x)
{
    return product(c, (int32_t)(uint32_t)((uint64_t)x >> 32)) + (int64_t)high((uint32_t)c, (uint32_t)x);
}
"""

PART = """\
/* a 2^-BY, to the nearest: two instructions where a shift leaves its last bit in the carry. */
#if defined __GNUC__ && defined __ARM_ARCH_ISA_THUMB && __ARM_ARCH_ISA_THUMB == 2
static inline int32_t NAME(int64_t a)
{
    uint32_t low = (uint32_t)a;
    __asm__("lsrs %0, %0, #BY\\n\\tadc %0, %0, %1, lsl #REST" : "+&r"(low) : "r"((uint32_t)((uint64_t)a >> 32)) : "cc");
    return (int32_t)low;
}
#else
static inline int32_t NAME(int64_t a) { return (int32_t)((a + (INT64_C(1) << (BY - 1))) >> BY); }
#endif
"""


def _part(name: str, by: int) -> str:
    return PART.replace("NAME", name).replace("BY - 1", str(by - 1)).replace("BY", str(by)).replace("REST", str(32 - by))


SHIFTED = """\
/* a 2^-by, to the nearest, 1 <= by <= 62 */
static inline int64_t shifted(int64_t a, int by) { return ((a >> (by - 1)) + 1) >> 1; }
"""

NARROW = """\
/* a, or the end of 32 bits that is nearer */
static inline int32_t narrow(int64_t a)
{
    return a == (int32_t)a ? (int32_t)a : a < 0 ? -INT32_MAX : INT32_MAX;
}
"""

ZEROS = """\
/* s > 0 */
#if defined __GNUC__ && __SIZEOF_INT__ == 4
static inline int zeros_before(uint32_t s) { return __builtin_clz(s); }
#else
static int zeros_before(uint32_t s)
{
    int zeros = 0;
    if (s < UINT32_C(1) << 16) zeros += 16, s <<= 16;
    if (s < UINT32_C(1) << 24) zeros += 8, s <<= 8;
    if (s < UINT32_C(1) << 28) zeros += 4, s <<= 4;
    if (s < UINT32_C(1) << 30) zeros += 2, s <<= 2;
    return zeros + (s < UINT32_C(1) << 31);
}
#endif
"""

ROOT = """\
#if defined __AVR__ /* whose constants are copied to RAM, but for these: 384 bytes */
#include <avr/pgmspace.h>
#define IN_FLASH PROGMEM
#define FROM_FLASH(word) pgm_read_dword(&(word))
#else
#define IN_FLASH
#define FROM_FLASH(word) (word)
#endif

typedef struct {
    int32_t over, root;
    int half;
} reciprocal;

/* Of t < 2^62, 0 as 1: 1 / sqrt(t) = over 2^(half - 62) to 2^-30 of it, sqrt(t) = root 2^(1 - half).
   A line near it, 14 bits, and a step of third order. */
#if defined __GNUC__
__attribute__((noinline))
#endif
static reciprocal inverse_root(uint64_t t)
{
    static const uint32_t line[96] IN_FLASH = { /* value 2^15, slope 2^5 */
LINE
    };
    const uint32_t upper = (uint32_t)(t >> 32), lower = (uint32_t)t;
    const uint32_t first = upper ? upper : lower + !lower, next = upper ? lower : 0;
    const int even = zeros_before(first) & ~1;
    const uint32_t v = first << even | next >> 1 >> (31 - even), near = FROM_FLASH(line[(v >> 25) - 32]);
    const uint32_t q = (near >> 16) - ((near & 0xffffu) * (v >> 9 & 0xffffu) >> 21);
    const int32_t rest = (int32_t)(UINT32_C(0x40000000) - high(v, q * q)), quarter = rest >> 2;
    const uint32_t step = UINT32_C(0x80000000) + (uint32_t)rest + ((uint32_t)(quarter * quarter) * 3u >> 28);
    uint32_t over = high(q << 16, step), root;
    over -= over >> 31;
    root = high(v, over << 1 | 1u); /* 1: half of what is cut off */
    root -= root >> 31;
    return (reciprocal){ (int32_t)over, (int32_t)root, (upper ? even : even + 32) / 2 };
}
"""

STUDENT = """\
/* sqrt(least / made) 2^30.  made: the variance that an innovation y whose noise is Student's, with the variance r, is taken
   with, by three steps of EM (Lange, Little and Taylor 1989).  over: 2^31 / (degrees of freedom + 1); root, half: of least */
static int32_t student(int32_t y, uint64_t spread, uint64_t r, uint64_t least, int32_t over, int32_t root, int half)
{
    uint64_t made = r;
    reciprocal m = inverse_root(made);
    for (int k = 0; k < 3; k++) {
        const int32_t c = ratio(m.root, m.half, inverse_root(spread + made)), rest = part(product(c, part(product(c, y))));
        made = least + 2 * (uint64_t)wide(over, product(rest, rest) + 4 * wide(c, 4 * wide(c, (int64_t)spread)));
        m = inverse_root(made);
    }
    return ratio(root, half, m);
}
"""

FRACTION = """\
/* f / sqrt(t) 2^30, |f| <= sqrt(t) */
static inline int32_t fraction(int32_t f, reciprocal r)
{
    return half_part(product((int32_t)((uint32_t)f << (r.half - 1)), r.over));
}
"""

RATIO = """\
/* sqrt of what is before, of a smaller t, over sqrt(t) */
static inline int32_t ratio(int32_t root, int half, reciprocal r)
{
    return half_part(product(root >> (half - r.half), r.over));
}
"""

WORD = """\
static inline int32_t word(reciprocal r)
{
    return (int32_t)(((uint32_t)r.root + ((UINT32_C(1) << (r.half - 1)) >> 1)) >> (r.half - 1));
}
"""

QUOTIENT = """\
/* 0xffffffff / d, rounded down, for 2^15 <= d <= 2^16 */
#if defined __ARM_ARCH_6M__ || defined __AVR__
/* This core divides in a hundred instructions: a line near 1 / d, two steps of Newton's, and what they leave. */
static uint32_t quotient(uint32_t d)
{
    const uint32_t near = UINT32_C(46261) - (UINT32_C(30840) * d >> 16);
    const int32_t first = (int32_t)((UINT32_C(1) << 30) - d * near);
    const uint32_t nearer = (near << 2) + (uint32_t)((int32_t)near * (first >> 12) >> 16);
    const int32_t second = (int32_t)(UINT32_C(0) - d * nearer);
    uint32_t r = nearer + (uint32_t)((int32_t)nearer * (second >> 10) >> 22); /* at most 2 below */
    int32_t rest = (int32_t)(UINT32_C(0xffffffff) - d * r);
    if (rest >= (int32_t)d) r++, rest -= (int32_t)d;
    return rest >= (int32_t)d ? r + 1 : r;
}
#else
static inline uint32_t quotient(uint32_t d) { return UINT32_C(0xffffffff) / d; }
#endif
"""

INVERSE = QUOTIENT + """\
/* 2^30 / (1 + |u|), u of 30 bits: a quotient of 16 bits and one step of Newton's */
static inline int32_t inverse(int32_t u)
{
    const uint32_t d = UINT32_C(0x40000000) + (uint32_t)(u < 0 ? -u : u), r = quotient((d + 0x4000u) >> 15);
    const int64_t rest = (INT64_C(1) << 47) - (int64_t)((uint64_t)d * r);
    return (int32_t)(r << 13) + (int32_t)(product((int32_t)r, (int32_t)(rest >> 4)) >> 30) + 1; /* 1: what is left */
}
"""

STOPPED = """\
/* x, at the end of its 2^62 where it is beyond */
static inline int64_t stopped(int64_t x, int64_t end) { return x < -end ? -end : x > end - 1 ? end - 1 : x; }
"""


def line() -> str:
    """Of 96 parts of [1/4, 1]: 1 / sqrt at the part's begin and its fall within the part, the least error on both
    sides.  Square roots are exact everywhere."""
    made = []
    for k in range(96):
        low, high = (k + 32) / 128, (k + 33) / 128
        a, b = 1 / math.sqrt(low), 1 / math.sqrt(high)
        where = ((a - b) * 256)**(-2 / 3)  # where the curve is as steep as the chord
        sag = (a - (a - b) * (where - low) * 128 - 1 / math.sqrt(where)) / 2
        made.append(f"{min(round((a - sag) * 2**15), 65535) << 16 | round((a - b) * 2**20):#010x}")
    return ",\n".join("        " + ", ".join(made[k:k + 8]) for k in range(0, 96, 8))


ROUTINES = (("student", STUDENT), ("stopped", STOPPED), ("inverse", INVERSE), ("word", WORD), ("ratio", RATIO), ("fraction", FRACTION),
            ("inverse_root", ROOT), ("zeros_before", ZEROS),
            ("narrow", NARROW), ("shifted", SHIFTED), ("half_part", _part("half_part", 31)), ("part", _part("part", 30)),
            ("twice_part", _part("twice_part", 29)), ("wide", WIDE),
            ("high", HIGH), ("product", PRODUCT))


def called(text: str, routines: Iterable[tuple[str, str]]) -> str:
    """Those that a text calls, and those that they call; names and texts, none after what it calls"""
    made = ""
    for name, routine in routines:
        if re.search(rf"\b{name}\(", text + made):
            made = routine + "\n" + made
    return made


def routines(text: str) -> str:
    return called(text, ROUTINES).replace("LINE", line())
