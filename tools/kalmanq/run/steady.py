"""What a constant model settles to, and the filter of constant gain."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Optional

import numpy as np
from numpy.typing import ArrayLike

from kalmanq.core import ffi, lib, require
from kalmanq.data.rows import Rows, present_of, require_one_origin, require_steps, rows_of
from kalmanq.errors import KalmanqError
from kalmanq.model import Model
from kalmanq.model.spellings import OfModel, spelled
from kalmanq.run.parts import Parts
from kalmanq.run.resolution import warn_of_coarse
from kalmanq.run.results import Run


@dataclass(frozen=True)
class SteadyState:
    """What a constant model settles to: predicted, filtered: n x n, P- and P; gain: n x m; smoother_gain: n x n.

    Examples
    --------
    >>> kalmanq.steady_state(kalmanq.Model([1], H=[1], R=1, Q=1, P0=1)).gain.round(3)
    array([[0.618]])
    """

    predicted: np.ndarray
    filtered: np.ndarray
    gain: np.ndarray
    smoother_gain: np.ndarray


def steady_state(model: Model, arithmetic: str = "f64") -> SteadyState:
    """Solves the Riccati equation of a model.

    Parameters
    ----------
    model : Model
    arithmetic : "f64" or "f32"

    Returns
    -------
    SteadyState

    Raises
    ------
    KalmanqError
        in q31, and where nothing is settled to

    Examples
    --------
    >>> kalmanq.steady_state(kalmanq.Model([1], H=[1], R=1, Q=1, P0=1)).predicted.round(3)
    array([[1.618]])
    """
    if arithmetic == "q31":
        raise KalmanqError("the equation is solved in f32 or f64")
    parts = Parts(model, arithmetic)
    a, n, m = parts.arithmetic, model.n, model.m
    made = [np.zeros(shape, a.number) for shape in ((n, n), (n, n), (n, m), (n, n))]
    names = ("predicted", "filtered", "gain", "smoother_gain")
    out = ffi.new(f"kq_steady_solution_{a.name} *", dict(zip(names, map(a.pointer, made))))
    memory = parts.memory(a.length("steady_solve", n, m))
    require(a.function("steady_solve")(parts.process, parts.sensor, *memory, out), "steady state")
    return SteadyState(*(one.astype(np.float64) for one in made))


class SteadyFilter(OfModel):
    """A filter of constant gain: no covariance, and of a row all components or none.  `run` has mean and innovation.

    Parameters
    ----------
    model : Model
    arithmetic : "f64", "f32" or "q31"
    gain : n x m; None: that of the steady state

    Raises
    ------
    KalmanqError
        a row of which a part is missing, steps that are not all alike, and a gain of another shape

    Examples
    --------
    >>> kalmanq.SteadyFilter(kalmanq.Model([1], H=[1], R=1, Q=1, P0=1), gain=[[0.5]]).run([2.0, 2.0]).mean.ravel()
    array([1. , 1.5])
    """

    def __init__(self, model: Model, arithmetic: str = "f64", gain: Optional[ArrayLike] = None):
        self.model = model
        self.parts = Parts(model, arithmetic)
        self.begins, self.coarse = True, ""  # the next row is the first one; of measurements, as a Filter has it
        self._left: Optional[np.ndarray] = None  # the control of the last row
        self._last: Optional[Rows] = None  # the last row, where it has a time
        a, n, m = self.parts.arithmetic, model.n, model.m
        self._handle = a.struct("steady")
        require(a.function("steady_assign")(self._handle, n, m, *self.parts.memory(
            a.length("steady", n))), "steady filter")
        gain = steady_state(model).gain if gain is None else rows_of(gain, model.measurements, "gain")
        if gain.shape != (n, m):
            raise KalmanqError(f"gain: {gain.shape}, not {n} x {m}")
        require(a.function("steady_init")(self._handle, self.parts.process, self.parts.sensor, self._mean(),
                                          self._gain(gain), 1), "steady filter")

    def _mean(self) -> object:
        return self.parts.prior.mean if self.parts.arithmetic.is_fixed else self.parts.array(self.model.x0)

    def _gain(self, gain: np.ndarray) -> object:
        if not self.parts.arithmetic.is_fixed:
            return self.parts.array(gain)
        formats = self.parts.formats
        table = ffi.new("kq_scaled_q31[]", gain.size)
        values = ffi.new("double[]", gain.ravel().tolist())
        require(lib.kq_matrix_prepare_q31(table, values, *gain.shape, formats["states"],
                                          formats["measurements"]), "gain")
        self.parts.kept.append(table)
        return table

    def _require_steps(self, rows: Rows) -> None:
        """From the row before on"""
        times = rows.times
        if times is not None and self._last is not None:
            require_one_origin(self._last.origin, rows.origin)
            times = np.concatenate([self._last.times, times])
        require_steps(self.model, times, "a steady filter", "give z.to_numpy() to take each row for one")

    @spelled("run(z, u)")
    def run(self, z: ArrayLike, u: Optional[ArrayLike] = None) -> Run:
        """As Filter.run, of steps that are all alike: mean and innovation."""
        parts, a, n, m = self.parts, self.parts.arithmetic, self.model.n, self.model.m
        rows = Rows.of(self.model, z, u, origin=self._last.origin if self._last else None)
        self._require_steps(rows)
        given = rows.z
        present = present_of(given)
        if np.any((present != 0) & (present != (1 << m) - 1)):
            row = int(np.flatnonzero((present != 0) & (present != (1 << m) - 1))[0])
            raise KalmanqError("a steady filter takes all components of a row, or none", row=row)
        words = np.ascontiguousarray(parts.words(given, "measurements"))
        moving = None if rows.u is None else parts.words(rows.u, "controls")
        carried = parts.carried(moving, self._left, len(given))
        mean, innovation = a.empty(len(given), n), a.empty(len(given), m)
        done = ffi.new("size_t *")
        status = a.function("steady_run")(
            self._handle, len(given), a.pointer(words), a.pointer(present, "uint32_t"), a.pointer(carried),
            self.begins, a.pointer(mean), a.pointer(innovation), done)
        require(status, "the run", int(done[0]))
        warn_of_coarse(self, a.name, given)
        if len(given):
            self._last = None if rows.times is None else rows[-1:]
            self.begins = False
            self._left = None if moving is None else moving[-1]
        return Run(self.model, a.name, mean=a.values(mean, parts.fractions("states")),
                   innovation=a.values(innovation, parts.fractions("measurements")),
                   index=rows.index, words={"mean": mean, "innovation": innovation})
