"""A number that is a formula: what Python and NumPy do with numbers, they do with it."""

from __future__ import annotations

import math
from typing import Any, Callable, Optional

import numpy as np

from kalmanq.formulas import graph
from kalmanq.formulas.graph import FUNCTIONS, Given, Node, add, call, compare, divide, inverse, logic, mul, node, power, select, sub


class NoFormula(Exception):
    """What is done has none."""


NO_NUMBER = ("wants a number where there is a formula (float, int, an index, an array of floats); of a table there is "
             "np.interp")


class Formula(Node):
    """decide: answers `if condition` while a function is traced"""

    __slots__ = ()
    __array_priority__ = 1000.0
    decide: Optional[Callable[[Node], bool]] = None

    def __truediv__(self, other: Given) -> Node: return divide(self, other)
    def __rtruediv__(self, other: Given) -> Node: return divide(other, self)
    def __pow__(self, other: Given) -> Node: return power(self, other)
    def __rpow__(self, other: Given) -> Node: return power(other, self)
    def __pos__(self) -> Node: return self
    def __abs__(self) -> Node: return call("abs", self)
    def __floordiv__(self, other: Given) -> Node: return call("floor", divide(self, other))
    def __rfloordiv__(self, other: Given) -> Node: return call("floor", divide(other, self))
    def __mod__(self, other: Given) -> Node: return remainder(self, other)
    def __rmod__(self, other: Given) -> Node: return remainder(other, self)
    def __gt__(self, other: Given) -> Node: return compare("lt", other, self)
    def __ge__(self, other: Given) -> Node: return compare("le", other, self)
    def __eq__(self, other: object) -> Any: return compare("eq", self, other)
    def __ne__(self, other: object) -> Any: return logic("not", compare("eq", self, other))
    def __and__(self, other: Given) -> Node: return logic("and", self, other)
    def __rand__(self, other: Given) -> Node: return logic("and", other, self)
    def __or__(self, other: Given) -> Node: return logic("or", self, other)
    def __ror__(self, other: Given) -> Node: return logic("or", other, self)
    def __invert__(self) -> Node: return logic("not", self)
    def __round__(self, *digits: int) -> Node: return _rounded(self, *digits)
    def __floor__(self) -> Node: return call("floor", self)
    def __ceil__(self) -> Node: return _upward(self)
    def __trunc__(self) -> Node: return _toward_zero(self)
    def __hash__(self) -> int: return id(self)

    def __bool__(self) -> bool:
        if self.is_constant:
            return bool(self.value)
        if Formula.decide is None:
            raise NoFormula("a branch depends on a value")
        return Formula.decide(self)

    def __float__(self) -> float:
        if self.is_constant:
            return float(self.value)
        raise NoFormula(NO_NUMBER)

    def __int__(self) -> int:
        return int(self.__float__())

    def __index__(self) -> int:
        raise NoFormula(NO_NUMBER)

    def __complex__(self) -> complex:
        raise NoFormula("complex numbers have no formula here")

    def conjugate(self) -> Node:
        return self

    @property
    def real(self) -> Node:
        return self

    @property
    def imag(self) -> Node:
        return graph.constant(0)

    def __getattr__(self, name: str) -> Callable[..., Any]:
        """NumPy's loops over arrays of objects call a method of the function's name."""
        if name in NAMED:
            return lambda *others: NAMED[name](self, *others)
        raise AttributeError(name)

    def __array_ufunc__(self, ufunc: Any, method: str, *given: Any, **options: Any) -> Any:
        if method != "__call__" or any(value is not None for key, value in options.items() if key != "out"):
            return NotImplemented
        if any(isinstance(one, np.ndarray) and one.ndim for one in given):
            return getattr(ufunc, method)(*map(boxed, given), **options)
        made = named(ufunc.__name__, *(one.item() if isinstance(one, (np.ndarray, np.generic)) else one for one in given))
        if "out" not in options:
            return made
        options["out"][0][...] = made
        return options["out"][0]

    def __array_function__(self, function: Any, types: Any, args: Any, options: Any) -> Any:
        return function(*map(boxed, args), **options)


def _leaves_arrays(operator: Callable[..., Any]) -> Callable[..., Any]:
    """An array's own operator takes a formula, entry by entry."""
    return lambda one, *other: NotImplemented if other and getattr(other[0], "ndim", 0) else operator(one, *other)


for _name in "add sub mul truediv pow floordiv mod lt gt le ge eq ne and or".split():
    for _full in (f"__{_name}__", f"__r{_name}__"):
        if hasattr(Formula, _full):
            setattr(Formula, _full, _leaves_arrays(getattr(Formula, _full)))


def boxed(one: Any) -> Any:
    """A formula as an array of objects, so that NumPy's own loops take it"""
    if not isinstance(one, Node):
        return one
    box = np.empty((), object)
    box[()] = one
    return box


