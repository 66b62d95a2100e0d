"""Formulas as a graph: equal formulas are one node, and 0, 1 and constants fold while an algorithm runs over them.

An algorithm is written with ordinary Python arithmetic.  Its numbers are nodes, and what it returns are nodes again,
from which `printing` makes C.  `fresh()` begins a graph: the C of a model does not depend on what was compiled before.
"""

from __future__ import annotations

import math
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Callable, ContextManager, Iterable, Iterator, Optional, Union

import numpy as np

Given = Union["Node", float, int]
MOST_POWER = 16


class Node:
    """An operation and its arguments.  The argument of a constant is a number, the argument of a symbol its name."""

    __slots__ = ("op", "args", "order")

    op: str
    args: tuple
    order: int

    def __add__(self, other: Given) -> Node: return add(self, other)
    def __radd__(self, other: Given) -> Node: return add(other, self)
    def __sub__(self, other: Given) -> Node: return sub(self, other)
    def __rsub__(self, other: Given) -> Node: return sub(other, self)
    def __mul__(self, other: Given) -> Node: return mul(self, other)
    def __rmul__(self, other: Given) -> Node: return mul(other, self)
    def __neg__(self) -> Node: return sub(0.0, self)
    def __lt__(self, other: Given) -> Node: return compare("lt", self, other)
    def __le__(self, other: Given) -> Node: return compare("le", self, other)

    def __repr__(self) -> str:
        return f"{self.op}{self.args}"

    @property
    def is_constant(self) -> bool:
        return self.op == "constant"

    @property
    def value(self) -> float:
        return self.args[0]

    def equals(self, number: float) -> bool:
        return self.is_constant and self.value == number


@dataclass
class Graph:
    """kind: of its nodes; line: file and line of the user's where a node is made, while his function is traced"""

    kind: type[Node] = Node
    table: dict[tuple, Node] = field(default_factory=dict)
    line: Optional[Callable[[], tuple[str, int]]] = None
    lines: dict[int, tuple[str, int]] = field(default_factory=dict)


_current = Graph()


@contextmanager
def using(graph: Graph) -> Iterator[Graph]:
    """Nodes are made in this graph."""
    global _current
    before, _current = _current, graph
    try:
        yield graph
    finally:
        _current = before


def fresh() -> ContextManager[Graph]:
    """A graph of its own: the order of nodes begins anew."""
    return using(Graph())


def make(op: str, *args: object) -> Node:
    """The node of an operation, as it is: nothing is folded."""
    key = (op, *(id(one) if isinstance(one, Node) else (type(one), one) for one in args))
    found = _current.table.get(key)
    if found is None:
        found = object.__new__(_current.kind)
        found.op, found.args, found.order = op, args, len(_current.table)
        _current.table[key] = found
        if _current.line:
            _current.lines[id(found)] = _current.line()
    return found


def constant(value: float) -> Node:
    return make("constant", 0.0 if value == 0 else math.nan if value != value else float(value))


def symbol(name: str) -> Node:
    return make("symbol", name)


def node(given: Given) -> Node:
    return given if isinstance(given, Node) else constant(float(given))


def _ordered(op: str, a: Node, b: Node) -> Node:
    return make(op, *sorted((a, b), key=lambda one: (not one.is_constant, one.order)))


def negated(a: Node) -> Union[Node, None]:
    """b, where a is -b"""
    if a.op == "sub" and a.args[0].equals(0):
        return a.args[1]
    return constant(-a.value) if a.is_constant and a.value < 0 else None


def add(one: Given, other: Given) -> Node:
    a, b = node(one), node(other)
    if a.is_constant and b.is_constant:
        return constant(a.value + b.value)
    if a.equals(0) or b.equals(0):
        return b if a.equals(0) else a
    for first, second in ((a, b), (b, a)):
        less = negated(second)
        if less is not None:
            return sub(first, less)
    return make("add", a, b)


def sub(one: Given, other: Given) -> Node:
    a, b = node(one), node(other)
    if a.is_constant and b.is_constant:
        return constant(a.value - b.value)
    if b.equals(0):
        return a
    if a is b:
        return constant(0)
    more = negated(b)
    return make("sub", a, b) if more is None else add(a, more)


def mul(one: Given, other: Given) -> Node:
    a, b = node(one), node(other)
    if a.is_constant and b.is_constant:
        return constant(a.value * b.value)
    for first, second in ((a, b), (b, a)):
        if first.equals(0) or second.equals(1):
            return first
    for first, second in ((a, b), (b, a)):
        less = negated(first)
        if less is not None:
            return sub(0.0, mul(less, second))
        if first.is_constant and second.op == "mul" and second.args[0].is_constant:
            return mul(first.value * second.args[0].value, second.args[1])
    return _ordered("mul", a, b)


