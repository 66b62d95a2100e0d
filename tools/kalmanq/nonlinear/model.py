"""A nonlinear model: functions of the user's, and what they and their numbers are called."""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Callable, Mapping, Optional, Sequence, Union

import numpy as np
from numpy.typing import ArrayLike

from kalmanq.errors import KalmanqError, ModelError, counted
from kalmanq.formulas.graph import needed
from kalmanq.formulas.tracing import Untraced
from kalmanq.model import Model, Quantities
from kalmanq.model import Sensor as LateSensor
from kalmanq.model.arrays import numbers_of
from kalmanq.model.spellings import spelled
from kalmanq.nonlinear.angles import turns_of, wrapped
from kalmanq.nonlinear.calls import OF_ROW, OF_STEP, STEP, Given, Instant, Stacked
from kalmanq.nonlinear.formulas import Formulas, Jacobian
from kalmanq.nonlinear.noises import Noises, length, looked_at

Function = Callable[..., Any]
Noise = Union[ArrayLike, Function, None]
NOTHING = np.zeros(0)  # u where there are no controls
NAMES = {"innovation": ("z", *OF_ROW), "plus": ("x", "d"), "minus": ("a", "b"), "simulated_controls": ("t",)}  # of arguments


@dataclass(frozen=True)
class Sensor:
    """Measurements first, first + 1, ... that are taken together; name: "" where there is one sensor"""

    name: str
    first: int
    m: int
    delay: float = 0.0

    @property
    def all(self) -> int:
        return (1 << self.m) - 1

    @property
    def rows(self) -> slice:
        """Of R and H"""
        return slice(self.first, self.first + self.m)

    @property
    def suffix(self) -> str:
        return f"_{self.name}" if self.name else ""


