"""Filters of nonlinear models: the C core's, asked as a firmware asks it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Callable, Optional

import numpy as np
from numpy.typing import ArrayLike

from kalmanq.core import NOT_A_VALUE, require, warn_of
from kalmanq.data.dates import step_from
from kalmanq.data.rows import Rows, index_of, refuse_back, require_one_origin, rising, row_of, rows_of, times_in
from kalmanq.errors import KalmanqError
from kalmanq.model.spellings import require_model, spelled
from kalmanq.nonlinear import methods
from kalmanq.nonlinear.calls import Instant
from kalmanq.nonlinear.model import NOTHING, NonlinearModel, Sensor
from kalmanq.nonlinear.steps import Steps
from kalmanq.run.parts import Parts
from kalmanq.run.readings import Readable, Results
from kalmanq.run.results import Run
from kalmanq.run.robust import Losses, Robust

ITERATIONS = 4


class NonlinearFilter(Readable):
    """A filter of a nonlinear model in one arithmetic, before the first measurement.

    Parameters
    ----------
    model : NonlinearModel; its functions are called in float64, the core takes what they answer as the arithmetic's numbers
    arithmetic : "f64", "f32" or "q31" (extended and iterated): bit for bit what the chip makes of them
    method : "extended": Jacobians at the mean; "iterated": h linearised where the update comes out, too;
        "cubature", "central": sigma points; "posterior": sigma points of where the update comes out
    iterations : of "iterated" and "posterior", for each update
    parts : `parts` of another filter of this model and arithmetic, to be shared

    Raises
    ------
    KalmanqError
        another method, a function without a number, what the core refuses; of a sequence with its row

    Examples
    --------
    >>> f = kalmanq.NonlinearFilter(kalmanq.NonlinearModel(lambda x: x, lambda x: [x[0] ** 2], Q=0.01, R=0.1, x0=[2.0], P0=[1.0]), method="cubature")
    >>> f.update(4.0); f.predict()          # one row at a time; f.predict(u, dt=0.3): of rows at their times
    >>> f.run([4.0, np.nan]).mean.round(1).ravel()    # or a sequence, which may be called again for more
    array([1.9, 1.9])
    """

    @spelled("NonlinearFilter(model, arithmetic, method)")
    def __init__(self, model: NonlinearModel, arithmetic: str = "f64", method: str = "extended",
                 iterations: int = ITERATIONS, *, parts: Optional[Parts] = None):
        require_model(model, NonlinearModel, "Filter and Smoother take it")
        if model.has_errors:
            raise KalmanqError("a model of error states is run by its C: kalmanq run --compiled")
        super().__init__(model, parts or parts_of(model, arithmetic))
        refuse_method(method, iterations, arithmetic)
        self.method, self.iterations = method, iterations
        self.way = methods.METHODS[method](iterations)
        self.steps = Steps(model, self.parts)
        self.row, self.begins, self.is_timed = 0, True, False
        self.origin: Optional[np.datetime64] = None  # that t counts from, where times are dates
        self.at = model.at_row(0)  # t of this row
        self._left = NOTHING  # controls of the last row
        self._trial: Optional[Readable] = None
        self._losses = Losses(self.arithmetic, [one.m for one in model.sensors])
        self.parts.init_filter(self._handle)

    @property
    def trial(self) -> Readable:
        """A filter to linearise at"""
        if self._trial is None:
            self._trial = Readable(self.model, self.parts)
        return self._trial

    def copy_to(self, other: Readable) -> None:
        require(other._call("filter_copy", self._handle), "copy")

    def number_of_mean(self, handle: Any) -> np.ndarray:
        """The mean as one number a state: in f32 without its low part, which no sigma point has."""
        return self._values(self._words("mean", handle))

    # ------------------------------------------------------------------ rows

    def predict(self, u: Optional[ArrayLike] = None, dt: Optional[float] = None) -> None:
        """To the next row; u: l controls of the row that is left; dt: to the next row, where rows have times: seconds, or a duration"""
        dt = None if dt is None else step_from(dt, 1.0)
        self._move(self._controls(u), self.model.dt if dt is None and self.is_timed else dt, None if dt is None else self.at + dt)

    def _move(self, u: np.ndarray, dt: Optional[float], to: Optional[float]) -> None:
        """to: the time of the next row, if it has one"""
        if self.is_timed and dt is None:
            raise KalmanqError("dt is missing: the rows before have times")
        t = self.at if dt is None else Instant(self.at, dt)
        if self.model.G is self.model.Q is None:
            self.steps.take(self.noise("Q", lambda: self.model.process_noise(self.mean, t, u)))
        self.way.predict(self, t, u)
        self.row, self.begins, self.is_timed = self.row + 1, False, dt is not None
        self.at = self.model.at_row(self.row) if dt is None else Instant(self.at + dt if to is None else to)

    def noise(self, key: str, make: Callable[[], Any], sensor: int = 0) -> Any:
        """Of this row, at the mean; sensor: whose update it is of"""
        return make()

    def update(self, z: ArrayLike, u: Optional[ArrayLike] = None, robust: Optional[Robust] = None) -> None:
        """Takes m measurements; what is NaN is missing.  u: l controls of this row."""
        self._take(row_of(z, self.model.m, "z")[0], self._controls(u), robust)

    @spelled("run(z, u)")
    def run(self, z: ArrayLike, u: Optional[ArrayLike] = None, *, times: Optional[ArrayLike] = None,
            robust: Optional[Robust] = None, covariance: bool = False) -> Run:
        """A sequence: the first row ever is taken at the prior's instant, a predict comes before each other one.

        Parameters
        ----------
        z : T x m, or T where m = 1; NaN: missing.  Or a DataFrame with a column for each measurement
        u : T x l: row t is given to h at row t, and to f from row t to row t + 1
        times : T: when each row is, in seconds, or dates or durations; t is that then (seconds since the first date), and dt the time to
            the next row.  None: what the index of a table says, where functions read t or dt
        robust : of the innovation, linearised as the method has it; each sensor has a gate of its own
        covariance : those of all rows, too

        Raises
        ------
        KalmanqError
            says at which row it stopped
        """
        given = rows_at(self.model, z, u, times, self.origin)
        rows, controls = given.z, given.u
        out, variances = Results(self, len(rows), covariance), np.full((len(rows), self.model.m), np.nan)
        at = self._times(given)
        for row in range(len(rows)):
            try:
                if not self.begins:
                    self._move(self._left, None if at is None else at[row] - self.at, None if at is None else at[row])
                elif at is not None:
                    self.at = Instant(at[row])
                self.begins = False
                self._left = controls[row]
                self._record(out, variances, row, self._take(rows[row], controls[row], robust))
            except KalmanqError as problem:
                raise KalmanqError(str(problem), problem.status, row) from problem
        made = out.run()
        made.innovation_sigma = np.sqrt(variances)
        made.index = given.index
        warn_of(made.events, f"{self.model.name}, {self.arithmetic.name}")
        self.warn_of_wide()
        return made

    def _times(self, rows: Rows) -> Optional[np.ndarray]:
        at = rows.times
        if at is not None and not self.begins and not self.is_timed and self.row:
            raise KalmanqError("times: the rows before had none")
        if at is None and self.is_timed:
            raise KalmanqError("times are missing: the rows before had them")
        if self.is_timed and not self.begins:
            require_one_origin(self.origin, rows.origin)
        if at is not None and len(rows) and not self.begins:
            refuse_back(at[:1] - self.at, self.model.has_empty_steps)
        self.is_timed, self.origin = at is not None, rows.origin
        return at

    def _controls(self, u: Optional[ArrayLike]) -> np.ndarray:
        if self.model.l == 0:
            return NOTHING
        if u is None:
            raise KalmanqError(f"u is missing: {', '.join(one.name for one in self.model.controls)}")
        return row_of(u, self.model.l, "u")[0]

    def _take(self, z: np.ndarray, u: np.ndarray, robust: Optional[Robust]) -> Optional[Taken]:
        """The sensors one after the other.  None: nothing is there."""
        made = None
        for sensor in self.model.sensors:
            some = np.full(len(z), np.nan)
            some[sensor.rows] = z[sensor.rows]
            taken = self._take_of(some, u, sensor, robust)
            made = made.joined(taken) if made and taken else made or taken
        return made

    def _take_of(self, z: np.ndarray, u: np.ndarray, sensor: Sensor, robust: Optional[Robust]) -> Optional[Taken]:
        there = ~np.isnan(z)
        if not np.any(there):
            return None
        if self.arithmetic.is_fixed:
            variance = np.ldexp(np.diag(self.covariance), 2 * np.array(self.parts.fractions("states")))
            self._widest = np.fmax(self._widest, variance)
        if self.model.R is None:
            self.steps.take({"R": self.noise("R", lambda: self.model.measurement_noise(self.mean, self.at, u), sensor.first)})
        self.steps.loss = self._loss(robust, sensor, there)
        prepared = self.way.update(self, z, self.at, u)
        variances = self._variances(prepared.sensor)
        words = self.steps.update(self._handle, prepared, z)
        lost = NOT_A_VALUE if self.arithmetic.is_fixed else np.nan
        return Taken(there, np.where(there, words, lost), np.where(there, variances, np.nan), self._call("nis"),
                     self._call("log_likelihood_last"), self.taken)

    def _loss(self, robust: Optional[Robust], sensor: Sensor, there: np.ndarray) -> Any:
        """A gate's limit is that of the components which the row has."""
        if robust is None:
            return None
        made = self._losses.of(robust)
        if made.limits is None:
            return made.losses
        gate = made.losses + self.model.sensors.index(sensor)
        gate.limit = made.limits[np.count_nonzero(there) - 1]
        return gate

    def _variances(self, sensor: Any) -> np.ndarray:
        """Of the innovation: the diagonal of S"""
        m, a = self.model.m, self.arithmetic
        z, S = a.empty(m), np.zeros((m, m), a.number_of_any_size)
        require(self._call("measurement", sensor, self._pointer(z), self._pointer(S, self._any_size)), "measurement")
        return a.numbers(np.diag(S), 2 * np.array(self.parts.fractions("measurements")))

    def _record(self, out: Results, variances: np.ndarray, row: int,
                taken: Optional[Taken]) -> None:
        for name in ("mean", "mean_low", "sigma"):
            if name in out.numbers:
                out.numbers[name][row] = self._words(name)
        full = np.zeros((self.model.n, self.model.n), self.arithmetic.number_of_any_size)
        if out.any_size.keys() & {"covariance", "variance"}:
            require(self._call("covariance", self._pointer(full, self._any_size)), "covariance")
        if "covariance" in out.any_size:
            out.any_size["covariance"][row] = full
        if "variance" in out.any_size:
            out.any_size["variance"][row] = np.diag(full)
        no_score = np.iinfo(np.int64).min if self.arithmetic.is_fixed else np.nan
        out.numbers["innovation"][row] = NOT_A_VALUE if self.arithmetic.is_fixed else np.nan
        out.scores["nis"][row] = no_score
        if taken is not None:
            out.numbers["innovation"][row], variances[row] = taken.words, taken.variances
            out.scores["nis"][row], out.scores["log_likelihood"][row] = taken.nis, taken.log_likelihood
            out.taken[row] = taken.count