def named(name: str, *given: Any) -> Any:
    """What NumPy's or math's function of this name answers"""
    if name not in NAMED:
        raise NoFormula(f"{name} has no formula here")
    return NAMED[name](*given)


def remainder(a: Given, b: Given) -> Node:
    return sub(a, mul(b, call("floor", divide(a, b))))


def _truncated_remainder(a: Given, b: Given) -> Node:
    """As C's fmod: of the sign of a"""
    return sub(a, mul(b, _toward_zero(divide(a, b))))


def hypot(*given: Given) -> Node:
    total = node(0.0)
    for one in given:
        total = add(total, mul(one, one))
    return call("sqrt", total)


def _lesser(a: Given, b: Given) -> Node:
    return select(compare("lt", a, b), a, b)


def _greater(a: Given, b: Given) -> Node:
    return select(compare("lt", a, b), b, a)


def _clipped(a: Given, low: Given, high: Given) -> Node:
    made = a if low is None else _greater(a, low)
    return node(made if high is None else _lesser(made, high))


def _upward(a: Given) -> Node:
    return sub(0.0, call("floor", sub(0.0, a)))


def _toward_zero(a: Given) -> Node:
    return select(compare("lt", a, 0.0), _upward(a), call("floor", a))


def _rounded(a: Given, digits: int = 0) -> Node:
    """The nearest: of two that are equally near, the upper one"""
    if digits:
        raise NoFormula("round to digits has no formula here")
    return call("floor", add(a, 0.5))


def _sinc(a: Given) -> Node:
    turned = mul(math.pi, a)
    return select(compare("eq", a, 0.0), 1.0, divide(call("sin", turned), turned))


def _sign(a: Given) -> Node:
    return select(compare("lt", a, 0.0), -1.0, select(compare("lt", 0.0, a), 1.0, 0.0))


def _scaled(scale: float) -> Callable[[Given], Node]:
    return lambda a: mul(a, scale)


def _logarithm(a: Given, base: Optional[float] = None) -> Node:
    return call("log", a) if base is None else mul(call("log", a), 1 / math.log(base))


NAMED: dict[str, Callable[..., Any]] = {
    **{name: (lambda *given, name=name: call(name, *given)) for name in FUNCTIONS if name not in ("log", "pow")},
    **{f"arc{name[1:]}": (lambda *given, name=name: call(name, *given)) for name in ("atan", "asin", "acos", "atan2")},
    "log": _logarithm, "log1p": lambda a: call("log", add(1.0, a)), "log2": lambda a: _logarithm(a, 2.0),
    "log10": lambda a: _logarithm(a, 10.0), "exp2": lambda a: call("exp", mul(a, math.log(2))),
    "expm1": lambda a: sub(call("exp", a), 1.0), "cbrt": lambda a: power(a, 1 / 3), "hypot": hypot, "sinc": _sinc,
    "absolute": lambda a: call("abs", a), "fabs": lambda a: call("abs", a), "square": lambda a: mul(a, a),
    "negative": lambda a: sub(0.0, a), "positive": lambda a: a, "reciprocal": inverse, "conjugate": lambda a: a,
    "maximum": _greater, "minimum": _lesser, "fmax": _greater, "fmin": _lesser, "clip": _clipped, "sign": _sign,
    "copysign": lambda a, b: mul(call("abs", a), select(compare("lt", b, 0.0), -1.0, 1.0)),
    "heaviside": lambda a, half: select(compare("lt", a, 0.0), 0.0, select(compare("lt", 0.0, a), 1.0, half)),
    "degrees": _scaled(180 / math.pi), "rad2deg": _scaled(180 / math.pi), "radians": _scaled(math.pi / 180),
    "deg2rad": _scaled(math.pi / 180), "ceil": _upward, "trunc": _toward_zero, "fix": _toward_zero, "rint": _rounded,
    "round": _rounded, "add": add, "subtract": sub, "multiply": mul, "matmul": mul, "divide": divide,
    "true_divide": divide, "floor_divide": lambda a, b: call("floor", divide(a, b)), "power": power, "pow": power,
    "float_power": power, "remainder": remainder, "mod": remainder,
    "fmod": _truncated_remainder, "less": lambda a, b: compare("lt", a, b),
    "greater": lambda a, b: compare("lt", b, a), "less_equal": lambda a, b: compare("le", a, b),
    "greater_equal": lambda a, b: compare("le", b, a), "equal": lambda a, b: compare("eq", a, b),
    "not_equal": lambda a, b: logic("not", compare("eq", a, b)), "logical_and": lambda a, b: logic("and", a, b),
    "logical_or": lambda a, b: logic("or", a, b), "logical_not": lambda a: logic("not", a),
    "isfinite": lambda a: True, "isnan": lambda a: False, "isinf": lambda a: False,
}
