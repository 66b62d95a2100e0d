"""A model with numbers from columns: its log-likelihood.  What is free are its numbers; expressions stay."""

from __future__ import annotations

from typing import Any, Mapping, Optional, Sequence

import numpy as np
from numpy.typing import ArrayLike

from kalmanq.core import lib
from kalmanq.data.rows import Rows
from kalmanq.errors import KalmanqError
from kalmanq.fitting.flow import Flow
from kalmanq.fitting.noise import Noise
from kalmanq.model import ColumnModel, Model
from kalmanq.run.filters import Filter
from kalmanq.run.parts import Parts

ARRAYS = ("A", "H", "R", "x0", "P0")


class ColumnExpectation:
    """arrays: A, H, R, x0, P0 with 0 in the place of expressions, Q of the noises (r x r, Q = F Q F'), and in continuous time F; Q is of Qc then.
    Its slopes are differences of the log-likelihood"""

    def __init__(self, model: ColumnModel, records: Any, noise: Noise, free: Sequence[str], flow: Optional[Flow]):
        self.begun, self.records, self.noise, self.free, self.flow, self.evaluations = model, records, noise, free, flow, 0
        plain = model.plain
        self.arrays = {name: np.array(getattr(plain, name)) for name in ARRAYS}
        self.arrays["Q"] = np.array(noise.inner)
        if flow:
            self.arrays["F"] = np.array(model.continuous.F)
        count = sum(self.arrays[name].size for name in free if name not in ("Q", "R", "P0"))
        self.status = lib.KQ_OK if records.measurements > count else lib.KQ_ERR_FEW_DATA
        self.begin()

    def begin(self) -> int:
        """Forgets what iterations have been"""
        self.log_likelihood = self.change = self.distance = float("nan")
        return self.status

    def _model(self) -> Model:
        if self.flow:
            return self.flow.model_at(self.arrays, self.noise)
        made = {name: self.arrays[name].copy() for name in self.free}
        if "Q" in made:
            made.update(self.noise.of_model(made.pop("Q")))
        return self.begun.changed(**made)

    def run(self) -> int:
        self.evaluations += 1
        try:
            model, total = self._model(), 0.0
            parts = Parts(model.frame, "f64")
            for z, u, times in self.records.each():
                run = Filter(model, parts=parts)
                run._sequence(Rows.of(model, z, u, times))
                if run.events & lib.KQ_EVENT_OVERFLOW:  # a measurement that the filter has left out
                    return lib.KQ_ERR_LIKELIHOOD
                total += run.log_likelihood
        except (KalmanqError, FloatingPointError):
            return lib.KQ_ERR_NOT_FINITE
        self.log_likelihood = float(total)
        return lib.KQ_OK

    def gradient(self) -> dict[str, np.ndarray]:
        """Not known: a problem takes differences along its coordinates"""
        return {name: np.full_like(self.arrays[name], np.nan) for name in self.free}


def held_cells(model: Any, free: Sequence[str], held: Optional[Mapping[str, ArrayLike]]) -> Mapping[str, ArrayLike]:
    """Masks with the places of expressions, which stay as they are written"""
    if not isinstance(model, ColumnModel):
        return held or {}
    made = dict(held or {})
    for name in free:
        cells = model.cells.get({"Qc": "Q"}.get(name, name), {})
        if name in ("Q", "R") and cells and not np.any(np.diag(getattr(model.plain, name)) > 0):
            raise KalmanqError(f"{name} is from columns, and has no number that can be free: leave it out of --free")
        if name in ("A", "H") and cells:
            mask = np.array(made.get(name, np.zeros(getattr(model, name).shape, bool)), bool)
            mask[tuple(np.array(list(cells)).T)] = True
            made[name] = mask
    return made


def free_by_default(model: Any) -> str:
    """Q and R, but for one that is from columns as a whole"""
    return ",".join(name for name in "QR" if not isinstance(model, ColumnModel) or name not in model.cells
                    or np.any(np.diag(getattr(model.plain, name)) > 0))