@dataclass(frozen=True)
class Taken:
    """Of an update: what was there, words of the innovation, its variances before, scores of the core, components taken"""

    there: np.ndarray
    words: np.ndarray
    variances: np.ndarray
    nis: float
    log_likelihood: float
    count: int

    def joined(self, other: Taken) -> Taken:
        """With the sensor after it; the NIS of what was rejected is that of a row of which nothing is taken"""
        words, variances = (np.where(other.there, two, one) for one, two in
                            ((self.words, other.words), (self.variances, other.variances)))
        counted = [one for one in (self, other) if one.count] or [self, other]
        return Taken(self.there | other.there, words, variances, sum(one.nis for one in counted),
                     self.log_likelihood + other.log_likelihood, self.count + other.count)


def extended_run(model: NonlinearModel, arithmetic: str, z: np.ndarray, u: Optional[np.ndarray],
                 times: Optional[np.ndarray] = None) -> Run:
    """From the start, with covariances"""
    return NonlinearFilter(model, arithmetic).run(z, u, times=times, covariance=True)


def parts_of(model: NonlinearModel, arithmetic: str) -> Parts:
    return Parts(model.frame, arithmetic)


def refuse_method(method: str, iterations: int, arithmetic: str) -> None:
    if method not in methods.METHODS:
        raise KalmanqError(f"there is no method {method!r}: {', '.join(methods.METHODS)}")
    if arithmetic == "q31" and method in methods.BY_POINTS:
        raise KalmanqError(f"{method}: sigma points are not in q31, which takes extended and iterated")
    if iterations < 1:
        raise KalmanqError("iterations: below 1")


