"""NAME_lag: the mean some samples ago, given all samples up to now, of a settled float filter.

The means of the last L samples are kept.  Each innovation corrects them all by constant gains: the gain of the mean k
samples ago is P A' ((A (I - K H))')^(k-1) H' S^-1, with the steady P, K and S.
"""

from __future__ import annotations

from typing import Callable

import numpy as np

from kalmanq.compiler.enclosure import Settled
from kalmanq.compiler.exact import eye, inverse
from kalmanq.compiler.request import Request


def gains(given: Request, steady: Settled) -> list[np.ndarray]:
    """n x m for each of 1 to L samples ago"""
    of = given.of
    variance = of.H @ steady.predicted @ of.H.T + np.diag(of.R)
    closed = of.A @ (eye(of.n) - steady.gain @ of.H)
    weighed, cross, made = of.H.T @ inverse(variance), steady.filtered @ of.A.T, []
    for _ in range(given.options.lag):
        made.append((cross @ weighed).astype(float))
        cross = cross @ closed.T
    return made


def struct(given: Request, type_: str) -> list[str]:
    if not given.options.lag:
        return []
    return ["typedef struct {", f"    {type_} x[{given.options.lag + 1}][{given.of.n}]; /* means 0, 1, ... samples ago */",
            "    uint16_t rows;", f"}} {given.name}_lag;", ""]


def calls(given: Request, type_: str) -> list[str]:
    lag, name = given.options.lag, given.name
    if not lag:
        return []
    lines = ["/** Before the first sample. */", f"void {name}_lag_start({name}_lag *l);", "",
             "/** After each step, update or predict of a missing sample.  Returns 1 where the gain has been constant for",
             f" *  {lag} samples: then NAME_lagged_... is the mean {lag} samples ago, given all samples up to now. */".replace(
                 "NAME", name),
             f"int {name}_lag_step({name}_lag *l, const {given.type} *f);", ""]
    for i, state in enumerate(given.states):
        lines += [f"static inline {type_} {name}_lagged_{state}(const {name}_lag *l)", "{",
                  f"    return l->x[{lag}][{i}];", "}", ""]
    return lines


def functions(given: Request, steady: Settled, type_: str, number: Callable[[float], str]) -> list[str]:
    lag, name, n, m = given.options.lag, given.name, given.of.n, given.of.m
    if not lag:
        return []
    rows = [", ".join(number(value) for value in one.ravel()) for one in gains(given, steady)]
    zero = number(0)
    return [f"static const {type_} lag_gain[{lag}][{n * m}] = {{", *(f"    {{{row}}}," for row in rows), "};", "",
            f"void {name}_lag_start({name}_lag *l)", "{", "    l->rows = 0;",
            f"    for (int k = 0; k <= {lag}; k++)", f"        for (int i = 0; i < {n}; i++) l->x[k][i] = {zero};", "}", "",
            f"int {name}_lag_step({name}_lag *restrict l, const {given.type} *restrict f)", "{",
            f"    for (int k = {lag}; k > 0; k--)", f"        for (int i = 0; i < {n}; i++) {{",
            f"            {type_} sum = l->x[k - 1][i];",
            f"            for (int j = 0; j < {m}; j++) sum += lag_gain[k - 1][{m} * i + j] * f->y[j];",
            "            l->x[k][i] = sum;", "        }",
            f"    for (int i = 0; i < {n}; i++) l->x[0][i] = f->x[i] + f->low[i];",
            "    if (f->calls != SETTLED) l->rows = 0;", f"    else if (l->rows <= {lag}) l->rows++;",
            f"    return l->rows > {lag};", "}", ""]
