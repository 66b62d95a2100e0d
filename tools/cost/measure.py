"""Builds programs, runs them in their emulators, two at a time, and makes the table's rows."""

from __future__ import annotations

import tempfile
from collections import Counter
from dataclasses import dataclass
from functools import partial
from multiprocessing import get_context
from multiprocessing.pool import Pool
from pathlib import Path
from typing import Callable, Sequence, TypeVar

from rich.console import Console
from rich.progress import track

import build
import emulators
from build import Place
from cases import CALLS, HARD, LEAN, ROOTS, Program
from cores import BY_NAME
from emulators import Call
from errors import UserError
from kalmanq.firmware.elf import Elf, flash_and_ram
from table import Row

WORKERS = 2
Item = TypeVar("Item")
Result = TypeVar("Result")


@dataclass(frozen=True)
class Measured:
    """What one program gave."""

    rows: list[Row]
    self_instructions: list[Counter[str]]  # of each row, by function


# ---- all of them -----------------------------------------------------------------------------


def measure_all(source: Path, wanted: list[Program]) -> list[Measured]:
    with tempfile.TemporaryDirectory(prefix="kalmanq-cost-") as folder:
        place = Place(source, Path(folder))
        make_tools(place, wanted)
        keys = sorted({build.library_key(program) for program in wanted})
        with get_context("fork").Pool(WORKERS) as pool:  # an error ends both
            finish(pool, partial(build.library, place), keys, "compiling")
            return finish(pool, partial(measure, place), wanted, "measuring")


def make_tools(place: Place, wanted: list[Program]) -> None:
    build.model_printer(place)
    if any(BY_NAME[program.core].family == "avr" for program in wanted):
        build.avr_counter(place)


def finish(pool: Pool, task: Callable[[Item], Result], items: Sequence[Item], doing: str) -> list[Result]:
    screen = Console(stderr=True)
    results = pool.imap(task, items)
    return list(track(results, doing, len(items), console=screen, transient=True, disable=not screen.is_terminal))


# ---- one of them -----------------------------------------------------------------------------


def measure(place: Place, wanted: Program) -> Measured:
    program = build.program(place, wanted)
    counted = emulators.count_program(BY_NAME[wanted.core], program, build.regions(wanted), place.avr_counter)
    elf = Elf(program)
    rows, hot = [], []
    for index, (n, m) in enumerate(wanted.dimensions):
        calls = calls_of(wanted, counted, index, n)
        for what in wanted.what(n):
            if what == "smooth" and not wanted.smooths(n):
                continue
            size = size_of(place, wanted, what, n, m)
            rows.append(row(wanted, what, (n, m), calls, size))
            hot.append(by_function(elf, calls[counted_as(what)]))
    return Measured(rows, hot)


def row(wanted: Program, what: str, size: tuple[int, int], calls: dict[str, Call],
        ram_and_flash: tuple[int | None, int | None]) -> Row:
    call, hard = calls[counted_as(what)], calls.get(HARD.get(what, ""))
    return Row(
        wanted.core, wanted.arithmetic, *size, wanted.sizes, wanted.profile, what, call.instructions, call.cycles,
        call.stack, hard.instructions if hard else None, stack_worst(calls, what), *ram_and_flash)


def counted_as(what: str) -> str:
    return "step" if what == ROOTS else what


def stack_worst(calls: dict[str, Call], what: str) -> int | None:
    """Of all that a program calls which does `what`."""
    if CALLS.get(what) not in calls:
        return None
    if what == LEAN:  # whatever has another sensor is not of it
        return max(calls[name].stack for name in (LEAN, CALLS[LEAN], HARD[LEAN]))
    without = {LEAN, HARD[LEAN], *CALLS.values()} - {CALLS[what]}
    if what == "smooth":
        without.remove(CALLS["step"])  # and so does this one
    else:
        without |= {"smooth", HARD["smooth"]}
    return max(call.stack for name, call in calls.items() if name not in without)


def calls_of(wanted: Program, counted: dict[int, Call], index: int, n: int) -> dict[str, Call]:
    calls = {}
    for what in wanted.regions(n):
        if build.region(what, index) not in counted:
            raise UserError(f"{wanted.name}: {what} was never called")
        calls[what] = counted[build.region(what, index)]
    return calls


def size_of(place: Place, wanted: Program, what: str, n: int, m: int) -> tuple[int | None, int | None]:
    """RAM and flash of a program that does `what`, less those of one that does nothing."""
    if what.endswith(("predict", "update", "dearest")):  # a program has both: step
        return None, None
    with_it, without = (flash_and_ram(build.program_of(place, wanted, each, n, m)) for each in (what, "nothing"))
    return with_it[1] - without[1], with_it[0] - without[0]


def by_function(elf: Elf, call: Call) -> Counter[str]:
    found: Counter[str] = Counter()
    for address, times in call.by_address.items():
        found[elf.function_at(address)] += times
    return found