def rows_at(model: NonlinearModel, z: Any, u: Any = None, times: Any = None, origin: Optional[np.datetime64] = None) -> Rows:
    """Looked at; they are then as they are.  origin: of rows before"""
    if isinstance(z, Rows):
        return z
    made, index = rows_of(z, model.measurements, "z"), index_of(z, u)
    if times is None and index is not None:
        times = times_in(model, z, u)
    at, begun = (None, None) if times is None else rising(times, len(made), 1.0, origin, model.has_empty_steps)
    return Rows(made, controls_of(u, model, len(made)), at, {}, index, begun)


def controls_of(u: Any, model: NonlinearModel, rows: int) -> np.ndarray:
    """T x l; none: T x 0"""
    if model.l == 0:
        if u is not None and np.shape(u) != (rows, 0):
            raise KalmanqError("u: the model has no controls")
        return np.zeros((rows, 0))
    if u is None:
        raise KalmanqError(f"u is missing: {', '.join(one.name for one in model.controls)}")
    made = rows_of(u, model.controls, "u")
    if len(made) != rows:
        raise KalmanqError(f"u has {len(made)} rows, z has {rows}")
    wrong = np.argwhere(~np.isfinite(made))
    if len(wrong):
        row, column = map(int, wrong[0])
        raise KalmanqError(f"{model.controls[column].name}: a control is missing", row=row)
    return made
