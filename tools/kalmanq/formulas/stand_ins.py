"""What stands for numpy, math and some of Python's own functions in a user's module while his functions are traced.

NumPy's functions take arrays of formulas; a stand-in makes an array of what is a list, and lets an array of numbers hold
formulas.
"""

from __future__ import annotations

import builtins
import functools
import math
import types
from typing import Any, Callable

import numpy as np

from kalmanq.formulas import numpy_functions  # noqa: F401  its functions are known by it
from kalmanq.formulas.arrays import OWN, as_numbers, dispatched, held, is_constant, plain
from kalmanq.formulas.formula import as_type
from kalmanq.formulas.functions import NAMED, NoFormula, greater, hypot, lesser, named, near_in_math, value
from kalmanq.formulas.graph import Node, add, call, divide, mul, sub

OF_A_SEQUENCE = ("concatenate", "stack", "hstack", "vstack", "column_stack", "dstack", "block", "select", "piecewise")
MAKERS = ("array", "asarray", "asanyarray", "ascontiguousarray")


class StandIn:
    """A function of NumPy's"""

    def __init__(self, real: Any):
        self.real, self.name = real, getattr(real, "__name__", "")
        functools.update_wrapper(self, real, updated=())

    def __call__(self, *args: Any, **options: Any) -> Any:
        kinds = [one for one in args[1:] if _is_kind(one)] if holds(args) or self.name in MAKERS else []
        kind = options.pop("dtype", kinds[0] if kinds else None)
        args = tuple(_taken(one, self.name) for one in args if not any(one is other for other in kinds))
        options = {key: _taken(one, self.name) for key, one in options.items()}
        if not holds([args, *options.values()]):
            made = self.real(*args, **options, **({} if kind is None else {"dtype": _real(kind)}))
            return held(np.full_like(made, np.nan) if self.name in ("empty", "empty_like") and made.dtype.kind == "f" else made)
        made = held(dispatched(self.real, args, options) if self.real in OWN else self.real(*args, **options))
        is_same = kind is None or self.name.startswith("as") and np.dtype(_real(kind)) == float
        if is_same or not isinstance(made, np.ndarray):
            return made
        return held(as_numbers(made).astype(_real(kind))) if is_constant(made) else made.astype(kind)

    def __getattr__(self, name: str) -> Any:
        found = getattr(self.real, name)
        return StandIn(found) if callable(found) else found


def _is_kind(one: Any) -> bool:
    return isinstance(one, (type, np.dtype))


def _real(kind: Any) -> Any:
    return getattr(kind, "real_type", kind)


def holds(given: Any) -> bool:
    """A formula in it?"""
    if isinstance(given, (list, tuple)):
        return any(map(holds, given))
    return isinstance(given, Node) or isinstance(given, np.ndarray) and given.dtype == object


def _taken(given: Any, name: str) -> Any:
    if isinstance(given, np.ndarray) and given.dtype == object:
        return held(given)
    if not isinstance(given, (list, tuple)) or not holds(given):
        return _real(given)
    if name in OF_A_SEQUENCE:
        return [_taken(one, name if name == "block" else "") if isinstance(one, (list, tuple, np.ndarray)) else one for one in given]
    return held(np.array([plain(one) if isinstance(one, np.ndarray) else one for one in given], object))


class Module(types.ModuleType):
    def __init__(self, real: types.ModuleType):
        super().__init__(real.__name__)
        self._real = real

    def __getattr__(self, name: str) -> Any:
        return stand_in_of(getattr(self._real, name))


def stand_in_of(real: Any) -> Any:
    """Of a module or a function, or what was given"""
    if isinstance(real, types.ModuleType):
        return Module(real) if real in (np, math, np.linalg) else real
    if isinstance(real, (type, StandIn)) or not callable(real):
        return real
    if hasattr(real, "cache_clear") and hasattr(real, "__wrapped__"):  # a cache would keep what one path answers
        return real.__wrapped__
    name, home = getattr(real, "__name__", ""), getattr(real, "__module__", None) or ""
    if getattr(math, name, None) is real:
        return _of_math(real, name)
    is_numpys = isinstance(real, np.ufunc) or home.split(".")[0] == "numpy"
    return StandIn(real) if is_numpys and (isinstance(real, np.ufunc) or hasattr(real, "__name__")) else real


def _of_math(real: Callable[..., Any], name: str) -> Callable[..., Any]:
    def function(*args: Any, **options: Any) -> Any:
        given = [one.item() if isinstance(one, np.ndarray) and one.size == 1 else one for one in args]
        if not holds(given):
            return real(*given, **options)
        if name in MATH:
            return MATH[name](*given, **options)
        return real(*as_numbers(given), **options) if is_constant(given) else named(name, *given, **options)

    return function


def _sum(given: Any) -> Node:
    return functools.reduce(add, map(value, given), value(0.0))


MATH: dict[str, Callable[..., Any]] = {
    "remainder": lambda a, b: sub(a, mul(b, call("rint", divide(a, b)))), "fsum": _sum, "isclose": near_in_math,
    "dist": lambda p, q: hypot(*(sub(a, b) for a, b in zip(p, q))),
    "sumprod": lambda p, q: _sum(mul(a, b) for a, b in zip(p, q)),
    "prod": lambda given, start=1: functools.reduce(mul, map(value, given), value(start)),
    "modf": lambda a: (NAMED["fmod"](a, 1.0), NAMED["trunc"](a))}


class _Like(type):
    def __instancecheck__(cls, one: Any) -> bool:
        return isinstance(one, cls.real_type)

    def __subclasscheck__(cls, one: type) -> bool:
        return issubclass(one, cls.real_type)


class Float(float, metaclass=_Like):
    """float(formula) is the formula."""

    real_type = float

    def __new__(cls, *given: Any) -> Any:
        return _converted(float, given)


class Int(int, metaclass=_Like):
    """int(formula) is the formula, cut."""

    real_type = int

    def __new__(cls, *given: Any, **options: Any) -> Any:
        return int(*given, **options) if options else _converted(int, given)


def _converted(kind: type, given: Any) -> Any:
    one = given[0].item() if given and isinstance(given[0], np.ndarray) and given[0].size == 1 else given[0] if given else 0
    return as_type(one, kind) if isinstance(one, Node) and not one.is_constant else kind(*given)


def _extreme(real: Callable[..., Any], pick: Callable[[Any, Any], Node]) -> Callable[..., Any]:
    def function(*given: Any, **options: Any) -> Any:
        several = list(given[0]) if len(given) == 1 else given
        if options or not any(isinstance(one, Node) for one in several):
            return real(*([several] if len(given) == 1 else given), **options)
        if not all(isinstance(one, (Node, int, float)) for one in several):
            raise NoFormula(f"{real.__name__} of arrays has no formula here: write np.{real.__name__}imum")
        return functools.reduce(pick, map(value, several))

    return function


def _printed(*given: Any, **options: Any) -> None:
    """print, of which nothing is to be seen"""


BUILTINS = {"print": _printed, "float": Float, "int": Int, "max": _extreme(builtins.max, greater), "min": _extreme(builtins.min, lesser)}
