"""A filter and smoother whose H is another one at each row: a regression with regressors that change."""

from __future__ import annotations

from dataclasses import fields
from typing import Optional, Sequence

import numpy as np
from numpy.typing import ArrayLike

from kalmanq.core import ffi, require, warn_of
from kalmanq.data.rows import rows_of, told
from kalmanq.errors import KalmanqError
from kalmanq.model import Model
from kalmanq.model.arrays import numbers_of
from kalmanq.run.filters import Filter, _Recording
from kalmanq.run.parts import Parts, matrix
from kalmanq.run.results import Run


class VaryingSmoother:
    """Of a recorded run with an H a row; all else is the model's.

        run = VaryingSmoother(model, "f32").run(z, H)       z: T x m, H: T x m x n, or T x n where m = 1
    """

    def __init__(self, model: Model, arithmetic: str = "f64"):
        self.model, self.arithmetic = model, arithmetic

    def run(self, z: ArrayLike, H: ArrayLike, *, smooth: bool = True, covariance: bool = False) -> Run:
        """As Smoother.run; without `smooth` the filter's results alone.  `covariance`: the smoothed ones, too."""
        rows = rows_of(z, self.model.measurements, "z")
        given = self._measurements(H, len(rows))
        parts = Parts(self.model, self.arithmetic)
        recording = _Recording(self.model, parts, rows, None) if smooth else None
        filter_ = recording or Filter(self.model, self.arithmetic, parts=parts)
        made = []
        for row in range(len(rows)):
            try:
                _change_measurement(parts, given[row])
                made.append(filter_._sequence(rows[row : row + 1], None))
            except KalmanqError as problem:
                reason = str(problem) if problem.row is None else str(problem).split(": ", 1)[1]
                raise KalmanqError(reason, problem.status, row) from None
        run = _joined(made)
        run.events = filter_.events
        if recording:
            recording.smooth(run, covariance, False)
        warn_of(run.events, f"{self.model.name}, {self.arithmetic}")
        return run

    def _measurements(self, H: ArrayLike, rows: int) -> np.ndarray:
        n, m = self.model.n, self.model.m
        try:
            given = numbers_of(H)
        except (TypeError, ValueError, OverflowError) as problem:
            raise KalmanqError(f"H: not an array of numbers{told(problem)}") from problem
        if given.ndim == 2 and m == 1:
            given = given[:, None, :]
        if given.shape != (rows, m, n):
            raise KalmanqError(f"H is {' x '.join(map(str, np.shape(H)))}, not {rows} x {m} x {n}")
        if not np.all(np.isfinite(given)):
            raise KalmanqError("H has an entry that is not finite", row=int(np.argwhere(~np.isfinite(given))[0][0]))
        return given


def _change_measurement(parts: Parts, H: np.ndarray) -> None:
    change = parts.arithmetic.function("sensor_change_measurement")
    if parts.arithmetic.is_fixed:
        table = matrix(parts, "H", H, parts.formats["measurements"], parts.formats["states"])
        status = change(parts.sensor, table, ffi.NULL)
    else:
        status = change(parts.sensor, parts.array(H))
    require(status, "H")


def _joined(runs: Sequence[Run]) -> Run:
    """Of one row each"""
    if not runs:
        raise KalmanqError("z has no rows")

    def column(name: str) -> Optional[np.ndarray]:
        values = [getattr(run, name) for run in runs]
        return np.concatenate(values) if isinstance(values[0], np.ndarray) else None

    arrays = {field.name: column(field.name) for field in fields(Run)}
    return Run(runs[0].model, runs[0].arithmetic,
               **{name: array for name, array in arrays.items() if array is not None})  # type: ignore[arg-type]
