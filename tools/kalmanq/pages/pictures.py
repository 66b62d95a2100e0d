"""How pictures look, and the pictures."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, Optional, Sequence

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from PIL import Image

from kalmanq.data.files import whole
from kalmanq.errors import KalmanqError
from kalmanq.model import Model
from kalmanq.pages.across import Across, across
from kalmanq.run.results import Run

if TYPE_CHECKING:
    from kalmanq.fitting import Fit

STYLE: dict[str, Any] = {
    "figure.dpi": 160, "font.size": 9.5, "axes.titlesize": 10, "axes.titlelocation": "left",
    "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True, "grid.color": "#DDDDDD",
    "grid.linewidth": 0.5, "axes.axisbelow": True, "legend.frameon": False,
}
WIDE = 30.0  # a sigma of so many medians says nothing yet
FILTERED, SMOOTHED, DATA, AHEAD = "#1F6FB4", "#C4501B", "#8A8A8A", "#3C8D40"


def require_png(path: Path) -> None:
    if path.suffix.lower() != ".png" and (path.is_file() or not path.exists()):
        raise KalmanqError(f"{path}: pictures are PNG: a name that ends in .png")


def save(figure: Figure, path: Path, inputs: Sequence[Path] = ()) -> None:
    require_png(path)
    with whole(path, inputs) as temporary:
        figure.savefig(temporary, format="png")
    plt.close(figure)


def save_small(figure: Figure, path: Path) -> None:
    """As save, in 256 colours, those that are seldom, too: a third of the bytes."""
    require_png(path)
    with whole(path) as temporary:
        figure.savefig(temporary, format="png")
        with Image.open(temporary) as picture:
            small = picture.convert("RGB").quantize(256, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
        small.save(temporary, format="png", optimize=True)
    plt.close(figure)


def measured_states(model: Any) -> dict[int, list[tuple[int, float]]]:
    """The components that measure one state alone, with their factors: their data can be drawn on its axis."""
    made: dict[int, list[tuple[int, float]]] = {}
    for c, row in enumerate(model.H if isinstance(model, Model) else ()):
        states = np.flatnonzero(row)
        if len(states) == 1 and np.isfinite(row[states[0]]):
            made.setdefault(int(states[0]), []).append((c, float(row[states[0]])))
    return made


def without_offsets(run: Run, z: np.ndarray) -> np.ndarray:
    """H x of measurements H x + D u + d"""
    d = run.model.frame.d
    z = z if d is None else z - d
    return z if run.fed is None else z - run.fed


def draw_run(run: Run, z: np.ndarray, ahead: Optional[tuple[np.ndarray, np.ndarray]] = None,
             times: Optional[np.ndarray] = None) -> Figure:
    """A panel a state: data, mean and band of 95 %, the smoothed ones over them, the forecast behind.  Of a nonlinear
    model a panel a measurement, too: data, and what the filter expected.  times: of rows that have some"""
    along = across(run.model, len(run), times)
    with plt.rc_context(STYLE):
        n, m = run.model.n, 0 if isinstance(run.model, Model) else run.model.m
        figure, axes = plt.subplots(n + m, 1, figsize=(8.6, 1.2 + 2.1 * (n + m)), sharex=True, squeeze=False,
                                    layout="constrained")
        shown, z = measured_states(run.model), without_offsets(run, z)
        for i, axis in enumerate(axes[:n, 0]):
            _draw_state(axis, run, z, i, shown.get(i, []), ahead, along)
        for c, axis in enumerate(axes[n:, 0]):
            _draw_measurement(axis, run, z, c, along.at)
        axes[-1, 0].set_xlabel(along.label)
        handles = {label: handle for axis in axes[:, 0]
                   for handle, label in zip(*axis.get_legend_handles_labels())}
        figure.legend(handles.values(), handles.keys(), loc="outside upper right", ncols=len(handles))
        axes[0, 0].set_title(f"{run.model.name}, {run.arithmetic}")
        return figure


def _draw_state(axis: Any, run: Run, z: np.ndarray, i: int, measured: list[tuple[int, float]],
                ahead: Optional[tuple[np.ndarray, np.ndarray]], along: Across) -> None:
    rows = along.at
    for c, factor in measured:
        axis.plot(rows, z[:, c] / factor, ".", ms=3.5, color=DATA, alpha=0.7, label="measured", zorder=1)
    _band(axis, rows, run.mean[:, i], run.sigma[:, i], FILTERED, "filtered, 95 %")
    if run.smoothed is not None and run.smoothed_sigma is not None:
        _band(axis, rows, run.smoothed[:, i], run.smoothed_sigma[:, i], SMOOTHED, "smoothed, 95 %")
    if run.lag is not None and run.lagged is not None and run.lagged_sigma is not None:  # each at the row that it is of
        _band(axis, rows[: max(len(run) - run.lag, 0)], run.lagged[run.lag :, i], run.lagged_sigma[run.lag :, i], SMOOTHED,
              f"{run.lag} rows later, 95 %")
    if ahead is not None:
        mean, sigma = ahead
        _band(axis, rows[-1] + along.step * np.arange(1, len(mean) + 1), mean[:, i], sigma[:, i], AHEAD, "forecast, 95 %")
    axis.set_ylabel(run.model.states[i].label)
    limit(axis, np.concatenate([_settled(run, i)] + [z[:, c] / factor for c, factor in measured]))


def _settled(run: Run, i: int) -> np.ndarray:
    """The band that most rows have: of smoothed means of a state, or of the filtered ones that are no longer of a wide prior"""
    mean, sigma = (run.mean[:, i], run.sigma[:, i]) if run.smoothed is None else (run.smoothed[:, i], run.smoothed_sigma[:, i])
    half = 1.96 * np.nanmedian(sigma) if np.any(np.isfinite(sigma)) else 0.0
    mean = mean[~(sigma > WIDE * np.nanmedian(sigma))] if half else mean
    return np.concatenate([mean - half, mean + half])


def _draw_measurement(axis: Any, run: Run, z: np.ndarray, c: int, rows: np.ndarray) -> None:
    axis.plot(rows, z[:, c], ".", ms=3.5, color=DATA, alpha=0.7, label="measured", zorder=1)
    _band(axis, rows, z[:, c] - run.innovation[:, c], run.innovation_sigma[:, c], AHEAD, "expected, 95 %")
    axis.set_ylabel(run.model.measurements[c].label)
    limit(axis, z[:, c])


def _band(axis: Any, rows: np.ndarray, mean: np.ndarray, sigma: np.ndarray, colour: str, label: str) -> None:
    axis.fill_between(rows, mean - 1.96 * sigma, mean + 1.96 * sigma, color=colour, alpha=0.18, lw=0)
    axis.plot(rows, mean, color=colour, lw=1.3, label=label)


def limit(axis: Any, values: np.ndarray) -> None:
    """Room for these values: the first rows' bands may be so wide that nothing else could be seen."""
    low, high = axis.get_ylim()
    values = values[np.isfinite(values)]
    if len(values) and np.ptp(values) > 0:
        room = 0.6 * np.ptp(values)
        axis.set_ylim(max(low, values.min() - room), min(high, values.max() + room))


