"""Records that the C of a nonlinear model is tried with."""

from __future__ import annotations

from typing import Optional

import numpy as np

from kalmanq.compiler.run.record import Record, clock_of
from kalmanq.compiler.text.emit import PREDICTS, UPDATES
from kalmanq.nonlinear import NonlinearModel, simulate

MISSING = 0.1  # share of the components


def drawn(model: NonlinearModel, rows: int, seed: int) -> Record:
    times = irregular(model, rows, seed)
    _, z, u = simulate(model, rows, seed, times=times)
    z, u = (one.astype(np.float32).astype(float) for one in (z, u))
    z[np.random.default_rng(seed).random(z.shape) < MISSING] = np.nan
    return recorded(model, z, u, times)


def irregular(model: NonlinearModel, rows: int, seed: int) -> Optional[np.ndarray]:
    """Of a model whose functions take the step: half of it to one and a half, each a float"""
    if not model.takes_step:
        return None
    if model.dt is None:
        raise model.step_error()
    steps = (model.dt * np.random.default_rng(seed + 1000).uniform(0.5, 1.5, rows - 1)).astype(np.float32)
    return np.concatenate([[0], np.cumsum(steps.astype(float))])


def recorded(model: NonlinearModel, z: np.ndarray, u: np.ndarray, times: Optional[np.ndarray] = None) -> Record:
    """Of measurements, NaN where they are missing, and controls; times: of the rows, if they have any"""
    rows = len(z)
    present = (~np.isnan(z)) @ (1 << np.arange(model.m))
    what = PREDICTS * (np.arange(rows) > 0) + UPDATES * (present > 0)
    carried = np.vstack([np.zeros((1, model.l)), u[:-1]])
    return Record(what.astype(np.uint8), present.astype(np.uint32), np.nan_to_num(z), carried, u, None if times is None else clock_of(times))
