"""What the command line asks for."""

from __future__ import annotations

import os
import sys
from pathlib import Path

from rich.console import Console

import outputs
import readme
import report
import table
from cases import Choice, Own, Program, own_programs, programs
from compare import compare
from errors import CostError
from measure import Measured
from row import Row
from run_all import run_all
from table import Table
from versions import compilers

ROOT = Path(__file__).resolve().parents[2]
TABLE = ROOT / "tools" / "cost.csv"
PICTURE = ROOT / "tools" / "cost.png"
README = ROOT / "README.md"


def measure(source: Path, choice: Choice, hot: int) -> None:
    """Writes the table if it is a whole one of this checkout, else prints."""
    found = measured(source, choice)
    if choice != Choice() or hot or source.resolve() != ROOT:
        report.show(console(), found, choice.what, hot)
        return
    rows = tuple(row for each in found for row in each.rows)
    outputs.write(TABLE, table.to_csv(Table(compilers(), rows)))
    print(f"wrote {shown(TABLE)}: {len(rows)} rows; --plot and --readme show them")


def check(source: Path, choice: Choice) -> bool:
    """Has nothing grown, and does the README say what the table says?"""
    before = table.read(TABLE)
    readme_is_right = readme.matches(README, before.rows)
    now = [row for each in measured(source, choice) for row in each.rows if choice.takes_row(row)]
    comparison = compare(filter(choice.takes_row, before.rows), now)
    report.show_comparison(console(), comparison, before.versions, compilers())
    if not readme_is_right:
        print(f"{shown(README)}: its costs are not the table's; tools/cost.py --readme writes them")
    passes = comparison.passes and readme_is_right
    print(f"{len(now)} rows measured: {'as in the table' if passes else 'FAILED'}")
    return passes


def draw() -> None:
    import plot  # late: Matplotlib takes its time

    rows = table.read(TABLE).rows
    with outputs.staged(PICTURE) as path:
        plot.save(rows, path)
    print(f"wrote {shown(PICTURE)}")


def write_readme() -> None:
    outputs.write(README, readme.rewritten(README, table.read(TABLE).rows))
    print(f"wrote {shown(README)}")


def show_card(source: Path, choice: Choice, size: Own) -> None:
    """Prints the cards of a user's own size."""
    size.check()
    report.show_cards(console(), measured_programs(source, own_programs(choice, size)))


def measured(source: Path, choice: Choice) -> list[Measured]:
    return measured_programs(source, programs(choice))


def measured_programs(source: Path, wanted: list[Program]) -> list[Measured]:
    if not (source / "include" / "kalmanq").is_dir():
        raise CostError(f"--source {source}: is not a checkout of kalmanq")
    if not wanted:
        raise CostError("there is nothing like that to measure")
    return run_all(source.resolve(), wanted)


def console() -> Console:
    # not a terminal: wide enough for every table, whatever reads it
    return Console(highlight=False, width=None if sys.stdout.isatty() else 200)


def shown(path: Path) -> str:
    """The path as seen from here, if that is shorter."""
    return min(str(path), os.path.relpath(path), key=len)
