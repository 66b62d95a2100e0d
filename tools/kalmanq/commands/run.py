"""kalmanq run: a CSV file through a filter, in blocks of rows where no smoother needs them all."""

from __future__ import annotations

import tempfile
import warnings
from contextlib import ExitStack
from copy import copy
from dataclasses import dataclass, replace
from functools import partial
from itertools import groupby
from pathlib import Path
from typing import Any, Callable, Iterable, Iterator, List, NamedTuple, Optional, Sequence

import numpy as np
import typer
from rich.console import Console

from kalmanq.commands.messages import print_json, table, tell_written
from kalmanq.commands.options import (
    ANY_MODEL,
    ARITHMETIC,
    COMPILED,
    DATAS,
    JSON,
    AnyModel,
    Arithmetic,
    as_compiled,
    choices,
    command_of,
    forms_of,
    read_any,
    refuse_compiled,
    require_steps,
    robust_of,
)
from kalmanq.compiler.run.equation_run import CompiledEquations, FixedEquations
from kalmanq.compiler.run.simulation import CompiledFilter
from kalmanq.core import names_of
from kalmanq.data import joining, tables, track, written
from kalmanq.data.blocks import Block, joined
from kalmanq.data.files import refuse_one_output, refuse_output
from kalmanq.data.ground import Begun
from kalmanq.data.rows import Rows
from kalmanq.errors import KalmanqError, KalmanqWarning
from kalmanq.model import Model
from kalmanq.model.column_model import refuse_rows
from kalmanq.nonlinear import NonlinearFilter, NonlinearModel, NonlinearSmoother
from kalmanq.nonlinear.filters import ITERATIONS
from kalmanq.nonlinear.jacobians import points_along, wrong_entries
from kalmanq.nonlinear.methods import BY_POINTS, METHODS
from kalmanq.run.filters import Filter, LagSmoother
from kalmanq.run.parts import WAYS
from kalmanq.run.results import Run
from kalmanq.run.reweighting import ReweightedSmoother
from kalmanq.run.robust import LOSSES
from kalmanq.run.streamed import StreamedSmoother

BLOCK = 65536  # rows in memory at once
PLOTTED = 200_000  # more rows than that are no picture
LEAST_JUDGED, FAR_NIS = 60, 2.0  # with so many measurements a right model's NIS is farther from 1 less often than once in 1000
LOOKED_AT = 10  # rows at which a nonlinear model's own Jacobians are compared with its functions


@dataclass(frozen=True)
class Options:
    model: Path = ANY_MODEL
    data: List[Path] = DATAS
    arithmetic: Arithmetic = ARITHMETIC
    smooth: bool = typer.Option(False, "--smooth", help="Smooth: also give each state given all rows.")
    lag: Optional[int] = typer.Option(None, "--lag", metavar="L", min=0, help="At each row, also give the state of L rows ago.")
    forecast: int = typer.Option(0, "--forecast", metavar="K", min=0, max=10_000, help="Forecast K rows of dt after the last one; the last control stays.")
    robust: Optional[str] = typer.Option(None, "--robust", metavar=forms_of(LOSSES), help="Against outliers: gate rejects rows as unlikely as a "
                                         "measurement K sigma off (3.89), huber counts no more than K sigma (3), student weighs with NU degrees of freedom (10). "
                                         "For jumps of the state: jump raises P where e^2 is above G S (9); with --smooth it finds the steps that need more noise.")
    way: Optional[choices("Way", WAYS)] = typer.Option(None, "--as", help="f32, q31: compute bit for bit as the C file of `design --way`.")
    compiled: bool = COMPILED
    method: Optional[choices("NonlinearMethod", METHODS)] = typer.Option(None, "--method", help="Nonlinear model: how to linearise; extended by default.")
    iterate: Optional[int] = typer.Option(None, "--iterate", metavar="N", min=1, max=1000, help="Methods iterated and posterior: linearise each update N times; 4 by default.")
    passes: Optional[int] = typer.Option(None, "--passes", metavar="N", min=1, max=1000, help="Nonlinear model with --smooth: at most N passes, each linearised at the smoothed states before it.")
    out: Optional[Path] = typer.Option(None, "-o", "--out", metavar="OUT.csv", help="Write the results: a row for each row of data; OUT.gpx: the track.")
    digits: int = typer.Option(9, "--digits", min=1, max=written.ALL_DIGITS, help="Significant digits of the results in OUT.csv; 17 bring back the same bits.")
    plot: Optional[Path] = typer.Option(None, "--plot", metavar="OUT.png", help="Draw data, means and bands of 95 %.")
    json: bool = JSON