class NonlinearModel:
    """A model of functions, x[t+1] = f(x[t], t, u[t]) + w[t], w ~ N(0, Q), and z[t] = h(x[t], t, u[t]) + v[t], v ~ N(0, R).

    ModelError names what does not fit.  `frame` is the linear model of the same noises, prior and names.

    Parameters
    ----------
    f, h : n and m numbers of x (n), t (the row, from 0; seconds where rows have times), u (l), or fewer of these; f, A, Q, G of `dt`, too
    increment : f(x) - x, in the place of f or beside it: of x' = x + v dt it is v dt, whose bits f(x) - x has lost
    innovation : z - h(x) of z, x, t, u, where it is not that difference
    A, H : Jacobians of f and h, n x n and m x n; what is not given is derived from the formulas of f and h
    x0, P0 : n; n x n or n variances, before the first measurement
    Q, R, G : covariances or variances, Q = G G'; or functions of x, t, u at the mean before the step, or the sensor's update
    dt : seconds of a step, where rows have no times: of functions that take it
    sensors, delays : {name: (h, R) or (h, R, H)} in the place of h, R, H: taken in turn; {name: how late}, in rows, or seconds if timed
    states, measurements, controls, name : as in Model; a measurement's range, for fixed point, is that of its innovation
    angles : the measurements, by name or number, whose innovations are wrapped, by their unit (none: rad)
    simulated_controls : l numbers of t: u where measurements are simulated
    nominal, plus, minus : error states, as of a quaternion: names of the numbers that x0, f, h have; plus(x, d): these with the errors d;
        minus(a, b): the errors of b that make a of it; A and H are by the errors
    Examples
    --------
    >>> kalmanq.NonlinearModel(lambda x: x, lambda x: [x[0] ** 2], Q=0.01, R=0.1, x0=[2.0], P0=[1.0])
    NonlinearModel('model', n=1, m=1, l=0)
    """

    @spelled("NonlinearModel(f, h, x0=..., P0=..., Q=..., R=...)")
    def __init__(self, f: Optional[Function] = None, h: Optional[Function] = None, *, x0: ArrayLike, P0: ArrayLike,
                 R: Noise = None, Q: Noise = None, G: Noise = None, dt: Optional[float] = None,
                 increment: Optional[Function] = None, innovation: Optional[Function] = None,
                 A: Optional[Function] = None, H: Optional[Function] = None, states: Quantities = None,
                 measurements: Quantities = None, controls: Quantities = None, angles: Sequence[Union[int, str]] = (),
                 simulated_controls: Optional[Function] = None, sensors: Optional[Mapping[str, tuple]] = None,
                 delays: Optional[Mapping[str, float]] = None,
                 nominal: Quantities = None, plus: Optional[Function] = None, minus: Optional[Function] = None,
                 name: str = "model"):
        if f is None and increment is None:
            raise ModelError("f", "is missing: f(x, t, u), or increment(x, t, u)")
        if not sensors and (h is None or R is None):
            raise ModelError(*(("R", "is missing") if h else ("h", "is missing: h(x, t, u)")))
        if P0 is None or isinstance(P0, str) or isinstance(P0, (list, tuple)) and any(isinstance(one, str) for one in P0):
            raise ModelError("P0", "has to be known, a matrix or variances: of what nothing is known give a wide one")
        if nominal is not None and (plus is None or minus is None or f is None):
            raise ModelError("nominal", "needs f(x, t, u), plus(x, d) and minus(a, b), too")
        self.carried = () if nominal is None else _nominal(nominal, x0)
        self.controls = () if controls is None else _controls(controls)
        self.l = len(self.controls)
        self.given = {key: Given(key, function, NAMES.get(key, OF_ROW)) for key, function in (
            ("f", f), ("increment", increment), ("h", h), ("innovation", innovation), ("A", A), ("H", H),
            ("plus", plus), ("minus", minus), ("simulated_controls", simulated_controls), *(
                (key, one) for key, one in (("Q", Q), ("G", G)) if callable(one))) if function is not None}
        n = length("x0" if nominal is None else "P0", x0 if nominal is None else P0)
        noise = Q if Q is not None else G
        if nominal is None and not callable(noise) and noise is not None and n != length("Q", noise) == (count := length("P0", P0)):
            raise ModelError("x0", f"has {counted(n, 'number')}, and P0 {counted(count, 'row' if np.ndim(P0) > 1 else 'variance')}: one for each state")
        self.noises = _sensor_parts(sensors, h, R, H) if sensors else Noises({"": R})
        m = self.noises.measured(lambda: (np.array(numbers_of(x0), float).ravel(), 0, self.controls_at(0)), measurements)
        if (Q is None) == (G is None):
            raise ModelError("Q", "give either Q or G, with Q = G G'; a constant of yours needs another name than Q and G")
        varies = self.given.keys() & {"Q", "G"}
        self.frame = Model(np.eye(n), H=np.zeros((m, n)), R=self.noises.start, Q=np.zeros((n, n)) if varies else Q, G=None if varies else G,
                           x0=x0 if nominal is None else np.zeros(n), P0=P0, states=states, measurements=measurements, name=name)
        self.name, self.n, self.m = name, n, m
        self.path: Optional[Path] = None  # of its file
        self.linear: Optional[Model] = None  # that it is of, where its functions are of columns
        self.recording: Mapping[str, Any] = {}  # what its file says of data files
        self.free: tuple[str, ...] = ()  # what its file says that a fit estimates
        self.constants: dict[str, float] = {}  # of its file, that were estimated
        self.P0, self.states, self.measurements = self.frame.P0, self.frame.states, self.frame.measurements
        self.Q, self.G = (None, None) if varies else (self.frame.Q, self.frame.G)  # None: functions
        self.R = None if self.noises.functions else self.frame.R
        self.x0 = self.frame.x0 if nominal is None else np.array(x0, float)
        self.carried = self.carried or self.states
        self.angles = turns_of(angles, self.measurements)
        self.measurements = self.frame.measurements = tuple(  # so that a file whose heading has another unit is refused
            replace(one, unit="rad") if c in self.angles and not one.unit else one for c, one in enumerate(self.measurements))
        self._R = R
        self.sensors = [Sensor("", 0, m)]
        if sensors:
            self._take_sensors(sensors)
        self._take_step(dt)
        self._take_delays({} if delays is None else delays)
        self.formulas = self._formulas()
        self._derived: dict[str, Jacobian] = {}

    def _formulas(self) -> Formulas:
        return Formulas(self.given, len(self.carried), self.n, self.m, self.l, self.angles, noises=self.noises)

    def traced_anew(self) -> NonlinearModel:
        """With formulas of its own, in whose graph nothing else has been made: the order of its nodes is that of products"""
        made = copy(self)
        made.formulas = made._formulas()
        return made

    def _take_sensors(self, sensors: Mapping[str, tuple]) -> None:
        self._sensors, sizes = sensors, self.noises.sizes
        self.given.update(_stacked(sensors, sizes))
        first = np.cumsum([0, *sizes.values()])
        self.sensors = [Sensor(name, int(at), count) for at, (name, count) in zip(first, sizes.items())]

    def _take_delays(self, delays: Mapping[str, float]) -> None:
        names = [one.name for one in self.sensors if one.name]
        if not isinstance(delays, Mapping) or not set(delays) <= set(names):
            raise ModelError("delays", f"is {{name of a sensor: how late it tells}}; sensors: {', '.join(names) or 'none has a name'}")
        for name, late in delays.items():
            if isinstance(late, bool) or not isinstance(late, (int, float)) or not 0 <= late < np.inf:
                raise ModelError("delays", f"{name} is to be 0 or more: seconds where a function takes t or dt, otherwise rows")
        self.sensors = [replace(one, delay=float(delays.get(one.name, 0.0))) for one in self.sensors]

    @property
    def is_late(self) -> bool:
        return any(one.delay for one in self.sensors)

    @property
    def late_sensors(self) -> list[LateSensor]:
        """As a linear model has them; empty: all tell in time"""
        names = [one.name for one in self.measurements]
        return [LateSensor(one.name, tuple(names[one.rows]), one.delay) for one in self.sensors] if self.is_late else []

    def _take_step(self, dt: Any) -> None:
        """takes_step: does a function take it?"""
        self.takes_step = any(STEP in one.takes for one in self.given.values() if isinstance(one, Given))
        for one in self.functions if self.takes_step else ():
            if one.has_own_step:
                raise one.error(f"{STEP} has a default, and another function takes {STEP}: leave the default out")
        self.dt = _step(dt) if self.takes_step and dt is not None else None
        for key in self.given.keys() & set(OF_STEP):
            self.given[key].dt = self.dt

    def __copy__(self) -> NonlinearModel:
        """Itself: to another process it goes as its file (file.py)"""
        made = object.__new__(type(self))
        made.__dict__.update(self.__dict__)
        return made

    def without_jacobians(self) -> NonlinearModel:
        return self.changed(A=None, H=None)

    def changed(self, **other: Any) -> NonlinearModel:
        """With other functions and arrays"""
        made: dict[str, Any] = {key: given.function for key, given in self.given.items() if isinstance(given, Given)}
        made.update({"nominal": self.carried} if self.has_errors else {})
        if isinstance(self.given["h"], Stacked):
            given = 2 if other.pop("H", "") is None else 3
            made["sensors"] = {name: one[:given] for name, one in self._sensors.items()}
            made["delays"] = {one.name: one.delay for one in self.sensors if one.delay}
        else:
            made["R"] = self._R
        if {"Q", "G"} & set(other):
            made.update(Q=None, G=None)
        elif not {"Q", "G"} & set(made):
            made.update({"G": self.G} if self.G is not None else {"Q": self.Q})
        made.update(dt=self.dt, x0=self.x0, P0=self.P0, states=self.states, measurements=self.measurements, controls=self.controls,
                    angles=self.angles, name=self.name)
        return NonlinearModel(**{**made, **other})

    # ------------------------------------------------------------------ rows at their times

    @cached_property
    def reads_times(self) -> bool:
        """Does a function read t, or take the step?"""
        f = self.formulas
        try:
            return self.takes_step or any(one.op == "symbol" and one.args[0] == "t" for one in needed(f.of_rows)[0])
        except Untraced:
            return any("t" in one.takes for one in self.functions)

    @property
    def inputs(self) -> Any:
        return self.controls

    @property
    def functions(self) -> list[Given]:
        """Of a row and of a step"""
        given = [one for key, one in self.given.items() if key not in ("plus", "minus", "simulated_controls")]
        parts = [part for one in given for part in ([of for _, of, _ in one.parts] if isinstance(one, Stacked) else [one])]
        return [*parts, *self.noises.functions.values()]

    @property
    def has_empty_steps(self) -> bool:
        """Is a step of no length none?  What takes no dt moves the state, or makes it less certain, over each"""
        noises = [of for key, of in self.given.items() if key in ("Q", "G")]
        return all(STEP in self.given[key].takes for key in ("f", "increment") if key in self.given) and self.takes_step and \
            (any(STEP in of.takes for of in noises) or not np.any(self.frame.Q))

    @property
    def dt_of_rows(self) -> Optional[float]:
        """Of data, whose times are read then: NaN if no step is known; None: rows are steps"""
        return (self.dt or np.nan) if self.reads_times else None

    def step_error(self) -> KalmanqError:
        """Where the step is not known"""
        return next(one for one in self.functions if STEP in one.takes).step_error()

    def at_row(self, row: int) -> float:
        """t of a row without a time"""
        return row if self.dt is None else Instant(row * self.dt, self.dt)

    def instants(self, rows: int, times: Optional[np.ndarray] = None) -> list[float]:
        """t of each row; the last one has the model's step"""
        if times is None:
            return [self.at_row(row) for row in range(rows)]
        return [Instant(*one) for one in zip(times, [*np.diff(times), self.dt])]

    # ------------------------------------------------------------------ the functions, checked

    @property
    def has_errors(self) -> bool:
        """Are its states errors of nominal numbers?"""
        return "plus" in self.given

    @property
    def carried_names(self) -> list[str]:
        """Of what f moves: the states, or the nominal numbers"""
        return [one.name for one in self.carried]

    def _answer(self, key: str, names: list[list[str]], x: np.ndarray, *more: Any) -> np.ndarray:
        """Of a function that is given; names: of its rows, and of columns"""
        of = self.given[key]
        return of.finite(of.numbers(tuple(map(len, names)), x, *more), names, x)

    def plus(self, x: np.ndarray, d: np.ndarray) -> np.ndarray:
        """x with errors, or changes, d"""
        return self._answer("plus", [self.carried_names], x, d) if self.has_errors else x + d

    def minus(self, a: np.ndarray, b: np.ndarray) -> np.ndarray:
        """The errors, or changes, of b that make a of it"""
        return self._answer("minus", [self.state_names], a, b) if self.has_errors else a - b

    @property
    def state_names(self) -> list[str]:
        return [one.name for one in self.states]

    @property
    def measurement_names(self) -> list[str]:
        return [one.name for one in self.measurements]

    @cached_property
    def measured(self) -> Model:
        """A linear model with the noises of this one, whose measurements are h(x0) at first; ranges are of innovations, and it has none"""
        try:
            at_first = self.expected(self.x0, self.at_row(0), self.controls_at(self.at_row(0)))
        except KalmanqError:
            at_first = None
        return self.frame.changed(d=at_first, measurements=self.measurement_names)

    def moved(self, x: np.ndarray, t: float, u: np.ndarray = NOTHING) -> np.ndarray:
        """f(x)"""
        return self._answer("f", [self.carried_names], x, t, u) if "f" in self.given else x + self.increment(x, t, u)

    def increment(self, x: np.ndarray, t: float, u: np.ndarray = NOTHING) -> np.ndarray:
        """f(x) - x"""
        return self._answer("increment", [self.state_names], x, t, u) if "increment" in self.given else self.moved(x, t, u) - x

    def expected(self, x: np.ndarray, t: float, u: np.ndarray = NOTHING) -> np.ndarray:
        """h(x)"""
        return self._answer("h", [self.measurement_names], x, t, u)

    def innovation(self, z: np.ndarray, x: np.ndarray, t: float, u: np.ndarray = NOTHING,
                   near: Optional[np.ndarray] = None) -> np.ndarray:
        """z - h(x), of what is NaN in z: 0.  Angles are within half a turn of `near`, or of 0."""
        there = ~np.isnan(z)
        if "innovation" in self.given:
            e = self.given["innovation"].numbers((self.m,), z, x, t, u)
            self.given["innovation"].finite(np.where(there, e, 0.0), [self.measurement_names], x)
        else:
            e = z - self.expected(x, t, u)
        e = np.where(there, e, 0.0)
        return wrapped(e, self.angles) if near is None else near + wrapped(e - near, self.angles)

    def transition(self, x: np.ndarray, t: float, u: np.ndarray = NOTHING) -> np.ndarray:
        """A = df/dx, n x n"""
        return self._answer("A", [self.state_names, self.state_names], x, t, u) if "A" in self.given else self.found_transition(x, t, u)

    def measurement(self, x: np.ndarray, t: float, u: np.ndarray = NOTHING) -> np.ndarray:
        """H = dh/dx, m x n"""
        return self._answer("H", [self.measurement_names, self.state_names], x, t, u) if "H" in self.given else self.found_measurement(x, t, u)

    def found_transition(self, x: np.ndarray, t: float, u: np.ndarray = NOTHING) -> np.ndarray:
        """A, derived from the formulas of f.  KalmanqError says what of f has no formula."""
        return self._finite("A", self._derive("A").at(x, t, u), self.state_names, x)

    def found_measurement(self, x: np.ndarray, t: float, u: np.ndarray = NOTHING) -> np.ndarray:
        return self._finite("H", self._derive("H").at(x, t, u), self.measurement_names, x)

    def _derive(self, which: str) -> Jacobian:
        if which not in self._derived:
            try:
                rows = self.formulas.derived_transition if which == "A" else self.formulas.derived_measurement
            except Untraced as problem:
                raise Untraced(f"{problem}.  Or give its Jacobian {which}(x, t, u)") from None
            self._derived[which] = Jacobian(rows, self.dt)
        return self._derived[which]

    def _finite(self, which: str, J: np.ndarray, rows: list[str], x: np.ndarray) -> np.ndarray:
        of = self.given["h" if which == "H" else "increment" if "increment" in self.given else "f"]
        return of.finite(J, [[f"its derivative of {one}" for one in rows], [f"by {one}" for one in self.state_names]], x)

    def process_noise(self, x: np.ndarray, t: float, u: np.ndarray = NOTHING) -> dict[str, np.ndarray]:
        """Q, or G, of the step that begins here, by name"""
        for key in ("Q", "G"):
            if key in self.given:
                return {key: looked_at(self.given[key], (x, t, u), self.n)}
        return {"Q": self.Q} if self.G is None else {"G": self.G}

    def measurement_noise(self, x: np.ndarray, t: float, u: np.ndarray = NOTHING) -> np.ndarray:
        """R of all sensors"""
        return self.R if self.R is not None else self.noises.at((x, t, u))

    def controls_at(self, t: float) -> np.ndarray:
        if not self.l:
            return NOTHING
        if "simulated_controls" not in self.given:
            return np.zeros(self.l)
        u = self.given["simulated_controls"]
        return u.finite(u.numbers((self.l,), t), [[one.name for one in self.controls]], np.array([float(t)]))

    def __repr__(self) -> str:
        return f"NonlinearModel({self.name!r}, n={self.n}, m={self.m}, l={self.l})"


