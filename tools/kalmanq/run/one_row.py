"""A row of measurements that a filter takes by itself: all of what C is given is made once."""

from __future__ import annotations

from typing import Any

import numpy as np

from kalmanq.core import ffi, lib
from kalmanq.errors import KalmanqError
from kalmanq.run.readings import Readable


class OneRow:
    """Of a filter; it knows no robust loss, and nothing watches"""

    def __init__(self, filter_: Readable):
        a, model = filter_.arithmetic, filter_.model
        self._words, self._run = a.empty(model.m), a.function("sequence_run")
        self._shape, self._less, self._rounds = (model.m,), None if model.d is None else np.asarray(model.d, a.number), a.name == "f32"
        self._q = q = ffi.new(f"kq_sequence_{a.name} *")
        q.filter, q.process, q.sensor, q.steps, q.begins = filter_._handle, filter_.parts.process, filter_.parts.sensor, 1, True
        q.z, q.u = a.pointer(self._words), ffi.NULL
        self._of_fixed: Any = filter_.parts.words if a.is_fixed else None
        if a.is_fixed:
            q.widest = ffi.cast("double *", filter_._widest.ctypes.data)

    def take(self, z: Any) -> bool:
        """False: it is no row of m numbers that the filter takes, and nothing has changed; a sequence of one row says why"""
        if not self._is_row(z):
            return False
        if self._of_fixed:
            try:
                self._words[:] = self._of_fixed(np.array(z, float).reshape(1, -1), "measurements")[0]
            except KalmanqError:
                return False
        elif self._rounds:
            with np.errstate(over="ignore"):
                self._words[:] = z
        else:
            self._words[:] = z
        if self._less is not None and not self._of_fixed:
            self._words -= self._less
        return self._run(self._q) >= lib.KQ_OK

    def _is_row(self, z: Any) -> bool:
        kind = type(z)
        if kind is np.ndarray:
            return z.shape == self._shape and z.dtype.kind == "f"
        if kind is float:
            return self._shape == (1,)
        return (kind is list or kind is tuple) and len(z) == self._shape[0] and all(type(one) is float for one in z)
