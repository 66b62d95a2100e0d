"""The card of a core: what a real program takes, without a smoother and with one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Iterable, Iterator, Sequence

from cases import CLANG, GCC, LEAN, ROOTS, RUNTIME
from cores import BY_NAME
from row import Row

SIZES = ((1, 1), (2, 1), (4, 2), (9, 3))  # in the README
ARITHMETICS = ("f32", "q31")
PARTS = (16, 32, 64)  # kB of flash
MEMORIES = (1, 2, 4, 8, 16, 32, 64)  # kB of RAM
START_UP = 1024  # bytes of flash: vectors and what a C library does before main

TITLES = (
    "core", "", "n, m", "flash", "from roots", "lean", "with smoother", "RAM", "lean", "with tape",
    "worst stack", "lean", "with smoother", "step", "worst update", "part", "lean", "with smoother",
)  # fmt: skip

EXPLAINED = f"""\
A real program: init of a process, a sensor and a filter from A, Q, H, R, x0 and P0 (q31: from tables),
`kq_step`, `kq_mean`, `kq_sigma`; "smoother": a history of 30 steps, `kq_smooth` and its readings as well.
Bytes. Flash is code, constants and initial values with what libc and libgcc add, less the same program without
a filter: gcc `-O2` (AVR `-Os`), then clang `-Oz`; all other columns are gcc's. From roots: where Q and P0 are given by
their roots (`kq_process_init_root`, `kq_filter_init_root`), as in q31's tables always. Lean: process and
sensor are constant tables, P0 is given by its root, and the sensor is one that refuses sharp measurements
(`KQ_PROCESS_TABLE`, `KQ_SENSOR_LEAN_TABLE_<T>`). RAM: the objects and the tape, on AVR also the constants.
Worst stack: the deepest of all calls, those of init, the first ones and noise-free measurements included.
Step: instructions of a settled `kq_step`; worst update: the dearest one found over hard inputs (R from 0 to P0,
sigmas 14 decades apart, P0 standing for infinity). Part: flash + RAM of the smallest that holds it, with
{START_UP} bytes of flash for the start-up, and objects, tape and worst stack in RAM.

**The linker does not see the stack.** A program that links may run through its stack into the filter at the first
update. Budget: objects + tape + worst stack + the frames of your own functions and interrupts <= RAM.
`tools/cost.py --states 5 --components 2 --controls 1 --core m3 --arithmetic q31` prints the card of your sizes."""


@dataclass(frozen=True)
class Card:
    """The rows that a line of it is made of; clang's may be missing."""

    step: Row
    smooth: Row
    update: Row
    roots: Row | None  # q31's tables are roots
    lean: Row
    clang_step: Row | None
    clang_lean: Row | None
    clang_smooth: Row | None

    def cells(self) -> list[str]:
        step, lean, smooth = self.step, self.lean, self.smooth
        return [
            BY_NAME[step.core].description,
            step.arithmetic,
            f"{step.n}, {step.m}",
            flash(step, self.clang_step),
            str(self.roots.flash_program) if self.roots else "",
            flash(lean, self.clang_lean),
            flash(smooth, self.clang_smooth),
            str(step.ram_program),
            str(lean.ram_program),
            str(smooth.ram_program),
            str(step.stack_worst),
            str(lean.stack_worst),
            str(smooth.stack_worst),
            str(step.instructions),
            str(self.update.instructions_worst),
            part(step),
            part(lean),
            part(smooth),
        ]


def cards(rows: Iterable[Row]) -> Iterator[Card]:
    """Of all filters that the rows have both of, without a smoother and with one."""
    found: dict[tuple[object, ...], dict[tuple[str, str], Row]] = {}
    for row in rows:
        if row.sizes == RUNTIME and row.arithmetic in ARITHMETICS:
            filter_ = (row.core, row.arithmetic, row.n, row.m)
            found.setdefault(filter_, {})[row.profile, row.what] = row
    for of in found.values():
        if {(GCC, "step"), (GCC, LEAN), (GCC, "smooth"), (GCC, "update")} <= set(of):
            yield Card(
                of[GCC, "step"],
                of[GCC, "smooth"],
                of[GCC, "update"],
                of.get((GCC, ROOTS)),
                of[GCC, LEAN],
                of.get((CLANG, "step")),
                of.get((CLANG, LEAN)),
                of.get((CLANG, "smooth")),
            )


def flash(gcc: Row, clang: Row | None) -> str:
    return f"{gcc.flash_program}, {clang.flash_program}" if clang else str(gcc.flash_program)


def part(row: Row) -> str:
    """The smallest that holds the program."""
    flash_kb = smallest(PARTS, (row.flash_program or 0) + START_UP)
    ram_kb = smallest(MEMORIES, (row.ram_program or 0) + (row.stack_worst or 0))
    return f"{flash_kb} + {ram_kb} kB"


def smallest(sizes: Sequence[int], needed: int) -> str:
    fitting = [str(size) for size in sizes if needed <= 1024 * size]
    return fitting[0] if fitting else f"> {sizes[-1]}"


def markdown(rows: Iterable[Row]) -> str:
    lines = ["| " + " | ".join(TITLES) + " |", "|---|---|" + "---:|" * (len(TITLES) - 2)]
    for card in cards(rows):
        if (card.step.n, card.step.m) in SIZES:
            lines.append("| " + " | ".join(card.cells()) + " |")
    return f"{EXPLAINED}\n\n" + "\n".join(lines)
