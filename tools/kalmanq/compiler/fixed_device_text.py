"""NAME.c of a device over the library in q31."""

from __future__ import annotations

from typing import Optional

from kalmanq.compiler.emit import function, within
from kalmanq.compiler.equation_device import field
from kalmanq.compiler.equation_device_text import DeviceHeader, DeviceText
from kalmanq.compiler.fixed_device import Evaluated, FixedDevice, fixed_device
from kalmanq.compiler.fixed_records import Seen, simulated
from kalmanq.compiler.product import Product
from kalmanq.compiler.request import Options
from kalmanq.formulas.graph import using
from kalmanq.nonlinear import NonlinearModel
from kalmanq.nonlinear.model import Sensor


def compiled_fixed(model: NonlinearModel, name: str, options: Options = Options("q31"), source: str = "",
                   seen: Optional[Seen] = None) -> Product:
    """seen: records that the formats are of; simulated ones otherwise"""
    seen = seen or simulated(model)
    with using(model.formulas.graph):
        a = fixed_device(model, name, options, seen)
        text = FixedDeviceText(a.given, a)
        remarks = [f"{name}: written by kalmanq compile --library --arith q31.", *([source] if source else [])]
        return Product(a.given, None, None, a, text, DeviceHeader(a.given, a, text).text(), text.code(remarks))


class FixedDeviceText(DeviceText):
    of: FixedDevice

    def _start(self) -> list[str]:
        a, n = self.of, self.of.n
        A = "f->A" if a.predicted and a.predicted.table else "A"
        calls = [f"kq_filter_assign_q31(&f->filter, {n}, f->filter_memory, KQ_FILTER_LEN_Q31({n}))",
                 "kq_process_init_q31(&f->process, &process_table, NULL)",
                 *([f"kq_process_change_jacobian_q31(&f->process, {A}, NULL)"] if a.predicted else [])]
        for one in a.sensors:
            kind = ("_diagonal" if a.is_diagonal(one) else "") + ("" if one in a.plain else "_extended")
            calls.append(f"kq_sensor_init{kind}_q31(&f->{field(one)}, &table{one.suffix}, NULL)")
        copies = [("A", n * n)] if A == "f->A" else []
        copies += [(f"H{one.suffix}", one.m * n) for one in a.sensors if a.varies(one)]
        lines = [f"for (int i = 0; i < {size}; i++) f->{name}[i] = {name}[i];" for name, size in copies]
        lines += [f"for (int i = 0; i < {len(a.x)}; i++) f->x[i] = first[i];"] if a.has_errors else []
        return function(f"kq_status {self.given.name}_start({self.filter})", [
            *lines, "f->events = 0;", *self._calls(*calls, "kq_filter_init_q31(&f->filter, &prior, NULL)"), "return status;"])

    def _start_at(self) -> list[str]:
        a, n, carried = self.of, self.of.n, len(self.given.carried)
        lines = [f"static const int32_t none[{n}] = {{0}};"] if a.has_errors else []
        lines += [f"int32_t root[KQ_ROOT_LEN_Q31({n})] = {{0}};",
                  f"const kq_prior_table_q31 given = {{{n}, state_format, {'none' if a.has_errors else 'mean'}, root}};",
                  *self._calls(f"{self.given.name}_start(f)"), f"for (int i = 0; i < {n}; i++) root[i * (i + 3) / 2] = sigma[i];",
                  *([f"for (int i = 0; i < {carried}; i++) f->x[i] = mean[i];"] if a.has_errors else []),
                  "return status ? status : kq_filter_init_q31(&f->filter, &given, NULL);"]
        return function(self.start_at_head(), lines)

    def _evaluated(self, of: Evaluated, to: str, table: str) -> list[str]:
        """Its formulas, where none is without a value; the local array `to` is there"""
        lines = [*of.formulas.c([*of.words, *(text for _, text in of.table)]),
                 *(f"{to}[{k}] = {text};" for k, text in enumerate(of.words)),
                 *(f"{table}[{k}] = {text};" for k, text in of.table)]
        if not any("far" in one for one in lines):
            return lines
        upper = self.given.upper
        return ["uint32_t far[1] = {0};", *lines, "f->events |= *far;", f"if (*far & {upper}_NO_VALUE) return KQ_ERR_NOT_FINITE;"]

    def _predict(self) -> list[str]:
        of = self.of.predicted
        if of is None:
            return super()._predict()
        to, given = ("moved", [f"static const int32_t d[{self.of.n}] = {{0}};"]) if self.of.has_errors else ("d", [])
        calls = ["kq_process_change_jacobian_q31(&f->process, f->A, NULL)"] if of.table else []
        calls.append("kq_predict_extended_q31(&f->filter, &f->process, d)")
        return function(f"kq_status {self.given.name}_predict({self.filter}{self.predict_arguments()})", [
            f"int32_t {to}[{len(of.words)}];", *given, *within(self._places(), self._evaluated(of, to, "f->A")),
            *self._calls(*calls), *(self._takes(to) if self.of.has_errors else []), "return status;"])

    def _takes(self, name: str) -> list[str]:
        """Nominal numbers, if the call before has been taken"""
        return ["if (status) return status;", f"for (int i = 0; i < {len(self.of.x)}; i++) f->x[i] = {name}[i];"]

    def _reset_errors(self) -> list[str]:
        n, count = self.of.n, len(self.of.x)
        backs = [f"back[{i}] = d{i} > -INT32_MAX ? -d{i} : INT32_MAX;" for i in range(n)]
        return function(f"kq_status {self.given.name}_reset({self.filter})", [
            f"int32_t whole[{count}], back[{n}];",
            *within(self._places(), [*self._evaluated(self.of.resetting, "whole", ""), *backs]),
            "const kq_status status = kq_move_q31(&f->filter, back);", *self._takes("whole"), "return status;"])

    def _innovation(self, sensor: Sensor) -> list[str]:
        if sensor in self.of.plain:
            return []
        of = self.of.measured_by[sensor.name]
        H = f"f->H{sensor.suffix}"
        last = f"return kq_sensor_change_measurement_q31(&f->{field(sensor)}, {H}, NULL);" if of.table else "return KQ_OK;"
        return function(self.innovation_head(sensor), [*within(self._places(), self._evaluated(of, "e", H)), last])
