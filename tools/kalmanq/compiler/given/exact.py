"""A constant model's numbers to 50 digits, and steps of its covariance: the same on every host."""

from __future__ import annotations

import decimal
from dataclasses import dataclass, fields
from decimal import Decimal
from functools import lru_cache
from typing import Sequence

import numpy as np

from kalmanq.errors import KalmanqError

DIGITS = decimal.Context(prec=50)


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


def ordered(of: Numbers, order: Sequence[int]) -> Numbers:
    """With its states in another order"""
    two = np.ix_(order, order)
    return Numbers(of.A[two], of.B[list(order)], of.H[:, list(order)], of.Q[two], of.R, of.x0[list(order)], of.P0[two])


def decimals(array: np.ndarray) -> np.ndarray:
    made = np.empty(array.shape, object)
    for place, value in np.ndenumerate(array):
        made[place] = Decimal(float(value))
    return made


def eye(n: int) -> np.ndarray:
    return _eye(n).copy()


@lru_cache(maxsize=None)
def _eye(n: int) -> np.ndarray:
    return decimals(np.eye(n))


def inverse(matrix: np.ndarray) -> np.ndarray:
    """By Gauss and Jordan, with pivots of a column."""
    n = len(matrix)
    work = np.concatenate([matrix.copy(), eye(n)], axis=1)
    for k in range(n):
        best = max(range(k, n), key=lambda i: abs(work[i, k]))
        if not work[best, k]:
            raise KalmanqError("a matrix is singular: give Q, R and P0 in units in which their sizes are nearer to each other")
        work[[k, best]] = work[[best, k]]
        work[k] = work[k] / work[k, k]
        for i in range(n):
            if i != k and work[i, k]:
                work[i] = work[i] - work[i, k] * work[k]
    return work[:, n:]


def predicted(of: Numbers, P: np.ndarray) -> np.ndarray:
    return symmetric(of.A @ P @ of.A.T + of.Q)


def joseph(P: np.ndarray, h: np.ndarray, r: float) -> np.ndarray:
    """In doubles, after a component with the row h and the variance r"""
    k = P @ h / (h @ P @ h + r)
    left = np.eye(len(P)) - np.outer(k, h)
    return left @ P @ left.T + r * np.outer(k, k)


def taken(of: Numbers, P: np.ndarray, j: int) -> np.ndarray:
    """After component j alone"""
    row = P @ of.H[j]
    return symmetric(P - np.outer(row, row) / (of.H[j] @ row + of.R[j]))


def symmetric(P: np.ndarray) -> np.ndarray:
    return (P + P.T) / 2


def keys(n: int) -> list[tuple[int, int]]:
    """Places of a factor's entries, column after column"""
    return [(i, j) for j in range(n) for i in range(j + 1)]


def root(P: np.ndarray) -> np.ndarray:
    """Upper triangular S with S S' = P; a pivot that is 0 leaves its column 0."""
    n, rest, S = len(P), P.copy(), decimals(np.zeros(P.shape))
    for j in reversed(range(n)):
        S[j, j] = rest[j, j].sqrt() if rest[j, j] > 0 else Decimal(0)
        for i in range(j):
            S[i, j] = rest[i, j] / S[j, j] if S[j, j] else Decimal(0)
        rest = rest - np.outer(S[:, j], S[:, j])
    return S
