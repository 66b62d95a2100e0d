"""kalmanq run: a CSV file through a filter, in blocks of rows where no smoother needs them all."""

from __future__ import annotations

import tempfile
import warnings
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Iterator, Optional

import numpy as np
import typer
from rich.console import Console

from kalmanq.commands.messages import print_json, table, tell_written
from kalmanq.commands.options import (
    ANY_MODEL, ARITHMETIC, DATA, JSON, AnyModel, Arithmetic, choices, command_of, read_any)
from kalmanq.core import names_of
from kalmanq.data import tables
from kalmanq.data.files import refuse_one_output
from kalmanq.errors import KalmanqError, KalmanqWarning
from kalmanq.model import Model
from kalmanq.nonlinear import NonlinearFilter, NonlinearModel, NonlinearSmoother
from kalmanq.nonlinear.filters import ITERATIONS
from kalmanq.nonlinear.jacobians import points_along, wrong_entries
from kalmanq.nonlinear.methods import BY_POINTS, METHODS
from kalmanq.run.filters import LOSSES, Filter, LagSmoother, Robust
from kalmanq.run.parts import WAYS
from kalmanq.run.results import Run
from kalmanq.run.streamed import StreamedSmoother

BLOCK = 65536  # rows in memory at once
PLOTTED = 200_000  # more rows than that are no picture
LOOKED_AT = 10  # rows at which a nonlinear model's own Jacobians are compared with its functions


@dataclass(frozen=True)
class Options:
    model: Path = ANY_MODEL
    data: Path = DATA
    arithmetic: Arithmetic = ARITHMETIC
    smooth: bool = typer.Option(False, "--smooth", help="Each row given all rows, too.")
    lag: Optional[int] = typer.Option(None, "--lag", metavar="L", min=0, help="The state L rows ago, too.")
    forecast: int = typer.Option(0, "--forecast", metavar="K", min=0, max=10_000, help="Rows ahead of the last one.")
    robust: Optional[choices("Loss", LOSSES)] = typer.Option(None, "--robust", help="For outliers (gate, huber, student) or jumps.")
    way: Optional[choices("Way", WAYS)] = typer.Option(None, "--as", help="Of f32 and q31: to the bit the C file that design writes in that way.")
    method: Optional[choices("NonlinearMethod", METHODS)] = typer.Option(None, "--method", help="Of a nonlinear model; extended if left out.")
    iterate: Optional[int] = typer.Option(None, "--iterate", metavar="N", min=1, max=1000, help="Of iterated and posterior: linearise each update so often; 4 if left out.")
    passes: Optional[int] = typer.Option(None, "--passes", metavar="N", min=1, max=1000, help="Of a nonlinear model's --smooth: the most passes that linearise at smoothed states.")
    out: Optional[Path] = typer.Option(None, "--out", metavar="OUT.csv", help="A row for each row of data.")
    plot: Optional[Path] = typer.Option(None, "--plot", metavar="OUT.png", help="Data, means and bands.")
    json: bool = JSON


@dataclass
class Summary:
    """What is told of all rows."""

    rows: int = 0
    taken: int = 0
    missing: int = 0
    nis: float = 0.0
    events: int = 0
    log_likelihood: float = 0.0
    filter: Any = None
    kept: list[Run] = field(default_factory=list)  # for the picture


def run_file(options: Options, console: Console) -> None:
    model = read_any(options.model)
    _refuse(options, model)
    summary = Summary()
    shown: list[np.ndarray] = []
    with ExitStack() as stack:
        write = None
        is_streamed = options.smooth and isinstance(model, Model)
        for first, z, run in (_smoothed_runs if is_streamed else _runs)(options, model, summary, stack):
            if options.plot:
                summary.kept.append(run)
                shown.append(z)
            if options.out:
                columns = {"step": np.arange(first, first + len(run)), **run.columns()}
                write = write or stack.enter_context(
                    tables.writing(options.out, list(columns), [options.data, options.model]))
                write(columns.values())
        filter_ = _finish(summary)
        ahead = _ahead(filter_, options.forecast)
        if options.plot:
            _plot(options, model, summary, np.vstack(shown), ahead)
    _tell(options, model, filter_, summary, ahead, console)


