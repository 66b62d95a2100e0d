"""How surely is a constant within 0.1 of the truth, the longer it is measured?"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Mapping

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from scipy.stats import norm

from kalmanq.run.filters import Filter
from kalmanq_studies.lectures.densities import TRUTH, constant, readings
from kalmanq_studies.lectures.example import BLUE, GREY, ORANGE, Example, apart, ranged, shown

ROWS, RUNS, WIDTH = 600, 200, 0.1


@dataclass(frozen=True)
class Result:
    """mean, outside: RUNS x ROWS, of which row 0 is the run that is shown; sigma, expected: ROWS, of every run"""

    mean: np.ndarray
    sigma: np.ndarray
    outside: np.ndarray
    expected: np.ndarray

    @property
    def average(self) -> np.ndarray:
        return self.outside.mean(axis=0)

    @property
    def standard_error(self) -> np.ndarray:
        return self.outside.std(axis=0, ddof=1) / np.sqrt(len(self.outside))


def compute(arithmetic: str, seed: int) -> Result:
    z = readings(seed, ROWS, RUNS)
    known = ranged(constant(), z)
    runs = [Filter(known, arithmetic).run(one) for one in z]
    mean, sigma = np.array([run.mean[:, 0] for run in runs]), runs[0].sigma[:, 0]
    return Result(mean, sigma, outside(mean, sigma), expected(sigma))


def outside(mean: np.ndarray, sigma: np.ndarray) -> np.ndarray:
    """The probability that N(mean, sigma^2) gives to what is farther than WIDTH from the truth."""
    return norm.sf(TRUTH + WIDTH, mean, sigma) + norm.cdf(TRUTH - WIDTH, mean, sigma)


def expected(sigma: np.ndarray) -> np.ndarray:
    """The mean of that probability over all noises.

    The mean after k measurements is Gaussian around the truth, but for what is left of the prior's error: with
    P = sigma^2 its weights are P / P0 for the prior and P / R for each measurement.
    """
    prior, k = constant(), np.arange(1, len(sigma) + 1)
    bias = sigma**2 / prior.P0[0, 0] * (prior.x0[0] - TRUTH)
    spread = np.sqrt(k * prior.R[0, 0]) * sigma**2 / prior.R[0, 0]
    return outside(TRUTH + bias, np.hypot(sigma, spread))


def numbers(result: Result) -> dict[str, Any]:
    made: dict[str, Any] = {}
    for row in (10, 100, ROWS):
        made[f"outside after {row}, this run"] = result.outside[0, row - 1]
        made[f"outside after {row}, mean of {RUNS} runs"] = result.average[row - 1]
        made[f"outside after {row}, its standard error"] = result.standard_error[row - 1]
        made[f"outside after {row}, theory"] = result.expected[row - 1]
    return made


def distance(result: Result, exact: Result) -> float:
    return apart(result.mean, exact.mean, exact.sigma)


def draw(results: Mapping[str, Result]) -> Figure:
    result = shown(results)
    k = np.arange(1, ROWS + 1)
    figure, axis = plt.subplots(figsize=(7.6, 4.2), layout="constrained")
    axis.plot(k, result.outside[1:20].T, color=GREY, lw=0.4, alpha=0.45)
    axis.plot([], [], color=GREY, lw=0.8, label="others")
    axis.plot(k, result.outside[0], color=BLUE, lw=1.5, label="one run")
    band = 2 * result.standard_error
    axis.fill_between(k, result.average - band, result.average + band, color=ORANGE, alpha=0.35, lw=0,
                      label=f"mean of {RUNS} runs, ± 2 standard errors")
    axis.plot(k, result.expected, color="black", ls="--", lw=1.2, label="mean, theory")
    place = f"{TRUTH:g} ± {WIDTH:g}"
    axis.set(xlabel="measurements", ylabel=f"probability outside {place}", ylim=(0, 1.02), xlim=(0, ROWS),
             title=f"The density gathers at the constant: what it gives to values outside {place} falls towards 0")
    axis.legend(loc="upper right")
    return figure


EXAMPLE = Example("the probability outside 10 ± 0.1 over 600 measurements of a constant", compute, numbers, distance,
                  draw)
