"""What a run over a sequence leaves: arrays of float64, a row a row of data."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Optional

import numpy as np

from kalmanq.core import ASKED_FOR, EVENTS, lib, names_of
from kalmanq.errors import counted
from kalmanq.model import Model
from kalmanq.model.spellings import Spelled

Array = Any  # an np.ndarray; None where it was not asked for


_OF_STATES = ("mean", "sigma", "smoothed", "smoothed_sigma", "lagged", "lagged_sigma", "instant", "instant_sigma")
_COVARIANCES = ("covariance", "smoothed_covariance", "instant_covariance")
_OF_MEASUREMENTS = ("innovation", "innovation_sigma", "fed")
_OF_ROWS = ("nis", "taken", "log_likelihood", "settled", "weights")


def _few(names: list[str]) -> str:
    return ", ".join(names[:4] + ["..."] * (len(names) > 4))


@dataclass
class Run(Spelled):
    """Of T rows, n states, m measurements, in their units.  What was not asked for is None; what is unknown is NaN.

    Attributes
    ----------
    model, arithmetic, words : what it is of, and raw values as the chip has them
    mean, sigma : T x n, after the update; covariance: T x n x n
    innovation : T x m, z - H x before the update; innovation_sigma: its standard deviation (a Student-t step shows none)
    nis : T, e' S^-1 e of what was taken or, where nothing is, of what was rejected; NaN where nothing was measured; `taken`: degrees of freedom
    log_likelihood : T, each row's term; 0 where nothing was taken
    smoothed, smoothed_sigma, smoothed_covariance : given all rows
    lagged, lagged_sigma : of `lag` rows before, given all rows so far; NaN in the first `lag` rows
    instant, instant_sigma, instant_covariance : of the row `instant_row`, given all rows so far; NaN before it
    settled : T, of a freeze: did the row move the mean alone?
    scales : T x 2: of Q and R, of an adaptation
    weights : T: of Q in the step to each row, by which a reweighted smoother smoothed
    fed : T x m: D u of each row, of a model that has D, or d from columns
    events : the core's events, ORed; `event_names` in words; `faults`: those that nobody asked for
    index : the index of the data, if it had one: `to_frame()` is a DataFrame

    Examples
    --------
    >>> run = kalmanq.Filter(kalmanq.Model([1], H=[1], R=1, Q=1, P0=1)).run([1.0, np.nan, 2.0])
    >>> run.mean.shape, run.innovation.shape, run.nis.shape, len(run), run.event_names
    ((3, 1), (3, 1), (3,), 3, [])
    """

    model: Model
    arithmetic: str
    mean: np.ndarray
    sigma: Array = None
    covariance: Array = None
    innovation: Array = None
    innovation_sigma: Array = None
    nis: Array = None
    taken: Array = None
    log_likelihood: Array = None
    smoothed: Array = None
    smoothed_sigma: Array = None
    smoothed_covariance: Array = None
    lag: Optional[int] = None
    lagged: Array = None
    lagged_sigma: Array = None
    instant_row: Optional[int] = None
    instant: Array = None
    instant_sigma: Array = None
    instant_covariance: Array = None
    settled: Array = None
    scales: Array = None
    weights: Array = None
    events: int = 0
    index: Any = None
    fed: Array = None
    words: dict[str, np.ndarray] = field(default_factory=dict, repr=False)  # as the chip has them

    def __repr__(self) -> str:
        """In 10 lines at most: what is there, with shapes, and the last row"""
        n, m, rows = self.model.n, self.model.m, " of ".join([f"{len(self)} series"] * (self.mean.ndim - 2) + [counted(self.mean.shape[-2], "row")])
        lines = [f"Run of {self.model.name}, {self.arithmetic}: {rows}, {counted(n, 'state')}, {counted(m, 'measurement')}"]
        for what, names in ((self.model.states, _OF_STATES), ((), _COVARIANCES), (self.model.measurements, _OF_MEASUREMENTS), ((), _OF_ROWS), ((), ("scales",))):
            there = [name for name in names if getattr(self, name) is not None]
            if there:
                shape = " x ".join(map(str, getattr(self, there[0]).shape))
                lines.append(f"  {shape:<12} {', '.join(there)}{f' of {_few([one.label for one in what])}' if what else ''}")
        if self.log_likelihood is not None:
            lines.append(f"  log_likelihood.sum() = {np.sum(self.log_likelihood):.6g}")
        if self.mean.size:
            sigma = [""] * n if self.sigma is None else [f" +- {one:.3g}" for one in self.sigma.reshape(-1, n)[-1]]
            last = zip(self.model.states, self.mean.reshape(-1, n)[-1], sigma)
            lines.append("  at the end   " + _few([f"{s.name} = {x:.6g}{e}{s.unit and ' ' + s.unit}" for s, x, e in last]))
        return "\n".join([*lines, f"  events       {', '.join(self.event_names) or 'none'}"])

    def __len__(self) -> int:
        return len(self.mean)

    @property
    def event_names(self) -> list[str]:
        return names_of(self.events)

    @property
    def faults(self) -> list[tuple[str, str]]:
        """Events that are no wish of the caller's: name, and what it means"""
        return [(name, meaning) for bit, (name, meaning) in EVENTS.items() if self.events & bit & ~ASKED_FOR]

    @property
    def is_held(self) -> bool:
        """Did something saturate?"""
        return bool(self.events & lib.KQ_EVENT_SATURATED)

    def columns(self) -> dict[str, np.ndarray]:
        """By the names that a table has: NAME_mean, NAME_sigma, NAME_smoothed, ..."""
        made: dict[str, np.ndarray] = {}
        for i, state in enumerate(self.model.states):
            for suffix, array in (("mean", self.mean), ("sigma", self.sigma), ("smoothed", self.smoothed),
                                  ("smoothed_sigma", self.smoothed_sigma), ("lagged", self.lagged),
                                  ("instant", self.instant), ("instant_sigma", self.instant_sigma)):
                if array is not None:
                    made[f"{state.name}_{suffix}"] = array[:, i]
        if self.innovation is not None:
            for c, measurement in enumerate(self.model.measurements):
                made[f"{measurement.name}_innovation"] = self.innovation[:, c]
        if self.nis is not None and self.log_likelihood is not None:
            made["nis"], made["loglik"] = self.nis, self.log_likelihood
        return made

    def to_frame(self) -> Any:
        """A pandas DataFrame of the columns, with the data's index."""
        import pandas

        return pandas.DataFrame(self.columns(), index=self.index)
