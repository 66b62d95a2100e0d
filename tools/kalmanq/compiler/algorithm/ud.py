"""P = U D U', U unit upper triangular, as an algorithm over nodes: it cannot lose positive definiteness.

Predict makes the columns of [A U, G] triangular by rotations without square roots (Gentleman 1973), or by Gram and
Schmidt with weights (Thornton 1976), whichever is shorter.  Update is Bierman's (1977).  There is no difference in D.
Entry (i, j) with i < j is U_ij; entry (j, j) is D_j.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Optional, Sequence

import numpy as np

from kalmanq.compiler.given.exact import decimals, keys, root
from kalmanq.formulas.graph import Given, Node, constant, dot, inverse, make, node, select

Key = tuple[int, int]
Entries = dict[Key, Node]
Row = Sequence[Given]
ZERO, ONE = 0.0, 1.0
ROUNDED = 2.0**-50  # of a variance of Q
ROUNDING = 2.0**-52  # of a double, as a share of a sigma
NEAR = 0.5  # 1, a coefficient above this
LEAST = 1e-36  # a D below this is 0: its inverse would overflow a float


def factor(P: np.ndarray) -> dict[Key, float]:
    """U and D of a covariance, which may be singular"""
    S = root(P if P.dtype == object else decimals(P))
    return {(i, j): float(S[j, j]**2 if i == j else S[i, j] / S[j, j] if S[j, j] else 0) for i, j in keys(len(P))}


@dataclass
class Column:
    """weight * entries * entries', a part of a covariance"""

    weight: Node
    entries: list[Node]


