"""Expressions of a factor in words: values are constants, names or nothing (0)."""

from __future__ import annotations

from typing import Iterable, Union

from kalmanq.compiler.algorithm.fixed.formats import down
from kalmanq.compiler.algorithm.fixed.lines import Lines

Value = Union[None, int, str]  # 0, a constant word, a name
Pair = tuple[Value, Value]
PRODUCT, ROUNDED, ROOT, INVERSE, LOAD = 1, 2, 48, 16, 1  # instructions, near enough to compare texts
COARSEST = 22  # bits that a small coefficient has at least


class Expressions(Lines):
    """Of the factor"""

    def root(self, square: str) -> str:
        return self.let("r", f"inverse_root({square})", "reciprocal", ROOT)

    def fraction(self, value: Value, root: str) -> str:
        return self.let("c", f"fraction({value}, {root})", cost=PRODUCT + 4)

    def product(self, a: Value, b: Value) -> str:
        self.cost += PRODUCT + 2 * LOAD
        first, second = sorted((a, b), key=lambda one: (isinstance(one, int), str(one)))
        return f"product({first}, {second})"

    def squares(self, values: Iterable[Value], type_: str = "uint64_t") -> str:
        return " + ".join(f"({type_}){self.product(one, one)}" for one in values)

    def products(self, pairs: Iterable[Pair], less: Iterable[Pair] = ()) -> str:
        """Sum of products, less some; "" for 0"""
        text = " + ".join(self.product(*pair) for pair in pairs if _is_there(pair))
        for pair in less:
            if _is_there(pair):
                text += f"{' ' if text else ''}- {self.product(*pair)}"
        return text

    def mixed(self, pairs: Iterable[Pair], less: Iterable[Pair] = (), base: str = "w") -> Value:
        """Of fractions with 30 bits, and words"""
        text = self.products(pairs, less)
        return self.let(base, f"part({text})", cost=ROUNDED) if text else None

    def weighed(self, terms: Iterable[tuple[float, Value]], base: str = "w") -> Value:
        """Sum of constant coefficients times words, rounded once"""
        ones, rest = [], []
        for c, value in terms:
            if not c or value is None:
                continue
            if abs(c - 1) < 1 / 32:
                ones.append(str(value))
                c -= 1
            if c:
                rest.append((c, value))
        if not rest:
            return ones[0] if len(ones) == 1 else self.let(base, " + ".join(ones), cost=len(ones)) if ones else None
        return self.let(base, " + ".join([*ones, self._rounded(rest)]), cost=ROUNDED + len(ones))

    def _rounded(self, terms: list[tuple[float, Value]]) -> str:
        most = max(abs(c) for c, _ in terms)
        by = min(30 - down(most), 32)
        if most * 2.0**32 < 2.0**COARSEST:
            by = min(30 - down(most), 60)
        text = self.products((v, round(c * 2.0**by)) for c, v in terms)
        return f"part({text})" if by == 30 else f"half_part({text})" if by == 31 else \
            f"(int32_t)(({text or 0} + (INT64_C(1) << {by - 1})) >> {by})"


def _is_there(pair: Pair) -> bool:
    return all(one is not None and one != 0 for one in pair)

