"""kalmanq gallery: textbook models with data, fitted, smoothed and drawn."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Callable, Optional

import numpy as np
import typer
from rich.console import Console

from kalmanq.commands.messages import print_json, table, tell_written
from kalmanq.commands.options import JSON, choices, command_of
from kalmanq.data.written import write_text, writing
from kalmanq.data.files import require_folder, whole
from kalmanq.firmware.ranges import with_ranges
from kalmanq.firmware.reach import Record
from kalmanq.model import model_file
from kalmanq.pages import pictures
from kalmanq.run.filters import Smoother
from kalmanq.run.results import Run
from kalmanq_studies.commands.listing import tell_choices
from kalmanq_studies.gallery import ENTRIES, Entry
from kalmanq_studies.gallery.fitted import Fitted, fit, varying_of
from kalmanq_studies.gallery.picture import Ahead, draw, forecast
from kalmanq_studies.gallery.sources import Data


@dataclass(frozen=True)
class Options:
    name: Optional[choices("Entry", ENTRIES)] = typer.Argument(None, metavar="MODEL", help="Which model; without it, a list.")
    out: Optional[Path] = typer.Option(None, "--out", metavar="FOLDER", help="Write the files to this folder, which must exist.")
    json: bool = JSON


def show(options: Options, console: Console) -> None:
    if options.name is None:
        tell_choices("model", {name: one.shows for name, one in ENTRIES.items()}, "what it is, and its data",
                     "kalmanq gallery NAME --out FOLDER", options.out, options.json, console)
        return
    entry, name = ENTRIES[options.name], options.name
    if options.out:
        require_folder(options.out)
    with console.status(f"{name}: fitting"):
        fitted = fit(entry, name)
        written = _write(entry, name, fitted, options.out) if options.out else []
    _tell(options, entry, fitted, written, console)


# ------------------------------------------------------------------------------ files


def _write(entry: Entry, name: str, fitted: Fitted, folder: Path) -> list[Path]:
    data = entry.data()
    run, ahead = _smoothed(entry, fitted, data)
    title = f"{entry.shows}\nlog-likelihood {fitted.log_likelihood:.2f}"
    makers: dict[str, Callable[[Path], None]] = {
        f"{name}.csv": lambda path: _write_data(path, data),
        f"{name}_smoothed.csv": lambda path: _write_run(path, run, data),
        f"{name}.png": lambda path: pictures.save_small(draw(entry, data, run, ahead, title), path)}
    if data.regressors is None:  # a model file has one H for all rows
        start, end = (_text(entry, name, parameters, data) for parameters in (entry.start, fitted.parameters))
        makers = {f"{name}.toml": lambda path: _write_text(path, start),
                  f"{name}_fitted.toml": lambda path: _write_text(path, end), **makers}
    for file, make in makers.items():
        make(folder / file)
    return [folder / file for file in makers]


def _smoothed(entry: Entry, fitted: Fitted, data: Data) -> tuple[Run, Optional[Ahead]]:
    smoother = Smoother(fitted.model)
    run = smoother.run(data.z, varying=varying_of(data), covariance=True)
    has_ahead = entry.ahead and data.regressors is None  # what those will be is not known
    return run, forecast(smoother.last, entry.ahead, data) if has_ahead else None


def _text(entry: Entry, name: str, parameters: dict, data: Data) -> str:
    """With ranges, so that it runs in fixed point, too.  Before an unknown start is known, every state may be as large
    as what is measured."""
    model, _ = with_ranges(entry.model(parameters, name), [Record(data.z)], life=0)
    if entry.is_unknown:
        most = max(one.range or 0.0 for one in (*model.states, *model.measurements))
        model = model.changed(states=[replace(one, range=most) for one in model.states])
    return f"# {entry.shows}.\n" + model_file.text_of_builder(entry.builder, parameters, model)


def _write_text(path: Path, text: str) -> None:
    with whole(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def _write_data(path: Path, data: Data) -> None:
    names = [data.axis, *data.names, *data.regressor_names]
    columns = [data.at, *data.z.T, *([] if data.regressors is None else data.regressors.T)]
    with whole(path) as temporary, open(temporary, "w", encoding="utf-8", newline="") as text:
        text.write(f"# {data.said}\n")
        write_text(text, names, columns)


def _write_run(path: Path, run: Run, data: Data) -> None:
    columns = {data.axis: data.at, **run.columns()}
    with writing(path, list(columns)) as write:
        write(columns.values())


# ------------------------------------------------------------------------------ what is told


def _tell(options: Options, entry: Entry, fitted: Fitted, written: list[Path], console: Console) -> None:
    if options.json:
        return print_json({"model": options.name, "builder": entry.builder, "parameters": fitted.parameters,
                           "free": entry.free, "log_likelihood": fitted.log_likelihood, "converged": fitted.converged,
                           "files": written})
    made = table("parameter", "where fitting began", "fitted", title=f"{options.name}: {entry.shows}")
    for name in entry.free:
        made.add_row(name, *(_numbers(of[name]) for of in (entry.start, fitted.parameters)))
    console.print(made)
    console.print(f"log-likelihood {fitted.log_likelihood:.6f}, {'converged' if fitted.converged else 'NOT converged'}")
    tell_written(written, console)
    if entry.data().regressors is not None:
        console.print("H is another one at each row, so there is no model file: kalmanq.Varying says it from Python")
    if not written:
        console.print("--out FOLDER writes model, data, smoothed states and a picture")


def _numbers(value: object) -> str:
    return "  ".join(f"{one:.6g}" for one in np.ravel(value))


command = command_of(Options, show)
