"""Constants of a model file that are free in a fit: the file is executed with other numbers, or with symbols, in their place.

A constant is free in all that the file makes of it: in f and h, in Q and R, in other constants.
"""

from __future__ import annotations

import ast
import builtins
from copy import copy
from typing import Any, Callable, Iterator, Mapping, Optional, Sequence

import numpy as np

from kalmanq.errors import ModelError
from kalmanq.formulas import tracing
from kalmanq.formulas.arrays import Array
from kalmanq.formulas.functions import value
from kalmanq.formulas.graph import Node, needed, symbol, using
from kalmanq.formulas.program import Program
from kalmanq.formulas.stand_ins import BUILTINS, stand_in_of
from kalmanq.model.arrays import block_diagonal, numbers_of
from kalmanq.nonlinear.calls import Given, Stacked
from kalmanq.nonlinear.formulas import Formulas, Rows

PUT = "_kalmanq_put"  # what a file calls for a constant
SAME = 1e-9


class Numbers:
    """values: other ones, by label; the others stay.  made: what the file has of each name"""

    def __init__(self, names: Sequence[str], values: Mapping[str, float]):
        self.names, self.values = names, values
        self.made: dict[str, np.ndarray] = {}

    def __call__(self, name: str, given: Any) -> Any:
        array = _numbers(name, given)
        for at, label in _labels(name, array):
            array[at] = self.values.get(label, array[at])
        self.made[name] = array
        return array if array.ndim else float(array)


class Symbols:
    """values, symbols: of each free number, by label"""

    def __init__(self, names: Sequence[str]):
        self.names, self.values = names, {}  # type: ignore[var-annotated]
        self.symbols: dict[str, Node] = {}

    def __call__(self, name: str, given: Any) -> Any:
        array = _numbers(name, given)
        made = np.empty(array.shape, object)
        for at, label in _labels(name, array):
            self.values[label] = float(array[at])
            made[at] = self.symbols[label] = symbol(f"c{len(self.symbols)}")
        return made.view(Array) if made.ndim else made[()]

    @property
    def builtins(self) -> dict[str, Any]:
        """Of a file that is executed with symbols: what it imports of NumPy and math takes them."""
        def imported(name: str, *rest: Any) -> Any:
            return stand_in_of(builtins.__import__(name, *rest))

        return {**vars(builtins), **BUILTINS, "__import__": imported}


def _numbers(name: str, given: Any) -> np.ndarray:
    try:
        made = np.array(numbers_of(given), float)
    except (TypeError, ValueError, OverflowError):
        raise ModelError(name, f"is free, but is {type(given).__name__}, not a number or an array of numbers") from None
    if made.ndim > 1:
        raise ModelError(name, "is free, but is a matrix: make its entries constants, and let these be free")
    if not np.all(np.isfinite(made)):
        raise ModelError(name, "is free, but is not finite")
    return made


def _labels(name: str, array: np.ndarray) -> Iterator[tuple[tuple[int, ...], str]]:
    """tau, or lever[0], lever[1], ..."""
    for at in np.ndindex(array.shape):
        yield at, f"{name}[{','.join(map(str, at))}]" if at else name


def placed(tree: ast.Module, names: Sequence[str]) -> ast.Module:
    """With a call after the statement that assigns each name"""
    for name in reversed(names):  # of one statement the first comes first
        places = [k for k, one in enumerate(tree.body) if name in _assigned(one)]
        if len(places) != 1:
            lines = ", ".join(str(tree.body[k].lineno) for k in places)
            raise ModelError(name, f"is free, but is assigned in lines {lines}: assign it once" if places else
                             "is free, but is no constant of the file: write NAME = number in a separate line")
        (made,) = ast.parse(f"{name} = {PUT}({name!r}, {name})").body
        for one in ast.walk(made):
            ast.copy_location(one, tree.body[places[0]])
        tree.body.insert(places[0] + 1, made)
    return tree


def _assigned(statement: ast.stmt) -> set[str]:
    """Names of the module"""
    made, waiting = set(), [statement]
    while waiting:
        one: Any = waiting.pop()
        if isinstance(one, (ast.FunctionDef, ast.ClassDef, ast.Lambda)):
            made |= {getattr(one, "name", "")}
        elif isinstance(one, ast.Name):
            made |= {one.id} if isinstance(one.ctx, ast.Store) else set()
        else:
            waiting += ast.iter_child_nodes(one)
    return made


