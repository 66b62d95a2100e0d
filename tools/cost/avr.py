"""Counts what an AVR executes within a call, with simavr (target/avr_count.c)."""

from __future__ import annotations

from pathlib import Path

from cases import CALLS
from commands import run
from counted import Counted, most
from elf import Elf
from errors import CostError

PLACES = ("_end", "cost_region", "cost_failed", "cost_end")


def build(source: Path, program: Path) -> None:
    """The host's program that runs the emulator."""
    run(["cc", "-std=gnu11", "-O2", str(source), "-lsimavr", "-o", str(program)])


def count(counter: Path, program: Path, functions: dict[int, str]) -> dict[int, Counted]:
    """A call of the function of each region, of several the most; all of a region without one."""
    elf = Elf(program)
    entries = [functions.get(region) for region in range(max(functions) + len(CALLS) + 1)]
    places = [elf.address(name) if name else 0 for name in (*PLACES, *entries)]
    lines = run([str(counter), str(program), *map(str, places)]).splitlines()
    if not lines or lines[-1] != "end":
        raise CostError(f"{program.name}: the emulator ended early")
    return parsed(lines[:-1])


def parsed(lines: list[str]) -> dict[int, Counted]:
    found: dict[int, list[Counted]] = {}
    call = Counted()
    for line in lines:
        word, *numbers = line.split()
        if word == "region":
            region, instructions, cycles, stack = map(int, numbers)
            call = Counted(instructions, cycles, stack)
            found.setdefault(region, []).append(call)
        elif word == "at":
            call.by_address[int(numbers[0])] = int(numbers[1])
    return {region: most(calls) for region, calls in found.items()}
