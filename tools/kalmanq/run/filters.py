"""Filters and smoothers: the C core's, bit for bit, over arrays."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from typing import Any, Callable, Optional, Sequence

import numpy as np
from numpy.typing import ArrayLike

from kalmanq.core import ffi, lib, require, warn_of
from kalmanq.data.dates import step_from
from kalmanq.data.rows import Rows, Varying, controls_of, refuse_back, require_one_origin, row_of, rows_of
from kalmanq.errors import KalmanqError
from kalmanq.model import ColumnModel, Model
from kalmanq.model.column_model import refuse_rows
from kalmanq.model.columns import OF_STEP
from kalmanq.model.spellings import OfModel, require_model, spelled
from kalmanq.run.one_row import OneRow
from kalmanq.run.parts import Parts
from kalmanq.run.readings import Readable, Results
from kalmanq.run.resolution import warn_of_coarse
from kalmanq.run.results import Run
from kalmanq.run.robust import Losses, Robust
from kalmanq.run.steps import Steps


class Filter(Readable):
    """A filter of a model in one arithmetic, before the first measurement.

    Readings are float64 in the units of the states: `mean`, `sigma` (n), `covariance` (n x n), `nis`, `taken`, `log_likelihood`, `events`,
    `memory`; `time`: of the last row, where rows have times; it counts from `origin` where these are dates.

    Parameters
    ----------
    model : Model
    arithmetic : "f64", "f32" or "q31": bit for bit what the chip computes
    way : of f32 and q31, "lean", "tables", "init" or "sizes": as in the C file that `design` writes in that way
    parts : `parts` of another filter of this model and arithmetic, to be shared

    Raises
    ------
    KalmanqError
        what the core refuses, in a line

    Examples
    --------
    >>> f = kalmanq.Filter(kalmanq.Model([1], H=[1], R=1, Q=1, P0=1), "f32")
    >>> f.update(2.0); f.predict(); f.update(np.nan)    # one row at a time; NaN: missing
    >>> f.mean, f.run([3.0, 4.0]).mean.shape            # or a sequence in one call, which may be called again for more
    (array([1.]), (2, 1))
    """

    @spelled("Filter(model, arithmetic)")
    def __init__(self, model: Model, arithmetic: str = "f64", *, way: str = "", parts: Optional[Parts] = None):
        require_model(model, Model, "NonlinearFilter and NonlinearSmoother take it")
        super().__init__(model, parts or Parts(model.frame, arithmetic, way))
        self.begins = True  # the next row is the first one
        self.row = 0  # where the filter stands
        self.time: Optional[float] = None
        self.origin: Optional[np.datetime64] = None
        self._left: Optional[np.ndarray] = None  # words of the last row's control: it moves the state to the next
        self._next: Optional[int] = None  # of the process that does, where the model's own does not
        self._steps = Steps(self.parts)
        self._predict, self._one = self.arithmetic.function("predict"), None
        self._is_alone = type(self)._ask is Filter._ask  # otherwise something follows each row, or learns of it
        self._losses = Losses(self.arithmetic, model.sensor_sizes)
        self._start = self._object("diffuse", model.n, 0, sizes=(model.n, 0)) if np.any(model.unknown) else None
        self.begin()

    def begin(self) -> None:
        """At the model's start, before the first measurement"""
        self.parts.init_filter(self._handle, self._start)

    # ------------------------------------------------------------------ one row

    def predict(self, u: Optional[ArrayLike] = None, dt: Optional[float] = None) -> None:
        """To the next row; u: l controls, or None; dt: of a model in continuous time, if not its own: a number of its unit, or a duration"""
        process, pushed = self.parts.process, None
        if dt is not None or self._next is not None:
            dt = self._step_of(dt)
            process = self._process(dt)
        if isinstance(self.model, ColumnModel):
            process = self._process_of(u, process)
            u = None if u is None else row_of(u, len(self.model.inputs), "u")[0, : len(self.parts.model.inputs)]
        if u is not None or self.model.c is not None:
            pushed = self.parts.pushes(u)
        require(self._predict(self._handle, process, ffi.NULL if pushed is None else self._pointer(pushed)), "predict")
        self._moved(1, dt=dt)

    def update(self, z: ArrayLike, robust: Optional[Robust] = None, watch: Optional[Any] = None, u: Optional[ArrayLike] = None) -> None:
        """Takes m measurements; what is NaN is missing.  u: of this row, where the model has D or columns"""
        if robust is None and watch is None and self._is_alone and not self.has_rows:
            self._one = self._one or OneRow(self)
            if self._one.take(z):
                self.begins = False
                return
        self._sequence(self._row_of(z, u), robust, watch, moves=False)
        self.begins = False

    def _process_of(self, u: Optional[ArrayLike], own: Any) -> Any:
        """Of a step whose columns are in u"""
        if not self.model.cells.keys() & set(OF_STEP):
            return own
        rows = self._row_of(np.full(self.model.m, np.nan), u)
        return self._steps.process_at(self._steps.processes(rows)[0])

    def _row_of(self, z: ArrayLike, u: Optional[ArrayLike]) -> Rows:
        given = row_of(z, self.model.m, "z")
        return Rows.of(self.model, given, None if u is None else row_of(u, len(self.model.inputs), "u")) if self.has_rows else Rows(given)

    def step(self, z: ArrayLike, u: Optional[ArrayLike] = None, dt: Optional[float] = None) -> None:
        """predict, then update; refused as a whole."""
        refuse_rows(self.model, "step", "predict(u) with the row before, update(z, u=...) with this one")
        self.parts.words(row_of(z, self.model.m, "z"), "measurements")
        self.predict(u, dt)
        self.update(z)

    def forget(self, forgetting: float) -> None:
        """Fading memory: P / forgetting, 0 < forgetting <= 1; before predict."""
        require(self._call("forget", self.arithmetic.parameter(forgetting)), "forget")

    def forecast(self, steps: int, u: Optional[ArrayLike] = None, dt: Optional[float] = None) -> Filter:
        """The state so many rows ahead, as a filter; u: steps x l, 0 if left out; dt: of each, if not the model's."""
        if steps < 0:
            raise KalmanqError("steps: below 0")
        dt = self._step_of(dt)
        if self.has_rows:
            return self._forecast_of_rows(steps, u, dt)
        controls = controls_of(u, self.model, steps)
        words = None if controls is None else self.parts.words(controls, "controls")
        if self._next is not None and dt is None:  # the first step is not as those after it
            ahead = self.copy()
            for k in range(steps):
                ahead.predict(None if controls is None else controls[k, : len(self.model.inputs)])
            return ahead
        ahead = Filter(self.model, self.arithmetic.name, parts=self.parts)
        require(self._call("forecast", self._process(dt), self._pointer(words), steps, ahead._handle), "forecast")
        ahead.row, ahead.time, ahead.origin = self.row, self.time, self.origin
        ahead._moved(steps, dt=dt)
        return ahead

    def _forecast_of_rows(self, steps: int, u: Optional[ArrayLike], dt: Optional[float]) -> Filter:
        given = [None] * steps if u is None else rows_of(u, self.model.inputs, "u")
        if len(given) != steps:
            raise KalmanqError(f"u has {len(given)} rows, not {steps}")
        ahead = self.copy()
        for row in given:
            ahead.predict(row, dt)
        return ahead

    @property
    def has_rows(self) -> bool:
        """Has the model D, or numbers from columns?"""
        return self.parts.model is not self.model

    def copy(self) -> Filter:
        """The same state; what is attached stays with this one."""
        made = Filter(self.model, self.arithmetic.name, parts=self.parts)
        require(made._call("filter_copy", self._handle), "copy")
        made.row, made.begins, made._left, made.time, made.origin = self.row, self.begins, self._left, self.time, self.origin
        made._next, made._steps, made._losses = self._next, self._steps.copy(), self._losses.copy()
        return made

    # ------------------------------------------------------------------ what the next update would do

    def gain(self) -> np.ndarray:
        """n x m: the gain that the next update would use."""
        refuse_rows(self.model, "gain", "a run has innovations and their sigmas")
        n, m, a = self.model.n, self.model.m, self.arithmetic
        made = np.zeros((n, m), a.number_of_any_size)
        require(self._call("gain", self.parts.sensor, self._pointer(made, self._any_size)), "gain")
        scale = np.subtract.outer(self.parts.fractions("states"), self.parts.fractions("measurements"))
        return a.numbers(made, scale)

    def measurement(self) -> tuple[np.ndarray, np.ndarray]:
        """z^ = H x + d (m) and its covariance S = H P H' + R (m x m)."""
        refuse_rows(self.model, "measurement", "a run has innovations and their sigmas")
        m, a = self.model.m, self.arithmetic
        z, S = a.empty(m), np.zeros((m, m), a.number_of_any_size)
        require(self._call("measurement", self.parts.sensor, self._pointer(z), self._pointer(S, self._any_size)),
                "measurement")
        fractions = np.array(self.parts.fractions("measurements"))
        expected = a.values(z, fractions) + (0.0 if self.model.d is None else self.model.d)
        return expected, a.numbers(S, fractions[:, None] + fractions)

    # ------------------------------------------------------------------ sequences

    @spelled("run(z, u)")
    def run(self, z: ArrayLike, u: Optional[ArrayLike] = None, *, times: Optional[ArrayLike] = None,
            varying: Optional[Varying] = None, robust: Optional[Robust] = None, watch: Optional[Any] = None,
            covariance: bool = False) -> Run:
        """A sequence in one call of C, without Python's lock.

        Parameters
        ----------
        z : T x m, or T where m = 1; NaN: missing.  Or a DataFrame with a column for each measurement.  The first row ever is taken at the
            prior's instant; a predict comes before each other one
        u : T x l: row t moves the state from row t to row t + 1
        times : T: of a model in continuous time, when each row is: numbers in the unit of its dt, dates or durations of NumPy, Python
            or pandas.  None: what the index of a table says, if it has dates, durations or fractions of numbers
        varying : `Varying`, matrices that are others at each row
        robust : `Robust`, how outliers are taken
        watch : a `Consistency`, which sees every update
        covariance : those of all rows, too

        Raises
        ------
        KalmanqError
            says at which row it stopped; the state is then the one before it
        """
        rows = Rows.of(self.model, z, u, times, varying, self.origin)
        run = self._sequence(rows, robust, watch, covariance=covariance)
        run.index, run.fed = rows.index, rows.fed
        warn_of(run.events, f"{self.model.name}, {self.arithmetic.name}")
        self.warn_of_wide()
        warn_of_coarse(self, self.arithmetic.name, rows.z)
        return run

    def _sequence(self, rows: Rows, robust: Optional[Robust] = None, watch: Optional[Any] = None, *, moves: bool = True,
                  covariance: bool = False) -> Run:
        a, T = self.arithmetic, len(rows)
        words = self.parts.words(rows.net, "measurements")
        controls = None if rows.u is None else self.parts.words(rows.u, "controls")
        carried = self.parts.carried(controls, self._left, T) if moves else None
        out = Results(self, T, covariance)
        q = ffi.new(f"kq_sequence_{a.name} *")
        q.filter, q.process, q.sensor = self._handle, self.parts.process, self.parts.sensor
        q.steps, q.begins = T, self.begins or not moves
        q.z, q.u = self._pointer(words), self._pointer(carried)
        before = self._processes(rows) if moves and T else None
        sensors = self._steps.sensors(rows) if rows.matrices.keys() & {"H", "R"} else None
        q.processes, q.sensors = (ffi.NULL if one is None else ffi.cast("void *", one.ctypes.data) for one in (before, sensors))
        q.is_upper = self._steps.is_upper and not np.any(np.tril(self.parts.model.A, -1))
        q.widest = ffi.cast("double *", self._widest.ctypes.data) if a.is_fixed else ffi.NULL
        q.watch = ffi.NULL if watch is None else watch.of(self)
        kept = self._loss(q, robust)
        self._ask(q, out)
        out.ask(q)
        status = a.function("sequence_run")(q)
        del kept
        done = int(q.done)
        if moves and done:
            self._moved(done - self.begins, None if controls is None else controls[done - 1])
            self._next = int(before[done]) if rows.matrices.keys() & set("ABQ") else None
            self.time, self.origin = (None, None) if rows.times is None else (float(rows.times[done - 1]), rows.origin)
        self._end(q)
        require(status, "the run", done)
        return out.run()

    def _processes(self, rows: Rows) -> Optional[np.ndarray]:
        """Of the predict before each row, and where matrices vary of that after the last; None: all are the model's"""
        own = self._steps.own
        if rows.times is not None:
            if self.time is None and not self.begins:
                raise KalmanqError("times: the time of the last row is not known: give the times of all rows")
            if self.time is not None:
                require_one_origin(self.origin, rows.origin)
            begun = rows.times[0] - self.model.continuous.dt if self.time is None else self.time  # no predict before row 0
            refuse_back(rows.times[:1] - begun, True)
            before = self.model.continuous.between(np.concatenate([[begun], rows.times]))
            made = self._steps.over(before)
            return None if np.all(made == own) else made
        if not rows.matrices.keys() & set("ABQ"):
            return None if self._next is None else np.array([self._next, *[own] * (len(rows) - 1)], np.uintp)
        return np.concatenate([np.array([own if self._next is None else self._next], np.uintp), self._steps.processes(rows)])

    def _process(self, dt: Optional[float]) -> Any:
        """What moves the state to the next row"""
        if dt is None:
            return self.parts.process if self._next is None else self._steps.process_at(self._next)
        return self._steps.process_at(self._steps.over(np.array([dt]))[0])

    def _step_of(self, dt: Any) -> Optional[float]:
        if dt is None:
            return None
        if self.model.continuous is None:
            raise KalmanqError("dt: of a model in continuous time (F, Qc, dt)")
        return step_from(dt, self.model.continuous.seconds)

    def _moved(self, rows: int, left: Optional[np.ndarray] = None, dt: Optional[float] = None) -> None:
        self.row, self.begins, self._left, self._next = self.row + rows, False, left, None
        if self.time is not None:
            self.time += rows * (self.model.continuous.dt if dt is None else dt)

    def _loss(self, q: Any, robust: Optional[Robust]) -> Any:
        """Sets how measurements are taken; returns what has to stay until the call is over."""
        if robust is None:
            return None
        made = self._losses.of(robust)
        q.losses, q.losses_count, q.measured = made.losses, len(made.measured), self._pointer(made.measured, "uint32_t")
        if made.limits is not None:
            q.limits = self._scores(made.limits)
        return made

    def _target(self, q: Any) -> tuple[Any, ...]:
        a, n, l = self.arithmetic, self.model.n, self.model.l
        target = a.struct("process")
        memory = a.empty(int(lib.kq_length_q31(lib.KQ_OBJECT_ROOT, n, 0, 0, 0)))
        if a.is_fixed:
            q.root = self._pointer(memory)
        else:
            require(a.function("process_assign")(target, n, l, self._pointer(memory), memory.size), "process")
        q.target = target
        return target, memory

    def _ask(self, q: Any, out: Results) -> None:
        """What a smoother or an adaptation wants of a run beside the filter's results."""

    def _end(self, q: Any) -> None:
        """What of a run has to be known at the next one."""


