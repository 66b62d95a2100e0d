"""What a run over a sequence leaves: arrays of float64, a row a row of data."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Optional

import numpy as np

from kalmanq.core import ASKED_FOR, EVENTS, lib, names_of
from kalmanq.model import Model

Array = Any  # an np.ndarray; None where it was not asked for


@dataclass
class Run:
    """Of T rows, n states, m measurements.  What was not asked for is None; what is unknown is NaN.

    mean, sigma            T x n, after the update
    covariance             T x n x n
    innovation             T x m, z - H x before the update; innovation_sigma: its standard deviation
                           (a Student-t step shows none)
    nis                    T, e' S^-1 e; NaN where nothing was taken; `taken`: degrees of freedom
    log_likelihood         T, each row's term; 0 where nothing was taken
    smoothed, smoothed_sigma, smoothed_covariance    given all rows
    lagged, lagged_sigma   of `lag` rows before, given all rows so far; NaN in the first `lag` rows
    instant, instant_sigma, instant_covariance             of the row `instant_row`, given all rows so far; NaN before it
    settled                T, of a freeze: did the row move the mean alone?
    scales                 T x 2: of Q and R, of an adaptation
    weights                T: of Q in the step to each row, by which a reweighted smoother smoothed
    events                 the core's events, ORed; `event_names` in words
    index                  the index of the data, if it had one
    fed                    T x m: D u of each row, of a model that has D, or d from columns
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
