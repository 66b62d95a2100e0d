"""NAME_delayed of a nonlinear model: each step keeps what its functions are of, too."""

from __future__ import annotations

from typing import Any, Optional

from kalmanq.compiler.text.delayed import Delayed, Late, kept_fields
from kalmanq.compiler.text.emit import Row
from kalmanq.compiler.text.equation_text import EquationText
from kalmanq.errors import KalmanqError
from kalmanq.firmware.steps_kept import kept_for
from kalmanq.nonlinear import NonlinearModel

KEPT = {"u": "now", "t": "at"}  # of an update, beside what a predict is of


def delayed_equations(text: EquationText, model: NonlinearModel) -> Optional[Delayed]:
    """Of a model with delays"""
    if not model.is_late:
        return None
    if text.given.options.smooth:
        raise KalmanqError("--smooth: and a sensor with a delay: the history would not know of what comes late: leave --smooth out")
    step = model.dt if model.reads_times else 1.0
    if step is None:
        raise KalmanqError("delays: are in seconds, as functions take t: give dt, and let a function take it, so that they are steps")
    sensors = [Late(one.name, one.first, one.m, round(one.delay / step)) for one in model.sensors]
    return EquationDelayed(text, kept_for(max(one.delay for one in model.sensors) / step) + 1, sensors)


class EquationDelayed(Delayed):
    by_sensor = True
    text: EquationText

    def __init__(self, text: EquationText, kept: int, sensors: list[Late]):
        super().__init__(text, text.predict_arguments(), kept, sensors)
        self.pairs = list(zip(text.of.sensors, sensors))

    def fields(self) -> str:
        l = self.given.of.l
        reads = [any(self.text.of.updates_by(one, which) for one, _ in self.pairs) for which in KEPT]
        return ", ".join(filter(None, [super().fields(), f"now[{l}]" if reads[0] else "", "at" if reads[1] else ""]))

    def names_of_sensors(self) -> list[dict[str, Any]]:
        made = []
        for names, (sensor, one) in zip(self.text.names_of_sensors(), self.pairs):
            reads = kept_fields(names["arguments"], KEPT)
            made.append({**names, "size": sensor.m, "bits": one.bits, "steps": one.steps, "said": one.said, "reads": reads,
                         "passed_again": "".join(f", d->steps[k].{field['kept']}" for field in reads)})
        return made

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
