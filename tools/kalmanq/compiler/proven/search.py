"""Every covariance that the C can come to, by running it on the host beside an exact filter (search.c)."""

from __future__ import annotations

import json
import subprocess
from contextlib import ExitStack
from dataclasses import dataclass
from decimal import Decimal
from pathlib import Path
from typing import Sequence

import numpy as np

from kalmanq.compiler.exact import Numbers, root
from kalmanq.compiler.host import build, folder_of
from kalmanq.compiler.proven.body import too_soon
from kalmanq.compiler.proven.header import header
from kalmanq.compiler.proven.plan import Plan
from kalmanq.compiler.proven.text import code, probes_of
from kalmanq.errors import KalmanqError

SEARCH = Path(__file__).with_name("search.c")
CHECKED = ("-fsanitize=signed-integer-overflow,shift", "-fsanitize-undefined-trap-on-error")
TIME_LIMIT = 300  # s


@dataclass(frozen=True)
class Found:
    """Over all covariances.  closed: there are no more; error: the largest beside the exact filter's, of sigma_i
    sigma_j; merged: what exact covariances of one word differ by; pivot: the least, scaled; bad: not positive definite;
    ranges: least and largest of each line, by its number"""

    closed: bool
    count: int
    error: float
    merged: float
    pivot: float
    bad: int
    ranges: Sequence[Sequence[int]] = ()


@dataclass(frozen=True)
class Track:
    """Of a record.  worst, last: errors of means in sigma, of all and of the last 100 rows"""

    worst: float
    last: float
    covariance: float
    refused: int
    lines: Sequence[str]


class Runner:
    """A plan's C as a program; a context, which ends with its folder."""

    def __init__(self, plan: Plan):
        self.plan = plan

    def __enter__(self) -> Runner:
        name = self.plan.name
        texts = {f"{name}.c": code(self.plan), f"{name}.h": header(self.plan), "subject.h": subject(self.plan)}
        checked = CHECKED if self.plan.subject.words.is_fixed else ()
        with ExitStack() as own:
            self.folder = own.enter_context(folder_of(texts))
            build(self.folder, [f"{name}.c", str(SEARCH)], "search", (*checked, f"-I{self.folder}"))
            self._own = own.pop_all()
        return self

    def __exit__(self, *_: object) -> None:
        self._own.close()

    def search(self, limit: int) -> Found:
        return Found(**json.loads(self._run("search", str(limit))))

    def record(self, rows: int, longest: int, prints: bool = False, ends: int = 0, wanders: int = 0) -> Track:
        """ends: a seed, of measurements and controls at the ends of their ranges; wanders: a seed, nothing is damped"""
        lines = self._run("run", str(rows), str(longest), str(int(prints)), str(ends), str(wanders)).splitlines()
        return Track(**json.loads(lines[-1]), lines=lines[:-1])

    def _run(self, *words: str) -> str:
        try:
            done = subprocess.run([str(self.folder / "search"), *words], capture_output=True, text=True,
                                  timeout=TIME_LIMIT)
        except subprocess.TimeoutExpired:
            raise KalmanqError(f"the search took more than {TIME_LIMIT} s") from None
        if done.returncode < 0:
            raise Overflow("a word overflows")
        if done.returncode:
            raise KalmanqError("the search ran out of memory")
        return done.stdout


class Overflow(KalmanqError):
    """An integer was larger than its word."""


# ------------------------------------------------------------------------------ subject.h


def pair(value: Decimal) -> str:
    high = float(value)
    return f"{{{high!r}, {float(value - Decimal(high))!r}}}"


def table(name: str, values: np.ndarray) -> str:
    cells = ", ".join(pair(value) for value in values.ravel()) or "{0, 0}"
    return f"static const exact {name}[] = {{{cells}}};"


def subject(plan: Plan) -> str:
    s, of = plan.subject, plan.subject.of
    name, type_ = plan.name, plan.subject.words.type
    zeros = f"static const {type_} none[{of.m} + {of.l} + 1];"
    u = "none, " if of.l else ""
    after = ", none" if of.l else ""
    lines = ["#include <stdio.h>", f'#include "{name}.h"', *sizes(plan),
             "typedef struct { double high, low; } exact;",
             f"typedef {plan.type} subject;",
             f"typedef {type_} subject_word;", zeros, *numbers_of(of),
             table("model_gain", plan.settled.gain), table("model_settled", plan.settled.filtered), table("model_cap", plan.cap),
             function("void subject_begin(subject *f)", [f"{name}_start(f);"]),
             function("void subject_start(subject *f)", [f"{name}_start(f);", *[
                 f"f->{field} = 0;" for i in range(of.n) for field, _ in s.mean.fields(i)]]),
             function("void subject_predict(subject *f)", [f"{name}_predict(f{after});"]),
             function("void subject_update(subject *f)", [f"{name}_update(f, none);"]),
             function("void subject_take(subject *f, unsigned present)", taking(plan, u, "none")),
             function("int subject_refused(const subject *f)", [f"return (f->events & {plan.upper}_REFUSED) != 0;"]),
             function("int subject_is_beyond(const subject *f)",
                      [f"return (f->events & {plan.upper}_SIGMA_SATURATED) != 0;"]),
             function("int subject_is_too_soon(const subject *f)",
                      [f"return !(uint16_t)f->rows && ({too_soon(plan)});" if plan.max_gap else "(void)f; return 0;"]),
             function("void subject_forget(subject *f)", ["f->events = 0;"]),
             function("void subject_covariance(const subject *f, double *P)", covariance(plan)),
             function("void subject_mean(const subject *f, int i, double *high, double *low)", mean(plan)),
             *outside(plan), *running(plan)]
    return "\n".join(lines) + "\n"


