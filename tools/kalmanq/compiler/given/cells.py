"""Numbers of the library's tables as C writes them."""

from __future__ import annotations

from typing import Any, Sequence

WIDEST = 100  # letters of a table in one line


def array(kind: str, name: str, cells: Sequence[str], columns: int = 6) -> list[str]:
    """Lines of a constant.  columns: of a matrix, a row of it a line; otherwise as many as fit"""
    flat = f"static const {kind} {name}[{len(cells)}] = {{{', '.join(cells)}}};"
    if len(flat) <= WIDEST:
        return [flat]
    rows = [", ".join(cells[k : k + columns]) for k in range(0, len(cells), columns)]
    return [f"static const {kind} {name}[{len(cells)}] = {{", *(f"    {row}," for row in rows), "};"]


def scaled(numbers: Any, count: int) -> list[str]:
    """Mantissas and exponents"""
    return [f"{{{numbers[k].mantissa}, {numbers[k].exponent}}}" for k in range(count)]


def words(numbers: Any, count: int) -> list[str]:
    return [str(numbers[k]) for k in range(count)]


def formats(of: Any, count: int) -> list[str]:
    """Ranges in words, and fractions"""
    return [f"{{{of[k].range}, {of[k].fraction}}}" for k in range(count)]
