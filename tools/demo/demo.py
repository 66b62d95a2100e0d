"""The kalmanq demo: filters, forecasts and smooths a data set in f32, f64 and q31, compares all
with a textbook filter in double precision, and writes the results as a CSV and a plot.  Where the
noise is a guess, EM estimates it first.

Started by tools/demo.sh, which builds the programs it runs.
"""

import math
import os
import sys
from dataclasses import dataclass, replace
from enum import Enum
from pathlib import Path
from typing import List, Optional

import typer
from rich.console import Console

import jobs
import learning_report
import reference
import report
import results
import runner
from errors import DemoError, one_line
from estimates import DRAWN, Estimates
from job import Job
from learning import Learning
from outputs import Outputs

ROOT = Path(__file__).resolve().parents[2]
ARITHMETICS = ("f32", "f64", "q31")
ESTIMATING = ("f32", "f64")
FORECAST_MOST = 10_000

DEMO_HELP = """Filter, forecast and smooth with kalmanq, in f32, f64 and q31. Without a CSV: the
two built-in data sets, the Nile, whose noise is estimated from a poor guess, and a simulated
track."""

MOMENTS_HELP = """Without --q or --r they are estimated by the method of moments. Local level:
variance c0 and lag-1 autocovariance c1 of the first differences, r = -c1 and q = c0 + 2 c1.
Constant velocity, each axis for itself: r from the variance c0 and the autocovariance c1 of the
second differences, r = (c0 - 4 c1) / 22; q from their variance 6 r + 2/3 q h^3 over a span h
that is long enough for the motion to show above the noise. Both are kept positive. They are
starting values: the method is simple, its estimates scatter."""

ESTIMATE_HELP = """With --estimate, EM takes q and r from there (--q and --r, where given) to the
maximum of the likelihood, in f32 and f64, in at most 1000 iterations (fewer of a long file); then
all arithmetics work with the estimate of f64. The axes of constant velocity keep the ratio of their
q. Iterations go to another CSV and another plot."""

CSV_HELP = """The CSV: one row a time step, fields separated by commas, an empty field or nan for a
missing measurement, a header line if you like, # for comments. Local level: one value, after an
optional column of times. Constant velocity: 1 to 3 positions, after an optional column whose header
is time. Times must be evenly spaced. The state before the first measurement is the mean
of the data, give or take ten times their standard deviation; the velocity 0, give or take ten
times the typical move per row."""

RANGE_HELP = """q31 works in fixed point: every state and measurement has a format Qm.n that holds
its range. The range of a measurement is --range, or else 4 times the largest in the data, and more
with a long forecast; a state measured has the same, and a velocity may cross it in one step."""


class ModelName(str, Enum):
    local_level = "local-level"
    constant_velocity = "constant-velocity"


app = typer.Typer(add_completion=False)


@app.command(
    help="\n\n".join(
        " ".join(text.split())
        for text in (DEMO_HELP, CSV_HELP, MOMENTS_HELP, ESTIMATE_HELP, RANGE_HELP)
    )
)
def main(
    csv: Optional[Path] = typer.Argument(None, help="Your measurements.", show_default=False),
    model: Optional[ModelName] = typer.Option(
        None, help="What your measurements follow.", show_default=False
    ),
    q: Optional[float] = typer.Option(
        None,
        help="Process noise. Local level: variance per step. Constant velocity: spectral "
        "density of the acceleration, length^2 / time^3.",
        show_default=False,
    ),
    r: Optional[float] = typer.Option(None, help="Variance of a measurement.", show_default=False),
    estimate: bool = typer.Option(
        False, "--estimate", help="Estimate q and r by EM, then filter with the estimate."
    ),
    dt: Optional[float] = typer.Option(
        None, help="Time from one row to the next; 1 if not given.", show_default=False
    ),
    measured_range: Optional[float] = typer.Option(
        None,
        "--range",
        help="For q31: the measurements are between -RANGE and RANGE.",
        metavar="RANGE",
        show_default=False,
    ),
    forecast: Optional[int] = typer.Option(
        None, help="Steps to forecast; if not given 10, for the track 20.", show_default=False
    ),
    out: Path = typer.Option(
        ROOT / "build" / "demo", help="Where the files go; build/demo if not given.",
        show_default=False,
    ),
    programs: Path = typer.Option(ROOT / "build" / "demo-build" / "tools" / "demo", hidden=True),
) -> None:
    try:
        check_options(csv, model, q, r, estimate, dt, measured_range, forecast)
        if csv is None:
            chosen = [jobs.nile(ROOT, forecast), jobs.track(forecast)]
        elif model is ModelName.local_level:
            job = jobs.local_level(csv, q, r, dt, measured_range, forecast)
            chosen = [replace(job, to_estimate=estimate)]
        else:
            job = jobs.constant_velocity(csv, q, r, dt, measured_range, forecast)
            chosen = [replace(job, to_estimate=estimate)]
        run_all(chosen, out, programs)
    except DemoError as problem:
        stop(str(problem))
    except OSError as problem:
        name = one_line(str(problem.filename)) if problem.filename else "file"
        stop(f"{name}: {problem.strerror or problem}")


