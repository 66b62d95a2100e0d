"""Where the binary points of q31 are.

Row i of the factor S, P = S S', has words of 2^(exponent_i - 30).  A rotation keeps a row's length, which is sigma_i, so
no entry of row i is ever beyond the largest sigma_i: its exponent is a constant.  A predict that would go beyond that
is not stored.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from decimal import Decimal
from typing import Optional, Sequence, Union

import numpy as np

from kalmanq.compiler.algorithm.cycle import Cycle
from kalmanq.compiler.given.enclosure import Settled
from kalmanq.compiler.given.exact import Numbers, joseph
from kalmanq.compiler.given.request import Request
from kalmanq.errors import KalmanqError
from kalmanq.firmware.ranges import with_ranges
from kalmanq.model import Model, Quantity

ROOM = 1.01  # of a sigma
BITS = 30  # of the largest sigma
TURNED = 1.4  # of 2^30: the longest row that a reflection takes
WEIGHED = 20  # bits of an innovation over its sigma after the point; so it is taken up to 2^11
FINE, FINER = 12, 15  # bits of an innovation's sigma after the point, with the constant gain
MORE, LOW_NOISE = 12, 2.0**8  # further bits; sigma of H x over that of the noise, above which they count
FAR = 14  # bits of an innovation over the noise, up to which Student's weight falls
CYCLES, LEAST_GAP, GAP, WITHOUT_BOUND = 100, 16, 60, 2.0 ** 12
LONGEST, WIDE = 62, 61  # bits of a sum, and of a mean at the end of its range
NONE = -60  # exponent of 0


@dataclass(frozen=True)
class Formats:
    """exponent  of rows of S; held: the power of two beyond which a sigma is not stored
    row       exponent of H_j S and of the innovation's sigma; far: that of what Student's weight is worked out from
    least     variances that components are taken with, the least that Student's weight makes of them
    weighed   bits after the point of an innovation over its sigma; more: further ones, where R is far below H P H'
    x, z, u   fractions; end: x stays within 2^end; z_most, u_most: ranges in words
    read      fractions of means of 32 bits
    wide, y   fractions of innovations: of 64 bits; of 32 bits, with the constant gain; is_narrow: it may be beyond"""

    exponent: Sequence[int]
    held: Sequence[int]
    row: Sequence[int]
    far: Sequence[int]
    least: Sequence[float]
    weighed: Sequence[int]
    more: Sequence[int]
    x: Sequence[int]
    end: Sequence[int]
    read: Sequence[int]
    z: Sequence[int]
    u: Sequence[int]
    z_most: Sequence[int]
    u_most: Sequence[int]
    wide: Sequence[int]
    y: Sequence[int]
    is_narrow: Sequence[bool]


class RawValues:
    """Of quantities whose fractions are constants"""

    def fraction(self, which: str, k: int) -> int:
        raise NotImplementedError

    def format_of(self, which: str, k: int) -> str:
        return f"Q{31 - self.fraction(which, k)}.{self.fraction(which, k)}"

    def raw(self, which: str, k: int, value: float) -> int:
        """Of a value; a measurement that is beyond its word is missing."""
        word = math.floor(math.ldexp(value, self.fraction(which, k)) + 0.5) if math.isfinite(value) else 2**31
        is_there = abs(word) < 2**31
        return word if is_there else -2**31 if which == "measurements" or value < 0 else 2**31 - 1

    def fractions(self, which: str, count: int) -> np.ndarray:
        return np.array([self.fraction(which, k) for k in range(count)], int)

    def raws(self, which: str, values: np.ndarray) -> np.ndarray:
        """`raw` of rows, as float64"""
        words = np.floor(np.ldexp(values, self.fractions(which, values.shape[1])) + 0.5)
        ends = np.where((which == "measurements") | (values < 0), -2.0**31, 2.0**31 - 1)
        return np.where(np.abs(words) < 2.0**31, words, ends)

    def literal(self, value: float) -> str:
        return str(int(value)) if value > -2**31 else "INT32_MIN"


def up(value: float) -> int:
    """The least k with value <= 2^k"""
    if value <= 0:
        return NONE
    fraction, k = math.frexp(value)
    return k - 1 if fraction == 0.5 else k


def down(value: float) -> int:
    """The most k with 2^k <= value, value > 0"""
    return math.frexp(value)[1] - 1


def largest_sigmas(of: Numbers, gap: int, steady: Optional[Settled] = None) -> np.ndarray:
    """Of n states.  By the order of covariances the worst past is one full sample after each gap, from the start on.  A
    sigma that grows without end stops at some thousand times what the first gap makes of it.  One that still grows after
    all those cycles has its gap from the steady state on, if there is one."""
    of = of.doubles()
    P, most, first = of.P0, np.diag(of.P0).copy(), np.zeros(of.n)
    for cycle in range(CYCLES):
        before = most
        for _ in range(gap + 1):
            P = of.A @ P @ of.A.T + of.Q
            most = np.maximum(most, np.diag(P))
        first = most if not cycle else first
        if np.all(most <= before * 1.0001) or np.any(most > first * WITHOUT_BOUND ** 2):
            break
        for h, r in zip(of.H, of.R):
            P = joseph(P, h, r)
    else:
        P = steady.filtered.astype(float) if steady else P
        for _ in range(gap + 1):
            P = of.A @ P @ of.A.T + of.Q
            most = np.maximum(most, np.diag(P))
    return np.sqrt(np.minimum(most, first * WITHOUT_BOUND ** 2))


def gap_of(model: Model) -> int:
    """Samples that may be missing before a sigma is held"""
    return max(LEAST_GAP, 4 * model.gaps.max_gap if model.gaps.max_gap else GAP)


def ranged(model: Model, sigma: np.ndarray) -> Model:
    """With a range for all that has none: as `kalmanq design` chooses it, or else some thousand sigmas"""
    try:
        return with_ranges(model, [])[0]
    except KalmanqError:
        pass
    states = [_with_range(one, 2.0**10 * s + abs(x)) for one, s, x in zip(model.states, sigma, model.x0)]
    spans = np.abs(model.H) @ [one.range for one in states] + 8 * np.sqrt(np.diag(model.R)) + _offsets(model)
    return model.changed(states=states, measurements=[_with_range(one, s) for one, s in zip(model.measurements, spans)],
                         controls=[_with_range(one, 2.0**15) for one in model.inputs])


def _offsets(model: Model) -> np.ndarray:
    return np.zeros(model.m) if model.d is None else np.abs(model.d)


def _with_range(one: Quantity, span: float) -> Quantity:
    return one if one.range else Quantity(one.name, one.unit, 2.0 ** up(max(float(span), 1e-30)), one.fraction)


def formats(given: Request, model: Model, settled: Union[Settled, Cycle, None], gains: Sequence[np.ndarray],
            sigma: np.ndarray) -> Formats:
    """model: with all ranges; gains: all constant ones"""
    of = given.of.doubles()
    if not np.all(np.isfinite(sigma)):
        raise _too_far(model, of, sigma)
    held = [up(one * ROOM) for one in sigma]
    limit = 2.0 ** np.array(held)
    grown = (np.abs(of.A) @ limit + np.sqrt(np.diag(of.Q))) / TURNED
    exponent = [max(h, up(one)) for h, one in zip(held, grown)]
    spread = np.abs(of.H) @ limit
    row = [up(math.sqrt(s * s + r) * ROOM) for s, r in zip(spread, of.R)]
    ends = [_end(one, x) for one, x in zip(model.states, of.x0)]
    u = [_fraction(one, 31, one.range) for one in model.controls]
    ends_of = 2.0 ** np.array(ends)
    moved = ends_of + np.abs(of.A - np.eye(of.n)) @ ends_of + np.abs(of.B) @ (2.0 ** (31 - np.array(u, int)))
    spans = np.abs(given.mixing) @ ([one.range for one in model.measurements] + _offsets(model))
    reach = np.abs(of.H) @ moved
    z = [_measured(*one) for one in zip(model.measurements, spans, reach)]
    most = reach + np.abs(given.mixing) @ (2.0 ** (31 - np.array(z)))  # of any word
    wide = [min(LONGEST - up(one * ROOM), f + 31) for one, f in zip(most, z)]
    least = [r * share_of(given.options.student) for r in of.R]
    far = [max(a, BITS - f, min(up((span + one) * ROOM), up(math.sqrt(r)) + FAR))
           for a, f, span, one, r in zip(row, wide, spans, reach, of.R)]
    weighed = [min(WEIGHED, f + a - half_of(variance_word(r, 2 * a)) - 1) for f, a, r in zip(wide, row, least)]
    y = [_settled(spans[j] + reach[j], settled.variances[j], z[j]) for j in range(of.m)] if settled else z
    x = _means(gains, exponent, ends, moved, y, weighed)
    more = [_more(f + a - half_of(variance_word(r, 2 * a)) - 1 - v, 2.0**a / math.sqrt(r))
            for f, a, r, v in zip(wide, row, least, weighed)]
    if any(f + e < 1 or a - h >= BITS for f, e, a, h in zip(x, ends, exponent, held)):
        raise _too_far(model, of, sigma)
    return Formats(exponent, held, row, far, least, weighed, more, x, [f + e for f, e in zip(x, ends)],
                   [_read(one, end, f) for one, end, f in zip(model.states, ends, x)], z, u,
                   _most(model.measurements, z), _most(model.controls, u), wide, y,
                   [(span + one) * ROOM * 2.0**f >= 2.0**31 for span, one, f in zip(spans, reach, y)])


def _too_far(model: Model, of: Numbers, sigma: np.ndarray) -> KalmanqError:
    """What has the range that is farthest from its sigma, or the state that a step moves farthest"""
    step = np.abs(of.A) @ sigma / sigma
    i = int(np.argmax(np.where(np.isfinite(step), step, np.inf)))
    moved = np.where(of.B == 0, np.inf, sigma[:, None] / np.where(of.B == 0, 1, np.abs(of.B))).min(axis=0)
    given = [*((one, max(one.range, abs(x)), s) for one, x, s in zip(model.states, of.x0, sigma)),
             *((one, one.range, s) for one, s in zip(model.measurements, np.abs(of.H) @ sigma + np.sqrt(of.R))),
             *((one, one.range, s) for one, s in zip(model.controls, moved))]
    apart = [max(span / s, s / span) if 0 < s < math.inf else 0.0 for _, span, s in given]
    one, span, s = given[int(np.argmax(apart))]
    if not step[i] < max(apart):
        j = int(np.argmax(np.abs(of.A[i])))
        return KalmanqError(f"A[{i},{j}]: is {of.A[i, j]:g}, and the sigma of {model.states[i].name} grows by more in a step, or in a gap, than 32 bits "
                            "span: correct A, or take --arith f64")
    return KalmanqError(f"{one.name}: its range{' or x0' if one in model.states else ''} is {span:g}, and one sigma of it, or of what it moves, is "
                        f"{s:.3g}: 32 bits do not span both; correct the one or the other, or take --arith f32")


def _end(one: Quantity, x0: float) -> int:
    return up(max(one.range or 0, abs(x0)) * (1 + 1e-6))


def _fraction(one: Quantity, bits: int, span: float) -> int:
    """As declared, or as fine as so many bits hold"""
    most = 31 - up(one.range or 0)
    if one.fraction is not None:
        return _declared(one)
    made = min(most, bits - up(span))
    return made - int(bool(one.range) and one.range * 2.0 ** made >= 2.0 ** 31)  # its end is a raw value, too: 2^31 is none


def _declared(one: Quantity) -> int:
    made = one.fraction or 0
    if one.range and not 1 <= one.range * 2.0**made < 2.0**31:
        needs, cure = ("more integer bits", "a smaller range, or fewer") if one.range * 2.0**made > 1 else ("more bits of fraction", "a larger range, or more")
        raise KalmanqError(f"{one.name}: {one.range:g} does not fit Q{31 - made}.{made}: it needs {needs}: declare {cure} bits of fraction")
    return made


def _read(one: Quantity, end: int, x: int) -> int:
    return _declared(one) if one.fraction is not None else min(30 - end, x - 1)


def _most(quantities: Sequence[Quantity], fractions: Sequence[int]) -> list[int]:
    return [min(int(one.range * 2.0 ** f), 2**31 - 1) for one, f in zip(quantities, fractions)]


def _measured(one: Quantity, span: float, reach: float) -> int:
    """A measurement's fraction, with room for the innovation if that takes 3 bits at most"""
    fits = up((span + reach) * ROOM) <= up(span * ROOM) + 3
    return _fraction(one, 31, (span + reach if fits else span) * ROOM)


