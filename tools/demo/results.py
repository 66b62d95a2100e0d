"""The results as CSVs: one row a step and arithmetic, then one row a forecast; one row an iteration
of an estimate."""

from __future__ import annotations

import csv
import io
from typing import Iterable, Iterator

import numpy as np

from estimates import Band, Estimates
from job import Job
from learning import Learning


def to_csv(job: Job, runs: dict[str, Estimates]) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header(job))
    for arithmetic, found in runs.items():
        writer.writerows([arithmetic, *row] for row in data_rows(job, found))
        writer.writerows([arithmetic, *row] for row in forecast_rows(job, found))
    return text.getvalue()


def iterations_to_csv(learning: Learning) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    names = [f"{noise}_{name}" for noise in "qr" for name in learning.guess.model.measured]
    writer.writerow(["arithmetic", "iteration", "log_likelihood", *names])
    for arithmetic, course in learning.courses.items():
        for k, (value, model) in enumerate(zip(course.log_likelihood, course.models)):
            writer.writerow([arithmetic, k, *numbers([value, *model.q, *model.r])])
    return text.getvalue()


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
