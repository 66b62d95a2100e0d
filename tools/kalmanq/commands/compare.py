"""kalmanq compare: every arithmetic beside double."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Optional

import numpy as np
from rich.console import Console
from rich.table import Table

from kalmanq.data import tables
from kalmanq.errors import KalmanqError
from kalmanq.model import model_file
from kalmanq.model import Model
from kalmanq.run.filters import Filter
from kalmanq.run.results import Run


def compare(model: Model, z: np.ndarray, u: Optional[np.ndarray]) -> tuple[dict[str, np.ndarray], dict[str, dict]]:
    """Worst error of a mean in sigma, at every row and of each arithmetic; the figures of each."""
    exact = Filter(model, "f64").run(z, u)
    errors, figures = {}, {}
    for name in ("f32", "q31"):
        try:
            run = Filter(model, name).run(z, u)
        except KalmanqError as problem:
            figures[name] = {"refused": str(problem)}
            continue
        errors[name], figures[name] = beside(run, exact)
    return errors, figures


def beside(run: Run, exact: Run) -> tuple[np.ndarray, dict]:
    """A run beside another one of the same rows: the worst error of a mean in sigma at each row, and figures"""
    assert run.sigma is not None and run.log_likelihood is not None
    assert exact.sigma is not None and exact.log_likelihood is not None
    with np.errstate(invalid="ignore", divide="ignore"):
        error = np.abs(run.mean - exact.mean) / exact.sigma
        sigma = np.abs(run.sigma / exact.sigma - 1)
    worst = np.nan_to_num(np.max(error, axis=1), nan=0.0)
    row = int(np.argmax(worst))
    return worst, {
        "mean_error_in_sigma": float(np.nanmax(error)), "worst_row": row,
        "worst_state": run.model.states[int(np.argmax(error[row]))].name,
        "sigma_relative_error": float(np.nanmax(sigma)),
        "log_likelihood_error": float(np.sum(run.log_likelihood) - np.sum(exact.log_likelihood)),
        "events": run.event_names}


def table_of(figures: dict[str, dict], title: str) -> Table:
    table = Table("arithmetic", "mean, in sigma", "at row, state", "sigma, relative", "log-likelihood", "events",
                  title=title, title_justify="left")
    for name, of in figures.items():
        if "refused" in of:
            table.add_row(name, of["refused"])
        else:
            table.add_row(name, f"{of['mean_error_in_sigma']:.2g}", f"{of['worst_row']}, {of['worst_state']}",
                          f"{of['sigma_relative_error']:.2g}", f"{of['log_likelihood_error']:.2g}",
                          ", ".join(of["events"]))
    return table


def compare_file(model_path: Path, data: tables.AnySource, plot: Optional[Path], as_json: bool, console: Console) -> None:
    model = model_file.read(model_path)
    z, u = tables.measurements_and_controls(data, model)
    errors, figures = compare(model, z, u)
    if plot:
        from kalmanq.pages import pictures

        pictures.save(pictures.draw_errors(errors), plot, [data, model_path])
    if as_json:
        print(json.dumps(figures, indent=2))
        return
    console.print(table_of(figures, f"{model.name}: worst errors of {len(z)} rows beside double"))
    if plot:
        console.print(f"wrote {plot}")
