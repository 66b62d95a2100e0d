"""A number that is a formula: what Python does with numbers, it does with it."""

from __future__ import annotations

from functools import partial
from typing import Any, Callable, Optional

import numpy as np

from kalmanq.formulas.functions import COMPLEX, NAMED, NoFormula, named, truth, value
from kalmanq.formulas.graph import Node, constant

NO_NUMBER = ("wants a number where there is a formula (float, int, an index, an array of numbers from outside or of another "
             "module): make arrays of floats in the function, import on top of the file; of a table there is np.interp, and what "
             "changes with the row t is a control")
NO_TEXT = "a text with a number in it has no formula: leave it out of the function; print(x) is left out by itself"
NO_KEY = ("a formula cannot be looked up in a dict, a set or a cache: write comparisons, or np.interp of a table; what changes "
          "with the row t is a control")


class Formula(Node):
    """decide: answers `if condition` while a function is traced"""

    __slots__ = ()
    __array_priority__ = 1000.0
    shape, ndim, size = (), 0, 1
    decide: Optional[Callable[[Node], bool]] = None

    @property  # type: ignore[misc]
    def __class__(self) -> type:  # type: ignore[override]
        """What isinstance says: as the functions are called, t is an int"""
        return int if self.op == "symbol" and self.args == ("t",) else np.float64

    def __repr__(self) -> str:
        if Formula.decide is not None and not self.is_constant:
            raise NoFormula(NO_TEXT)
        return str(self.args[0]) if self.op in ("constant", "symbol") else "(a formula)"

    def __format__(self, form: str) -> str:
        return format(self.value, form) if self.is_constant else str(self)

    def __hash__(self) -> int:
        if self.is_constant:
            return hash(self.value)
        raise NoFormula(NO_KEY)

    def __bool__(self) -> bool:
        if self.is_constant:
            return bool(self.value)
        if Formula.decide is None:
            raise NoFormula("a branch depends on a value")
        return Formula.decide(truth(self))

    def __float__(self) -> float:
        if self.is_constant:
            return float(self.value)
        raise NoFormula(NO_NUMBER)

    def __int__(self) -> int:
        return int(self.__float__())

    def __index__(self) -> int:
        raise NoFormula(NO_NUMBER)

    def __complex__(self) -> complex:
        if self.is_constant:
            return complex(self.value)
        raise NoFormula(COMPLEX)

    def __round__(self, digits: int = 0) -> Any:
        return named("round", self, digits)

    def __divmod__(self, other: Any) -> Any:
        return self // other, self % other

    def __rdivmod__(self, other: Any) -> Any:
        return other // self, other % self

    def __getattr__(self, name: str) -> Callable[..., Any]:
        """NumPy's loops over arrays of objects call a method of the function's name."""
        if name in NAMED and not name.startswith("_"):
            return partial(NAMED[name], self)
        raise AttributeError(f"a number of NumPy's has its {name}, a formula has not" if hasattr(np.float64, name) else
                             f"'numpy.float64' object has no attribute '{name}'")

    def item(self) -> Any:
        return self

    copy = flatten = ravel = item

    @property
    def imag(self) -> Node:
        return constant(0)

    @property
    def real(self) -> Node:
        return self

    T = real

    def astype(self, kind: Any) -> Any:
        return as_type(self, kind)


def _operator(name: str, is_reversed: bool) -> Callable[..., Any]:
    def operator(one: Node, *other: Any) -> Any:
        if other and (getattr(other[0], "ndim", 0) or not isinstance(other[0], (Node, *NUMBERS))):
            return NotImplemented  # an array's own operator takes a formula, entry by entry
        return named(name, *((*other, one) if is_reversed else (one, *other)))

    return operator


NUMBERS = (int, float, complex, np.number, np.bool_, np.ndarray)
for _name, _of in {"add": "add", "sub": "subtract", "mul": "multiply", "truediv": "divide", "pow": "power", "mod": "remainder",
                   "floordiv": "floor_divide", "and": "bitwise_and", "or": "bitwise_or", "xor": "bitwise_xor"}.items():
    setattr(Formula, f"__{_name}__", _operator(_of, False))
    setattr(Formula, f"__r{_name}__", _operator(_of, True))
for _name, _of in {"lt": "less", "le": "less_equal", "gt": "greater", "ge": "greater_equal", "eq": "equal", "ne": "not_equal",
                   "neg": "negative", "pos": "positive", "abs": "absolute", "invert": "invert", "floor": "floor",
                   "ceil": "ceil", "trunc": "trunc"}.items():
    setattr(Formula, f"__{_name}__", _operator(_of, False))


def as_type(one: Any, kind: Any) -> Any:
    """A number as one of another kind"""
    kind = np.dtype(getattr(kind, "real_type", kind))
    if kind in (np.dtype(float), np.dtype(object)):
        return value(one)
    if kind.kind in "iu":
        return named("trunc", one)
    if kind.kind == "b":
        return truth(one)
    raise NoFormula(COMPLEX if kind.kind == "c" else f"numbers of {kind} have no formula here: write float")
