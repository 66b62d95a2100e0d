"""NumPy's functions that look into an array for its numbers, of formulas"""

from __future__ import annotations

from itertools import permutations
from typing import Any, Callable

import numpy as np

from kalmanq.formulas.arrays import OWN, as_numbers, chosen, held, is_constant, plain
from kalmanq.formulas.functions import NAMED, NoFormula, hypot, value
from kalmanq.formulas.graph import Given, Node, add, call, compare, constant, divide, mul, node, select, sub

LARGEST = 4  # of a system of equations that is solved by formulas
Function = Callable[..., Any]


def own(*functions: Any) -> Callable[[Function], Function]:
    def register(function: Function) -> Function:
        OWN.update(dict.fromkeys(functions, function))
        return function

    return register


def _one_by_one(name: str) -> Function:
    def function(*args: Any, **options: Any) -> Any:
        options.pop("out", None)
        return np.frompyfunc(lambda *given: NAMED[name](*given, **options), len(args), 1)(*map(plain, args))

    return function


for _name in ("round", "around", "fix", "sinc", "isclose", "nan_to_num", "real"):
    OWN[getattr(np, _name)] = _one_by_one(_name)


@own(np.allclose)
def allclose(a: Any, b: Any, **options: Any) -> Any:
    return np.all(held(_one_by_one("isclose")(a, b, **options)))


@own(np.clip)
def clip(a: Any, a_min: Any = None, a_max: Any = None, **options: Any) -> Any:
    low, high = (options.get("min", a_min), options.get("max", a_max))
    return np.frompyfunc(NAMED["clip"], 3, 1)(*map(plain, (a, low, high)))


@own(np.where)
def where(condition: Any, *branches: Any) -> Any:
    if len(branches) != 2:
        raise NoFormula("where without two branches has no formula here: write np.where(condition, a, b)")
    return chosen(condition, *branches)


@own(np.select)
def select_of(conditions: Any, choices: Any, default: Any = 0) -> Any:
    made = default
    for condition, choice in reversed([*zip(conditions, choices)]):
        made = chosen(condition, choice, made)
    return made


@own(np.piecewise)
def piecewise(x: Any, conditions: Any, functions: Any, *args: Any, **options: Any) -> Any:
    conditions = conditions if isinstance(conditions, (list, tuple)) or np.ndim(conditions) > np.ndim(x) else [conditions]
    values = [one(x, *args, **options) if callable(one) else one for one in functions]
    made = values[len(conditions)] if len(values) > len(conditions) else 0.0
    for condition, choice in zip(conditions, values):  # of two that hold the later one
        made = chosen(condition, choice, made)
    return made


@own(np.interp)
def interp(x: Any, xp: Any, fp: Any, left: Any = None, right: Any = None, period: Any = None) -> Any:
    """Straight between the points, the ends' values beyond: a tree of selects"""
    if period is not None or not is_constant([xp, fp, left, right]):
        raise NoFormula("interp takes a table of numbers, without period")
    xs, ys = (np.atleast_1d(np.asarray(as_numbers(one), float)) for one in (xp, fp))
    if xs.shape != ys.shape or np.any(np.diff(xs) <= 0):
        raise NoFormula("interp takes a table of numbers whose points increase")
    ends = [float(as_numbers(one)) if one is not None else y for one, y in ((left, ys[0]), (right, ys[-1]))]
    return np.frompyfunc(lambda one: _interpolated(value(one), xs, ys, *ends), 1, 1)(plain(x))


def _interpolated(x: Node, xs: np.ndarray, ys: np.ndarray, left: float, right: float) -> Node:
    slopes = np.diff(ys) / np.diff(xs)
    pieces = [constant(left), *(add(mul(a, sub(x, at)), y) for a, at, y in zip(slopes, xs, ys)), constant(right)]

    def pick(low: int, high: int) -> Node:
        if high - low == 1:
            return pieces[low]
        middle = (low + high) // 2
        below = compare("le" if middle == len(xs) else "lt", x, xs[middle - 1])
        return select(below, pick(low, middle), pick(middle, high))

    if len(xs) == 1:
        return select(compare("lt", x, xs[0]), left, select(compare("lt", xs[0], x), right, ys[0]))
    return pick(0, len(pieces))


@own(np.linalg.norm)
def norm(x: Any, ord: Any = None, axis: Any = None, keepdims: bool = False) -> Any:
    array = np.array(x, object)
    vector = array.ndim == 1 or isinstance(axis, int)
    if ord not in (None, *((1, 2, np.inf) if vector else ("fro",))) or keepdims or not (vector or axis is None and array.ndim == 2):
        raise NoFormula("linalg.norm of this kind has no formula here: write np.sqrt(np.sum(x ** 2))")
    rows = np.moveaxis(array, axis, -1) if axis is not None and array.ndim > 1 else array.ravel()
    made = np.empty(rows.shape[:-1], object)
    for at in np.ndindex(made.shape):
        made[at] = _length([value(one) for one in rows[at]], ord)
    return made


def _length(row: list[Node], ord: Any) -> Node:
    if ord in (None, 2, "fro"):
        return hypot(*row)
    total = node(0.0)
    for one in row:
        total = add(total, call("abs", one)) if ord == 1 else NAMED["maximum"](total, call("abs", one))
    return total


def _square(given: Any) -> np.ndarray:
    a = np.array(given, object)
    if a.ndim != 2 or len(a) != a.shape[1]:
        raise NoFormula("linalg: matrices are n x n here")
    if len(a) > LARGEST:
        raise NoFormula(f"linalg: formulas are solved up to {LARGEST} x {LARGEST}: give the solution, or the matrix in numbers")
    return a


@own(np.linalg.det)
def det(given: Any) -> Any:
    """By its permutations"""
    a = _square(given)
    n, total = len(a), node(0.0)
    for order in permutations(range(n)):
        turns = sum(order[i] > order[j] for i in range(n) for j in range(i + 1, n))
        term: Given = -1.0 if turns % 2 else 1.0
        for row, column in enumerate(order):
            term = mul(term, value(a[row, column]))
        total = add(total, term)
    return total


@own(np.linalg.inv)
def inv(given: Any) -> Any:
    """By its minors"""
    if is_constant(given):
        return np.linalg.inv(as_numbers(np.array(given, object)))
    a, whole = _square(given), det(given)
    n = len(a)
    made = np.empty((n, n), object)
    for i in range(n):
        for j in range(n):
            minor = np.delete(np.delete(a, j, 0), i, 1)
            made[i, j] = divide(mul(-1.0 if (i + j) % 2 else 1.0, det(minor) if n > 1 else 1.0), whole)
    return made


@own(np.linalg.solve)
def solve(a: Any, b: Any) -> Any:
    return held(inv(a)) @ held(np.array(b, object))
