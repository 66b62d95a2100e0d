"""NAME_lag: the mean some samples ago, given all samples up to now, of a filter that has settled.

The means of the last L samples are kept.  Each innovation corrects them all by constant gains: the gain of the mean k
samples ago is P A' ((A (I - K H))')^(k-1) H' S^-1, with the steady P, K and S.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from kalmanq.compiler.algorithm.arithmetic import Arithmetic
from kalmanq.compiler.given.enclosure import Settled
from kalmanq.compiler.given.exact import Numbers, eye, inverse
from kalmanq.compiler.given.request import Request


def gains(of: Numbers, steady: Settled, lag: int) -> list[np.ndarray]:
    """n x m for each of 1 to L samples ago"""
    variance = of.H @ steady.predicted @ of.H.T + np.diag(of.R)
    closed = of.A @ (eye(of.n) - steady.gain @ of.H)
    weighed, cross, made = of.H.T @ inverse(variance), steady.filtered @ of.A.T, []
    for _ in range(lag):
        made.append(cross @ weighed)
        cross = cross @ closed.T
    return made


def bodies(given: Request, a: Arithmetic, steady: Settled) -> dict[str, Any]:
    """Of NAME.c"""
    lag, n = given.options.lag, given.of.n
    if not lag:
        return {}
    tables = [one.astype(float) for one in gains(given.of, steady, lag)]
    moved = [a.gained(i, tables, "g[{}]", "f->y[{}]") for i in range(n)]
    return {"lag_gain": [f"{{{', '.join(row)}}}," for row in a.gain_literals(tables)],
            "lagged": [{"kept": a.kept(i, f"l->x[k - 1][{i}]" + (f" + {text}" if text else "")), "now": a.whole_mean(i)}
                       for i, text in enumerate(moved)]}
