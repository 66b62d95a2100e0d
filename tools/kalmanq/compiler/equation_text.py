"""NAME.c of a nonlinear model: start, predict, and an update of each sensor."""

from __future__ import annotations

from typing import Mapping

from kalmanq.compiler.emit import PREDICTS, UPDATES, Row, Text, function, named, passed, within
from kalmanq.compiler.equation_smoother import Smoother
from kalmanq.compiler.equations import EquationFilter, Sensor
from kalmanq.compiler.floats import entry
from kalmanq.compiler.printing import indented
from kalmanq.compiler.request import Request


class EquationText(Text):
    """u and t are arguments of the functions whose formulas have them."""

    def __init__(self, given: Request, a: EquationFilter):
        super().__init__(given, a)
        self.of = a
        self.smoother = Smoother(a, self.predict_arguments(), self._controls(), self._refusal("")) if given.options.smooth else None

    def parts(self) -> list[list[str]]:
        updates = [lines for sensor in self.of.sensors for lines in self._sensor(sensor)]
        smooths = self.smoother.functions() if self.smoother else []
        return [self._start(), self._start_at(), self._control(), self.of.hold(), self._predict(), *updates, self._covariance(), *smooths]

    # ---- arguments

    def predict_arguments(self) -> str:
        return (self.u if self.given.of.l else "") + "".join(
            self._time(self.of.predicts_by(one), one) for one in ("t", "dt"))

    def update_arguments(self, sensor: Sensor) -> str:
        return f", const {self.a.type} z[{sensor.m}]" + (self.u if self.of.updates_by(sensor, "u") else "") \
            + self._time(self.of.updates_by(sensor, "t"))

    def _time(self, is_read: bool, name: str = "t") -> str:
        return f", {self.a.type} {name}" if is_read else ""

    def row(self, of: Row) -> list[str]:
        name, lines = self.given.name, []
        before = self.with_values(self.predict_arguments(), {
            "u": of.u, "t": f"({self.a.type})({of.left})", "dt": f"({self.a.type})({of.step})"})
        predict = f"{name}_predict_recorded(&f, &history" if self.smoother else f"{name}_predict(&f"
        lines = [f"if ({of.what} & {PREDICTS}) {predict}{before});"]
        for sensor in self.of.sensors:
            z = f"{of.z} + {sensor.first}" if sensor.first else of.z
            given = self.with_values(self.update_arguments(sensor), {"z": z, "u": of.now, "t": f"({self.a.type})({of.t})"})
            present = f"({of.present} >> {sensor.first} & {sensor.all}u)"
            some = f"_some(&f{given}, {present})" if sensor.m > 1 else f"(&f{given})"
            lines.append(f"if ({of.what} & {UPDATES} && {present}) {of.taken} |= "
                         f"{name}_update{sensor.suffix}{some} << {sensor.first};")
        return lines

    @staticmethod
    def with_values(arguments: str, values: Mapping[str, str]) -> str:
        """Values of such arguments"""
        return "".join(f", {values[name]}" for name, _ in named(arguments))

    def count_fields(self) -> list[str]:
        return []

    def _reset_counts(self) -> list[str]:
        return []

    # ---- functions

    def _controls(self) -> list[str]:
        looked_at = super()._controls()
        return [line if self.of.looks_at(k) else f"const {self.a.type} u{k} = u[{k}];" for k, line in enumerate(looked_at)]

    def _control(self) -> list[str]:
        return super()._control() if any(map(self.of.looks_at, range(self.given.of.l))) else []

    def _refusal(self, answer: str) -> list[str]:
        return [f"f->events |= {self.given.upper}_NOT_FINITE;", f"return{answer};"]

    def _predict(self) -> list[str]:
        return function(f"void {self.given.name}_predict({self.filter}{self.predict_arguments()})",
                        [*self._controls(), *self.of.predict(self._refusal("")), *self.of.within_numbers()])

    def _sensor(self, sensor: Sensor) -> list[list[str]]:
        return [self._taken_of(sensor), self._update_of(sensor), self._update_some_of(sensor)]

    def _taken_of(self, sensor: Sensor) -> list[str]:
        """static: the components whose bits are set"""
        a, given, arguments = self.of, self.given, self.update_arguments(sensor)
        controls = self._controls() if a.updates_by(sensor, "u") else []
        body = [*a.linearised(sensor), *a.unless_finite(sensor, self._refusal(" 0"))]
        is_once = a.is_once(sensor)
        for j in range(sensor.first, sensor.first + sensor.m):
            head = f"if (taken & {1 << a.slot(j)}u) {{" if sensor.m > 1 else "{"
            lines = [*a.unless_rounded(j), *a.update(j, self._unless_positive(sensor, j))]
            body += [f"{head} /* {given.measurements[j]} */", *indented(lines), "}"]
        body = self._iterated(body, a.finished(sensor)) if given.options.iterate > 1 else body + a.finished(sensor)
        lines = [f"f->nis = {a.zero};"] if given.options.nis else []
        measured = [f"const {a.type} z{sensor.first + j} = z[{j}];" for j in range(sensor.m)]
        body = body if is_once and sensor in a.linear else within(a.places(factor=not is_once), body)
        return function(f"static unsigned take{sensor.suffix}({self.filter}{arguments}, unsigned taken)",
                        [*lines, "if (!taken) return 0;", *controls, *measured, *body, "return taken;"])

    def _unless_positive(self, sensor: Sensor, j: int) -> list[str]:
        """Where an innovation has no variance: what components before it have written stays"""
        if sensor.m > 1 and self.of.is_once(sensor):
            return [*self._refusal("")[:-1], f"taken &= ~{1 << self.of.slot(j)}u;"]
        return self._refusal(" 0")

    def _iterated(self, body: list[str], finished: list[str]) -> list[str]:
        """The body from the same prior, at the mean (m) and then at what came out of it (a)"""
        type_, states = self.a.type, range(self.given.of.n)
        points = [f"const {type_} m{i} = x{i} + l{i};" for i in states] + [f"{type_} a{i} = m{i};" for i in states]
        again = [f"{local} = {field};" for _, local, field in self.a.places(mean=False)]
        again += [f"f->nis = {self.a.zero};"] if self.given.options.nis else []
        last = [f"if (pass == {self.given.options.iterate - 1}) {{", *indented(finished), "}"]
        return [*points, f"for (int pass = 0; pass < {self.given.options.iterate}; pass++) {{",
                *indented([*again, *body, *last, *(f"a{i} = a{i} + c{i};" for i in states)]), "}"]

    def _whole_groups_of(self, sensor: Sensor) -> list[str]:
        groups = {group >> sensor.first for group in self.given.together[sensor.first:sensor.first + sensor.m]
                  if group & (group - 1)}
        return [f"if ((taken & {group}u) != {group}u) taken &= ~{group}u;" for group in sorted(groups)]

    def _update_of(self, sensor: Sensor) -> list[str]:
        arguments = self.update_arguments(sensor)
        return function(f"unsigned {self.given.name}_update{sensor.suffix}({self.filter}{arguments})", [
            f"{'unsigned' if self._whole_groups_of(sensor) else 'const unsigned'} taken = {self.of.accepts_of(sensor)};",
            *self._whole_groups_of(sensor), self._refused(f"{sensor.all}u"),
            f"return take{sensor.suffix}(f{passed(arguments)}, taken);"])

    def _update_some_of(self, sensor: Sensor) -> list[str]:
        if sensor.m == 1:
            return []
        arguments = self.update_arguments(sensor)
        return function(f"unsigned {self.given.name}_update{sensor.suffix}_some({self.filter}{arguments}, unsigned present)", [
            f"present &= {sensor.all}u;", f"unsigned taken = present & ({self.of.accepts_of(sensor)});",
            *self._whole_groups_of(sensor), self._refused("present"),
            f"return take{sensor.suffix}(f{passed(arguments)}, taken);"])
