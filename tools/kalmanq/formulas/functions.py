"""What NumPy's and math's functions of numbers are, as formulas: by their names."""

from __future__ import annotations

import math
import sys
import types
from typing import Any, Callable, Optional

import numpy as np

from kalmanq.formulas.graph import (CONDITIONS, FUNCTIONS, IN_NUMPY, Given, Node, add, call, compare, constant, divide, inverse,
                                    logic, mul, node, power, select, sub)

COMPLEX = "complex numbers have no formula here: write real and imaginary parts"


class NoFormula(Exception):
    """What is done has none.

    raised  every one, so that an `except` of the user's hides none
    places  files and lines that led there, the innermost first
    """

    raised: list[NoFormula] = []

    def __init__(self, reason: str):
        super().__init__(reason)
        NoFormula.raised.append(self)
        self.places: list[tuple[str, int]] = []
        frame: Optional[types.FrameType] = sys._getframe(1)
        while frame is not None:
            self.places.append((frame.f_code.co_filename, frame.f_lineno))
            frame = frame.f_back


def value(given: Any) -> Node:
    """A number; a comparison is 1 or 0."""
    if isinstance(given, np.ndarray) and given.ndim == 0:
        given = given[()]
    if isinstance(given, Node):
        return select(given, 1.0, 0.0) if given.op in CONDITIONS else given
    if isinstance(given, (complex, np.complexfloating)):
        raise NoFormula(COMPLEX)
    return node(given)


def truth(given: Any) -> Node:
    """Of a number: is it not 0?"""
    if isinstance(given, Node) and given.op in CONDITIONS:
        return given
    return logic("not", compare("eq", value(given), 0.0))


def bit(given: Any) -> Node:
    """A comparison"""
    if isinstance(given, (bool, np.bool_)) and not isinstance(given, Node):
        return constant(bool(given))
    if isinstance(given, Node) and (given.op in CONDITIONS or given.is_constant and given.value in (0, 1)):
        return given
    raise NoFormula("bits of a number (&, |, ^, ~) have no formula here: write % and //, or and, or, not")


def is_comparison(given: Any) -> bool:
    return given.op in CONDITIONS if isinstance(given, Node) else isinstance(given, (bool, np.bool_))


def both(a: Any, b: Any) -> Node:
    """a + b"""
    if is_comparison(a) and is_comparison(b):
        raise NoFormula("a sum of two comparisons is True or 2, as Python or NumPy has it: write np.logical_or, or np.where of each")
    return add(value(a), value(b))


def times(a: Any, b: Any) -> Node:
    """a b; of two comparisons a comparison"""
    return logic("and", a, b) if is_comparison(a) and is_comparison(b) else mul(value(a), value(b))


def remainder(a: Given, b: Given) -> Node:
    """Of the sign of b"""
    rest, divisor = call("fmod", a, b), node(b)
    if divisor.is_constant:
        below = compare("lt", rest, 0.0) if divisor.value > 0 else compare("lt", 0.0, rest)
    else:
        below = compare("lt", mul(rest, divisor), 0.0)
    return select(below, add(rest, divisor), rest)


def floor_divided(a: Given, b: Given) -> Node:
    return call("rint", divide(sub(a, remainder(a, b)), b))


def hypot(*given: Given) -> Node:
    total = node(0.0)
    for one in given:
        total = add(total, mul(one, one))
    return call("sqrt", total)


def lesser(a: Given, b: Given) -> Node:
    return select(compare("lt", b, a), b, a)


def greater(a: Given, b: Given) -> Node:
    return select(compare("lt", a, b), b, a)


def clipped(a: Any, low: Any = None, high: Any = None) -> Node:
    made = value(a) if low is None else greater(value(a), value(low))
    return made if high is None else lesser(made, value(high))


def upward(a: Given) -> Node:
    return sub(0.0, call("floor", sub(0.0, a)))


def toward_zero(a: Given) -> Node:
    return select(compare("lt", a, 0.0), upward(a), call("floor", a))


def rounded(a: Any, digits: Any = 0) -> Node:
    """The nearest, of two that are equally near the even one; as NumPy does it, digits after the point are by a power of 10"""
    scale = 10.0 ** abs(int(digits or 0))
    if not digits:
        return call("rint", value(a))
    one, other = (mul, divide) if digits > 0 else (divide, mul)
    return other(call("rint", one(value(a), scale)), scale)


def sinc(a: Given) -> Node:
    turned = mul(math.pi, a)
    return select(compare("eq", a, 0.0), 1.0, divide(call("sin", turned), turned))


def sign(a: Given) -> Node:
    return select(compare("lt", a, 0.0), -1.0, select(compare("lt", 0.0, a), 1.0, 0.0))


