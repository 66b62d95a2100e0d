"""kalmanq simulate: measurements drawn from a model; with --runs, how far off a filter is over many runs."""

from __future__ import annotations

import hashlib
import sys
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, Optional, Sequence, Tuple

import numpy as np
import typer
from rich.console import Console

from kalmanq.commands.messages import print_json, table, tell_written
from kalmanq.commands.options import ANY_MODEL, COMPILED, FRESH, JSON, WORKERS, AnyModel, Arithmetic, command_of, read_any, refuse_compiled
from kalmanq.compiler.run.equation_run import compiled_equations_run
from kalmanq.compiler.run.simulation import NO_SMOOTHER, compiled_run
from kalmanq.data import tables, written
from kalmanq.data.blocks import joined
from kalmanq.data.files import refuse_output, whole
from kalmanq.data.layouts import unit_of
from kalmanq.data.time_columns import PER_SECOND, unit_in
from kalmanq.errors import KalmanqError
from kalmanq.model import ColumnModel, Model, Quantity, Sensor
from kalmanq.model.column_model import refuse_rows
from kalmanq.nonlinear import NonlinearModel
from kalmanq.nonlinear.filters import extended_run
from kalmanq.nonlinear.simulation import errors_of_run, rows_of_run, simulate
from kalmanq.run.campaigns import journal_of, progress_bar, run_campaign
from kalmanq.run.comparison import filtered
from kalmanq.run.monte_carlo import Study, one_run, rows_of_run as linear_rows, summary
from kalmanq.run.simulation import drawn

ROWS = 200  # if nothing says how many


@dataclass(frozen=True)
class Options:
    model: Path = ANY_MODEL
    rows: Optional[int] = typer.Option(None, "-n", "--rows", metavar="N", min=1, max=100_000_000, help="Number of rows; by default 200, or as many as CONTROLS.csv or TIMES.csv has.")
    seed: int = typer.Option(1, "--seed", min=0, help="The same seed gives the same rows everywhere.")
    out: Optional[Path] = typer.Option(None, "-o", "--out", metavar="OUT.csv", help="Write to this file; by default to the terminal.")
    truth: bool = typer.Option(False, "--truth", help="Also write the true states, as columns NAME_true.")
    gap: Optional[Tuple[int, int]] = typer.Option(None, "--gap", metavar="FIRST END", help="No measurements in the rows from FIRST to before END.")
    controls: Optional[Path] = typer.Option(None, "--controls", metavar="CONTROLS.csv", help="A CSV file of controls, by name; 0 by default.")
    at: Optional[Path] = typer.Option(None, "--at", metavar="TIMES.csv", help="A CSV file of times, one for each row; by default a row every dt.")
    runs: Optional[int] = typer.Option(None, "--runs", metavar="N", min=1, max=10_000_000, help="Simulate and filter N times; the output is a row of errors for each run.")
    arithmetic: Optional[Arithmetic] = typer.Option(None, "--arith", help="With --runs: the filter's arithmetic; f64 by default.")
    smooth: bool = typer.Option(False, "--smooth", help="With --runs: smooth each run, too.")
    compiled: bool = COMPILED
    workers: Optional[int] = WORKERS
    fresh: bool = FRESH
    json: bool = JSON


def simulate_file(options: Options, console: Console) -> None:
    if options.runs is not None:
        return simulate_runs(options, console)
    given = [f"--{name}" for name in ("arith", "smooth", "compiled", "workers", "fresh", "json")
             if getattr(options, {"arith": "arithmetic"}.get(name, name))]
    if given:
        raise KalmanqError(f"{', '.join(given)}: {'go' if len(given) > 1 else 'goes'} with --runs")
    model = read_any(options.model, options.at or options.controls)
    rows, controls, times = controls_of(options, model)
    _refuse_gap(options.gap, rows)
    if isinstance(model, ColumnModel) and any(one.delay for one in model.sensors):
        raise KalmanqError("simulate: a sensor is late, and its columns are of the row that tells it: leave `delay` out of the model")
    if isinstance(model, Model):
        x, z = drawn(model, rows, options.seed, options.gap, controls, times)
        u = np.zeros((rows, len(model.inputs))) if controls is None else controls
    else:
        x, z, u = simulate(model, rows, options.seed, controls, times)
        if options.gap:
            z[options.gap[0] : options.gap[1]] = np.nan
    z, stamps, times = _told(model, z, times, options.seed)
    columns = {"step": np.arange(rows), **_times(model, times), **stamps}
    columns.update(_written(model.measurements, z))
    columns.update(_written(model.inputs, u))
    if options.truth:
        states = model.carried if isinstance(model, NonlinearModel) else model.states
        taken = [one.name for one in states if f"{one.name}_true" in columns]
        if taken:
            raise KalmanqError(f"--truth: there is a column {taken[0]}_true already: leave --truth out, or call the column in the model something else")
        columns.update({f"{one.name}_true": x[:, i] for i, one in enumerate(states)})
    _write(options, columns, written.Form.of(model.recording))


