"""Expressions that fold while an ordinary algorithm runs over them: 0, 1 and equal terms vanish by arithmetic."""

from __future__ import annotations

from decimal import Decimal
from typing import Mapping, Union

Names = tuple[str, ...]
Number = Union[int, Decimal]


class Sum:
    """constant + the sum of coefficient * product of names; names of a product are sorted."""

    __slots__ = ("constant", "terms")

    def __init__(self, constant: Number = 0, terms: Mapping[Names, Decimal] = {}):
        self.constant = Decimal(constant)
        self.terms = {names: coefficient for names, coefficient in terms.items() if coefficient}

    @staticmethod
    def of(value: Union[Sum, Number]) -> Sum:
        return value if isinstance(value, Sum) else Sum(value)

    @staticmethod
    def named(name: str) -> Sum:
        return Sum(0, {(name,): Decimal(1)})

    @property
    def is_constant(self) -> bool:
        return not self.terms

    @property
    def is_zero(self) -> bool:
        return not self.terms and not self.constant

    @property
    def parts(self) -> int:
        return len(self.terms) + bool(self.constant)

    @property
    def name(self) -> str:
        """The name that it is, or an empty text."""
        if self.constant or len(self.terms) != 1:
            return ""
        (names, coefficient), = self.terms.items()
        return names[0] if len(names) == 1 and coefficient == 1 else ""

    def key(self) -> tuple:
        """The same for sums that are the same."""
        return self.constant, tuple(sorted(self.terms.items()))

    def __add__(self, other: Union[Sum, Number]) -> Sum:
        other = Sum.of(other)
        terms = dict(self.terms)
        for names, coefficient in other.terms.items():
            terms[names] = terms.get(names, Decimal(0)) + coefficient
        return Sum(self.constant + other.constant, terms)

    def __neg__(self) -> Sum:
        return Sum(-self.constant, {names: -coefficient for names, coefficient in self.terms.items()})

    def __sub__(self, other: Union[Sum, Number]) -> Sum:
        return self + -Sum.of(other)

    def __mul__(self, other: Union[Sum, Number]) -> Sum:
        other = Sum.of(other)
        if other.is_constant:
            c = other.constant
            return Sum(self.constant * c, {names: coefficient * c for names, coefficient in self.terms.items()})
        if self.is_constant:
            return other * self
        if self.parts != 1 or other.parts != 1:
            raise ValueError("a sum has a name before it is multiplied")
        (a, p), (b, q) = *self.terms.items(), *other.terms.items()
        return Sum(0, {tuple(sorted(a + b)): p * q})
