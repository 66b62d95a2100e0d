"""NAME_lag: the mean some samples ago, given all samples up to now, of a filter that has settled.

The means of the last L samples are kept.  Each innovation corrects them all by constant gains: the gain of the mean k
samples ago is P A' ((A (I - K H))')^(k-1) H' S^-1, with the steady P, K and S.
"""

from __future__ import annotations

from typing import Optional

import numpy as np

from kalmanq.compiler.arithmetic import Arithmetic
from kalmanq.compiler.enclosure import Settled
from kalmanq.compiler.exact import Numbers, eye, inverse
from kalmanq.compiler.request import Request


def gains(of: Numbers, steady: Settled, lag: int) -> list[np.ndarray]:
    """n x m for each of 1 to L samples ago"""
    variance = of.H @ steady.predicted @ of.H.T + np.diag(of.R)
    closed = of.A @ (eye(of.n) - steady.gain @ of.H)
    weighed, cross, made = of.H.T @ inverse(variance), steady.filtered @ of.A.T, []
    for _ in range(lag):
        made.append(cross @ weighed)
        cross = cross @ closed.T
    return made


def struct(given: Request, a: Arithmetic) -> list[str]:
    if not given.options.lag:
        return []
    return ["typedef struct {", f"    {a.mean_type} x[{given.options.lag + 1}][{given.of.n}]; /* means 0, 1, ... samples ago */",
            "    uint16_t rows;", f"}} {given.name}_lag;", ""]


def calls(given: Request, a: Arithmetic) -> list[str]:
    lag, name = given.options.lag, given.name
    if not lag:
        return []
    lines = ["/** Before the first sample. */", f"void {name}_lag_start({name}_lag *l);", "",
             "/** After each step, update or predict of a missing sample.  Returns 1 where the gain has been constant for",
             f" *  {lag} samples: then NAME_lagged_... is the mean {lag} samples ago, given all samples up to now. */".replace(
                 "NAME", name),
             f"int {name}_lag_step({name}_lag *l, const {given.type} *f);", ""]
    for i, state in enumerate(given.states):
        lines += [f"static inline {a.type} {name}_lagged_{state}(const {name}_lag *l)", "{",
                  f"    return {a.lagged(i, f'l->x[{lag}][{i}]')};", "}", ""]
    return lines


def functions(given: Request, a: Arithmetic, steady: Optional[Settled]) -> list[str]:
    lag, name, n, m = given.options.lag, given.name, given.of.n, given.of.m
    if not lag or steady is None:
        return []
    tables = [one.astype(float) for one in gains(given.of, steady, lag)]
    moved = [a.gained(i, tables, "g[{}]", "f->y[{}]") for i in range(n)]
    return [f"static const {a.type} lag_gain[{lag}][{n * m}] = {{",
            *(f"    {{{', '.join(row)}}}," for row in a.gain_literals(tables)), "};", "",
            f"void {name}_lag_start({name}_lag *l)", "{", "    l->rows = 0;",
            f"    for (int k = 0; k <= {lag}; k++)", f"        for (int i = 0; i < {n}; i++) l->x[k][i] = 0;", "}", "",
            f"int {name}_lag_step({name}_lag *restrict l, const {given.type} *restrict f)", "{",
            f"    for (int k = {lag}; k > 0; k--) {{", f"        const {a.type} *g = lag_gain[k - 1];",
            *(f"        l->x[k][{i}] = {a.kept(i, f'l->x[k - 1][{i}]' + (f' + {text}' if text else ''))};"
              for i, text in enumerate(moved)), "    }",
            *(f"    l->x[0][{i}] = {a.whole_mean(i)};" for i in range(n)),
            "    if (f->calls != SETTLED) l->rows = 0;", f"    else if (l->rows <= {lag}) l->rows++;",
            f"    return l->rows > {lag};", "}", ""]


# ---- of a program that runs the filter f


def followed(given: Request) -> list[str]:
    """Lines once after the start, and after each row"""
    name = given.name
    return [f"static {name}_lag l; {name}_lag_start(&l);", f"(void){name}_lag_step(&l, &f);"] if given.options.lag else []


def kept(given: Request) -> list[str]:
    """Its fields whose bits are compared"""
    return ["l.x"] if given.options.lag else []
