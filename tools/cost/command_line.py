"""The command line.  Started by tools/cost.py."""

from dataclasses import replace
from pathlib import Path
from typing import Container, List, Optional

import typer

import readme
import report
import table
from cases import PROFILES, WHAT, Choice, Own, Program, own_programs, programs
from cores import ROOT, compilers, incomparable
from measure import Measured, measure_all
from errors import UserError, told_in_one_line
from outputs import shown, terminal, write
from table import Table, compare

TABLE = ROOT / "tools" / "cost.csv"
PAGES = (  # and what each has of the table
    (ROOT / "README.md", readme.summary),
    (ROOT / "tools" / "cost" / "README.md", readme.section),
)
WIDTH = 200  # of every table, where there is no terminal

HELP = """What the library costs on seven cores: instructions, estimated cycles, stack, RAM and
flash. Without options: measures what the pages show and writes tools/cost.csv. With any of the filters
(each may be repeated): prints what they let through, of all that can be measured. tools/cost/README.md
says what is counted."""

app = typer.Typer(add_completion=False, pretty_exceptions_enable=False)


@app.command(help=" ".join(HELP.split()))
def main(core: List[str] = typer.Option([], help="m0, m3, m4f, m7, m33, rv32, avr."),
         arithmetic: List[str] = typer.Option([], help="f32, f64, q31, textbook-f32, textbook-q16."),
         sizes: List[str] = typer.Option([], help="runtime, fixed, fixed-dense."),
         profile: List[str] = typer.Option([], help=", ".join(PROFILES) + "."),
         n: List[int] = typer.Option([], help="Number of states."),
         what: List[str] = typer.Option([], help=", ".join(WHAT) + "."),
         states: Optional[int] = typer.Option(None, help="Print the card of a filter of your own size."),
         components: int = typer.Option(1, help="... measured at once, with --states."),
         controls: int = typer.Option(0, help="... with --states."),
         hot: int = typer.Option(0, help="Print the functions with most instructions, too."),
         source: Path = typer.Option(ROOT, help="A checkout to measure instead of this one.", show_default=False),
         check: bool = typer.Option(False, "--check", help="Compare with tools/cost.csv."),
         out: Optional[Path] = typer.Option(None, "--csv", help="Write what is measured to this file."),
         update_pages: bool = typer.Option(False, "--readme", help="Put the table into the pages.")) -> None:
    with told_in_one_line("cost"):
        choice = Choice(tuple(core), tuple(arithmetic), tuple(sizes), tuple(profile), tuple(n), tuple(what))
        choice.check()
        if check:
            raise typer.Exit(0 if as_in_the_table(source, choice) else 1)
        if states is not None:
            show_card(source, choice, Own(states, components, controls))
        if update_pages:
            write_pages()
        if states is None and not update_pages:
            measure(source, choice, hot, out)


# ---- what it asks for ------------------------------------------------------------------------


def measure(source: Path, choice: Choice, hot: int, out: Optional[Path]) -> None:
    """Writes the committed table, or to the file that is named; else prints."""
    is_table = choice == Choice() and not (hot or out) and source.resolve() == ROOT
    if is_table:
        save(TABLE, measured_programs(source, of_kept(programs(choice))), readme.kept())
        print("--readme puts it into the pages")
        return
    found = measured_programs(source, programs(choice))
    if out:
        save(out, found)
    else:
        report.show(terminal(WIDTH), found, choice.what, hot)


def save(path: Path, found: list[Measured], keys: Optional[Container[tuple[object, ...]]] = None) -> None:
    rows = tuple(row for each in found for row in each.rows if keys is None or row.key in keys)
    write(path, table.to_csv(Table(compilers(), rows)))
    print(f"wrote {shown(path)}: {len(rows)} rows")


def of_kept(wanted: list[Program]) -> list[Program]:
    """The programs with rows that are committed, at the sizes of those rows."""
    return [replace(program, dimensions=sizes) for program in wanted if (sizes := kept_sizes(program))]


def kept_sizes(p: Program) -> tuple[tuple[int, int], ...]:
    keys = readme.kept()
    return tuple((n, m) for n, m in p.dimensions if any(
        (p.core, p.arithmetic, n, m, p.sizes, p.profile, what) in keys for what in p.what(n)))


def as_in_the_table(source: Path, choice: Choice) -> bool:
    if reason := incomparable(table.read(TABLE).versions):
        print(reason)
        return True
    return are_as_in_the_table(measured_programs(source, of_kept(programs(choice))), choice)


def are_as_in_the_table(found: list[Measured], choice: Choice) -> bool:
    """Has nothing grown, and do the pages say what the table says?"""
    before, keys = table.read(TABLE), readme.kept()
    stale = [page for page, part in PAGES if not readme.matches(page, before.rows, part)]
    now = [row for each in found for row in each.rows if choice.takes_row(row) and row.key in keys]
    comparison = compare(filter(choice.takes_row, before.rows), now)
    report.show_comparison(terminal(WIDTH), comparison, before.versions, compilers())
    for page in stale:
        print(f"{shown(page)}: its costs are not the table's; tools/cost.py --readme writes them")
    passes = comparison.passes and not stale
    print(f"{len(now)} rows measured: {'as in the table' if passes else 'FAILED'}")
    return passes


def write_pages() -> None:
    rows = table.read(TABLE).rows
    for page, part in PAGES:
        write(page, readme.rewritten(page, rows, part))
        print(f"wrote {shown(page)}")


def show_card(source: Path, choice: Choice, size: Own) -> None:
    size.check()
    report.show_cards(terminal(WIDTH), measured_programs(source, own_programs(choice, size)))


def measured_programs(source: Path, wanted: list[Program]) -> list[Measured]:
    if not (source / "include" / "kalmanq").is_dir():
        raise UserError(f"--source {source}: is not a checkout of kalmanq")
    if not wanted:
        raise UserError("there is nothing like that to measure")
    return measure_all(source.resolve(), wanted)
