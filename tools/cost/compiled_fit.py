#!/usr/bin/env python3
"""Fits what compiled filters cost to what was measured: tools/kalmanq/compiler/proven/costs.csv.

    compiled_fit.py FOLDER --fit FITTED.csv... --check CHECKED.csv... -o costs.csv

tests/tools/compiled_plans.py has written FOLDER, with the operations of each filter, and compiled.py --csv what was
measured of FOLDER/fit and of FOLDER/check.  Printed: how far off the sums are for those that were fitted, and for
others, with the worst one's name, and for the five models.  What is farther off than MOST_OFF has no row: it is not
estimated.
"""

from __future__ import annotations

import csv
import json
import math
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path
from typing import Iterable

import numpy as np
import typer
from scipy.optimize import nnls

from outputs import csv_text, write

DIGITS = 3
MOST_OFF = 0.25
MEASURES = ("two_calls", "step_settled", "flash")
SPILLS = "spills"
Row = dict[str, str]
Told = dict[tuple[str, str], dict[str, dict[str, int]]]
Group = tuple[str, str, str]


def grouped(files: Iterable[Path]) -> dict[Group, list[Row]]:
    """By core, arithmetic and level"""
    made: dict[Group, list[Row]] = defaultdict(list)
    for file in files:
        for row in csv.DictReader(line for line in file.read_text().splitlines() if not line.startswith("#")):
            made[row["core"], row["arithmetic"], row["level"]].append(row)
    return made


def told_of(folder: Path) -> Told:
    """The operations of each filter"""
    told: Told = {}
    for file in sorted(folder.glob("*/*/*.json")):
        what = json.loads(file.read_text(encoding="utf-8"))
        told[what["name"], what["arithmetic"]] = what["operations"]
    return told


def table_of(rows: list[Row], told: Told, measure: str, kinds: list[str]) -> tuple[np.ndarray, np.ndarray]:
    X = np.array([[told[row["name"], row["arithmetic"]][measure][kind] for kind in kinds] for row in rows], float)
    return X, np.array([float(row[measure]) for row in rows])


def fit(X: np.ndarray, y: np.ndarray, kinds: list[str]) -> np.ndarray:
    """Least relative differences, no factor negative; of the numbers of registers the one that fits best"""
    best, least = np.zeros(len(kinds)), math.inf
    for registers in (kind for kind in kinds if kind.startswith(SPILLS)):
        taken = np.array([not kind.startswith(SPILLS) or kind == registers for kind in kinds])
        factor, rest = nnls(X / y[:, None] * taken, np.ones(len(y)))
        if rest < least:
            best, least = factor * taken, rest
    return np.array([float(f"{value:.{DIGITS}g}") for value in best])


@dataclass(frozen=True)
class Off:
    """How far sums are off what was measured, as shares: of filters that were fitted, and of others"""

    fitted: np.ndarray
    checked: np.ndarray
    names: list[str]  # of the others

    @property
    def most(self) -> float:
        return math.ceil(100 * max(np.abs(self.fitted).max(), np.abs(self.checked).max())) / 100

    def told(self) -> str:
        worst = int(np.abs(self.checked).argmax())
        five = [abs(off) for off, name in zip(self.checked, self.names) if name.startswith("m")]
        return (f"{len(self.fitted)} fitted, {100 * np.abs(self.fitted).max():.1f} % off at most; {len(self.checked)} "
                f"checked, {100 * math.sqrt(np.mean(self.checked**2)):.1f} % rms, {100 * self.checked[worst]:+.1f} % "
                f"at most ({self.names[worst]}), {100 * max(five):.1f} % of the five" +
                ("" if self.most <= MOST_OFF else ": not estimated"))


def main(folder: Path = typer.Argument(...), fitted: list[Path] = typer.Option(..., "--fit"),
         checked: list[Path] = typer.Option(..., "--check"), out: Path = typer.Option(..., "-o")) -> None:
    told = told_of(folder)
    kinds = list(next(iter(told.values()))["flash"])
    table, beside = [("core", "arithmetic", "level", "measure", "off", *kinds)], grouped(checked)
    for group, rows in sorted(grouped(fitted).items()):
        for measure in MEASURES:
            X, y = table_of(rows, told, measure, kinds)
            factor = fit(X, y, kinds)
            X_others, y_others = table_of(beside[group], told, measure, kinds)
            off = Off(X @ factor / y - 1, X_others @ factor / y_others - 1, [row["name"] for row in beside[group]])
            print(f"{' '.join(group)} {measure}: {off.told()}")
            if off.most <= MOST_OFF:
                table.append((*group, measure, f"{off.most:.2f}",
                              *(f"{value:g}" if value else "" for value in factor)))
    write(out, "# factors of operations, fitted to emulated cores (tools/cost/compiled_fit.py)\n" + csv_text(table))


if __name__ == "__main__":
    typer.run(main)
