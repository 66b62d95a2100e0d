"""Builds a program, runs it in its emulator, and makes the table's rows of it."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import avr
import build
from build import Place
from cases import RUNTIME, Program
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
    missing = [name for region, name in regions.items() if region not in counted]
    if missing:
        raise CostError(f"{wanted.name}: {missing[0]} was never called")
    flash = flash_of(place, wanted)
    calls = [(n, m, what) for n, m in wanted.dimensions for what in wanted.what]
    rows = [
        Row(wanted.core, wanted.arithmetic, n, m, wanted.sizes, wanted.optimisation, what,
            call.instructions, call.cycles, call.stack, call.ram, flash[n, m, what])
        for (n, m, what), call in zip(calls, counted.values())
    ]
    elf = Elf(program)
    return Measured(rows, [by_function(elf, call) for call in counted.values()])


def count(
    place: Place, wanted: Program, program: Path, regions: dict[int, str]
) -> dict[int, Counted]:
    core = BY_NAME[wanted.core]
    if core.family == "avr":
        return avr.count(place.avr_counter, program, regions)
    return Emulator(core, program).count(regions)


def flash_of(place: Place, wanted: Program) -> dict[tuple[int, int, str], int]:
    """By size and function; at run-time sizes the code is the same for all sizes."""
    found = {}
    for n, m in wanted.dimensions:
        for what in wanted.what:
            same = (*wanted.dimensions[0], what) if wanted.sizes == RUNTIME else None
            found[n, m, what] = (
                found[same]
                if same in found
                else flash_bytes(build.flash_program(place, wanted, n, m, what))
            )
    return found


def by_function(elf: Elf, call: Counted) -> Counter[str]:
    """Instructions of each function itself."""
    found: Counter[str] = Counter()
    for address, times in call.by_address.items():
        found[elf.function_at(address)] += times
    return found
