"""kalmanq: filters for microcontrollers, designed and tried at a desk."""

from __future__ import annotations

import inspect
import os
import signal
import sys
import warnings
from contextlib import contextmanager
from enum import Enum
from functools import wraps
from pathlib import Path
from typing import Any, Callable, Iterator, List, Optional, Tuple, get_type_hints

import typer
from rich.console import Console

from kalmanq.errors import KalmanqError, KalmanqWarning

app = typer.Typer(
    help=__doc__, no_args_is_help=True, add_completion=False, pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]})

REFUSED, NO_MAXIMUM, INTERRUPTED, PIPE_CLOSED, TERMINATED = 1, 3, 130, 141, 143


class Arithmetic(str, Enum):
    f32 = "f32"
    f64 = "f64"
    q31 = "q31"


class Way(str, Enum):
    gate = "gate"
    huber = "huber"
    student = "student"
    jump = "jump"


class Core(str, Enum):
    m0 = "m0"
    m3 = "m3"
    m4f = "m4f"
    m7 = "m7"
    m33 = "m33"
    rv32 = "rv32"
    avr = "avr"


class Chip(str, Enum):
    f32 = "f32"
    q31 = "q31"


class Example(str, Enum):
    rocket = "rocket"
    densities = "densities"
    concentration = "concentration"
    prediction_error = "prediction-error"
    stationary = "stationary"
    smoothing = "smoothing"


class Entry(str, Enum):
    level = "level"
    trend = "trend"
    season = "season"
    trend_season = "trend-season"
    ar = "ar"
    ar_noise = "ar-noise"
    ma = "ma"
    arma = "arma"
    regression = "regression"
    regression_drifting = "regression-drifting"
    factor = "factor"
    constant_velocity = "constant-velocity"
    constant_acceleration = "constant-acceleration"


class AnyArithmetic(str, Enum):
    f32 = "f32"
    f64 = "f64"
    q31 = "q31"
    all = "all"


class WayToRun(str, Enum):
    lean = "lean"
    tables = "tables"
    init = "init"
    sizes = "sizes"


class Study(str, Enum):
    heavy_tails = "heavy-tails"


class Method(str, Enum):
    em = "em"
    ml = "ml"
    both = "both"


class Form(str, Enum):
    full = "full"
    diagonal = "diagonal"
    multiple = "multiple"


class CompiledForm(str, Enum):
    covariance = "covariance"
    gain = "gain"


class NonlinearMethod(str, Enum):
    extended = "extended"
    iterated = "iterated"
    cubature = "cubature"
    central = "central"
    posterior = "posterior"


MODEL = typer.Argument(..., metavar="MODEL", help="A model file (TOML).")
ANY_MODEL = typer.Argument(..., metavar="MODEL", help="A model file (TOML); or a nonlinear one (.py), which is executed.")
DATA = typer.Argument(..., metavar="DATA.csv", help="Measurements and controls, by name; empty: missing; - is the standard input.")
JSON = typer.Option(False, "--json", help="Print what came out for machines.")
ARITHMETIC = typer.Option(Arithmetic.f64, "--arith", help="The numbers that the chip will have.")


SEPARATOR = typer.Option(None, "--separator", metavar="LETTER", help="Between the fields of data, or tab; found if left out.")
DECIMAL = typer.Option(None, "--decimal", metavar=". or ,", help="Of the numbers of data; found if left out.")
MISSING = typer.Option([], "--missing", metavar="CELL", help="What stands for nothing, such as -9999; may be given again.")
RENAME = typer.Option([], "--rename", metavar="NAME=COLUMN", help="The model's name of a column of data; may be given again.")