def _settled(span: float, variance: Union[Decimal, float], z: int) -> int:
    """Of the innovation with the constant gain: the measurement's where that is 2^-11 sigma, or else 2^-15 sigma, if need be with an
    end at 2^16 sigma"""
    fits, sigma = 31 - up(span * ROOM), up(math.sqrt(variance))
    return z if fits >= z >= FINE - sigma else max(fits, FINER - sigma)


def _more(most: int, ratio: float) -> int:
    return max(0, min(MORE, most)) if ratio > LOW_NOISE else 0


def share_of(student: Optional[float]) -> float:
    """The least variance that a measurement with Student's noise is taken with, of its own"""
    return student / (student + 1) if student else 1.0


def variance_word(r: float, square: int) -> int:
    return max(1, round(math.ldexp(r, 2 * BITS - square)))


def half_of(square: int) -> int:
    """As inverse_root has it"""
    return (64 - square.bit_length()) // 2


def root_of(square: int) -> tuple[int, int]:
    """Mantissa and `half` of its root"""
    half = half_of(square)
    return math.isqrt(square << 2 * half) >> 1, half


def _means(gains: Sequence[np.ndarray], exponent: Sequence[int], ends: Sequence[int], moved: np.ndarray,
           y: Sequence[int], weighed: Sequence[int]) -> list[int]:
    """No sum goes beyond 64 bits, and what an update adds needs no shift to the left."""
    made = []
    for i, end in enumerate(ends):
        most = min(WIDE - end, LONGEST - up(moved[i] * ROOM), min(weighed) + BITS - exponent[i])
        for gain in gains:
            far = float(np.abs(gain[i]) @ 2.0 ** (31 - np.array(y, int)))
            most = min(most, LONGEST - up(far * ROOM)) if far > 0 else most
        made.append(most)
    return made
