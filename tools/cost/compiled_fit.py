#!/usr/bin/env python3
"""Fits what compiled filters cost to what was measured: costs.csv of tools/kalmanq/compiler.

    compiled_fit.py FOLDER --fit FITTED.csv... --check CHECKED.csv... -o costs.csv

tests/tools/compiled_plans.py has written FOLDER, with the operations of each filter, and compiled.py --csv what was
measured of FOLDER/fit and of FOLDER/check.  Printed: how far off the sums are for those that were fitted, and for
others, with the worst one's name, and for the models whose names begin with --of.  What is farther off than --most-off has
no row: it is not estimated.  The stack's sum is raised until no filter that was measured has more.
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
STACK = "stack"
MEASURES = ("two_calls", "two_calls_settled", "step_settled", "flash", STACK)
ROOM = 16  # bytes that two stacks may differ by, which are next to none
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
    """Operations and what was measured; of the filters where it happens"""
    rows = those_with(rows, told, measure)
    X = np.array([[told[row["name"], row["arithmetic"]][measure][kind] for kind in kinds] for row in rows], float)
    return X, np.array([float(row[measure]) for row in rows])


def those_with(rows: list[Row], told: Told, measure: str) -> list[Row]:
    return [row for row in rows if measure in told[row["name"], row["arithmetic"]]]


def fit(X: np.ndarray, y: np.ndarray, kinds: list[str]) -> np.ndarray:
    """Least relative differences, no factor negative; of the numbers of registers the one that fits best"""
    best, least = np.zeros(len(kinds)), math.inf
    for registers in (kind for kind in kinds if kind.startswith(SPILLS)):
        taken = np.array([not kind.startswith(SPILLS) or kind == registers for kind in kinds])
        factor, rest = nnls(X / y[:, None] * taken, np.ones(len(y)))
        if rest < least:
            best, least = factor * taken, rest
    return rounded(best)


def fit_stack(X: np.ndarray, y: np.ndarray, kinds: list[str]) -> np.ndarray:
    """A frame, and words that have no register: never less than was measured"""
    taken = np.array([kind == "calls" or kind.startswith(SPILLS) for kind in kinds])
    factor = fit(X * taken, y + ROOM, kinds) * taken
    frame = kinds.index("calls")
    factor[frame] += np.ceil((y - X @ factor).max())
    return factor


def rounded(factor: np.ndarray) -> np.ndarray:
    return np.array([float(f"{value:.{DIGITS}g}") for value in factor])


@dataclass(frozen=True)
class Off:
    """How far sums are off what was measured, as shares: of filters that were fitted, and of others"""

    fitted: np.ndarray
    checked: np.ndarray
    names: list[str]  # of the others
    prefix: str  # of names that are told apart
    limit: float

    @property
    def most(self) -> float:
        return math.ceil(100 * max(np.abs(self.fitted).max(), np.abs(self.checked).max())) / 100

    def told(self) -> str:
        worst = int(np.abs(self.checked).argmax())
        apart = [abs(off) for off, name in zip(self.checked, self.names) if name.startswith(self.prefix)]
        return (f"{len(self.fitted)} fitted, {100 * np.abs(self.fitted).max():.1f} % off at most; {len(self.checked)} "
                f"checked, {100 * math.sqrt(np.mean(self.checked**2)):.1f} % rms, {100 * self.checked[worst]:+.1f} % "
                f"at most ({self.names[worst]}); {len(apart)} {self.prefix}*: {100 * np.median(apart):.1f} % in the "
                f"middle, {100 * max(apart):.1f} % at most" +
                ("" if self.most <= self.limit else ": not estimated"))


def main(folder: Path = typer.Argument(...), fitted: list[Path] = typer.Option(..., "--fit"),
         checked: list[Path] = typer.Option(..., "--check"), out: Path = typer.Option(..., "-o"),
         prefix: str = typer.Option("m", "--of"), most_off: float = typer.Option(0.25, "--most-off")) -> None:
    told = told_of(folder)
    kinds = list(next(iter(told.values()))["flash"])
    table, others = [("core", "arithmetic", "level", "measure", "off", *kinds)], grouped(checked)
    for group, rows in sorted(grouped(fitted).items()):
        for measure in MEASURES:
            if not those_with(rows, told, measure):
                continue
            row = row_of(rows, others[group], told, measure, kinds, f"{' '.join(group)} {measure}", prefix, most_off)
            table += [(*group, measure, *row)] if row else []
    used = [k for k in range(len(table[0])) if k < 5 or any(row[k] for row in table[1:])]
    table = [tuple(row[k] for k in used) for row in table]
    write(out, "# factors of operations, fitted to emulated cores (tools/cost/compiled_fit.py)\n" + csv_text(table))


def row_of(rows: list[Row], others: list[Row], told: Told, measure: str, kinds: list[str], title: str,
           prefix: str, most_off: float) -> tuple[str, ...]:
    """How far off, and the factors; nothing where that is too far"""
    (X, y), (X_others, y_others) = (table_of(some, told, measure, kinds) for some in (rows, others))
    if measure == STACK:
        factor = fit_stack(np.vstack([X, X_others]), np.concatenate([y, y_others]), kinds)
        print(f"{title}: at most {(X_others @ factor - y_others).max():.0f} bytes more than was measured")
        return ("0", *told_of_factors(factor))
    factor = fit(X, y, kinds)
    off = Off(X @ factor / y - 1, X_others @ factor / y_others - 1,
              [row["name"] for row in those_with(others, told, measure)], prefix, most_off)
    print(f"{title}: {off.told()}")
    return (f"{off.most:.2f}", *told_of_factors(factor)) if off.most <= most_off else ()


def told_of_factors(factor: np.ndarray) -> list[str]:
    return [f"{value:g}" if value else "" for value in factor]


if __name__ == "__main__":
    typer.run(main)
