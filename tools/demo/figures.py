"""The figures: data, filtered and smoothed mean with their 95 % bands, gaps, forecast, and how far
each arithmetic is from the reference; of an estimate, how the log-likelihood rises, and what the
smoother makes of the data with the guess and with the estimate.

The curves are those of one arithmetic: drawn on top of each other they would look the same.
"""

from __future__ import annotations

from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Ellipse

from estimates import DRAWN, REFERENCE, Band, Course, Estimates, Learning, Runs
from jobs import Job
from plot import (
    ARITHMETIC, DATA_STYLE, FILTER, FORECAST, GUESS, SMOOTHER, TINT, TRUTH_STYLE, Z_STYLE, arrange,
    band_sample, data_entries, from_now_on, label_time, literal, marker, plot_band,
    plot_component, plot_edges, shade_gaps, time_limits, with_unit,
)  # fmt: skip

SHOWN = (1e-16, 1e-6)  # distances from the reference in sigma, and more where it is needed
ELLIPSE_95 = np.sqrt(5.991465)  # half axis of the 95 % ellipse, in standard deviations


def draw(job: Job, runs: Runs) -> Figure:
    """The runs of a job."""
    figure = draw_series(job, runs) if len(job.model.measured) == 1 else draw_track(job, runs)
    arrange(figure, legend_entries(job), literal(f"{job.title} (kalmanq, {DRAWN})"))
    return figure


def legend_entries(job: Job) -> list[tuple[str, Any]]:
    entries = data_entries(job)
    entries.append(("filter, 95 % band", band_sample(FILTER)))
    entries.append(("smoother, 95 % band", band_sample(SMOOTHER)))
    if job.ahead:
        entries.append(("forecast, 95 % band", band_sample(FORECAST)))
        entries.append(("next measurements, 95 %", Line2D([], [], **Z_STYLE)))
    return entries


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


# ---- an estimate -----------------------------------------------------------------------------


def draw_learning(learning: Learning, runs: Runs) -> Figure:
    """The iterations, and the smoothed runs before and after them."""
    job, count = learning.guess, len(learning.guess.model.measured)
    figure, panels = plt.subplots(
        1 + count, figsize=(11, 3.4 + 3.6 * count), height_ratios=(0.8, *[1.0] * count)
    )
    plot_rise(panels[0], learning)
    before, after = learning.before.smoothed, runs[DRAWN].smoothed
    for c, axes in enumerate(panels[1:]):
        plot_smoothed(axes, learning, before, after, c)
    label_time(panels[-1], job)
    figure.align_ylabels(panels)
    arrange(figure, learning_entries(learning), literal(f"{job.title}, Q and R by EM (kalmanq)"))
    return figure


def plot_rise(axes: Axes, learning: Learning) -> None:
    """Linear convergence is a straight line here."""
    for name, course in learning.courses.items():
        label = f"{name}: {course.last} iterations"
        axes.plot(shortfall(course), color=ARITHMETIC[name], lw=1.4, label=label)
    axes.set_yscale("log")
    axes.margins(x=0.01)
    axes.set_xlabel("iteration")
    axes.set_ylabel("[nats]")
    axes.set_title("Log-likelihood: distance from its highest value, to rounding")
    axes.legend(loc="upper right")


def shortfall(course: Course) -> np.ndarray:
    """How far each iteration is below the highest; NaN where nothing is left of it."""
    found = course.log_likelihood.max() - course.log_likelihood
    return np.where(found > 0, found, np.nan)


def plot_smoothed(axes: Axes, learning: Learning, before: Band, after: Band, c: int) -> None:
    """One measured component against time."""
    job = learning.guess
    i = job.measured_states[c]
    shade_gaps(axes, job, c)
    for band, colour in ((before, GUESS), (after, SMOOTHER)):
        plot_band(axes, job.time, band, i, colour)
    plot_edges(axes, job.time, before, i, GUESS)
    axes.plot(job.time, job.z[:, c], ms=marker(job), zorder=3.5, **DATA_STYLE)
    axes.set_ylabel(with_unit(job.model.measured[c], job.unit))
    axes.margins(x=0.01)
    if c == 0:
        axes.set_title(f"Smoothed before and after, with 95 % bands ({DRAWN})")


def learning_entries(learning: Learning) -> list[tuple[str, Any]]:
    entries = data_entries(learning.guess)
    entries.append(("with the guess", band_sample(GUESS)))
    entries.append(("with the estimate", band_sample(SMOOTHER)))
    return entries
