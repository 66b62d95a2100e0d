"""What rounding does to a filter: kalmanq beside the usual filter, P - K (P h)', in the same kind of numbers.

The usual filter is in double beside f64, in float32 beside f32, and in Q16.16 beside q31.  All numbers that go in are
exact in each of them, so errors are of the filters alone.  They are told from Joseph's form in long double.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Callable, Mapping, Optional

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from kalmanq.model import Model, Quantity
from kalmanq.run.filters import Filter
from kalmanq.run.simulation import simulate
from kalmanq_studies.lectures.example import BLUE, GREEN, ORANGE, Example, apart

ROWS, DT, UNIT, GRID = 300, 0.125, 2.0**-16, 2.0**-8  # measurements are multiples of GRID: float32 has them all
NEGATIVE = -1e-6  # an eigenvalue that is no rounding, in sigma^2
USUAL = {"f64": np.float64, "f32": np.float32, "q31": None}  # None: Q16.16
CASES = {"ordinary": (0.25, 64.0), "low noise": (2.0**-12, 16384.0)}  # R, P0
STYLES = {("f32", "mean"): (GREEN, "kalmanq f32"), ("q31", "mean"): (BLUE, "kalmanq q31"),
          ("f32", "usual"): (ORANGE, "the usual filter, float32"), ("q31", "usual"): ("black", "the usual filter, Q16.16")}


def model(case: str) -> Model:
    """Constant acceleration, one position measured"""
    R, P0 = CASES[case]
    return Model(A=[[1, DT, DT**2 / 2], [0, 1, DT], [0, 0, 1]], H=[1, 0, 0], R=R, G=[DT**2 / 4, DT / 2, 0.5], P0=[P0, 1, 1],
                 states=[Quantity("position", "m", range=30000), Quantity("velocity", "m/s", range=2000),
                         Quantity("acceleration", "m/s^2", range=200)],
                 measurements=[Quantity("z", "m", range=30000)], name="constant acceleration")


@dataclass(frozen=True)
class Course:
    """exact, sigma, mean, usual: ROWS x n, after each row; the last two of kalmanq and of the usual filter;
    indefinite: rows in which their covariance has an eigenvalue below 0"""

    exact: np.ndarray
    sigma: np.ndarray
    mean: np.ndarray
    usual: np.ndarray
    indefinite: dict[str, int]

    def error(self, of: str) -> np.ndarray:
        return np.max(np.abs(getattr(self, of) - self.exact) / self.sigma, axis=1)


Result = dict[str, Course]


def compute(arithmetic: str, seed: int) -> Result:
    return {case: _course(model(case), arithmetic, seed) for case in CASES}


def _course(of: Model, arithmetic: str, seed: int) -> Course:
    z = np.round(simulate(of, ROWS, seed)[1][:, 0] / GRID) * GRID
    exact = list(usual_filter(of, z, np.longdouble, joseph=True))
    number = USUAL[arithmetic]
    usual = list(usual_filter(of, z, number) if number else q16_filter(of, z))
    mine = list(_library(of, z, arithmetic))
    sigma = np.sqrt([np.diag(P) for _, P in exact]).astype(float)
    bad = {name: sum(_is_indefinite(P, s) for (_, P), s in zip(rows, sigma)) for name, rows in (("mean", mine), ("usual", usual))}
    true, mean, beside = (np.array([x for x, _ in rows], dtype=float) for rows in (exact, mine, usual))
    return Course(true, sigma, mean, beside, bad)


def _is_indefinite(P: np.ndarray, sigma: np.ndarray) -> bool:
    return bool(np.linalg.eigvalsh(np.asarray(P, dtype=float) / np.outer(sigma, sigma))[0] < NEGATIVE)


def _library(of: Model, z: np.ndarray, arithmetic: str) -> Any:
    filter_ = Filter(of, arithmetic)
    for row, one in enumerate(z):
        if row:
            filter_.predict()
        filter_.update([one])
        yield filter_.mean, filter_.covariance


def usual_filter(of: Model, z: np.ndarray, number: Callable[[Any], Any], joseph: bool = False) -> Any:
    """Means and covariances after each row"""
    A, Q, h, P = (np.asarray(one, dtype=number) for one in (of.A, of.Q, of.H[0], of.P0))
    x, r = np.zeros(of.n, dtype=number), number(of.R[0, 0])
    for row, one in enumerate(z.astype(number)):
        if row:
            x, P = A @ x, _mirrored(A @ P @ A.T + Q)
        F = P @ h
        K = F / (h @ F + r)
        x = x + K * (one - h @ x)
        L = np.eye(of.n, dtype=number) - np.outer(K, h)
        P = L @ P @ L.T + r * np.outer(K, K) if joseph else _mirrored(P - np.outer(K, F))
        yield x, P


def q16_filter(of: Model, z: np.ndarray) -> Any:
    """The filter of tests/reference/q16_filter.c: 32 bits, 16 of them behind the point; sums in 64 bits are rounded once"""
    A, Q, h, P = (_words(one) for one in (of.A, of.Q, of.H[0], of.P0))
    x, r = _words(np.zeros(of.n)), _words(of.R)[0, 0]
    for row, one in enumerate(_words(z)):
        if row:
            x, P = _rounded(A @ x), _mirrored(_rounded(_rounded(A @ P) @ A.T) + Q)
        F = _rounded(h @ P)
        s, e = _rounded(h @ F) + r, one - _rounded(h @ x)
        if s > 0:
            K = np.array([(abs(int(f)) * 65536 + s // 2) // s * (1 if f >= 0 else -1) for f in F], dtype=object)
            x, P = x + _rounded(K * e), _mirrored(P - _rounded(np.outer(K, F)))
        yield x.astype(float) * UNIT, P.astype(float) * UNIT


def _words(given: np.ndarray) -> np.ndarray:
    """Python's integers, which do not overflow; a test compares with C"""
    return np.vectorize(lambda one: int(np.floor(float(one) / UNIT + 0.5)), otypes=[object])(given)


