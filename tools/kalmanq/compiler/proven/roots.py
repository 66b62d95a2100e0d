"""The form that carries a root: P = S S', S upper triangular.  Dearer than the covariance, and never indefinite."""

from __future__ import annotations

from decimal import Decimal
from typing import Callable

import numpy as np

from kalmanq.compiler.exact import root
from kalmanq.compiler.proven.forms import Entries, Keep, Key, Mean, Subject
from kalmanq.compiler.proven.lines import Lines
from kalmanq.compiler.proven.sums import Sum


class Root:
    """Householder's reflectors with their pivots in the root of Q, Carlson's update (1973), one component after the
    other."""

    name = "square root"
    has_roots = True

    def keys(self, n: int) -> list[Key]:
        return [(i, j) for j in range(n) for i in range(j + 1)]

    def values(self, P: np.ndarray) -> dict[Key, Decimal]:
        S = root(P)
        return {key: S[key] for key in self.keys(len(P))}

    def field(self, s: Subject, key: Key) -> str:
        return s.pair("s", *key)

    def word(self, s: Subject, key: Key) -> None:
        return None

    def covariance(self, n: int, value: Callable[[Key], str]) -> dict[Key, str]:
        return {(i, j): " + ".join(f"{value((i, k))} * {value((j, k))}" for k in range(j, n))
                for i in range(n) for j in range(i, n)}

    def predict(self, s: Subject, lines: Lines, S: Entries) -> Entries:
        """Of each row of A S, from the last: its reflections by those below it, and what is left of it."""
        n, G = s.of.n, root(s.of.Q)
        made: Entries = {}
        below: list[tuple[int, list[Sum], Sum, Sum]] = []
        for l in reversed(range(n)):
            row = self._moved(s, lines, S, l)
            for i, w, scale, weight in below:
                product = Sum(G[l, i] * G[i, i])
                for c in range(n):
                    product = product + s.words.times(lines, row[c], w[c])
                made[l, i] = s.words.name(lines, s.pair("s", l, i), s.words.times(lines, product, scale))
                turn = s.words.times(lines, made[l, i] + G[l, i], weight)
                row = [s.words.name(lines, f"a_{s.states[l]}_{s.states[c]}", row[c] - s.words.times(lines, turn, w[c]))
                       for c in range(n)]
            square = Sum(G[l, l] * G[l, l])
            for c in range(n):
                square = square + s.words.times(lines, row[c], row[c])
            made[l, l] = s.words.root(lines, s.pair("s", l, l), square)
            if l and not made[l, l].is_zero:
                below.append((l, row, s.words.inverse(lines, "p", made[l, l]),
                              s.words.inverse(lines, "q", made[l, l] + G[l, l])))
            elif l:
                below.append((l, [Sum()] * n, Sum(), Sum()))
        return made

    def _moved(self, s: Subject, lines: Lines, S: Entries, l: int) -> list[Sum]:
        """Row l of A S"""
        made = []
        for c in range(s.of.n):
            value = Sum()
            for k in range(c + 1):
                value = value + S[k, c] * s.of.A[l][k]
            made.append(s.words.name(lines, f"a_{s.states[l]}_{s.states[c]}", value))
        return made

    def update(self, s: Subject, lines: Lines, x: Mean, S: Entries, j: int, z: Sum, keep: Keep) -> tuple[Mean, Entries]:
        n, h, words = s.of.n, s.of.H[j], s.words
        variance, inverse = Sum(s.of.R[j]), Sum(1 / s.of.R[j])
        row, made = [Sum()] * n, dict(S)
        y = s.mean.innovation(lines, x, j, z, f"y_{s.measurements[j]}", "innovation")
        for c in range(n):
            f = Sum()
            for i in range(c + 1):
                f = f + S[i, c] * h[i]
            f = words.name(lines, f"f_{s.states[c]}", f)
            if f.is_zero:
                continue
            wider = words.name(lines, f"v_{s.measurements[j]}", variance + words.times(lines, f, f))
            narrower = words.inverse(lines, "w", wider)
            cosine = words.root(lines, "c", words.times(lines, variance, narrower))
            g = words.times(lines, words.times(lines, cosine, f), inverse)
            for i in range(c + 1):
                made[i, c] = words.name(lines, s.pair("s", i, c), words.times(lines, cosine, S[i, c])
                                        - (words.times(lines, g, row[i]) if i < c else Sum()))
            row = [words.name(lines, f"b_{s.states[i]}", row[i] + words.times(lines, f, S[i, c]))
                   for i in range(c + 1)] + row[c + 1:]
            variance, inverse = wider, narrower
        scaled = words.times(lines, inverse, y)
        keep(j, y, inverse, variance)
        return [s.mean.correct(lines, i, x[i], words.times(lines, row[i], scaled)) for i in range(n)], made
