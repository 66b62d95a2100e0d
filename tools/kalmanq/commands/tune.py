"""kalmanq tune: a page on which the filter runs over a recording while its noises are moved."""

from __future__ import annotations

import webbrowser
from dataclasses import dataclass
from pathlib import Path
from typing import List

import numpy as np
import typer
from rich.console import Console

from kalmanq.commands.messages import tell_written
from kalmanq.commands.options import MODEL, command_of, jittered
from kalmanq.data import joining
from kalmanq.data.files import refuse_output, whole
from kalmanq.model import model_file
from kalmanq.run.simulation import drawn
from kalmanq.tune import page

ROWS = 200  # that are drawn where no data are given


@dataclass(frozen=True)
class Options:
    model: Path = MODEL
    data: List[Path] = typer.Argument(None, metavar="DATA.csv", help="A CSV file with a header, or several, joined by their times; simulated from the model by default.")
    out: Path = typer.Option(Path("tune.html"), "-o", "--out", metavar="TUNE.html", help="The page: one HTML file that needs no server and no network.")
    open: bool = typer.Option(False, "--open", help="Open the page in the browser.")


def tune_file(options: Options, console: Console) -> None:
    data = options.data or None
    refuse_output(options.out, [options.model, *(data or [])])
    page.core()
    model = jittered(model_file.read(options.model), data)
    sources = {"model": options.model.name, "data": " ".join(one.name for one in data) if data else ""}
    if data:
        z, u, times = joining.record(data, model)
    else:
        (_, z), times = drawn(model, ROWS, 1, None), None
        u = np.zeros((ROWS, len(model.inputs)))
    text = page.page(model, z, u, times, sources)
    with whole(options.out, [options.model, *(data or [])]) as path:
        path.write_text(text, encoding="utf-8")
    tell_written([options.out], console)
    if options.open and not webbrowser.open(options.out.resolve().as_uri()):
        console.print(f"there is no browser here: open {options.out} by hand")


command = command_of(Options, tune_file)
