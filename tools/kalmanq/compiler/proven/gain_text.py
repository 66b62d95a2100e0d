"""NAME.c of a filter of constant gain: it carries no covariance."""

from __future__ import annotations

from kalmanq.compiler.proven.body import Body, beyond, counted, door, function, not_yet, second
from kalmanq.compiler.proven.lines import indented
from kalmanq.compiler.proven.plan import Plan, bookkeeping


def start(plan: Plan) -> list[str]:
    s = plan.subject
    lines = [f"f->{name} = {value};" for i in range(s.of.n)
             for (name, _), value in zip(s.mean.fields(i), s.mean.start(i))]
    lines += [f"f->{name} = 0;" for _, name in bookkeeping(plan)]
    lines += [*variances(plan), "f->nis = 0;"] if plan.nis else []
    lines += [f"f->y_{measured} = 0;" for measured in s.measurements if plan.lag]
    return function(f"void {plan.name}_start({plan.type} *restrict f)", lines)


def variances(plan: Plan) -> list[str]:
    """Those that settled components have, one after the other"""
    s = plan.subject
    if not plan.nis:
        return []
    return [f"f->s_{measured} = {s.words.constant(value, s.words.variance(j))};"
            for j, (measured, value) in enumerate(zip(s.measurements, plan.pivots))]


def predict(plan: Plan) -> list[str]:
    body = Body(plan, "predict", carries=False)
    body.predict_mean()
    return [*beyond(plan, ()), *function(f"void {plan.name}_predict({plan.type} *restrict f{plan.controls})",
                                         [*body.text(), *counted(plan)])]


def update(plan: Plan) -> list[str]:
    body = Body(plan, "update", carries=False)
    body.update_by_gain()
    enough = [*(["f->missed = 0;"] if plan.max_gap else []), f"f->rows = {plan.min_run};"]
    if plan.min_run > 1:
        enough = ["const uint32_t rows = (f->rows >> 16) + 1;", "f->rows = rows;", f"if (rows >= {plan.min_run}) {{",
                  *indented(enough), "}"]
    return function(f"unsigned {plan.name}_update({plan.type} *restrict f, {plan.sample})",
                    [*door(plan, ["return 0;"], second(plan)), *enough, *body.text(), f"return {plan.all}u;"])


def step(plan: Plan) -> list[str]:
    u = ", u" if plan.subject.of.l else ""
    body = Body(plan, "step", carries=False)
    body.predict_mean()
    body.update_by_gain()
    return function(f"unsigned {plan.name}_step({plan.type} *restrict f{plan.controls}, {plan.sample})",
                    [*door(plan, [f"{plan.name}_predict(f{u});", "return 0;"]), *not_yet(plan, plan.min_run),
                     *body.text(), f"return {plan.all}u;"])


PARTS = (start, predict, update, step)
