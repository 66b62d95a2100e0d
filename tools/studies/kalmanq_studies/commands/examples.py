"""kalmanq examples: the theory's examples, each with its numbers and its figure."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Mapping, Optional

import numpy as np
import typer
from rich.console import Console

from kalmanq.commands.messages import print_json, table
from kalmanq.commands.options import JSON, choices, command_of
from kalmanq.core import ARITHMETICS
from kalmanq.data.files import require_folder
from kalmanq.pages import pictures
from kalmanq_studies.commands.listing import tell_choices
from kalmanq_studies.lectures import EXAMPLES
from kalmanq_studies.lectures.example import caption


@dataclass(frozen=True)
class Options:
    name: Optional[choices("Example", EXAMPLES)] = typer.Argument(None, metavar="EXAMPLE", help="Which example; without it, a list.")
    arithmetic: choices("AnyArithmetic", [*ARITHMETICS, "all"]) = typer.Option("all", "--arith", help="The arithmetic to compute with.")
    seed: int = typer.Option(1, "--seed", min=0, help="Seed of the simulated measurements.")
    out: Optional[Path] = typer.Option(None, "--out", metavar="FIGURE.png", help="Write the example's figure to this file.")
    json: bool = JSON


def show(options: Options, console: Console) -> None:
    if options.name is None:
        tell_choices("example", {name: one.shows for name, one in EXAMPLES.items()}, "what it shows",
                     "kalmanq examples NAME --out FIGURE.png", options.out, options.json, console)
        return
    if options.out:
        require_folder(options.out.parent)
    example = EXAMPLES[options.name]
    wanted = ("f64", "f32", "q31") if options.arithmetic == "all" else (options.arithmetic,)
    with console.status(f"{options.name} in {', '.join(wanted)}"):
        results = {name: example.compute(name, options.seed) for name in wanted}
        said = caption(example, results)
        if options.out:
            pictures.save_small(example.figure(results, said), options.out)
    _tell(options, {name: example.numbers(of) for name, of in results.items()}, said, console)


def _tell(options: Options, numbers: Mapping[str, Mapping[str, Any]], said: str, console: Console) -> None:
    if options.json:
        return print_json({"example": options.name, "seed": options.seed, **numbers})
    made = table("", *numbers, title=f"{options.name}: {EXAMPLES[str(options.name)].shows}")
    for name in next(iter(numbers.values())):
        made.add_row(name, *(_text(of[name]) for of in numbers.values()))
    console.print(made)
    console.print(said)
    console.print(f"wrote {options.out}" if options.out else "--out FIGURE.png draws it")


def _text(value: Any) -> str:
    return "\n".join("  ".join(f"{one:.9g}" for one in row) for row in np.atleast_2d(value))


command = command_of(Options, show)
