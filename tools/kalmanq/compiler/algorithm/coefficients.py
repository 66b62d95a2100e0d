"""A, Q and R of a filter: numbers of its C, or (--tunable) fields that a program may change while it runs.

Entries that are 0, and ones on the diagonal of A, are part of the structure and stay: they fold.
"""

from __future__ import annotations

from typing import Any, Callable, Optional, Sequence

import numpy as np

from kalmanq.compiler.algorithm import ud
from kalmanq.compiler.given import stepping
from kalmanq.compiler.given.request import Request
from kalmanq.formulas.graph import Node, constant, node, symbol


class Constant:
    """All numbers are of the model."""

    fields: Sequence[str] = ()
    start: Sequence[str] = ()

    def __init__(self, given: Request):
        self.given, of = given, given.of.doubles()
        self.A = [[constant(value) for value in row] for row in of.A]
        self.A_less_one = [[constant(float(value - (i == k))) for k, value in enumerate(row)]
                           for i, row in enumerate(given.of.A)]
        self.R = [constant(value) for value in of.R]
        self.B = [[constant(float(value)) for value in row] for row in given.of.B]

    def noise(self, order: Optional[Sequence[int]] = None) -> list[ud.Column]:
        """order: of states; None: the model's, the only one of what may change"""
        Q = self.given.of.Q
        return ud.columns_of_noise(Q if order is None else Q[np.ix_(order, order)])

    def enumerators(self) -> list[str]:
        return []

    def tunable(self) -> dict[str, Any]:
        """What the templates of functions that set them are given"""
        return {"tunable": None, "step": None}


class Tunable(Constant):
    """Fields A[], q[], g[], r[]: entries of A, the factor of Q, the variances of R; of a model in continuous time B[], too"""

    def __init__(self, given: Request, type_: str, number: Callable[[float], str]):
        super().__init__(given)
        self.type, self.number, of = type_, number, given.of.doubles()
        self.continuous = given.model.continuous
        has, ones = (of.A != 0, np.diag(of.A) == 1) if self.continuous is None else _structure(self.continuous.F)
        self.places = [(int(i), int(k)) for i, k in zip(*np.nonzero(has)) if not (i == k and ones[i])]
        self.pushes = [] if self.continuous is None or not of.l else list(zip(*np.nonzero(has.astype(float) @ (self.continuous.B != 0))))
        for slot, (i, k) in enumerate(self.pushes):
            self.B[i][k] = symbol(f"f->B[{slot}]")
        for slot, (i, k) in enumerate(self.places):
            self.A[i][k] = symbol(f"f->A[{slot}]")
            self.A_less_one[i][k] = self.A[i][k] - float(i == k)
        self.R = [symbol(f"f->r[{j}]") for j in range(of.m)]
        self.q = ud.factor_of_noise(given.of.Q)
        self.columns = [c for c in range(of.n) if self.q[c, c]]
        self.rows = [(i, c) for c in self.columns for i in range(c) if self.q[i, c]]
        sizes = (("A", len(self.places)), ("B", len(self.pushes)), ("q", len(self.columns)), ("g", len(self.rows)), ("r", of.m))
        self.fields = [f"{type_} {', '.join(f'{name}[{size}]' for name, size in sizes if size)}; /* A, {'B, ' if self.pushes else ''}U and D of Q, R */"]
        values = [*((f"A[{s}]", of.A[place]) for s, place in enumerate(self.places)),
                  *((f"B[{s}]", of.B[place]) for s, place in enumerate(self.pushes)),
                  *((f"q[{s}]", self.q[c, c]) for s, c in enumerate(self.columns)),
                  *((f"g[{s}]", self.q[place]) for s, place in enumerate(self.rows)),
                  *((f"r[{j}]", value) for j, value in enumerate(of.R))]
        self.start = [f"f->{name} = {number(float(value))};" for name, value in values]

    def noise(self, order: Optional[Sequence[int]] = None) -> list[ud.Column]:
        n = self.given.of.n
        return [ud.Column(symbol(f"f->q[{slot}]"), [self._entry(i, c) for i in range(n)])
                for slot, c in enumerate(self.columns)]

    def _entry(self, i: int, c: int) -> Node:
        return symbol(f"f->g[{self.rows.index((i, c))}]") if (i, c) in self.rows else node(float(i == c))

    def enumerators(self) -> list[str]:
        """Which field an entry of A is"""
        if not self.places:
            return []
        states, upper = self.given.states, self.given.upper
        lines = [f"    {upper}_A_{states[i]}_{states[k]}".upper() + f" = {slot}" for slot, (i, k) in enumerate(self.places)]
        return ["/* f->A[...]: the entry of A in the row of the first state and the column of the second one */", "enum {",
                *(f"{line}," for line in lines[:-1]), lines[-1], "};", ""]

    def tunable(self) -> dict[str, Any]:
        slots = {key: slot for slot, key in enumerate(self.rows)}
        place = [self.columns.index(j) if i == j and j in self.columns else slots.get((i, j), NONE) for i, j in ud.keys(self.given.of.n)]
        return {"tunable": {"place": place, "none": NONE, "tiny": self.number(1e-6), "most": self.number(1e30), "has_rows": bool(self.rows)},
                "step": self._step() if self.continuous else None}

    def _step(self) -> dict[str, Any]:
        n, B = self.given.of.n, self.continuous.B
        stores = [(f"f->A[{s}]", f"A[{n * i + k}]") for s, (i, k) in enumerate(self.places)]
        stores += [(f"f->B[{s}]", " + ".join(f"{self.number(float(B[j, k]))} * S[{n * i + j}]" for j in range(n) if B[j, k]))
                   for s, (i, k) in enumerate(self.pushes)]
        return stepping.names(self.given, self.continuous, self.type, self.number, stores)


def _structure(F: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Entries of e^(F dt) that are not 0 for most dt, and which of the diagonal are 1 for every dt: those of states that
    nothing leads back to"""
    pattern = (F != 0).astype(float)
    has = np.linalg.matrix_power(np.eye(len(F)) + pattern, len(F))
    return has != 0, np.diag(pattern @ has) == 0


NONE = 255  # no field


def coefficients(given: Request, type_: str, number: Callable[[float], str]) -> Constant:
    return Tunable(given, type_, number) if given.options.tunable else Constant(given)
