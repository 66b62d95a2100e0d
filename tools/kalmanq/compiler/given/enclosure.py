"""How many full samples until the covariance is known, whatever happened before: without an enumeration.

A step (predict, then all components of a sample) maps the covariance P to E P (I + G P)^-1 E' + Q.  Such maps compose,
so the map of k steps is made by doubling.  They keep the order of covariances: k full samples after any past, gaps and
partial samples in any order, P is between what P = 0 and what P = C I becomes,

    Q_k  and  Q_k + E_k (G_k + I / C)^-1 E_k',

where C is beyond every covariance that a float holds.  Where both agree the gain is a constant.
"""

from __future__ import annotations

import decimal
from dataclasses import dataclass
from decimal import Decimal
from typing import Callable, Optional, Sequence

import numpy as np

from kalmanq.compiler.given.exact import Numbers, decimals, eye, inverse, symmetric
from kalmanq.errors import KalmanqError

DIGITS = decimal.Context(prec=90, Emax=decimal.MAX_EMAX, Emin=decimal.MIN_EMIN)  # what grows unseen grows far
BEYOND = Decimal("1e40")  # > n times the largest float
MOST = 17  # doublings until which a covariance has to settle: 131072 samples
MORE = 4  # doublings after which the steady covariance is exact
NEGLIGIBLE = 1e-12  # of a sigma
GONE = Decimal("1e-40")  # of its first variance: a state without noise whose variance fades away


@dataclass(frozen=True)
class Map:
    """P -> E P (I + G P)^-1 E' + Q"""

    E: np.ndarray
    G: np.ndarray
    Q: np.ndarray

    def then(self, b: Map) -> Map:
        W = inverse(eye(len(self.E)) + self.Q @ b.G)
        T = b.E @ W
        return Map(T @ self.E, symmetric(self.G + self.E.T @ b.G @ W @ self.E), symmetric(b.Q + T @ self.Q @ b.E.T))

    def of(self, P: np.ndarray) -> np.ndarray:
        return symmetric(self.E @ P @ inverse(eye(len(P)) + self.G @ P) @ self.E.T + self.Q)

    @property
    def width(self) -> np.ndarray:
        """Of each variance: what it is at most above that of P = 0.  No difference is taken."""
        spread = self.E @ inverse(self.G + eye(len(self.E)) / BEYOND) @ self.E.T
        return np.diag(spread)


@dataclass(frozen=True)
class Settled:
    """What the covariance settles to.

    samples    full ones, after which it has settled whatever happened before
    after_gap  full samples after a gap of 1, 2, ... samples that began settled
    tolerance  of variances, relative: how far from the steady ones they are at most then
    """

    samples: int
    after_gap: Sequence[int]
    tolerance: float
    filtered: np.ndarray
    predicted: np.ndarray
    gain: np.ndarray  # n x m
    variances: np.ndarray  # m, of innovations, each given the components before it
    lower: np.ndarray  # m x m, unit: innovations = lower * those given the components before

    @property
    def gains(self) -> list[np.ndarray]:
        return [self.gain.astype(float)]

    @property
    def means(self) -> np.ndarray:
        """Variances of the n means"""
        return np.diag(self.filtered).astype(float)

    @property
    def gain_that_moves(self) -> np.ndarray:
        """The gain in double; 0 where an innovation of one sigma moves a state by next to nothing"""
        gain, sigma = self.gain.astype(float), np.sqrt(self.means.clip(1e-300))
        moved = np.abs(gain) * np.sqrt(self.variances.astype(float)) / sigma[:, None]
        return np.where(moved < NEGLIGIBLE, 0, gain)


def steps(of: Numbers, samples: Sequence[Sequence[int]]) -> tuple[Map, list[Map]]:
    """Of a predict, and of a predict with a sample of such components after it"""
    nothing = decimals(np.zeros((of.n, of.n)))
    predict = Map(of.A, nothing, of.Q)
    return predict, [predict.then(Map(eye(of.n), of.H[one].T @ np.diag(1 / of.R[one]) @ of.H[one], nothing)) for one in samples]