class Free:
    """A model's formulas with symbols for its free constants.

    values    of these constants, by label; symbols: theirs
    formulas  of f, h, ...
    start, P0, Q, R   formulas of x0 and of the covariances; of Q and R that are functions, where `formulas` has them, 0
    """

    def __init__(self, model: Any, names: Sequence[str], executed: Callable[[Symbols], dict[str, Any]]):
        graph, made = tracing.graph_of_formulas(), Symbols(names)
        with using(graph):
            space = executed(made) if names else {}
            given, parts, noises = _given(model, space), _matrices(model, space), _noises(model, space)
            self.start = [value(one) for one in np.ravel(np.array(space.get("x0", model.x0), object))]
        self.values, self.symbols = made.values, made.symbols
        self.P0, self.Q, self.R = parts
        self.formulas = Formulas(given, len(model.carried), model.n, model.m, model.l, model.angles, graph, noises)
        self._require_same(model)

    def _require_same(self, model: Any) -> None:
        at = {one.args[0]: self.values[label] for label, one in self.symbols.items()}
        for key, rows, wanted in (("x0", [self.start], model.x0), ("P0", self.P0, model.P0), ("Q", self.Q, model.Q), ("R", self.R, model.R)):
            made = np.array(Program([one for row in rows for one in row]).values(at), float).reshape(len(rows), -1).squeeze()
            if wanted is not None and not np.allclose(made, wanted, SAME, 0):
                raise ModelError(key, "has no formula of the free constants: its numbers are lost on the way")

    def depends(self, rows: Rows) -> bool:
        """On a free constant?"""
        return bool(self._read(rows))

    def only_in_noises(self, label: str) -> bool:
        """Of no f, h, A, H or x0?"""
        f = self.formulas
        return id(self.symbols[label]) not in self._read([self.start, f.moved, f.innovation, f.corrected, *f.transition, *f.measurement])

    def _read(self, rows: Rows) -> set[int]:
        mine = {id(one) for one in self.symbols.values()}
        return mine & {id(one) for one in needed([one for row in rows for one in row])[0]}


def _given(model: Any, space: Mapping[str, Any]) -> dict[str, Any]:
    """The model's functions, of this space"""
    def of(key: str, had: Any) -> Any:
        if not space:
            return had
        if not isinstance(had, Stacked):
            return Given(key, space[key], had.names)
        at = 0 if key == "h" else 2
        return Stacked([(name, Given(one.name, space["sensors"][name][at]), m) for name, one, m in had.parts])

    return {key: of(key, had) for key, had in model.given.items()}


def _matrices(model: Any, space: Mapping[str, Any]) -> list[Rows]:
    """P0, Q, R"""
    P0, G = _matrix(space.get("P0", model.P0)), space.get("G")
    if {"Q", "G"} & set(model.given):
        Q: Any = np.zeros((model.n, model.n))
    elif G is not None:
        G = np.array(G, object).reshape(model.n, -1)
        Q = G @ G.T
    else:
        Q = _matrix(space.get("Q", model.Q))
    R = block_diagonal([np.zeros((model.noises.sizes[name],) * 2) if callable(one) else _matrix(one)
                        for name, one in _parts(model, space).items()])
    return [[[value(one) for one in row] for row in matrix] for matrix in (P0, Q, R)]


def _parts(model: Any, space: Mapping[str, Any]) -> dict[str, Any]:
    """R of each sensor, an array or a function"""
    had = model.noises.parts
    if "sensors" in space:
        return {name: space["sensors"][name][1] for name in had}
    return {"": space["R"]} if "R" in space else {name: getattr(one, "function", one) for name, one in had.items()}


def _noises(model: Any, space: Mapping[str, Any]) -> Any:
    """The model's, of this space"""
    made = copy(model.noises)
    made.parts = {name: Given(made.parts[name].name, one) if callable(one) else _matrix(one) for name, one in _parts(model, space).items()}
    return made


def _matrix(given: Any) -> np.ndarray:
    """Of a covariance, or of variances"""
    made = np.array(given, object)
    return made if made.ndim == 2 else block_diagonal([np.array([[one]], object) for one in made.ravel()])


def written(source: str, values: Mapping[str, Any]) -> str:
    """The file with other values of its constants: in the place of a literal, or in a line after what makes it"""
    tree, edits = ast.parse(source), []
    for name, given in values.items():
        last = max((one for one in tree.body if name in _assigned(one)), key=lambda one: one.lineno, default=None)
        literal = _literal(last, name) if last else None
        text = repr(np.asarray(given, float).tolist())
        if literal is not None:
            edits.append(((literal.lineno, literal.col_offset), (literal.end_lineno, literal.end_col_offset), text))
        else:
            end = (last.end_lineno, last.end_col_offset) if last else (source.count("\n") + 1, 0)
            edits.append((end, end, f"\n{name} = {text}"))
    lines = [f"{one}\n" for one in source.split("\n")]
    for (first, start), (end, stop), text in sorted(edits, reverse=True):
        head, tail = lines[first - 1].encode()[:start].decode(), lines[end - 1].encode()[stop:].decode()
        lines[first - 1:end] = [head + text + tail]
    return "".join(lines)[:-1]


def _literal(statement: ast.stmt, name: str) -> Optional[Any]:
    """The expression that `NAME = expression` gives to the name; None: nothing so simple"""
    if isinstance(statement, ast.AnnAssign):
        return statement.value
    if not isinstance(statement, ast.Assign) or len(statement.targets) != 1:
        return None
    target, given = statement.targets[0], statement.value
    if isinstance(target, ast.Name):
        return given
    if isinstance(target, (ast.Tuple, ast.List)) and isinstance(given, (ast.Tuple, ast.List)) and len(target.elts) == len(given.elts):
        for one, part in zip(target.elts, given.elts):
            if isinstance(one, ast.Name) and one.id == name:
                return part
    return None
