"""Each function in fixed point by itself: the C that a model gets for it, and its largest error."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Callable, Sequence

import numpy as np

from kalmanq.compiler.algorithm.fixed import functions as fixed_functions
from kalmanq.compiler.algorithm.fixed.formulas import FixedFormulas, Input
from kalmanq.compiler.algorithm.fixed.python import Far
from kalmanq.compiler.algorithm.fixed.values import fraction_for, largest, lowered
from kalmanq.formulas.graph import add, call, divide, fresh, mul, symbol
from kalmanq.formulas.program import Program

TRIED, ROWS = 20000, 64  # arguments for errors, and of them for costs
# Arguments from, to, as a model might have them; what has no row here is not a function of formulas
RANGES: dict[str, Sequence[tuple[float, float]]] = {
    "a + b": [(-4, 4), (-4, 4)], "a b": [(-4, 4), (-4, 4)], "a / b": [(-4, 4), (0.5, 4)], "sqrt": [(0, 4)],
    "sin": [(-4, 4)], "cos": [(-4, 4)], "tan": [(-1, 1)], "exp": [(-8, 2)], "log": [(0.05, 4)],
    "atan": [(-4, 4)], "asin": [(-0.98, 0.98)], "acos": [(-0.98, 0.98)],
    "sinh": [(-2, 2)], "cosh": [(-2, 2)], "tanh": [(-2, 2)], "atan2": [(-4, 4), (-4, 4)], "pow": [(0.05, 4), (0.5, 2)],
    "floor": [(-4, 4)], "abs": [(-4, 4)], "rint": [(-4, 4)], "fmod": [(-4, 4), (0.5, 1)], "log1p": [(-0.9, 3)],
    "expm1": [(-8, 2)], "cbrt": [(-4, 4)],
    "asinh": [(-4, 4)], "acosh": [(1.1, 4)], "atanh": [(-0.9, 0.9)]}
OPERATIONS: dict[str, Callable[..., Any]] = {"a + b": add, "a b": mul, "a / b": divide}


@dataclass(frozen=True)
class Function:
    """error: the largest, in units of the answer; fraction: of the answer; rows: raw arguments, of `fractions`; lines: of C, from
    x0, x1 to e[0]; run: the same in Python"""

    name: str
    ranges: Sequence[tuple[float, float]]
    error: float
    fraction: int
    rows: np.ndarray
    fractions: Sequence[int]
    lines: Sequence[str]
    run: Callable[..., list[Any]]

    @property
    def last_bits(self) -> float:
        return self.error * 2.0**self.fraction


def functions() -> list[Function]:
    return [_function(name, ranges) for name, ranges in RANGES.items()]


def _function(name: str, ranges: Sequence[tuple[float, float]]) -> Function:
    with fresh():
        x = [symbol(f"x{k}") for k in range(len(ranges))]
        exact = OPERATIONS[name](*x) if name in OPERATIONS else call(name, *x)
        roots = lowered([exact])
        fractions = [fraction_for(max(map(abs, one))) for one in ranges]
        draws = np.random.default_rng(1)
        words = np.array([[round(value * 2.0**n) for value in draws.uniform(*one, TRIED)] for one, n in zip(ranges, fractions)])
        given = {f"x{k}": np.ldexp(one.astype(float), -n) for k, (one, n) in enumerate(zip(words, fractions))}
        made = FixedFormulas(roots, {f"x{k}": Input(n) for k, n in enumerate(fractions)}, largest(roots, given))
        wanted = np.asarray(Program([exact]).values(given)[0], float)
        fraction = fraction_for(float(np.abs(wanted).max()))
        text = made.out(roots[0], fraction)
        run, far = made.python([text]), Far()
        answers = np.array([run(far, *row)[0] for row in words.T.tolist()], float)
        assert not far.bits
    error = float(np.max(np.abs(np.ldexp(answers, -fraction) - wanted)))
    return Function(name, ranges, error, fraction, words.T[:ROWS], fractions, [*made.c([text]), f"e[0] = {text};"], run)


def routines(made: Sequence[Function]) -> str:
    """C of what they call"""
    return fixed_functions.routines("\n".join(line for one in made for line in one.lines))