def doublings(step: Map, count: int = MOST) -> list[Map]:
    """Of 1, 2, 4, ... steps"""
    made = [step]
    for _ in range(count):
        made.append(made[-1].then(made[-1]))
    return made


def settled(of: Numbers, longest_gap: int, tolerance: float = 1e-6) -> Optional[Settled]:
    """None: it does not settle within 131072 samples (a bias that nothing moves, a direction that nothing sees)"""
    with decimal.localcontext(DIGITS):
        predict, (step,) = steps(of, [range(of.m)])
        floor = np.diag(of.P0) * GONE
        try:
            doubled = doublings(step)
            if not is_within(doubled[-1], tolerance, floor):
                return None
        except (KalmanqError, decimal.DecimalException):
            return None  # what nothing sees has grown beyond all digits
        samples = least_steps(doubled, lambda one: is_within(one, tolerance, floor))
        filtered = doublings(doubled[-1], MORE)[-1].Q
        rest = _rests(predict, doubled, filtered, longest_gap, tolerance, floor, samples)
        return _steady(of, filtered, samples, rest, tolerance)


def is_within(one: Map, tolerance: float, floor: np.ndarray) -> bool:
    return _agree(one.width, np.diag(one.Q), tolerance, floor)


def _agree(difference: np.ndarray, variance: np.ndarray, tolerance: float, floor: np.ndarray) -> bool:
    limit = Decimal(tolerance)
    return all(abs(d) <= limit * max(v, least) or not d for d, v, least in zip(difference, variance, floor))


def least_steps(doubled: Sequence[Map], is_enough: Callable[[Map], bool]) -> int:
    """The least number of steps whose map is enough, by halves; the largest of `doubled` is."""
    now, count = None, 0
    for k in range(len(doubled) - 2, -1, -1):
        trial = doubled[k] if now is None else now.then(doubled[k])
        if not is_enough(trial):
            now, count = trial, count + (1 << k)
    return count + 1


def _rests(predict: Map, doubled: Sequence[Map], P: np.ndarray, longest: int, tolerance: float, floor: np.ndarray, samples: int) -> list[int]:
    """After each gap the least number of steps, by halves; `samples` are enough whatever was before"""
    made, missed = [], P
    aim = np.diag(P)
    for _ in range(longest):
        now = missed = predict.of(missed)
        count = 0
        for k in reversed(range((samples - 1).bit_length())):
            trial = doubled[k].of(now)
            if not _agree(np.diag(trial) - aim, aim, tolerance, floor):
                now, count = trial, count + (1 << k)
        made.append(min(count + 1, samples))
    return made


def _steady(of: Numbers, filtered: np.ndarray, samples: int, rest: Sequence[int], tolerance: float) -> Settled:
    predicted, gain, pivots, lower = sampled(of, filtered, range(of.m))
    return Settled(samples, rest, tolerance, filtered, predicted, gain, pivots, lower)


def sampled(of: Numbers, P: np.ndarray, some: Sequence[int]) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Of a step from P and a sample of these components: what is predicted, the gain, variances of innovations given those before them,
    and their unit lower triangle"""
    predicted, H = symmetric(of.A @ P @ of.A.T + of.Q), of.H[some]
    variance = H @ predicted @ H.T + np.diag(of.R[some])
    lower, pivots = unit_lower(variance)
    return predicted, predicted @ H.T @ inverse(variance), pivots, lower


def unit_lower(S: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """L and d with S = L diag(d) L'"""
    m, L, rest = len(S), eye(len(S)), S.copy()
    pivots = np.empty(m, object)
    for k in range(m):
        pivots[k] = rest[k, k]
        L[k + 1:, k] = rest[k + 1:, k] / rest[k, k]
        rest = rest - np.outer(L[:, k], L[:, k]) * pivots[k]
    return L, pivots
