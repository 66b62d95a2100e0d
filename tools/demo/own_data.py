"""The user's data: a model of what the CSV holds, its noise estimated by the method of moments
where it is not given."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Sequence

import numpy as np

import csv_input
import jobs
from csv_input import Measurements
from jobs import FORECAST_STEPS, Job, Model
from shared.errors import FileError, one_line

PRIOR_WIDTH = 10.0  # of the data's standard deviation
VARIANCE_RANGE = (1e-30, 1e30)  # what a float can be asked to work with


@dataclass(frozen=True)
class Given:
    """What the user says of the data; None: not said."""

    q: float | None = None
    r: float | None = None
    dt: float | None = None
    range: float | None = None
    ahead: int | None = None
    to_estimate: bool = False


def local_level(path: Path, given: Given) -> Job:
    data = csv_input.read(path, csv_input.LOCAL_LEVEL)
    step = time_step(path, data, given.dt)
    z = data.values[:, 0]
    try:
        found_q, found_r = level_noise(z, given.q, given.r)
    except TooFewData:
        raise too_few(path, data) from None
    check_range(path, data, [found_q, found_r])
    mean, sigma = spread(z, found_r)
    name = data.names[0]
    model = jobs.local_level(name, found_q, found_r, mean, (PRIOR_WIDTH * sigma) ** 2)
    return users_job(path, data, model, step, given)


def constant_velocity(path: Path, given: Given) -> Job:
    data = csv_input.read(path, csv_input.POSITIONS)
    step = time_step(path, data, given.dt)
    try:
        noise = [axis_noise(z, step, given.q, given.r) for z in data.values.T]
    except TooFewData:
        raise too_few(path, data) from None
    check_range(path, data, [value for pair in noise for value in pair])
    x0, p0 = velocity_prior(data, noise, step)
    density, variance = zip(*noise)
    model = jobs.constant_velocity(data.names, step, density, variance, x0, p0)
    return users_job(path, data, model, step, given)


def users_job(path: Path, data: Measurements, model: Model, step: float, given: Given) -> Job:
    return Job(
        name=f"{path.stem}_kalmanq",
        title=f"{one_line(path.name, 60)}: {model.kind}",
        model=model,
        z=data.values,
        time=csv_input.times(data, step),
        dt=step,
        ahead=FORECAST_STEPS if given.ahead is None else given.ahead,
        to_estimate=given.to_estimate,
        range=given.range,
        note=jobs.noise_text(model, origin(given.q), origin(given.r)),
        inputs=[path],
    )


def time_step(path: Path, data: Measurements, dt: float | None) -> float:
    """--dt, or the step of the file's times; both only if they agree."""
    if data.time is None or len(data.time) < 2:
        return 1.0 if dt is None else dt
    step = float(data.time[-1] - data.time[0]) / (len(data.time) - 1)
    if dt is not None and abs(dt - step) > csv_input.SPACING_TOLERANCE * step:
        raise FileError(path, f"the times step by {step:.6g}, --dt says {dt:g}", data.last_row)
    return step


def spread(z: np.ndarray, r: float) -> tuple[float, float]:
    """Mean and standard deviation of the measurements, the latter not below their noise."""
    return float(np.nanmean(z)), max(float(np.nanstd(z)), r**0.5)


def velocity_prior(
    data: Measurements, noise: Sequence[tuple[float, float]], dt: float
) -> tuple[list[float], list[float]]:
    x0: list[float] = []
    p0: list[float] = []
    for z, (_, r) in zip(data.values.T, noise):
        mean, sigma = spread(z, r)
        x0 += [mean, 0.0]
        p0 += [(PRIOR_WIDTH * sigma) ** 2, (PRIOR_WIDTH * typical_step(z, sigma) / dt) ** 2]
    return x0, p0


def typical_step(z: np.ndarray, sigma: float) -> float:
    """How far the measurements move from one row to the next, root mean square."""
    steps = np.diff(z)
    steps = steps[~np.isnan(steps)]
    return max(float(np.sqrt(np.mean(steps**2))), 1e-3 * sigma) if steps.size else sigma


