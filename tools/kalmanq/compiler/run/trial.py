"""NAME_test.c: a program that ends with OK where the filter does on your chip what it did on the host."""

from __future__ import annotations

from typing import Any, Iterable, Iterator, Optional, Sequence

import numpy as np

from kalmanq.compiler.run.host import Host, Ran
from kalmanq.compiler.run.record import Record, drawn
from kalmanq.compiler.templates.engine import rendered
from kalmanq.compiler.text.delayed import Late
from kalmanq.compiler.text.emit import Row
from kalmanq.compiler.text.product import Product

ROWS = 24
SEED = 1
NEAR = {"f32": 1e-3, "f64": 1e-9}  # sigma: a core may fuse products where another one rounds them
FAR = 0.5  # sigma: never more
ROUNDINGS = 4  # of what float is off itself: a core's math library rounds in another way


def trial(product: Product, host: Host, record: Optional[Record] = None, rounded: float = 0.0) -> str:
    """rounded: how far float is off double, in sigma"""
    record = record or drawn(product.given, ROWS, SEED, 3)
    ran = host.run_record(record)
    back = host.steps_back(record.what) if product.given.options.smooth else None
    return Trial(product, record, ran, back, rounded).text()


class Trial:
    """back: smoothed means 1, 2, ... steps ago, of a filter with --smooth; is_device: over the library"""

    def __init__(self, product: Product, record: Record, ran: Ran, back: Optional[np.ndarray] = None, rounded: float = 0.0,
                 is_device: bool = False):
        self.product, self.given, self.a, self.name = product, product.given, product.arithmetic, product.given.name
        self.record, self.ran, self.back, self.rounded, self.is_device = record, ran, back, rounded, is_device

    def text(self) -> str:
        smoothed = [] if self.back is None else [f"{self._cells(row)}," for row in self.back]
        return rendered("filter_test.c.j2", {
            **self.product.text.names(), "ROWS": ROWS, "is_device": self.is_device, "digest": f"{self.ran.digest:08x}",
            "is_rounded": bool(self.rounded), "limit": self._limit(), "limit_said": self._limit().rstrip("f"),
            "inputs_of_row": self._inputs(), "rows": [*self._rows()],
            "row": self._row(), "variances": self._variances(), "fields": () if self.is_device else self.a.arrays, "smoothed": smoothed, "late": self._late()})

    def _inputs(self) -> list[str]:
        """Fields of a row, beside what all have"""
        l = self.given.inputs
        controls = [f"{self.a.type} {', '.join(f'{name}[{l}]' for name, _ in self._controls())};"] if l else []
        return [*controls, *([] if self.record.clock is None else [f"{self.a.type} clock[3];"])]

    def _controls(self) -> list[tuple[str, np.ndarray]]:
        given = [("u", self.record.u), *([] if self.record.now is None else [("now", self.record.now)])]
        return given if self.given.inputs else []

    def _rows(self) -> Iterator[str]:
        l, clock = self.given.inputs, self.record.clock
        for t in range(ROWS):
            cells = [*(str(one[t]) for one in (self.record.what, self.record.present, self.ran.taken)),
                     *(self._list("controls", values[t][:l]) for _, values in self._controls()),
                     *([] if clock is None else [self._cells(np.nan_to_num(clock[t]))]),
                     self._list("measurements", self.record.z[t]), self._cells(self.ran.reading[t])]
            yield f"{{{', '.join(cells)}}},"

    def _cells(self, values: Iterable[float]) -> str:
        return f"{{{', '.join(self.a.literal(value) for value in values)}}}"

    def _list(self, which: str, values: Sequence[float]) -> str:
        return self._cells(self.a.raw(which, k, value) for k, value in enumerate(values))

    def _late(self) -> Optional[dict[str, Any]]:
        """Calls of the program for what comes in time, and late"""
        late = self.product.late
        if late is None:
            return None
        late.has_clock = self.record.clock is not None
        sensors = []
        for one in late.sensors or [Late("", 0, self.given.of.m, late.kept - 1)]:
            steps = min(one.steps, ROWS // 2)
            sensors.append({"steps": steps, "late": late.late_row(one, f"t - {steps}" if steps else "t", str(steps)),
                            "last": late.late_row(one, "t", f"(unsigned)({ROWS} - t)")})
        return {"in_time": late.in_time(), "in_time_predict": late.in_time_predict(), "predict": late.late_predict("t"), "sensors": sensors}

    def _limit(self) -> str:
        """Of what is apart, in sigma"""
        arithmetic = self.given.options.arithmetic
        if arithmetic == "q31":
            return "0"
        return self.a.literal(float(np.clip(np.nan_to_num(ROUNDINGS * self.rounded), NEAR[arithmetic], FAR)))

    def _variances(self) -> list[str]:
        """Nominal numbers have none of their own: the least of the errors"""
        if not self.given.nominal or self.given.options.arithmetic == "q31":
            return []
        return [self.a.literal(float(np.einsum("tii->ti", self.ran.covariance).min()))] * len(self.given.carried)

    def _row(self) -> list[str]:
        clock = ("t - 1", "", "t") if self.record.clock is None else (f"rows[t].clock[{k}]" for k in range(3))
        return self.product.text.row(Row(*(f"rows[t].{one}" for one in ("what", "present", "z", "u", "now")), *clock, "taken"))


def device_trial(product: Product, record: Record, exact: Ran) -> str:
    """exact: what the record comes to in double"""
    return Trial(product, record, exact, is_device=True).text()
