"""What `kalmanq NAME` does, a module a command: its options, what it calls of the library, what it prints.

COMMANDS has a row for each.  A module defines `command`, which is made by options.command_of.
"""

from typing import NamedTuple

STUDIES = "kalmanq_studies.commands"  # a package of its own


class Row(NamedTuple):
    """example: what its help ends with; a test runs it in a folder with the files of kalmanq/examples"""

    module: str
    help: str
    example: str


COMMANDS = {
    "run": Row(
        "kalmanq.commands.run",
        "Filter a CSV file; with --smooth, --lag and --forecast what was, and what is to come.",
        "kalmanq run track.toml my.csv --smooth --plot my.png"),
    "check": Row(
        "kalmanq.commands.check",
        "Is the model observable, stabilisable and well conditioned, and do the ranges fit?  Are Jacobians right?",
        "kalmanq check track.toml"),
    "design": Row(
        "kalmanq.commands.design",
        "Formats, accuracy and costs on a core; the way to run it; the filter as a C file.",
        "kalmanq design track.toml --core m3 --out ."),
    "compile": Row(
        "kalmanq.commands.compile",
        "C for exactly this filter, without a library: straight lines, for any constant model and any gaps.",
        "kalmanq compile constant_velocity.toml -o walk.c"),
    "steady": Row(
        "kalmanq.commands.steady",
        "What the covariance settles to, the gain, and how fast the filter forgets.",
        "kalmanq steady constant_velocity.toml"),
    "simulate": Row(
        "kalmanq.commands.simulate",
        "Draw measurements of the model, as a CSV file that `run` takes; with --runs, errors over many runs.",
        "kalmanq simulate track.toml -n 200 --out my.csv"),
    "compare": Row(
        "kalmanq.commands.compare",
        "Every arithmetic compared with double: errors of means in sigma, and of sigmas.  Of a nonlinear model the "
        "methods, too.",
        "kalmanq compare track.toml my.csv"),
    "report": Row(
        "kalmanq.commands.report",
        "Does the data fit the model?  A page with a verdict, pictures and figures.",
        "kalmanq report nile.toml nile.csv -o nile.html"),
    "fit": Row(
        "kalmanq.commands.fit",
        "Estimate parameters, with standard errors.  Exit code 3: no maximum; OUT then has the best that was found.",
        "kalmanq fit nile_guess.toml nile.csv --out fitted.toml"),
    "tune": Row(
        "kalmanq.commands.tune",
        "A page in which the library runs over a recording while you move its noises; with a fit, and no server.",
        "kalmanq tune track.toml my.csv -o tune.html"),
    "doctor": Row(
        "kalmanq.commands.doctor",
        "What is installed, which compilers and emulators are there, what is missing for which command.",
        "kalmanq doctor --json"),
    "examples": Row(
        f"{STUDIES}.examples",
        "The theory's examples: stationary, smoothing.",
        "kalmanq examples stationary --out stationary.png"),
    "gallery": Row(
        f"{STUDIES}.gallery",
        "Textbook models with data, fitted, smoothed and drawn: level, trend, season, ARMA, regression, factor, ...",
        "kalmanq gallery trend-season --out ."),
    "study": Row(
        f"{STUDIES}.study",
        "Run a study of the library's behaviour, and write its findings.",
        "kalmanq study heavy-tails --quick -o ."),
}