class LagSmoother(Filter):
    """A filter with a fixed-lag smoother: `run` has `lagged`, `lagged_sigma` (T x n), the state of `lag` rows before, too.

    Parameters
    ----------
    model : Model
    lag : rows, 0 or more; NaN in the first `lag` rows
    arithmetic : "f64", "f32" or "q31"

    Raises
    ------
    KalmanqError
        a lag below 0, and what a Filter refuses

    Examples
    --------
    >>> run = kalmanq.LagSmoother(kalmanq.Model([1], H=[1], R=1, Q=1, P0=1), lag=1).run([1.0, 2.0, 3.0])
    >>> run.lagged.shape, bool(run.lagged_sigma[2, 0] < run.sigma[1, 0])    # row 1, given row 2, too
    ((3, 1), True)
    """

    def __init__(self, model: Model, lag: int, arithmetic: str = "f64"):
        super().__init__(model, arithmetic)
        if not isinstance(lag, (int, np.integer)) or lag < 0:
            raise KalmanqError(f"lag: {lag!r} is not a whole number from 0")
        self.lag = lag
        self._lag = self._object("lag", model.n, model.m, lag, sizes=(model.n, model.m, lag))
        self._follows = False

    def _ask(self, q: Any, out: Results) -> None:
        q.lag, q.age, q.lag_follows = self._lag, self.lag, self._follows
        out.add_states("lagged", "lagged")

    def _tell(self, run: Run, out: Results) -> None:
        run.lag = self.lag
        run.lagged, run.lagged_sigma = out.states("lagged", "lagged")

    def _end(self, q: Any) -> None:
        self._follows = bool(q.lag_follows)