def run_file(options: Options, console: Console) -> None:
    model = as_compiled(options.compiled, read_any(options.model, options.data), options.data, options.arithmetic)
    if isinstance(model, NonlinearModel) and model.has_errors:
        options = replace(options, compiled=True)  # error states are run by their C
        if options.plot:
            raise KalmanqError("--plot: of error states there is no picture; --out has all columns")
    _refuse(options, model)
    if options.out and options.out.suffix.lower() == track.SUFFIX:
        track.axes_of(model)
    _FileRun(options, model).perform(console)


def _refuse(options: Options, model: AnyModel) -> None:
    refuse_compiled(options.compiled, model, options.arithmetic, ", ".join(
        name for name, is_given in (("--smooth", options.smooth), ("--method iterated", options.method == "iterated")) if is_given))
    if isinstance(model, NonlinearModel):
        for name, is_given in (("--lag", options.lag is not None), ("--forecast", options.forecast > 0),
                               ("--as", options.way is not None)):
            if is_given:
                cure = ": rows with times and controls, and no measurements, are a forecast" if name == "--forecast" else ""
                raise KalmanqError(f"{name}: of a linear model (TOML), not of a nonlinear one{cure}")
        if options.iterate is not None and options.method not in ("iterated", "posterior"):
            raise KalmanqError("--iterate: of --method iterated and posterior; --passes are a smoother's")
        if options.compiled and options.method not in (None, "extended", "iterated"):
            raise KalmanqError(f"--compiled and --method {options.method}: the C is extended or iterated: take one of these, or leave --compiled out")
        if options.passes is not None and not options.smooth:
            raise KalmanqError("--passes: is of --smooth: give both, or none")
        if options.passes not in (None, 1) and options.robust is not None:
            raise KalmanqError("--passes and --robust: further passes are of Gaussian noise: leave one of them out")
    else:
        for name, given in (("--method", options.method), ("--iterate", options.iterate), ("--passes", options.passes)):
            if given is not None:
                raise KalmanqError(f"{name}: of a nonlinear model (a Python file), not of a linear one")
        _refuse_way(options)
        if options.way:
            refuse_rows(model, f"--as {options.way}", "kalmanq compile writes its C, and --compiled runs that")
        if options.smooth and options.robust and options.robust.startswith("jump"):
            refuse_rows(model, "--smooth --robust jump", "take gate, huber or student")
    if options.compiled:
        for name, is_given in (("--smooth", options.smooth and isinstance(model, Model)), ("--lag", options.lag is not None),
                               ("--robust", options.robust is not None), ("--as", options.way is not None)):
            if is_given:
                raise KalmanqError(f"--compiled and {name}: one of them")
        if options.passes is not None:
            raise KalmanqError("--compiled and --passes: the C smooths once")
    if options.smooth and options.lag is not None:
        raise KalmanqError("--smooth and --lag: one of them")
    _refuse_jump(options, model)
    refuse_one_output(options.out, options.plot)
    for path in (options.out, options.plot):
        if path:
            refuse_output(path)


def _refuse_jump(options: Options, model: AnyModel) -> None:
    """No smoother undoes that P is raised; one of linear models finds jumps of its own."""
    robust = robust_of(options.robust)
    if not robust or robust.way != "jump":
        return
    if options.lag is not None:
        raise KalmanqError(f"--lag and --robust {options.robust}: a lag cannot follow it: leave --lag out")
    if options.smooth and isinstance(model, NonlinearModel):
        raise KalmanqError(f"--smooth and --robust {options.robust}: jumps are smoothed of linear models alone: take gate, huber or student")
    if options.smooth and robust.parameter is not None:
        raise KalmanqError(f"--smooth and --robust {options.robust}: a smoother finds jumps without a limit: give --robust jump")


def _refuse_way(options: Options) -> None:
    """A design is a filter in numbers of a chip: what it has not, cannot be run as it."""
    for name, is_given in (("--arith f64", options.arithmetic == "f64"), ("--smooth", options.smooth),
                           ("--lag", options.lag is not None)):
        if options.way and is_given:
            raise KalmanqError(f"--as {options.way} and {name}: a design is a filter in f32 or q31: leave one of them out")


class Piece(NamedTuple):
    """Rows of a record: its number, and the first row's"""

    record: int
    first: int
    block: Block
    z: np.ndarray
    u: Optional[np.ndarray]


