"""What a run gives: means and standard deviations, by step."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

DRAWN = "f32"  # the arithmetic whose curves the plots show
FOR_95 = 1.959964  # half width of the 95 % band, in standard deviations


@dataclass(frozen=True)
class Band:
    """Rows are steps, columns are states or measured components."""

    mean: np.ndarray
    sigma: np.ndarray

    @property
    def low(self) -> np.ndarray:
        return self.mean - FOR_95 * self.sigma

    @property
    def high(self) -> np.ndarray:
        return self.mean + FOR_95 * self.sigma


@dataclass(frozen=True)
class Formats:
    """The n of every component's Qm.n: value = word * 2^-n."""

    states: tuple[int, ...]
    measured: tuple[int, ...]


@dataclass(frozen=True)
class Estimates:
    filtered: Band  # T x n
    smoothed: Band  # T x n
    forecast: Band  # K x n: 1 .. K steps after the last measurement
    forecast_z: Band  # K x m: the measurement to come
    log_likelihood: float
    memory: dict[str, int] = field(default_factory=dict)  # bytes, by object
    events: int = 0
    formats: Formats | None = None  # fixed point only
