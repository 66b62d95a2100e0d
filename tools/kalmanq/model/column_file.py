"""What of a model file is of columns: its expressions, its section [columns], and D, which is read beside them."""

from __future__ import annotations

from typing import Any, Callable, Mapping, Optional, Sequence

import numpy as np

from kalmanq.errors import ModelError
from kalmanq.model import columns
from kalmanq.model.column_model import ColumnModel
from kalmanq.model.model import Model, Quantity

Quantities = Callable[[str, Mapping[str, Any], int, Optional[list[str]]], list[Quantity]]


def with_columns(model: Model, texts: Sequence[Mapping[str, Any]], section: Mapping[str, Any], quantities: Quantities) -> Model:
    """texts: of [model] and of each sensor, as `taken` has them; section: [columns]; quantities: what reads names, units and ranges"""
    cells: dict[str, columns.Cells] = {}
    for key, one in texts[0].items():
        cells[key] = columns.placed(key, one, getattr(model, key).shape)
    first = 0
    for sensor, own in zip(model.sensors, texts[1:]):
        m = len(sensor.measurements)
        for key, one in own.items():
            shape, at = {"H": ((m, model.n), (first, 0)), "R": ((m, m), (first, first)), "d": ((m,), (first,))}.get(key, (
                (m, len(model.inputs)), (first, 0)))
            cells.setdefault(key, {}).update(columns.placed(key, one, shape, at))
        first += m
    if not cells:
        if section:
            raise ModelError("columns", "there is no expression of a column: leave the section out")
        return model
    if model.continuous and cells.keys() & {"A", "B", "Q"}:
        raise ModelError(next(key for key in "BAQ" if key in cells), columns.CURES["F"])
    names = columns.columns_of(cells, [one.name for one in model.inputs], {
        "state": [one.name for one in model.states], "measurement": [one.name for one in model.measurements]})
    return ColumnModel.of(model, cells, _quantities(names, section, quantities))


def _quantities(names: list[str], section: Mapping[str, Any], quantities: Quantities) -> tuple[Quantity, ...]:
    """Those of the section first, as it has them"""
    said = section.get("names", [])
    if section and (not isinstance(said, list) or not said):
        raise ModelError("columns", "names is missing: those of columns that have units, ranges or fractions")
    for name in said:
        if name not in names:
            others = [one for one in names if one not in said]
            raise ModelError("columns", f"{name} is in no expression: leave it out of names" + (f", or is {' or '.join(others)} of the expressions meant?" if others else ""))
        if said.count(name) > 1:
            raise ModelError("columns", f"{name} is there twice: leave one out of names")
    named = quantities("columns", section, len(said), None) if said else []
    return (*named, *(Quantity(name) for name in names if name not in said))


def controls_of(made: Mapping[str, Any]) -> int:
    """As B has columns, or D"""
    if made.get("B") is not None:
        return made["B"].shape[1] if made["B"].ndim == 2 else 1
    D = made.get("D")
    return 0 if D is None else D.shape[1] if D.ndim == 2 else D.size // (len(made["H"]) if made["H"].ndim == 2 else 1) or 1


def through(D: np.ndarray, m: int, controls: Optional[int]) -> np.ndarray:
    """Of a sensor with m measurements: m x l; controls: l, where it is known"""
    if D.ndim < 2:
        D = D.reshape((1, -1) if m == 1 else (-1, 1))
    if D.shape != (m, D.shape[1] if controls is None else controls):
        raise ModelError("D", f"is {' x '.join(map(str, D.shape))}: it has a row for each measurement of the sensor, {m}, and a column for each control"
                         + ("" if controls is None else f", {controls}"))
    return D


def within(cells: Optional[columns.Cells], own: slice, key: str) -> columns.Cells:
    """Of a sensor's rows, counted from its first"""
    first = (own.start, own.start) if key == "R" else (own.start, 0)
    return {tuple(i - k for i, k in zip(at, first)): one for at, one in (cells or {}).items() if own.start <= at[0] < own.stop}