def reads_data(command: Callable[..., None]) -> Callable[..., None]:
    """A command whose `data` may be written in any way: its options say how, and it is given a Source of each file."""
    kinds = get_type_hints(command)
    added = {"separator": (Optional[str], SEPARATOR), "decimal": (Optional[str], DECIMAL),
             "missing": (List[str], MISSING), "rename": (List[str], RENAME)}

    @wraps(command)
    def reading(**given: Any) -> None:
        from kalmanq.layouts import Source, layout_of

        with told_in_one_line():
            layout = layout_of(*(given.pop(name) for name in added))
        data = given[name_of_data]
        given[name_of_data] = [Source(one, layout) for one in data] if isinstance(data, (list, tuple)) else \
            None if data is None else Source(data, layout)
        command(**given)

    parameters = inspect.signature(command).parameters
    name_of_data = "data" if "data" in parameters else "controls"
    own = [one.replace(annotation=kinds[one.name]) for one in parameters.values()]
    own[-1:-1] = [inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=kind)
                  for name, (kind, default) in added.items()]
    made = inspect.Signature([one.replace(kind=inspect.Parameter.KEYWORD_ONLY) for one in own])
    reading.__signature__ = made  # type: ignore[attr-defined]
    reading.__annotations__ = {one.name: one.annotation for one in made.parameters.values()}
    return reading


@contextmanager
def told_in_one_line(model: Optional[Path] = None, *others: Optional[Path]) -> Iterator[None]:
    """Ends the program with one line where it cannot go on, and shows warnings as one line each.  What names no
    file is about the model."""
    warnings.simplefilter("ignore", RuntimeWarning)  # of numbers that are NaN, which is what they are to say
    warnings.simplefilter("always", KalmanqWarning)
    said: set[str] = set()
    warnings.showwarning = lambda message, *_: _say_once(str(message), said)  # type: ignore
    try:
        yield
    except KalmanqError as problem:
        named = str(problem).startswith("--") or any(str(path) in str(problem) for path in (model, *others) if path)
        _stop(str(problem) if named or model is None else f"{model}: {problem}")
    except BrokenPipeError as problem:
        if problem.filename is not None:
            _stop(f"{problem.filename}: {problem.strerror}")
        _leave_the_output()
        raise SystemExit(PIPE_CLOSED) from None
    except MemoryError:
        _stop("not enough memory for all rows at once")
    except OSError as problem:
        _stop(f"{problem.filename}: {problem.strerror}" if problem.filename else str(problem))
    except KeyboardInterrupt as interrupt:
        print(f"kalmanq: {interrupt if str(interrupt) else 'interrupted'}", file=sys.stderr)
        raise SystemExit(INTERRUPTED) from None


