"""How far states, measurements and controls go in records: what the formats of fixed point have to hold."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Optional, Sequence

import numpy as np

from kalmanq.data.rows import controls_of
from kalmanq.model import Model, Quantity
from kalmanq.run.filters import Filter
from kalmanq.run.parts import is_diagonal
from kalmanq.run.simulation import read_off, simulate

MARGIN = 1.5  # a range is so many times what was reached
ROWS, SEEDS = 500, 12  # of the records that are drawn where there are none


@dataclass(frozen=True)
class Record:
    z: np.ndarray
    u: Optional[np.ndarray] = None


@dataclass(frozen=True)
class Reach:
    """The largest |value| of each"""

    states: np.ndarray
    measurements: np.ndarray
    controls: np.ndarray


def draw(model: Model, rows: int = ROWS, seeds: Sequence[int] = range(SEEDS)) -> list[Record]:
    """Records of the model, with gaps where it allows them; controls anywhere in their ranges.  One ends where
    it leaves the ranges that the model declares."""
    made = []
    for seed in seeds:
        random = np.random.Generator(np.random.PCG64([seed, rows]))
        u = None
        if model.l:
            spans = np.array([one.range or 0.0 for one in model.inputs])
            u = controls_of(random.uniform(-spans, spans, (rows, len(spans))), model, rows)
        x, z = simulate(model, rows, seed, u)
        z = read_off(z, model)
        end = min(_inside(x, model.states), _inside(z, model.measurements))
        _leave_gaps(model, z, random)
        made.append(Record(z[:end], None if u is None else u[:end]))
    return made


def _inside(values: np.ndarray, quantities: Sequence[Quantity]) -> int:
    """Rows before the first that is beyond 1 / MARGIN of a declared range"""
    spans = np.array([np.inf if one.range is None else one.range / MARGIN for one in quantities])
    beyond = np.any(np.abs(values) > spans, axis=1)
    return int(np.argmax(beyond)) if np.any(beyond) else len(values)


def _leave_gaps(model: Model, z: np.ndarray, random: np.random.Generator) -> None:
    if not model.gaps.max_gap:
        return
    run = model.gaps.min_run or 1
    row = run
    while row < len(z):
        end = row + int(random.integers(1, model.gaps.max_gap + 1))
        z[row:end] = np.nan
        row = end + run + int(random.integers(0, 20))


def reach(model: Model, records: Sequence[Record]) -> Reach:
    """In double: of states as they are predicted, between the components of a measurement, and updated."""
    states, measured = np.zeros(model.n), np.zeros(model.m)
    driven = np.zeros(model.l)
    for record in records:
        if not len(record.z):
            continue
        run = Filter(model, "f64").run(record.z, record.u, covariance=True)
        states = np.fmax(states, np.nanmax(np.abs(run.mean), axis=0, initial=0.0))
        states = np.fmax(states, _between(model, record, run.mean, run.covariance))
        measured = np.fmax(measured, np.nanmax(np.abs(record.z), axis=0, initial=0.0))
        if record.u is not None:
            driven = np.fmax(driven, np.nanmax(np.abs(record.u), axis=0))
    return Reach(states, measured, driven)


def _between(model: Model, record: Record, mean: np.ndarray, P: np.ndarray) -> np.ndarray:
    """The predicted means, and those that have some components of a measurement already."""
    x, S = mean[:-1] @ model.A.T, model.A @ P[:-1] @ model.A.T + model.Q
    if model.B is not None and record.u is not None:
        x = x + record.u[:-1] @ model.B.T
    most = np.nanmax(np.abs(x), axis=0, initial=0.0)
    if not is_diagonal(model.R):
        return most
    for h, r, z in zip(model.H, np.diag(model.R), (record.z[1:] - (0.0 if model.d is None else model.d)).T):
        gain = S @ h
        variance = gain @ h + r
        there = np.isfinite(z) & (variance > 0) & np.isfinite(variance)
        share = np.where(there, (np.where(there, z, 0) - x @ h) / np.where(there, variance, 1), 0)
        x = x + gain * share[:, None]
        S = S - np.where(there, 1 / np.where(there, variance, 1), 0)[:, None, None] * gain[:, :, None] * gain[:, None, :]
        most = np.fmax(most, np.nanmax(np.abs(x), axis=0, initial=0.0))
    return most