def check_range(path: Path, data: Measurements, values: Sequence[float]) -> None:
    low, high = VARIANCE_RANGE
    for value in values:
        if value != 0 and not low <= value <= high:
            reason = f"a variance of {value:.3g} is beyond a float's range (scale the data)"
            raise FileError(path, reason, data.last_row)


def too_few(path: Path, data: Measurements) -> FileError:
    reason = "too few measurements in a row to estimate the noise: give --q and --r"
    return FileError(path, reason, data.last_row)


def origin(given: float | None) -> str:
    return " (estimated)" if given is None else ""


# ---- the method of moments -------------------------------------------------------------------

# Differences remove the level (or the position and the velocity), and what is left has variances
# that are known functions of q and r.
#
# Local level, first differences d[t] = z[t+1] - z[t] = w + v' - v:
#
#     c0 = var d = q + 2 r        c1 = cov(d[t], d[t+1]) = -r
#
# Constant velocity, second differences s[t] = z[t+2L] - 2 z[t+L] + z[t] over a stride of L steps,
# that is over h = L dt:
#
#     var s = 6 r + (2/3) q h^3   cov(s[t], s[t+L]) = -4 r + (1/6) q h^3
#
# r is taken from L = 1, where the noise of the measurements stands out; q from the shortest stride
# at which the motion does (or the longest that the data allow).
FEWEST = 4  # products that a moment is averaged over
SMALLEST = 1e-4  # of the variance of the differences: no estimate is below it


class TooFewData(Exception):
    """There are too few differences between measurements."""


def level_noise(z: np.ndarray, q: float | None, r: float | None) -> tuple[float, float]:
    """q per step and r; what is given is kept."""
    if q is not None and r is not None:
        return q, r
    d = z[1:] - z[:-1]
    c0 = mean_product(d, d) or tiny(z)
    if r is not None:
        return max(c0 - 2 * r, SMALLEST * c0), r
    if q is not None:
        return q, max((c0 - q) / 2, SMALLEST * c0)
    c1 = mean_product(d[1:], d[:-1])
    return max(c0 + 2 * c1, SMALLEST * c0), max(-c1, SMALLEST * c0)


def axis_noise(
    z: np.ndarray, dt: float, q: float | None, r: float | None
) -> tuple[float, float]:
    """Spectral density q and r of one axis; what is given is kept."""
    if q is not None and r is not None:
        return q, r
    s = second_difference(z, 1)
    c0 = mean_product(s, s) or tiny(z)
    if q is not None:
        return q, max((c0 - q * dt**3 * 2 / 3) / 6, SMALLEST * c0)
    if r is None:
        r = max((c0 - 4 * mean_product(s[1:], s[:-1])) / 22, SMALLEST * c0)
    return motion_density(z, dt, r), r


def motion_density(z: np.ndarray, dt: float, r: float) -> float:
    """q, from the shortest stride at which the motion is as large as the noise."""
    stride = 1
    variance = stride_variance(z, stride)
    while variance < 12 * r and 8 * stride <= len(z):
        try:
            variance = stride_variance(z, 2 * stride)
        except TooFewData:
            break
        stride *= 2
    density = 1.5 * max(variance - 6 * r, 0.01 * r)
    return density / (stride * dt) ** 3


def stride_variance(z: np.ndarray, stride: int) -> float:
    s = second_difference(z, stride)
    return mean_product(s, s)


def second_difference(z: np.ndarray, stride: int) -> np.ndarray:
    return z[2 * stride :] - 2 * z[stride:-stride] + z[: -2 * stride]


def mean_product(a: np.ndarray, b: np.ndarray) -> float:
    """The mean of a b over the pairs where neither is missing."""
    products = a * b
    products = products[~np.isnan(products)]
    if len(products) < FEWEST:
        raise TooFewData
    return float(products.mean())


def tiny(z: np.ndarray) -> float:
    """A variance for data that do not vary at all: a millionth of their size, squared."""
    size = float(np.nanmax(np.abs(z)))
    return (1e-6 * size) ** 2 if size > 0 and math.isfinite(size) else 1e-12
