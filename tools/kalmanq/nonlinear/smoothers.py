"""Smoothers of nonlinear models: every row given all rows, and passes that linearise at the last one's states."""

from __future__ import annotations

import warnings
from typing import Any, Callable, Optional

import numpy as np
from numpy.typing import ArrayLike

from kalmanq.core import ffi, lib, require, warn_of
from kalmanq.errors import KalmanqError, KalmanqWarning
from kalmanq.model.spellings import OfModel, require_model, spelled
from kalmanq.nonlinear import methods
from kalmanq.nonlinear.filters import ITERATIONS, NonlinearFilter, parts_of, refuse_method, rows_at
from kalmanq.nonlinear.model import NonlinearModel
from kalmanq.nonlinear.objective import objective
from kalmanq.run.parts import Parts
from kalmanq.run.filters import refuse_jump
from kalmanq.run.readings import Readable
from kalmanq.run.results import Run
from kalmanq.run.robust import Robust

SETTLED = 0.01  # sigma: no mean moves by more
HALVINGS = 4
# What the objective may rise by with sigma points.  Jacobians go down on it; states by sigma points are means, which
# are near its minimum, not at it.  1 is what a sigma along one direction of all the run makes.
POINTS_MAY_RISE = 1.0


class NonlinearSmoother(OfModel):
    """Of a recorded run: mean and covariance of every row given all rows.

    After a run: `passes_done`, `is_settled` (no mean moved by more than 0.01 sigma), `objectives` (one for each pass),
    `halvings`.  What the run says of the filter is that of the first pass.

    Parameters
    ----------
    model : NonlinearModel
    arithmetic, method, iterations : as of NonlinearFilter
    passes : 1: the Rauch-Tung-Striebel smoother of the filter's linearisations.  More: each further pass linearises
        f and h at the smoothed states of the last one, by Jacobians ("extended", "iterated") or by sigma points
        of the smoothed densities (sigma_points.h, with its step rule).  Noises that are functions stay as in the first

    Raises
    ------
    KalmanqError
        passes below 1, and what a NonlinearFilter refuses

    Examples
    --------
    >>> run = kalmanq.NonlinearSmoother(kalmanq.NonlinearModel(lambda x: x, lambda x: [x[0] ** 2], Q=0.01, R=0.1, x0=[2.0], P0=[1.0]), passes=6).run([4.0, 4.1, 4.0])
    >>> run.smoothed.round(2).ravel()
    array([2.01, 2.01, 2.01])
    """

    @spelled("NonlinearSmoother(model, arithmetic, method)")
    def __init__(self, model: NonlinearModel, arithmetic: str = "f64", method: str = "extended",
                 iterations: int = ITERATIONS, passes: int = 1):
        require_model(model, NonlinearModel, "Filter and Smoother take it")
        refuse_method(method, iterations, arithmetic)
        if passes < 1:
            raise KalmanqError("passes: below 1")
        self.model, self.parts = model, parts_of(model, arithmetic)
        self.method, self.iterations, self.passes = method, iterations, passes
        self.last: Optional[NonlinearFilter] = None  # the filter at the end of the last run
        self.passes_done, self.halvings, self.is_settled = 0, 0, False
        self.objectives: list[float] = []

    @spelled("run(z, u)")
    def run(self, z: ArrayLike, u: Optional[ArrayLike] = None, *, times: Optional[ArrayLike] = None,
            robust: Optional[Robust] = None, covariance: bool = False) -> Run:
        """As NonlinearFilter.run.  `covariance`: those of all rows, too.

        robust  gate, huber, student; with one pass: what further passes minimise is of Gaussian noise
        """
        refuse_jump(robust)
        if robust is not None and self.passes > 1:
            raise KalmanqError("passes: further ones are of Gaussian noise: take one, or leave robust out")
        given = rows_at(self.model, z, u, times)
        rows, controls = given.z, given.u
        self._times, self._noises = given.times, {}
        recording = self._recording(len(rows), None)
        run = recording.run(given, robust=robust, covariance=covariance)
        self.last = recording
        self.passes_done, self.halvings, self.is_settled, self.objectives = 1, 0, self.passes == 1, []
        if len(rows):
            recording.smooth(run, covariance)
            if self.passes > 1:
                self._iterate(run, recording, rows, controls, covariance)
        return run

    def _recording(self, rows: int, way: Any) -> _Recording:
        return _Recording(self.model, self.parts, self.method, self.iterations, rows, way, self._noises)

    def _iterate(self, run: Run, recording: _Recording, z: np.ndarray, u: np.ndarray, covariance: bool) -> None:
        """Passes until the states settle; `run` has the smoothed states of the best one."""
        at = Densities(recording, run, self.method)
        value = best = self._value(at.means, z, u)
        self.objectives.append(value)
        while self.passes_done < self.passes and not self.is_settled:
            made, found = self._pass(at, z, u, covariance)
            reached = self._value(found.means, z, u)
            self.objectives.append(reached)
            self.is_settled = settled(made, at.means)
            if reached <= best + at.may_rise or self.is_settled:
                best = min(best, reached)
                keep_smoothed(run, made)
            if reached > value + at.may_rise and not self.is_settled:
                reached = self._halve(at.means, found, value, z, u)
                if reached > value:
                    break
            at, value = found, reached
        if self.halvings and not self.is_settled:
            warnings.warn(f"{self.model.name}: the iterated smoother goes the wrong way and does not settle: the model "
                          "may have more than one solution; an x0 that is nearer may help", KalmanqWarning, stacklevel=3)

    def _pass(self, at: Densities, z: np.ndarray, u: np.ndarray, covariance: bool) -> tuple[Run, Densities]:
        recording = self._recording(len(z), at.way())
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", KalmanqWarning)  # told once, of the pass that is kept
            made = recording.run(z, u if self.model.l else None, times=self._times)
        recording.smooth(made, covariance)
        self.passes_done += 1
        return made, Densities(recording, made, self.method)

    def _halve(self, before: np.ndarray, after: Densities, value: float, z: np.ndarray, u: np.ndarray) -> float:
        """Moves `after` back by half of the way, and by half of that ..., until it is as good as before"""
        reached = float("inf")
        for _ in range(HALVINGS):
            self.halvings += 1
            after.move_to((before + after.means) / 2)
            reached = self._value(after.means, z, u)
            if reached <= value:
                break
        return reached

    def _value(self, means: np.ndarray, z: np.ndarray, u: np.ndarray) -> float:
        """Infinite where the functions cannot be evaluated"""
        with np.errstate(all="ignore"):
            try:
                value = objective(self.model, means, z, u, self.model.instants(len(z), self._times), self._noises)
            except KalmanqError:
                return float("inf")
        return value if np.isfinite(value) else float("inf")


