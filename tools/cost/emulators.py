"""Counts what a core executes within a call: Arm and RISC-V as the package does, AVR with simavr."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from cases import CALLS
from cores import Core, run
from errors import UserError
from kalmanq.firmware.elf import Elf
from kalmanq.firmware.emulated import Counted, Emulator, most
from timing import cycles

MARKS = ("_end", "cost_region", "cost_failed", "cost_end")


@dataclass
class Call(Counted):
    cycles: int = 0


def count_program(core: Core, program: Path, functions: dict[int, str], avr_counter: Path) -> dict[int, Call]:
    """A call of the function of each region, of several the most; all of a region without one."""
    if core.family == "avr":
        return count_avr(avr_counter, program, functions)
    emulator = Emulator(core, program)
    found = emulator.count_regions(functions)
    return {region: Call(**vars(one), cycles=cycles(core.name, emulator.code, one)) for region, one in found.items()}


def count_avr(counter: Path, program: Path, functions: dict[int, str]) -> dict[int, Call]:
    elf = Elf(program)
    entries = [functions.get(region) for region in range(max(functions) + len(CALLS) + 1)]
    places = [elf.address(name) if name else 0 for name in (*MARKS, *entries)]
    lines = run([str(counter), str(program), *map(str, places)]).splitlines()
    if not lines or lines[-1] != "end":
        raise UserError(f"{program.name}: the emulator ended early")
    return parsed(lines[:-1])


def parsed(lines: list[str]) -> dict[int, Call]:
    found: dict[int, list[Call]] = {}
    call = Call()
    for line in lines:
        word, *numbers = line.split()
        if word == "region":
            region, instructions, simulated, stack = map(int, numbers)
            call = Call(instructions, stack, cycles=simulated)
            found.setdefault(region, []).append(call)
        elif word == "at":
            call.by_address[int(numbers[0])] = int(numbers[1])
    return {region: most(calls) for region, calls in found.items()}
