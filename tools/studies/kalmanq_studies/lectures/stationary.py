"""The way of the predicted covariance to where it stays, for three sizes of the process noise."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Mapping

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from kalmanq.model import Model
from kalmanq.run.steady import steady_state
from kalmanq_studies.lectures.example import (
    ARITHMETIC_STYLES, BLUE, GREEN, ORANGE, Example, covariances_apart, predicted_covariances, ranged, shown)

SIZES, ROWS = (0.1, 0.3, 0.5), 40
COLOURS = dict(zip(SIZES, (GREEN, BLUE, ORANGE)))


def model(Q: float = 0.3) -> Model:
    """Eigenvalues of A: 0.9 and -0.1."""
    return Model(A=[[0.5, 0.4], [0.6, 0.3]], H=np.eye(2), R=0.5 * np.eye(2), Q=Q * np.eye(2), x0=[8, 8],
                 P0=[[0.9, 0.3], [0.3, 0.9]], name="stationary")


@dataclass(frozen=True)
class Result:
    """By the size of Q: course: ROWS x 2 x 2, predicted; limit: 2 x 2, by the Riccati equation in f64"""

    course: dict[float, np.ndarray]
    limit: dict[float, np.ndarray]

    def left(self, size: float) -> np.ndarray:
        """ROWS: how far the course is from its limit, in sigma_i sigma_j"""
        return np.array([covariances_apart(P, self.limit[size]) for P in self.course[size]])


def compute(arithmetic: str, seed: int) -> Result:
    """The same for every seed: covariances do not depend on what is measured."""
    models = {size: ranged(model(size), [np.tile(model().x0, (2, 1))]) for size in SIZES}
    return Result({size: predicted_covariances(of, arithmetic, ROWS) for size, of in models.items()},
                  {size: steady_state(of).predicted for size, of in models.items()})


def numbers(result: Result) -> dict[str, Any]:
    made: dict[str, Any] = {}
    for size in SIZES:
        made[f"Q = {size:g} I: after {ROWS} rows"] = result.course[size][-1]
        made[f"Q = {size:g} I: Riccati equation"] = result.limit[size]
    return made


def distance(result: Result, exact: Result) -> float:
    return max(covariances_apart(result.course[size], exact.course[size]) for size in SIZES)


def draw(results: Mapping[str, Result]) -> Figure:
    result, rows = shown(results), np.arange(ROWS)
    figure, (way, rest) = plt.subplots(1, 2, figsize=(9.4, 4.2), layout="constrained", width_ratios=[1, 1.1])
    for size in SIZES:
        for (i, j), mark in (((0, 0), "o"), ((0, 1), "s")):
            way.plot(rows[:13], result.course[size][:13, i, j], color=COLOURS[size], lw=1, marker=mark, ms=3.2)
            way.axhline(result.limit[size][i, j], color=COLOURS[size], lw=0.9, ls="--")
        way.plot([], [], color=COLOURS[size], label=f"Q = {size:g} I")
    for mark, label in (("o", "P11"), ("s", "P12")):
        way.plot([], [], color="black", marker=mark, ms=3.2, lw=0, label=label)
    way.set(xlabel="row", ylabel="entry of the predicted covariance", ylim=(0, 0.95),
            title="More process noise, a larger covariance;\ndashed: solution of the Riccati equation")
    way.legend(loc="upper right", ncols=2)
    for name, of in results.items():
        colour, line = ARITHMETIC_STYLES[name]
        rest.semilogy(rows, np.maximum(of.left(0.3), 1e-17), color=colour, ls=line, lw=1.6, label=name)
    rest.set(xlabel="row", ylabel="largest distance / (sigma_i sigma_j)", ylim=(1e-17, 3),
             title="Q = 0.3 I: the distance to where it stays falls\nby one factor a row, down to the last bits")
    rest.legend(loc="upper right")
    return figure


EXAMPLE = Example("the way to the stationary covariance for Q = 0.1 I, 0.3 I and 0.5 I", compute, numbers, distance,
                  draw)
