"""Numbers of a model that come from columns of the data: expressions in the place of numbers, in a file's matrices.

    R = ["accuracy^2"]      H = [[1.0, "current"]]      D = ["-R0"]

An expression has numbers, names of columns and of controls, + - * / ^ ( ), and FUNCTIONS.  It is parsed, and never executed.
"""

from __future__ import annotations

import ast
import math
from typing import Any, Callable, Iterator, Mapping, Optional, Sequence

import numpy as np

from kalmanq.errors import ModelError

FUNCTIONS = ("sqrt", "exp", "log", "sin", "cos", "abs")
CONSTANTS = {"pi": math.pi}
KEYS = ("A", "B", "Q", "H", "R", "D", "d")
OF_STEP = ("A", "B", "Q")  # the others are of the measurements of a row
CURES = {"G": "write Q in its place", "c": "write B, and give the column as a control", **{
    name: "a model in continuous time has columns in H, R, D and d; write A and Q of steps" for name in ("F", "L", "Qc")}}
LONGEST, DEEPEST = 1000, 50
SIGNS = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.Pow: "**"}
APPLIED: dict[type, Callable[[Any, Any], Any]] = {
    ast.Add: np.add, ast.Sub: np.subtract, ast.Mult: np.multiply, ast.Div: np.divide, ast.Pow: np.power}
WRITTEN = f"numbers, names of columns, + - * / ^ ( ) and {', '.join(FUNCTIONS)} of one number"


class Expression:
    """names: of columns and controls, each once, as they come"""

    def __init__(self, key: str, text: str):
        self.text, self._key = text, key
        if len(text) > LONGEST:
            raise ModelError(key, f"an expression has at most {LONGEST} letters: work out the column in the data")
        try:
            self._tree = ast.parse(text.strip().replace("^", "**"), mode="eval").body
        except (SyntaxError, ValueError, RecursionError, MemoryError):
            raise self._error("cannot be read", "a column whose name has other letters than a to z, digits and _ gets one by "
                              "--rename NAME=COLUMN") from None
        found: dict[str, None] = {}
        self._look(self._tree, found, 0)
        self.names = tuple(found)
        if not found:
            raise self._error("names no column", "write a number without quotes")

    def _error(self, why: str, cure: str = "") -> ModelError:
        return ModelError(self._key, f"{self.text[:40]!r} {why}: {cure or f'an expression has {WRITTEN}'}")

    def _look(self, node: ast.AST, found: dict[str, None], depth: int) -> None:
        """Refuses all that is not of an expression"""
        if depth > DEEPEST:
            raise self._error("is nested too deeply", "work out the column in the data")
        if isinstance(node, ast.BinOp) and type(node.op) in SIGNS:
            self._look(node.left, found, depth + 1)
            self._look(node.right, found, depth + 1)
        elif isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.UAdd, ast.USub)):
            self._look(node.operand, found, depth + 1)
        elif isinstance(node, ast.Call):
            name = node.func.id if isinstance(node.func, ast.Name) else ""
            if name not in FUNCTIONS or len(node.args) != 1 or node.keywords:
                raise self._error(f"calls {name or 'what has no name'}" if name not in FUNCTIONS else f"gives {name} other than one number")
            self._look(node.args[0], found, depth + 1)
        elif isinstance(node, ast.Name):
            found.update({} if node.id in CONSTANTS else {node.id: None})
        elif not (isinstance(node, ast.Constant) and type(node.value) in (int, float)):
            raise self._error("has what is no number and no column")

    def values(self, columns: Mapping[str, np.ndarray]) -> np.ndarray:
        """Of all rows at once"""
        with np.errstate(all="ignore"):
            return np.asarray(self._values(self._tree, columns), float)

    def _values(self, node: Any, columns: Mapping[str, np.ndarray]) -> Any:
        if isinstance(node, ast.BinOp):
            return APPLIED[type(node.op)](self._values(node.left, columns), self._values(node.right, columns))
        if isinstance(node, ast.UnaryOp):
            made = self._values(node.operand, columns)
            return -made if isinstance(node.op, ast.USub) else made
        if isinstance(node, ast.Call):
            return getattr(np, node.func.id)(self._values(node.args[0], columns))  # type: ignore[attr-defined]
        return columns.get(node.id, CONSTANTS.get(node.id)) if isinstance(node, ast.Name) else _number(node.value)

    def in_python(self, names: Mapping[str, str]) -> str:
        """With other names for columns, and NumPy's functions as np.NAME"""
        return self._python(self._tree, names)

    def _python(self, node: Any, names: Mapping[str, str]) -> str:
        if isinstance(node, ast.BinOp):
            return f"({self._python(node.left, names)} {SIGNS[type(node.op)]} {self._python(node.right, names)})"
        if isinstance(node, ast.UnaryOp):
            return f"({'-' if isinstance(node.op, ast.USub) else ''}{self._python(node.operand, names)})"
        if isinstance(node, ast.Call):
            return f"np.{node.func.id}({self._python(node.args[0], names)})"  # type: ignore[attr-defined]
        if isinstance(node, ast.Name):
            return names[node.id] if node.id in names else repr(CONSTANTS[node.id])
        return repr(float(_number(node.value)))