def _mirrored(P: np.ndarray) -> np.ndarray:
    return np.triu(P) + np.triu(P, 1).T


def _rounded(sums: Any) -> Any:
    return (sums + 32768) >> 16


def numbers(result: Result) -> dict[str, Any]:
    made: dict[str, Any] = {}
    for case, of in result.items():
        for name, said in (("mean", "kalmanq"), ("usual", "the usual filter")):
            made[f"{case}: {said}, largest error of a mean, in sigma"] = np.max(of.error(name))
            made[f"{case}: {said}, rows with an indefinite covariance"] = of.indefinite[name]
    return made


def distance(result: Result, exact: Result) -> float:
    return max(apart(result[case].mean, exact[case].mean, exact[case].sigma) for case in CASES)


def draw(results: Mapping[str, Result]) -> Figure:
    figure, axes = plt.subplots(1, 2, figsize=(9.4, 4.2), layout="constrained", sharey=True)
    for axis, case in zip(axes, CASES):
        for (arithmetic, of), (colour, label) in STYLES.items():
            course: Optional[Course] = results.get(arithmetic, {}).get(case)
            if course is not None:
                axis.semilogy(np.maximum.accumulate(np.maximum(course.error(of), 1e-12)), color=colour, lw=1.4, label=label)
        axis.axhline(1, color="grey", lw=0.8, ls=":")
        R, P0 = CASES[case]
        axis.set(xlabel="row", ylabel="largest error of a mean so far, in sigma", title=f"{case}: R / P0 = {R / P0:.0e}")
    axes[0].legend(loc="lower right")
    return figure


EXAMPLE = Example("errors of rounding beside the usual filter in float32 and Q16.16", compute, numbers, distance, draw)
