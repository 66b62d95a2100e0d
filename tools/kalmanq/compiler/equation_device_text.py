"""NAME.c, NAME.h and NAME_test.c of a device over the library."""

from __future__ import annotations

from dataclasses import replace
from typing import Sequence

import numpy as np

from kalmanq.compiler.emit import PREDICTS, UPDATES, Row, comment, function, within
from kalmanq.compiler.equation_device import Device, device, field
from kalmanq.compiler.equation_product import EquationHeader
from kalmanq.compiler.equation_text import EquationText
from kalmanq.compiler.floats import MOST
from kalmanq.compiler.host import Ran
from kalmanq.compiler.printing import Body
from kalmanq.compiler.product import Product
from kalmanq.compiler.record import Record
from kalmanq.compiler.request import Options
from kalmanq.compiler.trial import ROWS, Trial
from kalmanq.formulas.graph import Node, call, constant, dot, make, using
from kalmanq.nonlinear import NonlinearModel
from kalmanq.nonlinear.model import Sensor


def compiled_device(model: NonlinearModel, name: str, options: Options = Options(), source: str = "") -> Product:
    with using(model.formulas.graph):
        a = device(model, name, options)
        text = DeviceText(a.given, a)
        remarks = [f"{name}: written by kalmanq compile --library.", *([source] if source else [])]
        return Product(a.given, None, None, a, text, DeviceHeader(a.given, a, text).text(), text.code(remarks))