def _leave_the_output() -> None:
    """Nobody reads it any more, `head` for one: what is left of it goes nowhere, without a word."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _say_once(line: str, said: set[str]) -> None:
    """Blocks of rows repeat what is said of the whole run."""
    if line not in said:
        print(f"kalmanq: {_shown(line)}", file=sys.stderr)
    said.add(line)


_heard: list[int] = []


def _terminate(number: int, _: object) -> None:
    """As an interrupt, which leaves nothing behind"""
    _heard.append(number)
    signal.raise_signal(signal.SIGINT)


def _stop(line: str, code: int = REFUSED) -> None:
    print(f"kalmanq: {_shown(line)}", file=sys.stderr)
    raise SystemExit(code)


def _shown(line: str) -> str:
    return "".join(c if c.isprintable() else " " for c in line)


def console() -> Console:
    return Console(highlight=False, markup=False, width=None if sys.stdout.isatty() else 120)


@app.command()
@reads_data
def run(
    model: Path = ANY_MODEL,
    data: Path = DATA,
    arith: Arithmetic = ARITHMETIC,
    smooth: bool = typer.Option(False, "--smooth", help="Each row given all rows, too."),
    lag: Optional[int] = typer.Option(None, "--lag", metavar="L", min=0, help="The state L rows ago, too."),
    forecast: int = typer.Option(0, "--forecast", metavar="K", min=0, max=10_000, help="Rows ahead of the last one."),
    robust: Optional[Way] = typer.Option(None, "--robust", help="For outliers (gate, huber, student) or jumps."),
    as_: Optional[WayToRun] = typer.Option(None, "--as", help="Of f32 and q31: to the bit the C file that design writes in that way."),
    method: Optional[NonlinearMethod] = typer.Option(None, "--method", help="Of a nonlinear model; extended if left out."),
    iterate: Optional[int] = typer.Option(None, "--iterate", metavar="N", min=1, max=1000, help="Of iterated and posterior: linearise each update so often; 4 if left out."),
    passes: Optional[int] = typer.Option(None, "--passes", metavar="N", min=1, max=1000, help="Of a nonlinear model's --smooth: the most passes that linearise at smoothed states."),
    out: Optional[Path] = typer.Option(None, "--out", metavar="OUT.csv", help="A row for each row of data."),
    plot: Optional[Path] = typer.Option(None, "--plot", metavar="OUT.png", help="Data, means and bands."),
    json_: bool = JSON,
) -> None:
    """Filter a CSV file; with --smooth, --lag and --forecast what was, and what is to come."""
    from kalmanq.commands.run import Asked, run_file

    with told_in_one_line(model, data, out, plot):
        run_file(Asked(model, data, arith.value, smooth, lag, forecast, robust.value if robust else None, out,
                       plot, json_, method.value if method else None, iterate, passes, as_.value if as_ else None), console())


@app.command()
@reads_data
def check(
    model: Path = ANY_MODEL,
    data: Optional[Path] = typer.Argument(None, metavar="[DATA.csv]", help="Of a nonlinear model: what to look along."),
    json_: bool = JSON,
) -> None:
    """Is the model observable, stabilisable and well conditioned, and do the ranges fit?  Are Jacobians right?"""
    from kalmanq.commands import check as linear, check_nonlinear

    with told_in_one_line(model, data):
        if model.suffix == ".py":
            is_good = check_nonlinear.check_file(model, data, json_, console())
        elif data is not None:
            raise KalmanqError(f"{data}: a linear model is checked without data")
        else:
            is_good = linear.check_file(model, json_, console())
        if not is_good:
            raise SystemExit(REFUSED)


@app.command()
@reads_data
def design(
    model: Path = MODEL,
    core: Core = typer.Option(..., "--core", help="What it will run on."),
    data: Optional[Path] = typer.Option(None, "--data", metavar="DATA.csv", help="What it will be given; otherwise drawn."),
    arith: Optional[Chip] = typer.Option(None, "--arith", help="Only this one; otherwise what is best."),
    way: Optional[WayToRun] = typer.Option(None, "--way", help="Only this one."),
    flash: Optional[float] = typer.Option(None, "--flash", metavar="KB", min=0, help="Of the part."),
    ram: Optional[float] = typer.Option(None, "--ram", metavar="KB", min=0, help="Of the part."),
    name: str = typer.Option("", "--name", help="Of files and functions; otherwise the model's."),
    out: Optional[Path] = typer.Option(None, "--out", "-o", metavar="FOLDER", help="Where NAME.c and NAME.h go; it has to be there."),
    json_: bool = JSON,
) -> None:
    """Formats, accuracy and costs on a core; the way to run it; the filter as a C file."""
    from kalmanq.commands.design import Asked, design_file

    with told_in_one_line(model, data, out):
        design_file(Asked(model, core.value, data, arith.value if arith else None, way.value if way else None, flash,
                          ram, name, out, json_), console())


@app.command("compile")
def compile_(
    model: Path = MODEL,
    out: Path = typer.Option(..., "-o", "--out", metavar="NAME.c", help="NAME.h, NAME_test.c and NAME_proof.txt go beside it."),
    arith: Chip = typer.Option(Chip.f32, "--arith", help="The numbers that the chip will have."),
    form: CompiledForm = typer.Option(CompiledForm.covariance, "--form", help="gain: constant, where no sample is ever missing."),
    partial: bool = typer.Option(False, "--partial", help="Samples of which some components are missing, too."),
    nis: bool = typer.Option(False, "--nis", help="Keep NIS and the variances of innovations; f32: the likelihood."),
    lag: int = typer.Option(0, "--lag", metavar="L", min=0, max=64, help="The mean L samples ago, too, once settled."),
    bound: float = typer.Option(1e-4, "--bound", min=0, help="Of a covariance's error, in sigma_i sigma_j."),
    json_: bool = JSON,
) -> None:
    """C for exactly this filter, without a library, proven over every covariance that it can have."""
    from kalmanq.commands.compile import Asked, compile_file

    with told_in_one_line(model, out):
        compile_file(Asked(model, out, arith.value, form.value, partial, nis, lag, bound, json_), console())


@app.command()
def steady(model: Path = MODEL, json_: bool = JSON) -> None:
    """What the covariance settles to, the gain, and how fast the filter forgets."""
    from kalmanq.commands.steady import steady_file

    with told_in_one_line(model):
        steady_file(model, json_, console())


@app.command()
@reads_data
def simulate(
    model: Path = ANY_MODEL,
    rows: Optional[int] = typer.Option(None, "-n", "--rows", min=1, max=100_000_000, help="Rows to draw; 200 if left out, or as many as CONTROLS.csv has."),
    seed: int = typer.Option(1, "--seed", min=0, help="The same seed gives the same rows everywhere."),
    out: Optional[Path] = typer.Option(None, "--out", metavar="OUT.csv", help="Otherwise to the terminal."),
    truth: bool = typer.Option(False, "--truth", help="The states, too, as NAME_true."),
    gap: Optional[Tuple[int, int]] = typer.Option(
        None, "--gap", metavar="FIRST END", help="Rows without measurements."),
    controls: Optional[Path] = typer.Option(None, "--controls", metavar="CONTROLS.csv", help="Controls, by name; 0 if left out."),
    runs: Optional[int] = typer.Option(None, "--runs", min=1, max=10_000_000, help="Draw and filter so often: a row a run."),
    arith: Optional[Arithmetic] = typer.Option(None, "--arith", help="Of the runs' filter; f64 if left out."),
    smooth: bool = typer.Option(False, "--smooth", help="Smooth each run, too."),
    workers: Optional[int] = typer.Option(None, "--workers", min=1, help="Processes; all cores if left out."),
    dask: Optional[str] = typer.Option(None, "--dask", metavar="ADDRESS", help="A Dask scheduler: on its cluster."),
    fresh: bool = typer.Option(False, "--fresh", help="Forget what an interrupted command has done."),
    json_: bool = JSON,
) -> None:
    """Draw measurements of the model, as a CSV file that `run` takes; with --runs, errors over many runs."""
    with told_in_one_line(model, out, controls):
        from kalmanq.commands import simulate as one, simulate_runs as many

        if runs is None:
            given = {"--arith": arith, "--smooth": smooth, "--workers": workers, "--dask": dask, "--fresh": fresh,
                     "--json": json_}
            many.refuse_without_runs([name for name, value in given.items() if value])
            one.simulate_file(model, rows, seed, out, truth, gap, controls)
        else:
            many.simulate_runs(many.Asked(model, rows, seed, out, truth, gap, controls, runs, arith.value if arith else "f64",
                                          smooth, workers, dask, fresh, json_), console())


@app.command()
@reads_data
def compare(
    model: Path = ANY_MODEL,
    data: Path = DATA,
    plot: Optional[Path] = typer.Option(None, "--plot", metavar="OUT.png", help="Errors over the rows."),
    json_: bool = JSON,
) -> None:
    """Every arithmetic beside double: errors of means in sigma, and of sigmas.  Of a nonlinear model the methods, too."""
    from kalmanq.commands import compare as linear, compare_nonlinear

    with told_in_one_line(model, data, plot):
        command = compare_nonlinear if model.suffix == ".py" else linear
        command.compare_file(model, data, plot, json_, console())


@app.command()
@reads_data
def report(
    model: Path = MODEL,
    data: Path = DATA,
    out: Path = typer.Option(..., "-o", "--out", metavar="REPORT.html", help="One page that stands by itself."),
    arith: Arithmetic = ARITHMETIC,
) -> None:
    """Does the data fit the model?  A page with a verdict, pictures and figures."""
    with told_in_one_line(model, data, out):
        from kalmanq.commands.report import Asked, report_file

        report_file(Asked(model, data, arith.value, out), console())


@app.command()
@reads_data
def fit(
    model: Path = MODEL,
    data: List[Path] = typer.Argument(..., metavar="DATA.csv...", help="One record a file."),
    free: str = typer.Option("Q,R", "--free", help="Of A, H, Q, R, x0, P0, with commas; or entries, such as A[0,0]."),
    hold: str = typer.Option("", "--hold", help="Entries that stay, such as A[1,0] or Q[0,*]."),
    method: Method = typer.Option(Method.both, "--method", help="EM, maximum likelihood, or EM first and ML then."),
    q_form: Form = typer.Option(Form.full, "--q-form", help="Of Q; a multiple of what it is."),
    r_form: Form = typer.Option(Form.full, "--r-form", help="Of R."),
    starts: int = typer.Option(1, "--starts", min=1, max=1000, help="Begin so often, at random after the first."),
    seed: int = typer.Option(0, "--seed", min=0, help="Of the further starts."),
    iterations: int = typer.Option(1000, "--iterations", min=1, help="Evaluations that a start may take."),
    tolerance: float = typer.Option(1e-6, "--tolerance", min=1e-9, help="Log-likelihood that may be left."),
    out: Optional[Path] = typer.Option(None, "--out", metavar="FITTED.toml", help="The model, fitted."),
    plot: Optional[Path] = typer.Option(None, "--plot", metavar="OUT.png", help="The likelihood's course."),
    json_: bool = JSON,
) -> None:
    """Estimate parameters, with standard errors.  Exit code 3: no maximum; OUT then has the best that was found."""
    from kalmanq.commands.fit import Asked, fit_files

    with told_in_one_line(model, *data, out, plot):
        why = fit_files(Asked(model, data, free, hold, method.value, q_form.value, r_form.value, starts, seed,
                              iterations, tolerance, out, plot, json_), console())
        if why:
            _stop(f"{model}: {why}", NO_MAXIMUM)


@app.command()
def examples(
    name: Optional[Example] = typer.Argument(None, metavar="EXAMPLE", help="Otherwise the list of them."),
    arith: AnyArithmetic = typer.Option(AnyArithmetic.all, "--arith", help="The numbers to compute with."),
    seed: int = typer.Option(1, "--seed", min=0, help="Of the measurements that are drawn."),
    out: Optional[Path] = typer.Option(None, "--out", metavar="FIGURE.png", help="The example's figure."),
    json_: bool = JSON,
) -> None:
    """The theory's examples: rocket, densities, concentration, prediction-error, stationary, smoothing."""
    with told_in_one_line(None, out):
        from kalmanq.commands.examples import Asked, show

        show(Asked(name.value if name else None, arith.value, seed, out, json_), console())


