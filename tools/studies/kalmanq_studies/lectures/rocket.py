"""Where is the rocket?  A belief, a reading, what both say together, and where it will be next."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Mapping

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from scipy.stats import multivariate_normal

from kalmanq.model import Model, Quantity
from kalmanq.run.filters import Filter
from kalmanq_studies.lectures.example import BLUE, GREEN, GREY, ORANGE, Example, apart, covariances_apart, ranged, shown

READING = np.array([2.3, -1.9])
WITHIN = (0.9, 0.5, 0.2)  # probability inside each contour
PLACES = [Quantity("x1", "km"), Quantity("x2", "km")]


@dataclass(frozen=True)
class Density:
    """mean: 2; covariance: 2 x 2"""

    mean: np.ndarray
    covariance: np.ndarray


@dataclass(frozen=True)
class Result:
    prior: Density
    reading: Density
    filtered: Density
    predicted: Density


def model() -> Model:
    P0 = np.array([[0.4, 0.3], [0.3, 0.45]])
    made = Model(A=np.diag([1.2, -0.2]), H=np.eye(2), R=0.5 * P0, Q=0.3 * P0, x0=[0.2, -0.2], P0=P0, states=PLACES,
                 measurements=[Quantity("z1", "km"), Quantity("z2", "km")], name="rocket")
    return ranged(made, [np.array([READING, [np.nan, np.nan]])])


def compute(arithmetic: str, seed: int) -> Result:
    """The same for every seed: nothing is drawn."""
    known = model()
    filter_ = Filter(known, arithmetic)
    prior = _of(filter_)
    filter_.update(READING)
    return Result(prior, Density(READING, known.R), _of(filter_), _of(filter_.forecast(1)))


def _of(filter_: Filter) -> Density:
    return Density(filter_.mean, filter_.covariance)


def numbers(result: Result) -> dict[str, Any]:
    return {"filtered x": result.filtered.mean, "filtered P": result.filtered.covariance,
            "predicted x": result.predicted.mean, "predicted P": result.predicted.covariance}


def distance(result: Result, exact: Result) -> float:
    pairs = ((result.filtered, exact.filtered), (result.predicted, exact.predicted))
    return max(max(apart(of.mean, beside.mean, np.sqrt(np.diag(beside.covariance))),
                   covariances_apart(of.covariance, beside.covariance)) for of, beside in pairs)


def draw(results: Mapping[str, Result]) -> Figure:
    result = shown(results)
    parts = (("prior", result.prior, GREY, ":"), ("measurement", result.reading, ORANGE, "--"),
             ("filtered", result.filtered, BLUE, "-"), ("predicted", result.predicted, GREEN, "-."))
    figure, axis = plt.subplots(figsize=(7.4, 6.0), layout="constrained")
    for name, density, colour, line in parts:
        _contours(axis, density, colour, line)
        axis.plot([], [], color=colour, ls=line, label=name)
    axis.set(xlabel=PLACES[0].label, ylabel=PLACES[1].label, xlim=(-1.6, 3.9), ylim=(-3.2, 2.4), aspect="equal",
             title="The filtered density lies between prior and measurement and is narrower than both;\n"
                   "contours hold 20, 50 and 90 % of the probability, + is the mean")
    axis.legend(loc="upper left")
    return figure


def _contours(axis: Any, density: Density, colour: str, line: str) -> None:
    x, y = np.meshgrid(np.linspace(-1.6, 3.9, 260), np.linspace(-3.2, 1.8, 240))
    normal = multivariate_normal(density.mean, density.covariance)
    # of a density in two dimensions, the part above (1 - p) of its peak holds the probability p
    levels = [(1 - p) * normal.pdf(density.mean) for p in WITHIN]
    axis.contour(x, y, normal.pdf(np.dstack([x, y])), levels=levels, colors=colour, linestyles=line, linewidths=1.3)
    axis.plot(*density.mean, "+", color=colour, ms=7)


EXAMPLE = Example("prior, measurement, filtered and predicted density of a position in the plane", compute, numbers,
                  distance, draw)
