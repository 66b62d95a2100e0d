"""The data sets that ship with the demo: the Nile, and a track that is simulated.

The track is in the plane, of constant velocity disturbed by white noise, positions measured with
noise, with a stretch without measurements.  The same seed gives the same track on every machine.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

import csv_input
import jobs
from jobs import FORECAST_STEPS, Job, Published
from shared.outputs import csv_text


def nile(root: Path, ahead: int | None) -> Job:
    """A poor guess of the variances, to be estimated, and a prior that says nothing."""
    q, r, p0 = 1e4, 1e4, 1e7
    path = root / "tools" / "data" / "nile.csv"
    data = csv_input.read(path, csv_input.LOCAL_LEVEL)
    return Job(
        name="nile",
        title="Nile at Aswan, 1871-1970: local level",
        model=jobs.local_level("flow", q, r, 0.0, p0),
        z=data.values,
        time=csv_input.times(data, 1.0),
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
    settings = Settings()
    if ahead is not None:
        settings = replace(settings, beyond=ahead)
    made = simulate(settings)
    q, r = settings.q, settings.r
    first, end = settings.dropout
    x0 = [0.0, 0.0, 0.0, 0.0]
    p0 = [1e4, 1e2, 1e4, 1e2]
    return Job(
        name="track",
        title="Simulated track with a dropout: constant velocity in the plane",
        model=jobs.constant_velocity(("x", "y"), settings.dt, [q, q], [r, r], x0, p0),
        z=made.z,
        time=made.time[: settings.steps],
        dt=settings.dt,
        ahead=settings.beyond,
        unit="m",
        time_unit="s",
        truth=made.truth,
        note=f"q = {q:g} m^2/s^3, r = {r:g} m^2, dt = {settings.dt:g} s, seed {settings.seed}; "
        f"no measurements in steps {first} to {end - 1}; x0 = 0, sigma 100 m and 10 m/s",
        extra_files={"track_data.csv": track_csv(made)},
    )


# ---- the simulated track ---------------------------------------------------------------------


@dataclass(frozen=True)
class Settings:
    seed: int = 196  # of a track that turns; chosen for its shape, not for its errors
    steps: int = 150
    beyond: int = 20  # true states after the last measurement, to judge the forecast by
    dt: float = 1.0  # s
    q: float = 0.05  # spectral density of the acceleration, m^2/s^3
    r: float = 64.0  # variance of a measured coordinate, m^2
    dropout: tuple[int, int] = (75, 105)  # the steps without measurements: [first, end)
    speed: tuple[float, float] = (2.0, 0.0)  # at the start, m/s


@dataclass(frozen=True)
class Track:
    time: np.ndarray  # steps + beyond
    truth: np.ndarray  # steps + beyond rows of x, vx, y, vy
    z: np.ndarray  # steps x 2, NaN in the dropout


def simulate(settings: Settings) -> Track:
    # RandomState's stream is frozen by NumPy: it does not depend on the version.
    random = np.random.RandomState(settings.seed)
    noise = random.standard_normal((settings.steps, 2)) * np.sqrt(settings.r)
    truth = simulate_truth(settings, random)  # last: its length is the caller's
    z = np.round(truth[: settings.steps, [0, 2]] + noise, 3)
    z[slice(*settings.dropout)] = np.nan
    return Track(np.arange(len(truth)) * settings.dt, truth, z)


def simulate_truth(settings: Settings, random: np.random.RandomState) -> np.ndarray:
    """Every axis is x[t+1] = A x[t] + C n, with C C' = Q and n standard normal."""
    root = np.linalg.cholesky(settings.q * jobs.velocity_noise(settings.dt))
    step = np.array([[1.0, settings.dt], [0.0, 1.0]])
    states = np.zeros((settings.steps + settings.beyond, 2, 2))
    states[0, :, 1] = settings.speed
    for t in range(1, len(states)):
        disturbance = random.standard_normal((2, 2))
        states[t] = states[t - 1] @ step.T + disturbance @ root.T
    return np.round(states.reshape(-1, 4), 6)


def track_csv(track: Track) -> str:
    """The track as a CSV with the true states; the dropout is empty fields."""
    rows = [["time", "x", "y", "true_x", "true_vx", "true_y", "true_vy"]]
    for t, (time, truth) in enumerate(zip(track.time, track.truth)):
        z = track.z[t] if t < len(track.z) else [np.nan, np.nan]
        measured = ["" if np.isnan(value) else f"{value:.3f}" for value in z]
        rows.append([f"{time:.10g}", *measured, *(f"{value:.6f}" for value in truth)])
    return csv_text(rows)
