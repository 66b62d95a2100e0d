"""A model with numbers from columns of the data: its matrices at each row, and at given values of the columns."""

from __future__ import annotations

from typing import Any, Mapping

import numpy as np

from kalmanq.errors import KalmanqError
from kalmanq.model.columns import OF_STEP, Cells, Expression
from kalmanq.model.model import Model, Quantity

ROUNDING = 1e-12  # of a covariance, between an entry and its twin


class ColumnModel(Model):
    """What of its matrices is from columns is NaN in `A`, `B`, `Q`, `H`, `R`, `D` and `d`.

    columns  what its columns are called; in `inputs` they follow the controls, as they do in u
    cells    by matrix the expressions, by their places
    frame    the model with stand-ins, for what is the same at each row
    """

    columns: tuple[Quantity, ...]
    cells: Mapping[str, Cells]

    @classmethod
    def of(cls, model: Model, cells: Mapping[str, Cells], columns: tuple[Quantity, ...]) -> ColumnModel:
        """model: with 0 in the place of each expression"""
        made = object.__new__(cls)
        made.__dict__.update(model.__dict__)
        made.columns, made.cells = columns, cells
        made._numbers = {name: np.array(getattr(model, name)) for name in cells}
        made._frame = _framed(model, cells)
        for name, of in cells.items():
            array = made._numbers[name].copy()
            array[tuple(np.array(list(of)).T)] = np.nan
            array.setflags(write=False)
            made.__dict__[name] = array
        return made

    @property
    def frame(self) -> Model:
        return self._frame

    @property
    def inputs(self) -> tuple[Quantity, ...]:
        return (*super().inputs, *self.columns)

    @property
    def plain(self) -> Model:
        """With 0 in the place of each expression"""
        made = object.__new__(Model)
        made.__dict__.update({name: one for name, one in self.__dict__.items() if name not in ("columns", "cells", "_numbers", "_frame")})
        made.__dict__.update(self._numbers)
        return made

    def changed(self, **what: Any) -> ColumnModel:
        for name in what:
            if name in self.cells:
                kept = np.array(what[name], float)
                kept[tuple(np.array(list(self.cells[name])).T)] = 0.0
                what[name] = kept
        columns = what.pop("columns", self.columns)
        if "controls" in what:
            what["controls"] = [one for one in what["controls"] if one not in self.columns]
        return ColumnModel.of(self.plain.changed(**what), self.cells, columns)

    def flowing(self, **what: Any) -> ColumnModel:
        return ColumnModel.of(self.plain.flowing(**what), self.cells, self.columns)

    def jittered(self, share: float) -> ColumnModel:
        return ColumnModel.of(self.plain.jittered(share), self.cells, self.columns)

    def __repr__(self) -> str:
        return f"ColumnModel({self.name!r}, n={self.n}, m={self.m}, l={len(super().inputs)}, columns={', '.join(one.name for one in self.columns)})"

    def measured_with(self) -> dict[str, set[str]]:
        """By column the measurements that it is of; without those of steps, which each row needs"""
        made: dict[str, set[str]] = {one.name: set() for one in self.columns}
        for name, of in self.cells.items():
            for at, one in of.items():
                for column in made.keys() & set(one.names):
                    made[column] |= {self.measurements[i].name for i in (at if name == "R" else at[:1])} if name not in OF_STEP else {""}
        return {name: of for name, of in made.items() if "" not in of}

    # ------------------------------------------------------------------ at values of the columns

    def matrices(self, inputs: np.ndarray, z: np.ndarray) -> dict[str, np.ndarray]:
        """By name, T x ..., of T rows of `inputs` and z.  A row whose measurement is missing needs no column for it"""
        table = {one.name: column for one, column in zip(self.inputs, inputs.T)}
        there, made = ~np.isnan(z), {}
        for name, of in self.cells.items():
            whole = np.repeat(self._numbers[name][None], len(z), axis=0)
            for at, one in of.items():
                values = np.broadcast_to(one.values(table), len(z)).copy()
                needed = np.ones(len(z), bool) if name in OF_STEP else there[:, at[0]] & there[:, at[-1] if name == "R" else at[0]]
                self._require(name, at, one, values, needed, table)
                values[~np.isfinite(values)] = self.frame.R[at] if name == "R" else 0.0
                whole[(slice(None), *at)] = values
            made[name] = _symmetric(name, whole) if name in "QR" else whole
        return made

    def _require(self, name: str, at: tuple[int, ...], one: Expression, values: np.ndarray, needed: np.ndarray,
                 table: Mapping[str, np.ndarray]) -> None:
        """Finite where it is needed, and of a variance not below 0"""
        is_variance = name in "QR" and at[0] == at[-1]
        wrong = needed & ~(np.isfinite(values) & ((values >= 0) | (not is_variance)))
        if not np.any(wrong):
            return
        row = int(np.argmax(wrong))
        where = f"{name}[{','.join(map(str, at))}] = {one.text}"
        for column in one.names:
            if np.isnan(table[column][row]):
                raise KalmanqError(f"{column} is missing, which {where} needs: fill it in, or leave the row out", row=row)
        told = ", ".join(f"{column} = {table[column][row]:g}" for column in one.names)
        raise KalmanqError(f"{where} is {values[row]:g} with {told}: {'a variance is 0 or more' if is_variance else 'it has to be finite'}", row=row)

    def at(self, inputs: np.ndarray) -> Model:
        """The constant model of these controls and columns"""
        made = {name: one[0] for name, one in self.matrices(inputs[None], np.zeros((1, self.m))).items()}
        return self.plain.changed(**made)


def _symmetric(name: str, whole: np.ndarray) -> np.ndarray:
    twin = whole.swapaxes(1, 2)
    apart = np.any(np.abs(whole - twin) > ROUNDING * np.abs(whole), axis=(1, 2))
    if np.any(apart):
        raise KalmanqError(f"{name} is not symmetric: an entry above its diagonal and its twin below have one expression", row=int(np.argmax(apart)))
    return (whole + twin) / 2


def _framed(model: Model, cells: Mapping[str, Cells]) -> Model:
    """Without D, and with independent stand-ins: what varies is given with each row"""
    what: dict[str, Any] = {}
    for name in cells.keys() & {"Q", "R"}:
        own = np.diag(getattr(model, name)).copy()
        for i, k in cells[name]:
            if i == k:
                one = model.measurements[i] if name == "R" else model.states[i]
                own[i] = 0.0 if name == "Q" else (one.range / 8) ** 2 if one.range else 1.0
        what[name] = own
    if "d" in cells:
        what["d"] = None
    framed = model.changed(**what) if what else model
    return framed.frame


def row_needs(model: Model) -> bool:
    """Has it D, or numbers from columns?  Its measurements are of z and u then"""
    return model.frame is not model


def refuse_rows(model: Model, what: str, cure: str) -> None:
    """Of what takes a constant model alone"""
    if row_needs(model):
        has = "numbers from columns" if isinstance(model, ColumnModel) else "D, a part of its measurements by controls"
        raise KalmanqError(f"{what}: {model.name} has {has}: {cure}")
