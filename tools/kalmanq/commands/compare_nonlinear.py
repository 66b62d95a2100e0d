"""kalmanq compare, of a nonlinear model: arithmetics beside double, and methods beside each other."""

from __future__ import annotations

import json
import warnings
from pathlib import Path
from typing import Any, Optional

import numpy as np
from rich.console import Console
from rich.table import Table

from kalmanq.commands.compare import beside, table_of
from kalmanq.data import tables
from kalmanq.errors import KalmanqError, KalmanqWarning
from kalmanq.nonlinear.file import read
from kalmanq.nonlinear.filters import NonlinearFilter
from kalmanq.nonlinear.model import NonlinearModel
from kalmanq.nonlinear.smoothers import NonlinearSmoother
from kalmanq.run.diagnostics import nees
from kalmanq.run.results import Run

TRIED = (("extended", 1), ("iterated", 1), ("cubature", 1), ("central", 1), ("posterior", 1), ("extended", 6),
         ("cubature", 6))  # method, passes of the smoother
ARITHMETICS = (("f32", "extended"), ("f32", "cubature"), ("q31", "extended"))
SHOWN = 4  # states in the table; the JSON has all


def arithmetics(model: NonlinearModel, z: np.ndarray,
                u: Optional[np.ndarray]) -> tuple[dict[str, np.ndarray], dict[str, dict]]:
    """As commands.compare.compare, each beside the same method in double"""
    errors, figures = {}, {}
    exact: dict[str, Run] = {}
    for name, method in ARITHMETICS:
        key = f"{name}, {method}"
        try:
            if method not in exact:
                exact[method] = NonlinearFilter(model, "f64", method).run(z, u)
            errors[key], figures[key] = beside(NonlinearFilter(model, name, method).run(z, u), exact[method])
        except KalmanqError as problem:
            figures[key] = {"refused": str(problem)}
    return errors, figures


def compare_methods(model: NonlinearModel, z: np.ndarray, u: Optional[np.ndarray],
                    truth: Optional[np.ndarray]) -> dict[str, dict]:
    """What each method finds in double: filtered, and smoothed; errors where the true states are known."""
    made = {}
    for method, passes in TRIED:
        smoother = NonlinearSmoother(model, "f64", method, passes=passes)
        key = method if passes == 1 else f"{method}, {passes} passes"
        try:
            with warnings.catch_warnings(record=True) as told:
                warnings.simplefilter("always", KalmanqWarning)
                run = smoother.run(z, u, covariance=True)
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
    assert run.nis is not None and run.taken is not None and run.log_likelihood is not None
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
        assert states is not None and covariance is not None
        errors = states - truth
        made[f"{which}_rms"] = dict(zip(model.state_names, np.sqrt(np.nanmean(errors**2, axis=0)).tolist()))
        score, dimensions = nees(errors, covariance, "f64")
        total = int(dimensions.sum())
        made[f"{which}_nees_per_state"] = float(score[dimensions > 0].sum()) / total if total else None
    return made


def compare_file(path: Path, data: tables.AnySource, plot: Optional[Path], as_json: bool, console: Console) -> None:
    model = read(path)
    true_states = [f"{name}_true" for name in model.state_names]  # where there is one for each state
    z, u, truth = tables.measurements_controls_and(data, model, true_states)
    errors, figures = arithmetics(model, z, u)
    found = compare_methods(model, z, u, truth)
    if plot:
        from kalmanq.pages import pictures

        pictures.save(pictures.draw_errors(errors), plot, [data, path])
    if as_json:
        print(json.dumps({"arithmetics": figures, "methods": found}, indent=2))
        return
    console.print(table_of(figures, f"{model.name}: worst errors of {len(z)} rows beside double"))
    console.print(_methods_table(model, found, len(z), truth is not None))
    for told in sorted({one for of in found.values() for one in of.get("warnings", [])}):
        console.print(f"(!) {told}")
    for method, of in found.items():
        if "refused" in of:
            console.print(f"{method}: {of['refused']}")
    if plot:
        console.print(f"wrote {plot}")


def _methods_table(model: NonlinearModel, found: dict[str, dict], rows: int, is_known: bool) -> Table:
    shown = model.state_names[:SHOWN] if is_known else []
    known = ["NEES", "smoothed", *(f"RMS {name}" for name in shown)] if is_known else []
    said = "NIS a measurement" + (", NEES a state; RMS of smoothed states" if is_known else "")
    table = Table("method", "NIS", "log-likelihood", *known, title_justify="left",
                  title=f"{model.name}: methods in double, {rows} rows; {said}")
    for method, of in found.items():
        if "refused" in of:
            table.add_row(method, "refused")
            continue
        cells = [_cell(of.get("nis_per_measurement"), ".3f"), _cell(of.get("log_likelihood"), ".2f")]
        if is_known:
            cells += [_cell(of.get("filtered_nees_per_state"), ".4g"), _cell(of["smoothed_nees_per_state"], ".4g")]
            cells += [f"{of['smoothed_rms'][name]:.4g}" for name in shown]
        table.add_row(method + (" (!)" if of["warnings"] else ""), *cells)
    return table


def _cell(value: Optional[float], form: str) -> str:
    return "" if value is None else format(value, form)
