"""The data sets that ship with the demo, and the user's own."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Sequence

import numpy as np

import csv_input
import models
import moments
import simulate
from csv_input import Measurements
from errors import InputError, one_line
from job import Job, Published

FORECAST_STEPS = 10
PRIOR_WIDTH = 10.0  # of the data's standard deviation
VARIANCE_RANGE = (1e-30, 1e30)  # what a float can be asked to work with


# ---- built in --------------------------------------------------------------------------------


def nile(root: Path, ahead: int | None) -> Job:
    """A poor guess of the variances, to be estimated, and a prior that says nothing."""
    q, r, p0 = 1e4, 1e4, 1e7
    path = root / "tools" / "data" / "nile.csv"
    data = csv_input.read(path, csv_input.LOCAL_LEVEL)
    return Job(
        name="nile",
        title="Nile at Aswan, 1871-1970: local level",
        model=models.local_level("flow", q, r, 0.0, p0),
        z=data.values,
        time=times(data, 1.0),
        dt=1.0,
        ahead=FORECAST_STEPS if ahead is None else ahead,
        unit="10\u2078 m\u00b3",
        time_name="year",
        note=f"q = {q:g}, r = {r:g} (1e8 m^3)^2; before the first year: level 0, variance {p0:g}",
        to_estimate=True,
        published=Published("Durbin and Koopman, by maximum likelihood", 1469.1, 15099.0),
        inputs=[path],
    )


def track(ahead: int | None) -> Job:
    settings = simulate.Settings()
    if ahead is not None:
        settings = replace(settings, beyond=ahead)
    made = simulate.simulate(settings)
    q, r = settings.q, settings.r
    first, end = settings.dropout
    x0 = [0.0, 0.0, 0.0, 0.0]
    p0 = [1e4, 1e2, 1e4, 1e2]
    return Job(
        name="track",
        title="Simulated track with a dropout: constant velocity in the plane",
        model=models.constant_velocity(("x", "y"), settings.dt, [q, q], [r, r], x0, p0),
        z=made.z,
        time=made.time[: settings.steps],
        dt=settings.dt,
        ahead=settings.beyond,
        unit="m",
        time_unit="s",
        truth=made.truth,
        note=f"q = {q:g} m^2/s^3, r = {r:g} m^2, dt = {settings.dt:g} s, seed {settings.seed}; "
        f"no measurements in steps {first} to {end - 1}; x0 = 0, sigma 100 m and 10 m/s",
        extra_files={"track_data.csv": simulate.to_csv(made)},
    )


# ---- the user's ------------------------------------------------------------------------------


def local_level(
    path: Path,
    q: float | None,
    r: float | None,
    dt: float | None,
    measured_range: float | None,
    ahead: int | None,
) -> Job:
    data = csv_input.read(path, csv_input.LOCAL_LEVEL)
    step = time_step(path, data, dt)
    z = data.values[:, 0]
    try:
        found_q, found_r = moments.local_level(z, q, r)
    except moments.TooFewData:
        raise too_few(path, data) from None
    check_range(path, data, [found_q, found_r])
    mean, sigma = spread(z, found_r)
    name = data.names[0]
    model = models.local_level(name, found_q, found_r, mean, (PRIOR_WIDTH * sigma) ** 2)
    note = models.noise_text(model, origin(q), origin(r))
    return users_job(path, data, model, step, measured_range, ahead, note)


def constant_velocity(
    path: Path,
    q: float | None,
    r: float | None,
    dt: float | None,
    measured_range: float | None,
    ahead: int | None,
) -> Job:
    data = csv_input.read(path, csv_input.POSITIONS)
    step = time_step(path, data, dt)
    try:
        noise = [moments.constant_velocity(z, step, q, r) for z in data.values.T]
    except moments.TooFewData:
        raise too_few(path, data) from None
    check_range(path, data, [value for pair in noise for value in pair])
    x0, p0 = velocity_prior(data, noise, step)
    density, variance = zip(*noise)
    model = models.constant_velocity(data.names, step, density, variance, x0, p0)
    note = models.noise_text(model, origin(q), origin(r))
    return users_job(path, data, model, step, measured_range, ahead, note)


def users_job(
    path: Path,
    data: Measurements,
    model: models.Model,
    step: float,
    measured_range: float | None,
    ahead: int | None,
    note: str,
) -> Job:
    return Job(
        name=f"{path.stem}_kalmanq",
        title=f"{one_line(path.name, 60)}: {model.kind}",
        model=model,
        z=data.values,
        time=times(data, step),
        dt=step,
        ahead=FORECAST_STEPS if ahead is None else ahead,
        range=measured_range,
        note=note,
        inputs=[path],
    )


def time_step(path: Path, data: Measurements, dt: float | None) -> float:
    """--dt, or the step of the file's times; both only if they agree."""
    if data.time is None or len(data.time) < 2:
        return 1.0 if dt is None else dt
    step = float(data.time[-1] - data.time[0]) / (len(data.time) - 1)
    if dt is not None and abs(dt - step) > csv_input.SPACING_TOLERANCE * step:
        raise InputError(path, f"the times step by {step:.6g}, --dt says {dt:g}", data.last_row)
    return step


def times(data: Measurements, step: float) -> np.ndarray:
    return step * np.arange(len(data.values)) if data.time is None else data.time


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
            raise InputError(path, reason, data.last_row)


def too_few(path: Path, data: Measurements) -> InputError:
    reason = "too few measurements in a row to estimate the noise: give --q and --r"
    return InputError(path, reason, data.last_row)


def origin(given: float | None) -> str:
    return " (estimated)" if given is None else ""
