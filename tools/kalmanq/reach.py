"""How far states, measurements and controls go: what the formats of fixed point have to hold."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Optional, Sequence

import numpy as np
from scipy.linalg import solve_discrete_lyapunov

from kalmanq.commands.simulate import simulate
from kalmanq.errors import KalmanqError
from kalmanq.filters import Filter
from kalmanq.model import Model, Quantity
from kalmanq.parts import is_diagonal

MARGIN = 1.5  # a range is so many times what was reached
FAR = 6.0  # sigmas that a stationary state may be from its mean
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
            spans = np.array([one.range or 0.0 for one in model.controls])
            u = random.uniform(-spans, spans, (rows, model.l))
        x, z = simulate(model, rows, seed, u)
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
    for h, r, z in zip(model.H, np.diag(model.R), record.z[1:].T):
        gain = S @ h
        variance = gain @ h + r
        there = np.isfinite(z) & (variance > 0) & np.isfinite(variance)
        share = np.where(there, (np.where(there, z, 0) - x @ h) / np.where(there, variance, 1), 0)
        x = x + gain * share[:, None]
        S = S - np.where(there, 1 / np.where(there, variance, 1), 0)[:, None, None] * gain[:, :, None] * gain[:, None, :]
        most = np.fmax(most, np.nanmax(np.abs(x), axis=0, initial=0.0))
    return most


# ------------------------------------------------------------------------------ ranges


def with_ranges(model: Model, records: Sequence[Record]) -> tuple[Model, list[str]]:
    """The model with ranges for all that has none, from records or from the model itself; what was chosen."""
    lacking = [one for which in (model.states, model.measurements, model.controls) for one in which if one.range is None]
    if not lacking:
        return model, []
    found = reach(model, records) if records else _stationary(model, lacking[0])
    if records and np.any(model.unknown):
        found = replace(found, states=np.fmax(found.states, FAR * _first_sigmas(model, records)))
    notes: list[str] = []
    changed = {which: [_ranged(one, span, notes) for one, span in zip(getattr(model, which), getattr(found, which))]
               for which in ("states", "measurements", "controls")}
    return model.changed(**changed), notes


def widened(model: Model, records: Sequence[Record]) -> tuple[Model, list[str]]:
    """The model with wider ranges where the records, in double, go beyond those that it declares; what was widened"""
    found, said = reach(model, records), []
    changed = {}
    for which in ("states", "measurements", "controls"):
        changed[which] = list(getattr(model, which))
        for k, (one, span) in enumerate(zip(changed[which], getattr(found, which))):
            if one.range is not None and span > one.range and np.isfinite(span):
                made = _rounded_up(MARGIN * span)
                changed[which][k] = replace(one, range=made, fraction=None)
                said.append(f"a range of {made:g} for {one.name}, which reaches {span:.3g} and declares {one.range:g}")
    return (model.changed(**changed), said) if said else (model, said)


def _first_sigmas(model: Model, records: Sequence[Record]) -> np.ndarray:
    """The largest sigma of each state once it is known: ranges that leave room for it do not act as a prior of q31."""
    runs = [Filter(model, "f64").run(record.z, record.u) for record in records if len(record.z)]
    return np.max([np.nanmax(run.sigma, axis=0, initial=0.0) for run in runs], axis=0, initial=0.0)


def _ranged(one: Quantity, span: float, notes: list[str]) -> Quantity:
    if one.range is not None:
        return one
    if not (np.isfinite(span) and span > 0):
        raise KalmanqError(f"{one.name} has no range, and none can be told from the data: give it one")
    made = _rounded_up(MARGIN * span)
    notes.append(f"{one.label}: a range of {made:g} was chosen; it reaches {span:.3g}")
    return replace(one, range=made)


def _rounded_up(value: float) -> float:
    """To two digits"""
    unit = 10.0 ** (np.floor(np.log10(value)) - 1)
    return float(np.ceil(value / unit) * unit)


def _stationary(model: Model, first: Quantity) -> Reach:
    """Six sigmas of what a model without data comes to, if it comes to anything."""
    if np.abs(np.linalg.eigvals(model.A)).max() >= 1 or np.any(model.unknown) or model.l:
        raise KalmanqError(f"{first.name} has no range, and the model does not tell one: its states wander; "
                           "give ranges, or --data")
    covariance = np.fmax(np.diag(solve_discrete_lyapunov(model.A, model.Q)), np.diag(model.P0))
    # a start that is not the mean fades with A
    states = np.abs(model.x0) + FAR * np.sqrt(covariance)
    settled = solve_discrete_lyapunov(model.A, model.Q) + model.P0
    measured = np.sqrt(np.einsum("ci,ij,cj->c", model.H, settled, model.H) + np.diag(model.R))
    return Reach(states, np.abs(model.H) @ np.abs(model.x0) + FAR * measured, np.zeros(0))
