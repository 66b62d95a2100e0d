#!/usr/bin/env python3
"""Measures filters that kalmanq compile has written on the emulated cores, as the package does: compiled_costs.py FOLDER... --core CORE.

FOLDER has NAME.c, NAME.h and NAME.json (`kalmanq compile --json`).  Where NAME.json has promises (`must`), what is measured has to be
within them; where it tells costs, these have to be what is measured.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from kalmanq.firmware import measured as package  # noqa: E402
from kalmanq.firmware.cores import BY_NAME, Core, NotMeasured  # noqa: E402


def measured(core: Core, folder: Path, level: str) -> dict[str, Any]:
    if reason := package.why_not(core):
        raise NotMeasured(f"{core.name}: {reason}")
    what = told(folder)
    texts = {path.name: path.read_text(encoding="utf-8") for path in sorted(folder.glob("*.[ch]"))}
    made = package.measured(core, what, texts, level)
    return {"core": core.name, **{key: what[key] for key in ("name", "arithmetic", "n", "m")}, "level": level, **made, "ram": what["ram"]}


def told(folder: Path) -> dict[str, Any]:
    found = sorted(folder.glob("*.json"))
    if len(found) != 1:
        raise NotMeasured(f"{folder}: no filter with what kalmanq compile --json has told of it")
    return json.loads(found[0].read_text(encoding="utf-8"))


def broken_promises(made: dict[str, Any], folder: Path) -> list[str]:
    """What is dearer than it may be, and what was told otherwise"""
    what, where = told(folder), f"{made['core']} {made['level']}"
    broken = [f"{made['name']} on {where}: {measure} {made[measure]}, at most {most}"
              for measure, most in what.get("must", {}).get(where, {}).items() if made[measure] > most]
    return broken + [f"{made['name']} on {where}: {measure} {made[measure]}, told as {count}"
                     for measure, count in what.get("costs", {}).get(where, {}).items() if made[measure] != count]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--core", action="append", choices=list(BY_NAME))
    parser.add_argument("--level", action="append")
    given = parser.parse_args()
    count, broken = 0, []
    for folder in given.folders:
        for core in given.core or ["m4f"]:
            for level in given.level or ["O2"]:
                row = measured(BY_NAME[core], folder, level)
                count, broken = count + 1, broken + broken_promises(row, folder)
                print("  ".join(f"{column} {value}" for column, value in row.items()), flush=True)
    print(*broken, sep="\n", end="\n" * bool(broken), file=sys.stderr)
    print(f"{count} compiled filters measured, {len(broken)} promises broken")
    sys.exit(bool(broken))


if __name__ == "__main__":
    try:
        main()
    except NotMeasured as problem:
        sys.exit(f"compiled_costs: {problem}")
