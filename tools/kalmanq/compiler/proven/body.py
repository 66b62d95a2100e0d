"""The lines of a function: from a filter's fields, by an algorithm, back into its fields."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Sequence

from kalmanq.compiler.printing import indented
from kalmanq.compiler.proven.forms import Entries, Judged, Mean, judged_settled, judged_unsettled, \
    update_by_gain
from kalmanq.compiler.proven.lines import Line, Lines
from kalmanq.compiler.proven.plan import LARGEST, Plan, event
from kalmanq.compiler.proven.sums import Sum

WIDTH = 110
PROBE = re.compile("@([^@]*)@")


@dataclass
class Body:
    """A function that takes the filter from its fields and puts back what has changed."""

    plan: Plan
    function: str
    carries: bool = True  # the covariance
    lines: Lines = field(default_factory=Lines)
    x: Mean = field(default_factory=list)
    P: Entries = field(default_factory=dict)
    kept: list[Judged] = field(default_factory=list)

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
        """The mean goes on before the gap is looked at."""
        self.predict_mean()
        self._store_mean()
        for line in counted(self.plan):
            self.lines.do(line)
        self.lines.put_off(self.plan.field(key) for key in self.plan.structure.carried)
        if self.plan.carries_covariance:
            self.P = self.plan.form.predict(self.plan.subject, self.lines, self.P)

    def predict_mean(self) -> None:
        s = self.plan.subject
        self.x = s.mean.predict(self.lines, self.x, [self._control(k) for k in range(s.of.l)])

    def _control(self, k: int) -> Sum:
        plan, s = self.plan, self.plan.subject
        called = "within" if plan.model.controls[k].range else "number"
        return self.lines.add(f"u_{s.controls[k]}", s.words.type, f"{called}(f, u[{k}], {plan.stops[k]})")

    def update(self, j: int, z: Sum) -> None:
        self.x, self.P = self.plan.form.update(self.plan.subject, self.lines, self.x, self.P, j, z, self._keep)

    def _keep(self, j: int, y: Sum, w: Sum, variance: Sum) -> None:
        self.kept.append(Judged(j, y, w, variance))

    def judge(self) -> None:
        """Of all components that update has taken: NIS, and their variances"""
        s, plan = self.plan.subject, self.plan
        if plan.nis:
            self.lines.do(f"f->nis = {judged_unsettled(s, self.lines, self.kept)};")
            for one in self.kept:
                self.lines.do(f"f->s_{s.measurements[one.component]} = "
                              f"{s.words.store(one.variance, s.words.variance(one.component))};")

    def update_by_gain(self) -> None:
        s = self.plan.subject
        z = [Sum.named(f"z[{j}]") for j in range(s.of.m)]
        self.x, y = update_by_gain(s, self.lines, self.x, z, self.plan.settled.gain)
        for j, one in enumerate(y if self.plan.lag else ()):
            self.lines.do(f"f->y_{s.measurements[j]} = {one.name};")
        if self.plan.nis:
            self.lines.do(f"f->nis = {judged_settled(s, self.lines, y, self.plan.settled.variance)};")

    def text(self) -> list[str]:
        """Of its lines and of what is stored."""
        plan, s, P = self.plan, self.plan.subject, self.before[1]
        self._store_mean()
        for key in plan.structure.carried if self.carries else ():
            if self.P[key].key() != P[key].key():
                self.lines.do(f"f->{plan.field(key)} = {s.words.store(self.P[key], plan.form.word(s, key))};")
        return [one for line in self.lines.living() for one in self._written(line)]

    def _store_mean(self) -> None:
        s = self.plan.subject
        for i in range(s.of.n):
            for (name, _), new, old in zip(s.mean.fields(i), self.x[i], self.before[0][i]):
                if new.key() != old.key():
                    self.lines.do(f"f->{name} = {s.words.store(new)};")
        self.before = [list(words) for words in self.x], self.before[1]

    def _written(self, line: Line) -> list[str]:
        place = f"{self.function} {line.name}"
        if self.plan.probes and line.type == "int32_t" and line.note:
            return [line.code(), f"probe(@{place}@, {line.text.replace('(int32_t)', '')});"]
        notes = [note for note in (line.note, self.plan.ranges.get(place, "")) if note]
        if not notes:
            return [line.code()]
        remark = f"/* {', '.join(notes)} */"
        return [f"{line.code()} {remark}"] if len(line.code()) + len(remark) < WIDTH else [remark, line.code()]


def function(head: str, body: Sequence[str], remark: str = "") -> list[str]:
    return [*([f"/* {remark} */"] if remark else []), head, "{", *indented(body), "}", ""]


def outside_of(plan: Plan) -> list[str]:
    """Whether a measurement is outside its range, or no number, of each"""
    ranged = [bool(one.range) for one in plan.model.measurements]
    squares = " + ".join(f"z[{j}] * z[{j}]" for j in range(len(ranged)) if not ranged[j])  # one comparison of them all
    return [*(plan.subject.words.is_outside(f"z[{j}]", limit) for j, limit in enumerate(plan.doors) if ranged[j]),
            *([f"!({squares} <= {LARGEST**2:.0e}f)"] if squares else [])]


def door(plan: Plan, refused: Sequence[str], *others: str) -> list[str]:
    """What is outside the declared range, or no number, is refused, and what other conditions name."""
    outside = [*others, *outside_of(plan)]
    return [f"if ({' || '.join(outside)}) {{", *indented([event(plan, "REFUSED"), *refused]), "}"]


def second(plan: Plan) -> str:
    """Whether a sample was taken since the last predict; the highest bit of rows: some components of one"""
    return "(uint16_t)f->rows || f->rows >> 31" if plan.partial else "(uint16_t)f->rows"


def too_soon(plan: Plan) -> str:
    """Whether some rows were measured, but too few between two gaps"""
    return "f->missed && f->rows << 1" if plan.partial else "f->missed && f->rows"


def counted(plan: Plan) -> list[str]:
    """What a predict begins with: a gap beyond those declared is another function's."""
    other = ["beyond(f);", "return;"]
    if plan.max_gap:
        other = [f"if (f->missed == {plan.max_gap} || ({too_soon(plan)})) {{ "
                 "/* too long, or too soon after another */", *indented(other), "}", "f->missed++;"]
    return ["if ((uint16_t)f->rows == 0) { /* no sample since the last predict */", *indented(other), "}",
            "f->rows <<= 16;"]


