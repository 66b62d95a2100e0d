"""kalmanq simulate --runs: how far off a filter of the right model is, over many runs."""

from __future__ import annotations

import hashlib
import json
import warnings
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, Optional, Sequence

import numpy as np
from rich.console import Console
from rich.table import Table

from kalmanq.commands.simulate import controls_of, drawn
from kalmanq.data import tables
from kalmanq.errors import KalmanqError, KalmanqWarning
from kalmanq.model import model_file
from kalmanq.model import Model
from kalmanq.run.campaigns import journal_of, progress_bar, run_campaign
from kalmanq.run.diagnostics import is_scored, mean_bounds, nees, student_limit
from kalmanq.run.filters import Filter, Smoother

NO_FIGURES = ("run", "taken", "events")  # columns without a mean over the runs
TAIL = ("nees", "nis", "taken", "loglik", "events")


@dataclass(frozen=True)
class Asked:
    model: Path
    rows: Optional[int]
    seed: int
    out: Optional[Path]
    truth: bool
    gap: Optional[tuple[int, int]]
    controls: Optional[tables.AnySource]
    runs: int
    arithmetic: str
    smooth: bool
    workers: Optional[int]
    dask: Optional[str]
    fresh: bool
    json: bool


@dataclass(frozen=True)
class Study:
    """What every run is of."""

    model: Model
    rows: int
    seed: int
    arithmetic: str
    smooth: bool
    gap: Optional[tuple[int, int]]
    u: Optional[np.ndarray] = None


# ------------------------------------------------------------------------------ a run


def one_run(study: Study, run: int) -> dict[str, Any]:
    """Run `run` of a study: its row of the table.  It draws from a stream of its own."""
    try:
        return _row(study, run)
    except KalmanqError as problem:
        raise KalmanqError(f"run {run}: {problem}") from None


def _row(study: Study, number: int) -> dict[str, Any]:
    model = study.model
    x, z = drawn(model, study.rows, np.random.SeedSequence(study.seed, spawn_key=(number,)), study.gap,
                 study.u)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", KalmanqWarning)  # the row has the events
        run = Filter(model, study.arithmetic).run(z, study.u, covariance=True)
        smoothed = Smoother(model, study.arithmetic).run(z, study.u).smoothed if study.smooth else None
    assert run.covariance is not None and run.nis is not None and run.taken is not None
    assert run.log_likelihood is not None
    made: dict[str, Any] = {"run": number}
    for i, state in enumerate(model.states):
        made[f"{state.name}_rmse"] = root_mean_square(run.mean[:, i] - x[:, i])
        if smoothed is not None:
            made[f"{state.name}_smoothed_rmse"] = root_mean_square(smoothed[:, i] - x[:, i])
    score, dimensions = nees(run.mean - x, run.covariance, study.arithmetic)
    scored = is_scored(run, z)
    taken = int(run.taken[scored].sum())
    tail = (ratio(score.sum(), dimensions.sum()), ratio(run.nis[scored].sum(), taken), taken,
            float(run.log_likelihood.sum()), " ".join(run.event_names))
    return {**made, **dict(zip(TAIL, tail))}


def root_mean_square(errors: np.ndarray) -> float:
    """Of the rows where the state is known."""
    known = errors[np.isfinite(errors)]
    return float(np.sqrt(np.mean(known**2))) if len(known) else float("nan")


def ratio(score: float, count: int) -> float:
    return float(score) / int(count) if count else float("nan")


# ------------------------------------------------------------------------------ all runs


def refuse_without_runs(options: Sequence[str]) -> None:
    if options:
        raise KalmanqError(f"{', '.join(options)}: {'go' if len(options) > 1 else 'goes'} with --runs")


def simulate_runs(asked: Asked, console: Console) -> None:
    out = _out(asked)
    model = model_file.read(asked.model)
    rows, u = controls_of(asked.controls, model, asked.rows)
    asked = replace(asked, rows=rows)
    study = Study(model, rows, asked.seed, asked.arithmetic, asked.smooth, asked.gap, u)
    with progress_bar(f"{model.name}, {asked.arithmetic}") as progress:
        made = list(run_campaign(
            partial(one_run, study), range(asked.runs), fingerprint=_fingerprint(asked, u), journal=journal_of(out),
            workers=asked.workers, dask=asked.dask, progress=progress, fresh=asked.fresh))
    columns = {name: np.array([row[name] for row in made], object) for name in made[0]}
    with tables.Writer(out, list(columns), [asked.model]) as writer:
        writer.write(list(columns.values()))
    journal_of(out).unlink(missing_ok=True)
    _tell(asked, model, summary(columns), console)


