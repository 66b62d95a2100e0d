"""Runs a demo program (run.c, estimate.c) on a job, and reads what it answers."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np

import ranges
from errors import DemoError, one_line
from estimates import Band, Estimates, Formats
from job import Job
from learning import Course

TIME_LIMIT = 50  # seconds


def run(program: Path, job: Job) -> Estimates:
    return parse(program, answer(program, problem_text(job)), job)


def estimate(program: Path, job: Job) -> Course:
    return parse_course(program, answer(program, problem_text(job)), job)


def answer(program: Path, problem: str) -> str:
    try:
        done = subprocess.run(
            [str(program)], input=problem, capture_output=True, text=True, timeout=TIME_LIMIT
        )
    except OSError as error:
        raise DemoError(f"{program}: {error.strerror}; build it with tools/demo.sh") from error
    except subprocess.TimeoutExpired as error:
        raise DemoError(f"{program}: no answer within {TIME_LIMIT} s") from error
    if done.returncode != 0:
        reason = one_line(done.stderr.strip()) or f"{program.name}: stopped ({done.returncode})"
        raise DemoError(reason)
    return done.stdout


def problem_text(job: Job) -> str:
    """The job in the form that run.c documents."""
    model = job.model
    n, m = len(model.x0), len(model.H)
    lines = [f"sizes {n} {m} {job.steps} {job.ahead}"]
    for name in ("A", "Q", "H", "R", "x0", "P0"):
        lines += [name, rows_text(getattr(model, name))]
    declared = ranges.of(job)
    lines += ["x_range", rows_text(declared.states), "z_range", rows_text(declared.measured)]
    return "\n".join(lines + ["z", rows_text(job.z), "end", ""])


def rows_text(values: np.ndarray) -> str:
    rows = np.atleast_2d(values)
    return "\n".join(" ".join(repr(float(value)) for value in row) for row in rows)


def parse(program: Path, text: str, job: Job) -> Estimates:
    records = records_of(program, text)
    steps, forecasts = records.get("step", []), records.get("forecast", [])
    if (len(steps), len(forecasts)) != (job.steps, job.ahead):
        raise incomplete(program)
    n, m = len(job.model.x0), len(job.model.H)
    filtered, smoothed = bands(steps, [n, n])
    forecast, forecast_z = bands(forecasts, [n, m])
    memory = records["memory"][0]
    return Estimates(
        filtered=filtered,
        smoothed=smoothed,
        forecast=forecast,
        forecast_z=forecast_z,
        log_likelihood=float(records["log_likelihood"][0][0]),
        memory=dict(zip(memory[::2], map(int, memory[1::2]))),
        events=int(records["events"][0][0]),
        formats=formats_of(records["formats"][0], n) if "formats" in records else None,
    )


def parse_course(program: Path, text: str, job: Job) -> Course:
    records = records_of(program, text)
    rows = np.array(records["iteration"], dtype=float)
    n, m = len(job.model.x0), len(job.model.H)
    Q, R = rows[:, 2 : 2 + n * n].reshape(-1, n, n), rows[:, 2 + n * n :].reshape(-1, m, m)
    return Course(
        log_likelihood=rows[:, 1],
        models=[job.model.with_noise(*noise) for noise in zip(Q, R)],
        settled=records["settled"] == [["1"]],
        distance=float(records["distance"][0][0]),
    )


def records_of(program: Path, text: str) -> dict[str, list[list[str]]]:
    """The lines by their first word, if the answer is complete."""
    records: dict[str, list[list[str]]] = {}
    for word, *rest in (line.split() for line in text.splitlines()):
        records.setdefault(word, []).append(rest)
    if "end" not in records:
        raise incomplete(program)
    return records


def incomplete(program: Path) -> DemoError:
    return DemoError(f"{program.name}: an incomplete answer")


def formats_of(record: list[str], n: int) -> Formats:
    """Of `state F[n] measurement F[m]`."""
    states, measured = record[1 : n + 1], record[n + 2 :]
    return Formats(tuple(map(int, states)), tuple(map(int, measured)))


def bands(records: list[list[str]], widths: list[int]) -> list[Band]:
    """Splits records (an index, then mean and sigma of each band in turn) into bands."""
    numbers = np.array(records, dtype=float).reshape(len(records), 1 + 2 * sum(widths))
    found, at = [], 1
    for width in widths:
        found.append(Band(numbers[:, at : at + width], numbers[:, at + width : at + 2 * width]))
        at += 2 * width
    return found