@app.command()
def gallery(
    name: Optional[Entry] = typer.Argument(None, metavar="MODEL", help="Otherwise the list of them."),
    out: Optional[Path] = typer.Option(None, "--out", metavar="FOLDER", help="Where files go; it has to be there."),
    json_: bool = JSON,
) -> None:
    """Textbook models with data, fitted, smoothed and drawn: level, trend, season, ARMA, regression, factor, ..."""
    with told_in_one_line(None, out):
        from kalmanq.commands.gallery import Asked, show

        show(Asked(name.value if name else None, out, json_), console())


@app.command()
def study(
    name: Study = typer.Argument(..., metavar="NAME", help="heavy-tails: where the state jumps."),
    out: Path = typer.Option(..., "-o", "--out", metavar="FOLDER", help="Where the page goes; it has to be there."),
    quick: bool = typer.Option(False, "--quick", help="Few runs, in less than a minute."),
    seed: int = typer.Option(1, "--seed", min=0, help="The same seed gives the same page."),
    workers: Optional[int] = typer.Option(None, "--workers", min=1, help="Processes; all cores if left out."),
    dask: Optional[str] = typer.Option(None, "--dask", metavar="ADDRESS", help="A Dask scheduler: on its cluster."),
    fresh: bool = typer.Option(False, "--fresh", help="Forget what an interrupted command has done."),
    json_: bool = JSON,
) -> None:
    """Run a study of the library's behaviour, and write its findings."""
    with told_in_one_line(out):
        from kalmanq.commands.study import Asked, run_study

        run_study(Asked(name.value, out, quick, seed, workers, dask, fresh, json_), console())


def main() -> None:
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:  # it is ignored in the background of a script
        signal.signal(signal.SIGTERM, _terminate)
    try:
        with told_in_one_line():
            try:
                app()
            finally:
                sys.stdout.flush()
    except SystemExit as ended:
        raise SystemExit(TERMINATED if _heard and ended.code == INTERRUPTED else ended.code) from None


if __name__ == "__main__":
    main()
