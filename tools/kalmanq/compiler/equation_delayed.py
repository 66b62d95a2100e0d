"""NAME_delayed of a nonlinear model: each step keeps what its functions are of, too."""

from __future__ import annotations

from typing import Optional

from kalmanq.compiler.delayed import Delayed, Late
from kalmanq.compiler.emit import Row, function, named, passed
from kalmanq.compiler.equation_text import EquationText
from kalmanq.compiler.equations import EquationFilter, Sensor
from kalmanq.errors import KalmanqError
from kalmanq.firmware.steps_kept import kept_for
from kalmanq.nonlinear import NonlinearModel

KEPT = {"u": "now", "t": "at"}  # of an update, beside what a predict is of


def delayed_equations(a: EquationFilter, text: EquationText, model: NonlinearModel) -> Optional[Delayed]:
    """Of a model with delays"""
    if not model.is_late:
        return None
    if text.given.options.smooth:
        raise KalmanqError("--smooth: and a sensor with a delay: the history would not know of what comes late")
    step = model.dt if model.reads_times else 1.0
    if step is None:
        raise KalmanqError("delays: are in seconds, as functions take t: give dt, and let a function take it, so that they are steps")
    sensors = [Late(one.name, one.first, one.m, round(one.delay / step)) for one in model.sensors]
    return EquationDelayed(a, text, kept_for(max(one.delay for one in model.sensors) / step) + 1, sensors)


class EquationDelayed(Delayed):
    def __init__(self, a: EquationFilter, text: EquationText, kept: int, sensors: list[Late]):
        super().__init__(text.given, a, text.predict_arguments(), kept, sensors)
        self.text, self.pairs = text, list(zip(a.sensors, sensors))

    def fields(self) -> str:
        l = self.given.of.l
        reads = [any(self.text.of.updates_by(one, which) for one, _ in self.pairs) for which in KEPT]
        return ", ".join(filter(None, [super().fields(), f"now[{l}]" if reads[0] else "", "at" if reads[1] else ""]))

    def _of_row(self, sensor: Sensor) -> str:
        """The arguments of an update after z, from step k"""
        return "".join(f", d->steps[k].{KEPT[name]}" for name, _ in named(self.text.update_arguments(sensor)) if name in KEPT)

    def again(self) -> list[str]:
        lines = [f"if (d->steps[k].present & {self._bit()}) {self.name}_predict(f{passed(self.arguments, 'd->steps[k].')});", "unsigned taken = 0;"]
        for sensor, one in self.pairs:
            here = f"present >> {one.first} & {sensor.all}u" if one.first else f"present & {sensor.all}u"
            z = f"d->steps[k].z + {one.first}" if one.first else "d->steps[k].z"
            some = f"_some(f, {z}{self._of_row(sensor)}, {here})" if sensor.m > 1 else f"(f, {z}{self._of_row(sensor)})"
            lines.append(f"if ({here}) taken |= {self.name}_update{sensor.suffix}{some}{f' << {one.first}' if one.first else ''};")
        return lines

    def usage_of_updates(self) -> list[tuple[str, str]]:
        return [(f"{self.name}_delayed_update{sensor.suffix}(&d{passed(self.text.update_arguments(sensor))}{one.ago});", one.said)
                for sensor, one in self.pairs]

    def _declared_update(self, sensor: Sensor, one: Late) -> str:
        return f"unsigned {self.name}_delayed_update{sensor.suffix}({self.type} *d{self.text.update_arguments(sensor)}" \
               f"{', unsigned ago' if one.steps else ''})"

    def update_calls(self) -> list[str]:
        lines = [f"/** Take what a sensor has measured, a late one's `ago` steps before now, 0 to {self.kept - 1}.  d->now is then what it",
                 f" *  would be if all had come in time.  Costs an update, and {self.kept} steps where `ago` is not 0.  One sample of a sensor",
                 " *  in a step.  u and t are of the row that it was measured in.  Return the bits of what they took. */"]
        return [*lines, *(f"{self._declared_update(*pair)};" for pair in self.pairs), ""]

    def update_functions(self) -> list[str]:
        return [line for pair in self.pairs for line in self._update(*pair)]

    def _update(self, sensor: Sensor, one: Late) -> list[str]:
        arguments, ago = self.text.update_arguments(sensor), "ago" if one.steps else "0"
        keeps = [line for name, size in named(arguments) if name in KEPT for line in (
            [f"for (unsigned i = 0; i < {size}u; i++) d->steps[k].{KEPT[name]}[i] = {name}[i];"] if size else
            [f"d->steps[k].{KEPT[name]} = {name};"])]
        at = f"{one.first}u + j" if one.first else "j"
        now = f"{self.name}_update{sensor.suffix}(&d->now{passed(arguments)})"
        then = f"(replay_all(d, k) >> {one.first}) & {sensor.all}u" if one.first else f"replay_all(d, k) & {sensor.all}u"
        return function(self._declared_update(sensor, one), [
            f"const unsigned k = place(d, {one.bits}u, {ago});", f"if (k == {self.kept}u) return 0;",
            f"for (unsigned j = 0; j < {sensor.m}u; j++) d->steps[k].z[{at}] = z[j];", *keeps,
            f"d->steps[k].present |= {one.bits}u;", f"return ago ? {then} : {now};" if one.steps else f"return {now};"])

    # ---- of a test

    def in_time_predict(self) -> list[str]:
        return self._in_time("1")

    def in_time(self) -> list[str]:
        return self._in_time("(t ? 3 : 2)")

    def _in_time(self, what: str) -> list[str]:
        row = Row(what, f"{self.given.all}u", "rows[t].z", "rows[t].u", "rows[t].now", *self._clock("t"), "taken")
        return ["unsigned taken = 0;", *(line.replace("(&f", "(&in_time") for line in self.text.row(row)), "(void)taken;"]

    def _clock(self, row: str) -> list[str]:
        """t before, the step, t"""
        return [f"rows[{row}].clock[{k}]" for k in range(3)] if self.has_clock else [f"({row} - 1)", "", row]

    def late_predict(self, row: str) -> str:
        before, step, _ = self._clock(row)
        values = {"u": f"rows[{row}].u", "t": f"({self.a.type})({before})", "dt": f"({self.a.type})({step})"}
        return f"{self.name}_delayed_predict(&d{self.text.with_values(self.arguments, values)});"

    def late_row(self, which: Late, row: str, ago: str) -> str:
        sensor = next(sensor for sensor, one in self.pairs if one is which)
        z = f"rows[{row}].z + {which.first}" if which.first else f"rows[{row}].z"
        values = {"z": z, "u": f"rows[{row}].now", "t": f"({self.a.type})({self._clock(row)[2]})"}
        arguments = self.text.with_values(self.text.update_arguments(sensor), values)
        return f"(void){self.name}_delayed_update{sensor.suffix}(&d{arguments}{f', {ago}' if which.steps else ''});"
