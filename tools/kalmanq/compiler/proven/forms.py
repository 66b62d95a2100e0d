"""The filter's algorithms, as one would write them with loops, over sums that fold.

A form carries entries of the covariance, or of its root, under keys (i, j).  `words` is the arithmetic (floats.py,
fixed.py): it gives sums their names, and in fixed point their formats.
"""

from __future__ import annotations

from dataclasses import dataclass
from decimal import Decimal
from typing import Any, Callable, Sequence

import numpy as np

from kalmanq.compiler.exact import Numbers, inverse, upper
from kalmanq.compiler.proven.lines import Lines
from kalmanq.compiler.proven.sums import Sum

Key = tuple[int, int]
Entries = dict[Key, Sum]
Mean = list[list[Sum]]
Keep = Callable[[int, Sum, Sum, Sum], None]  # told of an update: component, innovation, 1 / variance, variance


@dataclass(frozen=True)
class Subject:
    """A model in an arithmetic: its numbers, words, mean, and what its states and measurements are called in C."""

    of: Numbers
    words: Any
    mean: Any
    states: Sequence[str]
    measurements: Sequence[str]
    controls: Sequence[str]

    def pair(self, letter: str, i: int, j: int) -> str:
        return f"{letter}_{self.states[i]}_{self.states[j]}"


def entry(P: Entries, i: int, j: int) -> Sum:
    return P[min(i, j), max(i, j)]


class ConstantGain:
    """Nothing is carried beside the mean."""

    name = "constant gain"
    has_roots = False

    def values(self, P: np.ndarray) -> dict[Key, Decimal]:
        return {}

    def covariance(self, n: int, value: Callable[[Key], str]) -> dict[Key, str]:
        return {}


class Covariance:
    """The upper triangle of P.  A component that measures one state makes that state's row R/h k, a product, where
    P - K S K' would be a difference of near numbers."""

    name = "covariance"
    is_product = True
    has_roots = False

    def keys(self, n: int) -> list[Key]:
        return list(upper(n))

    def values(self, P: np.ndarray) -> dict[Key, Decimal]:
        return {key: P[key] for key in self.keys(len(P))}

    def field(self, s: Subject, key: Key) -> str:
        return s.pair("p", *key)

    def word(self, s: Subject, key: Key) -> object:
        return s.words.covariance(*key)

    def predict(self, s: Subject, lines: Lines, P: Entries) -> Entries:
        n, A, known = s.of.n, s.of.A, {}

        def crossed(i: int, k: int) -> Sum:
            """(A P)_ik"""
            if (i, k) not in known:
                value = Sum()
                for l in range(n):
                    value = value + entry(P, l, k) * A[i][l]
                known[i, k] = value if value.parts <= 1 else \
                    s.words.name(lines, s.pair("t", i, k), value, s.words.cross(i, k), "A P")
            return known[i, k]

        made = {}
        for i, j in self.keys(n):
            made[i, j] = Sum(s.of.Q[i][j])
            for k in range(n):
                if A[j][k]:
                    made[i, j] = made[i, j] + crossed(i, k) * A[j][k]
        return {key: s.words.name(lines, s.pair("p", *key), value, self.word(s, key)) for key, value in made.items()}

    def update(self, s: Subject, lines: Lines, x: Mean, P: Entries, j: int, z: Sum, keep: Keep) -> tuple[Mean, Entries]:
        n, h, R, words, measured = s.of.n, s.of.H[j], s.of.R[j], s.words, s.measurements[j]
        seen = [i for i in range(n) if h[i]]
        row = [self._measured(s, lines, P, i, j, seen) for i in range(n)]
        variance = Sum(R)
        for i in seen:
            variance = variance + row[i] * h[i]
        variance = words.name(lines, f"s_{measured}", variance, words.variance(j), "variance of the innovation")
        w = words.reciprocal(lines, f"w_{measured}", variance, j)
        y = s.mean.innovation(lines, x, j, z, f"y_{measured}", "innovation")
        gain = [words.gained(lines, f"k_{s.states[i]}", row[i], w, j, i) for i in range(n)]
        keep(j, y, w, variance)
        last, made = j == s.of.m - 1, {}
        if not last:
            x = [s.mean.correct(lines, i, x[i], gain[i] * y) for i in range(n)]
        for a, b in self.keys(n):
            if self.is_product and len(seen) == 1 and seen[0] in (a, b):
                value = gain[a + b - seen[0]] * (R / h[seen[0]])
            else:
                value = entry(P, a, b) - gain[a] * row[b]
            made[a, b] = words.name(lines, s.pair("p", a, b), value, self.word(s, (a, b)))
        if last:  # right before it is stored: compilers then share the stores with those of a settled row
            x = [s.mean.correct(lines, i, x[i], gain[i] * y) for i in range(n)]
        return x, made

    def _measured(self, s: Subject, lines: Lines, P: Entries, i: int, j: int, seen: Sequence[int]) -> Sum:
        """(P h)_i"""
        value = Sum()
        for l in seen:
            value = value + entry(P, i, l) * s.of.H[j][l]
        return s.words.named_row(lines, f"h_{s.states[i]}", value, j, i)

    def covariance(self, n: int, value: Callable[[Key], str]) -> dict[Key, str]:
        """C texts of the entries of P, of the texts of what is carried; an empty text is 0"""
        return {key: value(key) for key in self.keys(n)}


class PlainCovariance(Covariance):
    """P - K S K' in all entries."""

    name = "plain covariance"
    is_product = False


def update_by_gain(s: Subject, lines: Lines, x: Mean, z: Sequence[Sum], gain: np.ndarray) -> tuple[Mean, list[Sum]]:
    """The mean and the innovations, all of them of the prediction."""
    y = [s.mean.innovation(lines, x, j, z[j], f"y_{s.measurements[j]}", "innovation", True) for j in range(s.of.m)]
    made = []
    for i in range(s.of.n):
        change = Sum()
        for j in range(s.of.m):
            change = change + y[j] * gain[i][j]
        made.append(s.mean.correct(lines, i, x[i], change))
    return made, y


# ------------------------------------------------------------------------------ NIS


@dataclass(frozen=True)
class Judged:
    """A component that was taken: its innovation, 1 / variance and variance"""

    component: int
    innovation: Sum
    inverse: Sum
    variance: Sum


def judged_unsettled(s: Subject, lines: Lines, kept: Sequence[Judged]) -> str:
    """The C text of y y / s, summed over components that were taken one after the other"""
    parts = [(one.component, s.words.weighed(lines, f"n_{s.measurements[one.component]}", one.innovation * one.inverse,
                                             one.component), one.innovation) for one in kept]
    return s.words.nis(lines, parts)


def judged_settled(s: Subject, lines: Lines, y: Sequence[Sum], variance: np.ndarray) -> str:
    """The C text of y' S^-1 y"""
    weights, parts = inverse(variance), []
    for i in range(s.of.m):
        weighed = Sum()
        for j in range(s.of.m):
            weighed = weighed + y[j] * weights[i, j]
        parts.append((i, s.words.weighed(lines, f"n_{s.measurements[i]}", weighed, i), y[i]))
    return s.words.nis(lines, parts)
