"""One data set with its model: what is to be run, and how to call it."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from models import Model


@dataclass(frozen=True)
class Published:
    """Noise that the literature has estimated from the same data."""

    source: str
    q: float
    r: float


@dataclass(frozen=True)
class Job:
    name: str  # of the output files
    title: str
    model: Model
    z: np.ndarray  # T x m, NaN where missing
    time: np.ndarray  # T
    dt: float
    ahead: int
    unit: str = ""  # of what is measured
    time_unit: str = ""
    time_name: str = "time"
    truth: np.ndarray | None = None  # T + ahead rows of states, where it is known
    note: str = ""  # a line below the table: the model's numbers
    to_estimate: bool = False  # the model's Q and R are a guess (learning.py)
    published: Published | None = None
    range: float | None = None  # of the measurements, as the user declares it (ranges.py)
    inputs: list[Path] = field(default_factory=list)  # files that must not be overwritten
    extra_files: dict[str, str] = field(default_factory=dict)  # to be written too, by name

    @property
    def steps(self) -> int:
        return len(self.z)

    @property
    def future(self) -> np.ndarray:
        """The times of the forecasts."""
        return self.time[-1] + self.dt * np.arange(1, self.ahead + 1)

    @property
    def measured_states(self) -> list[int]:
        """The state that each component measures."""
        return [int(np.argmax(row)) for row in self.model.H]

    def gaps(self, *components: int) -> list[tuple[int, int]]:
        """Runs of steps in which all these are missing: first and last step of each."""
        return runs_of(np.isnan(self.z[:, components]).all(axis=1))


def runs_of(missing: np.ndarray) -> list[tuple[int, int]]:
    """First and last index of each run."""
    edges = np.diff(np.concatenate([[0], missing.astype(int), [0]]))
    return list(zip(np.flatnonzero(edges == 1), np.flatnonzero(edges == -1) - 1))
