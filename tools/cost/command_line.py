"""The command line.  Started by tools/cost.py."""

from pathlib import Path
from typing import List, Optional

import typer

import readme
import report
import table
from cases import PROFILES, WHAT, Choice, Own, Program, own_programs, programs
from cores import ROOT, compilers
from measure import Measured, measure_all
from errors import UserError, told_in_one_line
from outputs import Outputs, shown, terminal, write
from table import Table, compare

TABLE = ROOT / "tools" / "cost.csv"
PICTURE = ROOT / "tools" / "cost.png"
PAGES = (  # and what each has of the table
    (ROOT / "README.md", readme.summary),
    (ROOT / "tools" / "cost" / "README.md", readme.section),
)
WIDTH = 200  # of every table, where there is no terminal

HELP = """What the library costs on seven cores: instructions, estimated cycles, stack, RAM and
flash. Without options: measures everything and writes tools/cost.csv. With any of the filters
(each may be repeated): prints what they let through. tools/cost/README.md says what is counted."""

app = typer.Typer(add_completion=False, pretty_exceptions_enable=False)


@app.command(help=" ".join(HELP.split()))
def main(
    core: List[str] = typer.Option([], help="m0, m3, m4f, m7, m33, rv32, avr."),
    arithmetic: List[str] = typer.Option([], help="f32, f64, q31, textbook-f32, textbook-q16."),
    sizes: List[str] = typer.Option([], help="runtime, fixed, fixed-dense."),
    profile: List[str] = typer.Option([], help=", ".join(PROFILES) + "."),
    n: List[int] = typer.Option([], help="Number of states."),
    what: List[str] = typer.Option([], help=", ".join(WHAT) + "."),
    states: Optional[int] = typer.Option(None, help="Print the card of a filter of your own size."),
    components: int = typer.Option(1, help="... measured at once, with --states."),
    controls: int = typer.Option(0, help="... with --states."),
    hot: int = typer.Option(0, help="Print the functions with most instructions, too."),
    source: Path = typer.Option(
        ROOT, help="A checkout to measure instead of this one.", show_default=False
    ),
    check: bool = typer.Option(False, "--check", help="Compare with tools/cost.csv."),
    plot: bool = typer.Option(False, "--plot", help="Draw the table: tools/cost.png."),
    update_pages: bool = typer.Option(False, "--readme", help="Put the table into the pages."),
) -> None:
    with told_in_one_line("cost"):
        choice = Choice(
            tuple(core), tuple(arithmetic), tuple(sizes), tuple(profile), tuple(n), tuple(what)
        )
        choice.check()
        if check:
            raise typer.Exit(0 if as_in_the_table(source, choice) else 1)
        if states is not None:
            show_card(source, choice, Own(states, components, controls))
        if plot:
            draw()
        if update_pages:
            write_pages()
        if states is None and not (plot or update_pages):
            measure(source, choice, hot)


# ---- what it asks for ------------------------------------------------------------------------


def measure(source: Path, choice: Choice, hot: int) -> None:
    """Writes the table if it is a whole one of this checkout, else prints."""
    found = measured(source, choice)
    if choice != Choice() or hot or source.resolve() != ROOT:
        report.show(terminal(WIDTH), found, choice.what, hot)
        return
    rows = tuple(row for each in found for row in each.rows)
    write(TABLE, table.to_csv(Table(compilers(), rows)))
    print(f"wrote {shown(TABLE)}: {len(rows)} rows; --plot and --readme show them")


def as_in_the_table(source: Path, choice: Choice) -> bool:
    """Has nothing grown, and do the pages say what the table says?"""
    before = table.read(TABLE)
    stale = [page for page, part in PAGES if not readme.matches(page, before.rows, part)]
    now = [row for each in measured(source, choice) for row in each.rows if choice.takes_row(row)]
    comparison = compare(filter(choice.takes_row, before.rows), now)
    report.show_comparison(terminal(WIDTH), comparison, before.versions, compilers())
    for page in stale:
        print(f"{shown(page)}: its costs are not the table's; tools/cost.py --readme writes them")
    passes = comparison.passes and not stale
    print(f"{len(now)} rows measured: {'as in the table' if passes else 'FAILED'}")
    return passes


def draw() -> None:
    import plot  # late: Matplotlib takes its time

    rows = table.read(TABLE).rows
    with Outputs(PICTURE.parent) as outputs:
        plot.save(rows, outputs.stage(PICTURE.name))
    print(f"wrote {shown(PICTURE)}")


def write_pages() -> None:
    rows = table.read(TABLE).rows
    for page, part in PAGES:
        write(page, readme.rewritten(page, rows, part))
        print(f"wrote {shown(page)}")


def show_card(source: Path, choice: Choice, size: Own) -> None:
    """Prints the cards of a user's own size."""
    size.check()
    report.show_cards(terminal(WIDTH), measured_programs(source, own_programs(choice, size)))


def measured(source: Path, choice: Choice) -> list[Measured]:
    return measured_programs(source, programs(choice))


def measured_programs(source: Path, wanted: list[Program]) -> list[Measured]:
    if not (source / "include" / "kalmanq").is_dir():
        raise UserError(f"--source {source}: is not a checkout of kalmanq")
    if not wanted:
        raise UserError("there is nothing like that to measure")
    return measure_all(source.resolve(), wanted)
