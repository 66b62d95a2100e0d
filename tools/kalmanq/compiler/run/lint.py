"""What float does to a model's own formulas: each is worked out in float and in double from the same state.

Tried are the means of records, states within two sigma of them, and the means at which a state is nearest to 0 with it
nearer still, where formulas such as (1 - cos w) / w lose their digits, if a row comes within three of its sigmas.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any, Callable, Iterator, Mapping, Optional, Sequence

import numpy as np

from kalmanq.compiler.algorithm.equation_rounding import EPSILON
from kalmanq.compiler.run.host import numbered
from kalmanq.formulas.graph import Node
from kalmanq.formulas.program import Program
from kalmanq.nonlinear import NonlinearModel
from kalmanq.nonlinear.formulas import values_of

Visited = tuple[np.ndarray, np.ndarray, np.ndarray, Optional[np.ndarray]]  # means, sigmas, controls, clock: of rows
POINTS = 300  # rows that are looked at
TINY = 1e-30  # a value below counts as this
NEAREST = 20  # means that are nearest to 0 in a state
NEAR_ZERO = 10.0 ** -np.arange(1.0, 8.0)


@dataclass(frozen=True)
class Lossy:
    """A formula and its worst error, in sigma of what it is for; line: of the user's file, 0: not known"""

    name: str
    error: float
    line: int
    where: str

    def __str__(self) -> str:
        return self.name + (f" (line {self.line})" if self.line else "")


def lossy_formulas(model: NonlinearModel, visited: Sequence[Visited]) -> list[Lossy]:
    """All formulas, the worst one first"""
    x, sigma, t, u, dt = points(model, visited)
    least = 0 if model.has_errors else EPSILON * np.abs(x)  # a state without noise gets more certain than a float
    rows = list(formulas(model, np.maximum(sigma, least)))
    program = Program([one for _, one, _ in rows])
    single = {name: np.asarray(value, np.float32) for name, value in values_of(x.T, t, u.T, dt).items()}
    low = program.values(single, np.float32)
    high = program.values({name: value.astype(float) for name, value in single.items()}, np.float64)
    made = [worst(model, name, np.abs(np.asarray(a, float) - b) * scale, single, partial(_line, model, one)) for (name, one, scale), a, b in
            zip(rows, low, high)]
    return sorted(made, key=lambda one: -one.error)


def worst(model: NonlinearModel, name: str, errors: np.ndarray, given: Mapping[str, Any],
          line: Callable[[dict[str, Any]], int] = lambda _: 0) -> Lossy:
    """Of a formula at many points; line: of the user's file, of one point"""
    errors = np.nan_to_num(np.broadcast_to(errors, given["x0"].shape), nan=0.0, posinf=0.0)
    k = int(np.argmax(errors))
    point = {key: value if np.ndim(value) == 0 else value[k] for key, value in given.items()}
    where = ", ".join(f"{state.name} = {point[f'x{i}']:.3g}" for i, state in enumerate(model.carried))
    return Lossy(name, float(errors[k]), line(point) if errors[k] else 0, where)


def _line(model: NonlinearModel, root: Node, point: dict[str, np.ndarray]) -> int:
    """Of the operation that loses most: its relative error beside the largest of its arguments"""
    program, lines = Program([root]), model.formulas.graph.lines
    low = program.every(point, np.float32)
    high = program.every({key: value.astype(float) for key, value in point.items()}, np.float64)
    off = {id(one): abs(float(a) - float(b)) / max(abs(float(b)), TINY) for one, a, b in zip(program.order, low, high)}
    losses = [(off[id(one)] / max([EPSILON, *(off[id(a)] for a in one.args if isinstance(a, Node))]), lines[id(one)][1])
              for one in program.order if lines.get(id(one))]
    return max(losses, default=(0.0, 0))[1]


def formulas(model: NonlinearModel, sigma: np.ndarray) -> Iterator[tuple[str, Node, np.ndarray]]:
    """Name, formula, and what an error of it is multiplied with to be in sigma"""
    f, q = model.formulas, np.zeros(model.n) if model.Q is None else np.sqrt(np.diag(model.Q))
    r = np.sqrt(np.diag(model.R if model.R is not None else model.noises.start))
    states, measurements = ([one.name for one in of] for of in (model.states, model.measurements))
    for i, one in enumerate(() if model.has_errors else f.change):
        yield f"f({states[i]})", one, 1 / np.where(q[i] > 0, q[i], sigma[:, i])
    for i, row in enumerate(f.transition):
        for j, one in enumerate(row):
            yield f"df({states[i]})/d{states[j]}", one, sigma[:, j] / sigma[:, i]
    for c, one in enumerate(f.expected):
        yield f"h({measurements[c]})", one, np.full(len(sigma), 1 / r[c])
    for c, row in enumerate(f.measurement):
        for j, one in enumerate(row):
            yield f"dh({measurements[c]})/d{states[j]}", one, sigma[:, j] / r[c]


def points(model: NonlinearModel, visited: Sequence[Visited]) -> tuple[np.ndarray, ...]:
    draws = np.random.default_rng(1)
    x, sigma, u = (np.concatenate([one[k] for one in visited]) for k in range(3))
    clock = np.concatenate([numbered(len(one[0])) if one[3] is None else one[3] for one in visited])
    t, dt = clock[:, 2], np.append(clock[1:, 1], np.nan)  # of the step that leaves a row
    dt = np.where(np.isnan(dt), model.dt or np.nan, dt)
    fine = np.flatnonzero(np.all(np.isfinite(x), axis=1) & np.all(np.isfinite(sigma), axis=1))
    some = fine[draws.permutation(len(fine))[:POINTS]]
    x, sigma, t, u, dt = x[some], sigma[some], t[some], u[some], dt[some]
    if model.has_errors:
        return x, sigma, t, u, dt
    made = [x, x + 2 * sigma * draws.uniform(-1, 1, x.shape)]
    for i in range(model.n):
        if x[:, i].min() <= 0 <= x[:, i].max() or np.any(np.abs(x[:, i]) <= 3 * sigma[:, i]):
            near = x[np.resize(np.argsort(np.abs(x[:, i]))[:NEAREST], len(x))]  # others are what they are there
            near[:, i] = draws.choice(NEAR_ZERO, len(x)) * np.where(near[:, i] == 0, sigma[:, i], near[:, i])
            made.append(near)
    count = len(made)
    return np.concatenate(made), np.tile(sigma, (count, 1)), np.tile(t, count), np.tile(u, (count, 1)), np.tile(dt, count)
