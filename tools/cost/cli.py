"""The command line.  Started by tools/cost.py."""

import sys
from pathlib import Path
from typing import List, Optional

import typer

import actions
from cases import PROFILES, WHAT, Choice, Own
from errors import CostError, one_line

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
        actions.ROOT, help="A checkout to measure instead of this one.", show_default=False
    ),
    check: bool = typer.Option(False, "--check", help="Compare with tools/cost.csv."),
    plot: bool = typer.Option(False, "--plot", help="Draw the table: tools/cost.png."),
    readme: bool = typer.Option(False, "--readme", help="Put the table into README.md."),
) -> None:
    try:
        choice = Choice(
            tuple(core), tuple(arithmetic), tuple(sizes), tuple(profile), tuple(n), tuple(what)
        )
        choice.check()
        if check:
            raise typer.Exit(0 if actions.check(source, choice) else 1)
        if states is not None:
            actions.show_card(source, choice, Own(states, components, controls))
        if plot:
            actions.draw()
        if readme:
            actions.write_readme()
        if states is None and not (plot or readme):
            actions.measure(source, choice, hot)
    except CostError as problem:
        stop(str(problem))
    except OSError as problem:
        stop(f"{one_line(str(problem.filename or 'file'))}: {problem.strerror or problem}")


def stop(line: str) -> None:
    print(f"cost: {line}", file=sys.stderr)
    raise typer.Exit(1)
