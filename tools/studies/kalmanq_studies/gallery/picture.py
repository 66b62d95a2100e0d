"""An entry's picture: data, what was smoothed and what is to come, and the states that matter."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Optional

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from kalmanq.pages.pictures import AHEAD, DATA, FILTERED, SMOOTHED, STYLE
from kalmanq.run.filters import Filter
from kalmanq.run.results import Run
from kalmanq_studies.gallery.entries import Entry
from kalmanq_studies.gallery.sources import Data


@dataclass(frozen=True)
class Ahead:
    """Measurements of the rows to come: at: k; mean, sigma: k x m"""

    at: np.ndarray
    mean: np.ndarray
    sigma: np.ndarray


def forecast(last: Filter, rows: int, data: Data) -> Ahead:
    made = [last.forecast(k).measurement() for k in range(1, rows + 1)]
    step = data.at[-1] - data.at[-2]
    return Ahead(data.at[-1] + step * np.arange(1, rows + 1), np.array([mean for mean, _ in made]),
                 np.array([np.sqrt(np.diag(S)) for _, S in made]))


def signal(run: Run, data: Data) -> tuple[np.ndarray, np.ndarray]:
    """H x, smoothed, and its sigma: T x m"""
    H = np.broadcast_to(run.model.H, (len(run), run.model.m, run.model.n))
    if data.regressors is not None:
        H = data.regressors[:, None, :]
    variance = np.einsum("tci,tij,tcj->tc", H, run.smoothed_covariance, H)
    return np.einsum("tci,ti->tc", H, run.smoothed), np.sqrt(np.maximum(variance, 0.0))


def draw(entry: Entry, data: Data, run: Run, ahead: Optional[Ahead], title: str) -> Figure:
    states = [i for i, one in enumerate(run.model.states) if one.name in entry.drawn]
    panels = run.model.m + len(states)
    with plt.rc_context({**STYLE, "figure.dpi": 110}):
        figure, axes = plt.subplots(panels, 1, figsize=(8.2, 1.4 + 1.9 * panels), sharex=True, squeeze=False,
                                    layout="constrained")
        for c, axis in enumerate(axes[: run.model.m, 0]):
            _draw_measurement(axis, data, run, ahead, c)
        for i, axis in zip(states, axes[run.model.m :, 0]):
            _draw_state(axis, data, run, i)
        axes[-1, 0].set_xlabel(data.axis)
        handles = {label: handle for axis in axes[:, 0] for handle, label in zip(*axis.get_legend_handles_labels())}
        figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=len(handles))
        axes[0, 0].set_title(title)
        return figure


def _draw_measurement(axis: Any, data: Data, run: Run, ahead: Optional[Ahead], c: int) -> None:
    axis.plot(data.at, data.z[:, c], ".", ms=3.5, color=DATA, label="measured", zorder=1)
    if run.model.R[c, c] > 0:
        mean, sigma = signal(run, data)
        _band(axis, data.at, mean[:, c], sigma[:, c], SMOOTHED, "smoothed, 95 %")
    else:  # what is measured is the signal itself
        _band(axis, data.at, data.z[:, c] - run.innovation[:, c], run.innovation_sigma[:, c], FILTERED,
              "predicted from the rows before, 95 %")
    if ahead is not None:
        _band(axis, ahead.at, ahead.mean[:, c], ahead.sigma[:, c], AHEAD, "forecast, 95 %", "--")
    axis.set_ylabel(run.model.measurements[c].label)


def _draw_state(axis: Any, data: Data, run: Run, i: int) -> None:
    _band(axis, data.at, run.smoothed[:, i], run.smoothed_sigma[:, i], SMOOTHED, "smoothed, 95 %")
    axis.set_ylabel(run.model.states[i].label)


def _band(axis: Any, at: np.ndarray, mean: np.ndarray, sigma: np.ndarray, colour: str, label: str,
          line: str = "-") -> None:
    axis.fill_between(at, mean - 1.96 * sigma, mean + 1.96 * sigma, color=colour, alpha=0.2, lw=0)
    axis.plot(at, mean, color=colour, lw=1.2, ls=line, label=label)
