"""kalmanq compile MODEL.py --smooth STEPS: a history of steps, and NAME_smooth, which goes back one of them.

A step is recorded as the filter's own mean and factor before its predict, and what the predict was given: A, the predicted
mean and the predicted factor are made again.  The step back is `back`, in lines or (back_loops) in loops.
"""

from __future__ import annotations

import re
from typing import Any, Sequence

from kalmanq.compiler.algorithm import back_loops
from kalmanq.compiler.algorithm.back import Back
from kalmanq.compiler.algorithm.equations import EquationFilter
from kalmanq.compiler.text.emit import within
from kalmanq.formulas.graph import Node, constant, needed, symbol
from kalmanq.formulas.printing import Body

STRAIGHT = 1200  # operations of a step back, about 6 kB: beyond, loops, which take 2 kB and five times as many instructions


class Smoother:
    """controls: lines that make u0, u1, ... of u; refusal: lines where a formula is not finite"""

    def __init__(self, a: EquationFilter, controls: Sequence[str], refusal: Sequence[str]):
        self.a, self.given, self.controls, self.refusal = a, a.given, controls, refusal
        self.name, self.steps, loops = a.given.name, a.given.options.smooth, a.given.options.loops
        self.lines, self.operations = self._straight()
        self.is_straight = self.operations <= STRAIGHT if loops is None else not loops

    # ---- what is recorded

    @property
    def times(self) -> list[str]:
        return [one for one in ("t", "dt") if self.a.predicts_by(one)]

    @property
    def controls_kept(self) -> int:
        return self.a.of.l if self.a.predicts_by("u") else 0

    @property
    def record_size(self) -> int:
        """Bytes"""
        numbers = 2 * len(self.given.carried) + max(len(self.a.live), 1) + len(self.times)
        numbers += self.controls_kept
        return (4 if self.a.type == "float" else 8) * numbers

    @property
    def history_size(self) -> int:
        """Bytes"""
        align = 4 if self.a.type == "float" else 8
        return self.record_size * self.steps + align

    def names(self) -> dict[str, Any]:
        """For NAME.h and NAME.c"""
        return {"steps": self.steps, "times": self.times, "controls": self.controls_kept, "entries": max(len(self.a.live), 1),
                "record_size": self.record_size, "history_size": self.history_size, "is_straight": self.is_straight,
                "stack": back_loops.stack(self.a)}

    # ---- the step back

    def bodies(self) -> dict[str, Any]:
        a = self.a
        lines, moved, loops = (self.lines, [], {}) if self.is_straight else back_loops.bodies(a, off(a), self.refusal)
        text = "\n".join([*lines, *moved])
        loads = within([(type_, local, field.replace("f->", "r->")) for type_, local, field in a.places()], [*lines, *moved])[:-len(moved) or None]
        controls = [line for k, line in enumerate(self.controls) if re.search(rf"\bu{k}\b", text)]
        given = [*([f"const {a.type} *const u = r->u;"] if controls else []), *controls]
        given += [f"const {a.type} {one} = r->{one};" for one in self.times if re.search(rf"\b{one}\b", text)]
        return {"one": a.number(1), "back": {**loops, "loops": not self.is_straight, "given": given, "lines": loads, "moved": moved,
                                             "overflow": a.overflow([f"f->P[{k}]" for k in range(len(a.live))])}}

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
