"""f32: words of one float, a mean of two.

The mean of a state is the sum of two floats: updates gather in the lower one, a predict moves them over.  So small
corrections of a large state are not lost.
"""

from __future__ import annotations

from decimal import Decimal
from typing import Sequence

import numpy as np

from kalmanq.compiler.exact import Numbers
from kalmanq.compiler.proven.lines import Lines
from kalmanq.compiler.proven.sums import Names, Sum

Mean = list[list[Sum]]


def literal(value: Decimal) -> str:
    """The shortest decimal that reads back as this float."""
    text = str(np.float32(float(value)))
    return f"{text}f" if "." in text or "e" in text else f"{text}.0f"


class Floats:
    """The arithmetic of f32: what forms.py asks of one.  fused: products are added by fmaf, for the search."""

    type = "float"
    is_fixed = False

    def __init__(self, of: Numbers, fused: bool = False):
        self.of = of
        self.fused = fused

    # ---- covariance: a word of any entry is a float

    def covariance(self, i: int, j: int) -> None:
        return None

    cross = row = gain = covariance

    def variance(self, j: int) -> None:
        return None

    def name(self, lines: Lines, base: str, value: Sum, word: object = None, note: str = "") -> Sum:
        if value.is_constant or value.name:
            return value
        return lines.add(base, "float", self.text(value), note)

    def gained(self, lines: Lines, base: str, row: Sum, w: Sum, j: int, i: int) -> Sum:
        return self.name(lines, base, row * w, None, "gain")

    def named_row(self, lines: Lines, base: str, row: Sum, j: int, i: int) -> Sum:
        """P h of a state; an entry of P, or a multiple of one, needs no name"""
        return row if row.parts <= 1 else self.name(lines, base, row, None, "P h")

    def times(self, lines: Lines, a: Sum, b: Sum) -> Sum:
        """A product; factors of several parts get names first"""
        a, b = (one if one.parts <= 1 else self.name(lines, "t", one) for one in (a, b))
        return a * b

    def inverse(self, lines: Lines, base: str, value: Sum) -> Sum:
        value = value if value.is_constant else self.name(lines, "t", value)
        return Sum(1 / value.constant) if value.is_constant else lines.add(base, "float", f"1.0f / {value.name}")

    def root(self, lines: Lines, base: str, value: Sum) -> Sum:
        return Sum(value.constant.sqrt()) if value.is_constant else \
            lines.add(base, "float", f"(float)sqrtf({self.text(value)})")

    def begin(self, lines: Lines) -> None:
        pass

    def reciprocal(self, lines: Lines, base: str, variance: Sum, j: int) -> Sum:
        return self.inverse(lines, base, variance)

    def constant(self, value: Decimal, word: object = None) -> str:
        return literal(value)

    def value(self, text: str, word: object = None) -> str:
        """A word as a double"""
        return f"(double){text}"

    def taken(self, which: str, index: str) -> list[str]:
        return [f"(void){index};", "return (float)value;"]

    def given(self, which: str, index: str) -> list[str]:
        return [f"(void){index};", "return (double)word;"]

    def printed(self, text: str) -> list[str]:
        return [f'printf(" %a", (double){text});']

    def door(self, which: str, j: int, span: float) -> str:
        """The largest word of a measurement (z) or a control (u)"""
        return literal(Decimal(span))

    def end(self, which: str, j: int, span: float) -> float:
        """What the largest word is of"""
        return float(np.float32(span))

    def is_outside(self, value: str, limit: str) -> str:
        return f"!({value} >= -{limit} && {value} <= {limit})"

    def weighed(self, lines: Lines, base: str, value: Sum, j: int) -> Sum:
        """What an innovation is multiplied by for NIS"""
        return self.name(lines, base, value)

    def nis(self, lines: Lines, parts: Sequence[tuple[int, Sum, Sum]]) -> str:
        total = Sum()
        for _, weighed, y in parts:
            total = total + weighed * y
        return self.text(total)

    def store(self, value: Sum, word: object = None) -> str:
        return self.text(value)

    def text(self, value: Sum) -> str:
        """Plain terms first, then products: each product then is one fused multiply and add."""
        plain = [(c < 0, names[0]) for names, c in value.terms.items() if len(names) == 1 and abs(c) == 1]
        products = [(c < 0, self._factors(names, c)) for names, c in value.terms.items()
                    if len(names) > 1 or abs(c) != 1]
        if value.constant:
            plain.append((value.constant < 0, literal(abs(value.constant))))
        plain.sort(key=lambda term: term[0])
        if not plain:
            products.sort(key=lambda term: term[0])
        return self._fused(plain, products) if self.fused else _joined(plain, products)

    @staticmethod
    def _factors(names: Names, coefficient: Decimal) -> list[str]:
        return ([] if abs(coefficient) == 1 else [literal(abs(coefficient))]) + list(names)

    @staticmethod
    def _fused(plain: Sequence[tuple[bool, str]], products: Sequence[tuple[bool, list[str]]]) -> str:
        made = _joined(plain, []) if plain else ""
        for negative, factors in products:
            *head, last = factors
            product = f"{'-' if negative else ''}{' * '.join(head)}"
            made = f"fmaf({product}, {last}, {made})" if made else f"{product} * {last}"
        return made or "0.0f"


