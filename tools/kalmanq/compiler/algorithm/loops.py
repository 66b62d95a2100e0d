"""The factor of a large model in loops: a kilobyte in the place of tens, for more instructions.

The same UD algorithms as in ud.py, over arrays: Thornton's predict and Bierman's update.  The mean stays in straight
lines, because A and H are sparse.
"""

from __future__ import annotations

from typing import Callable, Iterable

import numpy as np

from kalmanq.compiler.algorithm import ud
from kalmanq.compiler.algorithm.floats import LEAST, FloatFilter
from kalmanq.compiler.given import slow
from kalmanq.compiler.given.request import RUN
from kalmanq.compiler.templates.engine import rendered
from kalmanq.formulas.graph import symbol
from kalmanq.formulas.printing import Body


class LoopedFilter(FloatFilter):
    """As FloatFilter; all entries of the factor are carried."""

    updates_at_once = False

    def _find_entries(self) -> None:
        self.form, self.live = ud.UD(), ud.keys(self.of.n)
        self.facts = {key: key for key in self.live}

    def _adds_to(self, key: ud.Key) -> bool:
        return key[0] == key[1] and slow.change(self._predicted(self.form, self.entries)[key], self.entries[key]) is not None

    @property
    def _low(self) -> str:
        return ", f->P_low" if self.slow else ""

    def predict_factor(self) -> list[str]:
        return [f"predict_factor(f->P{self._low});"]

    def update(self, j: int) -> list[str]:
        options, n = self.given.options, self.of.n
        before, y = self.innovation_text(j)
        lines = [*before, f"const {self.type} y = {y};"]
        r = self.number(self.of.R[j])
        if options.student or options.gate is not None or options.nis:
            lines.append(f"const {self.type} s = spread(f->P, H[{j}]);")
        if options.student:
            made = Body(self.words)
            text = made.assign([("r", self._student(symbol("y"), symbol("s"), j))])
            lines += [*text[:-1], f"const {self.type} {text[-1]}"]
            r = "r"
        taken = [f"{self.type} b[{n}];", f"const {self.type} moved = y * update_factor(f->P, H[{j}], {r}, b{self._low});",
                 *(f"l{i} += b[{self.order.index(i)}] * moved;" for i in range(n))]
        if options.nis:
            taken += [f"f->s[{j}] = s + {self.number(self.of.R[j])};", f"f->nis += y * y / f->s[{j}];"]
        if options.gate is None:
            return [*lines, *taken]
        return [*lines, f"const int is_near = y * y <= {self.number(options.gate**2)} * (s + {r});",
                f"if (is_near || f->rejected[{j}] >= {RUN}) {{",
                *(f"    {line}" for line in (*taken, f"if (is_near) f->rejected[{j}] = 0;")), "} else {",
                f"    f->rejected[{j}]++;", f"    f->events |= {self.given.upper}_GATED;", f"    taken &= ~{1 << j}u;", "}"]

    def routines(self, text: str) -> str:
        r = len(self.coefficients.noise())
        return rendered("loops.c.j2", {
            "T": self.type, "n": self.of.n, "r": r, "columns": self.of.n + r, "zero": self.number(0), "one": self.number(1),
            "least": self.number(LEAST[self.type]), "is_slow": bool(self.slow), "has_spread": "spread(f->P" in text, "tables": self._tables()}) + "\n"

    def _tables(self) -> list[str]:
        """A by its entries that are not 0, the factor of Q, H"""
        of, noise = self.of, self.coefficients.noise(self.order)
        A, at = self._in_order(of.A), [str(self.slow.index((k, k)) if (k, k) in self.slow else of.n) for k in range(of.n)]
        weights = [one.weight.value for one in noise] or [0]
        entries = [[one.entries[i].value for one in noise] or [0] for i in range(of.n)]
        return [*sparse(A, self.type, lambda i, k: self.number(A[i, k])), *(table("uint8_t", "at", [at]) if self.slow else []),
                *table(self.type, "q", [map(self.number, weights)]),
                *table(self.type, "noise", [map(self.number, row) for row in entries], True),
                *table(self.type, "H", [map(self.number, self.row(j)) for j in range(of.m)], True)]


def table(type_: str, name: str, rows: Iterable[Iterable[str]], is_matrix: bool = False) -> list[str]:
    """A constant array, of one row or as a matrix"""
    made = [list(row) for row in rows]
    texts = [f"{{{', '.join(row)}}}" for row in made]
    if not is_matrix:
        return [f"static const {type_} {name}[{len(made[0])}] = {texts[0]};"]
    return [f"static const {type_} {name}[{len(made)}][{len(made[0])}] = {{", *(f"    {text}," for text in texts), "};"]


def sparse(A: np.ndarray, type_: str, value: Callable[[int, int], str]) -> list[str]:
    """A by its entries that are not 0, as value() writes them"""
    places = [(i, k) for i, row in enumerate(A) for k, one in enumerate(row) if one]
    first = [str(sum(i < row for i, _ in places)) for row in range(len(A) + 1)]
    return [*table("int16_t", "a_first", [first]), *table("uint8_t", "a_column", [[str(k) for _, k in places]]),
            *table(type_, "a_value", [[value(i, k) for i, k in places]])]
