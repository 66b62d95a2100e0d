"""The plots: data, filtered and smoothed mean with their 95 % bands, gaps, forecast; and how far
each arithmetic is from the reference.

The curves are those of one arithmetic: drawn on top of each other they would look the same.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Ellipse, Patch

from estimates import DRAWN, Band, Estimates
from job import Job

Runs = dict[str, Estimates]
REFERENCE = "reference"

# Okabe and Ito's palette: told apart with any colour vision.  A band's tint is opaque, so that
# bands on top of each other keep their colours.
FILTER, SMOOTHER, FORECAST, GUESS = "#D55E00", "#0072B2", "#009E73", "#E69F00"
TINT = {FILTER: "#FBE4D5", SMOOTHER: "#B9DAEF", FORECAST: "#BFE7DB", GUESS: "#FBE9C6"}
ARITHMETIC = {"f32": "#CC79A7", "f64": "#56B4E9", "q31": "#B57900"}
DATA, TRUTH, GAP = "#444444", "#000000", "#E6E6E6"
TRUTH_STYLE: dict[str, Any] = {"color": TRUTH, "lw": 1.1, "ls": (0, (1, 1.3))}
DATA_STYLE: dict[str, Any] = {"color": DATA, "ls": "", "marker": "o", "mew": 0}
Z_STYLE: dict[str, Any] = {"color": FORECAST, "lw": 0.9, "ls": "--"}
SHOWN = (1e-16, 1e-6)  # distances from the reference in sigma, and more where it is needed
ELLIPSE_95 = np.sqrt(5.991465)  # half axis of the 95 % ellipse, in standard deviations

STYLE: dict[str, Any] = {
    "figure.dpi": 160,
    "font.size": 9.5,
    "axes.titlesize": 10,
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#DDDDDD",
    "grid.linewidth": 0.5,
    "axes.axisbelow": True,
    "legend.frameon": False,
    "lines.solid_capstyle": "round",
}


def save(job: Job, runs: Runs, path: Path) -> None:
    """Draws the runs of a job into a PNG."""
    with plt.rc_context(STYLE):
        figure = draw_series(job, runs) if len(job.model.measured) == 1 else draw_track(job, runs)
        arrange(figure, legend_entries(job), literal(f"{job.title} (kalmanq, {DRAWN})"))
        figure.savefig(path, format="png")
        plt.close(figure)


# ---- one measured component ------------------------------------------------------------------


def draw_series(job: Job, runs: Runs) -> Figure:
    figure, (above, below) = plt.subplots(
        2, figsize=(11, 7.0), sharex=True, height_ratios=(3.4, 1)
    )
    plot_component(above, job, runs[DRAWN], 0)
    plot_distances(below, job, runs)
    label_time(below, job)
    figure.align_ylabels([above, below])
    return figure


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


# ---- two or three measured components --------------------------------------------------------


def draw_track(job: Job, runs: Runs) -> Figure:
    """The path in the plane of the first two axes; every axis against time; where the truth is
    known, the error; the arithmetics."""
    found, count = runs[DRAWN], len(job.model.measured)
    rows = count + (job.truth is not None) + 1
    figure = plt.figure(figsize=(13.5, 2.4 * rows + 1.1))
    heights = [1.0] * (rows - 1) + [0.8]
    grid = figure.add_gridspec(rows, 2, width_ratios=(1, 1.1), height_ratios=heights)
    plot_plane(figure.add_subplot(grid[:, 0]), job, found)
    series: list[Axes] = []
    for row in range(rows):
        axes = figure.add_subplot(grid[row, 1], sharex=series[0] if series else None)
        if row < count:
            plot_component(axes, job, found, row)
        elif job.truth is not None and row == count:
            plot_error(axes, job, found, job.truth, 0)
        else:
            plot_distances(axes, job, runs)
        axes.tick_params(labelbottom=row == rows - 1)
        series.append(axes)
    series[0].set_title("Against time, with 95 % bands")
    label_time(series[-1], job)
    figure.align_ylabels(series)
    return figure


def plot_plane(axes: Axes, job: Job, found: Estimates) -> None:
    i, j = job.measured_states[:2]
    plot_ellipses(axes, job, found, i, j)
    if job.truth is not None:
        axes.plot(job.truth[:, i], job.truth[:, j], zorder=4, **TRUTH_STYLE)
    axes.plot(job.z[:, 0], job.z[:, 1], ms=marker(job), zorder=2.5, **DATA_STYLE)
    plot_path(axes, found.filtered, i, j, FILTER)
    plot_path(axes, found.smoothed, i, j, SMOOTHER)
    if job.ahead:
        plot_path(axes, from_now_on(found), i, j, FORECAST)
    axes.set_xlabel(with_unit(job.model.measured[0], job.unit))
    axes.set_ylabel(with_unit(job.model.measured[1], job.unit))
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_title(f"In the plane{ellipse_note(job)}")


def ellipse_note(job: Job) -> str:
    places = ["in the gap"] * bool(job.gaps(0, 1)) + ["of the last forecast"] * bool(job.ahead)
    return f", with 95 % ellipses {' and '.join(places)}" if places else ""


def plot_path(axes: Axes, band: Band, i: int, j: int, colour: str) -> None:
    axes.plot(band.mean[:, i], band.mean[:, j], color=colour, lw=1.5, zorder=3)


def plot_ellipses(axes: Axes, job: Job, found: Estimates, i: int, j: int) -> None:
    """At a few steps of every gap.  The axes are independent: no tilt."""
    for band, colour in ((found.filtered, FILTER), (found.smoothed, SMOOTHER)):
        for first, last in job.gaps(0, 1):
            for t in np.unique(np.linspace(first, last, 5).round().astype(int))[::-1]:
                add_ellipse(axes, band, t, i, j, colour)
    if job.ahead:
        add_ellipse(axes, found.forecast, job.ahead - 1, i, j, FORECAST)


def add_ellipse(axes: Axes, band: Band, t: int, i: int, j: int, colour: str) -> None:
    width, height = 2 * ELLIPSE_95 * band.sigma[t, [i, j]]
    centre = band.mean[t, [i, j]]
    axes.add_patch(Ellipse(centre, width, height, fc=TINT[colour], ec=colour, lw=0.6, zorder=2))


def plot_error(axes: Axes, job: Job, found: Estimates, truth: np.ndarray, c: int) -> None:
    """Estimate minus truth, with the 95 % band that the estimate claims."""
    i = job.measured_states[c]
    now, beyond = truth[: job.steps, i], truth[job.steps - 1 :, i]
    shade_gaps(axes, job, c)
    plot_band(axes, job.time, error_of(found.filtered, now, i), 0, FILTER)
    plot_band(axes, job.time, error_of(found.smoothed, now, i), 0, SMOOTHER)
    if job.ahead:
        future = np.concatenate([job.time[-1:], job.future])
        plot_band(axes, future, error_of(from_now_on(found), beyond, i), 0, FORECAST)
        axes.axvline(job.time[-1], color="#888888", lw=0.8)
    axes.plot(job.time, job.z[:, c] - now, ms=marker(job), zorder=3.5, **DATA_STYLE)
    axes.axhline(0, zorder=4, **TRUTH_STYLE)
    axes.set_ylabel(with_unit(f"error in {job.model.measured[c]}", job.unit))


def error_of(band: Band, truth: np.ndarray, i: int) -> Band:
    """The error of state i with its band: where that holds 0, the band held the truth."""
    return Band((band.mean[:, i] - truth)[:, None], band.sigma[:, [i]])


# ---- the arithmetics -------------------------------------------------------------------------


def plot_distances(axes: Axes, job: Job, runs: Runs) -> None:
    """The distance of every arithmetic from the reference, in the reference's sigmas."""
    reference = runs[REFERENCE]
    drawn = [np.zeros(1)]
    for name, colour in ARITHMETIC.items():
        distance = np.concatenate(
            [
                distances(runs[name].filtered, reference.filtered),
                distances(runs[name].forecast, reference.forecast),
            ]
        )
        time = np.concatenate([job.time, job.future])
        axes.plot(time, distance, color=colour, lw=1.1, marker="o", ms=marker(job) / 3, label=name)
        smoothed = distances(runs[name].smoothed, reference.smoothed)
        axes.plot(job.time, smoothed, color=colour, lw=0.8, ls=(0, (2, 1.5)), alpha=0.8)
        drawn += [distance, smoothed]
    for c in range(len(job.model.measured)):
        shade_gaps(axes, job, c)
    if job.ahead:
        axes.axvline(job.time[-1], color="#888888", lw=0.8)
    axes.set_yscale("log")
    axes.set_ylim(SHOWN[0], max(4 * np.nanmax(np.concatenate(drawn)), SHOWN[1]))
    axes.set_xlim(*time_limits(job))
    axes.set_ylabel("[sigma]")
    axes.set_title("Distance from the reference; dashed: the smoother")
    place: dict[str, Any] = {"loc": "lower right", "bbox_to_anchor": (1.0, 0.98), "borderpad": 0}
    axes.legend(ncol=len(ARITHMETIC), handlelength=1.4, columnspacing=1.2, **place)


