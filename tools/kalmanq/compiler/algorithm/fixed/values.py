"""Formulas before they are in fixed point: of functions that it has, and how large their values are in records."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Callable, Mapping, NamedTuple, Sequence

import numpy as np

from kalmanq.formulas.calculus import Memo, remade
from kalmanq.formulas.graph import Node, add, call, compare, constant, inverse, mul, needed, select, sub
from kalmanq.formulas.program import Program

MARGIN = 2  # bits of a word that no record has used
WORD_BITS, FINEST = 30, 90
Values = Mapping[str, np.ndarray]
Guard = tuple[tuple[int, bool], ...]  # conditions, by id, and their answers


@dataclass(frozen=True)
class Seen:
    """before: symbols of predicts, at: of updates, by name, an array each; NaN: not measured"""

    before: Values
    at: Values
    rows: int
    ends: Sequence[str] = ()  # what has two ends, and is anywhere between them in half of the points

    def largest(self, stem: str, k: int) -> float:
        both = [values[f"{stem}{k}"] for values in (self.before, self.at) if f"{stem}{k}" in values]
        return max(float(np.nanmax(np.abs(one), initial=0.0)) for one in both)


class Number(NamedTuple):
    """text: of a word or a wide number with |text| <= bound, in C and in Python"""

    text: str
    fraction: int
    bound: int


def _power(a: Node, b: Node) -> Node:
    return select(compare("eq", a, 0.0), 0.0, call("exp", mul(b, call("log", a))))


def _odd(of: Callable[[Node], Node], a: Node) -> Node:
    """By its values of |a|"""
    made = of(call("abs", a))
    return select(compare("lt", a, 0.0), sub(0.0, made), made)


def _rises(a: Node) -> Node:
    """tanh of a >= 0"""
    left = call("exp", mul(-2.0, a))
    return mul(sub(1.0, left), inverse(add(1.0, left)))


def _rest(a: Node) -> Node:
    """sqrt(1 - a a)"""
    return call("sqrt", sub(1.0, mul(a, a)))


MADE: dict[str, Callable[..., Node]] = {
    "tan": lambda a: mul(call("sin", a), inverse(call("cos", a))), "atan": lambda a: call("atan2", a, 1.0),
    "asin": lambda a: call("atan2", a, _rest(a)), "acos": lambda a: call("atan2", _rest(a), a), "pow": _power,
    "sinh": lambda a: mul(0.5, sub(call("exp", a), call("exp", sub(0.0, a)))),
    "cosh": lambda a: mul(0.5, add(call("exp", a), call("exp", sub(0.0, a)))),
    "tanh": lambda a: _odd(_rises, a),
    "log1p": lambda a: call("log", add(1.0, a)), "expm1": lambda a: sub(call("exp", a), 1.0),
    "cbrt": lambda a: _odd(lambda size: _power(size, constant(1 / 3)), a),
    "asinh": lambda a: _odd(lambda size: call("log", add(size, call("sqrt", add(mul(a, a), 1.0)))), a),
    "acosh": lambda a: call("log", add(a, call("sqrt", sub(mul(a, a), 1.0)))),
    "atanh": lambda a: mul(0.5, sub(call("log", add(1.0, a)), call("log", sub(1.0, a))))}


def lowered(roots: Sequence[Node]) -> list[Node]:
    """Of functions that functions.py has"""
    memo: Memo = {}
    for one in needed(roots)[0]:
        args = [memo[id(a)] for a in one.args] if one.op not in ("constant", "symbol") else []
        memo[id(one)] = one if not args else MADE[one.op](*args) if one.op in MADE else _one_quotient(remade(one.op, args))
    return [memo[id(one)] for one in roots]


def _one_quotient(one: Node) -> Node:
    """1 / a 1 / b is 1 / (a b): a word of 1 / a is coarse where a is large"""
    if one.op == "mul" and all(a.op == "inverse" for a in one.args):
        return inverse(mul(one.args[0].args[0], one.args[1].args[0]))
    return one


# ------------------------------------------------------------------------------ values in records


def guards(roots: Sequence[Node]) -> dict[int, Guard]:
    """The answers that a formula is needed with"""
    made: dict[int, Guard] = {id(one): () for one in roots}

    def needs(one: Node, guard: Guard) -> None:
        before = made.get(id(one))
        if before is not None:
            same = [a == b for a, b in zip(before, guard)]
            guard = before[:(same + [False]).index(False)]
        made[id(one)] = guard

    for one in reversed(needed(roots)[0]):
        guard = made[id(one)]
        for k, a in enumerate(one.args if one.op not in ("constant", "symbol") else ()):
            needs(a, guard if one.op != "select" or not k else (*guard, (id(one.args[0]), k == 1)))
    return made


def largest(roots: Sequence[Node], given: Mapping[str, np.ndarray]) -> dict[int, float]:
    """Of |values| by id, where the formula is needed; 0: never, or always 0"""
    program, guard = Program(roots), guards(roots)
    values = dict(zip(map(id, program.order), program.every(given, np.asarray)))
    made = {}
    for one in program.order:
        value = np.abs(np.asarray(values[id(one)], float))
        for condition, answer in guard[id(one)]:
            value = np.where(np.asarray(values[condition], bool) == answer, value, 0.0)
        made[id(one)] = float(np.max(np.where(np.isfinite(value), value, 0.0), initial=0.0))
    return made


def fraction_for(most: float, bits: int = WORD_BITS - MARGIN) -> int:
    """The most fraction bits with which so many bits hold it"""
    return min(bits - math.frexp(most)[1], FINEST) if most > 0 else bits


def constant_word(value: float, bits: int = 31, whole: bool = False) -> Number:
    """A number of so many bits, without zeros at its end unless `whole`"""
    if value == 0:
        return Number("0", 0, 0)
    fraction = bits - math.frexp(abs(value))[1]
    word = round(math.ldexp(value, fraction))
    if abs(word) >> bits:
        word, fraction = word // 2, fraction - 1
    while word % 2 == 0 and not whole:
        word, fraction = word // 2, fraction - 1
    return Number(str(word), fraction, abs(word))
