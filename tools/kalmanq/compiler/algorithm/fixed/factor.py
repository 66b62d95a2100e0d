"""The factor S of P = S S' in words of 32 bits: predict by reflections, update by rotations; no length grows.

Predict makes the columns of [A S, G] triangular, G G' = Q.  Two columns are turned by a rotation, more by one
reflection (Householder 1958): one inverse root and one inverse for each row.
Update, of a component with f = H_j S: after column c the variance is t_c = R + f_0^2 + ... + f_c^2, and column c turns
with b by the angle whose cosine is sqrt(t_(c-1) / t_c) (Carlson 1973).  Behind the last one b is gain times sqrt(t).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Optional, Sequence

import numpy as np

from kalmanq.compiler.algorithm.fixed.expressions import INVERSE, ROUNDED, Expressions, Value
from kalmanq.compiler.algorithm.fixed.formats import BITS, Formats, root_of, variance_word
from kalmanq.compiler.given.exact import Numbers, keys, ordered, root

Key = tuple[int, int]
Entries = dict[Key, Value]


@dataclass
class Column:
    entries: list[Value]

    def is_constant(self, row: int) -> bool:
        """A part of the row's length that is always there"""
        return isinstance(self.entries[row], int)


class Factor:
    """order: of the states in S; their numbers, from the first row to the last"""

    def __init__(self, of: Numbers, formats: Formats, order: Sequence[int]):
        order = self.order = list(order)
        self.formats, self.n = formats, of.n
        self.exact = ordered(of, order)
        self.of = self.exact.doubles()
        self.exponent = [formats.exponent[i] for i in order]
        self.held = [formats.held[i] for i in order]
        self.noise = [one for one in self._columns(self.exact.Q) if any(one.entries)]

    def words(self, P: np.ndarray, finer: int = 0) -> dict[Key, int]:
        """The root of a covariance, whose rows are in this order"""
        S = root(P).astype(float)
        return {(i, j): round(math.ldexp(S[i, j], BITS - self.exponent[i] + finer)) for i, j in keys(self.n)}

    def words_of(self, P: np.ndarray) -> dict[Key, int]:
        """The same of a covariance in the model's order"""
        return self.words(P[np.ix_(self.order, self.order)])

    def _columns(self, P: np.ndarray) -> list[Column]:
        made = self.words(P)
        return [Column([made.get((i, j)) or None for i in range(self.n)]) for j in range(self.n)]

    def scaled(self, c: float, k: int, i: int) -> float:
        """A coefficient between rows, of words"""
        return math.ldexp(c, self.exponent[k] - self.exponent[i])

    # ---- constants of a row

    def noises(self, lines: Expressions) -> list[Column]:
        """Of the root of Q"""
        return [Column(list(one.entries)) for one in self.noise]

    def variance(self, j: int) -> tuple[str, tuple[str, str]]:
        """R of component j, and mantissa and `half` of its root"""
        square = variance_word(self.formats.least[j], 2 * self.formats.row[j])
        root, half = root_of(square)
        return f"UINT64_C({square})", (str(root), str(half))

    # ---- predict

    def predict(self, lines: Expressions, S: Entries) -> Entries:
        columns = [Column([lines.weighed((self.scaled(self.of.A[i, k], k, i), S.get((k, c))) for k in range(c + 1))
                           for i in range(self.n)]) for c in range(self.n)]
        columns += self.noises(lines)
        after: Entries = {}
        for row in range(self.n - 1, -1, -1):
            parts = [one for one in columns if one.entries[row] is not None]
            if not parts:
                continue
            pivot = self._turned(lines, parts, row)
            columns = [one for one in columns if one is not pivot]
            after.update({(i, row): pivot.entries[i] for i in range(row + 1)})
        return after

    def _turned(self, lines: Expressions, parts: Sequence[Column], row: int) -> Column:
        """The column that takes all of a row; the others keep none of it."""
        if len(parts) == 1:
            return parts[0]
        pivot = next((one for one in parts if one.is_constant(row)), parts[0])
        others = [one for one in parts if one is not pivot]
        square = lines.squares(one.entries[row] for one in parts)
        if not row:
            pivot.entries[0] = self._length(lines, lines.root(square))
            return pivot
        first: Value = pivot.entries[row]
        if not pivot.is_constant(row):
            square = lines.let("t", square, "uint64_t")  # where all are 0 nothing turns
            first, square = lines.let("p", f"{first} + ({square} == 0)", cost=3), f"{square} + ({square} == 0)"
        r = lines.root(square)
        turns = [lines.fraction(first, r), *(lines.fraction(one.entries[row], r) for one in others)]
        if len(parts) == 2:
            self._rotate(lines, pivot, others[0], turns, row)
        else:
            self._reflect(lines, pivot, others, turns, row)
        pivot.entries[row] = self._length(lines, r)
        for one in others:
            one.entries[row] = None
        return pivot

    def _length(self, lines: Expressions, r: str) -> str:
        return lines.let("w", f"word({r})", cost=5)

    def _rotate(self, lines: Expressions, pivot: Column, other: Column, turns: Sequence[str], row: int) -> None:
        c, s = turns
        for i in range(row):
            p, e = pivot.entries[i], other.entries[i]
            pivot.entries[i] = lines.mixed([(c, p), (s, e)])
            other.entries[i] = lines.mixed([(c, e)], [(s, p)])

    def _reflect(self, lines: Expressions, pivot: Column, others: Sequence[Column], turns: Sequence[str], row: int) -> None:
        """I - v v' / (1 + |u|), where u are the turns, and v is u with its pivot's 1 + |u|: nothing cancels."""
        weight = lines.let("v", f"inverse({turns[0]})", cost=INVERSE)
        is_positive = pivot.is_constant(row) and pivot.entries[row] > 0
        signed = weight if is_positive else lines.let("v", f"{turns[0]} < 0 ? -{weight} : {weight}", cost=3)
        for i in range(row):
            entries = [pivot.entries[i], *(one.entries[i] for one in others)]
            made = lines.mixed(zip(turns, entries))
            if made is None:
                continue
            text = lines.products([(made, weight), (entries[0], signed)])
            half = lines.let("h", f"half_part({text})", cost=ROUNDED)
            for turn, one in zip(turns[1:], others):
                one.entries[i] = self._less(lines, one.entries[i], turn, half)
            pivot.entries[i] = made

    def _less(self, lines: Expressions, entry: Value, turn: str, half: str) -> str:
        lines.cost += ROUNDED
        text = lines.product(turn, half)
        return lines.let("w", f"{entry or ''}{' ' if entry else ''}- twice_part({text})", cost=ROUNDED)

    def too_long(self, lines: Expressions, S: Entries) -> str:
        """C: is a row of S beyond what is held?"""
        sums: dict[int, list[str]] = {}
        for i in range(self.n):
            row = [S[i, k] for k in range(i, self.n) if S.get((i, k)) is not None]
            if row:
                top = 2 * (BITS - self.exponent[i] + self.held[i])
                sums.setdefault(top, []).append(lines.squares(row))
        return " || ".join(f"({' | '.join(f'({one})' for one in each)}) >> {top}" for top, each in sums.items())

    # ---- update

    def _seen(self, lines: Expressions, S: Entries, j: int, c: int) -> Value:
        """Entry c of H_j S"""
        a = self.formats.row[j]
        return lines.weighed(((math.ldexp(self.of.H[j, i], self.exponent[i] - a), S.get((i, c))) for i in range(c + 1)), "f")

    def spread(self, lines: Expressions, S: Entries, j: int) -> str:
        """The name of H_j P H_j'"""
        seen = [self._seen(lines, S, j, c) for c in range(self.n)]
        return lines.let("q", lines.squares(f for f in seen if f is not None) or "0", "uint64_t")

    def update(self, lines: Expressions, S: Entries, j: int, weight: Value = None) -> tuple[Entries, list[Value], Optional[str]]:
        """S after component j, gain times sigma of the innovation, and the name of the inverse of that sigma; weight: of
        the component and its innovation"""
        total, before = self.variance(j)
        b: list[Value] = [None] * self.n
        after, last = dict(S), None
        for c in range(self.n):
            f = self._seen(lines, S, j, c)
            if f is None:
                continue
            f = f if weight is None else lines.mixed([(weight, f)], base="g")
            total = lines.let("t", f"{total} + {lines.squares([f])}", "uint64_t")
            last = lines.root(total)
            u = lines.fraction(f, last)
            k = lines.let("k", f"ratio({before[0]}, {before[1]}, {last})", cost=5)
            before = f"{last}.root", f"{last}.half"
            for i in range(c + 1):
                entry = S.get((i, c))
                after[i, c] = lines.mixed([(k, entry)], [(u, b[i])])
                b[i] = lines.mixed([(k, b[i]), (u, entry)], base="b")
        return after, b, last


def entry(key: Key) -> str:
    i, j = key
    return f"s{i}{'_' if max(key) > 9 else ''}{j}"


def number_of(value: Value) -> str:
    return "0" if value is None else str(value)