def function(head: str, body: Sequence[str]) -> str:
    return "\n".join([f"static {head}", "{", *(f"    {line}" for line in body), "}"])


def sizes(plan: Plan) -> list[str]:
    of, given = plan.subject.of, {"HAS_SUBSETS": plan.partial, "IS_GAIN": not plan.carries_covariance,
                                  "LEAST_RUN": max(plan.min_run, 1), "PROBES": len(probes_of(plan))}
    return [f"enum {{ N = {of.n}, M = {of.m}, L = {of.l}, FULL = (1 << M) - 1 }};",
            f"enum {{ {', '.join(f'{name} = {int(value)}' for name, value in given.items())} }};"]


def numbers_of(of: Numbers) -> list[str]:
    names = ("A", "B", "H", "Q", "R", "x0", "P0")
    return [table(f"model_{name}", getattr(of, name)) for name in names]


def taking(plan: Plan, u: str, z: str) -> list[str]:
    name = plan.name
    some = [f"if (present != FULL) {{ {name}_step_some(f, {u}{z}, present); return; }}"] if plan.partial else []
    return [*some, "(void)present;", f"{name}_step(f, {u}{z});"]


def covariance(plan: Plan) -> list[str]:
    """The upper triangle by rows, from the fields."""
    form, n = plan.form, plan.subject.of.n
    texts = form.covariance(n, lambda key: entry(plan, key) if key in plan.structure.facts else "0")
    return ["(void)f;", "(void)P;", *(f"P[{k}] = {texts[key]};" for k, key in enumerate(sorted(texts)))]


def entry(plan: Plan, key: tuple[int, int]) -> str:
    fact = plan.structure.facts[key]
    if isinstance(fact, tuple):
        return plan.subject.words.value(f"f->{plan.field(fact)}", plan.form.word(plan.subject, fact))
    return repr(float(fact))


def mean(plan: Plan) -> list[str]:
    s = plan.subject
    lines = []
    for i in range(s.of.n):
        high, low = s.mean.value(i)
        lines.append(f"if (i == {i}) {{ *high = {high}; *low = {low}; }}")
    return lines


def outside(plan: Plan) -> list[str]:
    """What measurements and controls of the record can be, and their words."""
    s = plan.subject
    given = {"damped": [damping(s.of), damping(s.of, 1.0)], "root_of_Q": floats(root(s.of.Q)), "most_of": plan.most,
             "control_of": plan.pushes}
    tables = [f"static const double {name}[] = {{{', '.join(map(repr, values)) or '0'}}};"
              for name, values in given.items()]
    return [
        *tables,
        function("subject_word subject_measured(int j, double value)", s.words.taken("z", "j")),
        function("double subject_value(int j, subject_word word)", s.words.given("z", "j")),
        function("subject_word subject_control(int k, double value)", s.words.taken("u", "k")),
        function("double subject_control_value(int k, subject_word word)", s.words.given("u", "k"))]


def floats(values: np.ndarray) -> list[float]:
    return [float(value) for value in values.ravel()]


def damping(of: Numbers, most: float = 0.97) -> float:
    """With what A fades by a thirtieth a row at least, or does not grow by a power"""
    largest = float(np.abs(np.linalg.eigvals(of.A.astype(float))).max())
    return round(min(1.0, most / max(largest, 1e-9)), 3)


def running(plan: Plan) -> list[str]:
    name = plan.name
    u, after = ("u, ", ", u") if plan.subject.of.l else ("", "")
    fields = [field for i in range(plan.subject.of.n) for field, _ in plan.subject.mean.fields(i)]
    fields += [plan.field(key) for key in plan.structure.carried]
    return [function("void subject_predict_by(subject *f, const subject_word *u)",
                     ["(void)u;", f"{name}_predict(f{after});"]),
            function("void subject_update_by(subject *f, const subject_word *z)", [f"{name}_update(f, z);"]),
            function("void subject_step_by(subject *f, const subject_word *u, const subject_word *z, unsigned present)",
                     ["(void)u;", *taking(plan, u, "z")]),
            function("void subject_print_word(subject_word word)", plan.subject.words.printed("word")),
            function("void subject_print(const subject *f)",
                     [line for field in fields for line in plan.subject.words.printed(f"f->{field}")])]