class AdaptiveFilter(Filter):
    """A filter that learns the sizes of Q and R on its way (adaptation.h): `run` has `scales` (T x 2: of Q and R), too.

    Parameters
    ----------
    model : Model of steps that are all alike
    arithmetic : "f64", "f32" or "q31"
    scales : "both", "process" or "sensor"; the other one stays 1
    memory : M, in updates: 10 .. 100000
    step : 0 < step <= 1
    limits : of both scales, the least and the largest
    sensor_limits : of R's scale, where they are others

    Raises
    ------
    KalmanqError
        other scales, limits or memories, and rows whose steps or matrices vary

    Examples
    --------
    >>> f = kalmanq.AdaptiveFilter(kalmanq.Model([1], H=[1], R=1, Q=1, P0=1), scales="sensor", memory=50)
    >>> run = f.run(10 * np.random.default_rng(1).normal(size=500))    # of sigma 10, where the model says 1
    >>> bool(f.scales[1] > 20), run.scales.shape
    (True, (500, 2))
    """

    def __init__(self, model: Model, arithmetic: str = "f64", *, scales: str = "both", memory: int = 500,
                 step: float = 0.1, limits: tuple[float, float] = (1e-3, 1e3),
                 sensor_limits: Optional[tuple[float, float]] = None, parts: Optional[Parts] = None):
        super().__init__(model, arithmetic, parts=parts)
        a, n, m = self.arithmetic, model.n, model.m
        self._adaptation = a.struct("adaptation")
        store = np.zeros(self.arithmetic.length("adaptation", n, m), a.number_of_any_size)
        root = np.zeros(int(lib.kq_length_q31(lib.KQ_OBJECT_ROOT, n, 0, 0, 0)), np.int32)
        self._kept += [store, root]
        extra = [a.pointer(root, "int32_t")] if a.is_fixed else []
        require(a.function("adaptation_assign")(self._adaptation, n, m, self._pointer(store, self._any_size),
                                                store.size, *extra), "adaptation")
        which = {"both": lib.KQ_ADAPT_BOTH, "process": lib.KQ_ADAPT_PROCESS, "sensor": lib.KQ_ADAPT_SENSOR}
        if scales not in which:
            raise KalmanqError(f"there are no scales {scales!r}: {', '.join(which)}")
        ends = map(a.parameter, (*limits, *(sensor_limits or limits)))
        rule = ffi.new(f"kq_adaptation_rule_{a.name} *", {
            "scales": which[scales], "memory": memory, "step": a.parameter(step),
            **dict(zip(("process_least", "process_most", "sensor_least", "sensor_most"), ends))})
        require(a.function("adaptation_init")(self._adaptation, self.parts.process, self.parts.sensor, rule),
                "adaptation")
        self._attach(self._adaptation, "adaptation")

    def _ask(self, q: Any, out: Results) -> None:
        if q.processes or q.sensors:
            raise KalmanqError("an adaptation learns of one process and one sensor: steps and matrices cannot vary")
        q.adaptation = self._adaptation
        out.any_size["scales"] = np.zeros((int(q.steps), 2), self.arithmetic.number_of_any_size)

    def _tell(self, run: Run, out: Results) -> None:
        run.scales = self.arithmetic.numbers(out.any_size["scales"])

    @property
    def scales(self) -> np.ndarray:
        """2: of Q and R, as they are now."""
        a = self.arithmetic
        made = np.zeros(2, a.number_of_any_size)
        address = self._pointer(made, self._any_size)
        require(a.function("adaptation_scales")(self._adaptation, address, address + 1), "adaptation_scales")
        return a.numbers(made)


