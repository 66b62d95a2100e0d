#!/usr/bin/env python3
"""Measures filters that kalmanq compile has written on the emulated cores.

    compiled.py FOLDER... --core CORE [--level O2] [--csv OUT.csv]

FOLDER has NAME.c, NAME.h and NAME.json (`kalmanq compile --json`).  Printed, or written to OUT.csv: instructions of a
row in two calls before and after the covariance has settled, of one step before and after, bytes of the whole file,
of the filter, and of stack.  Of a nonlinear model, whose NAME.json has `sensors`: instructions of a predict and of an
update of each sensor, the most of the rows that NAME_test.c has.  Where NAME.json has promises (`must`), what is measured has to be within them, and as near
to its estimate as that says.
"""

from __future__ import annotations

import json
import re
import tempfile
from pathlib import Path
from typing import Any

import typer

import build
from build import TARGET, Place, compiled, linked
from cores import BY_NAME, ROOT, Core, run, toolchain
from elf import flash_and_ram
from emulators import count_program
from errors import UserError, told_in_one_line
from outputs import csv_text, end_of, write

STRICT = ("-std=c11", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wdouble-promotion", "-Wshadow", "-Werror")
REGIONS = ("predict", "update", "predict", "update", "step", "step")
WITH_FMA = ("m4f", "m7", "m33")
COLUMNS = ("core", "name", "arithmetic", "level", "n", "m", "two_calls", "two_calls_settled", "step", "step_settled",
           "flash", "ram", "stack")


def flags_of(core: Core, level: str) -> tuple[str, ...]:
    return (*STRICT, f"-{level}", "-ffunction-sections", f"-ffp-contract={'fast' if core.name in WITH_FMA else 'off'}")


def measured(place: Place, core: Core, folder: Path, level: str) -> dict[str, Any]:
    what = told(folder)
    name, work = what["name"], place.work / f"{core.name}-{folder.name}-{level}"
    work.mkdir()
    is_nonlinear = "sensors" in what
    (work / "compiled.h").write_text(naming_calls(what, folder) if is_nonlinear else naming(what), encoding="utf-8")
    written, main, marks = work / "written.o", work / "main.o", work / "marks.o"
    run([*toolchain(core, "gcc").compiler, *flags_of(core, level), "-c", str(folder / f"{name}.c"), "-o", str(written)])
    compiled(place, core, build.GCC, TARGET / ("equations.c" if is_nonlinear else "compiled.c"), main, (f"-I{folder}", f"-I{work}"))
    compiled(place, core, build.GCC, TARGET / "marks.c", marks)
    program = linked(core, [main, written, marks], work / "program.elf")
    calls = ["predict", *map(updating, what["sensors"])] if is_nonlinear else REGIONS
    functions = {region: f"{name}_{call}" for region, call in enumerate(calls)}
    counted = count_program(core, program, functions, place.avr_counter)
    count = {region: counted[region].instructions for region in functions}
    if is_nonlinear:
        return {"core": core.name, "name": name, "arithmetic": what["arithmetic"], "level": level, "n": what["n"], "m": what["m"],
                **{call: count[region] for region, call in enumerate(calls)}, "flash": flash(written), "program": flash(program),
                "ram": what["ram"], "stack": max(counted[region].stack for region in functions)}
    return {"core": core.name, "name": name, "arithmetic": what["arithmetic"], "level": level, "n": what["n"],
            "m": what["m"], "two_calls": count[0] + count[1], "two_calls_settled": count[2] + count[3],
            "step": count[5], "step_settled": count[4], "flash": flash(written), "ram": what["ram"],
            "stack": max(counted[region].stack for region in functions)}


def updating(sensor: dict[str, Any]) -> str:
    return f"update_{sensor['name']}" if sensor["name"] else "update"


def naming_calls(what: dict[str, Any], folder: Path) -> str:
    """The rows of NAME_test.c, and the calls of each"""
    name, word, sensors = what["name"], "float" if what["arithmetic"] == "f32" else "double", what["sensors"]
    rows = re.search(r"static const struct \{.*?\n\};\n", (folder / f"{name}_test.c").read_text(encoding="utf-8"), re.S)
    if rows is None:
        raise UserError(f"{folder}: {name}_test.c has no rows")

    def given(arguments: list[str], first: int, u: str) -> str:
        values = {"z": f"rows[k].z + {first}", "u": f"rows[k].{u}", "t": f"({word})k"}
        return "".join(f", {values[one]}" for one in arguments)

    updates, first = [], 0
    for region, sensor in enumerate(sensors, 1):
        call = f"{name}_{updating(sensor)}(&f{given(sensor['arguments'], first, 'now')})"
        whole = f"(rows[k].present >> {first} & {(1 << sensor['m']) - 1}u) == {(1 << sensor['m']) - 1}u"
        updates.append(f"    if ({whole}) {{ cost_region({region}); {call}; }} \\")
        first += sensor["m"]
    return "\n".join([f'#include "{name}.h"', rows[0], f"enum {{ RECORDED = sizeof rows / sizeof rows[0], ROWS = 20, NO_MORE = {len(sensors) + 1} }};",
                      f"#define FILTER {name}_filter", f"#define DO(call) {name}_##call", f"#define FAILED {name.upper()}_NOT_FINITE",
                      f"#define PREDICT_OF(k) {name}_predict(&f{given(what['predict'], 0, 'u')})", "#define UPDATES_OF(k) \\",
                      *updates, ""])


def told(folder: Path) -> dict[str, Any]:
    found = sorted(folder.glob("*.json"))
    if len(found) != 1:
        raise UserError(f"{folder}: no filter with what kalmanq compile --json has told of it")
    return json.loads(found[0].read_text(encoding="utf-8"))


def flash(written: Path) -> int:
    """Code and constants of the file, without what it takes from the compiler's library."""
    return flash_and_ram(written)[0]


def naming(what: dict[str, Any]) -> str:
    name, word = what["name"], "float" if what["arithmetic"] == "f32" else "int32_t"
    one = "0x1p-10f" if word == "float" else "1024"  # twelve of them are within any range
    u = f"static const {word} pushes[{what['l']}];" if what["l"] else ""
    predict, step = ("f, pushes", "f, pushes, z") if what["l"] else ("f", "f, z")
    return "\n".join([f'#include "{name}.h"', "#define REFUSED (f.events)", f"typedef {word} word;", f"#define FILTER {name}_filter",
                      f"#define DO(call) {name}_##call", f"#define PREDICT_OF(f) {name}_predict({predict})",
                      f"#define STEP_OF(f, z) {name}_step({step})", f"#define ONE {one}", u,
                      *settling(what)])


def settling(what: dict[str, Any]) -> list[str]:
    """The count of calls is set: the bound on the rows until then may be thousands of samples"""
    calls = what["calls"]
    return [f"enum {{ M = {what['m']}, ROWS = {8 * (not calls)} }};", f"#define SETTLE(f) ({f'(f).calls = {calls}u' if calls else '(void)0'})",
            ""]


def broken_promises(made: dict[str, Any], folder: Path) -> list[str]:
    """What is dearer than it may be, and of those filters what is farther from its estimate than is said of it"""
    what = told(folder)
    promised, where = what.get("must", {}), f"{made['core']} {made['level']}"
    broken = [f"{made['name']} on {where}: {measure} {made[measure]}, at most {most}"
              for measure, most in promised.get(where, {}).items() if made[measure] > most]
    expected = what.get("costs", {}).get(where, {}) if promised else {}
    return broken + [f"{made['name']} on {where}: {measure} {made[measure]}, estimated as {expected[measure]}"
                     for measure, off in expected.get("off", {}).items() if _is_off(measure, expected[measure], made, off)]


def _is_off(measure: str, expected: int, made: dict[str, Any], off: float) -> bool:
    """The stack's estimate is a bound"""
    return made[measure] > expected if measure == "stack" else abs(expected - made[measure]) > off * made[measure]


def main(folders: list[Path] = typer.Argument(...), core: list[str] = typer.Option(["m4f"], "--core"),
         level: list[str] = typer.Option(["O2"], "--level"), out: Path = typer.Option(None, "--csv")) -> None:
    made, broken = [], []
    with tempfile.TemporaryDirectory(prefix="kalmanq-compiled-") as work:
        place = Place(ROOT, Path(work))
        if "avr" in core:
            build.avr_counter(place)
        for folder in folders:
            for name in core:
                for optimised in level:
                    row = measured(place, BY_NAME[name], folder, optimised)
                    made.append(row)
                    broken += broken_promises(row, folder)
                    if not out:
                        print("  ".join(f"{column} {row[column]}" for column in ([*row] if "program" in row else COLUMNS)), flush=True)
    if out:
        write(out, "# compiled filters on emulated cores (tools/cost/compiled.py)\n" +
              csv_text([COLUMNS, *([one.get(column, "") for column in COLUMNS] for one in made)]))
    end_of("compiled filters", len(made), broken)


if __name__ == "__main__":
    with told_in_one_line("compiled"):
        typer.run(main)
