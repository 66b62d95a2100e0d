"""kalmanq fit: parameters by EM and maximum likelihood."""

from __future__ import annotations

import re
import time
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Callable, Iterator, List, Optional

import numpy as np
import typer
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

from kalmanq.commands.messages import NO_MAXIMUM, print_json, stop, tell_written
from kalmanq.commands.options import ANY_MODEL, JSON, AnyModel, choices, command_of, read_any
from kalmanq.data import joining
from kalmanq.data.files import refuse_one_output, whole
from kalmanq.data.layouts import Source
from kalmanq.data.tables import split
from kalmanq.errors import KalmanqError
from kalmanq.fitting import Fit, fit
from kalmanq.fitting.choice import require_units
from kalmanq.fitting.entries import free_and_held, label_of
from kalmanq.fitting.expectation import FORMS
from kalmanq.fitting.fit_model import METHODS
from kalmanq.fitting.of_columns import free_by_default, held_cells
from kalmanq.model.builders import searched
from kalmanq.model.fitted_file import fitted_text
from kalmanq.nonlinear import NonlinearModel, file as nonlinear_file


Form = choices("Form", FORMS)
EVERY = 5.0  # seconds, between lines of progress


@dataclass(frozen=True)
class Options:
    model: Path = ANY_MODEL
    data: List[Path] = typer.Argument(..., metavar="DATA", help="A CSV file or a log for each record; files that follow each other "
                                "without a column in common are one, joined by their times.")
    free: Optional[str] = typer.Option(None, "--free", help="What to estimate: A, H, Q, R, x0, P0, with commas, or entries such as "
                                       "A[0,0]; by default Q,R.  Model in continuous time: also F, Qc, or its builder's parameters, whose noises are the default.  "
                                       "Nonlinear model: constants of its file, Q, R, x0, P0; by default its `free`.")
    hold: str = typer.Option("", "--hold", help="Entries that keep their values, such as A[1,0] or Q[0,*].")
    method: choices("Method", METHODS) = typer.Option("both", "--method", help="EM, maximum likelihood (ml), or first EM, then ml (both).")
    Q_form: Form = typer.Option("full", "--q-form", help="Form of Q; multiple: a factor times the Q of the model file.")
    R_form: Form = typer.Option("full", "--r-form", help="Form of R, in the same way.")
    starts: int = typer.Option(1, "--starts", min=1, max=1000, help="Number of starts: the first from the model file, the others at random.")
    seed: int = typer.Option(0, "--seed", min=0, help="Seed of the random starts.")
    iterations: int = typer.Option(1000, "--iterations", min=1, help="The most evaluations of the likelihood for one start.")
    tolerance: float = typer.Option(1e-6, "--tolerance", min=1e-9, help="Stop when less than this is left to gain in log-likelihood.")
    out: Optional[Path] = typer.Option(None, "-o", "--out", metavar="FITTED", help="Write the fitted model to this file.")
    plot: Optional[Path] = typer.Option(None, "--plot", metavar="OUT.png", help="Draw the likelihood over the iterations.")
    json: bool = JSON


def fit_files(options: Options, console: Console) -> None:
    """The best point is written, whether or not it is a maximum."""
    _require_two_outputs(options)
    model = read_any(options.model, options.data)
    if options.out and options.out.suffix != options.model.suffix and isinstance(model, NonlinearModel):
        raise KalmanqError(f"{options.out}: is to be a {options.model.suffix} file, as the model is")
    free, held = free_and_held(_by_default(options, model) if options.free is None else options.free, options.hold, model)
    if not free:
        raise KalmanqError("--free: names nothing")
    require_units(model, free, held_cells(model, free, held))
    files = joining.records_of(options.data, model)
    records = [(*split(block, model, one), block.times) for one in files for block in joining.records_between(one, model)]
    if len(records) > 1 and not options.json:
        _tell_records(files, len(records), console)
    found = _fit(options, model, records, free, held)
    inputs = [options.model, *options.data]
    if options.out:
        with whole(options.out, inputs) as path:
            path.write_text(_text_of(found, options.model, free), encoding="utf-8")
    if options.plot:
        from kalmanq.pages import pictures

        pictures.save(pictures.draw_course(found, model.name), options.plot, inputs)
    _tell(options, files, found, free, console)
    if not found.converged:
        stop(f"{options.model}: {found.message}", NO_MAXIMUM)


def _by_default(options: Options, model: AnyModel) -> str:
    """What its file says; the noises of a builder in continuous time, as long as nothing is asked of matrices; Q and R"""
    if isinstance(model, NonlinearModel):
        return ",".join(model.free) or "Q,R"
    noises = [name for name in searched(model.builder) if name in ("sigma", "density", "noise") and np.any(np.array(model.builder.get(name, 0)))]
    is_asked = options.hold or options.method == "em" or (options.Q_form, options.R_form) != ("full", "full")
    return ",".join(noises) if noises and not is_asked else free_by_default(model)


