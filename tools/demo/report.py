"""The tables: log-likelihood, errors, memory, below it the formats of fixed point; of an estimate
its noise and log-likelihood at the guess, on the way and at the end."""

from __future__ import annotations


import numpy as np
from rich.console import Console
from rich.table import Table
from rich.text import Text

from estimates import REFERENCE, TAKEN, Band, Course, Estimates, Learning, Runs
from jobs import Job, ranges_of

Row = tuple[str, list[str]]

# KQ_EVENT_... of status.h, by bit
EVENTS = {
    1: "FLOOR (a measurement that could tell nothing new was not taken)",
    2: "OVERFLOW (an innovation left the number range; the measurement was not taken)",
    4: "HISTORY_FULL",
    8: "SATURATED (a state left the range of its format and was held at its end)",
}


def show(console: Console, job: Job, runs: Runs) -> None:
    """Prints the runs of a job side by side; the reference is the last of them."""
    sections = [
        likelihood_rows(runs),
        truth_rows(job, runs),
        error_rows(runs),
        memory_rows(job, runs),
    ]
    lines = [job.note, *formats(job, runs), *warnings(job, runs)]
    show_table(console, job.title, list(runs), sections, lines)


def show_learning(console: Console, learning: Learning) -> None:
    """Prints the iterations, a column each, of every arithmetic."""
    sections = [
        course_rows(name, course, learning, [*learning.milestones, course.last])
        for name, course in learning.courses.items()
    ]
    taken = learning.courses[TAKEN]
    lines = [rise_text(taken), *distance_text(taken), *remarks(learning)]
    title = f"{learning.guess.title}, Q and R by EM"
    show_table(console, title, headings(learning), sections, lines)


def show_table(
    console: Console, title: str, columns: list[str], sections: list[list[Row]], lines: list[str]
) -> None:
    """The lines go below the table."""
    table = Table(title=Text(title, style="bold"), title_justify="left", show_edge=False)
    table.add_column(no_wrap=True)
    for name in columns:
        table.add_column(name, justify="right")
    for rows in sections:
        for k, (name, cells) in enumerate(rows):
            table.add_row(Text(name), *cells, end_section=k == len(rows) - 1)
    console.print()
    console.print(table)
    for line in filter(None, lines):
        console.print(line, style="dim", markup=False, soft_wrap=True)


# ---- the runs of a job -----------------------------------------------------------------------


def likelihood_rows(runs: Runs) -> list[Row]:
    return [("log-likelihood", [f"{run.log_likelihood:.4f}" for run in runs.values()])]


def truth_rows(job: Job, runs: Runs) -> list[Row]:
    """RMS distance of the measured states from the truth, where it is known."""
    if job.truth is None:
        return []
    known, beyond = job.truth[: job.steps], job.truth[job.steps :]
    gap = np.isnan(job.z).all(axis=1)
    unit = f" [{job.unit}]" if job.unit else ""
    filtered = [run.filtered.mean for run in runs.values()]
    smoothed = [run.smoothed.mean for run in runs.values()]
    forecast = [run.forecast.mean for run in runs.values()]
    found = [
        (f"RMS error{unit}: measured", [spread_z(job)[~gap]] * len(runs), known[~gap]),
        ("  filtered", [mean[~gap] for mean in filtered], known[~gap]),
        ("  smoothed", [mean[~gap] for mean in smoothed], known[~gap]),
        ("  in the dropout: filtered", [mean[gap] for mean in filtered], known[gap]),
        ("  in the dropout: smoothed", [mean[gap] for mean in smoothed], known[gap]),
        (f"  {job.ahead} steps ahead: forecast", forecast, beyond),
    ]
    rows = [
        (label, [f"{rms(job, mean, truth):.3f}" for mean in means])
        for label, means, truth in found
        if len(truth)
    ]
    return rows + coverage_rows(job, runs, known)


def coverage_rows(job: Job, runs: Runs, known: np.ndarray) -> list[Row]:
    def share(band: Band) -> str:
        at = job.measured_states
        inside = (band.low <= known) & (known <= band.high)
        return f"{100 * inside[:, at].mean():.1f} %"

    return [
        ("truth in 95 % band: filtered", [share(run.filtered) for run in runs.values()]),
        ("  smoothed", [share(run.smoothed) for run in runs.values()]),
    ]


def spread_z(job: Job) -> np.ndarray:
    """The measurements in the places of the states that they measure."""
    z = np.full((job.steps, len(job.model.x0)), np.nan)
    z[:, job.measured_states] = job.z
    return z


def rms(job: Job, mean: np.ndarray, truth: np.ndarray) -> float:
    distance = (mean - truth)[:, job.measured_states]
    return float(np.sqrt(np.nanmean((distance**2).sum(axis=1))))