class _FileRun:
    """A file on its way through a filter, and what is told of all its rows"""

    def __init__(self, options: Options, model: AnyModel):
        self.options, self.model = options, model
        self.is_nonlinear, self.robust = isinstance(model, NonlinearModel), robust_of(options.robust)
        self.is_whole = options.smooth and (self.is_nonlinear or bool(self.robust) and self.robust.way == "jump")  # all rows at once
        self.filter: Any = None
        self.rows = self.records = self.taken = self.missing = self.rejected = self.events = 0
        self.nis = self.log_likelihood = 0.0
        self.times: Optional[np.ndarray] = None  # of the block at work
        self.last_time: Optional[float] = None
        self.begun = Begun()  # where and when the data did
        self.last_control: Optional[np.ndarray] = None  # 1 x l
        self.kept: list[tuple[int, np.ndarray, Run, Optional[np.ndarray]]] = []  # for the picture: record, measurements, what was made of them, times

    def perform(self, console: Console) -> None:
        options, write = self.options, None
        with ExitStack() as stack:
            stack.enter_context(console.status("running", spinner="line"))
            for first, z, run in self._all(stack):
                if options.plot:
                    self.kept.append((self.records, z, run, self.times))
                if options.out and self.is_track:
                    write = write or stack.enter_context(track.writing(options.out, self.model, [*options.data, options.model]))
                    write(run.mean if run.smoothed is None else run.smoothed, self._seconds(), self.begun)
                elif options.out:
                    timed = {} if self.times is None else {tables.time_name(self.model): self.times}
                    columns = {"step": np.arange(first, first + len(run)), **timed, **run.columns()}
                    digits = [written.ALL_DIGITS if name in timed else options.digits for name in columns]
                    write = write or stack.enter_context(
                        written.writing(options.out, list(columns), [*options.data, options.model], digits))
                    write(columns.values())
            if not self.rows:
                raise KalmanqError("no rows")
            ahead = [self._ahead(k) for k in range(1, options.forecast + 1)]
            if options.plot:
                self._plot(ahead)
        self._tell(ahead, console)

    @property
    def is_track(self) -> bool:
        return self.options.out is not None and self.options.out.suffix.lower() == track.SUFFIX

    def _seconds(self) -> Optional[np.ndarray]:
        of = None if self.is_nonlinear else self.model.continuous
        return self.times if self.times is None or of is None else of.seconds * self.times

    @property
    def last(self) -> Any:
        """The filter at the last row"""
        return self.filter.last if self.is_whole and not self.options.compiled else self.filter

    def _ahead(self, steps: int) -> Any:
        """The last control stays as it is."""
        return self.last.forecast(steps, None if self.last_control is None else np.repeat(self.last_control, steps, axis=0))

    def _all(self, stack: ExitStack) -> Iterator[tuple[int, np.ndarray, Run]]:
        """Of each record: the first row's number, measurements, and what was made of them, in blocks"""
        for _, pieces in groupby(self._pieces(), key=lambda one: one.record):
            self.records, self.last_time = self.records + 1, None
            yield from self._smoothed(stack, pieces) if self.options.smooth and not self.is_whole else self._filtered(stack, pieces)

    def _filtered(self, stack: ExitStack, pieces: Iterable[Piece]) -> Iterator[tuple[int, np.ndarray, Run]]:
        options = self.options
        given = {} if options.compiled or self.robust is None or self.is_whole and not self.is_nonlinear else {"robust": self.robust}
        for k, (_, first, block, z, u) in enumerate(pieces):
            self._look_at_times(block.times)
            if k == 0:
                self.filter = _filter(options, self.model, len(z))
                if options.compiled:
                    stack.enter_context(self.filter)
            timed = {} if block.times is None or options.way and not self.is_nonlinear else {"times": block.times}
            run = self._run(partial(self.filter.run, **given, **timed), z, u, block.place)
            if first == 0 and self.is_nonlinear and options.method not in BY_POINTS:
                self._warn_of_jacobians(run, u, block.times)
            yield first, z, run

    def _smoothed(self, stack: ExitStack, pieces: Iterable[Piece]) -> Iterator[tuple[int, np.ndarray, Run]]:
        """The same of a smoother, which goes through all rows and back"""
        options, out = self.options, self.options.out
        folder = out.resolve().parent if out and (out.is_file() or not out.exists()) else Path(tempfile.gettempdir())
        smoother = stack.enter_context(StreamedSmoother(self.model, options.arithmetic, folder, BLOCK, self.robust))
        read: list[tuple[int, Block]] = []  # blocks without their numbers, which know how rows are named
        for _, first, block, z, u in pieces:
            self._look_at_times(block.times)
            read.append((first, replace(block, columns={}, times=None)))
            smoother.add(Rows(z, u, block.times))
        number = read[0][0]
        for first, rows in smoother.rows():
            self._run(lambda *_: smoother.take(rows), rows.z, rows.u, replace(read[0][1], times=rows.times).place if read[0][1].is_joined else
                      lambda row: next(block.place(number + first + row - begun) for begun, block in reversed(read) if begun <= number + first + row))
        self.filter = smoother.filter
        for first, rows, run in smoother.smoothed():
            self.events |= run.events
            self.times = rows.times
            yield number + first, rows.z, run

    def _pieces(self) -> Iterator[Piece]:
        """Some smoothers take all rows of a record at once."""
        options, model, first = self.options, self.model, 0
        blocks = joining.blocks_of(options.data, model, BLOCK, has_to_fit=options.arithmetic == "q31")
        if self.is_whole:
            blocks = iter([joined(list(blocks))])
        for record, block in joining.cut(blocks, options.data, model):
            z, u = tables.split(block, model, options.data)
            self.begun = block.begun or Begun()
            self.last_control = None if u is None else u[-1:]
            yield Piece(record, first, block, z, u)
            first += len(z)

    def _look_at_times(self, times: Optional[np.ndarray]) -> None:
        if times is None:
            return
        if self.options.way and not self.is_nonlinear:
            require_steps(self.model, np.append([] if self.last_time is None else self.last_time, times), "--as")
        self.times, self.last_time = times, float(times[-1])

    def _run(self, run: Callable[..., Run], z: np.ndarray, u: Optional[np.ndarray], place: Callable[[int], str]) -> Run:
        """The run of a block, counted; an error names the row of the file."""
        try:
            made = run(z, u)
        except KalmanqError as problem:
            if problem.row is None:
                raise
            files = ", ".join(map(str, self.options.data))
            raise KalmanqError(f"{files}: {place(problem.row)}: {problem.text}", problem.status) from problem
        self.rows += len(made)
        taken, missing = int(made.taken.clip(0).sum()), int(np.isnan(z).sum())
        self.taken += taken
        self.missing += missing
        self.rejected += z.size - taken - missing
        self.nis += float(np.nansum(made.nis[made.taken > 0]))  # a rejected measurement has one, too
        self.log_likelihood += float(np.sum(made.log_likelihood))
        self.events |= made.events
        if self.options.plot and self.rows > PLOTTED:
            raise KalmanqError(f"--plot: more than {PLOTTED} rows are no picture: leave --plot out, or give fewer rows")
        return made

    def _warn_of_jacobians(self, run: Run, u: Optional[np.ndarray], times: Optional[np.ndarray]) -> None:
        """Wrong ones make wrong numbers without a word: the first rows are looked at."""
        controls = np.zeros((len(run), 0)) if u is None else u
        at = self.model.instants(len(run), times)[:None if times is None else -1]  # after the last one no step is known
        for entry in wrong_entries(self.model, points_along(run.mean[:LOOKED_AT], controls, at)):
            warnings.warn(f"{self.options.model}: {entry}; `kalmanq check` looks at more", KalmanqWarning, stacklevel=2)

    def _plot(self, ahead: list[Filter]) -> None:
        from kalmanq.pages import pictures

        records, z, runs, times = zip(*self.kept)
        whole = copy(runs[0])
        for name in ("mean", "sigma", "smoothed", "smoothed_sigma", "lagged", "lagged_sigma", "innovation",
                     "innovation_sigma", "fed"):
            parts = [getattr(run, name) for run in runs]
            setattr(whole, name, None if parts[0] is None else _drawn_apart(parts, records))
        band = (np.array([f.mean for f in ahead]), np.array([f.sigma for f in ahead])) if ahead else None
        picture = pictures.draw_run(whole, _drawn_apart(z, records), band, None if times[0] is None else _drawn_apart(times, records))
        pictures.save(picture, self.options.plot, [*self.options.data, self.options.model])

    def _distance(self, rows: int) -> str:
        of = self.model.continuous
        return f"in {rows} rows" if of is None else f"in {rows * of.dt:.6g} {of.unit}"

    def _event_names(self) -> list[str]:
        return self.filter.event_names if self.options.compiled else names_of(self.events)

    def _told(self, ahead: list[Filter]) -> dict[str, Any]:
        told = {
            "model": self.model.name, "arithmetic": self.options.arithmetic, "way": self.options.way, "rows": self.rows,
            "records": self.records, "taken": self.taken, "missing": self.missing, "rejected": self.rejected, "log_likelihood": self.log_likelihood,
            "nis_per_measurement": self.nis / self.taken if self.taken else None, "events": self._event_names(),
            "states": [state.name for state in self.model.states], "mean": self.last.mean,
            "covariance": self.last.covariance,
            "forecast": [{"mean": f.mean, "covariance": f.covariance} for f in ahead]}
        if self.options.compiled:
            told.update(way="compiled", digest=f"{self.filter.digest:08x}")
        if self.is_nonlinear:
            told.update({"nominal": self.model.carried_names} if self.model.has_errors else {}, method=self.filter.method)
        if isinstance(self.filter, NonlinearSmoother) and self.filter.passes > 1:
            told.update(passes=self.filter.passes_done, is_settled=self.filter.is_settled,
                        objectives=self.filter.objectives, halvings=self.filter.halvings)
        return told

    def _tell(self, ahead: list[Filter], console: Console) -> None:
        options, last, told = self.options, self.last, self._told(ahead)
        if options.json:
            return print_json(told)
        arithmetic = ", ".join(filter(None, (options.arithmetic, told.get("method"), told["way"])))
        made = table("state", "mean", "sigma", *([self._distance(len(ahead)), "sigma "] if ahead else []),
                     title=f"{self.model.name}: after {self.rows} rows{f' in {self.records} records' if self.records > 1 else ''}, {arithmetic}")
        has_errors = self.is_nonlinear and self.model.has_errors
        for i, one in enumerate(self.model.carried if has_errors else ()):
            made.add_row(one.label, f"{last.mean[i]:.6g}", "")
        for i, state in enumerate(self.model.states):
            if has_errors:
                made.add_row(state.label, "", f"{last.sigma[i]:.3g}")
                continue
            made.add_row(state.label, *(cell for f in (last, *ahead[-1:])
                                        for cell in (f"{f.mean[i]:.6g}", f"{f.sigma[i]:.3g}")))
        console.print(made)
        ratio = f", NIS {self.nis / self.taken:.3f} a measurement (1 if the model is right)" if self.taken else ""
        console.print(f"log-likelihood {self.log_likelihood:.6f}; {self.taken} measurements taken, "
                      f"{self.missing} missing{f', {self.rejected} rejected' if self.rejected else ''}{ratio}")
        if options.robust is None and self.taken >= LEAST_JUDGED and not 1 / FAR_NIS < self.nis / self.taken < FAR_NIS:
            console.print(f"{options.arithmetic} is too coarse for these measurements, which says nothing of the model" if getattr(self.last, "coarse", "") else
                          "the data do not fit the model; kalmanq report shows where, kalmanq fit finds Q and R")
        if told.get("passes", 1) > 1:
            said = "settled" if told["is_settled"] else \
                "not settled: take no more from them than from the first" if told["halvings"] else "not settled"
            console.print(f"{told['passes']} passes of the smoother, {said}")
        if told["events"]:
            console.print("events: " + ", ".join(told["events"]))
        tell_written((options.out, options.plot), console)