def inverse(given: Given) -> Node:
    a = node(given)
    if a.op == "inverse":
        return a.args[0]
    if a.is_constant:
        return constant(_divided(1.0, a.value))
    return make("inverse", a)


def divide(one: Given, other: Given) -> Node:
    a, b = node(one), node(other)
    if a.is_constant and b.is_constant:
        return constant(_divided(a.value, b.value))
    return mul(a, inverse(b))


def _divided(a: float, b: float) -> float:
    """By 0 as NumPy does it"""
    if b:
        return a / b
    return math.copysign(math.inf, a) if a else math.nan


def power(one: Given, other: Given) -> Node:
    """A whole power is made of products."""
    a, b = node(one), node(other)
    if not b.is_constant and a.is_constant and 0 < a.value < math.inf:
        return call("exp", mul(b, math.log(a.value)))
    if not b.is_constant or a.is_constant:
        return call("pow", a, b)
    k = b.value
    if k == 0.5:
        return call("sqrt", a)
    if k < 0:
        return inverse(power(a, -k))
    if not k <= MOST_POWER or k != int(k):
        return call("pow", a, b)
    made, square, left = constant(1), a, int(k)
    while left:
        if left & 1:
            made = mul(made, square)
        square, left = mul(square, square) if left > 1 else square, left >> 1
    return made


def call(name: str, *given: Given) -> Node:
    """A function of math, by its name in C"""
    args = [node(one) for one in given]
    if not all(one.is_constant for one in args):
        return make(name, *args)
    values = [one.value for one in args]
    try:
        return constant(_NUMBERS[name](*values))
    except (ValueError, OverflowError):  # of math; NumPy has NaN or infinity there
        with np.errstate(all="ignore"):
            return constant(getattr(np, IN_NUMPY.get(name, name))(*values))


FUNCTIONS = ("sqrt", "sin", "cos", "tan", "exp", "log", "atan", "asin", "acos", "sinh", "cosh", "tanh", "atan2", "pow",
             "floor", "abs", "rint", "fmod", "log1p", "expm1", "cbrt", "asinh", "acosh", "atanh")
IN_NUMPY = {"atan": "arctan", "asin": "arcsin", "acos": "arccos", "atan2": "arctan2", "pow": "power", "asinh": "arcsinh",
            "acosh": "arccosh", "atanh": "arctanh"}
_NUMBERS = {**{name: getattr(math, name, None) or getattr(np, name) for name in FUNCTIONS}, "abs": abs}
_COMPARED = {"lt": lambda a, b: a < b, "le": lambda a, b: a <= b, "eq": lambda a, b: a == b}
CONDITIONS = ("lt", "le", "eq", "not", "and", "or")


def compare(op: str, one: Given, other: Given) -> Node:
    a, b = node(one), node(other)
    if a.is_constant and b.is_constant:
        return constant(_COMPARED[op](a.value, b.value))
    for one, sign in ((a, 1), (b, -1)):
        if one.is_constant and not math.isfinite(one.value):  # what it is compared with is finite
            return constant(op != "eq" and one.value * sign == -math.inf)
    return constant(op != "lt") if a is b else make(op, a, b)


def logic(op: str, *given: Given) -> Node:
    """not, and, or"""
    args = [node(one) for one in given]
    if op == "not":
        return constant(not args[0].value) if args[0].is_constant else make(op, *args)
    for one, other in (args, args[::-1]):
        if one.is_constant:
            return other if bool(one.value) == (op == "and") else one
    return make(op, *args)


def select(given: Given, yes: Given, no: Given) -> Node:
    """condition ? yes : no"""
    condition, first, second = node(given), node(yes), node(no)
    if condition.is_constant:
        return first if condition.value else second
    return first if first is second else make("select", condition, first, second)


def dot(pairs: Iterable[tuple[Given, Given]], start: Given = 0.0) -> Node:
    """start + the sum of products"""
    total = node(start)
    for a, b in pairs:
        total = total + node(a) * b
    return total


def needed(roots: Iterable[Node]) -> tuple[list[Node], dict[int, int]]:
    """Every node that the roots need, arguments first, and how often each is used (a root once more)"""
    order: list[Node] = []
    uses: dict[int, int] = {}
    seen: set[int] = set()
    waiting = [(root, False) for root in roots]
    for root, _ in waiting:
        uses[id(root)] = uses.get(id(root), 0) + 1
    waiting.reverse()
    while waiting:
        one, is_done = waiting.pop()
        if is_done:
            order.append(one)
            continue
        if id(one) in seen:
            continue
        seen.add(id(one))
        waiting.append((one, True))
        for argument in reversed([a for a in one.args if isinstance(a, Node)]):
            uses[id(argument)] = uses.get(id(argument), 0) + 1
            waiting.append((argument, False))
    return order, uses
