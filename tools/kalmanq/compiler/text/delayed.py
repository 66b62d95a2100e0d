"""NAME_delayed: a filter that takes what was measured some steps ago, as if it had come in time.

The last steps are kept, with what moved the state and what was measured in each, and the filter as it was before them.  What
is late goes into its step, and all steps are worked out again from there.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Mapping, Optional, Sequence

from kalmanq.compiler.templates.engine import rendered_c
from kalmanq.compiler.text.emit import Text, named, passed
from kalmanq.errors import KalmanqError
from kalmanq.firmware.steps_kept import latest_of, steps_late


@dataclass(frozen=True)
class Late:
    """A sensor's components first, first + 1, ..., and how many steps late they are; 0: in time"""

    name: str
    first: int
    size: int
    steps: int

    @property
    def bits(self) -> int:
        return ((1 << self.size) - 1) << self.first

    @property
    def said(self) -> str:
        return f"{self.steps} steps late" if self.steps else "in time"


class Delayed:
    """What its templates are given.  arguments: of a predict, after the filter; kept: steps"""

    answers = False  # does a predict refuse steps?
    by_sensor = False  # has the filter an update of each sensor, and none of all?
    has_clock = False  # of a test: do its rows have times?

    def __init__(self, text: Text, arguments: str, kept: int, sensors: Sequence[Late]):
        self.text, self.given, self.a, self.name = text, text.given, text.a, text.given.name
        self.type, self.arguments, self.kept, self.sensors = f"{text.given.name}_delayed", arguments, kept, sensors

    def code(self) -> str:
        """The end of NAME.c"""
        return rendered_c("delayed.c.j2", {**self.text.names(), "late": self.names()}, str)

    def names(self) -> dict[str, Any]:
        """For NAME.h and NAME.c"""
        fields, again = self.fields(), self.text.predict_arguments()
        return {"kept": self.kept, "answers": self.answers, "by_sensor": self.by_sensor, "bit": 1 << self.given.of.m, "arguments": self.arguments,
                "fields": f"{fields}, " if fields else "", "passed": passed(self.arguments), "passed_on": passed(again),
                "passed_again": passed(again, "d->steps[k]."), "reads": kept_fields(self.arguments, {}), "sensors": self.names_of_sensors()}

    def names_of_sensors(self) -> list[dict[str, Any]]:
        raise NotImplementedError

    def fields(self) -> str:
        """What a step keeps beside z and present"""
        return ", ".join(f"{name}[{size}]" if size else name for name, size in named(self.arguments))

    def ram(self, filter_: int, align: int) -> int:
        """Bytes of NAME_delayed, with filters of so many"""
        word = 8 if self.a.type == "double" else 4
        numbers = sum(int(size or 1) for _, size in named(self.fields()))
        step = -(-(word * (numbers + self.given.of.m) + 4) // word) * word
        return -(-(2 * filter_ + self.kept * step + 4) // align) * align

    # ---- for a test

    def in_time(self) -> list[str]:
        """Lines: row t on in_time"""
        raise NotImplementedError

    def in_time_predict(self) -> list[str]:
        """The same of a predict alone"""
        raise NotImplementedError

    def late_predict(self, row: str) -> str:
        raise NotImplementedError

    def late_row(self, which: Late, row: str, ago: str) -> str:
        """The call that gives a sensor's part of a row to d"""
        raise NotImplementedError


def kept_fields(arguments: str, names: Mapping[str, str]) -> list[dict[str, str]]:
    """Arguments that a step keeps; names: of their fields where they are others"""
    return [{"name": name, "size": size, "kept": names.get(name, name)} for name, size in named(arguments) if name in names or not names]


# ------------------------------------------------------------------------------ constant matrices


def delayed(text: Text) -> Optional[Delayed]:
    """Of a model with delays"""
    given = text.given
    if not latest_of(given.model):
        return None
    if given.options.lag:
        raise KalmanqError("--lag: and a sensor with a delay: the means that --lag keeps would not know of what comes late: leave --lag out")
    if given.options.tunable and given.model.continuous is None:
        raise KalmanqError("--tunable: and a sensor with a delay: fields that a program changes are not kept with the steps: leave "
                           "--tunable out, or write the model with F, Qc and dt, whose dt is kept with each step")
    return LinearDelayed(text)


class LinearDelayed(Delayed):
    def __init__(self, text: Text):
        given, a = text.given, text.a
        self.answers = given.options.tunable
        late = zip(given.sensors, steps_late(given.model, self.answers))
        super().__init__(text, text.u + (f", {a.type} dt" if self.answers else ""), latest_of(given.model) + 1,
                         [Late(*sensor, steps) for sensor, steps in late])

    def names_of_sensors(self) -> list[dict[str, Any]]:
        zero, m = self.a.zero, self.given.of.m
        return [{"name": one.name, "suffix": f"_{one.name}", "first": one.first, "bits": one.bits, "steps": one.steps, "said": one.said,
                 "arguments": f", const {self.a.type} z[{one.size}]", "passed": f", {one.name}",
                 "cells": ", ".join(f"z[{k - one.first}]" if one.bits >> k & 1 else zero for k in range(m))} for one in self.sensors]

    def in_time(self) -> list[str]:
        z, all_ = "rows[t].z", f"{self.given.all}u"
        update = f"{self.name}_update_some(&in_time, {z}, {all_})" if self.given.of.m > 1 else f"{self.name}_update(&in_time, {z})"
        return [*(f"if (t) {one}" for one in self.in_time_predict()), f"(void){update};"]

    def in_time_predict(self) -> list[str]:
        move = [f"(void){self.name}_move(&in_time{self._dt()});"] if self.answers else []
        return [*move, f"{self.name}_predict(&in_time{', rows[t].u' if self.given.inputs else ''});"]

    def _dt(self) -> str:
        return f", {self.a.literal(self.given.model.continuous.dt)}" if self.answers else ""

    def late_predict(self, row: str) -> str:
        return f"{'(void)' if self.answers else ''}{self.name}_delayed_predict(&d{f', rows[{row}].u' if self.given.inputs else ''}{self._dt()});"

    def late_row(self, which: Late, row: str, ago: str) -> str:
        return f"(void){self.name}_delayed_update(&d, rows[{row}].z, {which.bits}u, {ago});"
