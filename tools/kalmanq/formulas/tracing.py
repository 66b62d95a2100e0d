"""A user's Python function, unchanged, run on formulas: what it answers is the formula of each of its numbers.

While it runs, numpy, math and float of its module are stand-ins, and afterwards all is as it was.  An `if` on a formula is
taken both ways: the function runs once a path, and the paths are joined by selects.
"""

from __future__ import annotations

import linecache
import math
import sys
import traceback
import types
from contextlib import contextmanager
from typing import Any, Callable, Iterator, Optional, Sequence

import numpy as np

from kalmanq.errors import KalmanqError
from kalmanq.formulas.arrays import Array
from kalmanq.formulas.formula import Formula
from kalmanq.formulas.functions import COMPLEX, NoFormula, value
from kalmanq.formulas.graph import Graph, Node, compare, needed, select, symbol, using
from kalmanq.formulas.outside import Outside

PATHS = 64
MOST_OPERATIONS = 20000


class Untraced(KalmanqError):
    """FILE: line N: what of a function has no formula, and what to write in its place"""


def graph_of_formulas() -> Graph:
    return Graph(Formula)


def symbols(stem: str, count: int) -> np.ndarray:
    made = np.empty(count, object)
    made[:] = [symbol(f"{stem}{i}") for i in range(count)]
    return made.view(Array)


def traced(function: Callable[..., Any], args: Sequence[Any], graph: Graph) -> list[Node]:
    """Formulas of all that function(*args) answers, flat.  It is run twice: formulas that differ come of a function that is
    not one of its arguments alone."""
    outside = Outside(function)
    with using(graph), outside.standing_in():
        first = _Trace(function, args, graph, outside).formulas()
        second = _Trace(function, args, graph, outside).formulas()
        kept = outside.kept()
    if kept:
        raise Untraced(f"{_place(function)}: keeps {kept} between calls: a function of x, t and u alone has a formula")
    if [*map(id, first)] != [*map(id, second)]:
        raise Untraced(f"{_place(function)}: {CHANGES}")
    return first


CHANGES = ("answers differently when it is called twice: it draws random numbers, or keeps something between calls: "
           "a function of x, t and u alone has a formula")


class _Trace:
    def __init__(self, function: Callable[..., Any], args: Sequence[Any], graph: Graph, outside: Outside):
        self.function, self.args, self.graph, self.files = function, args, graph, outside.files
        self.name, self.runs = getattr(function, "__name__", "the function"), 0

    def formulas(self) -> list[Node]:
        with self._lines():
            made = self._built([])
        for one in needed(made)[0]:
            if one.is_constant and not math.isfinite(one.value):
                raise Untraced(f"{self._line_of(one)}a number that is not finite ({one.value}): an array that is not filled "
                               "(np.empty), or a division by 0 or the like of constants")
        return made

    def _line_of(self, one: Node) -> str:
        file, line = self.graph.lines.get(id(one), ("", 0))
        text = linecache.getline(file, line).strip()
        return f"{file}: line {line}: {text}: " if file else f"{_place(self.function)}: "

    def _built(self, answers: Sequence[tuple[Node, bool]]) -> list[Node]:
        """The paths that begin with these answers, joined"""
        asked, out = self._path([answer for _, answer in answers])
        if [id(one) for one, _ in asked[:len(answers)]] != [id(one) for one, _ in answers]:
            raise Untraced(f"{_place(self.function)}: {CHANGES}")
        for k in range(len(asked) - 1, len(answers) - 1, -1):
            condition, is_taken = asked[k]
            other = self._built([*asked[:k], (condition, not is_taken)])
            if len(other) != len(out):
                raise self._refused(f"answers {len(out)} numbers on one branch and {len(other)} on another")
            out = [select(condition, *((a, b) if is_taken else (b, a))) for a, b in zip(out, other)]
        return out

    def _path(self, answers: Sequence[bool]) -> tuple[list[tuple[Node, bool]], list[Node]]:
        """Conditions with their answers, True where none is given, and what comes out"""
        answered = _Answers(answers)
        self.runs += 1
        if self.runs > PATHS:
            raise self._refused(f"more than {PATHS} paths: write its branches as np.where(condition, a, b)")
        NoFormula.raised.clear()
        before, Formula.decide = Formula.decide, answered.decide
        try:
            with np.errstate(all="ignore"):
                out = self.function(*(one.copy() if isinstance(one, np.ndarray) else one for one in self.args))
            made = [value(_number(one)) for one in np.ravel(np.array(out, object))]
            if NoFormula.raised:
                raise NoFormula.raised[0]
            return answered.asked, made
        except (Exception, SystemExit) as problem:
            first = NoFormula.raised[0] if NoFormula.raised else problem
            raise self._refused(_why(first), first) from problem
        finally:
            Formula.decide = before

    def _refused(self, reason: str, problem: Optional[BaseException] = None) -> Untraced:
        if isinstance(problem, Untraced):
            return problem
        if isinstance(problem, NoFormula):
            places = problem.places
        else:
            frames = traceback.extract_tb(problem.__traceback__) if problem else []
            places = [(one.filename, one.lineno or 0) for one in reversed(frames)]
        for file, line in places:
            if file in self.files:
                return Untraced(f"{file}: line {line}: {self.name}: {linecache.getline(file, line).strip()}: {reason}")
        return Untraced(f"{_place(self.function)}: {reason}")

    @contextmanager
    def _lines(self) -> Iterator[None]:
        """Formulas are made in a line of the user's file."""
        before, self.graph.line = self.graph.line, self._line
        try:
            yield
        finally:
            self.graph.line = before

    def _line(self) -> tuple[str, int]:
        if len(self.graph.table) > MOST_OPERATIONS:
            raise NoFormula(f"takes more than {MOST_OPERATIONS} operations: give fewer rounds")
        frame: Optional[types.FrameType] = sys._getframe(2)
        while frame is not None and frame.f_code.co_filename not in self.files:
            frame = frame.f_back
        return (frame.f_code.co_filename, frame.f_lineno) if frame else ("", 0)