class DeviceText(EquationText):
    of: Device

    def parts(self) -> list[list[str]]:
        updates = [lines for one in self.of.sensors for lines in (self._innovation(one), self._update_of(one), self._update_some_of(one))]
        return [self._start(), self._predict(), *([self._reset_errors()] if self.of.has_errors else []), *updates]

    def row(self, of: Row) -> list[str]:
        """The same calls as of the straight-line filter, whose answer here is a status"""
        lines = super().row(of)
        made = [f"if ({of.what} & {PREDICTS} && {lines[0].split(') ', 1)[1].rstrip(';')}) {of.taken} |= UINT32_C(1) << 31;"]
        for sensor, line in zip(self.of.sensors, lines[1:]):
            called = line.split(" |= ")[1].split(" << ")[0]
            present = f"({of.present} >> {sensor.first} & {sensor.all}u)"
            made.append(f"if ({of.what} & {UPDATES} && {present} && !{called}) {of.taken} |= {present} << {sensor.first};")
        return made

    def _calls(self, first: str, *more: str) -> list[str]:
        """One after the other, while the status is KQ_OK"""
        return [f"kq_status status = {first};", *(f"if (!status) status = {one};" for one in more)]

    def _start(self) -> list[str]:
        a, T, n = self.of, self.of.T, self.of.n
        calls = [f"kq_filter_assign_{T}(&f->filter, {n}, f->filter_memory, KQ_FILTER_LEN_{T.upper()}({n}))",
                 f"kq_process_assign_{T}(&f->process, {n}, {self._l}, f->process_memory, KQ_PROCESS_LEN({n}))",
                 *(f"kq_sensor_assign_{T}(&f->{field(one)}, {n}, {one.m}, f->{field(one)}_memory, {a.length(one)})" for one in a.sensors)]
        A, B = "f->A" if self._varies_A else "A", "B" if self._l else "NULL"
        G = a.nonlinear.G
        calls.append(f"kq_process_init_{T}(&f->process, {A}, {B}, Q)" if G is None else
                     f"kq_process_init_factor_{T}(&f->process, {A}, {B}, F, {np.atleast_2d(G).shape[1]})")
        for one in a.sensors:
            kind = ("_diagonal" if a.is_diagonal(one) else "") + ("" if one in a.plain else "_extended")
            calls.append(f"kq_sensor_init{kind}_{T}(&f->{field(one)}, {self._H(one)}, R{one.suffix})")
        mean = "none" if a.has_errors else "first"
        calls.append(f"kq_filter_init_{T}(&f->filter, {mean}, P0)")
        copies = [("A", "A", n * n)] if self._varies_A else []
        copies += [(f"H{one.suffix}", f"H{one.suffix}", one.m * n) for one in a.sensors if self._H(one).startswith("f->")]
        copies += [("x", "first", len(self.given.carried))] if a.has_errors else []
        lines = [f"static const {a.type} none[{n}] = {{0}};"] if a.has_errors else []
        lines += [f"for (int i = 0; i < {size}; i++) f->{to}[i] = {of}[i];" for to, of, size in copies]
        return function(f"kq_status {self.given.name}_start({self.filter})", [*lines, *self._calls(*calls), "return status;"])

    @property
    def _l(self) -> int:
        return self.of.B.shape[1] if self.of.B is not None else 0

    @property
    def _varies_A(self) -> bool:
        return not all(one.is_constant for one in self.of.transition)

    def _H(self, sensor: Sensor) -> str:
        return f"{'' if all(one.is_constant for one in self.of.rows_of(sensor)) else 'f->'}H{sensor.suffix}"

    def _places(self) -> list[tuple[str, str, str]]:
        a = self.of
        x = [(a.type, f"x{i}", a.mean_text(i)) for i in range(len(self.given.carried))]
        d = [(a.type, f"d{i}", f"kq_mean_{a.T}(&f->filter, {i})") for i in range(a.n)]
        return [*x, *d, *((a.type, f"u{k}", f"u[{k}]") for k in range(self.given.of.l)),
                *((a.type, f"z{one.first + j}", f"z[{j}]") for one in a.sensors for j in range(one.m))]

    def _unless_finite(self, body: Body, values: Sequence[Node]) -> None:
        total = call("abs", dot((one, 1.0) for one in values))
        body.name_shared([*values, total])
        body.lines.append(f"if (!({body.text(make('le', total, constant(MOST[self.of.type])))})) return KQ_ERR_NOT_FINITE;")

    def _written(self, body: Body, target: str, entries: Sequence[Node]) -> bool:
        """Those that are not constant"""
        made = [(f"f->{target}[{k}]", one) for k, one in enumerate(entries) if not one.is_constant]
        body.assign(made)
        return bool(made)

    def _predict(self) -> list[str]:
        a, T = self.of, self.of.T
        head = f"kq_status {self.given.name}_predict({self.filter}{self.predict_arguments()})"
        if a.B is not None:
            return function(head, [f"return kq_predict_{T}(&f->filter, &f->process, {'u' if self._l else 'NULL'});"])
        body, given = Body(a.words), "d"
        if a.has_errors:
            body.name_shared([*a.moved, *a.transition])
            self._unless_finite(body, a.moved)
            body.lines += [f"const {a.type} moved{i} = {body.text(one)};" for i, one in enumerate(a.moved)]
            body.lines.append(f"static const {a.type} d[{a.n}] = {{0}};")
        else:
            body.name_shared([*a.change, *a.transition])
            body.lines.append(f"const {a.type} d[{a.n}] = {{{', '.join(body.text(one) for one in a.change)}}};")
        changed = self._written(body, "A", a.transition)
        calls = [f"kq_process_change_transition_{T}(&f->process, f->A)"] if changed else []
        last = [*self._calls(*calls, f"kq_predict_extended_{T}(&f->filter, &f->process, {given})")]
        if a.has_errors:
            last += ["if (status) return status;", *(f"f->x[{i}] = moved{i};" for i in range(len(a.moved)))]
        return function(head, [*within(self._places(), body.lines), *last, "return status;"])

    def _reset_errors(self) -> list[str]:
        a, body = self.of, Body(self.of.words)
        body.name_shared(a.corrected)
        self._unless_finite(body, a.corrected)
        body.lines += [f"const {a.type} whole{i} = {body.text(one)};" for i, one in enumerate(a.corrected)]
        body.lines.append(f"const {a.type} back[{a.n}] = {{{', '.join(f'-d{i}' for i in range(a.n))}}};")
        return function(f"kq_status {self.given.name}_reset({self.filter})", [
            *within(self._places(), body.lines), f"const kq_status status = kq_move_{a.T}(&f->filter, back);",
            "if (status) return status;", *(f"f->x[{i}] = whole{i};" for i in range(len(a.corrected))), "return status;"])

    def _innovation(self, sensor: Sensor) -> list[str]:
        a = self.of
        if sensor in a.plain:
            return []
        e, rows, body = a.e[sensor.first:sensor.first + sensor.m], a.rows_of(sensor), Body(a.words)
        body.name_shared([*e, *rows])
        body.assign([(f"e[{j}]", one) for j, one in enumerate(e)])
        changed = self._written(body, f"H{sensor.suffix}", rows)
        last = f"return kq_sensor_change_measurement_{a.T}(&f->{field(sensor)}, {self._H(sensor)});" if changed else "return KQ_OK;"
        return function(self.innovation_head(sensor), [*within(self._places(), body.lines), last])

    def innovation_head(self, sensor: Sensor) -> str:
        return (f"kq_status {self.given.name}_innovation{sensor.suffix}({self.filter}{self.update_arguments(sensor)}, "
                f"{self.of.type} e[{sensor.m}])")

    def _taken_by(self, sensor: Sensor, call_: str, present: str) -> list[str]:
        a, name, arguments = self.of, self.given.name, self.update_arguments(sensor)
        call_ = f"{call_}_{a.T}(&f->filter, &f->{field(sensor)}, {{}}{present})"
        if sensor in a.plain:
            return [f"return {call_.format('z')};"]
        resets = [f"{name}_reset(f)"] if a.has_errors else []
        return [f"{a.type} e[{sensor.m}];", *self._calls(f"{name}_innovation{sensor.suffix}(f{self._same(arguments)}, e)",
                                                         call_.format("e"), *resets), "return status;"]

    def _update_of(self, sensor: Sensor) -> list[str]:
        return function(f"kq_status {self.given.name}_update{sensor.suffix}({self.filter}{self.update_arguments(sensor)})",
                        self._taken_by(sensor, "kq_update", ""))

    def _update_some_of(self, sensor: Sensor) -> list[str]:
        if sensor.m == 1:
            return []
        return function(f"kq_status {self.given.name}_update{sensor.suffix}_some({self.filter}{self.update_arguments(sensor)}, "
                        "unsigned present)", self._taken_by(sensor, "kq_update_subset", ", present"))