def _text_of(found: Fit, source: Path, free: list[str]) -> str:
    """The model file's but for what was free"""
    if not isinstance(found.model, NonlinearModel):
        return fitted_text(source, found.model)
    return nonlinear_file.fitted_text(source, found.model, free)


def _require_two_outputs(options: Options) -> None:
    refuse_one_output(options.out, options.plot)
    if options.plot:
        from kalmanq.pages import pictures

        pictures.require_png(options.plot)


def _fit(options: Options, model: AnyModel, records: list[Any], free: list[str], held: dict[str, np.ndarray]) -> Fit:
    with _progress() as report:
        return fit(
            model, [z for z, _, _ in records], free, u=[u for _, u, _ in records], times=_times(records),
            method=options.method, held=held, Q_form=options.Q_form, R_form=options.R_form, starts=options.starts, seed=options.seed,
            iterations=options.iterations, tolerance=options.tolerance, report=report)


@contextmanager
def _progress() -> Iterator[Callable[[int, float], None]]:
    """On stderr: a bar on a terminal, otherwise a line every few seconds"""
    console, begun = Console(stderr=True, highlight=False, markup=False), time.monotonic()
    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn(), TextColumn("{task.fields[now]}"))
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as progress:
        task, last = progress.add_task("fit", total=None, now=""), begun

        def report(evaluations: int, value: float) -> None:
            nonlocal last
            now = f"{evaluations} evaluations, log-likelihood {value:.6f}"
            progress.update(task, now=now)
            if not console.is_terminal and time.monotonic() - last > EVERY:
                last = time.monotonic()
                console.print(f"kalmanq: fit: {now} after {last - begun:.0f} s")

        yield report


def _times(records: list[Any]) -> Optional[list[Any]]:
    made = [times for _, _, times in records]
    return None if all(one is None for one in made) else made


# ------------------------------------------------------------------------------ what came out


def _tell(options: Options, files: list[list[Source]], found: Fit, free: list[str], console: Console) -> None:
    if options.json:
        return print_json({"records": [list(map(str, one)) for one in files], **_for_machines(found, free)})
    begun = f"{found.course[0]:.6g} -> " if found.course else ""
    console.print(f"log-likelihood {begun}{found.log_likelihood:.6f} in {len(found.course)} evaluations "
                  f"({found.evaluations} in all)")
    if found.converged:
        console.print(found.message)
    table = Table("parameter", "estimate", "standard error", box=None, pad_edge=False)
    for row in _rows(found, free):
        table.add_row(*row)
    console.print(table)
    if any(np.any(np.isfinite(errors)) for errors in found.standard_errors.values()):
        console.print("standard errors: from the exact Hessian of the log-likelihood")
    for name in found.boundary:
        console.print(f"at the boundary, no standard error: {_named(name, found.model)}")
    tell_written((options.out, options.plot), console)


def _tell_records(files: list[list[Source]], count: int, console: Console) -> None:
    said = "; ".join(" + ".join(map(str, one)) for one in files)
    console.print(f"{count} records: {said}", soft_wrap=True)


def _rows(found: Fit, free: list[str]) -> Iterator[tuple[str, str, str]]:
    """Entries that were estimated: of a covariance those up to the diagonal that are not 0 and held."""
    for name in found.names(free):
        value = found.value(name)
        errors = found.standard_errors.get(name, np.full(value.shape, np.nan))
        for at in np.ndindex(value.shape):
            if name in ("Q", "Qc", "R", "P0") and (at[1] > at[0] or (value[at] == 0 and np.isnan(errors[at]))):
                continue
            yield _named(label_of(name, at), found.model), f"{value[at]:.6g}", _number(errors[at])


def _named(label: str, model: AnyModel) -> str:
    """R[1,0] with the sensors' names, Q[0,0] with the states'; noise[1] is a measurement's"""
    entry = re.fullmatch(r"(\w+)\[(\d+)(?:,(\d+))?\]", label) or re.fullmatch(r"(noise)()()", label)
    states, measured = ([one.name for one in of] for of in (model.states, model.measurements))
    sides = {"R": (measured, measured), "H": (measured, states), "noise": (measured,), "x0": (states,),
             **dict.fromkeys(("A", "F", "Q", "Qc", "P0"), (states, states))}
    if not entry or entry.group(1) not in sides or not entry.group(2) and len(measured) > 1:
        return label
    names = [side[int(at or 0)] for side, at in zip(sides[entry.group(1)], entry.groups()[1:])]
    return f"{label} {', '.join(dict.fromkeys(names))}"


def _number(value: float) -> str:
    return "" if np.isnan(value) else f"{value:.6g}"


def _for_machines(found: Fit, free: list[str]) -> dict[str, Any]:
    told = {name: getattr(found, name) for name in (
        "log_likelihood", "converged", "message", "distance", "evaluations", "course", "em_evaluations", "boundary",
        "undetermined")}
    return {**told, **{name: found.value(name) for name in found.names(free)}, "standard_errors": found.standard_errors}


command = command_of(Options, fit_files)
