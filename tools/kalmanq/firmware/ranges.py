"""Ranges for a model that has none, from prior, model and records together; wider ones for records that go beyond."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Optional, Sequence

import numpy as np

from kalmanq.errors import KalmanqError
from kalmanq.firmware.life import CHANCE, LEAST_LIFE, LIFE, Life, controls_reach, life_of, tail
from kalmanq.firmware.reach import MARGIN, Reach, Record, reach
from kalmanq.model import Model, Quantity
from kalmanq.run.filters import Filter, Smoother

ROUNDED = 2e-5  # sigmas that a raw value of q31 may be worth: a life is no longer than allows it, nor than a record
FAR = 6.0  # sigmas of a state that has just become known


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
            return f"{said}{data}, and the model grows without end: the range comes from the data alone"
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
        raise KalmanqError(f"{lacking} has no range, and none follows from the model: {why}; give ranges, or `kalmanq design --data`")
    chosen: list[Choice] = []
    made = [_ranged(one, span, *far, life.rows or None, chosen)
            for one, span, far in zip(given, (*seen.states, *seen.measurements), goes)]
    controls = [_ranged(one, span, None, False, None, chosen)
                for one, span in zip(model.inputs, controls_reach(model, records) / MARGIN)]
    return model.changed(states=made[:model.n], measurements=made[model.n:], controls=controls), chosen


def _goes(model: Model, life: Life) -> list[tuple[float, bool]]:
    """How far each goes within a life, and whether it wanders; a measurement no farther than what it sees"""
    made = [(float(far), bool(wanders)) for far, wanders in zip(life.reach, life.wanders)]
    for j, row in enumerate(model.H):
        spans = [abs(factor) * (one.range or np.inf) for one, factor in zip(model.states, row) if factor]
        most = sum(spans) + tail(life.rows * model.m) * model.R[j, j] ** 0.5 + (0.0 if model.d is None else abs(model.d[j]))
        if most < made[model.n + j][0]:
            made[model.n + j] = float(most), False
    return made


def widened(model: Model, records: Sequence[Record]) -> tuple[Model, list[str]]:
    """The model with wider ranges where the records, in double, go beyond those that it declares; what was widened"""
    found, said = reach(model, records), []
    changed = {}
    for which in ("states", "measurements", "controls"):
        changed[which] = list(model.inputs if which == "controls" else getattr(model, which))
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
        raise KalmanqError(f"{one.name} has no range, and the data do not show one: give it one")
    made = _rounded_up(MARGIN * span)
    chosen.append(Choice(one.label, made, float(seen), None if grows else goes, rows, None if grows else CHANCE,
                         wanders and not grows))
    return replace(one, range=made)


def _rounded_up(value: float) -> float:
    """To two digits"""
    unit = 10.0 ** (np.floor(np.log10(value)) - 1)
    return float(f"{np.ceil(value / unit) * unit:.2g}")
