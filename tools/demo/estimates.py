"""What the programs and the reference give: means and standard deviations by step, iterations of
EM; and both as CSVs."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Iterable, Iterator

import numpy as np

from jobs import Job, Model, noise_text
from shared.outputs import csv_text

REFERENCE = "reference"  # among the runs, beside the arithmetics
DRAWN = "f32"  # the arithmetic whose curves the plots show
FOR_95 = 1.959964  # half width of the 95 % band, in standard deviations
TAKEN = "f64"  # the arithmetic whose estimate is worked with
MILESTONES = (0, 1, 10, 100)  # iterations that are shown, besides the last


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

Runs = dict[str, Estimates]  # by arithmetic, the reference last


@dataclass(frozen=True)
class Course:
    """The iterations of one arithmetic, from the guess, which is iteration 0."""

    log_likelihood: np.ndarray  # K + 1
    models: list[Model]  # K + 1
    settled: bool
    distance: float  # of the last log-likelihood to its maximum, extrapolated; NaN: not known

    @property
    def last(self) -> int:
        return len(self.models) - 1

    @property
    def rise(self) -> float:
        return float(self.log_likelihood[-1] - self.log_likelihood[0])


@dataclass(frozen=True)
class Learning:
    guess: Job
    courses: dict[str, Course]  # by arithmetic
    before: Estimates  # with the guess, of the arithmetic that is drawn

    @property
    def estimate(self) -> Job:
        """The job with the noise as it is estimated."""
        model = self.courses[TAKEN].models[-1]
        note = f"estimate (EM in {TAKEN}): {noise_text(model)}\nguess: {self.guess.note}"
        return replace(self.guess, model=model, note=note, to_estimate=False)

    @property
    def milestones(self) -> list[int]:
        """The iterations to be shown that all arithmetics have, before their last."""
        return [k for k in MILESTONES if all(k < course.last for course in self.courses.values())]


# ---- CSVs ------------------------------------------------------------------------------------


def runs_csv(job: Job, runs: Runs) -> str:
    """One row a step and arithmetic, then one row a forecast."""
    rows = [header(job)]
    for arithmetic, found in runs.items():
        rows += ([arithmetic, *row] for row in data_rows(job, found))
        rows += ([arithmetic, *row] for row in forecast_rows(job, found))
    return csv_text(rows)


def iterations_csv(learning: Learning) -> str:
    """One row an iteration."""
    names = [f"{noise}_{name}" for noise in "qr" for name in learning.guess.model.measured]
    rows = [["arithmetic", "iteration", "log_likelihood", *names]]
    for arithmetic, course in learning.courses.items():
        for k, (value, model) in enumerate(zip(course.log_likelihood, course.models)):
            rows.append([arithmetic, str(k), *numbers([value, *model.q, *model.r])])
    return csv_text(rows)


def header(job: Job) -> list[str]:
    states, measured = job.model.states, job.model.measured
    names = ["arithmetic", "kind", "step", "time"]
    names += [f"z_{name}" for name in measured]
    names += [f"true_{name}" for name in states] if job.truth is not None else []
    for estimate in ("filtered", "smoothed", "forecast"):
        names += columns(estimate, states)
    return names + columns("forecast_z", measured)


def columns(estimate: str, names: tuple[str, ...]) -> list[str]:
    means = [f"{estimate}_{name}" for name in names]
    return means + [f"{estimate}_{name}_sigma" for name in names]


def data_rows(job: Job, found: Estimates) -> Iterator[list[str]]:
    n, m = len(job.model.x0), len(job.model.H)
    blank = [""] * (2 * n + 2 * m)
    for t in range(job.steps):
        row = ["data", str(t), number(job.time[t]), *numbers(job.z[t]), *truth(job, t)]
        yield row + fields(found.filtered, t) + fields(found.smoothed, t) + blank


def forecast_rows(job: Job, found: Estimates) -> Iterator[list[str]]:
    n, m = len(job.model.x0), len(job.model.H)
    for k, time in enumerate(job.future):
        t = job.steps + k
        row = ["forecast", str(t), number(time), *[""] * m, *truth(job, t), *[""] * (4 * n)]
        yield row + fields(found.forecast, k) + fields(found.forecast_z, k)


def fields(band: Band, row: int) -> list[str]:
    return numbers(band.mean[row]) + numbers(band.sigma[row])


def truth(job: Job, t: int) -> list[str]:
    return [] if job.truth is None else numbers(job.truth[t])


def numbers(values: Iterable[float]) -> list[str]:
    return [number(value) for value in values]


def number(value: float) -> str:
    return "" if np.isnan(value) else f"{value:.10g}"