@dataclass(frozen=True)
class UD:
    """rotates: predict by rotations where a column allows it; guards: D may become 0, so no inverse is taken of a D
    below `least`; lasts: no coefficient near 1 is rounded, and a rotation begins with the state's own column, by which the others are
    small"""

    rotates: bool = True
    guards: bool = False
    least: float = LEAST
    lasts: bool = False

    def predict(self, A: Sequence[Row], noise: Sequence[Column], P: Entries) -> Entries:
        moved = (scaled if self.lasts else times)(A, P)
        return self.triangular([*moved, *(Column(one.weight, list(one.entries)) for one in noise)], len(A))

    def update(self, h: Row, r: Given, P: Entries, y: Given = ZERO, low: Optional[Entries] = None,
               by_column: bool = False) -> tuple[list[Node], Node, Entries]:
        """Of one component with variance r and innovation y: what it adds to the mean, the inverse of its innovation's variance,
        and P afterwards.  low: low parts of entries in two numbers, which become those afterwards; by_column: the last column's part
        of P H' is added to the mean by itself, which takes a register less"""
        after, low, variance = {}, {} if low is None else low, node(r)
        weight, products = inverse(variance), [constant(0)] * len(h)
        last, v, before_last = 0, constant(0), products
        for c in range(len(h)):
            f = node(h[c]) + dot((h[i], P[i, c]) for i in range(c))
            if f.equals(0):
                after.update({(i, c): P[i, c] for i in range(c + 1)})
                continue
            last, v, before_last = c, P[c, c] * f, list(products)
            total, before = variance + f * v, weight
            weight = inverse(total)
            ratio = variance * weight
            after[c, c] = P[c, c] * ratio
            if (c, c) in low:  # by what the product has been rounded, the ratio near 1 above all
                low[c, c] = ratio * (make("sub", P[c, c], after[c, c]) - v * (v * weight) + low[c, c])
            share = f * before
            for i in range(c):
                after[i, c] = P[i, c] - share * products[i]
                if (i, c) in low:
                    after[i, c], low[i, c] = carried(P[i, c], low[i, c] - share * products[i])
                products[i] = products[i] + P[i, c] * v
            products[c] = v
            variance = total
        step = y * weight
        added = [one * step for one in products]
        if by_column:
            added[:last] = [one * step + P[i, last] * (v * step) for i, one in enumerate(before_last[:last])]
        return added, weight, after

    def triangular(self, columns: list[Column], n: int) -> Entries:
        return self.reduced(columns, range(n - 1, -1, -1))[0]

    def reduced(self, columns: list[Column], rows: Sequence[int]) -> tuple[Entries, list[Column]]:
        """U and D of some rows, the last one first, and the columns of what is left: of the rows above, given these"""
        after: Entries = {}
        own = columns[:len(rows)] if self.lasts else [None] * (1 + max(rows))
        for row in rows:
            parts = sorted((one for one in columns if not one.entries[row].equals(0)), key=lambda one: one is not own[row])
            pivot = next((one for one in parts if one.entries[row].equals(1) and self.rotates), None)
            if not parts:
                after.update({(i, row): constant(0) for i in range(row + 1)})
            elif pivot is not None:
                columns = [one for one in columns if one is not pivot]
                after.update(self._rotated(pivot, [one for one in parts if one is not pivot], row))
            elif len(parts) == 1 and all(entry.equals(0) for entry in parts[0].entries[:row]):
                columns = [one for one in columns if one is not parts[0]]
                last = parts[0].entries[row]
                after.update({(i, row): constant(0) for i in range(row)})
                after[row, row] = parts[0].weight * last * last
            else:
                after.update(self._projected(parts, row))
        return after, columns

    def _rotated(self, pivot: Column, others: Sequence[Column], row: int) -> Entries:
        """The pivot's entry is 1, so nothing is divided by an entry that may be small."""
        d, u, is_sure = pivot.weight, pivot.entries, _is_noise(pivot, row)
        for one in others:
            f = one.entries[row]
            total = d + one.weight * f * f
            is_sure = is_sure or _is_noise(one, row)
            if row or one is not others[-1]:
                w = self._inverse(total, is_sure)
                turn = one.weight * f * w
                one.weight = d * turn if f.equals(1) else one.weight * (d * w)
                for i in range(row):
                    one.entries[i] = one.entries[i] - f * u[i]
                    u[i] = u[i] + turn * one.entries[i]
            one.entries[row] = constant(0)
            d = total
        return {(row, row): d, **{(i, row): u[i] for i in range(row)}}

    def _projected(self, parts: Sequence[Column], row: int) -> Entries:
        """Gram and Schmidt: no column less"""
        weighed = [one.weight * one.entries[row] for one in parts]
        d = dot((v, one.entries[row]) for v, one in zip(weighed, parts))
        if not row:
            return {(0, 0): d}
        w = self._inverse(d, any(_is_noise(one, row) for one in parts))
        u = [dot((v, one.entries[i]) for v, one in zip(weighed, parts)) * w for i in range(row)]
        for one in parts:
            for i in range(row):
                one.entries[i] = one.entries[i] - one.entries[row] * u[i]
            one.entries[row] = constant(0)
        return {(row, row): d, **{(i, row): u[i] for i in range(row)}}

    def _inverse(self, d: Node, is_sure: bool) -> Node:
        """1 / d, or 0 where d may be 0: without noise a state that decays has D = 0 one day"""
        return inverse(d) if is_sure or not self.guards else select(d < self.least, ZERO, inverse(d))


def _is_noise(one: Column, row: int) -> bool:
    """A part of D that is always there"""
    entry = one.entries[row]
    return one.weight.is_constant and entry.is_constant and one.weight.value * entry.value**2 > LEAST


def carried(high: Node, change: Node) -> tuple[Node, Node]:
    """high + change in two numbers"""
    total = high + change
    return total, change - make("sub", total, high) if total is not high else change


def factor_of_noise(Q: np.ndarray) -> dict[Key, float]:
    """Without what G G' is rounded by, of fewer columns than states"""
    return {(i, j): 0.0 if i == j and one <= ROUNDED * float(Q[i, i]) else one for (i, j), one in factor(Q).items()}


