"""Runs drawn from a model."""

from __future__ import annotations

from typing import Mapping, Optional, Union

import numpy as np

from kalmanq.data.rows import Rows, controls_of
from kalmanq.errors import KalmanqError
from kalmanq.model import ColumnModel, Model, root_of


def simulate(model: Model, rows: int, seed: Union[int, np.random.SeedSequence], u: Optional[np.ndarray] = None,
             times: Optional[np.ndarray] = None) -> tuple[np.ndarray, np.ndarray]:
    """States (rows x n) and measurements (rows x m).  An unknown state begins at x0."""
    if isinstance(model, ColumnModel) and u is None:
        raise KalmanqError(f"{model.name} has numbers from columns: give a file of them, --controls FILE with {', '.join(one.name for one in model.inputs)}")
    given = Rows.of(model, np.zeros((rows, model.m)), u)
    u = given.u if given.u is not None or not model.l else controls_of(np.zeros((rows, model.l)), model, rows)
    draw = np.random.Generator(np.random.PCG64(seed))
    A, B, G = _steps(model, rows, times, given.matrices)
    V, S = root_of(given.matrices.get("R", model.R)), root_of(model.P0)
    x = np.empty((rows, model.n))
    x[0] = model.x0 + np.where(model.unknown, 0, S @ draw.standard_normal(model.n))
    noise, error = draw.standard_normal((rows, G.shape[2])), draw.standard_normal((rows, model.m))
    for t in range(1, rows):
        x[t] = A[t] @ x[t - 1] + G[t] @ noise[t]
        if B is not None and u is not None:
            x[t] += B[t] @ u[t - 1]
    if V.ndim == 2 and "H" not in given.matrices:
        z = x @ model.H.T + error @ V.T
    else:
        z = (given.matrices.get("H", model.H) @ x[:, :, None] + V @ error[:, :, None])[..., 0]
    return x, z + (0.0 if model.frame.d is None else model.frame.d) + (0.0 if given.fed is None else given.fed)


def read_off(z: np.ndarray, model: Model) -> np.ndarray:
    """Measurements in the steps that their sensors have: the last bits of the fractions that the model declares"""
    for k, one in enumerate(model.measurements):
        if one.fraction is not None:
            z[:, k] = np.ldexp(np.rint(np.ldexp(z[:, k], one.fraction)), -one.fraction)
    return z


def _steps(model: Model, rows: int, times: Optional[np.ndarray], matrices: Mapping[str, np.ndarray]) -> list[Optional[np.ndarray]]:
    """A, B and the root of Q of the step to each row; matrices: of the step after it, where they vary"""
    if times is None or model.continuous is None:
        own = {"A": model.A, "B": model.B, "G": root_of(model.Q) if model.G is None and "Q" not in matrices else model.G}
        own.update({"G": root_of(matrices["Q"])} if "Q" in matrices else {}, **{name: matrices[name] for name in matrices.keys() & {"A", "B"}})
        return [None if one is None else np.broadcast_to(one, (rows, *one.shape)) if one.ndim == 2 else np.roll(one, 1, axis=0) for one in own.values()]
    dt, which = np.unique(np.append(model.continuous.dt, model.continuous.between(times)), return_inverse=True)
    A, Q, B = model.continuous.steps(dt)
    return [None if one is None else one[which] for one in (A, B, root_of(Q))]


def drawn(model: Model, rows: int, seed: Union[int, np.random.SeedSequence], gap: Optional[tuple[int, int]],
          u: Optional[np.ndarray] = None, times: Optional[np.ndarray] = None) -> tuple[np.ndarray, np.ndarray]:
    """As simulate, without the measurements of a gap."""
    x, z = simulate(model, rows, seed, u, times)
    if not np.all(np.isfinite(z)):
        raise KalmanqError(f"{model.name}: a state overflows within {rows} rows: draw fewer rows, or correct A")
    if gap:
        z[gap[0] : gap[1]] = np.nan
    return x, z
