"""What `kalmanq NAME` does, a module a command: its options, what it calls of the library, what it prints.

COMMANDS has a row for each, GONE what replaced an option.  A module defines `command`, which is made by options.command_of.  A package
brings further rows by an entry point of the group `kalmanq.commands`, a dictionary as COMMANDS is.
"""

from functools import lru_cache
from importlib import metadata
from typing import Any, NamedTuple, Sequence


class Row(NamedTuple):
    """example, more: what its help ends with; a test runs each in a folder with the files of kalmanq/examples"""

    module: str
    help: str
    example: str
    more: Sequence[str] = ()


ON_DASK = "within joblib's parallel_config(backend=\"dask\") run_campaign of Python runs on your cluster: tools/docs/guides/many_runs.md"
GONE = {  # of a command: options that it had before 2.0, and why it has no more
    "compile": {
        "--form": "compile has one form, which takes any gaps; leave it out",
        "--partial": "a sample may always be there in part; leave it out",
        "--bound": "NAME_report.txt has the errors that were observed; leave it out",
        "--gate": "it is --robust gate=K",
        "--student": "it is --robust student=NU",
        "--settle": "the gain counts as constant where every variance is within 1e-6 of the steady one; leave it out",
        "--data": "declare the ranges of states and controls in MODEL.py, which formats hold"},
    "simulate": {"--dask": ON_DASK},
    "study": {"--dask": ON_DASK},
}
COMMANDS = {
    "run": Row(
        "kalmanq.commands.run",
        "Filter a CSV file or a log.  Also smooth it (--smooth, --lag) and forecast (--forecast).",
        "kalmanq run track.toml my.csv --smooth --plot my.png"),
    "check": Row(
        "kalmanq.commands.check",
        "Check a model: is it observable, stabilisable, well conditioned?  Do ranges fit?  Are Jacobians right?",
        "kalmanq check track.toml"),
    "design": Row(
        "kalmanq.commands.design",
        "Choose formats and form of the filter for a core: accuracy, flash, RAM, instructions.  Write it as a C file.",
        "kalmanq design track.toml --core m3 --out ."),
    "compile": Row(
        "kalmanq.commands.compile",
        "Write C for this filter alone, without a library: for any constant model and any gaps.",
        "kalmanq compile constant_velocity.toml -o walk.c",
        ("kalmanq compile cart.toml -o cart.c --arith q31 --robust gate=4",
         "kalmanq compile oscillator.toml -o swing.c --nis --lag 8",
         "kalmanq compile track.toml -o track.c --tunable",
         "kalmanq compile two_gauges.toml -o gauges.c --every 1,10",
         "kalmanq compile trend_season.toml -o trend.c --loops",
         "kalmanq compile track.toml -o shared.c --library --robust huber=3",
         "kalmanq compile range_bearing.py -o radar.c --iterate 3 --smooth 50",
         "kalmanq compile battery.py -o battery.c --library --arith q31 --json")),
    "steady": Row(
        "kalmanq.commands.steady",
        "Show the steady state: covariance, gain, and how fast the filter forgets.",
        "kalmanq steady constant_velocity.toml"),
    "simulate": Row(
        "kalmanq.commands.simulate",
        "Simulate measurements of the model, as a CSV file for `run`; with --runs, the errors of many runs.",
        "kalmanq simulate track.toml -n 200 --out my.csv"),
    "compare": Row(
        "kalmanq.commands.compare",
        "Compare each arithmetic with double: errors of means in sigma, and of sigmas.  Nonlinear model: the "
        "methods, too.",
        "kalmanq compare track.toml my.csv"),
    "report": Row(
        "kalmanq.commands.report",
        "Does the model fit the data?  Write a page with a verdict, pictures and figures.",
        "kalmanq report nile.toml nile.csv -o nile.html"),
    "fit": Row(
        "kalmanq.commands.fit",
        "Estimate parameters from data, with standard errors.  Exit code 3: no maximum; OUT then has the best that was found.",
        "kalmanq fit nile_guess.toml nile.csv --out fitted.toml"),
    "tune": Row(
        "kalmanq.commands.tune",
        "Write a page in which the library filters your data while you move the noises; it needs no server.",
        "kalmanq tune track.toml my.csv -o tune.html"),
    "doctor": Row(
        "kalmanq.commands.doctor",
        "Show what is installed: packages, compilers, emulators; and what each command still needs.",
        "kalmanq doctor --json"),
}


@lru_cache(maxsize=None)  # each distribution on the path is opened
def commands() -> dict[str, Row]:
    """The package's own, and those of packages that are installed beside it"""
    points: Any = metadata.entry_points()
    group = "kalmanq.commands"
    found = points.select(group=group) if hasattr(points, "select") else points.get(group, ())  # before Python 3.10
    return {**COMMANDS, **{name: row for point in found for name, row in _rows(point).items()}}


def _rows(point: Any) -> dict[str, Row]:
    """None of a package that is half gone: kalmanq's own commands work on"""
    try:
        return point.load()
    except ImportError:
        return {}