def _write(options: Options, columns: dict[str, np.ndarray], form: written.Form) -> None:
    if options.out is None:
        return written.write_text(sys.stdout, list(columns), columns.values(), form)
    with whole(options.out, [one for one in (options.model, options.controls, options.at) if one]) as temporary:
        with open(temporary, "w", newline="", encoding="utf-8") as text:
            written.write_text(text, list(columns), columns.values(), form)


def _times(model: AnyModel, times: Optional[np.ndarray]) -> dict[str, np.ndarray]:
    """Under the name, and in the unit, that the model file says; times of several columns or of a format are `time`"""
    said = model.recording.get("time", "none")
    if times is None or said == "none" or "," in said or "time_format" in model.recording:
        return {} if times is None else {tables.time_name(model): times}
    seconds = times * (model.continuous.seconds if isinstance(model, Model) else 1.0)
    return {said: seconds * PER_SECOND[unit_in(said, unit_of(said)) or "s"]}


def _written(of: Sequence[Quantity], values: np.ndarray) -> dict[str, np.ndarray]:
    """Columns as `run` reads them with the same model file"""
    return {one.reading.column or one.name: (values[:, c] - one.reading.offset) / one.reading.factor if one.reading.converts else values[:, c]
            for c, one in enumerate(of)}


def _told(model: AnyModel, z: np.ndarray, times: Optional[np.ndarray], seed: int
          ) -> tuple[np.ndarray, dict[str, np.ndarray], Optional[np.ndarray]]:
    """z, the measurements of each sensor in the row that tells them; columns of when they were measured; and the times of rows, which these need"""
    sensors: Sequence[Sensor] = model.sensors if isinstance(model, Model) else model.late_sensors
    step = (model.continuous.dt if model.continuous else 1.0) if isinstance(model, Model) else model.dt if model.reads_times else 1.0
    is_even = times is None
    if is_even and any(sensor.measured for sensor in sensors):
        times = (step or np.nan) * np.arange(len(z))
    z, stamps, first, draw = z.copy(), {}, 0, np.random.default_rng([seed, 1])
    for sensor in sensors:
        own = slice(first, first := first + len(sensor.measurements))
        if sensor.measured:
            row = _ages(times, sensor.delay, draw)
            z[:, own], stamps[sensor.measured] = np.where(row[:, None] < 0, np.nan, z[row, own]), np.where(row < 0, np.nan, times[row])
            continue
        late = sensor.delay / (step or np.inf)
        rows = round(late)
        of_dt = f" = {step:g}" if step else ""
        if sensor.delay and (step is None or not is_even or abs(late - rows) > 1e-6):
            raise KalmanqError(f"the delay of {sensor.name}, {sensor.delay:g}, is in rows here: a multiple of dt{of_dt}, and without --at")
        if rows:
            z[rows:, own], z[:rows, own] = z[:-rows, own].copy(), np.nan
    return z, stamps, times


def _ages(times: np.ndarray, longest: float, draw: np.random.Generator) -> np.ndarray:
    """Of each row, the row whose measurement it tells: drawn of those up to `longest` ago; -1: that was told before"""
    rows = np.arange(len(times))
    least = np.searchsorted(times, times - longest * (1 - 1e-9))
    row = draw.integers(least, rows + 1)
    _, is_first = np.unique(row, return_index=True)
    return np.where(np.isin(rows, is_first), row, -1)


def controls_of(options: Options, model: AnyModel) -> tuple[int, Optional[np.ndarray], Optional[np.ndarray]]:
    """Rows to draw, their controls and their times, if there are files of them"""
    path, at, u, dt = options.controls, options.at, None, tables.dt_of(model)
    if path is not None and not model.inputs:
        raise KalmanqError(f"--controls {path}: the model has no controls" + ("; --at has times" if dt else ""))
    if at is not None and dt is None:
        raise KalmanqError(f"--at {at}: of a linear model with F, Qc and dt, or a nonlinear one whose functions take t or dt")
    unit = model.continuous.seconds if isinstance(model, Model) and dt else 1.0
    times = None if at is None else joined(list(tables.read(at, tables.wanted_of(model, quantities=[], controls=[])))).times
    if at is not None and times is None:
        raise KalmanqError(f"--at {at}: there is no column of times; --time says which it is")
    if path is not None:
        block = joined(list(tables.read(path, tables.wanted_of(model, quantities=model.inputs))))
        of_rows = isinstance(model, ColumnModel)
        u = tables.inputs_in(block, model, np.zeros((block.length, model.m)), path) if of_rows else tables.controls_in(block, model.inputs, path)
        times = block.times if times is None else times
    counts = [len(one) for one in (u, times) if one is not None]
    rows = options.rows or min(counts, default=ROWS)
    for name, one in ((f"--controls {path}", u), (f"--at {at}", None if at is None else times)):
        if one is not None and len(one) < rows:
            raise KalmanqError(f"{name}: has {len(one)} rows, fewer than the {rows} of -n")
    return rows, *(None if one is None else one[:rows] for one in (u, None if times is None else times / unit))


