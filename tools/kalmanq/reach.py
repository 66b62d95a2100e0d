"""How far states, measurements and controls go: what the formats of fixed point have to hold."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Iterator, Optional, Sequence

import numpy as np
from scipy.special import ndtri

from kalmanq.commands.simulate import simulate
from kalmanq.errors import KalmanqError
from kalmanq.filters import Filter, Smoother
from kalmanq.model import Model, Quantity
from kalmanq.parts import is_diagonal

MARGIN = 1.5  # a range is so many times what was reached
CHANCE = 1e-6  # that a model goes farther than is said, within a life
LIFE, LEAST_LIFE = 4, 10_000  # times the rows of the longest record; rows
ROUNDED = 2e-5  # sigmas that a raw value of q31 may be worth: a life is no longer than allows it, nor than a record
STEPS, FOREVER, MOST_REPLAYED = 1024, 1 << 40, 100_000  # rows: one by one, until what fades has, of controls
FAR = 6.0  # sigmas of a state that has just become known
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
    """How far a model goes within so many rows, without its measurements: states first, then measurements.

    reach    of each, left within the life with a chance of CHANCE at most; infinite: it grows by a power
    wanders  whether it goes farther in a longer life
    """

    rows: int
    reach: np.ndarray
    wanders: np.ndarray


def life_of(model: Model, records: Sequence[Record], rows: int) -> Life:
    """The variance of an estimate is at most that of the state: what holds the state holds its estimates."""
    sees = np.concatenate([np.eye(model.n), model.H])
    errors = np.concatenate([np.zeros(model.n), np.diag(model.R)])
    driven, ends = _driven(model, records, rows, sees)
    # what controls without end do is what the records' do: their mean by `driven`, their spread as noise
    loud = model.Q if model.B is None else model.Q + model.B @ _spread(model, records) @ model.B.T
    most, wanders, sigmas = np.zeros(len(sees)), ~ends, tail(rows * len(sees))
    for x0, P0 in _starts(model, records):
        for Q, which in ((model.Q, ends), (loud, ~ends)):
            if np.any(which):
                with np.errstate(over="ignore", invalid="ignore"):
                    now, later = (far + sigmas * np.sqrt(spread + errors)
                                  for far, spread in _grown(model, x0, P0, Q, rows, sees))
                # twice the rows are 2^n times as far at most, unless it grows by a power
                now = np.where(later <= 4.0**model.n * now, now, np.inf)
                most = np.where(which, np.fmax(most, now), most)
                wanders |= which & ~(later + driven <= 1.01 * (now + driven))
    return Life(rows, most + driven, wanders)


def tail(count: float) -> float:
    """Sigmas that so many Gaussian numbers stay within, but for CHANCE"""
    return float(-ndtri(CHANCE / (2 * count)))


def _starts(model: Model, records: Sequence[Record]) -> list[tuple[np.ndarray, np.ndarray]]:
    """Mean and covariance that a life begins with: the prior; where that is unknown, what each record ends with."""
    if not np.any(model.unknown):
        return [(model.x0, model.P0)]
    ends = [Filter(model, "f64").run(one.z, one.u, covariance=True) for one in records if len(one.z)]
    return [(np.nan_to_num(run.mean[-1]), np.nan_to_num(run.covariance[-1], posinf=0.0)) for run in ends]


def _grown(model: Model, x0: np.ndarray, P0: np.ndarray, Q: np.ndarray, rows: int,
           sees: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """The largest |mean| and variance within a life, then within one of twice the rows: row by row at first, then at
    twice as many, and so on.  What fades is followed until it has."""
    A, W, count, fades, ends = np.eye(model.n), np.zeros((model.n, model.n)), 0, _fades(model), 0
    steps = -(-rows // (1 << max(0, int(np.ceil(np.log2(rows / STEPS))))))  # the life itself is twice as many, or again
    most, swing = np.zeros((2, len(sees))), np.zeros(len(sees))  # what P0 comes to again where A turns
    while ends < 2:
        before = most
        prior, noise = (np.einsum("ci,ij,cj->c", sees, one, sees) for one in (A @ P0 @ A.T, W))
        swing = np.fmax(swing, prior) if count >= steps // 2 else swing
        most = np.fmax(most, [np.abs(sees @ A @ x0), np.fmax(prior, swing) + noise])
        if ends or count >= rows and (not fades or count >= FOREVER or not np.any(most > 1.0001 * before)):
            yield most[0], most[1]
            ends += 1
        if count < steps:
            A, W, count = model.A @ A, model.A @ W @ model.A.T + Q, count + 1
        else:
            A, W, count = A @ A, A @ W @ A.T + W, 2 * count


def _fades(model: Model) -> bool:
    return bool(np.abs(np.linalg.eigvals(model.A)).max() < 1 - 1e-12)


def _given(records: Sequence[Record]) -> list[np.ndarray]:
    return [one.u for one in records if one.u is not None and len(one.u)]


def _spread(model: Model, records: Sequence[Record]) -> np.ndarray:
    """Of controls about their mean"""
    given = _given(records)
    return np.atleast_2d(np.cov(np.concatenate(given).T, bias=True)) if given else np.zeros((model.l, model.l))


def _driven(model: Model, records: Sequence[Record], rows: int, sees: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """How far controls drive each, and whether that has an end: by any controls within their ranges where it has,
    otherwise by the recorded ones, over and over."""
    total, last = np.zeros(len(sees)), np.zeros(len(sees))
    if model.B is None:
        return total, total == 0
    column = model.B * controls_reach(model, records)
    for _ in range(MOST_REPLAYED if _fades(model) else 2 * STEPS):
        last = np.abs(sees @ column).sum(axis=1)
        total, column = total + last, model.A @ column
        if not np.any(last > 1e-6 * total):
            break
    ends = (last <= 1e-6 * total) | _fades(model)
    return np.where(ends, total, _replayed(model, records, rows, sees)), ends


def _replayed(model: Model, records: Sequence[Record], rows: int, sees: np.ndarray) -> np.ndarray:
    most = np.zeros(len(sees))
    for u in _given(records):
        x, pushes = np.zeros(model.n), u @ np.asarray(model.B).T
        for row in range(min(rows, MOST_REPLAYED)):
            x = model.A @ x + pushes[row % len(u)]
            most = np.fmax(most, np.abs(sees @ x))
    return most


def controls_reach(model: Model, records: Sequence[Record]) -> np.ndarray:
    """As far as is declared, or as those of the records tell"""
    given = _given(records)
    if not given:
        return np.array([one.range or 0.0 for one in model.controls])
    u = np.concatenate(given)
    seen = np.fmax(np.abs(u).max(axis=0), np.abs(u.mean(axis=0)) + tail(LIFE * u.size) * u.std(axis=0) / MARGIN)
    return np.array([MARGIN * span if one.range is None else one.range for one, span in zip(model.controls, seen)])


# ------------------------------------------------------------------------------ ranges


@dataclass(frozen=True)
class Choice:
    """A range that was chosen: of what, how far the data and the model go, the latter within so many rows but for a
    chance.  Neither is known where the model grows by a power."""

    name: str
    range: float
    data: float
    model: Optional[float] = None
    rows: Optional[int] = None
    chance: Optional[float] = None
    wanders: bool = False

    def __str__(self) -> str:
        said = f"{self.name}: a range of {self.range:g} was chosen; "
        data = f"the data reach {self.data:.3g}"
        if self.rows is None:
            return said + data
        if self.model is None:
            return f"{said}{data}, and the model grows without end: the range is that of the data alone"
        on = "; it wanders, and goes farther later: declare what bounds it" if self.wanders else ""
        return f"{said}{data + ', ' if self.data else ''}the model {self.model:.3g} in {self.rows} rows " \
               f"(farther: a chance of {self.chance:.0e}){on}"


def with_ranges(model: Model, records: Sequence[Record], life: Optional[int] = None) -> tuple[Model, list[Choice]]:
    """The model with ranges for all that has none, from prior, model and records together; what was chosen.

    life   rows that they are to hold; by itself LIFE times the longest record, LEAST_LIFE at least, but no longer
           than q31 is accurate with; 0: the records alone
    """
    if all(one.range is not None for which in (model.states, model.measurements, model.controls) for one in which):
        return model, []
    seen, (first, least) = reach(model, records), _sigmas(model, records)
    if np.any(model.unknown):
        seen = replace(seen, states=_unknown_reach(model, records, np.fmax(seen.states, FAR * first), least))
    longest = max((len(one.z) for one in records), default=0)
    rows = max(LEAST_LIFE, LIFE * longest) if life is None else life
    while True:
        far = life_of(model, records, rows) if rows else Life(0, np.zeros(0), np.zeros(0, bool))
        made, chosen = _with_life(model, records, seen, far)
        if life is not None or not np.any(far.wanders) or rows <= (longest or rows) or _is_fine(model, made, least):
            return made, chosen
        rows = max(rows // 2, longest)


def _is_fine(model: Model, made: Model, sigmas: np.ndarray) -> bool:
    """Is half a raw value of q31 little beside sigma, and beside a sensor's noise, at all ranges that were chosen?"""
    pairs = zip((*model.states, *model.measurements), (*made.states, *made.measurements),
                (*sigmas, *np.sqrt(np.diag(model.R))))
    return not any((one.range or 0) * 2.0**-31 > ROUNDED * sigma > 0 for old, one, sigma in pairs if old.range is None)


