"""A x + B u and z - H x in two floats, of which the second has what the first was rounded by.

A sum is Knuth's, whose error is a float.  Of a coefficient the first 12 bits are a literal and the rest another one, and a
float is split as Veltkamp (1968) does, with a sum in the place of his product: products of halves are exact, so a compiler that
fuses multiply and add changes nothing that counts.  C adds from the left, so what is in brackets here is subtracted.
"""

from __future__ import annotations

from decimal import Decimal
from math import frexp, ldexp
from typing import Sequence, Union

from kalmanq.compiler.algorithm.ud import carried
from kalmanq.compiler.given.request import Request
from kalmanq.formulas.graph import Node, constant, make, symbol

BITS = 12  # of a half
NONE = 0.0


def moved(given: Request, x: Sequence[tuple[Node, Node]], i: int) -> tuple[Node, Node]:
    """State i of A x + B u.  A low part that stayed would grow where A - I does"""
    made = Sum(x[i][1])
    for k, (high, low) in enumerate(x):
        made.add(given.of.A[i, k] - (i == k), high, low)
    for k, b in enumerate(given.of.B[i]):
        made.add(b, symbol(f"u{k}"))
    made.plus(x[i][0])
    return carried(made.high, made.low)


def innovation(given: Request, x: Sequence[tuple[Node, Node]], j: int) -> Node:
    """Component j of z - H x, whose noise is made independent of that of others here, too"""
    offset, mixed = float(given.offsets[j]), [(k, one) for k, one in enumerate(given.mixing[j, :j]) if one]
    made = Sum(symbol(f"z[{j}]" if mixed or offset else f"z{j}"))
    for k, one in mixed:
        made.add(one, symbol(f"z[{k}]"))
    made.add(-offset, constant(1))
    for h, (high, low) in zip(given.of.H[j], x):
        made.add(-h, high, low)
    return made.high + made.low


class Sum:
    """high + low"""

    def __init__(self, high: Node):
        self.high, self.low = high, constant(NONE)

    def add(self, coefficient: Union[Decimal, float], x: Node, low: Union[Node, float] = NONE) -> None:
        """coefficient * (x + low), the coefficient to 36 bits"""
        share, power = frexp(float(coefficient))
        first = ldexp(round(ldexp(share, BITS)), power - BITS)
        high, left = (x, constant(NONE)) if abs(share) == 0.5 else halves(x)
        self.plus(high * first)
        self.low = self.low + left * first + x * float(coefficient - type(coefficient)(first)) + float(coefficient) * low

    def plus(self, x: Node) -> None:
        self.high, over = two_sum(self.high, x)
        self.low = self.low - over


def two_sum(a: Node, b: Node) -> tuple[Node, Node]:
    """a + b, and what that is too much"""
    if a.equals(0) or b.equals(0):
        return (b, a) if a.equals(0) else (a, b)
    total = make("add", a, b)
    part = make("sub", total, a)
    return total, make("sub", make("sub", make("sub", total, part), a), make("sub", b, part))


def halves(x: Node) -> tuple[Node, Node]:
    """12 bits and 11; a power of two times x is exact"""
    far = make("add", make("mul", constant(2.0**BITS), x), x)
    high = make("sub", far, make("sub", far, x))
    return high, make("sub", x, high)