def _joined(plain: Sequence[tuple[bool, str]], products: Sequence[tuple[bool, list[str]]]) -> str:
    made = ""
    for negative, text in [*plain, *((negative, " * ".join(factors)) for negative, factors in products)]:
        made += (" - " if negative else " + ") + text if made else ("-" if negative else "") + text
    return made or "0.0f"


class PairMean:
    """mean = x + low.  names: of the states"""

    parts = ("", "_low")
    single = "float"  # a mean in one word

    def __init__(self, words: Floats, names: Sequence[str], controls: Sequence[str]):
        self.words, self.names, self.controls = words, names, controls

    def fields(self, i: int) -> list[tuple[str, str]]:
        return [(f"x_{self.names[i]}{part}", "float") for part in self.parts]

    def start(self, i: int) -> list[str]:
        high = Decimal(float(np.float32(float(self.words.of.x0[i]))))
        return [literal(high), literal(self.words.of.x0[i] - high)]

    def predict(self, lines: Lines, x: Mean, controls: Sequence[Sum]) -> Mean:
        A, B, n, name = self.words.of.A, self.words.of.B, self.words.of.n, self.words.name
        whole = [name(lines, f"v_{self.names[i]}", x[i][0] + x[i][1], None, "the whole mean")
                 if any(A[r][i] != (r == i) for r in range(n)) else Sum() for i in range(n)]
        made = []
        for i in range(n):
            change = x[i][1]
            for k in range(n):
                change = change + whole[k] * (A[i][k] - (i == k))
            for k, u in enumerate(controls):
                change = change + u * B[i][k]
            change = name(lines, f"d_{self.names[i]}", change)
            high = name(lines, f"x_{self.names[i]}", x[i][0] + change)
            left = name(lines, f"e_{self.names[i]}", high - x[i][0])
            made.append([high, name(lines, f"x_{self.names[i]}_low", change - left, None, "what x could not take")])
        return made

    def innovation(self, lines: Lines, x: Mean, j: int, z: Sum, base: str, note: str, settled: bool = False) -> Sum:
        H, name = self.words.of.H, self.words.name
        y = z
        for part in (0, 1):
            for i in range(self.words.of.n):
                y = y - x[i][part] * H[j][i]
            y = name(lines, base, y, None, note if part else "")
        return y

    def correct(self, lines: Lines, i: int, x: list[Sum], change: Sum) -> list[Sum]:
        return [x[0], self.words.name(lines, f"x_{self.names[i]}_low", x[1] + change)]

    def value(self, i: int) -> tuple[str, str]:
        """Two doubles whose sum is the mean"""
        return f"(double)f->x_{self.names[i]}", f"(double)f->x_{self.names[i]}_low"

    def whole(self, i: int) -> str:
        return f"f->x_{self.names[i]} + f->x_{self.names[i]}_low"

    def corrected(self, i: int, mean: str, change: Sum) -> str:
        return self.words.text(Sum.named(mean) + change)

    def reading(self, i: int) -> tuple[str, str]:
        """Type and text of the mean"""
        return "float", self.whole(i)

    def lagged(self, i: int, mean: str) -> tuple[str, str]:
        return "float", mean
