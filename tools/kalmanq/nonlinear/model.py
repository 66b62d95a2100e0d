"""A nonlinear model: functions of the user's, and what they and their numbers are called."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Callable, Mapping, Optional, Sequence, Union

import numpy as np
from numpy.typing import ArrayLike

from kalmanq.errors import ModelError
from kalmanq.formulas.tracing import Untraced
from kalmanq.model import SIZE_MAX, Model, Quantities
from kalmanq.model.arrays import block_diagonal, numbers_of
from kalmanq.nonlinear.calls import Given, Stacked
from kalmanq.nonlinear.formulas import Formulas, Jacobian

Function = Callable[..., Any]
NOTHING = np.zeros(0)  # u where there are no controls


@dataclass(frozen=True)
class Sensor:
    """Measurements first, first + 1, ... that are taken together; name: "" where there is one sensor"""

    name: str
    first: int
    m: int

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
    """A state-space model of functions.

        x[t+1] = f(x[t], t, u[t]) + w[t],  w ~ N(0, Q)        z[t] = h(x[t], t, u[t]) + v[t],  v ~ N(0, R)

    f          n numbers of x (n), t (the row, from 0) and u (l controls); a function may take x alone, or x and t
    h          m numbers of the same
    increment  f(x) - x, in the place of f or beside it: of x' = x + v dt it is v dt, whose bits f(x) - x has lost
    innovation z - h(x) of z, x, t, u, where it is not that difference; angles are wrapped afterwards
    A, H       Jacobians of f and h, n x n and m x n; what is not given is derived from the formulas of f and h
    x0, P0     mean and covariance before the first measurement; P0 may be n variances
    Q, R       covariances, or variances; G in the place of Q, with Q = G G'
    sensors    in the place of h and R where there are several: {name: (h, R) or (h, R, H), ...}.  Their measurements follow one another;
               an update takes the sensors in this order, each at what the one before has left
    angles     the measurements, by name or number, that are angles in rad: their innovations are wrapped
    controls   names of the controls; their columns are u.  A time step that varies is one of them.
    A measurement's range, for fixed point, is that of its innovation (extended.h).
    simulated_controls   l numbers of t: u where measurements are simulated

    Error states: the filter's states are small errors of `nominal` numbers, as of a quaternion.
    nominal    names of these numbers, x0 has their first values; f, h, A and H are of them, A and H by the errors
    plus       plus(x, d): the nominal numbers with the errors d; minus(a, b): the errors of b that make a of it

    ModelError names what does not fit.  `frame` is the linear model of the same noises, prior and names.
    """

    def __init__(self, f: Optional[Function] = None, h: Optional[Function] = None, *, x0: ArrayLike, P0: ArrayLike,
                 R: Optional[ArrayLike] = None, Q: Optional[ArrayLike] = None, G: Optional[ArrayLike] = None,
                 increment: Optional[Function] = None, innovation: Optional[Function] = None,
                 A: Optional[Function] = None, H: Optional[Function] = None, states: Quantities = None,
                 measurements: Quantities = None, controls: Quantities = None, angles: Sequence[Union[int, str]] = (),
                 simulated_controls: Optional[Function] = None, sensors: Optional[Mapping[str, tuple]] = None,
                 nominal: Quantities = None, plus: Optional[Function] = None, minus: Optional[Function] = None,
                 name: str = "model"):
        if f is None and increment is None:
            raise ModelError("f", "is missing: f(x, t, u), or increment(x, t, u)")
        stack = _stacked(sensors, h, R, H) if sensors else None
        if stack:
            R = stack[1]
        elif h is None or R is None:
            raise ModelError(*(("R", "is missing") if h else ("h", "is missing: h(x, t, u)")))
        if P0 is None or isinstance(P0, str):
            raise ModelError("P0", "has to be known: a matrix or variances")
        if nominal is not None and (plus is None or minus is None or f is None):
            raise ModelError("nominal", "needs f(x, t, u), plus(x, d) and minus(a, b), too")
        n, m = _length("x0" if nominal is None else "P0", x0 if nominal is None else P0), _length("R", R)
        self.frame = Model(np.eye(n), np.zeros((m, n)), R, Q, G=G, x0=x0 if nominal is None else np.zeros(n), P0=P0,
                           states=states, measurements=measurements, name=name)
        self.name, self.n, self.m = name, n, m
        self.path: Optional[Path] = None  # of its file
        self.free: tuple[str, ...] = ()  # what its file says that a fit estimates
        self.constants: dict[str, float] = {}  # of its file, that were estimated
        self.x0, self.P0, self.Q, self.G, self.R = (getattr(self.frame, key) for key in ("x0", "P0", "Q", "G", "R"))
        self.states, self.measurements = self.frame.states, self.frame.measurements
        self.carried = self.states if nominal is None else _nominal(nominal, x0)
        if nominal is not None:
            self.x0 = np.array(x0, float)
        self.controls = () if controls is None else _controls(controls)
        self.l = len(self.controls)
        self.angles = self._angles(angles)
        self.given = {key: Given(key, function, key == "innovation") for key, function in (
            ("f", f), ("increment", increment), ("h", h), ("innovation", innovation), ("A", A), ("H", H),
            ("plus", plus), ("minus", minus), ("simulated_controls", simulated_controls)) if function is not None}
        self.sensors = [Sensor("", 0, m)]
        if stack:
            self.given["h"], self._sensors = stack[0], sensors
            self.given.update({} if stack[2] is None else {"H": stack[2]})
            first = np.cumsum([0, *(count for _, _, count in stack[0].parts)])
            self.sensors = [Sensor(name, int(at), count) for at, (name, _, count) in zip(first, stack[0].parts)]
        self.formulas = Formulas(self.given, len(self.carried), n, m, self.l, self.angles)
        self._derived: dict[str, Jacobian] = {}

    def _angles(self, given: Sequence[Union[int, str]]) -> list[int]:
        names = [one.name for one in self.measurements]
        made = []
        for which in [given] if isinstance(given, (str, int)) else given:
            if which in names:
                made.append(names.index(which))
            elif isinstance(which, (int, np.integer)) and not isinstance(which, bool) and 0 <= which < self.m:
                made.append(int(which))
            else:
                raise ModelError("angles", f"there is no measurement {which!r}")
        return made

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
        else:
            made["R"] = self.R
        if not {"Q", "G"} & set(other):
            made.update({"G": self.G} if self.G is not None else {"Q": self.Q})
        made.update(x0=self.x0, P0=self.P0, states=self.states, measurements=self.measurements, controls=self.controls,
                    angles=self.angles, name=self.name)
        return NonlinearModel(**{**made, **other})

    # ------------------------------------------------------------------ the functions, checked

    @property
    def has_errors(self) -> bool:
        """Are its states errors of nominal numbers?"""
        return "plus" in self.given

    @property
    def carried_names(self) -> list[str]:
        """Of what f moves: the states, or the nominal numbers"""
        return [one.name for one in self.carried]

    def plus(self, x: np.ndarray, d: np.ndarray) -> np.ndarray:
        """x with errors, or changes, d"""
        if not self.has_errors:
            return x + d
        plus = self.given["plus"]
        return plus.finite(plus.numbers((len(self.carried),), x, d), [self.carried_names], x)

    def minus(self, a: np.ndarray, b: np.ndarray) -> np.ndarray:
        """The errors, or changes, of b that make a of it"""
        if not self.has_errors:
            return a - b
        minus = self.given["minus"]
        return minus.finite(minus.numbers((self.n,), a, b), [self.state_names], a)

    @property
    def state_names(self) -> list[str]:
        return [one.name for one in self.states]

    @property
    def measurement_names(self) -> list[str]:
        return [one.name for one in self.measurements]

    def moved(self, x: np.ndarray, t: int, u: np.ndarray = NOTHING) -> np.ndarray:
        """f(x)"""
        if "f" not in self.given:
            return x + self.increment(x, t, u)
        f = self.given["f"]
        return f.finite(f.numbers((len(self.carried),), x, t, u), [self.carried_names], x)

    def increment(self, x: np.ndarray, t: int, u: np.ndarray = NOTHING) -> np.ndarray:
        """f(x) - x"""
        if "increment" not in self.given:
            return self.moved(x, t, u) - x
        d = self.given["increment"]
        return d.finite(d.numbers((self.n,), x, t, u), [self.state_names], x)

    def expected(self, x: np.ndarray, t: int, u: np.ndarray = NOTHING) -> np.ndarray:
        """h(x)"""
        h = self.given["h"]
        return h.finite(h.numbers((self.m,), x, t, u), [self.measurement_names], x)

    def innovation(self, z: np.ndarray, x: np.ndarray, t: int, u: np.ndarray = NOTHING,
                   near: Optional[np.ndarray] = None) -> np.ndarray:
        """z - h(x), of what is NaN in z: 0.  Angles are within half a turn of `near`, or of 0."""
        there = ~np.isnan(z)
        if "innovation" in self.given:
            e = self.given["innovation"].numbers((self.m,), z, x, t, u)
            self.given["innovation"].finite(np.where(there, e, 0.0), [self.measurement_names], x)
        else:
            e = z - self.expected(x, t, u)
        e = np.where(there, e, 0.0)
        return unwrapped(e, self.angles) if near is None else near + unwrapped(e - near, self.angles)

    def transition(self, x: np.ndarray, t: int, u: np.ndarray = NOTHING) -> np.ndarray:
        """A = df/dx, n x n"""
        if "A" in self.given:
            A = self.given["A"]
            return A.finite(A.numbers((self.n, self.n), x, t, u), [self.state_names, self.state_names], x)
        return self.found_transition(x, t, u)

    def measurement(self, x: np.ndarray, t: int, u: np.ndarray = NOTHING) -> np.ndarray:
        """H = dh/dx, m x n"""
        if "H" in self.given:
            H = self.given["H"]
            return H.finite(H.numbers((self.m, self.n), x, t, u), [self.measurement_names, self.state_names], x)
        return self.found_measurement(x, t, u)

    def found_transition(self, x: np.ndarray, t: int, u: np.ndarray = NOTHING) -> np.ndarray:
        """A, derived from the formulas of f.  KalmanqError says what of f has no formula."""
        return self._finite("A", self._derive("A").at(x, t, u), self.state_names, x)

    def found_measurement(self, x: np.ndarray, t: int, u: np.ndarray = NOTHING) -> np.ndarray:
        return self._finite("H", self._derive("H").at(x, t, u), self.measurement_names, x)

    def _derive(self, which: str) -> Jacobian:
        if which not in self._derived:
            try:
                rows = self.formulas.derived_transition if which == "A" else self.formulas.derived_measurement
            except Untraced as problem:
                raise Untraced(f"{problem}.  Or give its Jacobian {which}(x, t, u)") from None
            self._derived[which] = Jacobian(rows)
        return self._derived[which]

    def _finite(self, which: str, J: np.ndarray, rows: list[str], x: np.ndarray) -> np.ndarray:
        of = self.given["h" if which == "H" else "increment" if "increment" in self.given else "f"]
        return of.finite(J, [[f"its derivative of {one}" for one in rows], [f"by {one}" for one in self.state_names]], x)

    def controls_at(self, t: int) -> np.ndarray:
        if not self.l:
            return NOTHING
        if "simulated_controls" not in self.given:
            return np.zeros(self.l)
        u = self.given["simulated_controls"]
        return u.finite(u.numbers((self.l,), t), [[one.name for one in self.controls]], np.array([float(t)]))

    def __repr__(self) -> str:
        return f"NonlinearModel({self.name!r}, n={self.n}, m={self.m}, l={self.l})"


def unwrapped(change: np.ndarray, angles: Sequence[int]) -> np.ndarray:
    """Angles within half a turn"""
    made = change.copy()
    for c in angles:
        made[c] -= 2 * np.pi * np.round(made[c] / (2 * np.pi))
    return made


def _nominal(names: Any, x0: ArrayLike) -> Any:
    count = _length("x0", x0)
    made = Model(np.eye(count), np.zeros((1, count)), 1.0, np.eye(count), P0=np.zeros(count), states=names).states
    return made


def _stacked(sensors: Mapping[str, tuple], h: Any, R: Any, H: Any) -> tuple[Stacked, np.ndarray, Optional[Stacked]]:
    """Their h, R and H"""
    if any(one is not None for one in (h, R, H)):
        raise ModelError("sensors", "is in the place of h, R and H: leave these out")
    parts, matrices, slopes = [], [], []
    for name, given in sensors.items():
        if not isinstance(name, str) or not name.isidentifier() or not isinstance(given, (tuple, list)) or len(given) not in (2, 3):
            raise ModelError("sensors", 'is {"name": (h, R), ...} or with (h, R, H), and names of letters, digits and _')
        m = _length(f"R of {name}", given[1])
        matrices.append(Model([[1.0]], np.zeros((m, 1)), given[1], [[0.0]], P0=[0.0]).R)
        parts.append((name, Given(name, given[0]), m))
        slopes += [(name, Given(f"H of {name}", given[2]), m)] if len(given) == 3 else []
    if slopes and len(slopes) < len(parts):
        raise ModelError("sensors", "either each gives its Jacobian H, or none does")
    return Stacked(parts), block_diagonal(matrices), Stacked(slopes) if slopes else None


def _length(key: str, given: ArrayLike) -> int:
    try:
        length = len(np.atleast_1d(numbers_of(given)))
    except (TypeError, ValueError, OverflowError):
        raise ModelError(key, "not an array of numbers, with rows of one length") from None
    if not 1 <= length <= SIZE_MAX:
        raise ModelError(key, f"has {length} rows; there are 1 to {SIZE_MAX}")
    return length


def _controls(given: Any) -> Any:
    names = list(given)
    if not names:
        return ()
    return Model([[0.0]], [0.0], 0.0, [[0.0]], B=np.zeros((1, len(names))), P0=[0.0], controls=names).controls
