"""NAME.c of a filter: start, predict, update, step."""

from __future__ import annotations

import numpy as np

from kalmanq.compiler.proven import lag_text
from kalmanq.compiler.proven.body import PROBE, Body, beyond, door, function, not_yet, numbered, outside_of, second, stops, \
    too_soon
from kalmanq.compiler.proven.header import comment
from kalmanq.compiler.printing import indented
from kalmanq.compiler.proven.plan import Plan, bookkeeping, event
from kalmanq.compiler.proven.routines import routines
from kalmanq.compiler.proven.sums import Sum

REGISTERS = 28  # words of a covariance beside which a settled row is a function apart: its registers are not theirs
NEVER_INLINE = """\
#if defined __GNUC__
#define NEVER_INLINE __attribute__((noinline))
#else
#define NEVER_INLINE
#endif
"""


def start(plan: Plan) -> list[str]:
    s = plan.subject
    lines = [f"f->{name} = {value};" for i in range(s.of.n)
             for (name, _), value in zip(s.mean.fields(i), s.mean.start(i))]
    lines += covariance_of(plan, s.of.P0) + [f"f->{name} = 0;" for _, name in bookkeeping(plan)]
    lines += [*variances(plan), *["f->nis = 0;"] * plan.nis]
    lines += [f"f->{name} = 0;" for name in lag_text.innovations(plan)]
    return function(f"void {plan.name}_start({plan.type} *restrict f)", lines)


def variances(plan: Plan) -> list[str]:
    """Those that settled components have, one after the other"""
    s = plan.subject
    if not plan.nis:
        return []
    return [f"f->s_{measured} = {s.words.constant(value, s.words.variance(j))};"
            for j, (measured, value) in enumerate(zip(s.measurements, plan.pivots))]


def predict(plan: Plan) -> list[str]:
    body = Body(plan, "predict")
    body.predict()
    return [*beyond(plan, covariance_of(plan, plan.cap)), *function(
        f"void {plan.name}_predict({plan.type} *restrict f{plan.controls})", body.text())]


def update(plan: Plan) -> list[str]:
    if not plan.carries_covariance:
        return update_by_gain(plan)
    body = Body(plan, "update")
    for j in range(plan.subject.of.m):
        body.lines.title(plan.subject.measurements[j])
        body.update(j, Sum.named(f"z[{j}]"))
    body.judge()
    settled, apart = settled_row(plan), []
    if len(plan.structure.carried) > REGISTERS:
        head = f"NEVER_INLINE static void settled_row({plan.type} *restrict f, {plan.sample})"
        apart = [NEVER_INLINE, *function(head, settled)]
        settled = ["settled_row(f, z);"]
    whole = f"return {plan.all}u;"
    lines = [*door(plan, ["return 0;"], second(plan)), "const uint32_t rows = f->rows >> 16;",
             f"if (rows >= {plan.rows - 1}) {{ /* settled */", *indented([*settled, whole]), "}", *body.text(),
             *sooner(plan), "f->rows = rows + 1;", whole]
    return apart + function(f"unsigned {plan.name}_update({plan.type} *restrict f, {plan.sample})", lines)


def update_by_gain(plan: Plan) -> list[str]:
    """Of a filter that carries no covariance"""
    body = Body(plan, "update")
    body.update_by_gain()
    enough = [*(["f->missed = 0;"] if plan.max_gap else []), f"f->rows = {plan.min_run};"]
    if plan.min_run > 1:
        enough = ["const uint32_t rows = (f->rows >> 16) + 1;", "f->rows = rows;", f"if (rows >= {plan.min_run}) {{",
                  *indented(enough), "}"]
    return function(f"unsigned {plan.name}_update({plan.type} *restrict f, {plan.sample})",
                    [*door(plan, ["return 0;"], second(plan)), *enough, *body.text(), f"return {plan.all}u;"])


def sooner(plan: Plan) -> list[str]:
    """Where there may be another gap before all has settled"""
    if not plan.max_gap or plan.min_run >= plan.rows:
        return []
    return ["f->missed = 0;" if plan.min_run == 1 else f"if (rows >= {plan.min_run - 1}) f->missed = 0;"]


