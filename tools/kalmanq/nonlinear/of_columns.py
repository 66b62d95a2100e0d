"""A linear model with numbers from columns, or with D, as a model of functions: its columns are controls of these.

    f = A(u) x + B(u) u + c     h = H(u) x + D(u) u + d     Q(u)     R(u)

So `kalmanq compile` takes it.  A model in continuous time has A, B and Q of the step where they are polynomials of it (a power of F is 0);
otherwise it is one of steps of dt.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, Callable, Optional, Sequence

import numpy as np

from kalmanq.errors import KalmanqError
from kalmanq.model import SIZE_MAX, Model, Quantity
from kalmanq.model.columns import OF_STEP
from kalmanq.model.continuous import Continuous
from kalmanq.nonlinear.file import executed
from kalmanq.nonlinear.model import NonlinearModel

RATE = 0.13  # radians a row, of columns and controls where measurements are simulated
SHARE = 0.25  # of a control's range


def equations_of(model: Model, arithmetic: str = "f32") -> NonlinearModel:
    """arithmetic: of its C, which says what it cannot be"""
    unknown = [one.name for one, is_unknown in zip(model.states, model.unknown) if is_unknown]
    if unknown:
        raise KalmanqError(f"P0 of {unknown[0]} is unknown, and C of a model with numbers from columns or D begins with a known start: give a wide P0")
    if len(model.inputs) > SIZE_MAX:
        raise KalmanqError(f"{len(model.inputs)} controls and columns: C has {SIZE_MAX} at most: work out some of them in the data")
    varies = [name for name in "QR" if name in getattr(model, "cells", {})]
    if arithmetic == "q31" and varies:
        raise KalmanqError(f"q31: {varies[0]} is from columns, and its C has constants for Q and R: take f32 or f64")
    written = _Written(model)
    space = executed(Path(f"{model.name}.py"), written.text.encode())
    noise = {"Q": space["Q"]} if "Q" in space else {"Q": model.Q} if model.G is None else {"G": model.G}
    noise.update({"dt": model.continuous.dt * model.continuous.seconds} if has_steps(model) else {})
    made = NonlinearModel(space["f"], **written.measured(space), **noise, x0=model.x0, P0=model.P0, states=model.states, measurements=model.measurements,
                          controls=model.inputs, simulated_controls=_simulated(model), name=model.name)
    made.linear, made.recording = model, model.recording
    return made


def has_steps(model: Model) -> bool:
    """Are its A, B and Q polynomials of the step?"""
    return model.continuous is not None and model.continuous.ends


class _Written:
    """The functions as a text of Python"""

    def __init__(self, model: Model):
        self.model = model
        self._cells = getattr(model, "cells", {})
        self._steps = _Polynomials(model.continuous) if has_steps(model) else None
        self._names = {one.name: f"u[{k}]" for k, one in enumerate(model.inputs)}
        controls = ["1.0" if one.constant else self._names[one.name] for one in model.controls]
        states = [f"x[{i}]" for i in range(model.n)]
        ends = np.cumsum([0, *model.sensor_sizes]).tolist()
        self.parts = list(zip(ends, ends[1:]))
        moved = [self._sum([("A", i, states), ("B", i, controls)]) for i in range(model.n)]
        expected = [self._sum([("H", c, states), ("D", c, controls)], self._cell("d", (c,))) for c in range(model.m)]
        lines = ["import numpy as np", self._function("f", moved)]
        if "Q" in self._cells or self._steps:
            lines.append(self._function("Q", self._matrix("Q", 0, model.n)))
        for k, (a, b) in enumerate(self.parts):
            lines.append(self._function(f"h{k}", expected[a:b]))
            if any(a <= i < b for i, _ in self._cells.get("R", {})):
                lines.append(self._function(f"R{k}", self._matrix("R", a, b)))
        self.text = "\n\n".join(lines) + "\n"

    def _function(self, name: str, answers: Sequence[str]) -> str:
        return f"def {name}(x, t, u{', dt' if self._steps and name in 'fQ' else ''}):\n    return [{', '.join(answers)}]"

    def _cell(self, name: str, at: tuple[int, ...]) -> str:
        """Empty: it is 0"""
        if self._steps and name in OF_STEP:
            return self._steps.text(name, at)
        cell, array = self._cells.get(name, {}).get(at), getattr(self.model, name)
        if cell is not None:
            return cell.in_python(self._names)
        return "" if array is None or not array[at] else repr(float(array[at]))

    def _sum(self, parts: Sequence[tuple[str, int, Sequence[str]]], offset: str = "") -> str:
        terms = [self._term(self._cell(name, (row, k)), of) for name, row, factors in parts if getattr(self.model, name) is not None
                 for k, of in enumerate(factors) if k < getattr(self.model, name).shape[1]]
        return " + ".join(filter(None, [*terms, offset])) or "0.0 * x[0]"

    @staticmethod
    def _term(cell: str, factor: str) -> str:
        return "" if not cell else factor if cell == "1.0" else cell if factor == "1.0" else f"{cell} * {factor}"

    def _matrix(self, name: str, a: int, b: int) -> list[str]:
        return [f"[{', '.join(self._cell(name, (i, k)) or '0.0' for k in range(a, b))}]" for i in range(a, b)]

    def measured(self, space: dict[str, Any]) -> dict[str, Any]:
        """h and R, or sensors and how late they are"""
        model = self.model
        made = [(space[f"h{k}"], space.get(f"R{k}", model.R[a:b, a:b])) for k, (a, b) in enumerate(self.parts)]
        if not model.sensors:
            return {"h": made[0][0], "R": made[0][1]}
        of = model.continuous
        late = {one.name: one.delay * of.seconds if of and self._steps else _rows_of(one.delay / (of.dt if of else 1.0), one.name)
                for one in model.sensors if one.delay}
        return {"sensors": {one.name: pair for one, pair in zip(model.sensors, made)}, "delays": late or None}


class _Polynomials:
    """A, B and Q over a step, by powers of it: of an F of which a power is 0"""

    def __init__(self, of: Continuous):
        n, unit = len(of.F), of.seconds
        powers = [np.linalg.matrix_power(of.F, k) / math.factorial(k) for k in range(n)]
        A = {k: one for k, one in enumerate(powers)}
        S = {k + 1: one / (k + 1) for k, one in enumerate(powers)}
        Q: dict[int, np.ndarray] = {}
        for i, one in enumerate(powers):
            for k, other in enumerate(powers):
                Q[i + k + 1] = Q.get(i + k + 1, np.zeros((n, n))) + one @ of.Qc @ other.T / (i + k + 1)
        B = {k: one @ of.B for k, one in S.items()} if of.B is not None else {}
        self._of = {name: {k: one / unit**k for k, one in made.items()} for name, made in (("A", A), ("B", B), ("Q", Q))}

    def text(self, name: str, at: tuple[int, ...]) -> str:
        terms = [(k, float(one[at])) for k, one in self._of[name].items() if one[at]]
        made = " + ".join(repr(by) if not k else f"{by!r} * dt**{k}" if by != 1 else f"dt**{k}" for k, by in terms)
        return f"({made})" if len(terms) > 1 else made


def _rows_of(late: float, name: str) -> int:
    if abs(late - round(late)) > 1e-6:
        raise KalmanqError(f"the delay of {name} is no multiple of dt, and its C has rows of dt: give a delay of whole rows")
    return round(late)


def _simulated(model: Model) -> Optional[Callable[[float], list[float]]]:
    """Controls and columns over their ranges, for records that the C is tried with"""
    if not model.inputs:
        return None
    columns = len(getattr(model, "columns", ()))
    spans = [_span(one, k >= len(model.inputs) - columns) for k, one in enumerate(model.inputs)]

    def simulated_controls(t: float) -> list[float]:
        return [low + (high - low) * (1 + float(np.sin(RATE * (1 + k) * t + k))) / 2 for k, (low, high) in enumerate(spans)]

    return simulated_controls


def _span(one: Quantity, is_column: bool) -> tuple[float, float]:
    if one.ends:
        return one.ends
    if one.range is None:
        return (1.0, 1.0) if is_column else (0.0, 0.0)
    return (one.range / 16, one.range) if is_column else (-SHARE * one.range, SHARE * one.range)
