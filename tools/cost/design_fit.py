#!/usr/bin/env python3
"""Fits what designs cost to what was measured: tools/kalmanq/firmware/costs.csv, and the deepest stacks, stacks.csv.

    design_fit.py MEASURED.csv FOLDER

designs.py --csv has written MEASURED.csv.  Printed: how far the sums are off at most.  Farther than MOST_OFF is an
error, and writes nothing.
"""

from __future__ import annotations

import csv
import math
import sys
from collections import defaultdict
from pathlib import Path

import numpy as np
import typer
from kalmanq.firmware.costs import SUMS, terms
from scipy.optimize import nnls

from outputs import csv_text, write

DIGITS = 4
MOST_OFF = 0.2
NOTE = "designs on emulated cores, gcc -O2, -ffp-contract=off (tools/cost/designs.py, design_fit.py)"
Row = dict[str, int]
Group = tuple[str, str, str]  # core, arithmetic, way


def grouped(file: Path) -> dict[Group, list[Row]]:
    made: dict[Group, list[Row]] = defaultdict(list)
    for row in csv.DictReader(line for line in file.read_text().splitlines() if not line.startswith("#")):
        key = row.pop("core"), row.pop("arithmetic"), row.pop("way")
        made[key].append({name: int(value) for name, value in row.items()})
    return made


def fit(rows: list[Row], measure: str) -> tuple[dict[str, float], float]:
    """Factors that are not negative, of the least relative errors; and the largest of these"""
    names = list(terms(measure, rows[0]))
    table = np.array([list(terms(measure, row).values()) for row in rows], float)
    found = np.array([row[measure] for row in rows], float)
    scale = np.maximum(np.abs(table).max(axis=0), 1e-9)
    solution, _ = nnls(table / scale / found[:, None], np.ones(len(rows)))
    factors = np.array([float(f"{value:.{DIGITS}g}") for value in solution / scale])
    off = float(np.abs(table @ factors / found - 1).max())
    return {name: factor for name, factor in zip(names, factors) if factor}, off


def stacks(rows: list[Row], sizes: list[int]) -> list[list[int]]:
    """For each kind that there is: correlated, unknown, the deepest stack up to each size"""
    kinds = sorted({(row["correlated"], row["unknown"]) for row in rows})
    return [[*kind, *(max((row["stack"] for row in rows if (row["correlated"], row["unknown"]) == kind and
                           row["n"] <= size), default=0) for size in sizes)] for kind in kinds]


def main(measured: Path, folder: Path) -> None:
    groups = grouped(measured)
    every = [row for rows in groups.values() for row in rows]
    names = list(dict.fromkeys(name for measure in SUMS for name in terms(measure, every[0])))
    sizes = sorted({row["n"] for row in every})
    costs: list[tuple] = [("core", "arithmetic", "way", "measure", "off", *names)]
    depths: list[tuple] = [("core", "arithmetic", "way", "correlated", "unknown", *sizes)]
    worst = dict.fromkeys(SUMS, 0.0)
    for group, rows in groups.items():
        for measure in SUMS:
            factors, off = fit(rows, measure)
            worst[measure] = max(worst[measure], off)
            cells = (f"{factors[name]:g}" if name in factors else "" for name in names)
            costs.append((*group, measure, f"{math.ceil(100 * off) / 100:.2f}", *cells))
        depths += [(*group, *depth) for depth in stacks(rows, sizes)]
    print(f"{len(every)} designs; off at most: {', '.join(f'{name} {100 * off:.1f} %' for name, off in worst.items())}")
    if max(worst.values()) > MOST_OFF:
        sys.exit(f"design_fit: farther off than {100 * MOST_OFF:.0f} %")
    write(folder / "costs.csv", f"# factors of {NOTE}\n" + csv_text(costs))
    write(folder / "stacks.csv", f"# the deepest stacks of {NOTE}\n" + csv_text(depths))


if __name__ == "__main__":
    typer.run(main)
