"""Sensors at different rates (--every): there is no full sample in each row, but a cycle of rows that settles.

A row counts from the last full sample.  As long as each row has the components that are due in it, N cycles after a
full sample the covariance of each row of the cycle is known, by the bound of `enclosure`.  From then on each row of the
cycle has a constant gain.
"""

from __future__ import annotations

import decimal
import math
from dataclasses import dataclass
from typing import Optional, Sequence

import numpy as np

from kalmanq.compiler.arithmetic import Arithmetic
from kalmanq.compiler.emit import Text, function, within
from kalmanq.compiler.enclosure import DIGITS, GONE, MORE, MOST, Map, is_within, least_steps, unit_lower
from kalmanq.compiler.exact import Numbers, decimals, eye, inverse, symmetric
from kalmanq.compiler.printing import indented
from kalmanq.compiler.request import Request, due
from kalmanq.errors import KalmanqError

LONGEST = 100  # rows
Matrix = np.ndarray


@dataclass(frozen=True)
class Row:
    """Of a row of the settled cycle.  due: bits of its components; gain: n x m, 0 for the others; variances: m, of
    innovations given those before them, infinite for the others"""

    due: int
    predicted: Matrix
    filtered: Matrix
    gain: Matrix
    variances: Matrix


@dataclass(frozen=True)
class Cycle:
    """rows[0] follows a full sample, and the last has one; cycles: after which it has settled"""

    rows: Sequence[Row]
    cycles: int
    tolerance: float

    @property
    def gains(self) -> list[Matrix]:
        return [row.gain.astype(float) for row in self.rows]

    @property
    def variances(self) -> Matrix:
        """m, the least in a row"""
        return np.min([row.variances for row in self.rows], axis=0)

    @property
    def means(self) -> Matrix:
        """Variances of the n means, the least in a row"""
        return np.min([np.diag(row.filtered).astype(float) for row in self.rows], axis=0)


def check(given: Request) -> None:
    every = given.options.every
    if len(every) != given.of.m or min(every) < 1:
        raise KalmanqError(f"--every: gives rows between two values of each of {given.of.m} measurements: whole numbers")
    if min(every) != 1:
        raise KalmanqError("--every: one measurement has to be in every row: give the model a longer step")
    if math.lcm(*every) > LONGEST:
        raise KalmanqError(f"--every: all measurements meet after {math.lcm(*every)} rows, at most {LONGEST}")
    if given.options.nis or given.options.gate is not None or given.options.lag:
        raise KalmanqError("--every: is without --nis, --robust gate and --lag; leave it out, and every row is worked out")


def settled(of: Numbers, every: Sequence[int], tolerance: float) -> Optional[Cycle]:
    with decimal.localcontext(DIGITS):
        predict = Map(of.A, decimals(np.zeros((of.n, of.n))), of.Q)
        masks = [due(every, row) for row in range(1, math.lcm(*every) + 1)]
        ahead = [predict.then(_sample(of, mask)) for mask in masks]
        whole = ahead[0]
        for one in ahead[1:]:
            whole = whole.then(one)
        doubled = [whole]
        for _ in range(MOST):
            doubled.append(doubled[-1].then(doubled[-1]))
        floor = np.diag(of.P0) * GONE

        def has_settled(one: Map) -> bool:
            for step in ahead:
                if not is_within(one, tolerance, floor):
                    return False
                one = one.then(step)
            return True

        if not has_settled(doubled[-1]):
            return None
        cycles, last = least_steps(doubled, has_settled), doubled[-1]
        for _ in range(MORE):
            last = last.then(last)
        return Cycle(_rows(of, masks, last.Q), cycles, tolerance)


def _sample(of: Numbers, mask: int) -> Map:
    nothing = decimals(np.zeros((of.n, of.n)))
    taken = [j for j in range(of.m) if mask >> j & 1]
    return Map(eye(of.n), of.H[taken].T @ np.diag(1 / of.R[taken]) @ of.H[taken], nothing)


def _rows(of: Numbers, masks: Sequence[int], P: Matrix) -> list[Row]:
    made = []
    for mask in masks:
        taken = [j for j in range(of.m) if mask >> j & 1]
        H, predicted = of.H[taken], symmetric(of.A @ P @ of.A.T + of.Q)
        gain, variances = decimals(np.zeros((of.n, of.m))), np.full(of.m, np.inf)
        variance = H @ predicted @ H.T + np.diag(of.R[taken])
        gain[:, taken], variances[taken] = predicted @ H.T @ inverse(variance), unit_lower(variance)[1].astype(float)
        P = symmetric(predicted - gain[:, taken] @ H @ predicted)
        made.append(Row(mask, predicted, P, gain, variances))
    return made