def settled(run: Run, before: np.ndarray) -> bool:
    sigma = np.where(run.smoothed_sigma > 0, run.smoothed_sigma, np.inf)  # what has none stays, or is rounding
    return bool(np.max(np.abs(run.smoothed - before) / sigma) <= SETTLED)


def keep_smoothed(run: Run, made: Run) -> None:
    run.smoothed, run.smoothed_sigma = made.smoothed, made.smoothed_sigma
    run.smoothed_covariance = made.smoothed_covariance
    warn_of(made.events & ~run.events, f"{run.model.name}, {run.arithmetic}, a pass of the smoother")
    run.events |= made.events
    run.words.update({name: words for name, words in made.words.items() if name.startswith("smoothed")})


class _Recording(NonlinearFilter):
    """A filter with a history of so many rows.  `way`: how it linearises, where that is not its method's; noises: of rows of
    passes before, which stay"""

    def __init__(self, model: NonlinearModel, parts: Parts, method: str, iterations: int, rows: int, way: Any,
                 noises: dict[tuple[str, int, int], Any]):
        super().__init__(model, parts.arithmetic.name, method, iterations, parts=parts)
        self.way, self.noises = way or self.way, noises
        n, m, rows = model.n, model.m, max(rows, 1)
        self._history = self._object("history", n, sizes=(n, m, rows, rows))
        a = self.arithmetic
        self._processes = ffi.new(f"kq_process_{a.name}[]", rows)
        memory = a.empty(self._jacobian_words(rows))
        self._kept.append(memory)
        self._jacobians = a.struct("jacobians")
        require(a.function("jacobians_assign")(self._jacobians, self._history, n, self._processes, rows,
                                               self._pointer(memory), memory.size), "jacobians")
        self._attach(self._jacobians, "history")

    def noise(self, key: str, make: Callable[[], Any], sensor: int = 0) -> Any:
        at = key, self.row, sensor
        self.noises[at] = self.noises[at] if at in self.noises else make()
        return self.noises[at]

    def _jacobian_words(self, rows: int) -> int:
        """KQ_JACOBIANS_LEN, with another noise at each predict"""
        n = self.model.n
        if self.arithmetic.is_fixed:
            return rows * (2 * n * n + int(lib.kq_length_q31(lib.KQ_OBJECT_ROOT, n, 0, 0, 0)))
        return rows * (n * n + n * (n + 1) // 2)

    def smooth(self, run: Run, covariance: bool) -> None:
        require(self.arithmetic.function("smooth")(self._history), "smoother")
        self.read_smoothed(run, "history", self._history, covariance)
        run.events |= self.smoothing_events(self._history)


class Densities:
    """The smoothed rows of a pass, to linearise at: means, and by sigma points the C core's densities."""

    def __init__(self, recording: _Recording, run: Run, method: str):
        self.means = run.smoothed
        self.rule = "central" if method == "central" else "cubature" if method in methods.BY_POINTS else None
        self.may_rise = POINTS_MAY_RISE if self.rule else 0.0
        self._filters: list[Readable] = []
        for t in range(len(run) if self.rule else 0):
            a, made = recording.arithmetic, Readable(recording.model, recording.parts)
            view = a.struct("filter")
            require(a.function("smoothed")(recording._history, t, view), "smoothed row")
            require(a.function("filter_copy")(made._handle, view), "smoothed row")
            self._filters.append(made)

    def move_to(self, means: np.ndarray) -> None:
        for t, filter_ in enumerate(self._filters):
            a = filter_.arithmetic
            d = np.ascontiguousarray(means[t] - self.means[t], a.number)
            require(a.function("move")(filter_._handle, a.pointer(d)), "move")
        self.means = means

    def way(self) -> Any:
        if self.rule is None:
            return methods.AtMeans(self.means)
        return methods.AtDensities([one._handle for one in self._filters], self.rule)