def distances(found: Band, true: Band) -> np.ndarray:
    """Step by step, the distance of the state that is furthest off; NaN where there is none."""
    furthest = np.max(np.abs(found.mean - true.mean) / true.sigma, axis=1)
    return np.where(furthest > 0, furthest, np.nan)


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


def legend_entries(job: Job) -> list[tuple[str, Any]]:
    entries = data_entries(job)
    entries.append(("filter, 95 % band", band_sample(FILTER)))
    entries.append(("smoother, 95 % band", band_sample(SMOOTHER)))
    if job.ahead:
        entries.append(("forecast, 95 % band", band_sample(FORECAST)))
        entries.append(("next measurements, 95 %", Line2D([], [], **Z_STYLE)))
    return entries


def data_entries(job: Job) -> list[tuple[str, Any]]:
    entries: list[tuple[str, Any]] = [("measurement", Line2D([], [], ms=4, **DATA_STYLE))]
    if job.truth is not None:
        entries.append(("truth", Line2D([], [], **TRUTH_STYLE)))
    if np.isnan(job.z).any():
        entries.append(("no measurements", Patch(fc=GAP)))
    return entries


def band_sample(colour: str) -> tuple[Patch, Line2D]:
    return Patch(fc=TINT[colour], lw=0), Line2D([], [], color=colour, lw=1.5)
