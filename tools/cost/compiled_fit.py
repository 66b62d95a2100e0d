#!/usr/bin/env python3
"""Fits what compiled filters cost to what was measured: tools/kalmanq/compiler/costs.csv.

    compiled_fit.py MEASURED.csv FOLDER... -o costs.csv

MEASURED.csv is what compiled.py --csv has written of these folders, which hold operations of each filter in
what `kalmanq compile --json` has told.  Printed: the worst differences.
"""

from __future__ import annotations

import csv
import json
from collections import defaultdict
from pathlib import Path

import numpy as np
import typer
from scipy.optimize import nnls

from outputs import csv_text, write

DIGITS = 3


def main(measured: Path = typer.Argument(...), folders: list[Path] = typer.Argument(...),
         out: Path = typer.Option(..., "-o")) -> None:
    told = {}
    for folder in folders:
        what = json.loads(next(folder.glob("*.json")).read_text(encoding="utf-8"))
        told[what["name"], what["arithmetic"]] = what["operations"]
    rows = list(csv.DictReader(line for line in measured.read_text().splitlines() if not line.startswith("#")))
    groups: dict[tuple[str, str, str], list[dict[str, str]]] = defaultdict(list)
    for row in rows:
        groups[row["core"], row["arithmetic"], row["level"]].append(row)
    names = list(next(iter(told.values()))["flash"])
    table, worst = [("core", "arithmetic", "level", "measure", *names)], []
    for (core, arithmetic, level), of in sorted(groups.items()):
        for measure in ("two_calls", "step_settled", "flash"):
            X = np.array([[told[row["name"], arithmetic][measure][name] for name in names] for row in of], float)
            y = np.array([float(row[measure]) for row in of])
            factor, _ = nnls(X / y[:, None], np.ones(len(y)))  # relative differences
            factor = np.array([float(f"{value:.{DIGITS}g}") for value in factor])
            table.append((core, arithmetic, level, measure, *factor))
            worst.append((np.abs(X @ factor / y - 1).max(), core, arithmetic, level, measure, len(y)))
    write(out, "# factors of operations, fitted to emulated cores (tools/cost/compiled_fit.py)\n" + csv_text(table))
    for line in sorted(worst, reverse=True)[:6]:
        print("%.0f %% off at most: %s" % (100 * line[0], " ".join(map(str, line[1:]))))


if __name__ == "__main__":
    typer.run(main)