class Smoother(OfModel):
    """Of a recorded run: mean and covariance of every row given all rows.

    Parameters
    ----------
    model : Model
    arithmetic : "f64", "f32" or "q31"

    Raises
    ------
    KalmanqError
        what the core refuses, in a line

    Examples
    --------
    >>> run = kalmanq.Smoother(kalmanq.Model([1], H=[1], R=1, Q=1, P0=1), "f32").run([1.0, np.nan, 3.0])
    >>> run.smoothed.ravel(), run.smoothed_sigma.shape
    (array([0.85714287, 1.57142866, 2.28571439]), (3, 1))
    """

    @spelled("Smoother(model, arithmetic)")
    def __init__(self, model: Model, arithmetic: str = "f64"):
        require_model(model, Model, "NonlinearFilter and NonlinearSmoother take it")
        self.model = model
        self.parts = Parts(model.frame, arithmetic)
        self.last: Optional[Filter] = None  # the filter at the end of the last run

    @spelled("run(z, u)")
    def run(self, z: ArrayLike, u: Optional[ArrayLike] = None, *, times: Optional[ArrayLike] = None,
            varying: Optional[Varying] = None, robust: Optional[Robust] = None, covariance: bool = False,
            means_only: bool = False) -> Run:
        """As Filter.run; memory for all rows is taken first.

        Parameters
        ----------
        z, u, times, varying : as of Filter.run
        robust : gate, huber, student: against outliers.  Of states that jump: ReweightedSmoother.  What a gate takes after
            `run` rejections it takes as it is: a filter alone takes it as a jump
        covariance : those of all rows, too
        means_only : no smoothed sigma, in less time
        """
        refuse_jump(robust)
        rows = Rows.of(self.model, z, u, times, varying)
        recording = _Recording(self.model, self.parts, rows)
        run = recording.run(rows, robust=robust, covariance=covariance)
        recording.smooth(run, covariance, means_only)
        self.last = recording
        return run