class _Answers:
    """What the conditions of one path are: as they are given, and True beyond.  What follows from others is not asked."""

    def __init__(self, given: Sequence[bool]):
        self.given, self.asked = given, []
        self.known: dict[int, bool] = {}

    def decide(self, condition: Node) -> bool:
        if condition.is_constant:
            return bool(condition.value)
        if condition.op == "not":
            return not self.decide(condition.args[0])
        if condition.op == "le":
            return not self.decide(compare("lt", *reversed(condition.args)))
        if id(condition) not in self.known:
            self.known[id(condition)] = self._ordered(condition) if condition.op in ("lt", "eq") else self._asked(condition)
        return self.known[id(condition)]

    def _ordered(self, condition: Node) -> bool:
        """Of a < b, b < a, a == b and b == a one is true, or the last two"""
        a, b = condition.args
        others = [compare("lt", a, b), compare("lt", b, a), compare("eq", a, b)]
        if condition.op == "eq":
            others = [*others[:2], compare("eq", b, a)]
        answers = [self.known.get(id(one)) for one in others if one is not condition]
        if condition.op == "eq" and answers[2] is not None:
            return bool(answers[2])
        if True in answers:
            return False
        return True if answers[:2] == [False, False] else self._asked(condition)

    def _asked(self, condition: Node) -> bool:
        k = len(self.asked)
        if k >= PATHS:
            raise NoFormula(f"more than {PATHS} branches on one path: a loop until a value is reached has no formula; "
                            "use a fixed number of rounds, or floor")
        self.asked.append((condition, self.given[k] if k < len(self.given) else True))
        return self.asked[k][1]


def _number(one: Any) -> Any:
    if isinstance(one, complex) or getattr(one, "dtype", np.dtype(float)).kind == "c":
        raise NoFormula(COMPLEX)
    if not isinstance(one, (Node, int, float, np.number, np.bool_)):
        raise NoFormula(f"answers {type(one).__name__}, no numbers")
    return one


def _why(problem: BaseException) -> str:
    said = " ".join(str(problem).split())
    if isinstance(problem, NoFormula):
        return said
    if isinstance(problem, (TypeError, AttributeError)) and "Formula" in said:
        return f"has no formula here ({said})"
    return f"{type(problem).__name__}: {said}" if said else type(problem).__name__


def _place(function: Callable[..., Any]) -> str:
    code = getattr(function, "__code__", None)
    name = getattr(function, "__name__", "the function")
    return f"{code.co_filename}: line {code.co_firstlineno}: {name}" if code else name
