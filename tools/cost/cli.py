"""What the library costs on seven cores: instructions, cycles, stack, RAM and flash.

Started by tools/cost.py.
"""

import sys
from pathlib import Path
from typing import List, Optional

import typer
from rich.console import Console

import report
from cases import Choice, programs
from errors import CostError, one_line
from run_all import run_all

ROOT = Path(__file__).resolve().parents[2]

app = typer.Typer(add_completion=False, pretty_exceptions_enable=False)


@app.command()
def main(
    core: List[str] = typer.Option([], help="Only this core; may be repeated."),
    arithmetic: List[str] = typer.Option([], help="Only f32, f64, q31, textbook-f32, textbook-q16."),
    sizes: List[str] = typer.Option([], help="Only runtime, fixed, fixed-dense."),
    optimisation: List[str] = typer.Option([], help="Only O2, O3, Os."),
    n: List[int] = typer.Option([], help="Only this number of states."),
    what: List[str] = typer.Option([], help="Only predict, update, step, smooth."),
    hot: int = typer.Option(0, help="Also the functions that took most, by self instructions."),
    source: Path = typer.Option(ROOT, help="A checkout to measure instead of this one."),
) -> None:
    try:
        choice = Choice(tuple(core), tuple(arithmetic), tuple(sizes), tuple(optimisation), tuple(n))
        found = run_all(source.resolve(), programs(choice), lambda *_: None)
        report.show(Console(highlight=False, width=None if sys.stdout.isatty() else 130), found, what, hot)
    except CostError as problem:
        stop(str(problem))
    except OSError as problem:
        stop(f"{one_line(str(problem.filename or 'file'))}: {problem.strerror or problem}")


def stop(line: str) -> None:
    print(f"cost: {line}", file=sys.stderr)
    raise typer.Exit(1)
