"""NAME.c, NAME.h and NAME_test.c of a device over the library."""

from __future__ import annotations

import textwrap
from dataclasses import replace
from typing import Sequence

import numpy as np

from kalmanq.compiler.emit import PREDICTS, UPDATES, Row, comment, function, passed, within
from kalmanq.compiler.equation_device import Device, device, field, varies
from kalmanq.compiler.equation_product import EquationHeader
from kalmanq.compiler.equation_rounding import PER_SIGMA
from kalmanq.compiler.equation_text import EquationText
from kalmanq.compiler.floats import MOST
from kalmanq.compiler.host import Ran
from kalmanq.compiler.printing import Body, indented
from kalmanq.compiler.product import Product
from kalmanq.compiler.record import Record
from kalmanq.compiler.request import Options
from kalmanq.compiler.trial import ROWS, Trial
from kalmanq.formulas.graph import Node, constant, dot, make, mul, using
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
        updates = [lines for one in self.of.sensors for lines in (
            self._linearised(one), self._innovation(one), self._update_some_of(one), self._update_of(one))]
        resets = [self._reset_errors()] if self.of.has_errors else []
        return [self._start(), self._start_at(), self._predict(), *resets, *updates, *self._points()]

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
        return [f"kq_status status = {first};", *self._then(more)]

    @staticmethod
    def _then(calls: Sequence[str]) -> list[str]:
        return [part for one in calls for part in textwrap.wrap(f"if (!status) status = {one};", 124, subsequent_indent="    ")]

    def _start(self) -> list[str]:
        a, T, n = self.of, self.of.T, self.of.n
        calls = [f"kq_filter_assign_{T}(&f->filter, {n}, f->filter_memory, KQ_FILTER_LEN_{T.upper()}({n}))",
                 f"kq_process_assign_{T}(&f->process, {n}, {self._l}, f->process_memory, KQ_PROCESS_LEN({n}))",
                 *(f"kq_sensor_assign_{T}(&f->{field(one)}, {n}, {one.m}, f->{field(one)}_memory, {a.length(one)})" for one in a.sensors)]
        if a.iterates:
            calls.append(f"kq_filter_assign_{T}(&f->trial, {n}, f->trial_memory, KQ_FILTER_LEN_{T.upper()}({n}))")
        A, B = "f->A" if varies(self.of.transition) else "A", "B" if self._l else "NULL"
        G = a.nonlinear.G
        if a.Q:
            calls.append(f"kq_process_init_factor_{T}(&f->process, {A}, NULL, NULL, 0)")  # none before the first predict
        else:
            calls.append(f"kq_process_init_{T}(&f->process, {A}, {B}, Q)" if G is None else
                         f"kq_process_init_factor_{T}(&f->process, {A}, {B}, F, {np.atleast_2d(G).shape[1]})")
        for one in a.sensors:
            kind = ("_diagonal" if a.is_diagonal(one) else "") + ("" if one in a.plain else "_extended")
            calls.append(f"kq_sensor_init{kind}_{T}(&f->{field(one)}, {self._H(one)}, {'f->' if a.has_spread(one) else ''}R{one.suffix})")
        mean = "none" if a.has_errors else "first"
        calls.append(f"kq_filter_init_{T}(&f->filter, {mean}, P0)")
        copies = [("A", "A", n * n)] if varies(self.of.transition) else []
        copies += [(f"H{one.suffix}", f"H{one.suffix}", one.m * n) for one in a.sensors if self._H(one).startswith("f->")]
        ones = [f"for (int i = 0; i < {len(a.spreads(one))}; i++) f->R{one.suffix}[i] = {self._unit(one)}; /* until the first innovation */"
                for one in a.sensors if a.has_spread(one)]
        copies += [("x", "first", len(self.given.carried))] if a.has_errors else []
        lines = [f"static const {a.type} none[{n}] = {{0}};"] if a.has_errors else []
        lines += [f"for (int i = 0; i < {size}; i++) f->{to}[i] = {of}[i];" for to, of, size in copies]
        return function(f"kq_status {self.given.name}_start({self.filter})", [*lines, *ones, *self._calls(*calls), "return status;"])

    def _start_at(self) -> list[str]:
        a, carried = self.of, len(self.given.carried)
        lines = [f"static const {a.type} none[{a.n}] = {{0}};"] if a.has_errors else []
        lines += [f"{a.type} P[{a.n * a.n}] = {{0}};", *self._calls(f"{self.given.name}_start(f)"),
                  f"for (int i = 0; i < {a.n}; i++) P[i * {a.n + 1}] = sigma[i] < 0 ? -1 : sigma[i] * sigma[i]; /* -1: is refused */",
                  *([f"for (int i = 0; i < {carried}; i++) f->x[i] = mean[i];"] if a.has_errors else []),
                  f"return status ? status : kq_filter_init_{a.T}(&f->filter, {'none' if a.has_errors else 'mean'}, P);"]
        return function(self.start_at_head(), lines)

    def start_at_head(self) -> str:
        return (f"kq_status {self.given.name}_start_at({self.filter}, const {self.of.type} mean[{len(self.given.carried)}], "
                f"const {self.of.type} sigma[{self.of.n}])")

    @property
    def _l(self) -> int:
        return self.of.B.shape[1] if self.of.B is not None else 0

    def _H(self, sensor: Sensor) -> str:
        return f"{'f->' if varies(self.of.rows_of(sensor)) else ''}H{sensor.suffix}"

    def _places(self, of: str = "filter") -> list[tuple[str, str, str]]:
        a = self.of
        x = [(a.type, f"x{i}", a.mean_text(i).replace("filter", of)) for i in range(len(self.given.carried))]
        d = [(a.type, f"d{i}", f"kq_mean_{a.T}(&f->filter, {i})") for i in range(a.n)]
        return [*x, *d, *((a.type, f"u{k}", f"u[{k}]") for k in range(self.given.of.l)),
                *((a.type, f"z{one.first + j}", f"z[{j}]") for one in a.sensors for j in range(one.m))]

    def _unless_finite(self, body: Body, values: Sequence[Node]) -> None:
        total = dot((one, 1.0) for one in values)
        square = mul(total, total)  # AVR has no fabsf
        body.name_shared([*values, square])
        body.lines.append(f"if (!({body.text(make('le', square, constant(MOST[self.of.type]**2)))})) return KQ_ERR_NOT_FINITE;")

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
            body.name_shared([*a.moved, *a.transition, *a.noises])
            self._unless_finite(body, a.moved)
            body.lines.append(f"static const {a.type} d[{a.n}] = {{0}};")
        else:
            body.name_shared([*a.change, *a.transition, *a.noises])
            body.lines.append(f"const {a.type} d[{a.n}] = {{{', '.join(body.text(one) for one in a.change)}}};")
        changed = self._written(body, "A", a.transition)
        calls = [f"kq_process_change_transition_{T}(&f->process, f->A)"] if changed else []
        if a.Q:
            name, columns = "F" if a.is_root else "Q", f", {len(a.Q[0])}" if a.is_root else ""
            body.lines.append(f"const {a.type} {name}[{len(a.noises)}] = {{{', '.join(body.text(one) for one in a.noises)}}};")
            calls = [f"kq_process_init{'_factor' if a.is_root else ''}_{T}(&f->process, {'f->A' if varies(self.of.transition) else 'A'}, NULL, "
                     f"{name}{columns})"]
        last = [*self._calls(*calls, f"kq_predict_extended_{T}(&f->filter, &f->process, {given})")]
        if a.has_errors:
            last += self._replaced(body, a.moved)
        return function(head, [*within(self._places(), body.lines), *last, "return status;"])

    def _reset_errors(self) -> list[str]:
        a, body = self.of, Body(self.of.words)
        body.name_shared(a.corrected)
        self._unless_finite(body, a.corrected)
        body.lines.append(f"const {a.type} back[{a.n}] = {{{', '.join(f'-d{i}' for i in range(a.n))}}};")
        return function(f"kq_status {self.given.name}_reset({self.filter})", [
            *within(self._places(), body.lines), f"const kq_status status = kq_move_{a.T}(&f->filter, back);",
            *self._replaced(body, a.corrected), "return status;"])

    @staticmethod
    def _replaced(body: Body, numbers: Sequence[Node]) -> list[str]:
        """Numbers that the states are errors of, once the filter has moved"""
        made = {i: body.text(one) for i, one in enumerate(numbers)}
        return ["if (status) return status;", *(f"f->x[{i}] = {text};" for i, text in made.items() if text != f"x{i}")]

    def _linearised(self, sensor: Sensor) -> list[str]:
        """static: innovations and H of a sensor that is not linear, where the filter is or where it is tried"""
        a = self.of
        if sensor in a.plain or not a.iterates:
            return []
        e, m, n = self._e_and_H(sensor, "trial"), sensor.m, a.n
        lines = [*e, f"for (int i = 0; i < {n}; i++) {{",
                 f"    const {a.type} apart = kq_mean_{a.T}(&f->filter, i) - kq_mean_{a.T}(&f->trial, i);",
                 f"    const {a.type} off = apart + kq_mean_low_{a.T}(&f->filter, i);",
                 f"    for (int j = 0; j < {m}; j++) e[j] -= {self._H(sensor)}[j * {n} + i] * off;", "}", self._changed(sensor)]
        return function(f"static {self.innovation_head(sensor, 'linearise')}", lines)

    def _e_and_H(self, sensor: Sensor, at: str = "filter") -> list[str]:
        a = self.of
        e, rows, body = a.innovations(sensor), a.rows_of(sensor), Body(a.words)
        spreads = a.spreads(sensor) if a.has_spread(sensor) and at == "filter" else []
        above = [a.variances[j] * PER_SIGMA < a.watched[j] for j in range(sensor.first, sensor.first + sensor.m) if j in a.watched]
        body.name_shared([*e, *rows, *spreads, *above])
        body.assign([(f"e[{j}]", one) for j, one in enumerate(e)])
        self._written(body, f"H{sensor.suffix}", rows)
        body.assign([(f"f->R{sensor.suffix}[{k}]", one) for k, one in enumerate(spreads)])
        body.lines += [f"if ({body.text(one)}) f->filter.events |= KQ_EVENT_PRECISION;" for one in above]
        return within(self._places(at), body.lines)

    def _changed(self, sensor: Sensor) -> str:
        H = self._H(sensor)
        return f"return kq_sensor_change_measurement_{self.of.T}(&f->{field(sensor)}, {H});" if H[0] == "f" else "return KQ_OK;"

    def _innovation(self, sensor: Sensor) -> list[str]:
        a = self.of
        if sensor in a.plain:
            return []
        if not a.iterates:
            return function(self.innovation_head(sensor), [*self._e_and_H(sensor), f"return {self._spread(sensor)};" if a.has_spread(sensor) else
                                                           self._changed(sensor)])
        spread = [*self._e_and_H(sensor), *self._calls(self._spread(sensor))] if a.has_spread(sensor) else []
        copied = f"kq_filter_copy_{a.T}(&f->trial, &f->filter)"
        return function(self.innovation_head(sensor), [
            *spread, *(self._then([copied]) if spread else self._calls(copied)),
            f"return status ? status : linearise{sensor.suffix}(f{passed(self.update_arguments(sensor))}, e);"])

    def _spread(self, sensor: Sensor) -> str:
        """The sensor with R of this mean, and its H"""
        kind = "_diagonal" if self.of.is_diagonal(sensor) else ""
        return f"kq_sensor_init{kind}_extended_{self.of.T}(&f->{field(sensor)}, {self._H(sensor)}, f->R{sensor.suffix})"

    def _unit(self, sensor: Sensor) -> str:
        """Of its R, the identity in the place of what is not known yet"""
        one, none = self.of.number(1), self.of.number(0)
        return one if self.of.is_diagonal(sensor) or sensor.m == 1 else f"i % {sensor.m + 1} ? {none} : {one}"

    def innovation_head(self, sensor: Sensor, name: str = "") -> str:
        return (f"kq_status {name or f'{self.given.name}_innovation'}{sensor.suffix}({self.filter}{self.update_arguments(sensor)}, "
                f"{self.of.type} e[{sensor.m}])")

    def _taken_by(self, sensor: Sensor, call_: str, present: str) -> list[str]:
        a, name, arguments = self.of, self.given.name, self.update_arguments(sensor)
        call_ = f"{call_}_{a.T}(&f->{{}}, &f->{field(sensor)}, {'z' if sensor in a.plain else 'e'}{present})"
        if sensor in a.plain:
            return [f"return {call_.format('filter')};"]
        last = self._then([call_.format("filter"), *([f"{name}_reset(f)"] if a.has_errors else [])])
        again = [f"status = kq_filter_copy_{a.T}(&f->trial, &f->filter);",
                 *self._then([call_.format("trial"), f"linearise{sensor.suffix}(f{passed(arguments)}, e)"])]
        passes = [f"for (int pass = 1; pass < {self.given.options.iterate} && !status; pass++) {{", *indented(again), "}"]
        return [f"{a.type} e[{sensor.m}];", *self._calls(f"{name}_innovation{sensor.suffix}(f{passed(arguments)}, e)"),
                *(passes if a.iterates else []), *last, "return status;"]

    def _update_of(self, sensor: Sensor) -> list[str]:
        arguments, name = self.update_arguments(sensor), f"{self.given.name}_update{sensor.suffix}"
        lines = self._taken_by(sensor, "kq_update", "")
        if sensor.m > 1:
            lines = [f"return {name}_some(f{passed(arguments)}, UINT32_MAX);"]
        return function(f"kq_status {name}({self.filter}{arguments})", lines)

    def _update_some_of(self, sensor: Sensor) -> list[str]:
        if sensor.m == 1:
            return []
        return function(f"kq_status {self.given.name}_update{sensor.suffix}_some({self.filter}{self.update_arguments(sensor)}, "
                        "uint32_t present)", self._taken_by(sensor, "kq_update_subset", ", present"))

    def _points(self) -> list[list[str]]:
        a = self.of
        made = [self._at_point(self.increment_head(), "d", a.change)] if a.moves_points else []
        return made + [self._at_point(self.point_head(one), "e", a.innovations(one), one.first) for one in a.measures_points]

    def _at_point(self, head: str, target: str, rows: Sequence[Node], first: int = 0) -> list[str]:
        """Of x, with what else is read in the row"""
        a, body = self.of, Body(self.of.words)
        body.assign([(f"{target}[{k}]", one) for k, one in enumerate(rows)])
        places = [(a.type, f"x{i}", f"x[{i}]") for i in range(a.n)] + [(a.type, one, f"row->{one}") for one in ("t", "dt")]
        places += [(a.type, f"u{k}", f"row->u[{k}]") for k in range(self.given.of.l)]
        places += [(a.type, f"z{first + j}", f"row->z[{j}]") for j in range(len(rows))]
        lines = within(places, body.lines)
        row = [f"const {self.given.name}_row *row = context;"] if any("row->" in one for one in lines) else []
        return function(head, [*row, *lines])

    def increment_head(self) -> str:
        return f"void {self.given.name}_point_increment(void *context, const {self.of.type} *x, {self.of.type} *d)"

    def point_head(self, sensor: Sensor) -> str:
        return f"void {self.given.name}_point_innovation{sensor.suffix}(void *context, const {self.of.type} *x, {self.of.type} *e)"


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
            lines += [f"    {tape}STEPS);", f"    KQ_JACOBIANS_{T.upper()}(jacobians, tape, {n}, STEPS, {'STEPS' if a.Q else 1});",
                      f"    kq_attach_{T}({self.name}_filter(&f), &jacobians.attached);"]
        if a.has_errors:
            lines += ["", "A smoothed mean is the error of what f.x was when the next predict began: keep f.x of each step.",
                      f"In another device g, with g.x as it was and kq_filter_copy of the view, {self.name}_reset(&g) makes",
                      "the whole of it."]
        one = a.sensors[0]
        z = "z" if one in a.plain else "e"
        lines += ["", "A robust update (kalmanq/robust.h):", ""]
        lines += [] if z == "z" else [f"    {self.name}_innovation{one.suffix}(&f{passed(self.c.update_arguments(one))}, e);"]
        lines += [f"    kq_update_robust_{T}({self.name}_filter(&f), &f.{field(one)}, {z}, UINT32_MAX, &loss);"]
        return [*lines, *([f"    {self.name}_reset(&f);"] if a.has_errors else []), *self._usage_of_points()]

    def _usage_of_points(self) -> list[str]:
        T, n, a = self.a.T, self.a.n, self.a
        called = [("predict", "process", "increment")] if a.moves_points else []
        called += [("update", field(one), f"innovation{one.suffix}") for one in a.measures_points]
        if not called:
            return []
        row = "&row" if a.row_fields() else "NULL"
        noises = "; a KQ_JACOBIANS has STEPS noises then" if a.moves_points else ""
        work = f"{a.type} work[KQ_SIGMA_POINTS_LEN({n}, {a.given.of.m})]"
        lines = ["", f"Sigma points (kalmanq/sigma_points.h), with {work}{noises}:", ""]
        if a.row_fields():
            lines.append(f"    {self.name}_row row = {{{', '.join(name for _, name in a.row_fields())}}};")
        for call, of, function_ in called:
            lines += [f"    kq_{call}_sigma_points_{T}({self.name}_filter(&f), &f.{of}, {self.name}_point_{function_}, {row},",
                      "        KQ_SIGMA_POINTS_CUBATURE, work);"]
        return lines

    def _events(self) -> list[str]:
        return []

    def _fields(self) -> list[str]:
        return ["typedef struct {", *(f"    {line}" for line in self.a.fields), f"}} {self.given.type};", ""]

    def _calls(self) -> list[str]:
        lines = ["/** Before the first sample.  Detaches what was attached. */", f"kq_status {self.name}_start({self.filter});", "",
                 "/** The same from a mean and a sigma of each state that you give. */", self._head(self.c.start_at_head()), ""]
        lines += ["/** To the next instant. */", f"kq_status {self.name}_predict({self.filter}{self.c.predict_arguments()});", ""]
        if self.a.has_errors:
            lines += ["/** The errors go into f->x, and are 0 then.  An update has done it. */",
                      f"kq_status {self.name}_reset({self.filter});", ""]
        for one in self.a.sensors:
            arguments = self.c.update_arguments(one)
            lines += ["/** Takes a sample. */", f"kq_status {self.name}_update{one.suffix}({self.filter}{arguments});", ""]
            if one.m > 1:
                lines += ["/** Takes the components of a sample whose bits are set in `present`. */",
                          f"kq_status {self.name}_update{one.suffix}_some({self.filter}{arguments}, uint32_t present);", ""]
            if one not in self.a.plain:
                lines += ["/** Innovations e of a sample at the mean; the sensor's H becomes the derivative there. */",
                          self._head(self.c.innovation_head(one)), ""]
        return lines + self._points()

    @staticmethod
    def _head(head: str) -> str:
        return f"{head.replace('restrict ', '')};"

    def _points(self) -> list[str]:
        a, lines = self.a, []
        if a.row_fields():
            lines += ["/** What the functions for sigma points read of a row beside the state. */", "typedef struct {",
                      *(f"    {one};" for one, _ in a.row_fields()), f"}} {self.name}_row;", ""]
        if a.moves_points:
            lines += ["/** f(x) - x at a sigma point.  context: a row. */", self._head(self.c.increment_head()), ""]
        for one in a.measures_points:
            lines += ["/** z - h(x) at a sigma point.  context: a row. */", self._head(self.c.point_head(one)), ""]
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
