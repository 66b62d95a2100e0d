"""A model's functions as formulas of x0, x1, ..., t, u0, u1, ... and d0, d1, ...: traced when they are first asked for."""

from __future__ import annotations

from functools import cached_property
from typing import Any, Mapping, Optional, Sequence

import numpy as np

from kalmanq.formulas import tracing
from kalmanq.formulas.calculus import jacobian, less, substituted
from kalmanq.formulas.functions import value
from kalmanq.formulas.graph import Graph, Node, add, call, compare, logic, mul, select, sub, symbol, using
from kalmanq.formulas.program import Program
from kalmanq.model.arrays import block_diagonal
from kalmanq.nonlinear.calls import Given, Stacked
from kalmanq.nonlinear.noises import Noises

Rows = list[list[Node]]


class Formulas:
    """Untraced is raised by what needs a function that has no formula.

    given   functions by name, as in NonlinearModel; angles: how large a turn of each measurement is that is an angle; count: of the numbers that f
            moves, n where these are the states; graph: of other symbols that the functions know
    """

    def __init__(self, given: dict[str, Given], count: int, n: int, m: int, l: int, angles: Mapping[int, float], graph: Optional[Graph] = None,
                 noises: Optional[Noises] = None):
        self.noises, self.given, self.count, self.n, self.m, self.angles = noises, given, count, n, m, angles
        self.graph = graph or tracing.graph_of_formulas()
        with using(self.graph):
            self.x, self.u, self.z, self.d = (tracing.symbols(stem, k) for stem, k in (("x", count), ("u", l), ("z", m), ("d", n)))
            self.t, self.dt = symbol("t"), symbol("dt")

    @property
    def of_rows(self) -> list[Node]:
        """Of all that is asked of a row or a step, but Jacobians"""
        noises = [one for rows in (self.noise_of_step or [], self.noise_of_sensors or []) for row in rows for one in row]
        return [*self.moved, *self.change, *self.innovation, *noises]

    def _traced(self, name: str, count: int) -> list[Node]:
        return self._traced_of(self.given[name], count)

    def _traced_of(self, given: Given, count: int) -> list[Node]:
        return self._traced_at(given, [*([self.z] if given.name == "innovation" else []), self.x, self.t, self.u], count)

    @cached_property
    def noise_of_step(self) -> Optional[Rows]:
        """Q (n x n) or G (n x r), where it is a function"""
        given = self.given.get("Q", self.given.get("G"))
        return None if given is None else self._noise(given, self.n)

    @cached_property
    def noise_of_sensors(self) -> Optional[Rows]:
        """R of all sensors, where one has a function"""
        if self.noises is None or not self.noises.functions:
            return None
        parts = [self._noise(one, self.noises.sizes[name]) if isinstance(one, Given) else one for name, one in self.noises.parts.items()]
        return [[value(one) for one in row] for row in block_diagonal([np.array(one, object) for one in parts])]

    def _noise(self, given: Given, size: int) -> Rows:
        made = tracing.traced(given.function, given.arguments(self.x, self.t, self.u, dt=self.dt), self.graph)
        columns = len(made) // size
        if len(made) % size or given.name != "G" and columns not in (1, size):
            raise given.error(f"answers {len(made)} numbers, not {size} x {size}, nor {size} variances")
        if columns == 1 and given.name != "G":
            return [[one if i == k else value(0.0) for k in range(size)] for i, one in enumerate(made)]
        return [made[i * columns:(i + 1) * columns] for i in range(size)]

    def _traced_at(self, given: Given, args: Sequence[Any], count: int) -> list[Node]:
        made = tracing.traced(given.function, given.arguments(*args, dt=self.dt), self.graph)
        if len(made) != count:
            raise given.error(f"answers {len(made)} numbers, not {count}")
        return made

    @cached_property
    def change(self) -> list[Node]:
        """f(x) - x"""
        if "increment" in self.given:
            return self._traced("increment", self.count)
        with using(self.graph):
            return [less(one, x) for one, x in zip(self.moved, self.x)]

    @cached_property
    def moved(self) -> list[Node]:
        """f(x), or the increment where there is no f"""
        return self._traced("f", self.count) if "f" in self.given else self.change

    @cached_property
    def expected(self) -> list[Node]:
        """h(x), of all sensors"""
        parts = self.given["h"].parts if isinstance(self.given["h"], Stacked) else [("h", self.given["h"], self.m)]
        return [one for _, h, m in parts for one in self._traced_of(h, m)]

    @cached_property
    def innovation(self) -> list[Node]:
        """z - h(x), of z0, z1, ...; angles within half a turn"""
        made = self._traced("innovation", self.m) if "innovation" in self.given else None
        with using(self.graph):
            made = made or [sub(z, h) for z, h in zip(self.z, self.expected)]
            return [_wrapped(one, self.angles[c]) if c in self.angles else one for c, one in enumerate(made)]

    @cached_property
    def corrected(self) -> list[Node]:
        """x with the errors d0, d1, ..."""
        if "plus" in self.given:
            return self._traced_at(self.given["plus"], [self.x, self.d], self.count)
        with using(self.graph):
            return [add(x, d) for x, d in zip(self.x, self.d)]

    @cached_property
    def apart(self) -> list[Node]:
        """The errors of b0, b1, ... that make a0, a1, ... of them"""
        with using(self.graph):
            a, b = (tracing.symbols(stem, self.count) for stem in "ab")
            if "minus" not in self.given:
                return [sub(one, other) for one, other in zip(a, b)]
        return self._traced_at(self.given["minus"], [a, b], self.n)

    @cached_property
    def derived_transition(self) -> Rows:
        """A, of f: n x n"""
        if "plus" not in self.given:
            with using(self.graph):
                rows = jacobian(self.change, list(self.x))
                return [[add(one, float(i == k)) for k, one in enumerate(row)] for i, row in enumerate(rows)]
        after = [np.array(one, object) for one in (self._with_errors(self.moved), self.moved)]
        return self.by_errors(self._traced_at(self.given["minus"], after, self.n))

    @cached_property
    def derived_measurement(self) -> Rows:
        """H, of h: m x n"""
        if "plus" in self.given:
            return self.by_errors(self._with_errors(self.expected))
        with using(self.graph):
            return jacobian(self.expected, list(self.x))

    def _with_errors(self, rows: Sequence[Node]) -> list[Node]:
        values, memo = {f"x{i}": one for i, one in enumerate(self.corrected)}, {}
        with using(self.graph):
            return [substituted(one, values, memo) for one in rows]

    def by_errors(self, rows: Sequence[Node]) -> Rows:
        """Derivatives where the errors are 0"""
        none, memo = {f"d{k}": 0.0 for k in range(self.n)}, {}
        with using(self.graph):
            return [[substituted(one, none, memo) for one in row] for row in jacobian(rows, list(self.d))]

    @property
    def transition(self) -> Rows:
        """A: the model's own, or derived"""
        return self._matrix("A", self.n) if "A" in self.given else self.derived_transition

    @property
    def measurement(self) -> Rows:
        return self._matrix("H", self.m) if "H" in self.given else self.derived_measurement

    def _matrix(self, name: str, rows: int) -> Rows:
        given = self.given[name]
        parts = given.parts if isinstance(given, Stacked) else [(name, given, rows)]
        made = [one for _, of, m in parts for one in self._traced_of(of, m * self.n)]
        return [made[i * self.n:(i + 1) * self.n] for i in range(rows)]


class Jacobian:
    """Of a function of the model, in numbers.  dt: of a step, where its instant has none"""

    def __init__(self, rows: Rows, dt: Optional[float] = None):
        self.dt = dt
        self.shape = len(rows), len(rows[0])
        self.program = Program([one for row in rows for one in row])

    def at(self, x: np.ndarray, t: float, u: np.ndarray) -> np.ndarray:
        return np.array(self.program.values(values_of(x, t, u, self.dt)), float).reshape(self.shape)


def values_of(x: np.ndarray, t: float, u: np.ndarray, dt: Optional[float] = None) -> dict[str, float]:
    """dt: where t has none"""
    return {**{f"x{i}": value for i, value in enumerate(x)}, **{f"u{i}": value for i, value in enumerate(u)}, "t": t,
            "dt": dt if getattr(t, "dt", None) is None else t.dt}


def _wrapped(angle: Node, turn: float) -> Node:
    """Within half a turn"""
    turns = call("floor", add(mul(angle, 1 / turn), 0.5))
    return select(logic("or", compare("lt", turn / 2, angle), compare("lt", angle, -turn / 2)), sub(angle, mul(turn, turns)), angle)