def draw_errors(errors: dict[str, np.ndarray]) -> Figure:
    """Worst error of a mean in sigma at every row, of each arithmetic compared with double."""
    with plt.rc_context(STYLE):
        figure, axis = plt.subplots(figsize=(8.6, 3.6), layout="constrained")
        for (name, error), colour in zip(errors.items(), (FILTERED, SMOOTHED)):
            axis.semilogy(np.maximum(error, 1e-17), lw=1, color=colour, label=name)
        axis.set(xlabel="row", ylabel="error of a mean / sigma", title="compared with double")
        figure.legend(loc="outside upper right", ncols=2)
        return figure


def draw_course(fit: Fit, name: str) -> Figure:
    """How far below the best one the best so far was, of EM and then of maximum likelihood.  What was tried besides is
    in dots: searches along a line, and searches from other places, which begin lower."""
    below = np.max(fit.course) - np.array(fit.course) if fit.course else np.zeros(0)
    below = np.where(np.isfinite(below), np.maximum(below, 1e-10), np.nan)
    numbers, count = np.arange(1, len(below) + 1), fit.em_evaluations
    best = np.fmin.accumulate(below)
    with plt.rc_context(STYLE):
        figure, axis = plt.subplots(figsize=(8.6, 3.6), layout="constrained")
        for part, colour, label in ((slice(0, count), FILTERED, "EM"),
                                    (slice(max(count - 1, 0), None), SMOOTHED, "maximum likelihood")):
            if len(numbers[part]) > (part.start > 0):
                tried = np.where(below > best, below, np.nan)[part]
                axis.semilogy(numbers[part], tried, ".", ms=3, color=DATA, alpha=0.6,
                              label="tried besides" if np.any(np.isfinite(tried)) else None)
                axis.semilogy(numbers[part], best[part], "o-", ms=3, lw=1.2, color=colour, label=label)
        axis.set(xlabel="evaluation", ylabel="log-likelihood below the best",
                 title=f"{name}: log-likelihood {fit.log_likelihood:.6f} after {len(below)} evaluations")
        axis.xaxis.get_major_locator().set_params(integer=True)
        if len(below):
            handles = dict(sorted(zip(*reversed(axis.get_legend_handles_labels()))))
            figure.legend(handles.values(), handles.keys(), loc="outside upper right", ncols=3)
        return figure