class DeviceHeader(EquationHeader):
    a: Device
    c: DeviceText

    def _what(self) -> list[str]:
        what, *more = super()._what()
        return [what, "A device over the library (kalmanq/extended.h): its calls answer the library's statuses.", *more]

    def _usage(self) -> list[str]:
        T, n, a = self.a.T, self.a.n, self.a
        tape = f"KQ_HISTORY_{T.upper()}(tape, {n}, {a.given.of.m}, STEPS, "
        lines = [*super()._usage(), "", "For smoothers, attach a history after NAME_start (kalmanq/smoother.h):".replace("NAME", self.name), ""]
        if a.B is not None:
            lines += [f"    {tape}0);", f"    kq_attach_{T}({self.name}_filter(&f), &tape.attached);"]
        else:
            lines += [f"    {tape}STEPS);", f"    KQ_JACOBIANS_{T.upper()}(jacobians, tape, {n}, STEPS, 1);",
                      f"    kq_attach_{T}({self.name}_filter(&f), &jacobians.attached);"]
        if a.has_errors:
            lines += ["", "A smoothed mean is the error of what f.x was when the next predict began: keep f.x of each step."]
        one = a.sensors[0]
        z = "z" if one in a.plain else "e"
        lines += ["", "A robust update (kalmanq/robust.h):", ""]
        lines += [] if z == "z" else [f"    {self.name}_innovation{one.suffix}(&f{self.c._same(self.c.update_arguments(one))}, e);"]
        lines += [f"    kq_update_robust_{T}({self.name}_filter(&f), &f.{field(one)}, {z}, UINT32_MAX, &loss);"]
        return lines + ([f"    {self.name}_reset(&f);"] if a.has_errors else [])

    def _events(self) -> list[str]:
        return []

    def _fields(self) -> list[str]:
        return ["typedef struct {", *(f"    {line}" for line in self.a.fields), f"}} {self.given.type};", ""]

    def _calls(self) -> list[str]:
        lines = ["/** Before the first sample.  Detaches what was attached. */", f"kq_status {self.name}_start({self.filter});", ""]
        lines += ["/** To the next instant. */", f"kq_status {self.name}_predict({self.filter}{self.c.predict_arguments()});", ""]
        if self.a.has_errors:
            lines += ["/** The errors go into f->x, and are 0 then.  An update has done it. */",
                      f"kq_status {self.name}_reset({self.filter});", ""]
        for one in self.a.sensors:
            arguments = self.c.update_arguments(one)
            lines += ["/** Takes a sample. */", f"kq_status {self.name}_update{one.suffix}({self.filter}{arguments});", ""]
            if one.m > 1:
                lines += ["/** Takes the components of a sample whose bits are set in `present`. */",
                          f"kq_status {self.name}_update{one.suffix}_some({self.filter}{arguments}, unsigned present);", ""]
            if one not in self.a.plain:
                lines += ["/** Innovations e of a sample at the mean; the sensor's H becomes the derivative there. */",
                          f"{self.c.innovation_head(one).replace('restrict ', '')};", ""]
        return lines


class DeviceTrial(Trial):
    """Rows come to what the straight-line C came to in double."""

    def text(self) -> str:
        lines = comment([f"{self.name}_test: {ROWS} rows of the model, some of them missing, come to what the straight-line C came to",
                         "in double.  Prints OK.  Link it with kalmanq."])
        return "\n".join([*lines, "#include <stdio.h>", "", f'#include "{self.name}.h"', "", *self._rows(), *self._near(), *self._main()])

    def _variance(self, i: int) -> str:
        sigma = f"{self.name}_sigma_{self.given.states[i]}(&f)" if not self.given.nominal else ""
        return f"{sigma} * {sigma}" if sigma else super()._variance(i)

    def _main(self) -> list[str]:
        made = [line for line in super()._main() if "uint32_t h = " not in line]
        made = [line.replace(", digest %08lx", "").replace(", (unsigned long)h", "") for line in made]
        return [line.replace(f"{self.name}_start(&f);", f"wrong += {self.name}_start(&f) != KQ_OK;") for line in made]


def in_whole_groups(record: Record, together: Sequence[int]) -> Record:
    """Without samples of which a part with correlated noises is missing: the straight-line C leaves out all of it"""
    present = record.present.copy()
    for group in set(together):
        present[(present & group) != group] &= ~np.uint32(group)
    what = np.where(present > 0, record.what, record.what & PREDICTS).astype(np.uint8)
    return replace(record, present=present, what=what)


def device_trial(product: Product, record: Record, exact: Ran) -> str:
    """exact: what the record comes to in double"""
    return DeviceTrial(product, record, exact).text()