def _refuse(options: Options, model: AnyModel) -> None:
    if isinstance(model, NonlinearModel):
        for name, is_given in (("--lag", options.lag is not None), ("--forecast", options.forecast > 0),
                               ("--robust", options.robust is not None), ("--as", options.way is not None)):
            if is_given:
                raise KalmanqError(f"{name}: of a linear model (TOML), not of a nonlinear one")
        if options.iterate is not None and options.method not in ("iterated", "posterior"):
            raise KalmanqError("--iterate: of --method iterated and posterior; --passes are a smoother's")
        if options.passes is not None and not options.smooth:
            raise KalmanqError("--passes: of --smooth")
    else:
        for name, given in (("--method", options.method), ("--iterate", options.iterate), ("--passes", options.passes)):
            if given is not None:
                raise KalmanqError(f"{name}: of a nonlinear model (a Python file), not of a linear one")
        _refuse_way(options)
    if options.smooth and options.lag is not None:
        raise KalmanqError("--smooth and --lag: one of them")
    if options.smooth and options.robust:
        raise KalmanqError("--smooth and --robust: a smoother undoes plain updates alone")
    if options.robust == "jump" and options.lag is not None:
        raise KalmanqError(f"--lag and --robust {options.robust}: a lag cannot follow it")
    refuse_one_output(options.out, options.plot)
    for path in (options.out, options.plot):
        if path and not path.parent.is_dir():
            raise KalmanqError(f"{path}: there is no such folder")


def _refuse_way(options: Options) -> None:
    """A design is a filter in numbers of a chip: what it has not, cannot be run as it."""
    for name, is_given in (("--arith f64", options.arithmetic == "f64"), ("--smooth", options.smooth),
                           ("--lag", options.lag is not None)):
        if options.way and is_given:
            raise KalmanqError(f"--as {options.way} and {name}: a design is a filter in f32 or q31")


def _refuse_picture(rows: int) -> None:
    if rows > PLOTTED:
        raise KalmanqError(f"--plot: more than {PLOTTED} rows are no picture")


def _warn_of_jacobians(options: Options, model: NonlinearModel, run: Run, u: Optional[np.ndarray]) -> None:
    """Wrong ones make wrong numbers without a word: the first rows are looked at."""
    controls = np.zeros((len(run), 0)) if u is None else u
    for entry in wrong_entries(model, points_along(run.mean[:LOOKED_AT], controls)):
        warnings.warn(f"{options.model}: {entry}; `kalmanq check` looks at more", KalmanqWarning, stacklevel=2)


def _filter(options: Options, model: AnyModel) -> Any:
    if isinstance(model, NonlinearModel):
        method, count = options.method or "extended", options.iterate or ITERATIONS
        if options.smooth:
            return NonlinearSmoother(model, options.arithmetic, method, count, options.passes or 1)
        return NonlinearFilter(model, options.arithmetic, method, count)
    if options.lag is not None:
        return LagSmoother(model, options.lag, options.arithmetic)
    return Filter(model, options.arithmetic, way=options.way or "")


def _runs(options: Options, model: AnyModel, summary: Summary, _: ExitStack) -> Iterator[tuple[int, np.ndarray, Run]]:
    """The first row's number, measurements, and what was made of them, in blocks"""
    summary.filter = _filter(options, model)
    robust = Robust(options.robust) if options.robust else None
    for first, row, z, u in _blocks(options, model):
        run = _run(options, summary.filter, z, u, robust, row)
        if first == 0 and isinstance(model, NonlinearModel) and options.method not in BY_POINTS:
            _warn_of_jacobians(options, model, run, u)
        _count(options, summary, run, z)
        yield first, z, run


def _smoothed_runs(options: Options, model: Model, summary: Summary,
                   stack: ExitStack) -> Iterator[tuple[int, np.ndarray, Run]]:
    """The same of a smoother, which goes through all rows and back"""
    beside = options.out is not None and (options.out.is_file() or not options.out.exists())
    folder = options.out.resolve().parent if beside and options.out else Path(tempfile.gettempdir())
    smoother = stack.enter_context(StreamedSmoother(model, options.arithmetic, folder, BLOCK))
    begin = 0  # the first row's line
    for first, row, z, u in _blocks(options, model):
        begin = begin or row
        smoother.add(z, u)
    for first, z, u in smoother.rows():
        run = _run(options, smoother, z, u, None, begin + first)
        _count(options, summary, run, z)
    summary.filter = smoother.filter
    for first, z, run in smoother.smoothed():
        summary.events |= run.events
        yield first, z, run


def _blocks(options: Options, model: AnyModel) -> Iterator[tuple[int, int, np.ndarray, Optional[np.ndarray]]]:
    """First step, its row in the file, measurements and controls; a nonlinear smoother takes all rows at once."""
    blocks = tables.read(options.data, [*model.measurements, *model.controls], BLOCK, has_to_fit=options.arithmetic == "q31")
    if options.smooth and isinstance(model, NonlinearModel):
        blocks = iter([tables.joined(list(blocks))])
    first = 0
    for block in blocks:
        z, u = tables.split(block, model, options.data)
        yield first, block.first_row, z, u
        first += len(z)


