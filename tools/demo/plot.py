"""What the figures are drawn from: bands, gaps, forecasts, labels."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from estimates import Band, Estimates
from jobs import Job

# Okabe and Ito's palette: told apart with any colour vision.  A band's tint is opaque, so that
# bands on top of each other keep their colours.
FILTER, SMOOTHER, FORECAST, GUESS = "#D55E00", "#0072B2", "#009E73", "#E69F00"
TINT = {FILTER: "#FBE4D5", SMOOTHER: "#B9DAEF", FORECAST: "#BFE7DB", GUESS: "#FBE9C6"}
ARITHMETIC = {"f32": "#CC79A7", "f64": "#56B4E9", "q31": "#B57900"}
DATA, TRUTH, GAP = "#444444", "#000000", "#E6E6E6"
TRUTH_STYLE: dict[str, Any] = {"color": TRUTH, "lw": 1.1, "ls": (0, (1, 1.3))}
DATA_STYLE: dict[str, Any] = {"color": DATA, "ls": "", "marker": "o", "mew": 0}
Z_STYLE: dict[str, Any] = {"color": FORECAST, "lw": 0.9, "ls": "--"}


# ---- one component against time --------------------------------------------------------------


def plot_component(axes: Axes, job: Job, found: Estimates, c: int) -> None:
    """One measured component against time."""
    i = job.measured_states[c]
    shade_gaps(axes, job, c)
    plot_band(axes, job.time, found.filtered, i, FILTER)
    plot_band(axes, job.time, found.smoothed, i, SMOOTHER)
    plot_edges(axes, job.time, found.filtered, i, FILTER)
    plot_forecast(axes, job, found, c)
    if job.truth is not None:
        times = np.concatenate([job.time, job.future])
        axes.plot(times, job.truth[:, i], zorder=4, **TRUTH_STYLE)
    axes.plot(job.time, job.z[:, c], ms=marker(job), zorder=3.5, **DATA_STYLE)
    axes.set_ylabel(with_unit(job.model.measured[c], job.unit))
    axes.set_xlim(*time_limits(job))
    axes.set_ylim(*limits(job, found, c))


def plot_band(axes: Axes, time: np.ndarray, band: Band, i: int, colour: str) -> None:
    low, high = band.low[:, i], band.high[:, i]
    axes.fill_between(time, low, high, color=TINT[colour], lw=0, zorder=2)
    axes.plot(time, band.mean[:, i], color=colour, lw=1.5, zorder=3)


def plot_edges(axes: Axes, time: np.ndarray, band: Band, i: int, colour: str) -> None:
    """The edges of a band that another one covers."""
    for edge in (band.low[:, i], band.high[:, i]):
        axes.plot(time, edge, color=colour, lw=0.6, alpha=0.55, zorder=2.5)


def plot_forecast(axes: Axes, job: Job, found: Estimates, c: int) -> None:
    """The forecast of the state and, wider, of the measurement; it starts at the last state."""
    if job.ahead == 0:
        return
    i = job.measured_states[c]
    time = np.concatenate([job.time[-1:], job.future])
    plot_band(axes, time, from_now_on(found), i, FORECAST)
    axes.plot(job.future, found.forecast_z.low[:, c], **Z_STYLE)
    axes.plot(job.future, found.forecast_z.high[:, c], **Z_STYLE)
    axes.axvline(job.time[-1], color="#888888", lw=0.8)


def from_now_on(found: Estimates) -> Band:
    """The last state and the forecasts."""
    return Band(
        np.concatenate([found.filtered.mean[-1:], found.forecast.mean]),
        np.concatenate([found.filtered.sigma[-1:], found.forecast.sigma]),
    )


def shade_gaps(axes: Axes, job: Job, c: int) -> None:
    for first, last in job.gaps(c):
        start, end = job.time[first] - job.dt / 2, job.time[last] + job.dt / 2
        axes.axvspan(start, end, color=GAP, lw=0, zorder=0)


def time_limits(job: Job) -> tuple[float, float]:
    last = job.time[-1] + job.ahead * job.dt
    margin = 0.01 * (last - job.time[0]) or job.dt
    return job.time[0] - margin, last + margin


def limits(job: Job, found: Estimates, c: int) -> tuple[float, float]:
    """Everything in sight but the filter's band of the first steps, which tells of P0 only."""
    i = job.measured_states[c]
    settled = slice(min(2 * len(job.model.x0), job.steps - 1), None)
    parts = [job.z[:, c], found.smoothed.mean[:, i]]
    for band, rows, column in (
        (found.smoothed, settled, i),
        (found.filtered, settled, i),
        (found.forecast_z, slice(None), c),
    ):
        parts += [band.low[rows, column], band.high[rows, column]]
    low, high = np.nanmin(np.concatenate(parts)), np.nanmax(np.concatenate(parts))
    margin = 0.04 * (high - low) or 1.0
    return low - margin, high + margin


# ---- labels ----------------------------------------------------------------------------------


def marker(job: Job) -> float:
    """Smaller dots where there are many."""
    return float(np.clip(40 / np.sqrt(job.steps), 0.8, 4.0))


def with_unit(name: str, unit: str) -> str:
    return literal(f"{name} [{unit}]" if unit else name)


def literal(text: str) -> str:
    """Text that Matplotlib is not to take for mathematics."""
    return text.replace("$", r"\$")


def label_time(axes: Axes, job: Job) -> None:
    axes.set_xlabel(with_unit(job.time_name, job.time_unit))


def arrange(figure: Figure, entries: list[tuple[str, Any]], title: str) -> None:
    """The title above, the legend below, the panels between."""
    inch = 1 / figure.get_size_inches()[1]
    figure.text(0.012, 1 - 0.1 * inch, title, ha="left", va="top", fontsize=12, weight="bold")
    columns = 6 if figure.get_size_inches()[0] < 12 else 7
    figure.legend(
        [handle for _, handle in entries],
        [label for label, _ in entries],
        loc="lower center",
        ncol=columns,
        fontsize=9,
        columnspacing=1.5,
    )
    lines = -(-len(entries) // columns)
    figure.tight_layout(rect=(0, (0.1 + 0.21 * lines) * inch, 1, 1 - 0.34 * inch))


def data_entries(job: Job) -> list[tuple[str, Any]]:
    entries: list[tuple[str, Any]] = [("measurement", Line2D([], [], ms=4, **DATA_STYLE))]
    if job.truth is not None:
        entries.append(("truth", Line2D([], [], **TRUTH_STYLE)))
    if np.isnan(job.z).any():
        entries.append(("no measurements", Patch(fc=GAP)))
    return entries


def band_sample(colour: str) -> tuple[Patch, Line2D]:
    return Patch(fc=TINT[colour], lw=0), Line2D([], [], color=colour, lw=1.5)
