"""A device in q31 that is run over a record on this machine: its formulas in Python and the library's C, bit for bit the chip's."""

from __future__ import annotations

from typing import Any, Optional, Sequence

import numpy as np

from kalmanq.compiler.algorithm.fixed.device import Evaluated, FixedDevice
from kalmanq.compiler.algorithm.fixed.functions import NO_VALUE
from kalmanq.compiler.algorithm.fixed.python import Far
from kalmanq.compiler.algorithm.fixed.tables import constant_entry
from kalmanq.compiler.run.host import Ran
from kalmanq.compiler.run.record import Record
from kalmanq.compiler.text.emit import PREDICTS, UPDATES
from kalmanq.core import ffi, lib
from kalmanq.nonlinear.model import Sensor
from kalmanq.run.readings import Readable

LIBRARY = 16  # the library's events, in a row's


class FixedRun:
    """events: of formulas; those of the library are of `filter`"""

    def __init__(self, device: FixedDevice):
        self.device, n = device, device.n
        self.filter = Readable(device.process.model, device.process)
        device.process.init_filter(self.filter._handle)
        self.events = 0
        self.process = device.process.process
        self.A = ffi.new("kq_scaled_q31[]", n * n)
        self.H = {one.name: ffi.new("kq_scaled_q31[]", one.m * n) for one in device.sensors}
        self.x = list(device.first) if device.has_errors else []  # nominal numbers
        _fill(self.A, device.transition, np.subtract.outer(device.d, device.d))
        for one in device.sensors:
            own = [device.innovation_fraction(j) for j in range(one.first, one.first + one.m)]
            _fill(self.H[one.name], device.rows_of(one), np.subtract.outer(own, device.d))
        if device.predicted:
            lib.kq_process_change_jacobian_q31(self.process, self.A, ffi.NULL)

    def run(self, record: Record, first: int = 0) -> Ran:
        """From where it is; first: the row that the record begins with"""
        device, rows, n, count = self.device, len(record.what), self.device.n, len(self.device.x)
        numbers = (np.zeros((rows, *shape)) for shape in ((count,), (count,), (n, n)))
        made = Ran(*numbers, *(np.zeros(rows, np.uint32) for _ in range(2)))
        for t in range(rows):
            made.taken[t] = self.row(record, t, first)
            made.reading[t] = self._words()
            made.mean[t] = np.ldexp(np.array(self.x, float), -np.array(device.x)) if device.has_errors else self.filter.mean
            made.covariance[t] = self.filter.covariance
            made.events[t], self.events = self.events | self.filter.events << LIBRARY, 0
            self.filter.clear_events()
        return made

    def row(self, record: Record, t: int, first: int = 0) -> int:
        """Bits of what was taken; bit 31: the predict was refused"""
        device, taken = self.device, 0
        u, now = ([] if of is None else device.raws("controls", of[t]) for of in (record.u, record.now))
        z = device.raws("measurements", record.z[t])
        if record.what[t] & PREDICTS and self.predict(u, first + t - 1):
            taken |= 1 << 31
        for one in device.sensors if record.what[t] & UPDATES else ():
            present = int(record.present[t]) >> one.first & one.all
            if present and not self.update(one, z, now, first + t, present):
                taken |= present << one.first
        return taken

    def predict(self, u: list[int], t: int) -> int:
        handle, of = self.filter._handle, self.device.predicted
        if of is None:
            return int(lib.kq_predict_q31(handle, self.process, u or ffi.NULL))
        d = self._evaluated(of, self.A, _named("u", u), t)
        if d is None:
            return int(lib.KQ_ERR_NOT_FINITE)
        status = lib.kq_process_change_jacobian_q31(self.process, self.A, ffi.NULL) if of.table else 0
        if not self.device.has_errors:
            return int(status or lib.kq_predict_extended_q31(handle, self.process, d))
        status = status or lib.kq_predict_extended_q31(handle, self.process, [0] * self.device.n)
        self.x = self.x if status else d
        return int(status)

    def reset(self) -> int:
        """The errors go into the nominal numbers"""
        d = [int(lib.kq_mean_q31(self.filter._handle, i)) for i in range(self.device.n)]
        assert self.device.resetting
        whole = self._evaluated(self.device.resetting, None, _named("d", d), 0)
        if whole is None:
            return int(lib.KQ_ERR_NOT_FINITE)
        status = lib.kq_move_q31(self.filter._handle, [-max(one, -2**31 + 1) for one in d])
        self.x = self.x if status else whole
        return int(status)

    def update(self, sensor: Sensor, z: list[int], u: list[int], t: int, present: int) -> int:
        handle, parts = self.filter._handle, self.device.parts[sensor.name]
        given: Optional[list[int]] = z[sensor.first:sensor.first + sensor.m]
        if sensor not in self.device.plain:
            of, H = self.device.measured_by[sensor.name], self.H[sensor.name]
            given = self._evaluated(of, H, {**_named("u", u), **_named("z", z)}, t)
            if given is None:
                return int(lib.KQ_ERR_NOT_FINITE)
            status = lib.kq_sensor_change_measurement_q31(parts.sensor, H, ffi.NULL) if of.table else 0
            if status:
                return int(status)
        status = lib.kq_update_q31(handle, parts.sensor, given) if sensor.m == 1 else \
            lib.kq_update_subset_q31(handle, parts.sensor, given, present)
        return int(status) or (self.reset() if self.device.has_errors else 0)

    def _evaluated(self, of: Evaluated, table: Any, given: dict[str, int], t: int) -> Optional[list[int]]:
        """Its words; None: a formula has no value.  The table gets its entries"""
        far = Far()
        values = {**dict.fromkeys(of.formulas.inputs, 0), **_named("x", self._words()), **given, "t": t}
        made = of.run(far, **values)
        self.events |= far.bits
        for (k, _), entry in zip(of.table, made[len(of.words):]):
            table[k].mantissa, table[k].exponent = entry.mantissa, entry.exponent
        return None if far.bits & NO_VALUE else made[:len(of.words)]

    def _words(self) -> list[int]:
        """Of what the formulas are of"""
        return self.x or [int(lib.kq_mean_q31(self.filter._handle, i)) for i in range(self.device.n)]


def _named(stem: str, values: Sequence[int]) -> dict[str, int]:
    return {f"{stem}{k}": value for k, value in enumerate(values)}


def _fill(table: Any, entries: Any, exponents: np.ndarray) -> None:
    for k, (one, by) in enumerate(zip(entries, exponents.ravel())):
        table[k].mantissa, table[k].exponent = constant_entry(one, by)