def _with_life(model: Model, records: Sequence[Record], seen: Reach, life: Life) -> tuple[Model, list[Choice]]:
    goes = _goes(model, life) if life.rows else [(None, False)] * (model.n + model.m)
    given = (*model.states, *model.measurements)
    wander = any(far for one, (_, far) in zip(given, goes) if one.range is None)
    if life.rows and not records and (np.any(model.unknown) or wander):
        lacking = next(one.name for one in (*given, *model.controls) if one.range is None)
        why = "its start is unknown" if np.any(model.unknown) else "its states wander"
        raise KalmanqError(f"{lacking} has no range, and the model does not tell one: {why}; give ranges, or --data")
    chosen: list[Choice] = []
    made = [_ranged(one, span, *far, life.rows or None, chosen)
            for one, span, far in zip(given, (*seen.states, *seen.measurements), goes)]
    controls = [_ranged(one, span, None, False, None, chosen)
                for one, span in zip(model.controls, controls_reach(model, records) / MARGIN)]
    return model.changed(states=made[:model.n], measurements=made[model.n:], controls=controls), chosen


def _goes(model: Model, life: Life) -> list[tuple[float, bool]]:
    """How far each goes within a life, and whether it wanders; a measurement no farther than what it sees"""
    made = [(float(far), bool(wanders)) for far, wanders in zip(life.reach, life.wanders)]
    for j, row in enumerate(model.H):
        spans = [abs(factor) * (one.range or np.inf) for one, factor in zip(model.states, row) if factor]
        most = sum(spans) + tail(life.rows * model.m) * model.R[j, j] ** 0.5
        if most < made[model.n + j][0]:
            made[model.n + j] = float(most), False
    return made


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


