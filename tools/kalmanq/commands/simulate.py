"""kalmanq simulate: measurements drawn from a model."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Optional, Union

import numpy as np

from kalmanq import nonlinear
from kalmanq.data import tables
from kalmanq.errors import KalmanqError
from kalmanq.model import Model, root_of
from kalmanq.nonlinear import NonlinearModel
from kalmanq.nonlinear.file import read_any

ROWS = 200  # if nothing says how many


def simulate(model: Model, rows: int, seed: Union[int, np.random.SeedSequence],
             u: Optional[np.ndarray] = None) -> tuple[np.ndarray, np.ndarray]:
    """States (rows x n) and measurements (rows x m).  An unknown state begins at x0."""
    if model.l and u is None:
        u = np.zeros((rows, model.l))
    draw = np.random.Generator(np.random.PCG64(seed))
    G = root_of(model.Q) if model.G is None else model.G
    V, S = root_of(model.R), root_of(model.P0)
    x = np.empty((rows, model.n))
    x[0] = model.x0 + np.where(model.unknown, 0, S @ draw.standard_normal(model.n))
    noise, error = draw.standard_normal((rows, G.shape[1])), draw.standard_normal((rows, model.m))
    for t in range(1, rows):
        x[t] = model.A @ x[t - 1] + G @ noise[t]
        if model.B is not None and u is not None:
            x[t] += model.B @ u[t - 1]
    return x, x @ model.H.T + error @ V.T


def drawn(model: Model, rows: int, seed: Union[int, np.random.SeedSequence], gap: Optional[tuple[int, int]],
          u: Optional[np.ndarray] = None) -> tuple[np.ndarray, np.ndarray]:
    """As simulate, without the measurements of a gap."""
    _refuse_gap(gap, rows)
    x, z = simulate(model, rows, seed, u)
    if not np.all(np.isfinite(z)):
        raise KalmanqError(f"{model.name}: the states leave the numbers within {rows} rows")
    if gap:
        z[gap[0] : gap[1]] = np.nan
    return x, z


def drawn_nonlinear(model: NonlinearModel, rows: int, seed: int, gap: Optional[tuple[int, int]],
                    given: Optional[np.ndarray] = None) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """States, measurements and controls"""
    _refuse_gap(gap, rows)
    x, z, u = nonlinear.simulate(model, rows, seed, given)
    if gap:
        z[gap[0] : gap[1]] = np.nan
    return x, z, u


def controls_of(path: Optional[tables.AnySource], model: Union[Model, NonlinearModel],
                rows: Optional[int]) -> tuple[int, Optional[np.ndarray]]:
    """Rows to draw, and their controls, if there is a file of them"""
    if path is None:
        return rows or ROWS, None
    if not model.l:
        raise KalmanqError(f"--controls {path}: the model has no controls")
    block = tables.joined(list(tables.read(path, model.controls)))
    u = tables.controls_in(block, model.controls, path)
    if rows is not None and len(u) < rows:
        raise KalmanqError(f"--controls {path}: has {len(u)} rows, fewer than the {rows} of -n")
    return rows or len(u), u[: rows or len(u)]


def _refuse_gap(gap: Optional[tuple[int, int]], rows: int) -> None:
    if gap and not 0 <= gap[0] < gap[1] <= rows:
        raise KalmanqError(f"--gap {gap[0]} {gap[1]}: from a row to one after it, within {rows} rows")


def simulate_file(path: Path, rows: Optional[int], seed: int, out: Optional[Path], truth: bool,
                  gap: Optional[tuple[int, int]], controls: Optional[tables.AnySource] = None) -> None:
    model = read_any(path)
    rows, given = controls_of(controls, model, rows)
    x, z, u = drawn_nonlinear(model, rows, seed, gap, given) if isinstance(model, NonlinearModel) else \
        (*drawn(model, rows, seed, gap, given), np.zeros((rows, model.l)) if given is None else given)
    columns = {"step": np.arange(rows)}
    columns.update({one.name: z[:, c] for c, one in enumerate(model.measurements)})
    columns.update({one.name: u[:, c] for c, one in enumerate(model.controls)})
    if truth:
        taken = [one.name for one in model.states if f"{one.name}_true" in columns]
        if taken:
            raise KalmanqError(f"--truth: there is a column {taken[0]}_true already")
        columns.update({f"{one.name}_true": x[:, i] for i, one in enumerate(model.states)})
    if out is None:
        tables.write_text(sys.stdout, list(columns), list(columns.values()))
        return
    with tables.Writer(out, list(columns), [path, *([controls] if controls else [])]) as writer:
        writer.write(list(columns.values()))
