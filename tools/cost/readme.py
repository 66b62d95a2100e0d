"""The pages' sections of costs, made from the table and never typed.  tools/cost/README.md has all: the
cards of the cores, which say what a real program takes without a smoother and with one, and
instructions; README.md a few lines of them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Callable, Iterable, Iterator, Mapping, Sequence

from cases import CLANG, FIXED, GCC, LEAN, ROOTS, RUNTIME, SIZES, SMALL
from cores import BY_NAME, CORES
from errors import FileError
from table import Row

BEGIN, END = "<!-- costs: written by tools/cost.py --readme -->", "<!-- end of costs -->"


def section(rows: tuple[Row, ...]) -> str:
    by_key = {row.key: row for row in rows}
    instructions = (STEPS_TITLE, step_table(by_key), MODULES_TITLE, module_table(by_key))
    nonlinear = (NONLINEAR_TITLE, nonlinear_table(by_key))
    return "\n\n".join((card_table(rows), *instructions, *nonlinear))


Where = tuple[str, str]  # core, arithmetic
Part = Callable[[tuple[Row, ...]], str]


def rewritten(path: Path, rows: tuple[Row, ...], part: Part = section) -> str:
    text = path.read_text(encoding="utf-8")
    if text.count(BEGIN) != 1 or text.count(END) != 1 or text.index(BEGIN) > text.index(END):
        raise FileError(path, f"needs the lines '{BEGIN}' and '{END}', once each")
    before, rest = text.split(BEGIN)
    return f"{before}{BEGIN}\n{part(rows)}\n{END}{rest.split(END)[1]}"


def markdown(titles: Sequence[str], lines: Iterable[Sequence[object]], text: int) -> str:
    """A table whose first columns, so many, are text; what is None is an empty cell"""
    made = [titles, *(["" if cell is None else str(cell) for cell in line] for line in lines)]
    made = ["| " + " | ".join(cells) + " |" for cells in made]
    return "\n".join([made[0], "|" + "---|" * text + "---:|" * (len(titles) - text), *made[1:]])


def matches(path: Path, rows: tuple[Row, ...], part: Part = section) -> bool:
    return rewritten(path, rows, part) == path.read_text(encoding="utf-8")


# ---- cards -----------------------------------------------------------------------------------

CARD_SIZES = ((1, 1), (2, 1), (4, 2), (9, 3))
CARD_ARITHMETICS = ("f32", "q31")
PARTS = (16, 32, 64)  # kB of flash
MEMORIES = (1, 2, 4, 8, 16, 32, 64)  # kB of RAM
START_UP = 1024  # bytes of flash: vectors and what a C library does before main

TITLES = (
    "core", "", "n, m", "flash", "from roots", "lean", "with smoother", "RAM", "lean", "with tape",
    "worst stack", "lean", "with smoother", "step", "lean", "worst update", "part", "lean", "with smoother",
)

EXPLAINED = f"""\
A real program: init of a process, a sensor and a filter from A, Q, H, R, x0 and P0 (q31: from tables),
`kq_step`, `kq_mean`, `kq_sigma`; "smoother": a history of 30 steps, `kq_smooth` and its readings as well.
Bytes. Flash is code, constants and initial values with what libc and libgcc add, less the same program without
a filter: gcc `-O2` (AVR `-Os`), then clang `-Oz`; all other columns are gcc's. From roots: where Q and P0 are given by
their roots (`kq_process_init_root`, `kq_filter_init_root`), as in q31's tables always. Lean: process and
sensor are constant tables with the shapes of A and H, as `kalmanq design` writes them, P0 is given by its root, and the
sensor is lean (`KQ_PROCESS_TABLE`, `KQ_SENSOR_LEAN_TABLE_<T>`). Take lean, unless R is 0 or rows of H repeat exactly.
RAM: the objects and the tape, on AVR also the constants.
Worst stack: the deepest of all calls, with init, the first calls and noise-free measurements.
Step: instructions of a settled `kq_step`; worst update: the dearest one of 58 hard inputs (R from 0 to P0, sigmas 14
decades apart, P0 standing for infinity) and of what a search of any input has found: no bound. Part: flash + RAM of the smallest that holds it, with
{START_UP} bytes of flash for the start-up, and objects, tape and worst stack in RAM.

