"""Tables of the library's q31 in the C of a device."""

from __future__ import annotations

import math
from typing import Any, Iterable, Sequence

from kalmanq.core import ffi, lib
from kalmanq.formulas.graph import Node
from kalmanq.model import Quantity
from kalmanq.run.parts import Parts, prepare_format


def tables_of_process(n: int, l: int, parts: Parts) -> list[str]:
    """Its own, and those of the prior"""
    root, table = int(lib.kq_length_q31(lib.KQ_OBJECT_ROOT, n, 0, 0, 0)), parts.process_table
    lines = [_formats("state_format", parts.formats["states"], n), _scaled("transition", table.transition, n * n)]
    lines += [_formats("control_format", parts.formats["controls"], l), _scaled("control", table.control, n * l)] if l else []
    lines += [words("noise_root", table.noise_root, root), words("first_mean", parts.prior.mean, n),
              words("first_root", parts.prior.root, root)]
    formats, control = ("control_format", "control") if l else ("NULL", "NULL")
    cells = f"{n}, {l}, state_format, {formats}, transition, {control}, noise_root"
    return [*lines, f"static const kq_process_table_q31 process_table = {{{cells}}};",
            f"static const kq_prior_table_q31 prior = {{{n}, state_format, first_mean, first_root}};"]


def tables_of_sensor(n: int, m: int, suffix: str, is_diagonal: bool, parts: Parts) -> list[str]:
    table = parts.sensor_table
    return [_formats(f"format{suffix}", parts.formats["measurements"], m), _scaled(f"H{suffix}", table.measurement, m * n),
            _scaled(f"R{suffix}", table.noise, m if is_diagonal else m * (m + 1) // 2),
            f"static const kq_sensor_table_q31 table{suffix} = {{{n}, {m}, {int(not is_diagonal)}, state_format, format{suffix}, "
            f"H{suffix}, R{suffix}}};"]


def constants(name: str, entries: Sequence[Node], exponents: Iterable[int]) -> str:
    """Those of A that are constant"""
    return _array("kq_scaled_q31", name, [f"{{{a}, {b}}}" for a, b in (constant_entry(*one) for one in zip(entries, exponents))])


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


def _array(kind: str, name: str, cells: Iterable[str]) -> str:
    return f"static const {kind} {name}[] = {{{', '.join(cells)}}};"


def words(name: str, words: Any, count: int) -> str:
    return _array("int32_t", name, (str(words[k]) for k in range(count)))


def _scaled(name: str, numbers: Any, count: int) -> str:
    return _array("kq_scaled_q31", name, (f"{{{numbers[k].mantissa}, {numbers[k].exponent}}}" for k in range(count)))


def _formats(name: str, formats: Any, count: int) -> str:
    return _array("kq_format_q31", name, (f"{{{formats[k].range}, {formats[k].fraction}}}" for k in range(count)))