def _nominal(names: Any, x0: ArrayLike) -> Any:
    count = length("x0", x0)
    made = Model(np.eye(count), H=np.zeros((1, count)), R=1.0, Q=np.eye(count), P0=np.zeros(count), states=names).states
    return made


def _sensor_parts(sensors: Mapping[str, tuple], h: Any, R: Any, H: Any) -> Noises:
    """R of each"""
    if any(one is not None for one in (h, R, H)):
        raise ModelError("sensors", "is in the place of h, R and H: leave these out")
    for name, given in sensors.items():
        if not isinstance(name, str) or not name.isidentifier() or not isinstance(given, (tuple, list)) or len(given) not in (2, 3):
            raise ModelError("sensors", 'is {"name": (h, R), ...} or with (h, R, H), and names of letters, digits and _')
    counts = [len(given) for given in sensors.values()]
    if max(counts) > min(counts):
        raise ModelError("sensors", "either each gives its Jacobian H, or none does")
    return Noises({name: given[1] for name, given in sensors.items()})


def _stacked(sensors: Mapping[str, tuple], sizes: Mapping[str, int]) -> dict[str, Stacked]:
    """Their h and H"""
    made = {"h": Stacked([(name, Given(name, given[0]), sizes[name]) for name, given in sensors.items()])}
    if all(len(given) == 3 for given in sensors.values()):
        made["H"] = Stacked([(name, Given(f"H of {name}", given[2]), sizes[name]) for name, given in sensors.items()])
    return made


def _step(dt: Any) -> float:
    if isinstance(dt, bool) or not isinstance(dt, (int, float, np.integer, np.floating)) or not 0 < dt < np.inf:
        raise ModelError("dt", "is not a number above 0: the seconds from row to row")
    return float(dt)


def _controls(given: Any) -> Any:
    names = list(given)
    if not names:
        return ()
    return Model([[0.0]], H=[0.0], R=0.0, Q=[[0.0]], B=np.zeros((1, len(names))), P0=[0.0], controls=names).controls