def beyond(plan: Plan, capped: Sequence[str]) -> list[str]:
    """Of a predict beyond the declared gaps.  capped: lines that make the covariance the cap"""
    again = [f"if ({too_soon(plan)}) {{ /* too soon after another */", *indented([
        *capped, "f->rows = 0;", f"f->missed = {plan.max_gap};"]), "}"] if plan.max_gap else []
    fields = [name for i in range(plan.subject.of.n) for name, _ in plan.subject.mean.fields(i)]
    stays = [f"f->{name} = stay(f, f->{name}, {plan.subject.mean.word(i, most)});"
             for i, (name, most) in enumerate(zip(fields, plan.stays))]
    remark = "A gap that was not declared: the covariance stays" + \
        (", or becomes what the longest one leaves of the start" if again and capped else "")
    return [*(stay(plan) if stays else []), *function(f"static void beyond({plan.type} *restrict f)", [
        event(plan, "SIGMA_SATURATED"), *again, *stays], remark)]


def stay(plan: Plan) -> list[str]:
    return function(f"static int64_t stay({plan.type} *restrict f, int64_t x, int64_t most)", [
        "if (x >= -most && x <= most) return x;", event(plan, "MEAN_SATURATED"), "return x > 0 ? most : -most;"])


def not_yet(plan: Plan) -> list[str]:
    """What a step begins with: before the gain is constant it is two calls."""
    u = ", u" if plan.subject.of.l else ""
    return [f"if (f->rows != {plan.rows_to_constant_gain}) {{", f"    {plan.name}_predict(f{u});",
            f"    return {plan.name}_update(f, z);", "}"]


def stops(plan: Plan) -> list[str]:
    """The functions that controls go through"""
    ranges = [one.range for one in plan.model.controls]
    none = function(f"static inline float number({plan.type} *restrict f, float u, float most)", [
        "if (u >= -most && u <= most) return u;", event(plan, "CONTROL_REFUSED"), "return 0.0f;"], "A control, or none")
    return [*(stop(plan) if any(ranges) else []), *(none if any(not one for one in ranges) else [])]


def stop(plan: Plan) -> list[str]:
    type_, otherwise = plan.subject.words.type, "-most" if plan.subject.words.is_fixed else "u < 0 ? -most : 0"
    return function(f"static inline {type_} within({plan.type} *restrict f, {type_} u, {type_} most)", [
        "if (u >= -most && u <= most) return u;", event(plan, "CONTROL_REFUSED"), f"return u > 0 ? most : {otherwise};"],
        "A control, or the nearer end of its range")


def numbered(text: str) -> str:
    places = {place: k for k, place in enumerate(dict.fromkeys(PROBE.findall(text)))}
    return PROBE.sub(lambda found: str(places[found.group(1)]), text)
