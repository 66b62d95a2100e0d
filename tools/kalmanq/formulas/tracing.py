"""A user's Python function, unchanged, run on formulas: what it answers is the formula of each of its numbers.

While it runs, numpy, math and float of its module are stand-ins.  An `if` on a formula is taken both ways: the function
runs once a path, and the paths are joined by selects.
"""

from __future__ import annotations

import builtins
import sys
import traceback
import types
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Callable, Iterator, Optional, Sequence

import math
import numpy as np

from kalmanq.errors import KalmanqError
from kalmanq.formulas.formula import Formula, NoFormula
from kalmanq.formulas.graph import Graph, Node, node, select, symbol, using
from kalmanq.formulas.stand_ins import Math, NumPy, as_float, stand_in_of

PATHS = 64
MOST_OPERATIONS = 20000


class Untraced(KalmanqError):
    """FILE: line N: what of a function has no formula, and what to write in its place"""


def graph_of_formulas() -> Graph:
    return Graph(Formula)


def symbols(stem: str, count: int) -> np.ndarray:
    made = np.empty(count, object)
    made[:] = [symbol(f"{stem}{i}") for i in range(count)]
    return made


def traced(function: Callable[..., Any], args: Sequence[Any], graph: Graph) -> list[Node]:
    """Formulas of all that function(*args) answers, flat.  It is run twice: formulas that differ come of a function that is
    not one of its arguments alone."""
    with using(graph):
        first = _Trace(function, args, graph).formulas()
        second = _Trace(function, args, graph).formulas()
    if [*map(id, first)] != [*map(id, second)]:
        raise Untraced(f"{_place(function)}: answers differently when it is called twice: it draws random numbers, or keeps "
                       "something between calls")
    return first


class _Trace:
    def __init__(self, function: Callable[..., Any], args: Sequence[Any], graph: Graph):
        self.function, self.args, self.graph = function, args, graph
        self.file = getattr(getattr(function, "__code__", None), "co_filename", None)
        self.runs = 0

    def formulas(self) -> list[Node]:
        with _standing_in(self.function), self._lines():
            return self._built([])

    def _built(self, answers: list[bool]) -> list[Node]:
        """The paths that begin with these answers, joined"""
        asked, out = self._path(answers)
        taken = [answer for _, answer in asked]
        for k in range(len(asked) - 1, len(answers) - 1, -1):
            other = self._built([*taken[:k], not taken[k]])
            if len(other) != len(out):
                raise self._refused(f"answers {len(out)} numbers on one branch and {len(other)} on another")
            out = [select(asked[k][0], *((a, b) if taken[k] else (b, a))) for a, b in zip(out, other)]
        return out

    def _path(self, answers: Sequence[bool]) -> tuple[list[tuple[Node, bool]], list[Node]]:
        """Conditions with their answers, True where none is given, and what comes out"""
        asked: list[tuple[Node, bool]] = []
        known: dict[int, bool] = {}

        def decide(condition: Node) -> bool:
            if condition.op == "not":
                return not decide(condition.args[0])
            if id(condition) not in known:
                if len(asked) >= PATHS:
                    raise NoFormula(f"more than {PATHS} branches on one path: a loop until a value is reached has no formula; "
                                    "use a fixed number of rounds, or floor")
                known[id(condition)] = answers[len(asked)] if len(asked) < len(answers) else True
                asked.append((condition, known[id(condition)]))
            return known[id(condition)]

        self.runs += 1
        if self.runs > PATHS:
            raise self._refused(f"more than {PATHS} paths: write its branches as np.where(condition, a, b)")
        before, Formula.decide = Formula.decide, decide
        try:
            out = self.function(*(one.copy() if isinstance(one, np.ndarray) else one for one in self.args))
            return asked, [node(_number(one)) for one in np.ravel(np.array(out, object))]
        except (Exception, SystemExit) as problem:
            raise self._refused(_why(problem), problem) from problem
        finally:
            Formula.decide = before

    def _refused(self, reason: str, problem: Optional[BaseException] = None) -> Untraced:
        if isinstance(problem, Untraced):
            return problem
        frames = traceback.extract_tb(problem.__traceback__) if problem else []
        lines = [one for one in frames if one.filename == self.file]
        if not lines:
            return Untraced(f"{_place(self.function)}: {reason}")
        return Untraced(f"{self.file}: line {lines[-1].lineno}: {self.function.__name__}: {lines[-1].line or ''}: {reason}")

    @contextmanager
    def _lines(self) -> Iterator[None]:
        """Formulas are made in a line of the user's file."""
        before, self.graph.line = self.graph.line, self._line
        try:
            yield
        finally:
            self.graph.line = before

    def _line(self) -> int:
        if len(self.graph.table) > MOST_OPERATIONS:
            raise NoFormula(f"takes more than {MOST_OPERATIONS} operations: give fewer rounds")
        frame: Optional[types.FrameType] = sys._getframe(2)
        while frame is not None and frame.f_code.co_filename != self.file:
            frame = frame.f_back
        return frame.f_lineno if frame else 0


def _number(one: Any) -> Any:
    if isinstance(one, complex) or getattr(one, "dtype", np.dtype(float)).kind == "c":
        raise NoFormula("complex numbers have no formula here")
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


@contextmanager
def _standing_in(function: Callable[..., Any]) -> Iterator[None]:
    """numpy and math of the function's module, and of the modules beside it that it uses, are stand-ins."""
    own = {id(np): NumPy(), id(math): Math(), id(np.linalg): NumPy().linalg}
    kept: list[tuple[dict[str, Any], str, Any]] = []
    for space in _spaces(function):
        for name, value in list(space.items()):
            other = own.get(id(value)) or (stand_in_of(value) if callable(value) and not name.startswith("__") else value)
            if other is not value:
                kept.append((space, name, value))
                space[name] = other
        kept.append((space, "float", space.get("float", builtins.float)))
        space["float"] = as_float if kept[-1][2] is builtins.float else kept[-1][2]
    try:
        yield
    finally:
        for space, name, value in kept:
            if name == "float" and value is builtins.float:
                del space[name]
            else:
                space[name] = value


def _spaces(function: Callable[..., Any]) -> list[dict[str, Any]]:
    """Names of its module, and of the modules in the same folder that they lead to"""
    first = getattr(getattr(function, "__func__", function), "__globals__", None)
    if first is None:
        return []
    folder = _folder(first)
    found, waiting = [], [first]
    while waiting:
        space = waiting.pop()
        if any(space is one for one in found):
            continue
        found.append(space)
        for value in list(space.values()):
            other = value.__dict__ if isinstance(value, types.ModuleType) else getattr(value, "__globals__", None)
            if isinstance(other, dict) and folder is not None and _folder(other) == folder:
                waiting.append(other)
    return found


def _folder(space: dict[str, Any]) -> Optional[Path]:
    file = space.get("__file__")
    return Path(file).resolve().parent if isinstance(file, str) else None
