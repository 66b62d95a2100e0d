"""NAME_move: A, B and Q of a tunable filter for a step of another length, of a model in continuous time.

As kalmanq.model.continuous: a series over dt / 2^k, and k doublings.  Where a power of F is 0 the series ends, and k is 0.
"""

from __future__ import annotations

from typing import Any, Callable, Sequence

import numpy as np

from kalmanq.compiler.given.request import Request
from kalmanq.model.continuous import Continuous

SHORT, TERMS = 0.25, {"float": 8, "double": 14}  # of a series: h |F| at most, and its terms
LONGEST = 20  # doublings at most


def longest(of: Continuous) -> float:
    """The longest step that is taken"""
    return np.inf if of.ends else SHORT * 2.0**LONGEST / of.norm


def names(given: Request, of: Continuous, type_: str, number: Callable[[float], str], stores: Sequence[tuple[str, str]]) -> dict[str, Any]:
    """For its templates.  stores: fields, and what they get: entries of A, and sums over S B"""
    made = {"F": ", ".join(number(float(value)) for value in of.F.ravel()), "density": ", ".join(number(float(value)) for value in of.Qc.ravel()),
            "ends": of.ends, "terms": given.of.n if of.ends else TERMS[type_], "one": number(1), "dt": f"{of.dt:g} {of.unit}",
            "pushes": given.of.l, "stores": [f"{field} = {value};" for field, value in stores]}
    if of.ends:
        return made
    return {**made, "norm": number(of.norm), "short": number(SHORT), "half": number(0.5), "longest": number(longest(of)),
            "longest_said": f"{longest(of):.3g}"}
