"""Functions in fixed point: C as text, and the same in Python, bit for bit.

A word has 31 bits, -2^30 .. 2^30 - 1; `far` gets a bit where a value is beyond it, or has none.  Every function is a reduction of
its argument and a polynomial near the least error (Chebyshev's), all without floating point.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any, Callable, Mapping, Sequence

from kalmanq.compiler import word_routines

SATURATED, NO_VALUE = 1, 2  # bits of `far`
HALF_WORD, MOST = 1 << 30, 2**31 - 1
# Coefficients of 1, x, x^2, ...: of 2^x, |x| <= 1/2; of the next three by the square of what they are odd or even in; of
# log(x + 3/2), |x| <= 1/2
EXP = (1073741824, 744261118, 257941253, 59597083, 10327276, 1431671, 166105, 16432)  # 2^-30
SIN = (1686629713, -693598667, 85569259, -5026471, 169873)  # 2^-30, sin(pi/2 y) / y, |y| <= 1/2
COS = (1073741824, -1324675869, 272375233, -22398329, 970263)  # 2^-30, cos(pi/2 y)
ATAN = (1073741824, -357913941, 214748290, -153388158, 119222248, -96554821, 74875806, -40415630)  # 2^-30, atan(q) / q, |q| <= 0.415
LOG = (870729689, 1431655764, -477218588, 212097252, -106048638, 56556013, -31419796, 17998857, -10500967, 5925019, -3549187,
       3103530, -1904386)  # 2^-31
TURN, LOG2_E = (1367130551, 33), (1549082005, 30)  # 1 / (2 pi) and log2(e): numbers, and their fractions
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
/* a, or the end of 31 bits that is nearer */
static inline int32_t held(int64_t a, uint32_t *far)
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
    "placed": """\
