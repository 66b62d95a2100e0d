"""Of a nonlinear model: arithmetics compared with double, and methods beside each other."""

from __future__ import annotations

import warnings
from typing import Any, Callable, Mapping, Optional

import numpy as np

from kalmanq.errors import KalmanqError, KalmanqWarning
from kalmanq.nonlinear.filters import NonlinearFilter
from kalmanq.nonlinear.model import NonlinearModel
from kalmanq.nonlinear.smoothers import NonlinearSmoother
from kalmanq.run.comparison import beside
from kalmanq.run.diagnostics import nees
from kalmanq.run.results import Run

TRIED = (("extended", 1), ("iterated", 1), ("cubature", 1), ("central", 1), ("posterior", 1), ("extended", 6),
         ("cubature", 6))  # method, passes of the smoother
ARITHMETICS = (("f32", "extended"), ("f32", "cubature"), ("q31", "extended"))


def arithmetics(model: NonlinearModel, z: np.ndarray, u: Optional[np.ndarray], others: Mapping[str, Callable[..., Run]] = {},
                times: Optional[np.ndarray] = None) -> tuple[dict[str, np.ndarray], dict[str, dict]]:
    """As run.comparison.compare, each beside the same method in double.  others: more extended filters, by name"""
    errors, figures = {}, {}
    exact: dict[str, Run] = {}
    rows = [(f"{name}, {method}", method, lambda name=name, method=method: NonlinearFilter(model, name, method).run(z, u, times=times))
            for name, method in ARITHMETICS]
    rows += [(name, "extended", lambda run=run: run(model, z, u, times=times)) for name, run in others.items()]
    for key, method, run in rows:
        try:
            if method not in exact:
                exact[method] = NonlinearFilter(model, "f64", method).run(z, u, times=times)
            errors[key], figures[key] = beside(run(), exact[method])
        except KalmanqError as problem:
            figures[key] = {"refused": str(problem)}
    return errors, figures


def compare_methods(model: NonlinearModel, z: np.ndarray, u: Optional[np.ndarray],
                    truth: Optional[np.ndarray], times: Optional[np.ndarray] = None) -> dict[str, dict]:
    """What each method finds in double: filtered, and smoothed; errors where the true states are known."""
    made = {}
    for method, passes in TRIED:
        smoother = NonlinearSmoother(model, "f64", method, passes=passes)
        key = method if passes == 1 else f"{method}, {passes} passes"
        try:
            with warnings.catch_warnings(record=True) as told:
                warnings.simplefilter("always", KalmanqWarning)
                run = smoother.run(z, u, times=times, covariance=True)
        except KalmanqError as problem:
            if len(made) == len(TRIED) - 1 and all("refused" in of for of in made.values()):
                raise  # the last of them all
            made[key] = {"refused": str(problem)}
            continue
        made[key] = _figures(model, run, truth, passes == 1)
        if passes > 1:
            made[key]["is_settled"] = smoother.is_settled
        made[key]["warnings"] = [str(one.message) for one in told if one.category is KalmanqWarning]
    return made


def _figures(model: NonlinearModel, run: Run, truth: Optional[np.ndarray], is_filter: bool) -> dict[str, Any]:
    taken = int(run.taken.sum())
    made: dict[str, Any] = {}
    if is_filter:
        made["nis_per_measurement"] = float(np.nansum(run.nis)) / taken if taken else None
        made["log_likelihood"] = float(np.sum(run.log_likelihood))
    if truth is None:
        return made
    for which, states, covariance in (("filtered", run.mean, run.covariance),
                                      ("smoothed", run.smoothed, run.smoothed_covariance)):
        if which == "filtered" and not is_filter:
            continue
        errors = states - truth
        made[f"{which}_rms"] = dict(zip(model.state_names, np.sqrt(np.nanmean(errors**2, axis=0)).tolist()))
        score, dimensions = nees(errors, covariance, "f64")
        total = int(dimensions.sum())
        made[f"{which}_nees_per_state"] = float(score[dimensions > 0].sum()) / total if total else None
    return made
