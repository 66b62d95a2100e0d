"""What stands for numpy and math in a user's module while his functions are traced.

NumPy's own functions take arrays of formulas, but for those that make arrays of floats, those that look into an array
for its numbers, and those of linalg.
"""

from __future__ import annotations

import math
import types
from itertools import permutations
from typing import Any, Callable

import numpy as np

from kalmanq.formulas.formula import NAMED, NoFormula, boxed, hypot, named
from kalmanq.formulas.graph import Given, Node, add, call, compare, constant, divide, mul, node, select, sub

MAKERS = ("zeros", "ones", "empty", "full", "eye", "identity", "diag", "zeros_like", "ones_like", "empty_like", "array",
          "asarray", "asanyarray", "ascontiguousarray", "arange", "linspace", "full_like", "atleast_1d", "atleast_2d")
LARGEST = 4  # of a system of equations that is solved by formulas


class NumPy(types.ModuleType):
    """numpy: what makes an array makes one that can hold formulas"""

    def __init__(self) -> None:
        super().__init__("numpy")
        self.linalg = Linalg()

    def __getattr__(self, name: str) -> Any:
        return stand_in_of(getattr(np, name))


class Linalg(types.ModuleType):
    def __init__(self) -> None:
        super().__init__("numpy.linalg")

    def __getattr__(self, name: str) -> Any:
        return LINALG[name] if name in LINALG else _without_formulas(getattr(np.linalg, name), f"linalg.{name}")


class Math(types.ModuleType):
    """math, of formulas, too"""

    def __init__(self) -> None:
        super().__init__("math")

    def __getattr__(self, name: str) -> Any:
        real = getattr(math, name)
        return stand_in_of(real) if callable(real) else real


def stand_in_of(real: Any) -> Any:
    """Of a function, or what was given"""
    name = getattr(real, "__name__", "")
    if getattr(math, name, None) is real:
        return _of_math(real, name)
    if name in MAKERS and getattr(np, name, None) is real:
        return _maker(real)
    return OWN.get(name, real) if getattr(np, name, None) is real else real


def _of_math(real: Callable[..., Any], name: str) -> Callable[..., Any]:
    def function(*args: Any) -> Any:
        given = [one.item() if getattr(one, "shape", None) == () and not isinstance(one, Node) else one for one in args]
        return MATH.get(name, lambda *a: named(name, *a))(*given) if any(isinstance(a, Node) for a in given) else real(*given)

    return function


def _maker(real: Callable[..., Any]) -> Callable[..., Any]:
    def make(*args: Any, **options: Any) -> Any:
        holds = any(_holds(one) for one in args)
        dtype = options.pop("dtype", None)
        made = real(*args, **options) if holds or dtype is None else real(*args, dtype=dtype, **options)
        return made.astype(object) if isinstance(made, np.ndarray) and made.dtype.kind in "fiu" else made

    return make


def _holds(given: Any) -> bool:
    """A formula in it?"""
    if isinstance(given, (list, tuple)):
        return any(map(_holds, given))
    return isinstance(given, Node) or isinstance(given, np.ndarray) and given.dtype == object


def _without_formulas(real: Any, name: str) -> Any:
    def function(*args: Any, **options: Any) -> Any:
        if any(isinstance(one, Node) for one in np.ravel(np.array(args[0], object))):
            raise NoFormula(f"{name} has no formula here")
        return real(*(_floats(one) for one in args), **options)

    return function if callable(real) and not isinstance(real, type) else real


def _floats(given: Any) -> Any:
    return given.astype(float) if isinstance(given, np.ndarray) and given.dtype == object else given


def interp(x: Any, xs: Any, ys: Any, *rest: Any, **options: Any) -> Any:
    """Straight between the points, the ends' values beyond: a tree of selects"""
    if isinstance(x, np.ndarray) and x.ndim:
        return np.array([interp(one, xs, ys, *rest, **options) for one in x.ravel()], object).reshape(x.shape)
    if not isinstance(x, Node):
        return np.interp(x, _floats(np.asarray(xs)), _floats(np.asarray(ys)), *rest, **options)
    if rest or options or _holds(np.asarray(xs)) and any(isinstance(one, Node) for one in (*xs, *ys)):
        raise NoFormula("interp takes a table of numbers, without left, right and period")
    xs, ys = np.asarray(xs, float), np.asarray(ys, float)
    if len(xs) < 2:
        return constant(ys[0])
    slopes = np.diff(ys) / np.diff(xs)
    pieces = [constant(ys[0]), *(add(mul(a, sub(x, at)), y) for a, at, y in zip(slopes, xs, ys)), constant(ys[-1])]

    def pick(low: int, high: int) -> Node:
        if high - low == 1:
            return pieces[low]
        middle = (low + high) // 2
        return select(compare("lt", x, xs[middle - 1]), pick(low, middle), pick(middle, high))

    return pick(0, len(pieces))


def where(condition: Any, *branches: Any) -> Any:
    if len(branches) != 2:
        raise NoFormula("where without two branches has no formula")
    entries = np.broadcast(*(boxed(one) for one in (condition, *branches)))
    made = np.empty(entries.shape, object)
    made.ravel()[:] = [select(c, a, b) for c, a, b in entries]
    return made if made.ndim else made.item()


def clip(a: Any, a_min: Any = None, a_max: Any = None) -> Any:
    return np.array([NAMED["clip"](one, a_min, a_max) for one in np.ravel(boxed(a))], object).reshape(np.shape(boxed(a))) \
        if not isinstance(a, Node) else NAMED["clip"](a, a_min, a_max)


def norm(given: Any, ord: Any = None, axis: Any = None) -> Any:
    array = np.array(given, object)
    if ord not in (None, 2) or axis is not None or array.ndim != 1:
        raise NoFormula("linalg.norm is of one vector, ord 2, here")
    return hypot(*array)


def det(given: Any) -> Any:
    """By its permutations"""
    a, n = np.array(given, object), len(given)
    if n > LARGEST:
        raise NoFormula(f"linalg: formulas are solved up to {LARGEST} x {LARGEST}")
    total: Given = 0.0
    for order in permutations(range(n)):
        turns = sum(order[i] > order[j] for i in range(n) for j in range(i + 1, n))
        term: Given = -1.0 if turns % 2 else 1.0
        for row, column in enumerate(order):
            term = mul(term, a[row, column])
        total = add(total, term)
    return total


def inv(given: Any) -> Any:
    """By its minors"""
    a, n = np.array(given, object), len(given)
    whole = det(a)
    made = np.empty((n, n), object)
    for i in range(n):
        for j in range(n):
            minor = np.delete(np.delete(a, j, 0), i, 1)
            made[i, j] = divide(mul(-1.0 if (i + j) % 2 else 1.0, det(minor) if n > 1 else 1.0), whole)
    return made


def solve(a: Any, b: Any) -> Any:
    return inv(a) @ np.array(b, object)


def as_float(given: Any = 0.0) -> Any:
    """float(formula) is the formula."""
    return given if isinstance(given, Node) else float(given)


OWN: dict[str, Callable[..., Any]] = {"interp": interp, "where": where, "clip": clip}
LINALG: dict[str, Callable[..., Any]] = {"norm": norm, "det": det, "inv": inv, "solve": solve}
MATH: dict[str, Callable[..., Any]] = {
    "remainder": lambda a, b: sub(a, mul(b, NAMED["rint"](divide(a, b)))),
    "dist": lambda p, q: hypot(*(sub(a, b) for a, b in zip(p, q)))}
