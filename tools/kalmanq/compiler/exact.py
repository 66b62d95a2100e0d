"""A constant model's numbers to 50 digits, and what it settles to: the same on every host."""

from __future__ import annotations

import decimal
from dataclasses import dataclass, fields
from decimal import Decimal
from typing import Iterator

import numpy as np

from kalmanq.errors import KalmanqError
from kalmanq.model import Model

DIGITS = decimal.Context(prec=50)
DOUBLINGS = 60
SOLVED = Decimal("1e-30")  # of a covariance, relative


@dataclass(frozen=True)
class Numbers:
    """Of a model, as its C has them: arrays of Decimal; R: m variances.  `doubles` makes arrays of float64 of them."""

    A: np.ndarray
    B: np.ndarray
    H: np.ndarray
    Q: np.ndarray
    R: np.ndarray
    x0: np.ndarray
    P0: np.ndarray

    @property
    def n(self) -> int:
        return len(self.A)

    @property
    def m(self) -> int:
        return len(self.H)

    @property
    def l(self) -> int:
        return self.B.shape[1]

    def doubles(self) -> Numbers:
        return Numbers(*(getattr(self, field.name).astype(float) for field in fields(self)))


@dataclass(frozen=True)
class Settled:
    """predicted, filtered: n x n; gain: n x m; variance: m x m, of the innovation"""

    predicted: np.ndarray
    filtered: np.ndarray
    gain: np.ndarray
    variance: np.ndarray


def numbers(model: Model, single: bool) -> Numbers:
    """single: each rounded to a float first, as it will be a literal of the C."""
    def made(array: np.ndarray) -> np.ndarray:
        values = array.astype(np.float32).astype(np.float64) if single else array
        return decimals(values)

    B = np.zeros((model.n, 0)) if model.B is None else model.B
    return Numbers(made(model.A), made(B), made(model.H), made(model.Q), made(np.diag(model.R)), made(model.x0),
                   made(model.P0))


def decimals(array: np.ndarray) -> np.ndarray:
    made = np.empty(array.shape, object)
    for place, value in np.ndenumerate(array):
        made[place] = Decimal(float(value))
    return made


def eye(n: int) -> np.ndarray:
    return decimals(np.eye(n))


def inverse(matrix: np.ndarray) -> np.ndarray:
    """By Gauss and Jordan, with pivots of a column."""
    n = len(matrix)
    work = np.concatenate([matrix.copy(), eye(n)], axis=1)
    for k in range(n):
        best = max(range(k, n), key=lambda i: abs(work[i, k]))
        if not work[best, k]:
            raise KalmanqError("a matrix is singular")
        work[[k, best]] = work[[best, k]]
        work[k] = work[k] / work[k, k]
        for i in range(n):
            if i != k and work[i, k]:
                work[i] = work[i] - work[i, k] * work[k]
    return work[:, n:]


def predicted(of: Numbers, P: np.ndarray) -> np.ndarray:
    return symmetric(of.A @ P @ of.A.T + of.Q)


def updated(of: Numbers, P: np.ndarray) -> np.ndarray:
    for j in range(of.m):
        P = taken(of, P, j)
    return P


def taken(of: Numbers, P: np.ndarray, j: int) -> np.ndarray:
    """After component j alone"""
    row = P @ of.H[j]
    return symmetric(P - np.outer(row, row) / (of.H[j] @ row + of.R[j]))


def symmetric(P: np.ndarray) -> np.ndarray:
    return (P + P.T) / 2


def settled(of: Numbers) -> Settled:
    """Solves the Riccati equation by structured doubling (Anderson 1978; Chu and others 2005)."""
    A, G, X = of.A.T, of.H.T @ np.diag(1 / of.R) @ of.H, of.Q
    for _ in range(DOUBLINGS):
        W = inverse(eye(of.n) + G @ X)
        A, G, X, last = A @ W @ A, symmetric(G + A @ W @ G @ A.T), symmetric(X + A.T @ X @ W @ A), X
        if distance(X, last) < SOLVED:
            break
    else:
        raise KalmanqError("the covariance does not settle: what is not measured, or not driven, does not decay "
                           "(kalmanq check says which direction)")
    variance = of.H @ X @ of.H.T + np.diag(of.R)
    gain = X @ of.H.T @ inverse(variance)
    filtered = updated(of, X)
    if distance(predicted(of, filtered), X) > Decimal("1e-25"):
        raise KalmanqError("the covariance does not settle: its equation has no solution to 25 digits")
    return Settled(X, filtered, gain, variance)


def root(P: np.ndarray) -> np.ndarray:
    """Upper triangular S with S S' = P; a pivot that is 0 leaves its column 0."""
    n, rest, S = len(P), P.copy(), decimals(np.zeros(P.shape))
    for j in reversed(range(n)):
        S[j, j] = rest[j, j].sqrt() if rest[j, j] > 0 else Decimal(0)
        for i in range(j):
            S[i, j] = rest[i, j] / S[j, j] if S[j, j] else Decimal(0)
        rest = rest - np.outer(S[:, j], S[:, j])
    return S


def distance(P: np.ndarray, reference: np.ndarray) -> Decimal:
    """The largest |difference| over sigma_i sigma_j of the reference; 0 where a sigma is 0."""
    sigma = [value.sqrt() if value > 0 else Decimal(0) for value in np.diag(reference)]
    worst = Decimal(0)
    for i, j in upper(len(P)):
        scale = sigma[i] * sigma[j]
        difference = abs(P[i, j] - reference[i, j])
        if scale:
            worst = max(worst, difference / scale)
        elif difference:
            return Decimal(1)
    return worst


def upper(n: int) -> Iterator[tuple[int, int]]:
    return ((i, j) for i in range(n) for j in range(i, n))


def rows_to_settle(of: Numbers, state: Settled, max_gap: int, tolerance: Decimal, most: int) -> int:
    """Measured rows after which P is within the tolerance of what it settles to, from the start and from a gap."""
    gap = state.filtered
    for _ in range(max_gap):
        gap = predicted(of, gap)
    return max(_rows_from(of, P, state.filtered, tolerance, most) for P in (of.P0, gap))


def _rows_from(of: Numbers, P: np.ndarray, aim: np.ndarray, tolerance: Decimal, most: int) -> int:
    P = updated(of, P)
    for count in range(1, most + 1):
        if distance(P, aim) < tolerance:
            return count
        P = updated(of, predicted(of, P))
    raise KalmanqError(f"the covariance takes more than {most} rows to settle")
