"""A 2-D track: constant velocity disturbed by white noise, positions measured with noise, and a
stretch without measurements.  The same seed gives the same track on every machine."""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass

import numpy as np

import models


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
    root = np.linalg.cholesky(settings.q * models.velocity_noise(settings.dt))
    step = np.array([[1.0, settings.dt], [0.0, 1.0]])
    states = np.zeros((settings.steps + settings.beyond, 2, 2))
    states[0, :, 1] = settings.speed
    for t in range(1, len(states)):
        disturbance = random.standard_normal((2, 2))
        states[t] = states[t - 1] @ step.T + disturbance @ root.T
    return np.round(states.reshape(-1, 4), 6)


def to_csv(track: Track) -> str:
    """The track as a CSV with the true states; the dropout is empty fields."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["time", "x", "y", "true_x", "true_vx", "true_y", "true_vy"])
    for t, (time, truth) in enumerate(zip(track.time, track.truth)):
        z = track.z[t] if t < len(track.z) else [np.nan, np.nan]
        measured = ["" if np.isnan(value) else f"{value:.3f}" for value in z]
        writer.writerow([f"{time:.10g}", *measured, *(f"{value:.6f}" for value in truth)])
    return text.getvalue()