/* a 2^-by, to the nearest, in 31 bits */
static int32_t placed(int64_t a, int by, uint32_t *far)
{
    if (by > 62) return 0;
    if (by > 0) return held(((a >> (by - 1)) + 1) >> 1, far);
    const int64_t most = by < -30 ? 0 : INT64_C(0x3fffffff) >> -by;
    if (a >= -most && a <= most) return a ? (int32_t)(a * (INT64_C(1) << -by)) : 0;
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
    return placed(p, 30 - fraction - (k > 200 ? 200 : k < -200 ? -200 : k), far);
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
ORDER = ("upper", "rounded", "narrowed", "held", "known", "placed", "size", "leading", "scaled", "one_over", "root_of", "over_root", "phase",
         "large_phase", "sine", "exponential", "logarithm", "angle", "nearest", "within", "absolute", "remainder_of")


def routines(text: str) -> str:
    """C of the functions that a text calls, and of those that they call"""
    made: list[str] = []
    for name in ORDER[::-1]:
        if re.search(rf"\b{name}\(", text):
            made.insert(0, C[name])
            text += C[name]
    own = "\n".join([*([INVERTED] if "inverted" in text else []), *made])
    return "\n".join(one for one in (word_routines.routines(text), own) if one)


# ------------------------------------------------------------------------------ the same in Python


class Far:
    def __init__(self) -> None:
        self.bits = 0


@dataclass(frozen=True)
class Reciprocal:
    over: int
    root: int
    half: int


@dataclass(frozen=True)
class Inverted:
    over: int
    by: int


@dataclass(frozen=True)
class Scaled:
    mantissa: int
    exponent: int


NEAR = [int(one, 16) for one in re.findall(r"0x[0-9a-f]+", word_routines.line())]
UNSIGNED = 0xffffffff


def signed(word: int) -> int:
    word &= UNSIGNED
    return word - (1 << 32) if word >> 31 else word


def upper(a: int, b: int) -> int:
    return (a * b) >> 32


def wide(c: int, x: int) -> int:
    return (c * (x >> 32)) + (c * (x & UNSIGNED) >> 32)


def rounded(a: int, by: int) -> int:
    return (a + (1 << (by - 1))) >> by


def held(a: int, far: Far) -> int:
    if -HALF_WORD <= a < HALF_WORD:
        return a
    far.bits |= SATURATED
    return -HALF_WORD + 1 if a < 0 else HALF_WORD - 1


def known(a: int) -> int:
    return a if -MOST <= a <= MOST else -MOST - 1


def placed(a: int, by: int, far: Far) -> int:
    if by > 62:
        return 0
    if by > 0:
        return held(rounded(a, by), far)
    most = 0 if by < -30 else (HALF_WORD - 1) >> -by
    return a << min(-by, 30) if abs(a) <= most else held(a << 31, far)


def leading(a: int) -> int:
    return 64 - a.bit_length()


def scaled(a: int, exponent: int) -> Scaled:
    if not a:
        return Scaled(0, 0)
    zeros = leading(abs(a))
    mantissa = abs(a) << zeros >> 33
    return Scaled(-mantissa if a < 0 else mantissa, exponent + 33 - zeros)


def inverse(u: int) -> int:
    d = (1 << 30) + abs(u)
    r = UNSIGNED // ((d + 0x4000) >> 15)
    return (r << 13) + (r * (((1 << 47) - d * r) >> 4) >> 30) + 1


def one_over(a: int, far: Far) -> Inverted:
    if not a:
        far.bits |= NO_VALUE
        return Inverted(HALF_WORD - 1, 30)
    zeros = leading(abs(a))
    over = inverse((abs(a) << zeros >> 33) - (1 << 30))
    return Inverted(-over if a < 0 else over, 93 - zeros)


def inverse_root(t: int) -> Reciprocal:
    high, low = t >> 32, t & UNSIGNED
    first, after = high or low + (not low), low if high else 0
    even = (32 - first.bit_length()) & ~1
    v = (first << even | after >> 1 >> (31 - even)) & UNSIGNED
    near = NEAR[(v >> 25) - 32]
    q = (near >> 16) - ((near & 0xffff) * (v >> 9 & 0xffff) >> 21)
    rest = signed(0x40000000 - (v * q * q >> 32))
    quarter = rest >> 2
    step = (0x80000000 + rest + (quarter * quarter * 3 >> 28)) & UNSIGNED
    over = (q << 16 & UNSIGNED) * step >> 32
    over -= over >> 31
    root = v * (over << 1 | 1) >> 32
    root -= root >> 31
    return Reciprocal(over, root, (even if high else even + 32) // 2)


def root_of(a: int, far: Far) -> Reciprocal:
    if a < 0:
        far.bits |= NO_VALUE
    return inverse_root(max(a, 0))


def over_root(r: Reciprocal) -> Inverted:
    return Inverted(r.over, 62 - r.half)


def phase(turns: int, by: int) -> int:
    return rounded(turns, by) & UNSIGNED


def large_phase(turns: int, by: int) -> int:
    return turns << by & UNSIGNED


def _horner(coefficients: Sequence[int], x: int) -> int:
    made = coefficients[-1]
    for one in coefficients[-2::-1]:
        made = one + upper(made, x)
    return made


def sine(turn: int) -> int:
    begun = (turn + 0x20000000) & UNSIGNED
    y = signed(((begun & 0x3fffffff) << 2) - 0x80000000)
    square = upper(y, y)
    made = _horner(COS, square) if begun & 0x40000000 else upper(_horner(SIN, square), y)
    return -made if begun & 0x80000000 else made


def exponential(a: int, fraction: int, far: Far) -> int:
    k = (a + 0x80000000) >> 32
    return placed(_horner(EXP, signed(a)), 30 - fraction - min(max(k, -200), 200), far)


def logarithm(a: int, fraction: int, far: Far) -> int:
    if a <= 0:
        far.bits |= NO_VALUE
    given = max(a, 1)
    zeros = leading(given)
    x = signed(((given << zeros >> 32 & UNSIGNED) << 1) - 0x80000000)
    return (63 - zeros - fraction) * LN_2 + _horner(LOG, x)


def angle(y: int, x: int) -> int:
    larger = max(abs(y), abs(x))
    if not larger:
        return 0
    zeros = leading(larger)
    a, b = abs(y) << zeros >> 33, abs(x) << zeros >> 33
    less, more = min(a, b), max(a, b)
    beyond = less > (more * TANGENT >> 32)
    sum_ = less + more if beyond else more
    by = sum_ >> 31
    over = inverse((sum_ >> by) - (1 << 30))
    q = rounded((less - more if beyond else less) * over, 28 + by)
    made = (upper(_horner(ATAN, upper(q, q)), q) + 1) >> 1
    made += QUARTER // 2 if beyond else 0
    made = QUARTER - made if a > b else made
    made = HALF - made if x < 0 else made
    return -made if y < 0 else made


def nearest(a: int, by: int) -> int:
    made = rounded(a, by)
    return made - (made & 1 if (a - (made << by)) * 2 == -(1 << by) else 0)


def remainder_of(a: int, b: int, far: Far) -> int:
    if not b:
        far.bits |= NO_VALUE
        return 0
    return abs(a) % abs(b) * (-1 if a < 0 else 1)


PYTHON: Mapping[str, Callable[..., Any]] = {
    "product": lambda a, b: a * b, "INT64_C": int, "UINT32_C": int, "narrowed": int, "absolute": abs,
    "within": lambda a, most: max(-most, min(most, a)), **{
        one.__name__: one for one in (upper, wide, rounded, held, known, placed, scaled, one_over, root_of, over_root, phase, large_phase,
                                      sine, exponential, logarithm, angle, nearest, remainder_of)}}
