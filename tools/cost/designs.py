#!/usr/bin/env python3
"""Measures filters that kalmanq design has written on the emulated cores.

    designs.py FOLDER [--core CORE]... [--csv OUT.csv]

FOLDER has a folder for each design (design_models.py): NAME.h, NAME.c, design.h with rows of data and the words
that come of them, design.json with what it is.  A design that warns, does not run, or comes to other words is an
error.  Printed, or written to OUT.csv: what a settled step, flash, RAM and stack are.  Where design.json has
promises, what is measured has to be within a fifth of them.
"""

from __future__ import annotations

import json
import tempfile
from functools import lru_cache, partial
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import typer

import build
import table
from build import Place, compiled, linked
from cases import MOST, SIZES
from cores import BY_NAME, ROOT, Core
from emulators import count_program
from errors import UserError, told_in_one_line
from kalmanq.firmware.elf import flash_and_ram
from measure import WORKERS, finish
from outputs import csv_text, end_of, write

COUNTED = 8  # settled steps
USED = ("filter", "steady")  # of the library's files, by what design writes
SHARE = 0.2  # of what is promised
CALLS = COUNTED  # the region of all that is called at first
SAME_BITS = ("-ffp-contract=off",)  # as CMake builds by default
STRICT = ("-Wpedantic", "-Wconversion", "-Wdouble-promotion", "-Wshadow", "-Werror")
COLUMNS = ("core", "arithmetic", "way", "n", "m", "l", "upper", "transition", "mixing", "pairs", "triples",
           "correlated",
           "unknown", "instructions", "flash", "ram", "stack")


# Where one would compile for sizes: float where there is an FPU for it, q31 where there is flash
SIZES_ON = {"f32": ("m4f", "m7", "m33"), "q31": ("m3", "m4f", "m7", "m33", "rv32")}


def library(place: Place, key: tuple[str, str]) -> None:
    core, arithmetic = key
    folder = place.work / f"{core}-{arithmetic}"
    folder.mkdir()
    for source in build.library_sources(place, arithmetic, USED):
        compiled(place, BY_NAME[core], build.GCC, source, folder / f"{source.stem}.o", SAME_BITS)


def measure(place: Place, task: tuple[str, Path]) -> dict[str, Any]:
    try:
        return measured(place, BY_NAME[task[0]], task[1])
    except UserError as problem:
        raise UserError(f"{task[1].name} on {task[0]}: {problem}") from None


def measured(place: Place, core: Core, folder: Path) -> dict[str, Any]:
    what = json.loads((folder / "design.json").read_text(encoding="utf-8"))
    work = place.work / f"{core.name}-{folder.name}"
    work.mkdir()
    include = (*SAME_BITS, f"-I{folder}", f"-I{place.source / 'src' / 'fixed_size'}")
    written = work / "written.o"
    compiled(place, core, build.GCC, folder / f"{what['name']}.c", written, (*include, *STRICT),
             is_user=what["way"] == "sizes")
    main, marks = work / "main.o", work / "marks.o"
    compiled(place, core, build.GCC, build.TARGET / "design.c", main, include)
    compiled(place, core, build.GCC, build.MARKS, marks)
    parts = [main, written, marks, *sorted((place.work / f"{core.name}-{what['arithmetic']}").glob("*.o"))]
    step = f"{what['name']}_step"
    functions = {region: step for region in range(COUNTED)}
    program = linked(core, parts, work / "program.elf")
    counted = count_program(core, program, functions, place.avr_counter)
    with_it, without = (flash_and_ram(linked(core, parts, work / f"{entry}.elf", entry=entry))
                        for entry in ("use_design", "use_nothing"))
    made = {"core": core.name, **what,
            "instructions": sum(counted[region].instructions for region in range(COUNTED)) // COUNTED,
            "flash": with_it[0] - without[0], "ram": with_it[1] - without[1],
            "stack": max(counted[region].stack for region in range(COUNTED + 1))}
    return {**made, "stack": deepest(made)}


def deepest(made: dict[str, Any]) -> int:
    """Of the stack: a design is given ordinary measurements here; what takes hard ones is in the table of the
    library (tools/cost.csv), for the next size that it has."""
    what = "lean" if made["way"] == "lean" else "step"
    worst = [row.stack_worst for row in library_rows()
             if (row.core, row.arithmetic, row.sizes, row.profile, row.what) ==
             (made["core"], made["arithmetic"], build.RUNTIME, build.GCC, what) and row.n <= next_size(made["n"])]
    return max(made["stack"], *(depth for depth in worst if depth is not None))


@lru_cache(maxsize=None)
def library_rows() -> tuple[table.Row, ...]:
    return table.read(ROOT / "tools" / "cost.csv").rows


def next_size(n: int) -> int:
    return min((size for size, _ in SIZES if size >= n), default=MOST)


def broken_promises(made: dict[str, Any]) -> list[str]:
    promised = made.get("promises", {}).get(made["core"], {})
    return [f"{made['name']} on {made['core']}: {measure} {made[measure]}, promised {value}"
            for measure, value in promised.items() if abs(made[measure] - value) > SHARE * value]


def main(folder: Path = typer.Argument(...), core: list[str] = typer.Option(list(BY_NAME), "--core"),
         out: Path = typer.Option(None, "--csv")) -> None:
    designs = sorted(path.parent for path in folder.glob("*/design.json"))
    if not designs:
        raise UserError(f"{folder}: no designs there")
    with tempfile.TemporaryDirectory(prefix="kalmanq-designs-") as work:
        place = Place(ROOT, Path(work))
        if "avr" in core:
            build.avr_counter(place)
        whats = {one: json.loads((one / "design.json").read_text(encoding="utf-8")) for one in designs}
        arithmetics = sorted({what["arithmetic"] for what in whats.values()})
        tasks = [(name, one) for one, what in whats.items() for name in core
                 if name in what.get("cores", core) and (what["way"] != "sizes" or
                                                         name in SIZES_ON[what["arithmetic"]])]
        with get_context("fork").Pool(WORKERS) as pool:
            finish(pool, partial(library, place), [(c, a) for c in core for a in arithmetics], "compiling")
            made = finish(pool, partial(measure, place), tasks, "measuring")
    if out:
        write(out, "# designs on emulated cores, gcc -O2, -ffp-contract=off (tools/cost/designs.py)\n" +
              csv_text([COLUMNS, *([one[column] for column in COLUMNS] for one in made)]))
    for one in made if not out else ():
        print(f"{one['core']:5} {one['name']:32} {one['instructions']:8} instructions {one['flash']:6} flash "
              f"{one['ram']:5} RAM {one['stack']:5} stack")
    broken = [line for one in made for line in broken_promises(one)]
    end_of("designs", len(made), broken)


if __name__ == "__main__":
    with told_in_one_line("designs"):
        typer.run(main)