def with_sign(a: Given, b: Given) -> Node:
    return mul(call("abs", a), select(compare("lt", b, 0.0), -1.0, 1.0))


def logarithm(a: Given, base: Optional[Given] = None) -> Node:
    return call("log", a) if base is None else divide(call("log", a), call("log", base))


def near(a: Any, b: Any, rtol: Any = 1e-5, atol: Any = 1e-8, equal_nan: bool = False) -> Node:
    """numpy.isclose"""
    return compare("le", call("abs", sub(value(a), value(b))), add(atol, mul(rtol, call("abs", value(b)))))


def near_in_math(a: Any, b: Any, *, rel_tol: float = 1e-9, abs_tol: float = 0.0) -> Node:
    larger = greater(call("abs", value(a)), call("abs", value(b)))
    return compare("le", call("abs", sub(value(a), value(b))), greater(mul(rel_tol, larger), abs_tol))


def _scaled(scale: float) -> Callable[[Given], Node]:
    return lambda a: mul(a, scale)


def _called(name: str) -> Callable[..., Node]:
    return lambda *given: call(name, *given)


_OF_NUMBERS: dict[str, Callable[..., Node]] = {
    **{IN_NUMPY.get(name, name): _called(name) for name in FUNCTIONS}, **{name: _called(name) for name in FUNCTIONS},
    "log": logarithm, "log2": lambda a: logarithm(a, 2.0), "log10": lambda a: logarithm(a, 10.0),
    "exp2": lambda a: power(2.0, a), "hypot": hypot, "sinc": sinc, "absolute": _called("abs"), "fabs": _called("abs"),
    "square": lambda a: mul(a, a), "negative": lambda a: sub(0.0, a), "positive": lambda a: a, "reciprocal": inverse,
    "conjugate": lambda a: a, "conj": lambda a: a, "real": lambda a: a, "nan_to_num": lambda a: a, "maximum": greater,
    "minimum": lesser, "fmax": greater, "fmin": lesser, "sign": sign, "copysign": with_sign,
    "heaviside": lambda a, half: select(compare("lt", a, 0.0), 0.0, select(compare("lt", 0.0, a), 1.0, half)),
    "degrees": _scaled(180 / math.pi), "rad2deg": _scaled(180 / math.pi), "radians": _scaled(math.pi / 180),
    "deg2rad": _scaled(math.pi / 180), "ceil": upward, "trunc": toward_zero, "fix": toward_zero, "subtract": sub,
    "divide": divide, "true_divide": divide, "floor_divide": floor_divided, "power": power, "pow": power,
    "float_power": power, "remainder": remainder, "mod": remainder, "less": lambda a, b: compare("lt", a, b),
    "greater": lambda a, b: compare("lt", b, a), "less_equal": lambda a, b: compare("le", a, b),
    "greater_equal": lambda a, b: compare("le", b, a), "equal": lambda a, b: compare("eq", a, b),
    "not_equal": lambda a, b: logic("not", compare("eq", a, b)),
    "isfinite": lambda a: constant(1), "isnan": lambda a: constant(0), "isinf": lambda a: constant(0),
}


def _of_numbers(function: Callable[..., Node]) -> Callable[..., Node]:
    return lambda *given: function(*map(value, given))


def _logic(name: str, of: Callable[[Any], Node]) -> Callable[..., Node]:
    return lambda *given: logic(name, *map(of, given))


def _unlike(of: Callable[[Any], Node]) -> Callable[..., Node]:
    return lambda a, b: logic("not", compare("eq", value(of(a)), value(of(b))))


NAMED: dict[str, Callable[..., Any]] = {
    **{name: _of_numbers(function) for name, function in _OF_NUMBERS.items()}, "add": both, "multiply": times, "clip": clipped,
    "round": rounded, "around": rounded, "isclose": near,
    **{f"logical_{name}": _logic(name, truth) for name in ("and", "or", "not")}, "logical_xor": _unlike(truth),
    **{f"bitwise_{name}": _logic(name, bit) for name in ("and", "or")}, "invert": _logic("not", bit), "bitwise_xor": _unlike(bit)}
CONDITIONAL = ("less", "greater", "less_equal", "greater_equal", "equal", "not_equal", "logical_and", "logical_or",
               "logical_not", "logical_xor", "isfinite", "isnan", "isinf", "isclose", "bitwise_and", "bitwise_or",
               "bitwise_xor", "invert")


def named(name: str, *given: Any) -> Any:
    """What NumPy's or math's function of this name answers"""
    if name not in NAMED:
        raise NoFormula(f"{name} has no formula here")
    return NAMED[name](*given)
