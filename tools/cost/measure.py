"""Builds a program, runs it in its emulator, and makes the table's rows of it."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Iterable

import avr
import build
from build import Place
from cases import WHAT, Program
from cores import BY_NAME
from counted import Counted
from elf import Elf, flash_bytes
from emulator import Emulator
from errors import CostError
from row import Row


@dataclass(frozen=True)
class Measured:
    """What one program gave."""

    rows: list[Row]
    self_instructions: list[Counter[str]]  # of each row, by function


def measure(place: Place, wanted: Program) -> Measured:
    program = build.program(place, wanted)
    regions = build.regions(wanted)
    counted = count(place, wanted, program, regions)
    flash = flash_of(place, wanted, regions.values())
    elf = Elf(program)
    rows, hot = [], []
    for region, name in regions.items():
        index, kind = divmod(region, len(WHAT))
        if WHAT[kind] == "smooth" and not wanted.smooths(wanted.dimensions[index][0]):
            continue
        if region not in counted:
            raise CostError(f"{wanted.name}: {name} was never called")
        rows.append(row(wanted, region, counted[region], flash[name]))
        hot.append(by_function(elf, counted[region]))
    return Measured(rows, hot)


def row(wanted: Program, region: int, call: Counted, flash: int) -> Row:
    index, kind = divmod(region, len(WHAT))
    n, m = wanted.dimensions[index]
    return Row(
        wanted.core,
        wanted.arithmetic,
        n,
        m,
        wanted.sizes,
        wanted.optimisation,
        WHAT[kind],
        call.instructions,
        call.cycles,
        call.stack,
        call.ram,
        flash,
    )


def count(
    place: Place, wanted: Program, program: Path, regions: dict[int, str]
) -> dict[int, Counted]:
    core = BY_NAME[wanted.core]
    if core.family == "avr":
        return avr.count(place.avr_counter, program, regions)
    return Emulator(core, program).count(regions)


def flash_of(place: Place, wanted: Program, names: Iterable[str]) -> dict[str, int]:
    """By function; at run-time sizes one serves all sizes."""
    once = dict.fromkeys(names)
    return {name: flash_bytes(build.flash_program(place, wanted, name)) for name in once}


def by_function(elf: Elf, call: Counted) -> Counter[str]:
    """Instructions of each function itself."""
    found: Counter[str] = Counter()
    for address, times in call.by_address.items():
        found[elf.function_at(address)] += times
    return found