def error_rows(runs: Runs) -> list[Row]:
    """The largest error of a mean against the reference, in its standard deviations there."""
    reference = runs[REFERENCE]
    rows: list[Row] = []
    for label, part in (
        ("worst error [sigma]: filtered", "filtered"),
        ("  smoothed", "smoothed"),
        ("  forecast", "forecast"),
    ):
        true = getattr(reference, part)
        cells = [error_text(mean_error(getattr(run, part), true)) for run in runs.values()]
        rows.append((label, [*cells[:-1], "0"]))
    sigma = [error_text(sigma_error(run, reference)) for run in runs.values()]
    return rows + [("  any sigma itself, relative", [*sigma[:-1], "0"])]


def mean_error(found: Band, true: Band) -> float:
    return largest(np.abs(found.mean - true.mean) / true.sigma)


def sigma_error(found: Estimates, true: Estimates) -> float:
    pairs = [(getattr(found, p), getattr(true, p)) for p in ("filtered", "smoothed", "forecast")]
    return max(largest(np.abs(a.sigma / b.sigma - 1)) for a, b in pairs)


def largest(values: np.ndarray) -> float:
    return float(values.max()) if values.size else 0.0


def error_text(value: float) -> str:
    return "0" if value == 0 else f"{value:.1e}"


def memory_rows(job: Job, runs: Runs) -> list[Row]:
    def cell(run: Estimates, *names: str) -> str:
        return f"{sum(run.memory[name] for name in names):,}" if run.memory else "-"

    rows = [
        ("memory [bytes]: to filter", ("process", "sensor", "filter")),
        ("  the model's tables", ("model",)),
        (f"  to smooth {job.steps} steps", ("history",)),
    ]
    return [(label, [cell(run, *names) for run in runs.values()]) for label, names in rows]


def formats(job: Job, runs: Runs) -> list[str]:
    """Qm.n of every component, and the range declared that it was chosen for."""
    declared = ranges_of(job)
    lines = []
    for name, run in runs.items():
        if run.formats is None:
            continue
        for label, components, fractions, widths in (
            ("states", job.model.states, run.formats.states, declared.states),
            ("measurements", job.model.measured, run.formats.measured, declared.measured),
        ):
            shown = [
                f"{component} {format_text(fraction)} (\u00b1{width:.4g})"
                for component, fraction, width in zip(components, fractions, widths)
            ]
            lines.append(f"{name} formats, {label}: {', '.join(shown)}")
    return lines


def format_text(fraction: int) -> str:
    """Qm.n; m or n may be negative, where the point is outside the word."""
    return f"Q{31 - fraction}.{fraction}"


def warnings(job: Job, runs: Runs) -> list[str]:
    lines = [
        f"{name}: KQ_EVENT_{text}"
        for name, run in runs.items()
        for bit, text in EVENTS.items()
        if run.events & bit
    ]
    sigma = np.sqrt(np.diag(job.model.R))
    rounding = float(np.nanmax(np.abs(job.z) / sigma)) * 2**-24
    if rounding > 0.01:
        lines.append(
            f"f32 reads a measurement to 24 bits, here {rounding:.2g} of its sigma: "
            "subtract an origin from such data."
        )
    for name, run in runs.items():
        if run.formats is not None:
            grid = float(np.max(2.0 ** -np.array(run.formats.measured, dtype=float) / 2 / sigma))
            if grid > 0.01:
                lines.append(
                    f"{name} rounds a measurement to its format, by up to {grid:.2g} of its sigma: "
                    "subtract an origin, or declare a smaller --range."
                )
    return lines


# ---- an estimate -----------------------------------------------------------------------------


def headings(learning: Learning) -> list[str]:
    between = [""] * (len(learning.milestones) - 1)
    published = ["published"] if learning.guess.published else []
    return ["guess", *between, "last", *published]


def course_rows(name: str, course: Course, learning: Learning, shown: list[int]) -> list[Row]:
    published = learning.guess.published
    rows: list[Row] = [(f"{name}: iteration", [str(k) for k in shown])]
    for noise in ("q", "r"):
        known = [f"{getattr(published, noise):.6g}"] if published else []
        for c, component in enumerate(component_names(learning)):
            cells = [f"{getattr(course.models[k], noise)[c]:.6g}" for k in shown]
            rows.append((f"  {noise}{component}", cells + known))
    rows.append(("  log-likelihood", [f"{course.log_likelihood[k]:.4f}" for k in shown]))
    return rows


def component_names(learning: Learning) -> list[str]:
    """What tells the components apart, where there are several."""
    measured = learning.guess.model.measured
    return [f" of {name}" for name in measured] if len(measured) > 1 else [""]


def rise_text(course: Course) -> str:
    first, last = course.log_likelihood[[0, -1]]
    return f"{TAKEN}: the log-likelihood rose by {course.rise:.4f}, from {first:.4f} to {last:.4f}"


def distance_text(course: Course) -> list[str]:
    """What more iterations would add, where the last ones tell it."""
    if np.isnan(course.distance):
        return []
    return [f"{TAKEN}: up to {course.distance:.1g} below the maximum, extrapolated"]


def remarks(learning: Learning) -> list[str]:
    published = learning.guess.published
    lines = [
        f"{name}: not settled after {course.last} iterations"
        for name, course in learning.courses.items()
        if not course.settled
    ]
    return lines + ([f"published: {published.source}"] if published else [])
