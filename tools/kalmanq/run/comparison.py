"""Every arithmetic compared with double."""

from __future__ import annotations

from functools import partial
from typing import Callable, Mapping, Optional

import numpy as np

from kalmanq.errors import KalmanqError
from kalmanq.model import Model
from kalmanq.run.filters import Filter
from kalmanq.run.results import Run


Filtered = Callable[[Model, str, np.ndarray, Optional[np.ndarray]], Run]  # of a model in an arithmetic


def filtered(model: Model, arithmetic: str, z: np.ndarray, u: Optional[np.ndarray], times: Optional[np.ndarray] = None) -> Run:
    return Filter(model, arithmetic).run(z, u, times=times, covariance=True)


def compare(model: Model, z: np.ndarray, u: Optional[np.ndarray], others: Mapping[str, Filtered] = {},
            times: Optional[np.ndarray] = None) -> tuple[dict[str, np.ndarray], dict[str, dict]]:
    """Worst error of a mean in sigma, at every row and of each arithmetic; the figures of each.  others: filters beside
    the library's, by what goes before the arithmetic's name"""
    exact = Filter(model, "f64").run(z, u, times=times)
    errors, figures = {}, {}
    for before, run_of in {"": partial(filtered, times=times), **others}.items():
        for arithmetic in ("f32", "q31"):
            name = f"{before} {arithmetic}".strip()
            try:
                run = run_of(model, arithmetic, z, u)
            except KalmanqError as problem:
                figures[name] = {"refused": str(problem)}
                continue
            errors[name], figures[name] = beside(run, exact)
    return errors, figures


def beside(run: Run, exact: Run) -> tuple[np.ndarray, dict]:
    """A run beside another one of the same rows: the worst error of a mean in sigma at each row, and figures"""
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
