"""The plot of the estimate: how the log-likelihood rises, and what the smoother makes of the data
with the guess and with the estimate.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

import plot
from estimates import DRAWN, Band
from learning import Course, Learning


def save(learning: Learning, runs: plot.Runs, path: Path) -> None:
    """Draws the iterations, and the smoothed runs before and after them, into a PNG."""
    job, count = learning.guess, len(learning.guess.model.measured)
    with plt.rc_context(plot.STYLE):
        figure, panels = plt.subplots(
            1 + count, figsize=(11, 3.4 + 3.6 * count), height_ratios=(0.8, *[1.0] * count)
        )
        plot_rise(panels[0], learning)
        before, after = learning.before.smoothed, runs[DRAWN].smoothed
        for c, axes in enumerate(panels[1:]):
            plot_smoothed(axes, learning, before, after, c)
        plot.label_time(panels[-1], job)
        figure.align_ylabels(panels)
        title = f"{job.title}, Q and R by EM (kalmanq)"
        plot.arrange(figure, legend_entries(learning), plot.literal(title))
        figure.savefig(path, format="png")
        plt.close(figure)


def plot_rise(axes: Axes, learning: Learning) -> None:
    """Linear convergence is a straight line here."""
    for name, course in learning.courses.items():
        label = f"{name}: {course.last} iterations"
        axes.plot(shortfall(course), color=plot.ARITHMETIC[name], lw=1.4, label=label)
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
    plot.shade_gaps(axes, job, c)
    for band, colour in ((before, plot.GUESS), (after, plot.SMOOTHER)):
        plot.plot_band(axes, job.time, band, i, colour)
    plot.plot_edges(axes, job.time, before, i, plot.GUESS)
    axes.plot(job.time, job.z[:, c], ms=plot.marker(job), zorder=3.5, **plot.DATA_STYLE)
    axes.set_ylabel(plot.with_unit(job.model.measured[c], job.unit))
    axes.margins(x=0.01)
    if c == 0:
        axes.set_title(f"Smoothed before and after, with 95 % bands ({DRAWN})")


def legend_entries(learning: Learning) -> list[tuple[str, Any]]:
    entries = plot.data_entries(learning.guess)
    entries.append(("with the guess", plot.band_sample(plot.GUESS)))
    entries.append(("with the estimate", plot.band_sample(plot.SMOOTHER)))
    return entries