def settled_row(plan: Plan) -> list[str]:
    """By the constant gain; the covariance is what it settles to."""
    fast = Body(plan, "settled", carries=False)
    fast.update_by_gain()
    again = ["f->missed = 0;"] if plan.max_gap else []
    return [*again, *fast.text(), *settled_fields(plan), f"f->rows = {plan.rows};"]


def step(plan: Plan) -> list[str]:
    name = plan.name
    given = ", u" if plan.subject.of.l else ""
    fast = Body(plan, "step", carries=False)
    fast.predict_mean()
    fast.update_by_gain()
    lines = door(plan, [f"{name}_predict(f{given});", "return 0;"])
    lines += [*not_yet(plan), *fast.text(), f"return {plan.all}u;"]
    return function(f"unsigned {plan.name}_step({plan.type} *restrict f{plan.controls}, {plan.sample})", lines)


def update_some(plan: Plan) -> list[str]:
    """Each component has a function; a sample in part is one of a gap."""
    s, name = plan.subject, plan.name
    lines: list[str] = []
    for j, measured in enumerate(s.measurements):
        body = Body(plan, f"take_{measured}")
        body.update(j, Sum.named("z"))
        lines += function(f"static void take_{measured}({plan.type} *restrict f, {s.words.type} z)", body.text())
    taken = [f"if (present >> {j} & 1u) take_{measured}(f, z[{j}]);" for j, measured in enumerate(s.measurements)]
    shut = [line for j, limit in enumerate(plan.doors) for line in (
        f"if ((present >> {j} & 1u) && ({s.words.is_outside(f'z[{j}]', limit)})) {{", f"    {event(plan, 'REFUSED')}",
        f"    present &= ~{1 << j}u;", "}")]
    whole = (1 << s.of.m) - 1
    return lines + function(f"unsigned {name}_update_some({plan.type} *restrict f, {plan.sample}, unsigned present)", [
        f"present &= {whole}u;", *shut, f"if (present == {whole}u) return {name}_update(f, z);",
        "if (present == 0) return 0;", f"if ({second(plan)}) {{", f"    {event(plan, 'REFUSED')}", "    return 0;", "}",
        f"if (f->missed >= {plan.max_gap} || ({too_soon(plan)})) {{ /* too long, or too soon after another */",
        f"    {event(plan, 'REFUSED')}", "    return 0;", "}",
        "f->rows = UINT32_C(1) << 31;", *taken, "return present;"])


def step_some(plan: Plan) -> list[str]:
    name, u = plan.name, ", u" if plan.subject.of.l else ""
    whole = (1 << plan.subject.of.m) - 1
    outside = outside_of(plan)  # of a sample with a component beyond its range the others are taken
    return function(f"unsigned {name}_step_some({plan.type} *restrict f{plan.controls}, {plan.sample}, unsigned present)", [
        f"if (present == {whole}u && !({' || '.join(outside)})) return {name}_step(f{u}, z);",
        f"{name}_predict(f{u});", f"return {name}_update_some(f, z, present);"])


def settled_fields(plan: Plan) -> list[str]:
    return covariance_of(plan, plan.settled.filtered) + variances(plan)


def covariance_of(plan: Plan, P: np.ndarray) -> list[str]:
    s = plan.subject
    values = plan.form.values(P)
    return [f"f->{plan.field(key)} = {s.words.constant(values[key], plan.form.word(s, key))};"
            for key in plan.structure.carried]


def _functions(plan: Plan) -> str:
    parts = (start, predict, update, step, *((update_some, step_some) if plan.partial else ()))
    parts += (lag_text.start, lag_text.step) if plan.lag else ()
    return "\n".join(line for part in parts for line in part(plan))


def probes_of(plan: Plan) -> list[str]:
    """Function and name of each line whose value is told, in order"""
    return list(dict.fromkeys(PROBE.findall(_functions(plan)))) if plan.probes else []


def code(plan: Plan) -> str:
    body = numbered(_functions(plan))
    body = "\n".join(stops(plan)) + "\n" + body if plan.stops else body
    called = routines(body)
    includes = (["#include <limits.h>"] if "UINT_MAX" in called else []) + \
        (["#include <math.h>"] if plan.needs_math else [])
    return "\n".join([*comment(plan, plan.remarks), f'#include "{plan.name}.h"', "", *includes,
                      *([""] if includes else []), called + body])
