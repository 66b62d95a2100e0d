"""NAME_lag: the mean some samples ago, given all up to now, of a settled filter.

The means of the last L samples are kept, and each innovation corrects them all by constant gains:
P A' (A (I - K H))'^(k-1) H' S^-1 for the one k samples ago, with the steady P, K and S.
"""

from __future__ import annotations

from kalmanq.compiler import lag
from kalmanq.compiler.proven.body import function
from kalmanq.compiler.printing import indented
from kalmanq.compiler.proven.plan import Plan
from kalmanq.compiler.proven.sums import Sum


def innovations(plan: Plan) -> list[str]:
    """Fields of a filter for its lag"""
    return [f"y_{measured}" for measured in plan.subject.measurements] if plan.lag else []


def struct(plan: Plan) -> list[str]:
    if not plan.lag:
        return []
    type_ = plan.subject.mean.single
    fields = [f"{type_} x_{state}_{k};" for k in range(plan.lag + 1) for state in plan.subject.states]
    return ["typedef struct {", *indented(["uint16_t rows;", *fields]), f"}} {plan.name}_lag;", ""]


def calls(plan: Plan) -> list[str]:
    if not plan.lag:
        return []
    since = f"settled for {plan.lag} samples" if plan.carries_covariance else \
        f"given {plan.forgets + plan.lag} samples in a row"
    lines = ["/** Before the first sample. */", f"void {plan.name}_lag_start({plan.name}_lag *l);", "",
             "/** After each step, update and predict of a missing sample: 1 where the filter has been",
             f" *  {since}, so that the mean {plan.lag} samples ago is given all up to now; else 0. */",
             f"int {plan.name}_lag_step({plan.name}_lag *restrict l, const {plan.type} *restrict f);", ""]
    for i, state in enumerate(plan.subject.states):
        type_, text = plan.subject.mean.lagged(i, f"l->x_{state}_{plan.lag}")
        lines += [f"static inline {type_} {plan.name}_lagged_{state}(const {plan.name}_lag *l)", "{",
                  f"    return {text};",
                  "}", ""]
    return lines


def start(plan: Plan) -> list[str]:
    fields = [f"l->x_{state}_{k} = 0;" for k in range(plan.lag + 1) for state in plan.subject.states]
    return function(f"void {plan.name}_lag_start({plan.name}_lag *l)", ["l->rows = 0;", *fields])


def step(plan: Plan) -> list[str]:
    s, lines = plan.subject, []
    steady = lag.gains(s.of, plan.settled, plan.lag)
    for k in range(plan.lag, 0, -1):
        for i, state in enumerate(s.states):
            change = Sum()
            for j, measured in enumerate(s.measurements):
                change = change + Sum.named(f"f->y_{measured}") * steady[k - 1][i, j]
            lines.append(f"l->x_{state}_{k} = {s.mean.corrected(i, f'l->x_{state}_{k - 1}', change)};")
    lines += [f"l->x_{state}_0 = {s.mean.whole(i)};" for i, state in enumerate(s.states)]
    count = plan.lag if plan.carries_covariance else plan.forgets + plan.lag - plan.min_run
    return function(f"int {plan.name}_lag_step({plan.name}_lag *restrict l, const {plan.type} *restrict f)", [
        *lines, f"if (f->rows != {plan.rows_to_constant_gain}) {{", "    l->rows = 0;",
        f"}} else if (l->rows <= {count}) {{", "    l->rows++;", "}",
        f"return l->rows > {count};"])
