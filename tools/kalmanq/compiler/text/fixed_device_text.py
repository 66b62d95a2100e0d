"""NAME.c of a device over the library in q31."""

from __future__ import annotations

from typing import Any

from kalmanq.compiler.algorithm.fixed.device import Evaluated, FixedDevice, fixed_device
from kalmanq.compiler.algorithm.fixed.values import Seen
from kalmanq.compiler.given.request import Options
from kalmanq.compiler.text.emit import within
from kalmanq.compiler.text.equation_device_text import DeviceText
from kalmanq.compiler.text.product import Product, written
from kalmanq.formulas.graph import using
from kalmanq.nonlinear import NonlinearModel
from kalmanq.nonlinear.model import Sensor


def compiled_fixed(model: NonlinearModel, name: str, seen: Seen, options: Options = Options("q31"),
                   source: str = "") -> Product:
    """seen: records that the formats are of"""
    model = model.traced_anew()
    with using(model.formulas.graph):
        text = FixedDeviceText(fixed_device(model, name, options, seen))
        return written(text, [f"{name}: written by kalmanq compile --library --arith q31.", *([source] if source else [])])


class FixedDeviceText(DeviceText):
    of: FixedDevice

    is_fixed = True

    def _varies(self) -> bool:
        return bool(self.of.predicted and self.of.predicted.table)

    def _varies_with(self, sensor: Sensor) -> bool:
        return self.of.varies(sensor)

    def _evaluated(self, of: Evaluated, to: str, table: str) -> list[str]:
        """Its formulas, where none is without a value; the local array `to` is there"""
        lines = [*of.formulas.c([*of.words, *(text for _, text in of.table)]),
                 *(f"{to}[{k}] = {text};" for k, text in enumerate(of.words)),
                 *(f"{table}[{k}] = {text};" for k, text in of.table)]
        if not any("far" in one for one in lines):
            return lines
        upper = self.given.upper
        return ["uint32_t far[1] = {0};", *lines, "f->events |= *far;", f"if (*far & {upper}_NO_VALUE) return KQ_ERR_NOT_FINITE;"]

    def _predicted(self) -> dict[str, Any]:
        of, has_errors = self.of.predicted, self.of.has_errors
        to, given = ("moved", [f"static const int32_t d[{self.of.n}] = {{0}};"]) if has_errors else ("d", [])
        return {"predicted": [f"int32_t {to}[{len(of.words)}];", *given, *within(self._places(), self._evaluated(of, to, "f->A"))],
                "moved": self._takes(to) if has_errors else []}

    def _takes(self, name: str) -> list[str]:
        """Nominal numbers"""
        return [f"for (int i = 0; i < {len(self.of.x)}; i++) f->x[i] = {name}[i];"]

    def _reset(self) -> dict[str, Any]:
        n, count = self.of.n, len(self.of.x)
        backs = [f"back[{i}] = d{i} > -INT32_MAX ? -d{i} : INT32_MAX;" for i in range(n)]
        return {"resets": [f"int32_t whole[{count}], back[{n}];",
                           *within(self._places(), [*self._evaluated(self.of.resetting, "whole", ""), *backs])],
                "corrected": self._takes("whole")}

    def _innovations(self, sensor: Sensor) -> dict[str, Any]:
        return {"measured": within(self._places(), self._evaluated(self.of.measured_by[sensor.name], "e", f"f->H{sensor.suffix}"))}