def _drawn_apart(parts: Sequence[np.ndarray], records: Sequence[int]) -> np.ndarray:
    """A row without numbers between two records: no line joins them"""
    made = [parts[0]]
    for part, now, before in zip(parts[1:], records[1:], records):
        made += [np.full((1, *part.shape[1:]), np.nan)] * (now != before) + [part]
    return np.concatenate(made)


def _filter(options: Options, model: AnyModel, rows: int) -> Any:
    """rows: of the first block, which is all that a nonlinear smoother has"""
    if isinstance(model, NonlinearModel):
        method, count = options.method or "extended", options.iterate or ITERATIONS
        if options.compiled:
            if options.arithmetic == "q31":
                return FixedEquations(model)
            return CompiledEquations(model, options.arithmetic, count if method == "iterated" else 1, rows if options.smooth else 0)
        if options.smooth:
            return NonlinearSmoother(model, options.arithmetic, method, count, options.passes or 1)
        return NonlinearFilter(model, options.arithmetic, method, count)
    if options.compiled:
        return CompiledFilter(model, options.arithmetic)
    if options.smooth:  # states that jump
        return ReweightedSmoother(model, options.arithmetic)
    if options.lag is not None:
        return LagSmoother(model, options.lag, options.arithmetic)
    return Filter(model, options.arithmetic, way=options.way or "")


command = command_of(Options, run_file)
