"""What a task comes to: for each estimator columns of numbers, one for each run."""

from __future__ import annotations

from typing import Dict, List

import numpy as np

from kalmanq.errors import KalmanqError
from kalmanq_studies.heavy_tails import estimators
from kalmanq_studies.heavy_tails.grid import FINER, Grid, posterior_means
from kalmanq_studies.heavy_tails.settings import Task

Columns = Dict[str, List[float]]
REFINED = 10  # runs of a block that are computed on a finer grid, too


def perform(task: Task) -> dict[str, Columns]:
    try:
        x, z = task.draw()
        if task.part in ("known", "skewed"):
            filtered, smoothed = estimators.known(task.setting, z)
            return {"known": {**errors("filter", filtered - x), **errors("smoother", smoothed - x)}}
        return _fitted(task, x, z) if task.part == "fitted" else _robust(task, x, z)
    except KalmanqError as problem:
        raise KalmanqError(f"{task.part}, Q/R = {task.setting.ratio:g}, alpha = {task.alpha:g}, block "
                           f"{task.block}: {problem}") from None


def errors(kind: str, error: np.ndarray) -> Columns:
    """Mean square and mean size of each run's errors, runs x rows"""
    return {f"{kind}_square": np.mean(error**2, axis=1).tolist(),
            f"{kind}_size": np.mean(np.abs(error), axis=1).tolist()}


def _fitted(task: Task, x: np.ndarray, z: np.ndarray) -> dict[str, Columns]:
    filtered, smoothed = estimators.known(task.setting, z)
    made = {"known": {**errors("filter", filtered - x), **errors("smoother", smoothed - x),
                      **errors("measured", filtered - x)}}
    for fitting in estimators.fittings(task.setting):
        runs = [estimators.fitted(fitting, task.setting, row) for row in z]
        filtered, smoothed = (np.stack([getattr(run, name) for run in runs]) for name in ("filtered", "smoothed"))
        H = np.array([run.model.H[0, 0] for run in runs])[:, None]
        made[fitting.name] = {
            **errors("filter", filtered - x), **errors("smoother", smoothed - x),
            **errors("measured", H * filtered - x),
            **{name: [float(getattr(run.model, name).ravel()[0]) for run in runs] for name in estimators.SIX},
            "K": [run.weight for run in runs], "P": [run.variance for run in runs],
            "converged": [float(run.converged) for run in runs]}
    return made


def _robust(task: Task, x: np.ndarray, z: np.ndarray) -> dict[str, Columns]:
    """Beside the exact posterior means, and how far those move when the grid is refined, in some of the runs"""
    exact = posterior_means(Grid(task.alpha, task.setting.sigma), z)
    finer = posterior_means(Grid(task.alpha, task.setting.sigma, **FINER), z[:REFINED])
    made: dict[str, Columns] = {"exact": {
        **errors("filter", exact[0] - x), **errors("smoother", exact[1] - x),
        "refined": [max(float(np.abs(coarse[:REFINED] - fine).max()) for coarse, fine in zip(exact, finer))]}}
    for kind, states in (("filter", estimators.robust_filters(task.setting, z)),
                         ("smoother", estimators.robust_smoothers(task.setting, z))):
        for name, estimated in states.items():
            made.setdefault(name, {}).update(errors(kind, estimated - x))
    return made