def _number(given: Any) -> np.float64:
    try:
        return np.float64(given)
    except OverflowError:
        return np.float64(np.inf)


# ------------------------------------------------------------------------------ of a file

Cells = dict[tuple[int, ...], Expression]  # by their places


def has_texts(given: Any) -> bool:
    return isinstance(given, str) or isinstance(given, list) and any(map(has_texts, given))


def taken(section: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """A section with 0 in the place of each expression, and by key the arrays of those, with None where a number is"""
    numbers, texts = dict(section), {}
    for key, value in section.items():
        if key in CURES and has_texts(value):
            raise ModelError(key, f"has numbers from columns, which are in A, B, Q, H, R, D and d: {CURES[key]}")
        if key in KEYS and has_texts(value):
            texts[key] = _mapped(value, lambda one: Expression(key, one) if isinstance(one, str) else None)
            numbers[key] = _mapped(value, lambda one: 0.0 if isinstance(one, str) else one)
    return numbers, texts


def _mapped(given: Any, of: Callable[[Any], Any]) -> Any:
    return [_mapped(one, of) for one in given] if isinstance(given, list) else of(given)


def placed(key: str, texts: Any, shape: tuple[int, ...], first: tuple[int, ...] = (0, 0)) -> Cells:
    """Where the expressions are in the matrix, which begins at `first` of a larger one"""
    found = {at: one for at, one in _found(texts, ()) if one is not None}
    depth = max(map(len, found))
    made: Cells = {}
    for at, one in found.items():
        if depth == len(shape):
            place = at
        elif key in "QR":  # variances, or a number
            place = (at[0], at[0]) if at else (0, 0)
        elif len(shape) == 1:
            place = (0,)
        else:  # a row or a column that is flat
            place = (0, at[0] if at else 0) if shape[0] == 1 else (at[0], 0)
        made[tuple(i + k for i, k in zip(place, first))] = one
    return made


def _found(texts: Any, at: tuple[int, ...]) -> Iterator[tuple[tuple[int, ...], Optional[Expression]]]:
    if not isinstance(texts, list):
        yield at, texts
        return
    for k, one in enumerate(texts):
        yield from _found(one, (*at, k))


def columns_of(cells: Mapping[str, Cells], controls: Sequence[str], others: Mapping[str, Sequence[str]]) -> list[str]:
    """Names that are no control's, as they come; others: names of what is no column, by what they are"""
    found: dict[str, None] = {}
    for key, of in cells.items():
        for one in of.values():
            for name in one.names:
                for what, known in others.items():
                    if name in known:
                        cure = "a nonlinear model (.py) has functions of states" if what == "state" else "copy it to a column of its own"
                        raise ModelError(key, f"{one.text!r} has {name}, which is a {what}: {cure}")
                found.update({} if name in controls else {name: None})
    return list(found)