class CycleText(Text):
    """The functions of a filter whose cycle of rows settles.  f->row: since the last full sample, LOST: not on time"""

    counter = ("row", "LOST")

    def __init__(self, given: Request, a: Arithmetic, cycle: Cycle):
        super().__init__(given, a)
        self.cycle, self.length, self.settles = cycle, len(cycle.rows), True

    def _constants(self) -> str:
        a, rows = self.a, self.cycle.rows
        factors = [P for k, row in enumerate(rows) for P in (rows[k - 1].filtered, row.predicted)]
        literals = [", ".join(a.factor_literals(P)) or "0" for P in factors]
        gains = [", ".join(one) for one in a.gain_literals(self.cycle.gains)]
        return "\n".join([
            f"enum {{ ROWS = {self.length}, LOST = {self.length + 1} }};",
            f"#define SETTLED UINT32_C({2 * self.length * self.cycle.cycles}) /* calls: {self.cycle.cycles} cycles of so many rows */",
            f"static const {a.type} steady[{2 * self.length}][{max(len(a.live), 1)}] = {{ /* updated in a row, predicted to the next */",
            *(f"    {{{one}}}," for one in literals), "};",
            f"static const {a.type} gain[{self.length}][{self.given.of.n * self.given.of.m}] = {{", *(f"    {{{one}}}," for one in gains), "};",
            f"static const uint16_t due[{self.length}] = {{{', '.join(str(row.due) for row in rows)}}}; /* bits */", "", ""])

    def _factor(self) -> str:
        return "f->calls >= SETTLED ? steady[2u * f->row - (f->calls & 1u)] : f->P"

    def _leave(self) -> list[str]:
        return function(f"static void leave({self.filter})", [
            f"const {self.a.type} *from = steady[2u * f->row - (f->calls & 1u)];",
            f"for (int i = 0; i < {max(len(self.a.live), 1)}; i++) f->P[i] = from[i];", "f->calls &= 1u;",
            "f->row = LOST;"], "From the steady cycle on, the factor is carried again.")

    def _count_predict(self) -> list[str]:
        return ["if (f->calls > SETTLED) leave(f);", "if (f->row < LOST) f->row++;", "if (f->calls == SETTLED) {",
                "    f->calls++;", "    return;", "}", "if (f->calls & 1u) f->row = LOST;", "else f->calls++;"]

    def _leave_before(self) -> list[str]:
        return ["if (f->calls >= SETTLED) leave(f);"]

    def _count_update(self) -> list[str]:
        return ["const int is_due = (f->calls & 1u) && f->row < LOST && taken == due[f->row - 1];",
                "f->calls = is_due ? f->calls + 1u : 0u;", f"if (taken == {self.given.all}u) f->row = 0;",
                "else if (!is_due) f->row = LOST;"]

    def _settled_row(self) -> list[str]:
        """By the gain of its row; it returns."""
        a = self.a
        body = [f"const {a.type} *g = gain[f->row - 1];"]
        body += [f"const {a.type} y{j} = taken & {1 << j}u ? {a.innovation_text(j)} : {a.zero};"
                 for j in range(self.given.of.m)]
        added = {i: a.gained(i, self.cycle.gains, "g[{}]", "y{}") for i in range(self.given.of.n)}
        body += a.moved({i: text for i, text in added.items() if text})
        return [*self._measured(), *within(a.places(factor=False), body), "f->calls = SETTLED;",
                "if (f->row == ROWS) f->row = 0;", "return taken;"]

    def _update(self) -> list[str]:
        given = self.given
        call = f"unsigned {given.name}_update_some({self.filter}, {self.z}, unsigned present)"
        return [*function(call, [
            f"present &= {given.all}u;", f"unsigned taken = present & ({self._accepted()});", *self._whole_groups(),
            self._refused("present"), "if (f->calls == SETTLED + 1u && taken == due[f->row - 1]) {",
            *indented(self._settled_row()), "}", "return take(f, z, taken);"]),
            *function(f"unsigned {given.name}_update({self.filter}, {self.z})",
                      [f"return {given.name}_update_some(f, z, {given.all}u);"])]

    def _update_some(self) -> list[str]:
        return []

    def _step(self) -> list[str]:
        u = ", u" if self.given.inputs else ""
        return function(f"unsigned {self.given.name}_step({self.filter}{self.u}, {self.z})",
                        [f"{self.given.name}_predict(f{u});", f"return {self.given.name}_update(f, z);"])