def refuse_jump(robust: Optional[Robust]) -> None:
    """Before a smoother of recorded updates"""
    if robust is not None and robust.way == "jump":
        raise KalmanqError("jump raises P, which no smoother undoes: smooth states that jump with ReweightedSmoother (--smooth --robust jump)")


class _Recording(Filter):
    """A filter with a history of so many rows and, where the start is unknown, what keeps its first rows."""

    def __init__(self, model: Model, parts: Parts, rows: Rows, count: int = 0):
        super().__init__(model, parts.arithmetic.name, parts=parts)
        n, m, count = model.n, model.m, max(count, len(rows), 1)
        self._steps.keeps = True
        self.is_unknown = bool(np.any(model.unknown))
        if self.is_unknown:
            early = rows_to_know(model, parts, rows)
            self._start = self._object("diffuse", n, early, sizes=(n, early))
            self.parts.init_filter(self._handle, self._start)
        self._history = self._object("history", n, sizes=(n, m, count, count if rows.is_varying else 0))
        self._attach(self._history, "history")

    def smooth(self, run: Run, covariance: bool, means_only: bool) -> None:
        if not len(run):
            return
        self._smooth(means_only)
        what = "diffuse" if self.is_unknown else "history"
        self.read_smoothed(run, what, self._start if self.is_unknown else self._history, covariance, means_only)
        run.events |= self.smoothing_events(self._history)

    def _smooth(self, means_only: bool) -> None:
        a = self.arithmetic
        if not self.is_unknown or means_only:
            require(a.function("smooth_states" if means_only else "smooth")(self._history), "smoother")
        if self.is_unknown:
            require(a.function("diffuse_smooth")(self._start), "smoother")


