"""NAME.c and NAME.h of a nonlinear model: what their templates (templates/equations.c.j2, equations.h.j2) are given."""

from __future__ import annotations

from typing import Any, Mapping

from kalmanq.compiler.algorithm.equations import EquationFilter, Sensor
from kalmanq.compiler.text.emit import PREDICTS, UPDATES, Row, Text, commented, named, passed, within
from kalmanq.compiler.text.equation_smoother import Smoother
from kalmanq.formulas.printing import indented


class EquationText(Text):
    header, counter = "equations.h.j2", ""

    def __init__(self, a: EquationFilter):
        super().__init__(a)
        self.of = a
        self.smoother = Smoother(a, self.controls(), self._refusal("")) if self.given.options.smooth else None

    def names(self) -> dict[str, Any]:
        return {**super().names(), "smooth": self.smoother.names() if self.smoother else None}

    def names_of_sensors(self) -> list[dict[str, Any]]:
        of = [(one, self.update_arguments(one)) for one in self.of.sensors]
        return [{"suffix": one.suffix, "first": one.first, "m": one.m, "all": one.all, "arguments": given, "passed": passed(given)} for one, given in of]

    def bodies(self) -> dict[str, Any]:
        sensors = [{**names, **self._sensor(one)} for names, one in zip(self.names_of_sensors(), self.of.sensors)]
        return {**self.shared(), "predict_mean": self.of.predict(self._refusal("")), "predict_factor": [], "sensors": sensors,
                "looks_at_controls": any(map(self.of.looks_at, range(self.given.of.l))), **(self.smoother.bodies() if self.smoother else {})}

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

    # ---- bodies

    def controls(self) -> list[str]:
        lines = [line if self.of.looks_at(k) else f"const {self.a.type} u{k} = u[{k}];" for k, line in enumerate(super().controls())]
        return commented(lines, self.given)

    def _refusal(self, answer: str) -> list[str]:
        return [f"f->events |= {self.given.upper}_NOT_FINITE;", f"return{answer};"]

    def _sensor(self, sensor: Sensor) -> dict[str, Any]:
        groups = self.groups(self.given.together[sensor.first:sensor.first + sensor.m])
        return {"controls": self.controls() if self.of.updates_by(sensor, "u") else [], "lines": self._taken(sensor),
                "measured": commented([f"const {self.a.type} z{sensor.first + j} = z[{j}];" for j in range(sensor.m)], self.given),
                "accepted": self.of.accepts_of(sensor), "accepts": self.of.all_within(sensor.m),
                "groups": [group >> sensor.first for group in groups]}

    def _taken(self, sensor: Sensor) -> list[str]:
        """The components whose bits are set"""
        a, given = self.of, self.given
        body = [*a.linearised(sensor), *a.unless_finite(sensor, self._refusal(" 0"))]
        is_once = a.is_once(sensor)
        for j in range(sensor.first, sensor.first + sensor.m):
            head = f"if ((taken & {1 << a.slot(j)}u) != 0u) {{" if sensor.m > 1 else "{"
            lines = [*a.unless_rounded(j), *a.update(j, self._unless_positive(sensor, j))]
            body += [f"{head} /* {given.measurements[j]} */", *indented(lines), "}"]
        body = self._iterated(body, a.finished(sensor)) if given.options.iterate > 1 else body + a.finished(sensor)
        return body if is_once and sensor in a.linear else within(a.places(factor=not is_once), body)

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
