"""Functions of functions.py in Python, bit for bit."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any, Callable, Mapping, Sequence

from kalmanq.compiler.algorithm.fixed import routines as word_routines
from kalmanq.compiler.algorithm.fixed.functions import ATAN, COS, EXP, HALF, LN_2, LOG, NO_VALUE, QUARTER, SATURATED, SIN, TANGENT, WORD

MOST, UNSIGNED = 2**31 - 1, 0xffffffff
NEAR = [int(one, 16) for one in re.findall(r"0x[0-9a-f]+", " ".join(word_routines.line()))]


class Far:
    """line: of the program, where it is watched; lacks: bits that a word had too few, by line"""

    def __init__(self) -> None:
        self.bits, self.line = 0, ""
        self.lacks: dict[str, int] = {}

    def saturate(self, a: int) -> None:
        self.bits |= SATURATED
        self.lacks[self.line] = max(self.lacks.get(self.line, 0), abs(a).bit_length() - WORD.bit_length() + 1)


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
    if -WORD <= a < WORD:
        return a
    far.saturate(a)
    return -WORD + 1 if a < 0 else WORD - 1


def known(a: int) -> int:
    return a if -MOST <= a <= MOST else -MOST - 1


def kept(a: int, far: Far) -> int:
    if abs(a) > MOST:
        far.bits |= NO_VALUE
    return known(a)


def placed(a: int, by: int, far: Far) -> int:
    if by > 62:
        return 0
    if by > 0:
        return held(rounded(a, by), far)
    most = 0 if by < -30 else (WORD - 1) >> -by
    return a << min(-by, 30) if abs(a) <= most else held(a << min(-by, 64), far)


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
        return Inverted(WORD - 1, 30)
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


SAME = (upper, wide, rounded, held, known, kept, placed, scaled, one_over, root_of, over_root, phase, large_phase, sine,
        exponential, logarithm, angle, nearest, remainder_of)
PYTHON: Mapping[str, Callable[..., Any]] = {
    "product": lambda a, b: a * b, "INT64_C": int, "UINT32_C": int, "narrowed": int, "absolute": abs,
    "within": lambda a, most: max(-most, min(most, a)), **{one.__name__: one for one in SAME}}
