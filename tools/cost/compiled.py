#!/usr/bin/env python3
"""Measures filters that kalmanq compile has written on the emulated cores, as the package does.

    compiled.py FOLDER... --core CORE [--level O2] [--csv OUT.csv]

FOLDER has NAME.c, NAME.h and NAME.json (`kalmanq compile --json`).  Printed, or written to OUT.csv: what
kalmanq/firmware/measured.py measures.  Where NAME.json has promises (`must`), what is measured has to be within them; where
it tells costs, these have to be what is measured.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import typer
from errors import UserError, told_in_one_line
from kalmanq.firmware import measured as package
from kalmanq.firmware.cores import BY_NAME, Core
from outputs import csv_text, end_of, write

COLUMNS = ("core", "name", "arithmetic", "level", "n", "m", "two_calls", "two_calls_settled", "step", "step_settled",
           "flash", "program", "ram", "stack")


def measured(core: Core, folder: Path, level: str) -> dict[str, Any]:
    if reason := package.why_not(core):
        raise UserError(f"{core.name}: {reason}")
    what = told(folder)
    texts = {path.name: path.read_text(encoding="utf-8") for path in sorted(folder.glob("*.[ch]"))}
    made = package.measured(core, what, texts, level)
    return {"core": core.name, **{key: what[key] for key in ("name", "arithmetic", "n", "m")}, "level": level, **made, "ram": what["ram"]}


def told(folder: Path) -> dict[str, Any]:
    found = sorted(folder.glob("*.json"))
    if len(found) != 1:
        raise UserError(f"{folder}: no filter with what kalmanq compile --json has told of it")
    return json.loads(found[0].read_text(encoding="utf-8"))


def broken_promises(made: dict[str, Any], folder: Path) -> list[str]:
    """What is dearer than it may be, and what was told otherwise"""
    what, where = told(folder), f"{made['core']} {made['level']}"
    broken = [f"{made['name']} on {where}: {measure} {made[measure]}, at most {most}"
              for measure, most in what.get("must", {}).get(where, {}).items() if made[measure] > most]
    return broken + [f"{made['name']} on {where}: {measure} {made[measure]}, told as {count}"
                     for measure, count in what.get("costs", {}).get(where, {}).items() if made[measure] != count]


def main(folders: list[Path] = typer.Argument(...), core: list[str] = typer.Option(["m4f"], "--core"),
         level: list[str] = typer.Option(["O2"], "--level"), out: Path = typer.Option(None, "--csv")) -> None:
    made, broken = [], []
    for folder in folders:
        for name in core:
            for optimised in level:
                row = measured(BY_NAME[name], folder, optimised)
                made.append(row)
                broken += broken_promises(row, folder)
                if not out:
                    print("  ".join(f"{column} {value}" for column, value in row.items()), flush=True)
    if out:
        write(out, "# compiled filters on emulated cores (tools/cost/compiled.py)\n" +
              csv_text([COLUMNS, *([one.get(column, "") for column in COLUMNS] for one in made)]))
    end_of("compiled filters", len(made), broken)


if __name__ == "__main__":
    with told_in_one_line("compiled"):
        typer.run(main)
