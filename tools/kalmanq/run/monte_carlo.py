"""How far off a filter of the right model is, over many runs."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any, Callable, Optional

import numpy as np

from kalmanq.errors import KalmanqError, KalmanqWarning
from kalmanq.model import Model
from kalmanq.run.diagnostics import is_scored, mean_bounds, nees, student_limit
from kalmanq.run.comparison import Filtered, filtered
from kalmanq.run.filters import Smoother
from kalmanq.run.simulation import drawn

NO_FIGURES = ("run", "taken", "events")  # columns without a mean over the runs
TAIL = ("nees", "nis", "taken", "loglik", "events")


def rows_of_run(model: Model, rows: int, seed: np.random.SeedSequence, gap: Optional[tuple[int, int]],
                u: Optional[np.ndarray], times: Optional[np.ndarray] = None
                ) -> tuple[np.ndarray, np.ndarray, Optional[np.ndarray]]:
    """States, measurements, controls"""
    return (*drawn(model, rows, seed, gap, u, times), u)


def errors_of_run(model: Model, mean: np.ndarray, x: np.ndarray) -> np.ndarray:
    return mean - x


@dataclass(frozen=True)
class Study:
    """What every run is of.  filtered, drawn, errors: functions of modules"""

    model: Any
    rows: int
    seed: int
    arithmetic: str
    smooth: bool
    gap: Optional[tuple[int, int]]
    u: Optional[np.ndarray] = None
    filtered: Filtered = filtered
    drawn: Callable[..., tuple] = rows_of_run
    errors: Callable[..., np.ndarray] = errors_of_run
    times: Optional[np.ndarray] = None  # `drawn` and `filtered` know of them


# ------------------------------------------------------------------------------ a run


def one_run(study: Study, run: int) -> dict[str, Any]:
    """Run `run` of a study: its row of the table.  It draws from a stream of its own."""
    try:
        return _row(study, run)
    except KalmanqError as problem:
        raise KalmanqError(f"run {run}: {problem}") from None


def _row(study: Study, number: int) -> dict[str, Any]:
    model = study.model
    x, z, u = study.drawn(model, study.rows, np.random.SeedSequence(study.seed, spawn_key=(number,)), study.gap, study.u)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", KalmanqWarning)  # the row has the events
        run = study.filtered(model, study.arithmetic, z, u)
        smoothed = Smoother(model, study.arithmetic).run(z, u, times=study.times).smoothed if study.smooth else None
    errors = study.errors(model, run.mean, x)
    made: dict[str, Any] = {"run": number}
    for i, state in enumerate(model.states):
        made[f"{state.name}_rmse"] = root_mean_square(errors[:, i])
        if smoothed is not None:
            made[f"{state.name}_smoothed_rmse"] = root_mean_square(smoothed[:, i] - x[:, i])
    score, dimensions = nees(errors, run.covariance, study.arithmetic)
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
