"""The three problems of smoothing and prediction on one signal: the error against how far one looks back or ahead.

Fixed lag: the state some rows ago, at every row.  Fixed point: one row, ever better known.  Fixed interval: every
row of a record given all of it.  Their standard deviations, as the covariances have them, stand beside the errors of
many drawn records, of which each estimate of each problem is compared with the truth once.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Mapping, Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from kalmanq.model import Model
from kalmanq.model.builders import build
from kalmanq.run.filters import Filter, LagSmoother, Smoother
from kalmanq.run.following import InstantSmoother
from kalmanq.run.parts import Parts
from kalmanq.run.simulation import simulate
from kalmanq_studies.lectures.example import BLUE, GREEN, GREY, ORANGE, PURPLE, Example, apart, ranged, shown

ROWS, POINT, FAR, RUNS = 60, 30, 12, 200  # rows of a record, the fixed point, the largest lag and horizon, records


@dataclass(frozen=True)
class Estimates:
    """Of the signal, k of them a record: error: RUNS x k, estimate - truth; sigma: k, what the core says of it"""

    error: np.ndarray
    sigma: np.ndarray

    @property
    def mean_square(self) -> np.ndarray:
        return np.mean(self.error**2, axis=0)

    @property
    def rms(self) -> np.ndarray:
        return np.sqrt(self.mean_square)

    @property
    def standard_error(self) -> np.ndarray:
        """Of the rms"""
        return self.error.std(axis=0, ddof=1) ** 2 * np.sqrt(2 / len(self.error)) / (2 * self.rms)


@dataclass(frozen=True)
class Record:
    """The one that is shown: truth, z: ROWS + FAR; the others: ROWS, ahead: FAR"""

    truth: np.ndarray
    z: np.ndarray
    filtered: np.ndarray
    smoothed: np.ndarray
    smoothed_sigma: np.ndarray
    ahead: np.ndarray
    ahead_sigma: np.ndarray


@dataclass(frozen=True)
class Result:
    """lag: of 0 .. FAR rows before the last one; horizon: 1 .. FAR rows after it; point: of row POINT, given rows
    POINT .. ROWS - 1; interval: every row given all"""

    lag: Estimates
    horizon: Estimates
    point: Estimates
    interval: Estimates
    filtered: Estimates
    record: Record


def model() -> Model:
    """A noisy oscillation of about twelve rows: y = 1.6 y_1 - 0.85 y_2 + w, measured with noise."""
    return Model(**build("ar", {"phi": np.array([1.6, -0.85]), "variance": 1.0, "noise": 6.0}), name="oscillation")


def compute(arithmetic: str, seed: int) -> Result:
    drawn = [simulate(model(), ROWS + FAR, one) for one in np.random.SeedSequence(seed).spawn(RUNS)]
    known = ranged(model(), [z for _, z in drawn])
    truth = np.array([x[:, 0] for x, _ in drawn])
    records = [z[:ROWS] for _, z in drawn]
    smoother = Smoother(known, arithmetic)
    runs = [smoother.run(z) for z in records]
    horizon = _ahead(known, arithmetic, records, truth)
    interval = _of([run.smoothed[:, 0] for run in runs], runs[0].smoothed_sigma[:, 0], truth[:, :ROWS])
    ahead = truth[0, ROWS:] + horizon.error[0]
    record = Record(truth[0], drawn[0][1][:, 0], runs[0].mean[:, 0], runs[0].smoothed[:, 0], interval.sigma, ahead,
                    horizon.sigma)
    filtered = _of([run.mean[:, 0] for run in runs], runs[0].sigma[:, 0], truth[:, :ROWS])
    return Result(_lagged(known, arithmetic, records, truth), horizon, _instant(known, arithmetic, records, truth),
                  interval, filtered, record)


def _of(values: Sequence[np.ndarray], sigma: np.ndarray, truth: np.ndarray) -> Estimates:
    return Estimates(np.array(values) - truth, np.array(sigma))


def _lagged(known: Model, arithmetic: str, records: Sequence[np.ndarray], truth: np.ndarray) -> Estimates:
    """Of each record at its last row, by a smoother of each lag"""
    runs = [[LagSmoother(known, lag, arithmetic).run(z) for lag in range(FAR + 1)] for z in records]
    return _of([[run.lagged[-1, 0] for run in one] for one in runs], [run.lagged_sigma[-1, 0] for run in runs[0]],
               truth[:, ROWS - 1 - np.arange(FAR + 1)])


def _ahead(known: Model, arithmetic: str, records: Sequence[np.ndarray], truth: np.ndarray) -> Estimates:
    parts = Parts(known, arithmetic)
    means, sigma = [], np.zeros(FAR)
    for z in records:
        filter_ = Filter(known, arithmetic, parts=parts)
        filter_.run(z)
        ahead = [filter_.forecast(k) for k in range(1, FAR + 1)]
        means.append([one.mean[0] for one in ahead])
        sigma = np.array([one.sigma[0] for one in ahead])
    return _of(means, sigma, truth[:, ROWS:])


def _instant(known: Model, arithmetic: str, records: Sequence[np.ndarray], truth: np.ndarray) -> Estimates:
    runs = [InstantSmoother(known, POINT, arithmetic).run(z) for z in records]
    return _of([run.instant[POINT:, 0] for run in runs], runs[0].instant_sigma[POINT:, 0], truth[:, [POINT]])


def numbers(result: Result) -> dict[str, Any]:
    made: dict[str, Any] = {}
    for name, of, k in (("12 rows ahead", result.horizon, FAR - 1), ("1 row ahead", result.horizon, 0),
                        ("filtered", result.lag, 0), ("lag 2", result.lag, 2), ("lag 12", result.lag, FAR),
                        (f"row {POINT}, given all", result.point, -1),
                        (f"fixed interval, row {POINT}", result.interval, POINT)):
        made[f"{name}: rms error of {RUNS} runs"] = of.rms[k]
        made[f"{name}: its standard error"] = of.standard_error[k]
        made[f"{name}: theory"] = of.sigma[k]
    return made


def distance(result: Result, exact: Result) -> float:
    """The truth is the same: errors are as far apart as estimates."""
    names = ("lag", "horizon", "point", "interval", "filtered")
    pairs = [(getattr(result, name), getattr(exact, name)) for name in names]
    return max(apart(of.error, beside.error, beside.sigma) for of, beside in pairs)


# ------------------------------------------------------------------------------ the figure


def draw(results: Mapping[str, Result]) -> Figure:
    result = shown(results)
    figure, axes = plt.subplot_mosaic([["signal", "signal"], ["offset", "offset"], ["point", "interval"]],
                                      figsize=(9.4, 9.2), layout="constrained")
    _draw_signal(axes["signal"], result.record)
    _draw_offsets(axes["offset"], result)
    _draw_point(axes["point"], result)
    _draw_interval(axes["interval"], result)
    return figure


def _draw_signal(axis: Any, record: Record) -> None:
    rows, ahead = np.arange(ROWS), ROWS + np.arange(FAR)
    axis.plot(record.truth, color="black", lw=1, label="signal")
    axis.plot(record.z[:ROWS], ".", color=GREY, ms=4, label="measured")
    axis.plot(rows, record.filtered, color=BLUE, lw=1, ls="--", label="filtered")
    for at, mean, sigma, colour, label in ((rows, record.smoothed, record.smoothed_sigma, ORANGE, "smoothed, 95 %"),
                                           (ahead, record.ahead, record.ahead_sigma, GREEN, "predicted, 95 %")):
        axis.fill_between(at, mean - 1.96 * sigma, mean + 1.96 * sigma, color=colour, alpha=0.18, lw=0)
        axis.plot(at, mean, color=colour, lw=1.3, label=label)
    low, high = axis.get_ylim()
    axis.set(xlabel="row", ylabel="signal", ylim=(low, high + 0.25 * (high - low)),
             title="One record: the smoothed signal does not trail behind as the filtered one does")
    axis.legend(loc="upper left", ncols=5)


def _draw_offsets(axis: Any, result: Result) -> None:
    lag, horizon = np.arange(FAR + 1), np.arange(1, FAR + 1)
    sigma = np.concatenate([result.lag.sigma[::-1], result.horizon.sigma])
    axis.plot(np.arange(-FAR, FAR + 1), sigma, color="black", lw=1.2, label="theory")
    axis.axhline(result.interval.sigma[POINT], color=ORANGE, lw=1, ls=":", label="fixed interval, amid the record")
    _errors(axis, -lag[1:], result.lag, slice(1, None), PURPLE, "s", "fixed lag")
    _errors(axis, horizon, result.horizon, slice(None), GREEN, "^", "prediction")
    _errors(axis, np.zeros(1), result.lag, slice(0, 1), BLUE, "o", "filter")
    axis.set(xlabel="rows from the last measurement to the estimated one", ylabel="rms error", ylim=(0, None),
             title="A few rows of lag are worth most of a smoother's gain; what is ahead is ever less known")
    axis.legend(loc="upper left", ncols=2)


def _errors(axis: Any, at: np.ndarray, of: Estimates, part: slice, colour: str, mark: str, label: str) -> None:
    axis.errorbar(at, of.rms[part], 2 * of.standard_error[part], color=colour, marker=mark, ms=3.4, lw=0,
                  elinewidth=0.9, label=f"{label}, ± 2 standard errors")


def _draw_point(axis: Any, result: Result) -> None:
    rows = np.arange(POINT, ROWS)
    axis.plot(rows, result.point.sigma, color="black", lw=1.2)
    _errors(axis, rows, result.point, slice(None), PURPLE, "s", "fixed point")
    axis.set(xlabel="last row that is measured", ylabel=f"rms error of row {POINT}", ylim=(0, None),
             title="Fixed point: one row is ever better known")
    axis.legend(loc="lower left")


def _draw_interval(axis: Any, result: Result) -> None:
    rows = np.arange(ROWS)
    for of, colour, mark, label in ((result.filtered, BLUE, "o", "filter"),
                                    (result.interval, ORANGE, "D", "fixed interval")):
        axis.plot(rows, of.sigma, color="black", lw=1.2)
        axis.errorbar(rows, of.rms, 2 * of.standard_error, color=colour, marker=mark, ms=2.6, lw=0, elinewidth=0.6,
                      label=label)
    axis.set(xlabel="row", ylabel="rms error", ylim=(0, None),
             title="Fixed interval: worth most amid the record")
    axis.legend(loc="lower left", ncols=2)


EXAMPLE = Example("fixed-lag, fixed-point and fixed-interval smoothing and prediction on one signal", compute, numbers,
                  distance, draw)