def _refuse_gap(gap: Optional[tuple[int, int]], rows: int) -> None:
    if gap and not 0 <= gap[0] < gap[1] <= rows:
        raise KalmanqError(f"--gap {gap[0]} {gap[1]}: from a row to one after it, within {rows} rows")


# ------------------------------------------------------------------------------ many runs


def simulate_runs(options: Options, console: Console) -> None:
    out = _out(options)
    model = read_any(options.model, options.at or options.controls)
    if isinstance(model, NonlinearModel):
        if options.smooth:
            raise KalmanqError("--smooth: of a linear model (TOML) with --runs")
        refuse_compiled(options.compiled, model, options.arithmetic or "f64")
    rows, u, times = controls_of(options, model)
    _refuse_gap(options.gap, rows)
    options = replace(options, rows=rows, arithmetic=options.arithmetic or "f64")
    if options.compiled and isinstance(model, Model):
        refuse_rows(model, "--compiled", "leave --compiled out; kalmanq compile tries its C in records of its own")
    study = _study(options, model, rows, u, times)
    with progress_bar(f"{model.name}, {_way(options)}") as progress:
        made = list(run_campaign(
            partial(one_run, study), range(options.runs), fingerprint=_fingerprint(options, u, times), journal=journal_of(out),
            workers=options.workers, progress=progress, fresh=options.fresh))
    columns = {name: np.array([row[name] for row in made], object) for name in made[0]}
    with written.writing(out, list(columns), [options.model]) as write:
        write(columns.values())
    journal_of(out).unlink(missing_ok=True)
    _tell(options, model, summary(columns), console)


def _study(options: Options, model: AnyModel, rows: int, u: Optional[np.ndarray], times: Optional[np.ndarray]) -> Study:
    if isinstance(model, NonlinearModel):
        is_compiled = options.compiled or model.has_errors
        return Study(model, rows, options.seed, options.arithmetic, False, options.gap, u,
                     partial(compiled_equations_run if is_compiled else extended_run, times=times), partial(rows_of_run, times=times),
                     errors_of_run)
    return Study(model, rows, options.seed, options.arithmetic, options.smooth and not options.compiled, options.gap, u,
                 partial(compiled_run if options.compiled else filtered, times=times), partial(linear_rows, times=times),
                 times=times)


def _way(options: Options) -> str:
    return f"{options.arithmetic}, compiled" if options.compiled else options.arithmetic


def _out(options: Options) -> Path:
    """Where to write; what would be refused after all runs is refused before them."""
    if options.out is None:
        raise KalmanqError("--runs: needs --out, a row a run")
    if options.truth:
        raise KalmanqError("--truth: of one run alone, without --runs")
    refuse_output(options.out, [options.model])
    return options.out


def _fingerprint(options: Options, u: Optional[np.ndarray], times: Optional[np.ndarray]) -> dict[str, Any]:
    """All that run k comes from; how many runs there are is no part of it."""
    driven = {name: hashlib.sha256(one.tobytes()).hexdigest() for name, one in (("controls", u), ("times", times))
              if one is not None}
    driven.update({"compiled": True} if options.compiled else {})
    return {**driven, "study": "simulate", "model": hashlib.sha256(options.model.read_bytes()).hexdigest(),
            **{name: getattr(options, name) for name in ("rows", "seed", "arithmetic", "smooth", "gap")}}


def _tell(options: Options, model: Model, said: dict[str, Any], console: Console) -> None:
    if options.json:
        way = {"way": "compiled"} if options.compiled else {}
        return print_json({"model": model.name, "arithmetic": options.arithmetic, **way, "rows": options.rows,
                           "runs": options.runs, "seed": options.seed, **said})
    made = table("column", "mean", "standard error",
                 title=f"{model.name}: {options.runs} runs of {options.rows} rows, {_way(options)}")
    for name, of in said["columns"].items():
        made.add_row(name, *("" if of[key] is None else f"{of[key]:.6g}" for key in ("mean", "standard_error")))
    console.print(made)
    for name, what in (("nees", "NEES a dimension"), ("nis", "NIS a measurement")):
        of = said[name]
        if of["bounds"] is None:
            console.print(f"{what}: too few runs to judge")
        else:
            console.print(f"{what} {of['mean']:.4f}: {'within' if of['within'] else 'OUTSIDE'} its bounds of 95 %, "
                          f"{of['bounds'][0]:.4f} to {of['bounds'][1]:.4f}")
    if said["runs_with_events"]:
        console.print(f"events in {said['runs_with_events']} runs")
    if options.compiled and options.smooth:
        console.print(f"left out: --smooth; {NO_SMOOTHER}")
    tell_written([options.out], console)


command = command_of(Options, simulate_file)
