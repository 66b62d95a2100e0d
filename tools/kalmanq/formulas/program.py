"""Values of formulas: of numbers, or of arrays of numbers, in NumPy's float64, float32 or long double."""

from __future__ import annotations

from typing import Any, Callable, Mapping, Sequence

import numpy as np

from kalmanq.formulas.graph import FUNCTIONS, IN_NUMPY, Node, needed

OPERATIONS: dict[str, Callable[..., Any]] = {
    "add": np.add, "sub": np.subtract, "mul": np.multiply, "inverse": lambda a: 1 / a, "select": np.where, "lt": np.less,
    "le": np.less_equal, "eq": np.equal, "not": np.logical_not, "and": np.logical_and, "or": np.logical_or,
    **{name: getattr(np, IN_NUMPY.get(name, name)) for name in FUNCTIONS}}


class Program:
    """Formulas as a list of operations, worked out one after the other.

    operations: by name, for other numbers than NumPy's"""

    def __init__(self, roots: Sequence[Node], operations: Mapping[str, Callable[..., Any]] = OPERATIONS):
        self.order, _ = needed(roots)
        places = {id(one): k for k, one in enumerate(self.order)}
        self.roots = [places[id(one)] for one in roots]
        self.constants = [(places[id(one)], one.value) for one in self.order if one.op == "constant"]
        self.symbols = [(places[id(one)], one.args[0]) for one in self.order if one.op == "symbol"]
        self.steps = [(k, operations[one.op], tuple(places[id(a)] for a in one.args)) for k, one in enumerate(self.order)
                      if one.op not in ("constant", "symbol")]

    def values(self, given: Mapping[str, Any], number: Callable[[float], Any] = np.float64) -> list[Any]:
        """Of the roots; given: of symbols by name"""
        every = self.every(given, number)
        return [every[k] for k in self.roots]

    def every(self, given: Mapping[str, Any], number: Callable[[float], Any] = np.float64) -> list[Any]:
        """Of all formulas, as in `order`; what has no value is NaN or infinite"""
        made: list[Any] = [None] * len(self.order)
        for k, value in self.constants:
            made[k] = number(value)
        for k, name in self.symbols:
            made[k] = number(given[name])
        with np.errstate(all="ignore"):
            for k, operation, args in self.steps:
                made[k] = operation(*(made[a] for a in args))
        return made
