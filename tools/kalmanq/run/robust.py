"""Updates for noise that is not Gaussian: the losses of robust.h, and the limits of a gate."""

from __future__ import annotations

import math
from dataclasses import dataclass
from statistics import NormalDist
from typing import Any, Optional, Sequence

import numpy as np

from kalmanq.core import Arithmetic, lib
from kalmanq.errors import KalmanqError

LEVELS = {0.9: lib.KQ_LEVEL_90, 0.95: lib.KQ_LEVEL_95, 0.99: lib.KQ_LEVEL_99, 0.999: lib.KQ_LEVEL_999,
          0.9999: lib.KQ_LEVEL_9999}
FINEST = 2.0**24  # a limit of q31 is in Q39.24


@dataclass(frozen=True)
class Loss:
    """A loss of robust.h, kq_loss_NAME: what commands and pages say of it.

    usual     its parameter; of a gate the probability that a good measurement passes
    shown     the parameter in messages and, of a filter without the library, on pages; of a gate in sigma
    least     of a parameter, in sigma if it is a gate's; 0 and a gate's 1 are too little
    letter    of the parameter
    is_alone  C without the library has it, too
    """

    usual: float
    shown: float
    least: float
    letter: str
    is_alone: bool
    title: str
    note: str


LOSSES = {
    "gate": Loss(0.9999, 4.0, 1.0, "K", True, "gate", "Leaves out what is more than K sigma off."),
    "huber": Loss(3.0, 3.0, 0.0, "K", False, "Huber", "Counts a row beyond K sigma less."),
    "student": Loss(10.0, 10.0, 2.0**-20, "NU", True, "Student t", "Heavy tails with NU degrees of freedom."),
    "jump": Loss(9.0, 9.0, 1.0, "G", False, "jump", "Raises the covariance where a row says that the state has jumped: e^2 above G S."),
}
ALONE = tuple(name for name, one in LOSSES.items() if one.is_alone)


@dataclass(frozen=True)
class Robust:
    """An update for noise that is not Gaussian: a loss of robust.h, which says which to take.

    While something of an unknown start is still unknown, measurements are taken as they are.

    Parameters
    ----------
    way : "gate": what a sensor tells in a row is not taken if it is too far off, for as many components as it has; each sensor has a gate;
        "huber", "student": it counts less; "jump": the covariance is raised
    parameter : gate: the probability that a good measurement passes (0.9, 0.95, 0.99, 0.999, 0.9999), or above 1 how many sigma a
        single one may be off, with that limit's probability for rows of several;
        k of Huber in sigma, nu of Student, g of jump; None: what is usual
    run : gate: after so many rejections in a row one is taken; 65535: never

    Raises
    ------
    KalmanqError
        another way, or a parameter that it does not have

    Examples
    --------
    >>> z = [0.0] * 9 + [99.0]
    >>> float(kalmanq.Filter(kalmanq.Model([1], H=[1], R=1, Q=1, P0=1)).run(z, robust=kalmanq.Robust("gate", 4)).mean[-1, 0])
    0.0
    """

    way: str
    parameter: Optional[float] = None
    run: int = 8

    def __post_init__(self) -> None:
        if self.way not in LOSSES:
            raise KalmanqError(f"there is no robust {self.way!r}: {', '.join(LOSSES)}")
        if self.way == "gate" and self.value not in LEVELS and not 1 < self.value < math.inf:
            raise KalmanqError(f"a gate's level is one of {', '.join(map(str, LEVELS))}, or above 1: in sigma")
        of = LOSSES[self.way]
        if self.way != "gate" and not (of.least <= self.value < math.inf and self.value > 0):
            raise KalmanqError(f"{self.way}: {self.value:g} is not a parameter: give {'1 or more' if of.least == 1 else 'one above 0'}, "
                               f"usually {of.usual:g}")

    @property
    def value(self) -> float:
        return LOSSES[self.way].usual if self.parameter is None else self.parameter

    @property
    def sigmas(self) -> float:
        """Of a gate: how far off a single measurement may be"""
        return self.value if self.value > 1 else round(NormalDist().inv_cdf((1 + self.value) / 2), 4)

    def limits(self, of: Arithmetic, count: int) -> list[float]:
        """Of a gate: of the NIS of 1 to `count` components, as scores"""
        if self.value in LEVELS:
            return [of.function("chi_square_limit")(m, LEVELS[self.value]) for m in range(1, count + 1)]
        made = [limit_of(self.value, m) for m in range(1, count + 1)]
        return [min(round(one * FINEST), 2**63 - 1) for one in made] if of.is_fixed else made


class Losses:
    """The losses of one filter, as C has them.  A gate's count of rejections goes on from call to call.

    sizes   measurements of each sensor: each has a gate
    """

    def __init__(self, arithmetic: Arithmetic, sizes: Sequence[int]):
        self.arithmetic, self.sizes = arithmetic, sizes
        self._made: dict[Robust, Taking] = {}

    def of(self, robust: Robust) -> Taking:
        if robust not in self._made:
            a, is_gate = self.arithmetic, robust.way == "gate"
            sizes = self.sizes if is_gate else [sum(self.sizes)]
            losses = a.losses(robust.way, len(sizes))
            for one in losses:
                if is_gate:
                    one.run = robust.run
                else:
                    one.parameter = a.parameter(robust.value)
            limits = np.array(robust.limits(a, max(sizes)), a.score) if is_gate else None
            self._made[robust] = Taking(losses, np.array(bits_of(sizes), np.uint32), limits)
        return self._made[robust]

    def copy(self) -> Losses:
        """For a filter that goes on from the same row"""
        made = Losses(self.arithmetic, self.sizes)
        for robust, one in self._made.items():
            for own, given in zip(made.of(robust).losses, one.losses):
                own.rejected = given.rejected
        return made


@dataclass(frozen=True)
class Taking:
    """losses: one or, of gates, one for each sensor; measured: by each of them, bits of a row; limits: of gates, of the NIS of 1, 2, ... components"""

    losses: Any
    measured: np.ndarray
    limits: Optional[np.ndarray]


def bits_of(sizes: Sequence[int]) -> list[int]:
    """Of each sensor's measurements in a row of all"""
    ends = np.cumsum(sizes).tolist()
    return [(1 << end) - (1 << end - size) for end, size in zip(ends, sizes)]


def limit_of(sigmas: float, count: int) -> float:
    """What chi-square of `count` is above as seldom as a Gaussian is so many sigma off"""
    low = high = sigmas**2
    wanted = _log_tail(low, 1)
    while _log_tail(high, count) > wanted:
        low, high = high, 2 * high
    while low < (middle := (low + high) / 2) < high:
        low, high = (middle, high) if _log_tail(middle, count) > wanted else (low, middle)
    return high


def _log_tail(x: float, count: int) -> float:
    """The logarithm of the probability that chi-square is above x: powers of x / 2 over their factorials, times exp(-x / 2)"""
    half, first = x / 2, 0.5 * (count % 2)
    term, total = (half**first / math.gamma(1 + first) if first else 1.0), 0.0
    for k in range(count // 2):
        total += term
        term *= half / (k + 1 + first)
    return -half + math.log(total + (_scaled_tail(half) if first else 0.0))


def _scaled_tail(half: float) -> float:
    """exp(half) erfc(sqrt(half))"""
    root = math.sqrt(half)
    if root < 20:
        return math.exp(half) * math.erfc(root)
    return (1 - 0.5 / half + 0.75 / half**2) / (root * math.sqrt(math.pi))
