"""NAME.c of a filter: what its template (templates/filter.c.j2) is given, and lines that more than one template is given."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any, Iterable, Sequence

from kalmanq.compiler.algorithm import lag
from kalmanq.compiler.algorithm.arithmetic import Arithmetic
from kalmanq.compiler.given.request import LONGEST_GAP, Request
from kalmanq.compiler.templates.engine import rendered_c
from kalmanq.formulas.printing import indented

PREDICTS, UPDATES = 1, 2  # of a row
FIRST = re.compile(r"(?:const )?\w+ ([xzu])(\d+) = .*;$|f->x\[(\d+)\] = [^;]*;$")


@dataclass(frozen=True)
class Row:
    """What a row of a record is called in C.  what: PREDICTS and UPDATES; present: bits; u: controls of the step to the row;
    now: of the row itself; left: t of the row before, step: the time between them; t: of the row; taken: gets bits"""

    what: str
    present: str
    z: str
    u: str
    now: str
    left: str
    step: str
    t: str
    taken: str


class Text:
    """template: of NAME.c; header: of NAME.h; counter: the field that is counted beside `calls`, if there are any"""

    template, header, counter = "filter.c.j2", "filter.h.j2", "gap"

    def __init__(self, a: Arithmetic):
        self.given, self.a = a.given, a
        self.u = f", const {a.type} u[{self.given.inputs}]" if self.given.inputs else ""
        self.settles = a.steady is not None

    def code(self, remarks: Sequence[str]) -> str:
        return rendered_c(self.template, {**self.names(), **self.bodies(), "remarks": remarks}, self.a.routines)

    # ---- for the templates

    def names(self) -> dict[str, Any]:
        """What NAME.c and NAME.h have in common"""
        given, a, options, before = self.given, self.a, self.given.options, self.predict_arguments()
        return {"name": given.name, "type": given.type, "upper": given.upper, "T": a.type, "zero": a.zero, "arithmetic": options.arithmetic,
                "n": given.of.n, "m": given.of.m, "all": given.all, "inputs": given.inputs, "carried": given.carried, "states": given.states,
                "nominal": given.nominal, "predict": {"arguments": before, "passed": passed(before)}, "counter": self.counter, "slots": a.slots,
                "nis": options.nis, "gate": options.gate is not None, "lag": options.lag, "smooth": None, "covariance_type": a.covariance_type,
                "sensors": self.names_of_sensors(), "parts": self._parts(), "uses_math": "#include <math.h>" in a.code_includes, **a.tunable()}

    def names_of_sensors(self) -> list[dict[str, Any]]:
        """What has an update of its own"""
        m = self.given.of.m
        return [{"suffix": "", "m": m, "all": self.given.all, "arguments": f", const {self.a.type} z[{m}]", "passed": ", z"}]

    def bodies(self) -> dict[str, Any]:
        """Lines of NAME.c, by the places where they come"""
        given, a = self.given, self.a
        sensor = {**self.names_of_sensors()[0], "controls": [], "measured": self.measured(), "lines": self._taken(), "accepted": self._accepted(),
                  "accepts": a.accepts_all(), "groups": self.groups(given.together)}
        return {**self.shared(), **self._steady(), "sensors": [sensor],
                "predict_mean": commented(within(a.places(factor=False), block(a.predict_mean())), given),
                "predict_factor": within([] if a.predicts_at_once else a.places(mean=False), block(a.predict_factor()))}

    def _taken(self) -> list[str]:
        """The components whose bits are set"""
        given, body = self.given, []
        for j in range(given.of.m):
            head = f"if ((taken & {1 << j}u) != 0u) {{" if given.of.m > 1 else "{"
            body += [f"{head} /* {given.measurements[j]} */", *indented(self.a.update(j)), "}"]
        return within([] if self.a.updates_at_once else self.a.places(), [*body, *self.a.finer_lines()])

    def shared(self) -> dict[str, Any]:
        """Of filters of all models"""
        a = self.a
        return {"settles": self.settles, "cycle": None, "code_includes": a.code_includes, "entries": max(len(a.live), 1),
                "start": commented(a.start(), self.given), "start_at": a.start_at(), "started_at": a.started_at(),
                "looks_at_controls": bool(self.given.inputs), "has_ends": self.has_ends, "hold": a.hold(), "controls": self.controls(), "within_numbers": a.within_numbers(),
                "factor": self._factor() if self.settles else "f->P", "covariance": a.covariance()}

    def _steady(self) -> dict[str, Any]:
        a = self.a
        if a.steady is None:
            return {}
        rests = [2 * (a.steady.samples - rest) + 1 for rest in a.steady.after_gap[:LONGEST_GAP]]
        updated, predicted = (", ".join(a.factor_literals(P)) or "0" for P in (a.steady.filtered, a.steady.predicted))
        return {"steady": {"first_low": a.first_low(), "samples": a.steady.samples, "updated": updated, "predicted": predicted, "rests": rests,
                           "rest_type": "uint16_t" if max(rests) < 1 << 16 else "uint32_t"},
                "settled_update": self._settled(False), "settled_step": self._settled(True), **lag.bodies(self.given, a, a.steady)}

    def _factor(self) -> str:
        return "f->calls >= SETTLED ? steady[f->calls & 1u] : f->P"

    def controls(self) -> list[str]:
        ends = [", ".join(self.a.ends_of_control(k)[not self.has_ends:]) for k in range(self.given.inputs)]
        given = [f"control(f, u[{k}], {one})" for k, one in enumerate(ends)]
        given += [self.a.one for _ in range(self.given.of.l - len(given))]
        return commented([f"const {self.a.type} u{k} = {one};" for k, one in enumerate(given)], self.given)

    @property
    def has_ends(self) -> bool:
        """Has a control a least value of its own?"""
        return any(one.ends for one in self.given.model.controls[:self.given.inputs])

    def predict_arguments(self) -> str:
        return self.u

    def _accepted(self) -> str:
        return " | ".join(f"({self.a.accepts(j)} ? {1 << j}u : 0u)" for j in range(self.given.of.m))

    @staticmethod
    def groups(together: Iterable[int]) -> list[int]:
        """Components with correlated noises are taken together."""
        return sorted({group for group in together if group & (group - 1)})

    def measured(self) -> list[str]:
        return commented([f"const {self.a.type} z{j} = {self.a.mixed(j)};" for j in range(self.given.of.m)], self.given)

    def _settled(self, predicts: bool) -> list[str]:
        """Of a full sample, once settled; it returns."""
        gates = range(self.given.of.m) if self.given.options.gate is not None else ()
        counted = [] if predicts else ["f->calls = SETTLED;"]
        ends = [*(f"f->rejected[{j}] = 0;" for j in gates), *counted, f"return {self.given.all}u;"]
        mark = "/* store */"
        body = self.a.settled(predicts, [mark, *ends])
        return [*self.measured(), *commented(within(self.a.places(factor=False), body, mark), self.given)]

    def _parts(self) -> list[dict[str, Any]]:
        m, zero = self.given.of.m, self.a.zero
        return [{"name": name, "size": size, "first": first, "bits": ((1 << size) - 1) << first,
                 "cells": ", ".join(f"z[{k - first}]" if first <= k < first + size else zero for k in range(m))}
                for name, first, size in self.given.sensors]

    # ---- for programs that run a record

    def row(self, of: Row) -> list[str]:
        """The calls of a row"""
        name, m = self.given.name, self.given.of.m
        u = f", {of.u}" if self.given.inputs else ""
        whole = f"{name}_update(&f, {of.z})"
        some = f"{of.present} == {self.given.all} ? {whole} : {name}_update_some(&f, {of.z}, {of.present})" if m > 1 else whole
        return [f"if ({of.what} == {PREDICTS | UPDATES} && {of.present} == {self.given.all}) {of.taken} = {name}_step(&f{u}, {of.z});",
                "else {", f"    if ({of.what} & {PREDICTS}) {name}_predict(&f{u});",
                f"    if ({of.what} & {UPDATES}) {of.taken} = {some};", "}"]


def passed(arguments: str, of: str = "") -> str:
    """Arguments of a function as they are passed on; of: where they are"""
    return "".join(f", {of}{name}" for name, _ in named(arguments))


def named(arguments: str) -> list[tuple[str, str]]:
    """Names, and lengths of arrays"""
    return re.findall(r"(\w+)(?:\[(\d+)\])?(?=,|$)", arguments)


def within(places: Sequence[tuple[str, str, str]], body: Sequence[str], mark: str = "") -> list[str]:
    """The body between loads of what it reads and stores of what it writes; mark: the line of the body that becomes the
    stores"""
    text = "\n".join(body)
    loads = [f"{'' if _writes(text, local) else 'const '}{type_} {local} = {field};" for type_, local, field in places
             if re.search(rf"\b{local}\b", text)]
    stores = [f"{field} = {local};" for _, local, field in places if _writes(text, local)]
    if not mark:
        return [*loads, *body, *stores]
    at = next(k for k, line in enumerate(body) if line.strip() == mark)
    room = body[at][:len(body[at]) - len(mark)]
    return [*loads, *body[:at], *(room + one for one in stores), *body[at + 1:]]


def _writes(text: str, local: str) -> bool:
    return re.search(rf"^\s*{local} [-+]?= ", text, re.M) is not None


def commented(lines: Sequence[str], given: Request) -> list[str]:
    """With the names of quantities where x<i>, z<j>, u<k> and the mean get their first values"""
    names = {"x": given.carried, "z": given.measurements, "u": given.controls}
    made = []
    for line in lines:
        found = FIRST.match(line)
        of, k = (found[1] or "x", int(found[2] or found[3])) if found else ("", 0)
        made.append(f"{line} /* {names[of][k]} */" if found and k < len(names[of]) else line)
    return made


def block(lines: Sequence[str]) -> list[str]:
    return ["{", *indented(lines), "}"]
