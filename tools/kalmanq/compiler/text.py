"""NAME.c of a filter: start, predict, update, step."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Sequence

import numpy as np

from kalmanq.compiler.forms import Entries, Mean, update_by_gain
from kalmanq.compiler.lines import Line, Lines, indented
from kalmanq.compiler.header import comment
from kalmanq.compiler.plan import Plan, bookkeeping
from kalmanq.compiler.routines import routines
from kalmanq.compiler.sums import Sum

WIDTH = 110


@dataclass
class Body:
    """A function that takes the filter from its fields and puts back what has changed."""

    plan: Plan
    function: str
    carries: bool = True  # the covariance
    lines: Lines = field(default_factory=Lines)
    x: Mean = field(default_factory=list)
    P: Entries = field(default_factory=dict)

    def __post_init__(self) -> None:
        plan, s = self.plan, self.plan.subject
        self.lines.taken |= {"f", "z", "u", "present"}
        s.words.begin(self.lines)
        for i in range(s.of.n):
            self.x.append([self.lines.load(name, type_, f"f->{name}", None) for name, type_ in s.mean.fields(i)])
        names = {key: plan.field(key) for key in plan.structure.carried} if self.carries else {}
        for key, name in names.items():
            self.lines.load(name, s.words.type, f"f->{name}", plan.form.word(s, key))
        self.P = plan.structure.entries(names) if self.carries else {}
        self.before = [list(words) for words in self.x], dict(self.P)

    def predict(self) -> None:
        self._predict_covariance()
        self.predict_mean()

    def _predict_covariance(self) -> None:
        self.P = self.plan.form.predict(self.plan.subject, self.lines, self.P)

    def predict_mean(self) -> None:
        s = self.plan.subject
        self.x = s.mean.predict(self.lines, self.x, [Sum.named(f"u[{k}]") for k in range(s.of.l)])

    def update(self, j: int, z: Sum) -> None:
        self.x, self.P = self.plan.form.update(self.plan.subject, self.lines, self.x, self.P, j, z, lambda *_: None)

    def update_by_gain(self) -> None:
        s = self.plan.subject
        z = [Sum.named(f"z[{j}]") for j in range(s.of.m)]
        self.x, _ = update_by_gain(s, self.lines, self.x, z, self.plan.settled.gain)

    def text(self) -> list[str]:
        """Of its lines and of what is stored."""
        plan, s = self.plan, self.plan.subject
        x, P = self.before
        for i in range(s.of.n):
            for (name, _), new, old in zip(s.mean.fields(i), self.x[i], x[i]):
                if new.key() != old.key():
                    self.lines.do(f"f->{name} = {s.words.store(new)};")
        for key in plan.structure.carried if self.carries else ():
            if self.P[key].key() != P[key].key():
                self.lines.do(f"f->{plan.field(key)} = {s.words.store(self.P[key], plan.form.word(s, key))};")
        return [one for line in self.lines.living() for one in self._written(line)]

    def _written(self, line: Line) -> list[str]:
        place = f"{self.function} {line.name}"
        if self.plan.probes and line.type == "int32_t" and line.note:
            return [line.code(), f"probe(@{place}@, {line.text.replace('(int32_t)', '')});"]
        notes = [note for note in (line.note, self.plan.ranges.get(place, "")) if note]
        if not notes:
            return [line.code()]
        remark = f"/* {', '.join(notes)} */"
        return [f"{line.code()} {remark}"] if len(line.code()) + len(remark) < WIDTH else [remark, line.code()]


PROBE = re.compile("@([^@]*)@")


def probes_of(plan: Plan) -> list[str]:
    """Function and name of each line whose value is told, in order"""
    return list(dict.fromkeys(PROBE.findall(_functions(plan)))) if plan.probes else []


def _numbered(text: str) -> str:
    places = {place: k for k, place in enumerate(dict.fromkeys(PROBE.findall(text)))}
    return PROBE.sub(lambda found: str(places[found.group(1)]), text)


# ------------------------------------------------------------------------------ functions


def function(head: str, body: Sequence[str], remark: str = "") -> list[str]:
    return [*([f"/* {remark} */"] if remark else []), head, "{", *indented(body), "}", ""]


def start(plan: Plan) -> list[str]:
    s = plan.subject
    lines = [f"f->{name} = {value};" for i in range(s.of.n)
             for (name, _), value in zip(s.mean.fields(i), s.mean.start(i))]
    lines += covariance_of(plan, s.of.P0) + [f"f->{name} = 0;" for _, name in bookkeeping(plan)]
    return function(f"void {plan.name}_start({plan.type} *restrict f)", lines)


def predict(plan: Plan) -> list[str]:
    body = Body(plan, "predict")
    body.predict()
    head = ["const uint32_t rows = f->rows << 16;", "if (rows == 0) { /* no sample since the last predict */",
            *indented(gap(plan)), "}", "f->rows = rows;"]
    return function(f"void {plan.name}_predict({plan.type} *restrict f{plan.controls})", [*head, *body.text()])


def gap(plan: Plan) -> list[str]:
    refuse = ["{", "    f->gap_refused = 1;", "    return;", "}"]
    if not plan.max_gap:
        return refuse[1:3]
    return ["const uint32_t run = f->rows >> 16; /* samples before a gap that begins here */",
            f"if (run ? f->missed && run < {plan.min_run} : f->missed == {plan.max_gap}) {refuse[0]}", *refuse[1:],
            "f->missed = (uint8_t)(run ? 1 : f->missed + 1);"]


def update(plan: Plan) -> list[str]:
    body = Body(plan, "update")
    for j in range(plan.subject.of.m):
        body.lines.title(plan.subject.measurements[j])
        body.update(j, Sum.named(f"z[{j}]"))
    fast = Body(plan, "settled", carries=False)
    fast.update_by_gain()
    N = plan.rows
    lines = [*door(plan, ["return;"]), "const uint32_t rows = f->rows >> 16;", f"if (rows >= {N - 1}) {{ /* settled */",
             *indented([*fast.text(), f"f->rows = {N};", *covariance_of(plan, plan.settled.filtered), "return;"]), "}",
             "f->rows = rows + 1;", *body.text()]
    return function(f"void {plan.name}_update({plan.type} *restrict f, {plan.sample})", lines)


def step(plan: Plan) -> list[str]:
    name = plan.name
    given = ", u" if plan.subject.of.l else ""
    fast = Body(plan, "step", carries=False)
    fast.predict_mean()
    fast.update_by_gain()
    lines = door(plan, [f"{name}_predict(f{given});", "return;"])
    lines += [f"if (f->rows != {plan.rows}) {{", f"    {name}_predict(f{given});", f"    {name}_update(f, z);",
              "    return;", "}", *fast.text()]
    return function(f"void {plan.name}_step({plan.type} *restrict f{plan.controls}, {plan.sample})", lines)


def covariance_of(plan: Plan, P: np.ndarray) -> list[str]:
    s = plan.subject
    values = plan.form.values(P)
    return [f"f->{plan.field(key)} = {s.words.constant(values[key], plan.form.word(s, key))};"
            for key in plan.structure.carried]


def door(plan: Plan, refused: Sequence[str]) -> list[str]:
    """What is outside the declared range, or no number, is refused."""
    outside = [plan.subject.words.is_outside(f"z[{j}]", limit) for j, limit in enumerate(plan.doors) if limit]
    if not outside:
        return []
    return [f"if ({' || '.join(outside)}) {{", *indented(["f->sample_refused = 1;", *refused]), "}"]


def _functions(plan: Plan) -> str:
    return "\n".join(line for part in (start, predict, update, step) for line in part(plan))


def code(plan: Plan) -> str:
    body = _numbered(_functions(plan))
    called = routines(body)
    includes = (["#include <limits.h>"] if "UINT_MAX" in called else []) + \
        (["#include <math.h>"] if plan.needs_math else [])
    return "\n".join([*comment(plan, plan.remarks), f'#include "{plan.name}.h"', "", *includes, *([""] if includes else []), called + body])