**The linker does not see the stack.** A program that links may run through its stack into the filter at the first
update. Budget: objects + tape + worst stack + the frames of your own functions and interrupts <= RAM.
`tools/cost.py --states 5 --components 2 --controls 1 --core m3 --arithmetic q31` prints the card of your sizes."""


@dataclass(frozen=True)
class Card:
    """The rows that a line is made of, by profile and what; clang's may be missing, and q31's tables are roots."""

    of: Mapping[tuple[str, str], Row]

    @property
    def step(self) -> Row:
        return self.of[GCC, "step"]

    def named(self) -> list[str]:
        return [BY_NAME[self.step.core].description, self.step.arithmetic, f"{self.step.n}, {self.step.m}"]

    def cells(self) -> list[str]:
        step, lean, smooth, roots = self.step, self.of[GCC, LEAN], self.of[GCC, "smooth"], self.of.get((GCC, ROOTS))
        worst = self.of[GCC, "update"].instructions_worst
        return [*self.named(), self.flash("step"), str(roots.flash_program) if roots else "", self.flash(LEAN),
                self.flash("smooth"), *(str(row.ram_program) for row in (step, lean, smooth)),
                *(str(row.stack_worst) for row in (step, lean, smooth)), str(step.instructions), str(lean.instructions),
                str(worst), *map(part, (step, lean, smooth))]

    def short_cells(self) -> list[str]:
        """Of the lean sensor"""
        lean = self.of[GCC, LEAN]
        return [*self.named(), *map(str, (lean.flash_program, lean.ram_program, lean.stack_worst, lean.instructions))]

    def flash(self, what: str) -> str:
        """gcc's, then clang's"""
        rows = [self.of[profile, what] for profile in (GCC, CLANG) if (profile, what) in self.of]
        return ", ".join(str(row.flash_program) for row in rows)


def cards(rows: Iterable[Row]) -> Iterator[Card]:
    """Of all filters that the rows have both of, without a smoother and with one."""
    found: dict[tuple[object, ...], dict[tuple[str, str], Row]] = {}
    for row in rows:
        if row.sizes == RUNTIME and row.arithmetic in CARD_ARITHMETICS:
            found.setdefault(row.key[:4], {})[row.profile, row.what] = row
    needed = {(GCC, what) for what in ("step", LEAN, "smooth", "update")}
    yield from (Card(of) for of in found.values() if needed <= set(of))


def part(row: Row) -> str:
    flash_kb = smallest(PARTS, (row.flash_program or 0) + START_UP)
    ram_kb = smallest(MEMORIES, (row.ram_program or 0) + (row.stack_worst or 0))
    return f"{flash_kb} + {ram_kb} kB"


def smallest(sizes: Sequence[int], needed: int) -> str:
    fitting = [str(size) for size in sizes if needed <= 1024 * size]
    return fitting[0] if fitting else f"> {sizes[-1]}"


def card_table(rows: Iterable[Row]) -> str:
    shown = (card.cells() for card in cards(rows) if (card.step.n, card.step.m) in CARD_SIZES)
    return f"{EXPLAINED}\n\n{markdown(TITLES, shown, 2)}"


# ---- the rows of all this --------------------------------------------------------------------


def kept() -> frozenset[tuple[object, ...]]:
    """The keys of the rows that are committed: of the pages' tables."""
    every = [(core.name, arithmetic) for core in CORES for arithmetic in CARD_ARITHMETICS]
    keys: set[tuple[object, ...]] = set()

    def keep(wheres: Iterable[Where], sizes: Iterable[tuple[int, int]], profile: str, whats: Iterable[str],
             kind: str = RUNTIME) -> None:
        keys.update((*where, *size, kind, profile, what) for where in wheres for size in sizes for what in whats)

    keep(every, CARD_SIZES, GCC, ("step", "smooth", "update", ROOTS, LEAN))
    keep(every, CARD_SIZES, CLANG, ("step", "smooth", LEAN))
    for kind in (RUNTIME, FIXED):
        keep(FITTING, SIZES, GCC, ("step",), kind)
    for what, kind, _ in MODULE_ROWS:
        keep(MODULE_CORES, MODULE_SIZES, GCC, (what,), kind)
    for profile in (GCC, SMALL):
        keep(MODULE_CORES, NONLINEAR_SIZES, profile, NONLINEAR)
    return frozenset(keys)


# ---- a few lines of the cards ----------------------------------------------------------------

SUMMARY_CORES = (("m0", "q31"), ("m4f", "f32"), ("avr", "f32"))
SUMMARY_SIZES = ((4, 2),)
SUMMARY_TITLES = ("core", "arithmetic", "states, measurements", "flash", "RAM without stack", "worst stack", "instructions")


def summary(rows: tuple[Row, ...]) -> str:
    """For README.md: a line for each core and size."""
    found = {card.step.key[:4]: card for card in cards(rows)}
    wanted = [(*where, *size) for where in SUMMARY_CORES for size in SUMMARY_SIZES]
    return markdown(SUMMARY_TITLES, (found[filter_].short_cells() for filter_ in wanted if filter_ in found), 2)


# ---- instructions ----------------------------------------------------------------------------

