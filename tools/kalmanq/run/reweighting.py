"""A smoother for states that jump: the noise of each step is reweighted by what all rows say of it (robust.h)."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Optional

import numpy as np
from numpy.typing import ArrayLike

from kalmanq.core import require
from kalmanq.data.rows import Rows, require_steps
from kalmanq.errors import KalmanqError
from kalmanq.model import Model
from kalmanq.model.spellings import OfModel, require_model, spelled
from kalmanq.run.filters import Filter, _Recording
from kalmanq.run.parts import Parts
from kalmanq.run.readings import Results
from kalmanq.run.results import Run


class ReweightedSmoother(OfModel):
    """A smoother with Student-t process noise, for states that jump: fixed-interval passes, each with the weights of the one before.

    What a run says of the filter (mean, sigma, log-likelihood) is the plain filter's; outliers become jumps.  `weights` (T): of Q.

    Parameters
    ----------
    model : Model of steps, whose start is known
    arithmetic : "f64", "f32" or "q31"
    nu : degrees of freedom, above 0: the fewer, the more often it jumps
    passes : 1 or more; from a first weight of 16, more than five do not gain
    first : the weight of Q at every step of the first pass: from 1, large jumps are found slowly

    Raises
    ------
    KalmanqError
        an unknown start, passes below 1, and what a Smoother refuses

    Examples
    --------
    >>> model = kalmanq.Model([1], H=[1], R=1, Q=0.01, P0=1)
    >>> run = kalmanq.ReweightedSmoother(model).run([0.0] * 20 + [9.0] * 20)
    >>> int(run.weights[1:].argmax()) + 1, run.smoothed[[19, 20]].round().ravel()
    (20, array([0., 9.]))
    """

    def __init__(self, model: Model, arithmetic: str = "f64", *, nu: float = 2.0, passes: int = 5,
                 first: float = 16.0):
        require_model(model, Model, "NonlinearSmoother takes it")
        if np.any(model.unknown):
            raise KalmanqError("a reweighted smoother needs a known start: give P0 for every state")
        if passes < 1:
            raise KalmanqError("passes: below 1")
        self.model, self.parts = model, Parts(model, arithmetic)
        self.nu, self.passes, self.first = nu, passes, first
        self.last: Optional[Filter] = None  # the plain filter at the end of the last run

    @spelled("run(z, u)")
    def run(self, z: ArrayLike, u: Optional[ArrayLike] = None, *, times: Optional[ArrayLike] = None, covariance: bool = False) -> Run:
        """As Smoother.run, of steps that are all alike."""
        rows = Rows.of(self.model, z, u, times)
        require_steps(self.model, rows.times, "a reweighted smoother", "give z without times to take each row for a step")
        rows = replace(rows, times=None)
        self.last = Filter(self.model, parts=self.parts)
        run = self.last.run(rows)
        arithmetic = self.parts.arithmetic
        weights = arithmetic.made_of(np.full(max(len(rows), 1), self.first))
        for left in reversed(range(self.passes if len(rows) else 0)):
            run.weights = arithmetic.numbers(weights.copy())
            run.weights[0] = np.nan  # no step leads to the first row
            recording = _Weighted(self.model, self.parts, rows, weights, self.nu)
            if left:
                recording.reweight()
            else:
                recording.smooth(run, covariance, means_only=False)
        return run


class _Weighted(_Recording):
    """A recorded run whose step to row t has weights[t] Q; smoothing it writes the weights of the next one."""

    def __init__(self, model: Model, parts: Parts, rows: Rows, weights: np.ndarray, nu: float):
        super().__init__(model, parts, rows)
        self._weights, self._nu = weights, nu
        self._sequence(rows)

    def _ask(self, q: Any, out: Results) -> None:
        self._scaled = self._target(q)
        q.weights = self._pointer(self._weights, self._any_size)

    def reweight(self) -> None:
        a, (target, root) = self.arithmetic, self._scaled
        require(a.function("smooth_reweighted")(
            self._history, target, self.parts.process, *([self._pointer(root)] if a.is_fixed else []),
            a.parameter(self._nu), self._pointer(self._weights[1:], self._any_size)), "reweighting")

    def _smooth(self, means_only: bool) -> None:
        self.reweight()