def _out(asked: Asked) -> Path:
    """Where to write; what would be refused after all runs is refused before them."""
    if asked.out is None:
        raise KalmanqError("--runs: needs --out, a row a run")
    if asked.truth:
        raise KalmanqError("--truth: of one run alone, without --runs")
    if asked.workers is not None and asked.dask is not None:
        raise KalmanqError("--workers and --dask: one of them")
    if not asked.out.parent.is_dir():
        raise KalmanqError(f"{asked.out}: there is no such folder")
    if asked.out.exists() and asked.model.exists() and asked.out.samefile(asked.model):
        raise KalmanqError(f"{asked.out}: is an input; write to another file")
    return asked.out


def _fingerprint(asked: Asked, u: Optional[np.ndarray]) -> dict[str, Any]:
    """All that run k comes from; how many runs there are is no part of it."""
    driven = {} if u is None else {"controls": hashlib.sha256(u.tobytes()).hexdigest()}
    return {**driven, "study": "simulate", "model": hashlib.sha256(asked.model.read_bytes()).hexdigest(), "rows": asked.rows,
            "seed": asked.seed, "arithmetic": asked.arithmetic, "smooth": asked.smooth, "gap": asked.gap}


def summary(columns: dict[str, np.ndarray]) -> dict[str, Any]:
    """Means over the runs; NEES and NIS, which are 1 if all is right, with their bounds of 95 %.

    The innovations of a run are independent, so that NIS has the bounds of chi-square.  The errors of a run are
    not; runs are: NEES has the bounds of Student's t, from what the runs show.
    """
    figures = {name: _mean(values.astype(float)) for name, values in columns.items() if name not in NO_FIGURES}
    freedom = int(columns["taken"].sum())
    nis = ratio(float(np.nansum(columns["nis"].astype(float) * columns["taken"].astype(float))), freedom)
    error, runs = figures["nees"]["standard_error"], figures["nees"]["runs"]
    margin = None if error is None else student_limit(runs - 1) * error
    return {
        "columns": figures,
        "nees": _judged(figures["nees"]["mean"], None if margin is None else (1 - margin, 1 + margin)),
        "nis": _judged(nis, mean_bounds(freedom) if freedom else None),
        "runs_with_events": int(sum(map(bool, columns["events"])))}


def _mean(values: np.ndarray) -> dict[str, Any]:
    known = values[np.isfinite(values)]
    count = len(known)
    return {"mean": float(np.mean(known)) if count else None, "runs": count,
            "standard_error": float(np.std(known, ddof=1) / np.sqrt(count)) if count > 1 else None}


def _judged(mean: Optional[float], bounds: Optional[tuple[float, float]]) -> dict[str, Any]:
    if mean is None or mean != mean or bounds is None:
        return {"mean": None if mean != mean else mean, "bounds": None, "within": None}
    return {"mean": mean, "bounds": list(bounds), "within": bool(bounds[0] <= mean <= bounds[1])}


def _tell(asked: Asked, model: Model, said: dict[str, Any], console: Console) -> None:
    if asked.json:
        print(json.dumps({"model": model.name, "arithmetic": asked.arithmetic, "rows": asked.rows,
                          "runs": asked.runs, "seed": asked.seed, **said}, indent=2))
        return
    table = Table("column", "mean", "standard error", title_justify="left",
                  title=f"{model.name}: {asked.runs} runs of {asked.rows} rows, {asked.arithmetic}")
    for name, of in said["columns"].items():
        table.add_row(name, *("" if of[key] is None else f"{of[key]:.6g}" for key in ("mean", "standard_error")))
    console.print(table)
    for name, what in (("nees", "NEES a dimension"), ("nis", "NIS a measurement")):
        of = said[name]
        if of["bounds"] is None:
            console.print(f"{what}: too few runs to judge")
        else:
            console.print(f"{what} {of['mean']:.4f}: {'within' if of['within'] else 'OUTSIDE'} its bounds of 95 %, "
                          f"{of['bounds'][0]:.4f} to {of['bounds'][1]:.4f}")
    if said["runs_with_events"]:
        console.print(f"events in {said['runs_with_events']} runs")
    console.print(f"wrote {asked.out}")