MODULE_SIZES = ((2, 1), (4, 2), (9, 3))
MODULE_CORES = (("m4f", "f32"), ("m3", "q31"))
# what the page calls them; the filter's step first, to compare with
MODULE_ROWS = (
    ("step", RUNTIME, "`kq_step`"), ("steady", RUNTIME, "`kq_steady_step`"),
    ("steady", FIXED, "`kq_fixed_steady_step`"), ("settling", RUNTIME, "`kq_step`, a settled `kq_freeze` attached"),
    ("update", RUNTIME, "`kq_update`"), ("gated", RUNTIME, "`kq_update_robust`, a gate that accepts"),
    ("huber", RUNTIME, "`kq_update_robust`, Huber"), ("student", RUNTIME, "`kq_update_robust`, Student"),
    ("jump", RUNTIME, "`kq_update_robust`, jump, none"), ("lag", RUNTIME, "a sample with `kq_lagged`, L = 10"),
    ("lag_states", RUNTIME, "a sample with `kq_lagged_states`, L = 10"),
    ("point", RUNTIME, "a sample with `kq_instant_smooth`"),
    ("delayed", RUNTIME, "`kq_update_delayed`, 10 steps late"), ("adapted", RUNTIME, "a sample of `kq_adaptation`"),
    ("continuous", RUNTIME, "`kq_process_init_continuous`, another dt"),
    ("correlated", RUNTIME, "`kq_process_init_correlated`"),
    ("changed", RUNTIME, "`kq_predict` and `kq_update`, another A and another H"),
    ("extended_predict", RUNTIME, "`kq_predict_extended`"),
    ("extended_update", RUNTIME, "`kq_update` by an innovation"),
    ("extended", RUNTIME, "an extended step, f and h in it, another A and another H"),
    ("points", RUNTIME, "`kq_predict_sigma_points` and `kq_update_sigma_points`, 4n + 2 calls in it"))

NONLINEAR = ("changed", "extended", "points")
NONLINEAR_SIZES = ((4, 2), (6, 3), (9, 3))
NONLINEAR_TITLE = """\
A nonlinear model: a linear step with another A and H; an extended one; one by sigma points (cubature). Instructions
with the user's f and h, plain loops over dense rows (`target/nonlinear.inc`); bytes of stack of that call; flash of
the linear program, and what the other two add to it without f and h, at `-O2` and at `-Os`:"""
NONLINEAR_TITLES = (
    "core", "", "n, m", "linear", "extended", "points", "stack", "extended", "points",
    "flash `-O2`", "extended", "points", "flash `-Os`", "extended", "points",
)
STEPS_TITLE = "Instructions of one settled predict and one full update (`kq_step`) at n, m:"
MODULES_TITLE = "Instructions of the other functions at n, m, and of the plain ones beside them:"
Rows = Mapping[tuple[object, ...], Row]
# what one would choose on each core
FITTING = (
    ("m0", "q31"), ("m3", "q31"), ("m4f", "f32"), ("m7", "f32"), ("m7", "f64"), ("m33", "f32"),
    ("rv32", "q31"), ("avr", "f32"), ("avr", "q31"),
)


def module_table(by_key: Rows) -> str:
    titles = ["", *(f"{core.upper()} {arithmetic}: {n}, {m}" for core, arithmetic in MODULE_CORES
                    for n, m in MODULE_SIZES)]
    lines = []
    for what, kind, name in MODULE_ROWS:
        cells = [module_cells(by_key, where, kind, what) for where in MODULE_CORES]
        if any(cells) and None not in cells:
            lines.append([name, *(cell for core in cells for cell in core or [""] * len(MODULE_SIZES))])
    return markdown(titles, lines, 1)


def module_cells(by_key: Rows, where: Where, kind: str, what: str) -> list[str] | None:
    """Of one core, instructions at each size; none where it has no such function, or None where
    some figures are missing."""
    keys = [(*where, *size, kind, GCC, what) for size in MODULE_SIZES]
    found = [str(by_key[key].instructions) for key in keys if key in by_key]
    return found if len(found) in (0, len(keys)) else None


def nonlinear_table(by_key: Rows) -> str:
    """What a nonlinear model takes, a line for each size; what is not there has none."""
    lines = []
    for core, arithmetic in MODULE_CORES:
        for n, m in NONLINEAR_SIZES:
            fast, small = ([by_key.get((core, arithmetic, n, m, RUNTIME, profile, what)) for what in NONLINEAR]
                           for profile in (GCC, SMALL))
            if fast[0] and small[0]:
                lines.append([BY_NAME[core].description, arithmetic, f"{n}, {m}", *nonlinear_cells(fast, small)])
    return markdown(NONLINEAR_TITLES, lines, 3)


def nonlinear_cells(fast: Sequence[Row | None], small: Sequence[Row | None]) -> list[int | None]:
    figures = [row and row.instructions for row in fast] + [row and row.stack_bytes for row in fast]
    for rows in (fast, small):
        flash = [row and row.flash_program for row in rows]
        figures += [flash[0], *(bytes_ and bytes_ - (flash[0] or 0) for bytes_ in flash[1:])]
    return figures


def step_table(by_key: Rows) -> str:
    lines = []
    for core, arithmetic in FITTING:
        for kind in (RUNTIME, FIXED):
            rows = [by_key.get((core, arithmetic, *size, kind, GCC, "step")) for size in SIZES]
            if all(rows):
                lines.append([BY_NAME[core].description, arithmetic, {RUNTIME: "run-time"}.get(kind, kind),
                              *(row.instructions for row in rows if row)])
    return markdown(["core", "", "sizes", *(f"{n}, {m}" for n, m in SIZES)], lines, 3)
