"""Functions in fixed point, as text of C; fixed_python.py has the same, bit for bit.

A word has 31 bits, -2^30 .. 2^30 - 1; `far` gets a bit where a value is beyond it, or has none.  Every function is a reduction of
its argument and a polynomial near the least error (Chebyshev's), all without floating point.
"""

from __future__ import annotations

import math
from typing import Sequence

from kalmanq.compiler import word_routines

SATURATED, NO_VALUE = 1, 2  # bits of `far`
WORD = 1 << 30  # words are below
# Coefficients of 1, x, x^2, ...: of 2^x, |x| <= 1/2; of the next three by the square of what they are odd or even in; of
# log(x + 3/2), |x| <= 1/2
EXP = (1073741824, 744261118, 257941253, 59597083, 10327276, 1431671, 166105, 16432)  # 2^-30
SIN = (1686629713, -693598667, 85569259, -5026471, 169873)  # 2^-30, sin(pi/2 y) / y, |y| <= 1/2
COS = (1073741824, -1324675869, 272375233, -22398329, 970263)  # 2^-30, cos(pi/2 y)
ATAN = (1073741824, -357913941, 214748290, -153388158, 119222248, -96554821, 74875806,
        -40415630)  # 2^-30, atan(q) / q, |q| <= 0.415
LOG = (870729689, 1431655764, -477218588, 212097252, -106048638, 56556013, -31419796, 17998857, -10500967, 5925019, -3549187,
       3103530, -1904386)  # 2^-31
TURN, LOG2_E = 1 / (2 * math.pi), 1 / math.log(2)
LN_2, TANGENT = 1488522236, 0x6A09E668  # log(2) 2^31, tan(pi/8) 2^32
QUARTER, HALF = 843314857, 1686629713  # pi/2 and pi, 2^-29


def polynomial(coefficients: Sequence[int], x: str, to: str) -> str:
    """C, by Horner's rule"""
    lines = [f"int32_t {to} = {coefficients[-1]};"]
    return "\n    ".join([*lines, *(f"{to} = {one} + upper({to}, {x});" for one in coefficients[-2::-1])])


