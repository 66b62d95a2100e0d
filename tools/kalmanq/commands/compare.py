"""kalmanq compare: every arithmetic compared with double; of a nonlinear model the methods beside each other, too."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import List, Optional

import numpy as np
import typer
from rich.console import Console
from rich.table import Table

from kalmanq.commands.messages import print_json, table, tell_written
from kalmanq.commands.options import ANY_MODEL, COMPILED, DATAS, JSON, as_compiled, command_of, read_any, refuse_compiled
from kalmanq.compiler.run.equation_run import COMPILED as BESIDE
from kalmanq.compiler.run.simulation import compiled_run
from kalmanq.data import joining, tables
from kalmanq.errors import KalmanqError
from kalmanq.model import Model
from kalmanq.nonlinear import NonlinearModel
from kalmanq.nonlinear.comparison import arithmetics, compare_methods
from kalmanq.run.comparison import compare

SHOWN = 4  # states in the table; the JSON has all


@dataclass(frozen=True)
class Options:
    model: Path = ANY_MODEL
    data: List[Path] = DATAS
    plot: Optional[Path] = typer.Option(None, "--plot", metavar="OUT.png", help="Draw the errors over the rows.")
    compiled: bool = COMPILED
    json: bool = JSON


def compare_file(options: Options, console: Console) -> None:
    model = as_compiled(options.compiled, read_any(options.model, options.data), options.data)
    refuse_compiled(options.compiled, model)
    if isinstance(model, Model):
        z, u, times = joining.record(options.data, model)
        errors, figures = compare(model, z, u, {"compiled": partial(compiled_run, times=times)} if options.compiled else {}, times)
        _draw(options, errors)
        if options.json:
            return print_json(figures)
        console.print(_table(figures, model.name, len(z)))
        _tell_refused(figures, console)
    elif model.has_errors:
        raise KalmanqError("of error states f32 is compared with double by kalmanq compile: it is in NAME_report.txt")
    else:
        if model.is_late:
            raise KalmanqError("compare cannot use delays (run, report, check and fit can): move late measurements to the rows in which they were made, "
                               "and leave `delays` out")
        joining.refuse_several(options.data, model)
        true_states = [f"{name}_true" for name in model.state_names]  # where there is one for each state
        z, u, truth, times = tables.record_and(options.data[0], model, true_states)
        errors, figures = arithmetics(model, z, u, BESIDE if options.compiled else {}, times)
        found = compare_methods(model, z, u, truth, times)
        _draw(options, errors)
        if options.json:
            return print_json({"arithmetics": figures, "methods": found})
        console.print(_table(figures, model.name, len(z)))
        _tell_refused(figures, console)
        _tell_methods(model, found, len(z), truth is not None, console)
    tell_written([options.plot], console)


def _draw(options: Options, errors: dict[str, np.ndarray]) -> None:
    if options.plot:
        from kalmanq.pages import pictures

        pictures.save(pictures.draw_errors(errors), options.plot, [*options.data, options.model])


def _table(figures: dict[str, dict], name: str, rows: int) -> Table:
    made = table("arithmetic", "mean, in sigma", "at row, state", "sigma, relative", "log-likelihood", "events",
                 title=f"{name}: worst errors of {rows} rows compared with double")
    for name, of in figures.items():
        if "refused" in of:
            made.add_row(name, "refused")
        else:
            made.add_row(name, f"{of['mean_error_in_sigma']:.2g}", f"{of['worst_row']}, {of['worst_state']}",
                         f"{of['sigma_relative_error']:.2g}", f"{of['log_likelihood_error']:.2g}",
                         ", ".join(of["events"]))
    return made


def _tell_methods(model: NonlinearModel, found: dict[str, dict], rows: int, is_known: bool, console: Console) -> None:
    console.print(_methods_table(model, found, rows, is_known))
    for told in sorted({one for of in found.values() for one in of.get("warnings", [])}):
        console.print(f"(!) {told}")
    if not is_known:
        console.print("more passes of the smoother are compared where the data have the true states (kalmanq simulate --truth)")
    _tell_refused(found, console)


def _tell_refused(found: dict[str, dict], console: Console) -> None:
    for name, of in found.items():
        if "refused" in of:
            console.print(f"{name}: {of['refused']}")


def _methods_table(model: NonlinearModel, found: dict[str, dict], rows: int, is_known: bool) -> Table:
    shown = model.state_names[:SHOWN] if is_known else []
    known = ["NEES", "smoothed", *(f"RMS {name}" for name in shown)] if is_known else []
    said = "NIS a measurement" + (", NEES a state; RMS of smoothed states" if is_known else "")
    made = table("method", "NIS", "log-likelihood", *known,
                 title=f"{model.name}: methods in double, {rows} rows; {said}")
    for method, of in found.items():
        if "refused" in of:
            made.add_row(method, "refused")
            continue
        if not is_known and "nis_per_measurement" not in of:
            continue  # more passes, of which nothing is known
        cells = [_cell(of.get("nis_per_measurement"), ".3f"), _cell(of.get("log_likelihood"), ".2f")]
        if is_known:
            cells += [_cell(of.get("filtered_nees_per_state"), ".4g"), _cell(of["smoothed_nees_per_state"], ".4g")]
            cells += [f"{of['smoothed_rms'][name]:.4g}" for name in shown]
        made.add_row(method + (" (!)" if of["warnings"] else ""), *cells)
    return made


def _cell(value: Optional[float], form: str) -> str:
    return "" if value is None else format(value, form)


command = command_of(Options, compare_file)
