"""How far states, measurements and controls go: what the formats of fixed point have to hold."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Iterator, Optional, Sequence

import numpy as np
from scipy.special import ndtri

from kalmanq.commands.simulate import simulate
from kalmanq.errors import KalmanqError
from kalmanq.filters import Filter
from kalmanq.model import Model, Quantity
from kalmanq.parts import is_diagonal

MARGIN = 1.5  # a range is so many times what was reached
CHANCE = 1e-6  # that a model goes farther than is said, within a life
LIFE, LEAST_LIFE = 4, 10_000  # times the rows of the longest record; rows
STEPS, FOREVER, MOST_REPLAYED = 1024, 1 << 40, 100_000  # rows: one by one, until what fades has, of controls
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


# ------------------------------------------------------------------------------ a life


@dataclass(frozen=True)
class Life:
    """What a model comes to within so many rows, without its measurements: states first, then measurements.

    reach    of each, which it leaves within the life by a chance of CHANCE at most; infinite: it grows by a power
    wanders  whether it would go farther in a longer life
    """

    rows: int
    reach: np.ndarray
    wanders: np.ndarray
    is_recorded: bool  # there are records, too


def life_of(model: Model, records: Sequence[Record]) -> Life:
    """From the prior on: an estimate has no larger variance than what is estimated.  Of a start that is unknown the
    records have to tell."""
    rows = max(LEAST_LIFE, LIFE * max((len(one.z) for one in records), default=0))
    sees = np.concatenate([np.eye(model.n), model.H])
    noise = np.concatenate([np.zeros(model.n), np.diag(model.R)])
    sigmas = tail(rows * len(sees))
    driven, moves = _driven(model, records, rows, sees)
    spread = model.Q if model.B is None else model.Q + model.B @ _spread(model, records) @ model.B.T
    with np.errstate(over="ignore", invalid="ignore"):
        most = [far + sigmas * np.sqrt(variance + noise) for far, variance in _grown(model, spread, rows, sees)]
    now, later = (np.where(np.isfinite(one), one, np.inf) + driven for one in most)
    return Life(rows, now, ~(later <= 1.01 * now) | moves, bool(records))


def tail(count: float) -> float:
    """Sigmas that so many Gaussian numbers stay within, but for CHANCE"""
    return float(-ndtri(CHANCE / (2 * count)))


def _grown(model: Model, spread: np.ndarray, rows: int, sees: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """The largest |mean| and variance within a life, and within one of twice the rows: row by row at first, then at
    twice as many, and so on.  What fades is followed until it has."""
    P0 = np.where(np.outer(~model.unknown, ~model.unknown), model.P0, 0)
    A, W, count, fades, ends = np.eye(model.n), np.zeros((model.n, model.n)), 0, _fades(model), 0
    far = variance = np.zeros(len(sees))
    while ends < 2:
        before = variance
        far = np.fmax(far, np.abs(sees @ A @ model.x0))
        variance = np.fmax(variance, np.einsum("ci,ij,cj->c", sees, A @ P0 @ A.T + W, sees))
        if ends or count >= rows and (not fades or count >= FOREVER or not np.any(variance > 1.0001 * before)):
            yield far, variance
            ends += 1
        if count < STEPS:
            A, W, count = model.A @ A, model.A @ W @ model.A.T + spread, count + 1
        else:
            A, W, count = A @ A, A @ W @ A.T + W, 2 * count


def _fades(model: Model) -> bool:
    return bool(np.abs(np.linalg.eigvals(model.A)).max() < 1 - 1e-12)


def _spread(model: Model, records: Sequence[Record]) -> np.ndarray:
    """Of controls about their mean"""
    given = [one.u for one in records if one.u is not None and len(one.u)]
    return np.atleast_2d(np.cov(np.concatenate(given).T, bias=True)) if given else np.zeros((model.l, model.l))


def _driven(model: Model, records: Sequence[Record], rows: int, sees: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """How far controls drive each, and whether without end: by any within their ranges where that fades, else by the
    recorded ones, over and over."""
    total = last = np.zeros(len(sees))
    if model.B is None:
        return total, total > 0
    column = model.B * controls_reach(model, records)
    for _ in range(MOST_REPLAYED if _fades(model) else 2 * STEPS):
        last = np.abs(sees @ column).sum(axis=1)
        total, column = total + last, model.A @ column
        if not np.any(last > 1e-6 * total):
            break
    ends = last <= 1e-6 * total if not _fades(model) else last >= 0
    given = [one.u for one in records if one.u is not None and len(one.u)]
    return np.where(ends, total, _replayed(model, given, rows, sees)), ~ends


def _replayed(model: Model, given: Sequence[np.ndarray], rows: int, sees: np.ndarray) -> np.ndarray:
    most = np.zeros(len(sees))
    for u in given:
        x = np.zeros(model.n)
        pushes = u @ model.B.T  # type: ignore[union-attr]
        for row in range(min(rows, MOST_REPLAYED)):
            x = model.A @ x + pushes[row % len(u)]
            most = np.fmax(most, np.abs(sees @ x))
    return most


def controls_reach(model: Model, records: Sequence[Record]) -> np.ndarray:
    """Declared, or of the records"""
    given = [one.u for one in records if one.u is not None and len(one.u)]
    together = np.concatenate(given) if given else np.zeros((1, model.l))
    seen = np.fmax(MARGIN * np.abs(together).max(axis=0),
                   np.abs(together.mean(axis=0)) + tail(LIFE * len(together) * max(model.l, 1)) * together.std(axis=0))
    return np.array([span if one.range is None else one.range for one, span in zip(model.controls, seen)])


# ------------------------------------------------------------------------------ ranges


def with_ranges(model: Model, records: Sequence[Record], lives: bool = False) -> tuple[Model, list[str]]:
    """The model with ranges for all that has none, and what was chosen: from the records alone, or for a life, from
    prior, model and records together.  Without records the model has to tell."""
    which = (model.states, model.measurements, model.controls)
    if all(one.range is not None for quantities in which for one in quantities):
        return model, []
    life = life_of(model, records) if lives or not records else None
    seen = reach(model, records)
    controls = controls_reach(model, records) / MARGIN if lives else seen.controls
    notes: list[str] = []
    states = [_ranged(one, span, goes, life, notes)
              for one, span, goes in zip(model.states, seen.states, _goes(model, life, 0, seen.states))]
    measurements = [_ranged(one, span, goes, life, notes) for one, span, goes in zip(
        model.measurements, seen.measurements, _goes(model, life, model.n, seen.measurements))]
    return model.changed(states=states, measurements=measurements, controls=[
        _ranged(one, span, (0.0, False), None, notes) for one, span in zip(model.controls, controls)]), notes


def _goes(model: Model, life: Optional[Life], first: int, seen: np.ndarray) -> list[tuple[float, bool]]:
    """How far the model goes within a life, and whether it wanders; a measurement no farther than what it sees"""
    if life is None:
        return [(0.0, False)] * len(seen)
    ends, known = life.reach[first:first + len(seen)], np.any(model.unknown)
    made = [(float(end + span * known), bool(far) or bool(known))
            for end, span, far in zip(ends, seen, life.wanders[first:])]
    for j, row in enumerate(model.H if first else ()):
        spans = [one.range for one, factor in zip(model.states, row) if factor]
        most = sum(abs(factor) * (one.range or 0.0) for one, factor in zip(model.states, row))
        most += tail(life.rows * model.m) * model.R[j, j] ** 0.5
        if all(spans) and most < made[j][0]:
            made[j] = most, False
    return made


def _ranged(one: Quantity, seen: float, goes: tuple[float, bool], life: Optional[Life], notes: list[str]) -> Quantity:
    end, wanders = goes
    if one.range is not None:
        return one
    if life and not life.is_recorded and wanders:
        raise KalmanqError(f"{one.name} has no range, and the model does not tell one: its states wander; "
                           "give ranges, or --data")
    span = max(seen, end) if np.isfinite(end) else seen
    if not (np.isfinite(span) and span > 0):
        raise KalmanqError(f"{one.name} has no range, and none can be told from the data: give it one")
    made = _rounded_up(MARGIN * span)
    notes.append(f"{one.label}: a range of {made:g} was chosen; {_why(seen, end, wanders, life)}")
    return replace(one, range=made)


def _why(seen: float, end: float, wanders: bool, life: Optional[Life]) -> str:
    if life is None:
        return f"it reaches {seen:.3g}"
    data = f"the data reach {seen:.3g}, " if seen else ""
    if not np.isfinite(end):
        return f"{data}and the model grows without end: the range is that of the data alone"
    on = "; it wanders, and goes farther later: declare what bounds it" if wanders else ""
    return f"{data}the model {end:.3g} in {life.rows} rows (farther: a chance of {CHANCE:.0e}){on}"


def _rounded_up(value: float) -> float:
    """To two digits"""
    unit = 10.0 ** (np.floor(np.log10(value)) - 1)
    return float(f"{np.ceil(value / unit) * unit:.2g}")