def _unknown_reach(model: Model, records: Sequence[Record], first: np.ndarray, least: np.ndarray) -> np.ndarray:
    """As far as first estimates go, if q31 is accurate with that; otherwise as far as estimates given all rows do: the
    ranges are then the prior of what the first rows hardly tell."""
    if not records or np.all(MARGIN * first * 2.0**-31 <= ROUNDED * least):
        return first
    runs = [Smoother(model, "f64").run(one.z, one.u).smoothed for one in records if len(one.z)]
    return np.max([np.nanmax(np.abs(np.asarray(run)), axis=0, initial=0.0) for run in runs], axis=0)


def _sigmas(model: Model, records: Sequence[Record]) -> tuple[np.ndarray, np.ndarray]:
    """The largest of each state once it is known: ranges with room for it do not act as a prior of q31.  The least."""
    runs = [Filter(model, "f64").run(record.z, record.u).sigma for record in records if len(record.z)]
    sigmas = np.concatenate([np.zeros((1, model.n)), *(run for run in runs if run is not None)])
    least = np.nanmin(np.where(sigmas > 0, sigmas, np.inf), axis=0)
    return np.nanmax(sigmas, axis=0), np.where(np.isfinite(least), least, 0.0)


def _ranged(one: Quantity, seen: float, goes: Optional[float], wanders: bool, rows: Optional[int],
            chosen: list[Choice]) -> Quantity:
    if one.range is not None:
        return one
    grows = goes is None or not np.isfinite(goes)
    span = seen if grows else max(seen, goes or 0.0)
    if not (np.isfinite(span) and span > 0):
        raise KalmanqError(f"{one.name} has no range, and none can be told from the data: give it one")
    made = _rounded_up(MARGIN * span)
    chosen.append(Choice(one.label, made, float(seen), None if grows else goes, rows, None if grows else CHANCE,
                         wanders and not grows))
    return replace(one, range=made)


def _rounded_up(value: float) -> float:
    """To two digits"""
    unit = 10.0 ** (np.floor(np.log10(value)) - 1)
    return float(f"{np.ceil(value / unit) * unit:.2g}")
