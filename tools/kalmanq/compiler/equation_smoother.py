"""kalmanq compile MODEL.py --smooth STEPS: a history of steps, and NAME_smooth, which goes back one of them.

A step is recorded as the filter's own mean and factor before its predict, and what the predict was given: A, the predicted
mean and the predicted factor are made again.  The step back is `back`, in lines or (back_loops) in loops.
"""

from __future__ import annotations

import re
from typing import Sequence

from kalmanq.compiler import back_loops
from kalmanq.compiler.back import Back
from kalmanq.compiler.emit import function, passed, within
from kalmanq.compiler.equations import EquationFilter
from kalmanq.compiler.printing import Body
from kalmanq.formulas.graph import Node, constant, needed, symbol

STRAIGHT = 1200  # operations of a step back, about 6 kB: beyond, loops, which take 2 kB and five times as many instructions


class Smoother:
    """controls: lines that make u0, u1, ... of u; refusal: lines where a formula is not finite"""

    def __init__(self, a: EquationFilter, arguments: str, controls: Sequence[str], refusal: Sequence[str]):
        self.a, self.given, self.arguments, self.controls, self.refusal = a, a.given, arguments, controls, refusal
        self.name, self.steps, loops = a.given.name, a.given.options.smooth, a.given.options.loops
        self.lines, self.operations = self._straight()
        self.is_straight = self.operations <= STRAIGHT if loops is None else not loops

    # ---- what is recorded

    @property
    def record(self) -> list[str]:
        n, type_ = len(self.given.carried), self.a.type
        return [f"{type_} x[{n}], low[{n}], P[{max(len(self.a.live), 1)}];",
                *([f"{type_} u[{self.a.of.l}];"] if self.a.predicts_by("u") else []),
                *(f"{type_} {one};" for one in self.times)]

    @property
    def times(self) -> list[str]:
        return [one for one in ("t", "dt") if self.a.predicts_by(one)]

    @property
    def record_size(self) -> int:
        """Bytes"""
        numbers = 2 * len(self.given.carried) + max(len(self.a.live), 1) + len(self.times)
        numbers += self.a.of.l if self.a.predicts_by("u") else 0
        return (4 if self.a.type == "float" else 8) * numbers

    @property
    def history_size(self) -> int:
        """Bytes"""
        align = 4 if self.a.type == "float" else 8
        return self.record_size * self.steps + align

    def structs(self) -> list[str]:
        return ["typedef struct { /* of a step: the filter before it, and what it was given */",
                *(f"    {line}" for line in self.record), f"}} {self.name}_record;", "",
                "typedef struct { /* of the last steps; yours, as the filter is */",
                f"    {self.name}_record records[{self.steps}]; /* the oldest one gives way */",
                "    uint16_t next, steps; /* place of the next record; how many there are */", f"}} {self.name}_history;", ""]

    def told(self) -> list[str]:
        """Of the report"""
        where = "straight lines" if self.is_straight else "loops"
        return [f"  {self.name}_smooth, {self.name}_lagged: a step back in {where}; the history holds {self.steps} steps of "
                f"{self.record_size} bytes, {self.history_size} bytes in all."]

    # ---- the header

    def usage(self) -> list[tuple[str, str]]:
        """Calls and what they are for"""
        state = self.given.carried[0]
        return [("", ""), (f"static {self.name}_history h;", f"the last {self.steps} steps, {self.history_size} bytes"),
                (f"{self.name}_history_start(&h);", "once"), (f"{self.name}_predict_recorded(&f, &h{passed(self.arguments)});", "in the place of predict"),
                (f"{self.given.type} s = f;", "to smooth, begin with a copy"), (f"{self.name}_smooth(&s, &h, 1);", "then with 2, 3, ..."),
                (f"{self.name}_mean_{state}(&s)", "1 step ago, given all samples")]

    def calls(self) -> list[str]:
        name, filter_, n = self.name, f"{self.given.type} *f", len(self.given.carried)
        return [
            "/** Before the first step. */", f"void {name}_history_start({name}_history *h);", "",
            f"/** {name}_predict, and the step is recorded, in {self.record_size} bytes of the history. */",
            f"void {name}_predict_recorded({filter_}, {name}_history *h{self.arguments});", "",
            f"/** Goes one step back, to `back` steps before the last one: f becomes the filter of then, given all samples up to",
            " *  now.  f: a copy of the filter, which has gone back to `back` - 1; read it as you read the filter.",
            f" *      for (int back = 1; {name}_smooth(&s, &h, back); back++) use({name}_mean_{self.given.carried[0]}(&s));",
            f" *  Returns 0 and changes nothing where no such step is recorded.  {self._cost('3 to 5', '10 to 30')} */",
            f"int {name}_smooth({filter_}, const {name}_history *h, int back);", "",
            "/** The mean of `back` steps ago, given all samples up to now, without its variance.  Returns 0 and changes nothing",
            f" *  where so many are not recorded.  {self._cost('2 or 3', '5 to 15', ' for each of the steps')} */",
            f"int {name}_lagged(const {filter_}, const {name}_history *h, int back, {self.a.type} mean[{n}]);", ""]

    def _cost(self, straight: str, loops: str, each: str = "") -> str:
        """Observed on a Cortex-M4F at 2 to 6 states"""
        if self.is_straight:
            return f"Cost: {straight} predicts{each}."
        return f"Cost: {loops} predicts{each}; stack {back_loops.stack(self.a)} bytes."

    def functions(self) -> list[list[str]]:
        name, type_, n = self.name, self.a.type, len(self.given.carried)
        filter_, history = f"{self.given.type} *restrict f", f"{name}_history *restrict h"
        return [
            function(f"void {name}_history_start({history})", ["h->next = 0;", "h->steps = 0;"]),
            function(f"void {name}_predict_recorded({filter_}, {history}{self.arguments})", [
                f"{name}_record *const r = &h->records[h->next];", *self._recorded(),
                f"h->next = (uint16_t)(h->next + 1 < {self.steps} ? h->next + 1 : 0);",
                f"if (h->steps < {self.steps}) h->steps++;", f"{name}_predict(f{passed(self.arguments)});"]),
            *self._step_back(),
            function(f"static const {name}_record *recorded(const {history}, int back)", [
                f"return &h->records[h->next - back + (h->next < back ? {self.steps} : 0)];"]),
            function(f"int {name}_smooth({filter_}, const {history}, int back)", [
                "if (back < 1 || back > h->steps) return 0;", "step_back(f, recorded(h, back), 1);", "return 1;"]),
            function(f"int {name}_lagged(const {filter_}, const {history}, int back, {type_} mean[{n}])", [
                "if (back < 0 || back > h->steps) return 0;", f"{self.given.type} s = *f;",
                "for (int k = 1; k <= back; k++) step_back(&s, recorded(h, k), 0);",
                f"for (int i = 0; i < {n}; i++) mean[i] = s.x[i] + s.low[i];", "return 1;"])]

    def _recorded(self) -> list[str]:
        lines = [f"for (int i = 0; i < {len(self.given.carried)}; i++) {{", "    r->x[i] = f->x[i];", "    r->low[i] = f->low[i];", "}",
                 f"for (int i = 0; i < {max(len(self.a.live), 1)}; i++) r->P[i] = f->P[i];"]
        lines += [f"for (int i = 0; i < {self.a.of.l}; i++) r->u[i] = u[i];"] if self.a.predicts_by("u") else []
        return [*lines, *(f"r->{one} = {one};" for one in self.times)]

    # ---- the step back

    def _step_back(self) -> list[list[str]]:
        lines, helpers = (self.lines, []) if self.is_straight else back_loops.lines(self.a, off(self.a), self.refusal)
        text = "\n".join(lines)
        lines = within([(type_, local, field.replace("f->", "r->")) for type_, local, field in self.a.places()], lines)
        controls = [line for k, line in enumerate(self.controls) if re.search(rf"\bu{k}\b", text)]
        given = [*([f"const {self.a.type} *const u = r->u;"] if controls else []), *controls]
        given += [f"const {self.a.type} {one} = r->{one};" for one in self.times if re.search(rf"\b{one}\b", text)]
        head = f"static void step_back({self.given.type} *restrict f, const {self.name}_record *restrict r, int is_whole)"
        return [*helpers, function(head, [*given, *lines, *self.a.overflow([f"f->P[{k}]" for k in range(len(self.a.live))])],
                                   "f goes back to the step of the record.  is_whole: its covariance, too")]

    def _straight(self) -> tuple[list[str], int]:
        """Its lines, whose locals x0, l0, u0_1, d0, ... are of the record, and how many operations they are"""
        a, body = self.a, Body(self.a.words)
        c, fields = a.coefficients, {key: symbol(f"f->P[{slot}]") for slot, key in enumerate(a.live)}
        back = Back.of(a.form, c.A, c.noise(), a.entries)
        after = back.smoothed({key: fields[fact] if isinstance(fact, tuple) else constant(fact) for key, fact in a.facts.items()})
        first = back_loops.written(a.moved_by(back.moved(off(a))))
        second = [(f"f->P[{slot}]", after[key]) for slot, key in enumerate(a.live)]
        body.lines += a.unless_finite_step(body, self.refusal)
        made = [one for _, one in first]
        body.name_shared([*made, *_handed_on(made, [one for _, one in second])])
        body.assign(first)
        body.lines.append("if (!is_whole) return;")
        return body.assign(second), body.count


def off(a: EquationFilter) -> list[Node]:
    """The next instant's mean given all, less its predicted one"""
    given_all = [(symbol(f"f->x[{i}]"), symbol(f"f->low[{i}]")) for i in range(len(a.given.carried))]
    return a.beside(given_all, a.moved_mean())


def _handed_on(first: Sequence[Node], second: Sequence[Node]) -> list[Node]:
    """What the first formulas have made and the second ones use"""
    known = {id(one) for one in needed(first)[0]}
    later = [one for one in needed(second)[0] if id(one) not in known]
    return [part for one in later for part in one.args if isinstance(part, Node) and id(part) in known]
