"""Runs the demo's programs (run.c, estimate.c) and the reference on a job; reads their answers."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

import reference
from estimates import DRAWN, REFERENCE, Band, Course, Estimates, Formats, Learning, Runs
from jobs import Job, ranges_of
from shared.errors import UserError, one_line, run_program

ARITHMETICS = ("f32", "f64", "q31")
ESTIMATING = ("f32", "f64")


@dataclass(frozen=True)
class Result:
    job: Job  # with its noise as it was estimated, if it was
    runs: Runs
    learning: Learning | None  # of the noise, if it was estimated


def run_job(job: Job, programs: Path) -> Result:
    """In all arithmetics, after an estimate of the noise if the job asks for it."""
    learning = learn(job, programs) if job.to_estimate else None
    if learning:
        job = learning.estimate
    runs: Runs = {name: run(programs / f"kq_demo_{name}", job) for name in ARITHMETICS}
    runs[REFERENCE] = reference.run(job.model, job.z, job.ahead)
    return Result(job, runs, learning)


def learn(guess: Job, programs: Path) -> Learning:
    courses = {a: estimate(programs / f"kq_estimate_{a}", guess) for a in ESTIMATING}
    before = run(programs / f"kq_demo_{DRAWN}", guess)
    return Learning(guess, courses, before)


# ---- one program -----------------------------------------------------------------------------


def run(program: Path, job: Job) -> Estimates:
    return parse(program, answer(program, problem_text(job)), job)


def estimate(program: Path, job: Job) -> Course:
    return parse_course(program, answer(program, problem_text(job)), job)


def answer(program: Path, problem: str) -> str:
    done = run_program([str(program)], "build it with tools/demo.sh", problem)
    if done.returncode != 0:
        reason = one_line(done.stderr.strip()) or f"{program.name}: stopped ({done.returncode})"
        raise UserError(reason)
    return done.stdout


def problem_text(job: Job) -> str:
    """The job in the form that run.c documents."""
    model = job.model
    n, m = len(model.x0), len(model.H)
    lines = [f"sizes {n} {m} {job.steps} {job.ahead}"]
    for name in ("A", "Q", "H", "R", "x0", "P0"):
        lines += [name, rows_text(getattr(model, name))]
    declared = ranges_of(job)
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


def incomplete(program: Path) -> UserError:
    return UserError(f"{program.name}: an incomplete answer")


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
