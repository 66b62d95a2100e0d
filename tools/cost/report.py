"""Rows and comparisons on the terminal."""

from __future__ import annotations

from typing import Sequence

from rich import box
from rich.console import Console
from rich.table import Table

import readme
from measure import Measured
from table import TOLERANCE, Change, Comparison, Row

TEXT = ("core", "arithmetic", "n", "m", "sizes", "profile", "what")
NUMBERS = ("instructions", "cycles~", "stack", "worst", "its stack", "ram", "flash")
MOST = 40  # lines of a kind


def show(console: Console, found: list[Measured], what: Sequence[str], hot: int) -> None:
    """Every row, and beneath it the functions that took most of its instructions."""
    table = empty(TEXT, NUMBERS)
    for measured in found:
        for row, functions in zip(measured.rows, measured.self_instructions):
            if what and row.what not in what:
                continue
            values = (
                row.instructions, row.cycles_estimate, row.stack_bytes, row.instructions_worst, row.stack_worst,
                row.ram_program, row.flash_program)
            table.add_row(*names(row), *("" if value is None else str(value) for value in values))
            for name, count in functions.most_common(hot):
                table.add_row(*[""] * 6, f"  {name}", str(count))
    console.print(table)


def show_cards(console: Console, found: list[Measured]) -> None:
    table = empty(readme.TITLES[:3], readme.TITLES[3:])
    for each in readme.cards(row for measured in found for row in measured.rows):
        table.add_row(*each.cells())
    console.print(table)


def show_comparison(console: Console, found: Comparison, before: tuple[str, ...], now: tuple[str, ...]) -> None:
    if before != now:
        console.print("The table was made with other compilers:")
        console.print("\n".join(f"  {version}" for version in before if version not in now))
        console.print("and this is")
        console.print("\n".join(f"  {version}" for version in now if version not in before))
    show_changes(console, f"Grown by more than {TOLERANCE} %", found.worse)
    show_rows(console, "In the table, but not measured", found.not_measured)
    show_rows(console, "Measured, but not in the table", found.not_in_table)
    show_changes(console, f"Better by more than {TOLERANCE} %", found.better)


def show_changes(console: Console, title: str, changes: list[Change]) -> None:
    if not changes:
        return
    table = empty((*TEXT, "column"), ("table", "now", ""))
    for change in sorted(changes, key=lambda change: -abs(change.share))[:MOST]:
        table.add_row(*names(change.row), change.column, str(change.before), str(change.now), f"{change.share:+.1%}")
    console.print(f"{title}: {len(changes)}")
    console.print(table)


def show_rows(console: Console, title: str, rows: list[Row]) -> None:
    if not rows:
        return
    table = empty(TEXT, ())
    for row in rows[:MOST]:
        table.add_row(*names(row))
    console.print(f"{title}: {len(rows)}")
    console.print(table)


def empty(text: Sequence[str], numbers: Sequence[str]) -> Table:
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for name in text:
        table.add_column(name, justify="right" if name in ("n", "m") else "left")
    for name in numbers:
        table.add_column(name, justify="right")
    return table


def names(row: Row) -> tuple[str, ...]:
    return tuple(map(str, row.key))
