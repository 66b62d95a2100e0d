"""A step back of the smoother of Rauch, Tung and Striebel as an algorithm over nodes, with UD factors.

With x of then and x+ of the next instant, the columns
    [ U      0 ]  weights D        made triangular in the rows of x+ are  [ rest   C U+ ]
    [ A U    G ]          q                                               [ 0        U+ ]
with C = P A' (P+)^-1, and `rest` the columns of the covariance of x given x+.  So P given all is rest + C P+ given all C',
made triangular: a sum of what is not negative, without a difference.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Callable, Sequence

from kalmanq.compiler.algorithm import ud
from kalmanq.formulas.graph import Node, constant, dot, symbol

Rows = Sequence[Sequence[Node]]


@dataclass
class Back:
    """The predicted factor U+, C U+ (rows of the states), and `rest`"""

    form: ud.UD
    ahead: ud.Entries
    cross: Rows
    rest: list[ud.Column]

    @classmethod
    def of(cls, form: ud.UD, A: Sequence[ud.Row], noise: Sequence[ud.Column], P: ud.Entries) -> Back:
        form, n, zero = replace(form, guards=True), len(A), constant(0)
        columns = [ud.Column(one.weight, [zero] * n + list(one.entries)) for one in noise]  # first: what rotations start from
        columns += [ud.Column(one.weight, [*unit(P, c, n), *one.entries]) for c, one in enumerate(ud.times(A, P))]
        made, rest = form.reduced(columns, range(2 * n - 1, n - 1, -1))
        ahead = {(i, j): made[n + i, n + j] for i, j in ud.keys(n)}
        return cls(form, ahead, [[made[i, n + j] for j in range(n)] for i in range(n)], rest)

    def solved(self, column: Sequence[Node]) -> list[Node]:
        """U+ to the power -1, times a column"""
        made = list(column)
        for j in range(len(made) - 1, 0, -1):
            for i in range(j):
                made[i] = made[i] - self.ahead[i, j] * made[j]
        return made

    def moved(self, column: Sequence[Node]) -> list[Node]:
        """C times a column"""
        made = self.solved(column)
        return [dot(zip(row, made)) for row in self.cross]

    def smoothed(self, P: ud.Entries) -> ud.Entries:
        """P: that of the next instant, given all"""
        n = len(self.cross)
        columns = [ud.Column(one.weight, one.entries[:n]) for one in self.rest]
        columns += [ud.Column(P[c, c], self.moved(unit(P, c, n))) for c in range(n)]
        return replace(self.form, rotates=False).triangular(columns, n)


def unit(P: ud.Entries, c: int, n: int) -> list[Node]:
    """Column c of U"""
    return [P[i, c] if i < c else constant(float(i == c)) for i in range(n)]


def transfer(form: ud.UD, A: Sequence[ud.Row], noise: Sequence[ud.Column]) -> Callable[[ud.Entries], ud.Entries]:
    """What becomes of entries by a step back: what `facts` finds holds for a smoothed filter, too"""
    def given_all(P: ud.Entries) -> ud.Entries:
        later = {key: one if one.is_constant else symbol(f"later {one.args[0]}") for key, one in P.items()}
        return Back.of(form, A, noise, dict(P)).smoothed(later)

    return given_all
