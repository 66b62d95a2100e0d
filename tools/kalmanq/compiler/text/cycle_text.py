"""NAME.c of sensors at different rates: rows of a table."""

from __future__ import annotations

from typing import Any

from kalmanq.compiler.algorithm.arithmetic import Arithmetic
from kalmanq.compiler.algorithm.cycle import Cycle
from kalmanq.compiler.text.emit import Text, within


class CycleText(Text):
    """Of a filter whose cycle of rows settles"""

    counter = "row"

    def __init__(self, a: Arithmetic, cycle: Cycle):
        super().__init__(a)
        self.cycle, self.settles = cycle, True

    def _factor(self) -> str:
        return "f->calls >= SETTLED ? steady[2u * f->row - (f->calls & 1u)] : f->P"

    def _steady(self) -> dict[str, Any]:
        a, rows = self.a, self.cycle.rows
        factors = [P for k, row in enumerate(rows) for P in (rows[k - 1].filtered, row.predicted)]
        return {"cycle": {"rows": len(rows), "cycles": self.cycle.cycles, "due": [row.due for row in rows], "settled_row": self._settled_row(),
                          "factors": [f"{{{', '.join(a.factor_literals(P)) or '0'}}}," for P in factors],
                          "gains": [f"{{{', '.join(one)}}}," for one in a.gain_literals(self.cycle.gains)]}}

    def _settled_row(self) -> list[str]:
        """By the gain of its row"""
        a = self.a
        body = [f"const {a.type} *g = gain[f->row - 1];"]
        for j in range(self.given.of.m):
            lines, y = a.innovation_text(j)
            body += [*lines, f"const {a.type} y{j} = (taken & {1 << j}u) != 0u ? {y} : {a.zero};"]
        added = {i: a.gained(i, self.cycle.gains, "g[{}]", "y{}") for i in range(self.given.of.n)}
        body += a.moved({i: text for i, text in added.items() if text})
        return [*self.measured(), *within(a.places(factor=False), body)]