def stop(line: str) -> None:
    print(f"demo: {line}", file=sys.stderr)
    raise typer.Exit(1)


def check_options(
    csv: Optional[Path],
    model: Optional[ModelName],
    q: Optional[float],
    r: Optional[float],
    estimate: bool,
    dt: Optional[float],
    measured_range: Optional[float],
    forecast: Optional[int],
) -> None:
    own = (model, q, r, estimate or None, dt, measured_range)
    if csv is None and any(option is not None for option in own):
        raise DemoError("--model, --q, --r, --estimate, --dt and --range go with a CSV of your own")
    if csv is not None and model is None:
        raise DemoError("--model is missing: local-level or constant-velocity")
    for name, value, least in (
        ("--q", q, 1e-30 if estimate else 0.0),  # EM cannot leave 0
        ("--r", r, 1e-30),
        ("--dt", dt, 1e-9),
        ("--range", measured_range, 1e-30),
    ):
        if value is not None and not (math.isfinite(value) and least <= value <= 1e30):
            raise DemoError(f"{name} {value:g}: must be from {least:g} to 1e+30")
    if forecast is not None and not 0 <= forecast <= FORECAST_MOST:
        raise DemoError(f"--forecast {forecast}: must be from 0 to {FORECAST_MOST}")


@dataclass(frozen=True)
class Result:
    job: Job  # with its noise as it was estimated, if it was
    runs: "dict[str, Estimates]"
    learning: Optional[Learning]


def run_all(chosen: List[Job], out: Path, programs: Path) -> None:
    """Runs every job, then writes every file, then shows the tables."""
    found = [run(job, programs) for job in chosen]
    with Outputs(out, [path for job in chosen for path in job.inputs]) as outputs:
        for result in found:
            write(result, outputs)
    # not a terminal: wide enough for every table, whatever reads it
    console = Console(highlight=False, width=None if sys.stdout.isatty() else 120)
    for result in found:
        if result.learning:
            learning_report.show(console, result.learning)
        report.show(console, result.job, result.runs)
    print()
    for path in outputs.files:
        print(f"wrote {shown(path)}")


def run(job: Job, programs: Path) -> Result:
    learning = learn(job, programs) if job.to_estimate else None
    if learning:
        job = learning.estimate
    runs = {name: runner.run(programs / f"kq_demo_{name}", job) for name in ARITHMETICS}
    runs[report.REFERENCE] = reference.run(job.model, job.z, job.ahead)
    return Result(job, runs, learning)


def learn(guess: Job, programs: Path) -> Learning:
    courses = {a: runner.estimate(programs / f"kq_estimate_{a}", guess) for a in ESTIMATING}
    before = runner.run(programs / f"kq_demo_{DRAWN}", guess)
    return Learning(guess, courses, before)


def write(result: Result, outputs: Outputs) -> None:
    import learning_plot  # late: Matplotlib takes its time, and bad input is answered without it
    import plot

    job, learning = result.job, result.learning
    for name, text in job.extra_files.items():
        outputs.write(name, text)
    outputs.write(f"{job.name}.csv", results.to_csv(job, result.runs))
    plot.save(job, result.runs, outputs.stage(f"{job.name}.png"))
    if learning:
        outputs.write(f"{job.name}_em.csv", results.iterations_to_csv(learning))
        learning_plot.save(learning, result.runs, outputs.stage(f"{job.name}_em.png"))


def shown(path: Path) -> str:
    """The path as seen from here, if that is shorter."""
    return min(str(path), os.path.relpath(path), key=len)


if __name__ == "__main__":
    app(prog_name="tools/demo.sh")
