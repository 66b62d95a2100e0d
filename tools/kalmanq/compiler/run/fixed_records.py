"""What a nonlinear model's formulas are of, in records that its filter in double has run over: for formats."""

from __future__ import annotations

from functools import lru_cache
from typing import Any, Mapping, Sequence

import numpy as np

from kalmanq.compiler.algorithm.fixed.values import Seen, Values
from kalmanq.compiler.given.request import Options
from kalmanq.compiler.run.equation_records import drawn
from kalmanq.compiler.run.host import Host
from kalmanq.compiler.run.record import Record
from kalmanq.compiler.text.equation_product import compiled_equations
from kalmanq.formulas.program import Program
from kalmanq.nonlinear import NonlinearModel
from kalmanq.nonlinear.calls import STEP
from kalmanq.nonlinear.formulas import values_of

ROWS, SEEDS = 400, (11, 12, 13, 14)  # none of those that equation_report tries


def refuse_varying(model: NonlinearModel) -> None:
    """Formats are of numbers that q31 writes once"""
    for one in (*(model.given[key] for key in ("Q", "G") if key in model.given), *model.noises.functions.values()):
        raise one.error("is a function, and q31 has arrays of noises: give an array, or take f32 or f64")
    for one in model.functions:
        if STEP in one.takes:
            raise one.error(f"takes {STEP}, and in q31 the rows are steps that are all alike: take f32 or f64")


@lru_cache(maxsize=4)
def simulated(model: NonlinearModel) -> Seen:
    refuse_varying(model)
    return seen(model, [drawn(model, ROWS, seed) for seed in SEEDS])


def seen(model: NonlinearModel, records: Sequence[Record]) -> Seen:
    before, at = [], []
    with Host(compiled_equations(model, "exact", Options("f64"))) as exact:
        for record in records:
            ran = exact.run_record(record)
            now = np.zeros((len(record.z), model.l)) if record.now is None else record.now
            made = _points(model, ran.mean, record.measured, now)
            before.append(made[0])
            at.append(made[1])
    wide, both = _ends(model), (_joined(before), _joined(at))
    if wide:
        both = tuple(_joined([one, _anywhere(model, one, wide)]) for one in both)
    return Seen(*both, sum(len(one.z) for one in records), [
        f"{one.name} from {one.ends[0]:g} to {one.ends[1]:g}" for one in (*model.carried, *model.controls) if one.ends])


def _ends(model: NonlinearModel) -> dict[str, tuple[float, float]]:
    """By symbol"""
    return {f"{stem}{k}": one.ends for stem, which in (("x", model.carried), ("u", model.controls))
            for k, one in enumerate(which) if one.ends}


def _anywhere(model: NonlinearModel, values: Values, ends: Mapping[str, tuple[float, float]]) -> Values:
    """The points with other values between the ends, half of them at an end; innovations stay as they are"""
    draws, count = np.random.default_rng(1), len(values["x0"])
    made = dict(values)
    for name, (low, high) in ends.items():
        made[name] = np.where(draws.random(count) < 0.5, draws.choice([low, high], count), draws.uniform(low, high, count))
    if "z0" in values:
        expected = Program(model.formulas.expected)
        moved = _rows(expected.values(made), count) - _rows(expected.values(values), count)
        made.update({f"z{c}": values[f"z{c}"] + column for c, column in enumerate(moved.T)})
    return made


def _points(model: NonlinearModel, mean: np.ndarray, z: np.ndarray, now: np.ndarray) -> tuple[Values, Values]:
    """Predicts begin at means, updates are at what a predict has left and at means that other sensors have left"""
    rows = np.arange(len(mean), dtype=float)
    before = values_of(mean.T, rows, now.T)
    moved = _rows(Program(model.formulas.moved).values(before), len(mean))
    whole = moved if model.has_errors or "increment" not in model.given else mean + moved
    predicted = np.vstack([model.x0[None], whole[:-1]])
    measured = [values_of(one.T, rows, now.T) for one in (predicted, mean)]
    for one in measured:
        one.update({f"z{c}": column for c, column in enumerate(z.T)})
    if model.has_errors:
        d = np.array([model.minus(*pair) for pair in zip(mean, predicted)])
        before.update({f"d{i}": column for i, column in enumerate(d.T)})
    return {key: np.broadcast_to(one, len(mean)) for key, one in before.items()}, _joined(measured)


def _rows(values: Sequence[Any], rows: int) -> np.ndarray:
    return np.stack([np.broadcast_to(np.asarray(one, float), rows) for one in values], axis=1)


def _joined(parts: Sequence[Values]) -> Values:
    return {key: np.concatenate([np.atleast_1d(one[key]) for one in parts]) for key in parts[0]}