C = {
    "upper": """\
/* a b 2^-32, rounded down */
static inline int32_t upper(int32_t a, int32_t b) { return (int32_t)(product(a, b) >> 32); }
""",
    "rounded": """\
/* a 2^-by, to the nearest, by > 0 */
static inline int64_t rounded(int64_t a, int by) { return (a + (INT64_C(1) << (by - 1))) >> by; }
""",
    "narrowed": """\
/* a, which fits */
static inline int32_t narrowed(int64_t a) { return (int32_t)a; }
""",
    "held": """\
/* a, or the end of 31 bits that is nearer; a large model has hundreds of them */
#if defined __GNUC__
__attribute__((noinline))
#endif
static int32_t held(int64_t a, uint32_t *far)
{
    if ((uint64_t)a + 0x40000000u < 0x80000000u) return (int32_t)a;
    *far |= 1u;
    return a < 0 ? -0x3fffffff : 0x3fffffff;
}
""",
    "known": """\
/* a, or what the library refuses where it is beyond 32 bits */
static inline int32_t known(int64_t a) { return a >= -INT32_MAX && a <= INT32_MAX ? (int32_t)a : INT32_MIN; }
""",
    "kept": """\
/* a, which has no value beyond 32 bits */
static inline int32_t kept(int64_t a, uint32_t *far)
{
    if (a < -INT32_MAX || a > INT32_MAX) *far |= 2u;
    return known(a);
}
""",
    "placed": """\
/* a 2^-by, to the nearest, in 31 bits */
#if defined __GNUC__
__attribute__((noinline))
#endif
static int32_t placed(int64_t a, int by, uint32_t *far)
{
    if (by > 62) return 0;
    if (by > 0) {
        a = ((a >> (by - 1)) + 1) >> 1;
        if ((uint64_t)a + 0x40000000u < 0x80000000u) return (int32_t)a;
    } else {
        const int64_t most = by < -30 ? 0 : INT64_C(0x3fffffff) >> -by;
        if (a >= -most && a <= most) return a ? (int32_t)(a * (INT64_C(1) << -by)) : 0;
    }
    *far |= 1u;
    return a < 0 ? -0x3fffffff : 0x3fffffff;
}
""",
    "size": """\
static inline uint64_t size(int64_t a) { return a < 0 ? UINT64_C(0) - (uint64_t)a : (uint64_t)a; }
""",
    "leading": """\
/* Zeros before a > 0 */
static inline int leading(uint64_t a)
{
    const uint32_t first = (uint32_t)(a >> 32);
    return first ? zeros_before(first) : 32 + zeros_before((uint32_t)a);
}
""",
    "scaled": """\
/* a 2^exponent, as the library has it */
static kq_scaled_q31 scaled(int64_t a, int exponent)
{
    if (!a) return (kq_scaled_q31){0, 0};
    const int zeros = leading(size(a));
    const int32_t mantissa = (int32_t)(size(a) << zeros >> 33);
    return (kq_scaled_q31){a < 0 ? -mantissa : mantissa, exponent + 33 - zeros};
}
""",
    "one_over": """\
/* 1 / a = over 2^-by to 2^-29 of it */
static inverted one_over(int64_t a, uint32_t *far)
{
    if (!a) {
        *far |= 2u;
        return (inverted){0x3fffffff, 30};
    }
    const int zeros = leading(size(a));
    const int32_t over = inverse((int32_t)(size(a) << zeros >> 33) - 0x40000000);
    return (inverted){a < 0 ? -over : over, 93 - zeros};
}
""",
    "root_of": """\
static inline reciprocal root_of(int64_t a, uint32_t *far)
{
    if (a < 0) *far |= 2u;
    return inverse_root(a < 0 ? 0 : (uint64_t)a);
}
""",
    "over_root": """\
static inline inverted over_root(reciprocal r) { return (inverted){r.over, 62 - r.half}; }
""",
    "phase": """\
/* An angle as 2^32 parts of a turn */
static inline uint32_t phase(int64_t turns, int by) { return (uint32_t)(uint64_t)rounded(turns, by); }
""",
    "large_phase": """\
/* Of an angle whose last bit is more than one of these parts */
static inline uint32_t large_phase(int64_t turns, int by) { return (uint32_t)((uint64_t)turns << by); }
""",
    "sine": f"""\
/* sin 2^30 */
static int32_t sine(uint32_t turn)
{{
    const uint32_t from = turn + UINT32_C(0x20000000);
    const int32_t y = (int32_t)(((from & 0x3fffffffu) << 2) - UINT32_C(0x80000000)), square = upper(y, y);
    int32_t made;
    if (from & UINT32_C(0x40000000)) {{
        {polynomial(COS, 'square', 'c').replace(chr(10), chr(10) + '    ')}
        made = c;
    }} else {{
        {polynomial(SIN, 'square', 's').replace(chr(10), chr(10) + '    ')}
        made = upper(s, y);
    }}
    return from & UINT32_C(0x80000000) ? -made : made;
}}
""",
    "exponential": f"""\
/* 2^(a 2^-32) 2^fraction */
static int32_t exponential(int64_t a, int fraction, uint32_t *far)
{{
    const int32_t k = (int32_t)((a + INT64_C(0x80000000)) >> 32), x = (int32_t)(uint32_t)(uint64_t)a;
    {polynomial(EXP, 'x', 'p')}
    const int by = 30 - fraction - (int)(k > 200 ? 200 : k < -200 ? -200 : k);
    if (by > 31) return 0;
    return by > 0 ? ((p >> (by - 1)) + 1) >> 1 : placed(p, by, far);
}}
""",
    "logarithm": f"""\
/* log(a 2^-fraction) 2^31 */
static int64_t logarithm(int64_t a, int fraction, uint32_t *far)
{{
    if (a <= 0) *far |= 2u;
    const uint64_t given = a <= 0 ? 1 : (uint64_t)a;
    const int zeros = leading(given);
    const int32_t x = (int32_t)(((uint32_t)(given << zeros >> 32) << 1) - UINT32_C(0x80000000));
    {polynomial(LOG, 'x', 'p')}
    return product(63 - zeros - fraction, {LN_2}) + p;
}}
""",
    "angle": f"""\
/* atan2(y, x) 2^29 */
static int32_t angle(int64_t y, int64_t x)
{{
    const uint64_t up = size(y), along = size(x), larger = up > along ? up : along;
    if (!larger) return 0;
    const int zeros = leading(larger);
    const uint32_t a = (uint32_t)(up << zeros >> 33), b = (uint32_t)(along << zeros >> 33);
    const uint32_t less = a < b ? a : b, more = a < b ? b : a;
    const int beyond = less > (uint32_t)(((uint64_t)more * {TANGENT}u) >> 32);
    const uint32_t sum = beyond ? less + more : more;
    const int by = (int)(sum >> 31);
    const int32_t over = inverse((int32_t)((sum >> by) - UINT32_C(0x40000000)));
    const int32_t above = (int32_t)(beyond ? less - more : less);
    const int32_t q = (int32_t)rounded(product(above, over), 28 + by), square = upper(q, q);
    {polynomial(ATAN, 'square', 'p')}
    int32_t made = (upper(p, q) + 1) >> 1;
    if (beyond) made += {QUARTER // 2};
    if (a > b) made = {QUARTER} - made;
    if (x < 0) made = {HALF} - made;
    return y < 0 ? -made : made;
}}
""",
    "nearest": """\
/* a 2^-by, halves to the even one, 0 < by < 62 */
static inline int64_t nearest(int64_t a, int by)
{
    const int64_t made = rounded(a, by);
    return made - ((a - made * (INT64_C(1) << by)) * 2 == -(INT64_C(1) << by) ? made & 1 : 0);
}
""",
    "within": """\
/* a, or the end of -most .. most that is nearer */
static inline int64_t within(int64_t a, int64_t most) { return a < -most ? -most : a > most ? most : a; }
""",
    "absolute": """\
static inline int64_t absolute(int64_t a) { return a < 0 ? -a : a; }
""",
    "remainder_of": """\
/* Of the sign of a */
static int64_t remainder_of(int64_t a, int64_t b, uint32_t *far)
{
    if (!b) *far |= 2u;
    return b ? a % b : 0;
}
""",
}
INVERTED = "typedef struct { int32_t over; int by; } inverted;\n"


def routines(text: str) -> str:
    """C of the functions that a text calls, and of those that they call"""
    own = word_routines.called(text, reversed(C.items()))
    own = f"{INVERTED}\n{own}" if "inverted" in text + own else own
    return "\n".join(one for one in (word_routines.routines(text + own), own.removesuffix("\n")) if one)
