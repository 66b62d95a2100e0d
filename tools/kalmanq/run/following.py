"""What follows a filter from a row on: one instant that is refined, and a covariance that settles."""

from __future__ import annotations

from typing import Any, Optional

import numpy as np
from numpy.typing import ArrayLike

from kalmanq.core import require
from kalmanq.data.rows import Rows, row_of
from kalmanq.errors import KalmanqError
from kalmanq.model import Model
from kalmanq.model.column_model import refuse_rows
from kalmanq.run.filters import Filter
from kalmanq.run.parts import Parts
from kalmanq.run.readings import Results
from kalmanq.run.results import Run
from kalmanq.run.robust import Robust


class InstantSmoother(Filter):
    """A filter with a fixed-point smoother: `run` has `instant`, `instant_sigma` (T x n), the state of one row given all rows so far, too.

    Parameters
    ----------
    model : Model
    row : counted from the first one ever; what is known of it must be all of the state by then.  It is begun by the `run` or
        `update` that takes that row
    arithmetic : "f64", "f32" or "q31"

    Raises
    ------
    KalmanqError
        a row below 0, and what a Filter refuses

    Examples
    --------
    >>> run = kalmanq.InstantSmoother(kalmanq.Model([1], H=[1], R=1, Q=1, P0=1), row=0).run([1.0, 2.0, 3.0])
    >>> run.instant.ravel()    # row 0, given rows 0, 0 and 1, 0 to 2
    array([0.5       , 0.8       , 0.92307692])
    """

    def __init__(self, model: Model, row: int = 0, arithmetic: str = "f64"):
        super().__init__(model, arithmetic)
        if not isinstance(row, (int, np.integer)) or row < 0:
            raise KalmanqError(f"row: {row!r} is not a whole number from 0")
        self.instant_row = row
        self._instant = self._object("instant", model.n, model.m, sizes=(model.n, model.m))
        self._follows = False

    @property
    def instant(self) -> np.ndarray:
        """n: the row's state, given all so far"""
        view = self._refine()
        return self._values(self._words("mean", view), self._words("mean_low", view))

    @property
    def instant_sigma(self) -> np.ndarray:
        view, variance = self._refine(), self._variances_of_any_size(1)
        if variance is not None:
            full = np.zeros((self.model.n, self.model.n), self.arithmetic.number_of_any_size)
            require(self.arithmetic.function("covariance")(view, self._pointer(full, self._any_size)), "instant")
            variance[0] = np.diag(full)
        return self._sigmas(self._words("sigma", view)[None], variance)[0]

    def _refine(self) -> Any:
        view = self.arithmetic.struct("filter")
        require(self.arithmetic.function("instant_smooth")(self._instant, view), "instant")
        return view

    def _ask(self, q: Any, out: Results) -> None:
        T, n = int(q.steps), self.model.n
        q.instant, q.instant_follows = self._instant, self._follows
        first = self.row + int(not q.begins)  # of this call
        q.instant_row = self.instant_row - first if self.instant_row >= first else T
        out.add_states("instant", "instant_mean")
        if "covariance" in out.any_size:
            out.any_size["instant_covariance"] = np.zeros((T, n, n), self.arithmetic.number_of_any_size)

    def _tell(self, run: Run, out: Results) -> None:
        run.instant_row = self.instant_row
        run.instant, run.instant_sigma = out.states("instant", "instant_mean")
        run.words["instant"] = run.words.pop("instant_mean")
        if "instant_covariance" in out.any_size:
            full = out.any_size["instant_covariance"]
            run.instant_covariance = self.arithmetic.numbers(full, self.parts.covariance_scale)

    def _end(self, q: Any) -> None:
        self._follows = bool(q.instant_follows)


class FrozenGainFilter(Filter):
    """A filter that leaves its covariance alone once that has settled, and begins again after a gap (steady.h).

    While it is settled, `nis` and `log_likelihood` are those of the last row before.  Rows come by `run` or `step`.

    Parameters
    ----------
    model : Model
    arithmetic : "f64", "f32" or "q31"
    bits : it has settled when a row changes no row of the covariance's root by more than 2^-bits of its norm
    parts : `parts` of another filter of this model and arithmetic, to be shared

    Raises
    ------
    KalmanqError
        robust or watched updates, and what a Filter refuses

    Examples
    --------
    >>> run = kalmanq.FrozenGainFilter(kalmanq.Model([1], H=[1], R=1, Q=1, P0=1), "f32").run(np.ones(100))
    >>> bool(run.settled[-1]), bool(run.settled[0])
    (True, False)
    """

    def __init__(self, model: Model, arithmetic: str = "f64", bits: int = 10, *, parts: Optional[Parts] = None):
        super().__init__(model, arithmetic, parts=parts)
        a, n, m = self.arithmetic, model.n, model.m
        self._settling, self._attached = a.struct("freeze"), False
        memory, gain = a.empty(self.arithmetic.length("freeze", n)), np.zeros((n, m), a.number_of_any_size)
        self._kept += [memory, gain]
        require(a.function("freeze_assign")(self._settling, n, m, self._pointer(memory), memory.size,
                                              self._pointer(gain, self._any_size)), "settling")
        require(a.function("freeze_init")(self._settling, bits), "settling")
        if not np.any(model.unknown):
            self._attach(self._settling, "settling")
            self._attached = True

    @property
    def is_settled(self) -> bool:
        """Did the last step move the mean alone?"""
        return bool(self.arithmetic.function("freeze_is_active")(self._settling))

    def release(self) -> None:
        """Back to the full filter at the next step."""
        require(self.arithmetic.function("freeze_release")(self._settling), "settling")

    def step(self, z: ArrayLike, u: Optional[ArrayLike] = None) -> None:
        """predict and update, which may rest on the gain."""
        refuse_rows(self.model, "step", "give its rows to run")
        given = row_of(z, self.model.m, "z")
        self.parts.words(given, "measurements")  # what is refused changes nothing
        controls = self.parts.pushes(u)
        self.begins, self._left = False, None if controls is None else controls[0]
        self._sequence(Rows(given))

    def run(self, z: ArrayLike, u: Optional[ArrayLike] = None, *, robust: Optional[Robust] = None, watch: Any = None,
            **given: Any) -> Run:
        if robust or watch:
            raise KalmanqError("a filter that settles takes every measurement as it is, and none is watched")
        return super().run(z, u, **given)

    def _ask(self, q: Any, out: Results) -> None:
        q.settling, q.is_settling = self._settling, self._attached
        out.settled = np.zeros(int(q.steps), np.uint8)
        q.settled = self.arithmetic.pointer(out.settled, "uint8_t")

    def _tell(self, run: Run, out: Results) -> None:
        run.settled = out.settled.astype(bool)

    def _end(self, q: Any) -> None:
        self._attached = bool(q.is_settling)