EARLY_MAX = 65534  # kq_diffuse_assign


def rows_to_know(model: Model, parts: Parts, rows: Rows) -> int:
    """Rows until all of the start is known: what has to be kept of them takes memory."""
    trial, block = Filter(model, parts.arithmetic.name, parts=parts), 64
    for first in range(0, len(rows), block):
        trial._sequence(rows[first : first + block])
        if parts.arithmetic.function("diffuse_count")(trial._start) == 0 or first + block > EARLY_MAX:
            return min(first + block, EARLY_MAX)
    return min(len(rows) + 1, EARLY_MAX)


def run_many(sequences: Sequence[Any], run: Callable[[Any], Run], workers: Optional[int] = None) -> list[Run]:
    """`run` of each sequence, on several cores: C runs without Python's lock.  In the order of the sequences.

    Parameters
    ----------
    sequences : what `run` takes, each of a length of its own
    run : function of one of them; a filter of its own in it
    workers : threads; None: as Python has it

    Examples
    --------
    >>> model = kalmanq.Model([1], H=[1], R=1, Q=1, P0=1)
    >>> [len(one) for one in kalmanq.run_many([[1.0], [2.0, 3.0]], lambda z: kalmanq.Filter(model).run(z))]
    [1, 2]
    """
    with ThreadPoolExecutor(workers) as pool:
        return list(pool.map(run, sequences))
