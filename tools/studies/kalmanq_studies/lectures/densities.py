"""A constant that is measured with noise: what is known of it after each of the first five measurements."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Mapping

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from scipy.stats import norm

from kalmanq.model import Model
from kalmanq.run.filters import Filter
from kalmanq_studies.lectures.example import GREY, Example, apart, ranged, shown

TRUTH, SHOWN = 10.0, 5


@dataclass(frozen=True)
class Result:
    """After each of SHOWN measurements z; sigma of a constant falls as 1 / sqrt(k + 1) here"""

    z: np.ndarray
    mean: np.ndarray
    sigma: np.ndarray


def constant(mean: float = 8.0, variance: float = 1.0, noise: float = 1.0) -> Model:
    """A state that stays what it is: N(mean, variance) before the first measurement."""
    return Model(A=1, H=1, R=noise, Q=0, x0=mean, P0=variance, name="constant")


def readings(seed: int, rows: int, runs: int = 1) -> np.ndarray:
    """runs x rows x 1"""
    return TRUTH + np.random.Generator(np.random.PCG64(seed)).standard_normal((runs, rows, 1))


def compute(arithmetic: str, seed: int) -> Result:
    z = readings(seed, SHOWN)[0]
    run = Filter(ranged(constant(), [z]), arithmetic).run(z)
    return Result(z[:, 0], run.mean[:, 0], run.sigma[:, 0])


def numbers(result: Result) -> dict[str, Any]:
    return {"measurements": result.z, "means": result.mean, "sigmas": result.sigma}


def distance(result: Result, exact: Result) -> float:
    return apart(result.mean, exact.mean, exact.sigma)


def draw(results: Mapping[str, Result]) -> Figure:
    result = shown(results)
    theta = np.linspace(5, 12.5, 600)
    figure, axis = plt.subplots(figsize=(7.6, 4.2), layout="constrained")
    prior = constant()
    axis.plot(theta, norm.pdf(theta, prior.x0[0], np.sqrt(prior.P0[0, 0])), color=GREY, ls=":", label="prior")
    for k, (mean, sigma) in enumerate(zip(result.mean, result.sigma), 1):
        axis.plot(theta, norm.pdf(theta, mean, sigma), color=plt.cm.viridis(0.95 - 0.19 * k), lw=1 + 0.25 * k,
                  label=f"after {k}")
    axis.axvline(TRUTH, color="black", lw=1, ls="--", label="the constant")
    axis.set(xlabel="value of the constant", ylabel="probability density", xlim=(theta[0], theta[-1]),
             ylim=(0, None), title="Each measurement draws the density towards the constant and narrows it")
    axis.legend(loc="upper left")
    return figure


EXAMPLE = Example("a constant of 10 from noisy readings: its first five posterior densities", compute, numbers,
                  distance, draw)
