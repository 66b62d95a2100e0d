"""Rows on the terminal."""

from __future__ import annotations

from typing import Sequence

from rich import box
from rich.console import Console
from rich.table import Table

from measure import Measured

TEXT, NUMBERS = ("core", "arithmetic", "sizes", "level", "n", "m", "what"), (
    "instructions", "cycles~", "stack", "ram", "flash")


def show(console: Console, found: list[Measured], what: Sequence[str], hot: int) -> None:
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for name in TEXT:
        table.add_column(name)
    for name in NUMBERS:
        table.add_column(name, justify="right")
    for measured in found:
        for row, functions in zip(measured.rows, measured.self_instructions):
            if what and row.what not in what:
                continue
            table.add_row(row.core, row.arithmetic, row.sizes, row.optimisation, str(row.n),
                          str(row.m), row.what, f"{row.instructions}", f"{row.cycles_estimate}",
                          f"{row.stack_bytes}", f"{row.ram_bytes}", f"{row.flash_bytes}")
            for name, count in functions.most_common(hot):
                table.add_row("", "", "", "", "", "", f"  {name}", f"{count}")
    console.print(table)
