"""The log-likelihood of records of a linear model, exact of an unknown start, and its slopes: the disturbance smoother in C (slopes.h)."""

from __future__ import annotations

from typing import NamedTuple, Optional, Sequence

import numpy as np

from kalmanq.core import ffi, lib, pointer_of
from kalmanq.data.rows import Rows
from kalmanq.model import Model

AGREES = 1e-7  # share of the log-likelihood by which the covariances here may be off from C's roots
ROUNDS = 1e-5  # the same of an unknown start: C's roots round where its first rows hardly determine it, the covariances do not
LEAST = 1e-9  # eigenvalue of the correlations of the start, given the records: rounding makes 1e-7 of it

class Steps(NamedTuple):
    """A and Q (k x n x n), B (k x n x l) of distinct steps"""

    A: np.ndarray
    Q: np.ndarray
    B: np.ndarray

    @classmethod
    def of(cls, A: np.ndarray, Q: np.ndarray, B: Optional[np.ndarray]) -> Steps:
        return cls(A, Q, np.zeros((*A.shape[:2], 0)) if B is None else B)


class Slopes(NamedTuple):
    """Of the log-likelihood, to each distinct step's A, Q and B, and to the rest; symmetric where what it is of is"""

    A: np.ndarray
    Q: np.ndarray
    B: np.ndarray
    H: np.ndarray
    R: np.ndarray
    x0: np.ndarray
    P0: np.ndarray

    @classmethod
    def none(cls, model: Model, steps: Steps) -> Slopes:
        return cls(*(np.zeros(one.shape) for one in (*steps, model.H, model.R, model.x0, model.P0)))


class Recorded:
    """A record, whose row t + 1 comes by step which[t]"""

    def __init__(self, rows: Rows, which: np.ndarray):
        self.rows, self.which = rows, np.ascontiguousarray(which, np.int64)
        self._z = np.ascontiguousarray(rows.net, float)
        self._u = None if rows.u is None else np.ascontiguousarray(rows.u, float)
        self._kept = np.empty(0)

    def log_likelihood(self, model: Model, steps: Steps, keeps: bool = False) -> float:
        """NaN: the covariance of a measurement is not positive definite, or the records hardly determine the start.
        keeps: what the slopes need

        Means have a column more for each unknown state, which is 1 in it."""
        unknown = model.unknown
        X = np.column_stack([np.where(unknown, 0.0, model.x0), np.eye(model.n)[:, unknown]])
        P = np.where(unknown | unknown[:, None], 0.0, model.P0)
        self._bind(model, steps, X, P, keeps)
        squares = np.zeros((X.shape[1], X.shape[1]))
        total = lib.kq_slopes_forwards(self._given, pointer_of(squares))
        spread, logarithm = _inverted(squares[1:, 1:])
        start = -spread @ squares[1:, 0]
        self._start, self._spread = np.concatenate([[1.0], start]), spread
        return float(total - (squares[0, 0] + squares[1:, 0] @ start + logarithm) / 2)

    def add_slopes(self, by: Slopes) -> None:
        """After a log_likelihood that keeps"""
        C = np.outer(self._start, self._start)
        C[1:, 1:] += self._spread
        mean = np.zeros((len(by.x0), len(C)))
        for name, array in (*zip(("by_A", "by_Q", "by_B", "by_H", "by_R"), by), ("by_mean", mean), ("by_P0", by.P0)):
            setattr(self._given, name, pointer_of(array))
        lib.kq_slopes_backwards(self._given, pointer_of(self._start), pointer_of(C))
        by.x0[:] += mean[:, 0]

    def _bind(self, model: Model, steps: Steps, X: np.ndarray, P: np.ndarray, keeps: bool) -> None:
        """A kq_slopes, and what it refers to"""
        length = lib.kq_slopes_kept(model.n, model.m, X.shape[1]) * (len(self.rows) if keeps else 1)
        if len(self._kept) < length:
            self._kept = np.empty(length)
        self._arrays = {name: np.ascontiguousarray(one, float) for name, one in (
            ("z", self._z), ("u", self._u), ("A", steps.A), ("Q", steps.Q), ("B", steps.B), ("H", model.H), ("R", model.R),
            ("mean", X), ("P0", P), ("kept", self._kept)) if one is not None}
        self._given = ffi.new("kq_slopes *", {
            "n": model.n, "m": model.m, "l": model.l, "columns": X.shape[1], "rows": len(self.rows), "keeps": keeps,
            "which": pointer_of(self.which), **{name: pointer_of(one) for name, one in self._arrays.items()}})


def recorded(model: Model, records: Sequence[Rows], is_flow: bool) -> tuple[list[Recorded], np.ndarray]:
    """Each record, and the distinct dt of its steps; is_flow: otherwise a row without a time is a step of the model's A and Q, of dt NaN"""
    of, made = model.continuous, []
    for rows in records:
        alike = of.dt if is_flow else np.nan
        made.append(np.full(len(rows) - 1, alike) if rows.times is None else of.between(rows.times))
    dt, which = np.unique(np.concatenate(made), return_inverse=True)
    ends = np.cumsum([len(one) for one in made])[:-1]
    return [Recorded(rows, one) for rows, one in zip(records, np.split(which, ends))], dt


def exact(model: Model, records: Sequence[Rows]) -> float:
    """The log-likelihood of an unknown start, in covariances, or NaN"""
    made, dt = recorded(model, records, False)
    if len(dt) == 0 or np.isnan(dt[-1]):
        if len(dt) > 1:
            return float("nan")
        steps = Steps.of(model.A[None], model.Q[None], None if model.B is None else model.B[None])
    else:
        steps = Steps.of(*model.continuous.steps(dt))
    return sum(one.log_likelihood(model, steps) for one in made)


def agrees(exact: float, filtered: float, is_unknown: bool) -> bool:
    """Is it what C's roots say, but for rounding?"""
    return abs(exact - filtered) < (ROUNDS if is_unknown else AGREES) * (1 + abs(exact))


def _inverted(W: np.ndarray) -> tuple[np.ndarray, float]:
    """Its inverse and the logarithm of its determinant; NaN where they would not be exact"""
    if not len(W):
        return W, 0.0
    with np.errstate(divide="ignore", invalid="ignore"):
        size = 1 / np.sqrt(np.diag(W))
        scaled = W * size[:, None] * size
    if not np.all(np.isfinite(scaled)):
        return np.full_like(W, np.nan), np.nan
    values, vectors = np.linalg.eigh(scaled)
    if not values[0] > LEAST:
        return np.full_like(W, np.nan), np.nan
    turned = size[:, None] * vectors
    return turned / values @ turned.T, float(np.sum(np.log(values)) - 2 * np.sum(np.log(size)))
