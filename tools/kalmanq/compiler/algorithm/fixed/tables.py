"""Numbers of the library's q31 that a device begins with."""

from __future__ import annotations

import math
from typing import Iterable, Sequence

from kalmanq.core import ffi
from kalmanq.formulas.graph import Node
from kalmanq.model import Quantity
from kalmanq.run.parts import prepare_format


def constants(entries: Sequence[Node], exponents: Iterable[int]) -> list[str]:
    """Those of A that are constant"""
    return [f"{{{a}, {b}}}" for a, b in (constant_entry(*one) for one in zip(entries, exponents))]


def constant_entry(one: Node, exponent: int) -> tuple[int, int]:
    """Mantissa and exponent; what is no constant is 0"""
    if not one.is_constant or not one.value:
        return 0, 0
    part, k = math.frexp(one.value)
    mantissa = round(math.ldexp(part, 31))
    by = int(abs(mantissa) >> 31)
    return mantissa >> by, k - 31 + by + int(exponent)


def fraction_of(one: Quantity) -> int:
    """As the library's tables have it"""
    return prepare_format("ranges", one, ffi.new("kq_format_q31 *")) if one.fraction is None else one.fraction
