"""q31: the factor of a large model in loops, as the other loops.py has it for floats: fewer bytes, for more instructions.

The same reflections and rotations as in factor.py, over arrays; what is 0 in a row is left out as the program runs.
The mean stays in straight lines.
"""

from __future__ import annotations

import math
from typing import Optional, Sequence

from kalmanq.compiler.algorithm.fixed.expressions import Expressions, Value
from kalmanq.compiler.algorithm.fixed.factor import Factor, Key, keys
from kalmanq.compiler.algorithm.fixed.formats import BITS, down, root_of, variance_word
from kalmanq.compiler.algorithm.fixed.lines import word_of
from kalmanq.compiler.algorithm.fixed.words import WordFilter
from kalmanq.compiler.algorithm.loops import sparse, table
from kalmanq.compiler.templates.engine import rendered


class LoopedWords(WordFilter):
    """As WordFilter; all entries of the factor are carried."""

    def _orders(self) -> list[tuple[int, ...]]:
        return [tuple(range(self.of.n))]

    def _in_order(self, order: Sequence[int]) -> tuple[Factor, list[Key], int]:
        factor, self.there, cost = super()._in_order(order)
        return factor, keys(self.of.n), cost

    def predict_factor(self) -> list[str]:
        return [f"if (predict_factor(f->P) != 0) {self.event('SIGMA_SATURATED')}"]

    def _spread(self, lines: Expressions, j: int) -> str:
        text = f"seen(f->P, H[{j}], {self._seen()[j][1]}, f{j})"
        if (text, ()) not in lines.known:
            lines.do(f"int32_t f{j}[{self.of.n}];")
        return lines.let("q", text, "uint64_t")

    def _updated(self, lines: Expressions, j: int, weight: Value) -> tuple[list[Value], Optional[str], list[str], list[str]]:
        n, f, there = self.of.n, f"f{j}", {key: "s" for key in self.there}
        moves = [one is not None for one in self.factor.update(Expressions(), there, j)[1]]
        if not any(moves):
            return [], None, [], []
        spread, square = self._spread(lines, j), variance_word(self.formats.least[j], 2 * self.formats.row[j])
        if weight is not None:
            lines.do(f"for (int c = 0; c < {n}; c++) {f}[c] = part(product({weight}, {f}[c]));")
            spread = f"16 * (uint64_t)wide({weight}, wide({weight}, (int64_t){spread}))"
        last = lines.root(f"UINT64_C({square}) + {spread}")
        root, half = root_of(square)
        return [f"b[{i}]" if moves[i] else None for i in range(n)], last, [
            f"int32_t b[{n}];", f"update_factor(f->P, {f}, UINT64_C({square}), {root}, {half}, b);"], []

    def routines(self, text: str) -> str:
        n, r = self.of.n, len(self.factor.noise)
        made = rendered("word_loops.c.j2", {"n": n, "r": r, "columns": n + r, "tables": self._tables()}) + "\n"
        return super().routines(made + text) + made

    def _seen(self) -> list[tuple[list[float], int]]:
        """Rows of H between words, and the digits of their words"""
        factor, f = self.factor, self.formats
        rows = [[math.ldexp(h, e - a) for h, e in zip(row, factor.exponent)] for row, a in zip(self.of.H, f.row)]
        return [(row, digits(row)) for row in rows]

    def _tables(self) -> list[str]:
        """A by its entries that are not 0, the root of Q, H, and the length of a row that is too long"""
        n, factor = range(self.of.n), self.factor
        A = [[factor.scaled(self.of.A[i, k], k, i) for k in n] for i in n]
        by = [digits(row) for row in A]
        top = [2 * (BITS - e + held) for e, held in zip(factor.exponent, factor.held)]
        return [*sparse(self.of.A, "int32_t", lambda i, k: str(word_of(A[i][k], by[i]))),
                *table("uint8_t", "a_digits", [map(str, by)]), *table("uint8_t", "top", [map(str, top)]),
                *table("int32_t", "noise", [[str(one.entries[i] or 0) for one in factor.noise] or ["0"] for i in n], True),
                *table("int32_t", "H", [[str(word_of(h, by)) for h in row] for row, by in self._seen()], True)]


def digits(row: Sequence[float]) -> int:
    """Of the words of a row's coefficients"""
    most = max(map(abs, row))
    return min(30 - down(most), 60) if most else 30
