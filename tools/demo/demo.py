"""The kalmanq demo: filters, forecasts and smooths a data set in f32, f64 and q31, compares all
with a textbook filter in double precision, and writes the results as a CSV and a plot.  Where the
noise is a guess, EM estimates it first.

Started by tools/demo.sh, which builds the programs it runs.
"""

import math
import sys
from dataclasses import replace
from enum import Enum
from pathlib import Path
from typing import List, Optional

import typer

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(1, str(ROOT / "tools"))

import built_in
import own_data
import report
import runner
from estimates import iterations_csv, runs_csv
from jobs import Job
from own_data import Given
from shared.errors import UserError, told_in_one_line
from shared.outputs import Outputs, shown, terminal

WIDTH = 120  # of every table, where there is no terminal
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
    with told_in_one_line("demo"):
        given = Given(q, r, dt, measured_range, forecast, estimate)
        check_options(csv, model, given)
        if csv is None:
            chosen = [built_in.nile(ROOT, forecast), built_in.track(forecast)]
        elif model is ModelName.local_level:
            chosen = [own_data.local_level(csv, given)]
        else:
            chosen = [own_data.constant_velocity(csv, given)]
        run_all(chosen, out, programs)


def check_options(csv: Optional[Path], model: Optional[ModelName], given: Given) -> None:
    if csv is None and (model is not None or replace(given, ahead=None) != Given()):
        raise UserError("--model, --q, --r, --estimate, --dt and --range go with a CSV of your own")
    if csv is not None and model is None:
        raise UserError("--model is missing: local-level or constant-velocity")
    for name, value, least in (
        ("--q", given.q, 1e-30 if given.to_estimate else 0.0),  # EM cannot leave 0
        ("--r", given.r, 1e-30),
        ("--dt", given.dt, 1e-9),
        ("--range", given.range, 1e-30),
    ):
        if value is not None and not (math.isfinite(value) and least <= value <= 1e30):
            raise UserError(f"{name} {value:g}: must be from {least:g} to 1e+30")
    if given.ahead is not None and not 0 <= given.ahead <= FORECAST_MOST:
        raise UserError(f"--forecast {given.ahead}: must be from 0 to {FORECAST_MOST}")


def run_all(chosen: List[Job], out: Path, programs: Path) -> None:
    """Runs every job, then writes every file, then shows the tables."""
    found = [runner.run_job(job, programs) for job in chosen]
    with Outputs(out, [path for job in chosen for path in job.inputs]) as outputs:
        for result in found:
            write(result, outputs)
    console = terminal(WIDTH)
    for result in found:
        if result.learning:
            report.show_learning(console, result.learning)
        report.show(console, result.job, result.runs)
    print()
    for path in outputs.files:
        print(f"wrote {shown(path)}")


def write(result: runner.Result, outputs: Outputs) -> None:
    import figures  # late: Matplotlib takes its time, and bad input is answered without it
    from shared import pictures

    job, runs, learning = result.job, result.runs, result.learning
    for name, text in job.extra_files.items():
        outputs.write(name, text)
    outputs.write(f"{job.name}.csv", runs_csv(job, runs))
    pictures.save(lambda: figures.draw(job, runs), outputs.stage(f"{job.name}.png"))
    if learning:
        outputs.write(f"{job.name}_em.csv", iterations_csv(learning))
        picture = outputs.stage(f"{job.name}_em.png")
        pictures.save(lambda: figures.draw_learning(learning, runs), picture)


if __name__ == "__main__":
    app(prog_name="tools/demo.sh")
