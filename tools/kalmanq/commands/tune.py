"""kalmanq tune: a page on which the filter runs over a recording while its noises are moved."""

from __future__ import annotations

import webbrowser
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, List, Tuple

import numpy as np
import typer
from rich.console import Console

from kalmanq.commands.messages import tell_written
from kalmanq.commands.options import ANY_MODEL, AnyModel, command_of, read_any
from kalmanq.data import joining
from kalmanq.data.files import refuse_output, whole
from kalmanq.data.layouts import options_of
from kalmanq.model import Model
from kalmanq.model.column_model import refuse_rows
from kalmanq.nonlinear import NonlinearModel
from kalmanq.nonlinear.simulation import simulate
from kalmanq.run.simulation import drawn
from kalmanq.tune import page

ROWS = 200  # that are drawn where no data are given


@dataclass(frozen=True)
class Options:
    model: Path = ANY_MODEL
    data: List[Path] = typer.Argument(None, metavar="DATA", help="A CSV file with a header, a log, or several, joined by their times; simulated from the model by default.")
    out: Path = typer.Option(Path("tune.html"), "-o", "--out", metavar="TUNE.html", help="The page: one HTML file that needs no server and no network.")
    open: bool = typer.Option(False, "--open", help="Open the page in the browser.")


def tune_file(options: Options, console: Console) -> None:
    data = options.data or None
    refuse_output(options.out, [options.model, *(data or [])])
    model = read_any(options.model, data)
    if isinstance(model, Model):
        refuse_rows(model, "tune", "a page has one model for all rows; kalmanq fit finds the numbers, and kalmanq report shows what they do")
    page.require(model)
    sources: Dict[str, Any] = {"model": options.model.name, "data": " ".join(one.name for one in data) if data else ""}
    if data:
        sources.update(files=[one.name for one in data], options=options_of(data[0].layout))
    if data:
        z, u, times = joining.record(data, model)
    else:
        z, u = _drawn(model)
        times = None
    text = page.page(model, z, u, times, sources)
    with whole(options.out, [options.model, *(data or [])]) as path:
        path.write_text(text, encoding="utf-8")
    tell_written([options.out], console)
    if options.open and not webbrowser.open(options.out.resolve().as_uri()):
        console.print(f"there is no browser here: open {options.out} by hand")


def _drawn(model: AnyModel) -> Tuple[np.ndarray, np.ndarray]:
    if isinstance(model, NonlinearModel):
        return simulate(model, ROWS, 1)[1:]
    return drawn(model, ROWS, 1, None)[1], np.zeros((ROWS, len(model.inputs)))


command = command_of(Options, tune_file)