def _run(options: Options, filter_: Any, z: np.ndarray, u: Optional[np.ndarray], robust: Optional[Robust],
         row: int) -> Run:
    try:
        if isinstance(filter_, StreamedSmoother):
            return filter_.take(z, u)
        if isinstance(filter_, (NonlinearFilter, NonlinearSmoother)):
            return filter_.run(z, u)
        return filter_.run(z, u, robust=robust)
    except KalmanqError as problem:
        if problem.row is None:
            raise
        text = str(problem).split(": ", 1)[1]
        raise KalmanqError(f"{options.data}: row {row + problem.row}: {text}", problem.status) from problem


def _count(options: Options, summary: Summary, run: Run, z: np.ndarray) -> None:
    summary.rows += len(run)
    summary.taken += int(run.taken.clip(0).sum())
    summary.missing += int(np.isnan(z).sum())
    summary.nis += float(np.nansum(run.nis))
    summary.log_likelihood += float(np.sum(run.log_likelihood))
    summary.events |= run.events
    if options.plot:
        _refuse_picture(summary.rows)


def _finish(summary: Summary) -> Any:
    if summary.rows == 0:
        raise KalmanqError("no rows")
    return summary.filter


def _ahead(filter_: Any, steps: int) -> list[Filter]:
    source = filter_.last if isinstance(filter_, NonlinearSmoother) else filter_
    return [source.forecast(k) for k in range(1, steps + 1)] if steps else []


def _plot(options: Options, model: AnyModel, summary: Summary, z: np.ndarray, ahead: list[Filter]) -> None:
    from kalmanq.pages import pictures

    whole = summary.kept[0]
    for name in ("mean", "sigma", "smoothed", "smoothed_sigma", "lagged", "lagged_sigma", "innovation",
                 "innovation_sigma"):
        parts = [getattr(run, name) for run in summary.kept]
        setattr(whole, name, None if parts[0] is None else np.vstack(parts))
    band = (np.array([f.mean for f in ahead]), np.array([f.sigma for f in ahead])) if ahead else None
    pictures.save(pictures.draw_run(whole, z, band), options.plot, [options.data, options.model])


def _tell(options: Options, model: AnyModel, filter_: Any, summary: Summary, ahead: list[Filter], console: Console) -> None:
    source = filter_.last if isinstance(filter_, NonlinearSmoother) else filter_
    told = {
        "model": model.name, "arithmetic": options.arithmetic, "way": options.way, "rows": summary.rows, "taken": summary.taken,
        "missing": summary.missing, "log_likelihood": summary.log_likelihood,
        "nis_per_measurement": summary.nis / summary.taken if summary.taken else None,
        "events": names_of(summary.events), "states": [state.name for state in model.states],
        "mean": source.mean, "covariance": source.covariance,
        "forecast": [{"mean": f.mean, "covariance": f.covariance} for f in ahead]}
    if isinstance(model, NonlinearModel):
        told.update(_told_of_nonlinear(filter_))
    if options.json:
        return print_json(told)
    arithmetic = ", ".join(filter(None, (options.arithmetic, told.get("method"), options.way)))
    made = table("state", "mean", "sigma", *(["in %d rows" % len(ahead), "sigma "] if ahead else []),
                 title=f"{model.name}: after {summary.rows} rows, {arithmetic}")
    for i, state in enumerate(model.states):
        cells = [f"{source.mean[i]:.6g}", f"{source.sigma[i]:.3g}"]
        cells += [f"{ahead[-1].mean[i]:.6g}", f"{ahead[-1].sigma[i]:.3g}"] if ahead else []
        made.add_row(state.label, *cells)
    console.print(made)
    ratio = f", NIS {summary.nis / summary.taken:.3f} a measurement (1 if the model is right)" if summary.taken else ""
    console.print(f"log-likelihood {summary.log_likelihood:.6f}; {summary.taken} measurements taken, "
                  f"{summary.missing} missing{ratio}")
    if told.get("passes", 1) > 1:
        console.print(f"{told['passes']} passes of the smoother, "
                      + ("settled" if told["is_settled"] else "not settled: take no more from them than from the first"
                         if told["halvings"] else "not settled"))
    if summary.events:
        console.print("events: " + ", ".join(names_of(summary.events)))
    tell_written((options.out, options.plot), console)


def _told_of_nonlinear(filter_: Any) -> dict[str, Any]:
    if isinstance(filter_, NonlinearFilter) or filter_.passes == 1:
        return {"method": filter_.method}
    return {"method": filter_.method, "passes": filter_.passes_done, "is_settled": filter_.is_settled,
            "objectives": filter_.objectives, "halvings": filter_.halvings}


command = command_of(Options, run_file)