def columns_of_noise(Q: np.ndarray) -> list[Column]:
    q, n = factor_of_noise(Q), len(Q)

    def part(i: int, c: int) -> float:
        """Of a state's noise; 0 where it is less than the rounding of Q's doubles"""
        is_there = q[i, c]**2 * q[c, c] > ROUNDING**2 * float(Q[i, i])
        return q[i, c] if is_there else ZERO

    return [Column(node(q[c, c]), [node(part(i, c) if i < c else float(i == c)) for i in range(n)]) for c in range(n) if q[c, c]]


def factored(Q: Sequence[Row], least: float, wrong: float, most: float) -> tuple[list[Column], list[Node]]:
    """U and D of a covariance of formulas, and what is `most` where it is none.  Shares of a variance: `least`, which counts as 0,
    and `wrong`, below 0 more than rounding makes it"""
    left, columns, improper = [[node(one) for one in row] for row in Q], [], []
    for j in range(len(Q) - 1, -1, -1):
        d, floor = left[j][j], left[j][j] if left[j][j] is node(Q[j][j]) else node(Q[j][j]) * least
        if d.equals(0):
            continue
        is_there = node(0.0) < d if d is floor else floor < d
        above = [left[i][j] for i in range(j)]
        share = select(is_there, inverse(d), ZERO) if any(not one.equals(0) for one in above) else node(0.0)
        column = [one * share for one in above]
        for i in range(j):
            for k in range(i + 1):
                left[k][i] = left[k][i] - column[i] * above[k]
        columns.append(Column(select(is_there, d, ZERO), [*column, node(ONE), *[node(ZERO)] * (len(Q) - j - 1)]))
        improper.append(select(d < (node(ZERO) if d is floor else node(Q[j][j]) * -wrong), most, ZERO))
    return columns, improper


def lower(R: Sequence[Row]) -> tuple[list[list[Node]], list[Node]]:
    """The inverse of L and D, R = L D L', of formulas: what makes noises independent, and their variances"""
    m, made, variances = len(R), [], []
    for j in range(m):
        row = [node(float(j == k)) for k in range(m)]
        for k in range(j):  # less what the noises before say of it
            weight = dot((made[k][i], R[j][i]) for i in range(k + 1))
            if not weight.equals(0):
                share = weight * inverse(variances[k])
                row = [one - share * other for one, other in zip(row, made[k])]
        made.append(row)
        variances.append(dot((one, R[j][i]) for i, one in enumerate(row)))
    return made, variances


def by_state(columns: Sequence[Column], form: UD, n: int) -> list[Column]:
    """The same noise as columns that end in a 1, each in another row"""
    last = [max((i for i, one in enumerate(each.entries) if not one.equals(0)), default=-1) for each in columns]
    if all(i >= 0 and each.entries[i].equals(1) for i, each in zip(last, columns)) and len(set(last)) == len(last):
        return list(columns)
    made = replace(form, guards=True).triangular([Column(one.weight, list(one.entries)) for one in columns], n)
    return [Column(made[c, c], [made[i, c] if i < c else node(float(i == c)) for i in range(n)]) for c in range(n)
            if not made[c, c].equals(0)]


def times(A: Sequence[Row], P: Entries) -> list[Column]:
    """The columns of A U, with their weights D"""
    n = len(A)
    return [Column(P[c, c], [dot((row[k], ONE if k == c else P[k, c]) for k in range(c + 1)) for row in A])
            for c in range(n)]


def scaled(A: Sequence[Row], P: Entries) -> list[Column]:
    """The same, each column over its A_cc: what is near 1 is 1 and the rest"""
    made = []
    for c in range(len(A)):
        by = A[c][c].value if A[c][c].is_constant and A[c][c].value > NEAR else ONE
        entries = []
        for i, row in enumerate(A):
            own = P[i, c] if i < c else node(float(i == c))
            share = row[i].value / by
            first = own + own * (share - 1) if i < c and share > NEAR else own * share
            entries.append(dot(((row[k].value / by, ONE if k == c else P[k, c]) for k in range(c + 1) if k != i), first))
        made.append(Column(P[c, c] + P[c, c] * (by * by - 1), entries))
    return made
