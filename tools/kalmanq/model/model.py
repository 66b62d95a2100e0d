"""What a filter is of: matrices, a prior, and what states, measurements and controls are called."""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Mapping, Optional, Sequence, Union

import numpy as np
from numpy.typing import ArrayLike

from kalmanq.errors import ModelError, counted
from kalmanq.model.arrays import by_name, numbers_of
from kalmanq.model.continuous import UNITS, Continuous

SIZE_MAX = 16
ROOT_LOST = 1e-9  # of sigma_i sigma_j


@dataclass(frozen=True)
class Reading:
    """How a column of a data file says a quantity, as factor * cell + offset.

    column     its name, if it is not the quantity's
    missing    numbers and texts in the file that mean: nothing was measured
    plausible  the least and the largest value, in the quantity's unit; what is outside is missing
    """

    column: str = ""
    factor: float = 1.0
    offset: float = 0.0
    missing: tuple[Union[str, float], ...] = ()
    plausible: Optional[tuple[float, float]] = None

    @property
    def converts(self) -> bool:
        return (self.factor, self.offset) != (1.0, 0.0)


AS_IT_IS = Reading()


@dataclass(frozen=True)
class Quantity:
    """A state, a measurement or a control: what it is called, and what fixed point has to know.

    Parameters
    ----------
    name : what its columns are called
    unit : for tables and pictures; that of the mean and the sigma, squared of R, Q and P0
    range : the largest absolute value, or the least and the largest; fixed point needs it
    fraction : n of Qm.n, value = raw value 2^-n; None: the most that the range leaves room for
    constant : a control that is always 1, which nobody gives: its column of B is an offset
    ends : the least and the largest value, where `range` was both; `range` is then the larger absolute value
    reading : how data files say it: `Reading`

    Raises
    ------
    ModelError
        a range whose ends do not rise

    Examples
    --------
    >>> kalmanq.Quantity("height", "m", range=(-10, 500)).range
    500.0
    """

    name: str
    unit: str = ""
    range: Optional[float] = None
    fraction: Optional[int] = None
    constant: bool = False
    ends: Optional[tuple[float, float]] = None
    reading: Reading = AS_IT_IS

    if TYPE_CHECKING:
        def __init__(self, name: str, unit: str = "", range: Union[float, tuple[float, float], None] = None, fraction: Optional[int] = None,
                     constant: bool = False, ends: Optional[tuple[float, float]] = None, reading: Reading = AS_IT_IS) -> None: ...

    def __post_init__(self) -> None:
        if isinstance(self.range, (tuple, list)):
            low, high = self.range if len(self.range) == 2 else (0, 0)
            if not -np.inf < low < high < np.inf:
                raise ModelError(self.name, f"range: {tuple(self.range)} is not a least and a larger number")
            object.__setattr__(self, "ends", (float(low), float(high)))
            object.__setattr__(self, "range", max(-float(low), float(high)))
        elif self.ends and self.range != max(-self.ends[0], self.ends[1]):  # another range was put in their place
            object.__setattr__(self, "ends", None)

    @property
    def label(self) -> str:
        return f"{self.name} [{self.unit}]" if self.unit else self.name

    @property
    def span(self) -> str:
        """Its range as it was given; empty: it has none"""
        return f"{self.ends[0]:g} to {self.ends[1]:g}" if self.ends else f"{self.range:g}" if self.range else ""


@dataclass(frozen=True)
class Gaps:
    """Which samples may be missing; `kalmanq check` and `design` take a model at its word.

    Parameters
    ----------
    max_gap : at most so many rows in a row
    min_run : at least so many between two gaps; None: any number

    Examples
    --------
    >>> kalmanq.Gaps(max_gap=3, min_run=10).max_gap
    3
    """

    max_gap: int = 0
    min_run: Optional[int] = None


@dataclass(frozen=True)
class Sensor:
    """Measurements, by name, that come together: of a file, they are all there or none is"""

    name: str
    measurements: tuple[str, ...]
    delay: float = 0.0  # from when it measured to the row that tells it, in the unit of dt; rows of a model of steps
    measured: str = ""  # a column with the time that it measured at: no more than `delay` before that of the row


_FIXED = ("A", "H", "R", "Q", "G", "B", "D", "d", "x0", "P0", "unknown")  # of which others are worked out
Quantities = Optional[Sequence[Union[Quantity, str]]]


class Model:
    """A linear state-space model.  Its arrays are read-only float64; `n`, `m`, `l` are sizes; `changed(R=...)` answers another one.

        x[t+1] = A x[t] + B u[t] + c + w[t],  w ~ N(0, Q)        z[t] = H x[t] + D u[t] + d + v[t],  v ~ N(0, R)

    ModelError names what does not fit.  Of x' = F x + B u + noise: `Model.of_continuous(F, H=..., R=..., Qc=..., dt=...)`.

    Parameters
    ----------
    A, H : n x n, and m x n; n numbers where m = 1
    R : m x m, or m variances where the noises are independent; a number where m = 1
    Q : n x n, or n variances; or in its place
    G : n x r, with Q = G G', exact where Q is singular; n numbers where r = 1
    B, D : n x l and m x l, or None: no control; D is what a measurement has of the controls of its row
    c, d : n and m numbers; None: no offset.  c is the last column of `B` then, of a control that is always 1
    x0 : n, mean before the first measurement; None: 0
    P0 : n x n, or n variances, before the first measurement; None: nothing is known of any state
    unknown : the states, by name or number, of which nothing is known at first; "all"
    states, measurements, controls : names, or `Quantity` with unit and range (which q31 needs)
    gaps, name : which samples may be missing (`Gaps`); what messages and pictures call it

    Examples
    --------
    >>> kalmanq.Model([[1, 0.1], [0, 1]], H=[1, 0], R=0.04, G=[0.005, 0.1], P0=[100, 10], states=["position", "velocity"])
    Model('model', n=2, m=1, l=0)
    """

    @by_name("Model(A, H=..., R=..., Q=...)")
    def __init__(self, A: ArrayLike, *, H: ArrayLike, R: ArrayLike, Q: Optional[ArrayLike] = None,
                 G: Optional[ArrayLike] = None, B: Optional[ArrayLike] = None, c: Optional[ArrayLike] = None,
                 D: Optional[ArrayLike] = None, d: Optional[ArrayLike] = None, x0: Optional[ArrayLike] = None,
                 P0: Optional[ArrayLike] = None, unknown: Union[str, Sequence[Union[int, str]]] = (),
                 states: Quantities = None, measurements: Quantities = None, controls: Quantities = None,
                 gaps: Gaps = Gaps(), name: str = "model"):
        self.name = name
        self.gaps = gaps
        self.continuous: Optional[Continuous] = None  # of `of_continuous`
        self.sensors: tuple[Sensor, ...] = ()  # of a model file that names them
        self.builder: Optional[Mapping[str, Any]] = None  # what its builder was given
        self.recording: Mapping[str, Any] = {}  # what its file says of data files
        self.constants: dict[str, float] = {}  # what a fit has estimated of that
        self.A = _square("A", A)
        self.n = len(self.A)
        self.H = _rows("H", H, self.n)
        self.m = len(self.H)
        self.R = _covariance("R", R, self.m)
        if (Q is None) == (G is None):
            raise ModelError("Q", "give either Q or G, with Q = G G'")
        self.G = None if G is None else _columns("G", G, self.n)
        self.Q = _covariance("Q", Q, self.n) if self.G is None else _fixed(self.G @ self.G.T)
        self.D = None if D is None else _columns("D", D, self.m, "measurement")
        self.B = _pushes(B if D is None or B is not None else np.zeros((self.n, self.D.shape[1])), c, self.n)
        self.l = 0 if self.B is None else self.B.shape[1]
        if self.D is not None and self.D.shape[1] != self.l - (c is not None):
            raise ModelError("D", f"is {_shape(self.D)}: it has a column for each of {counted(self.l - (c is not None), 'control')}")
        self.d = None if d is None else _vector("d", d, self.m)
        self.states = _quantities("states", states, self.n, "x")
        self.measurements = _quantities("measurements", measurements, self.m, "z")
        self.controls = _quantities("controls", controls, self.l - (c is not None), "u") + (() if c is None else (ONE,))
        self.unknown = self._unknown("all" if P0 is None else unknown)
        self.x0 = _vector("x0", np.zeros(self.n) if x0 is None else x0, self.n)
        self.P0 = _covariance("P0", np.zeros((self.n, self.n)) if P0 is None else P0, self.n)

    @property
    def c(self) -> Optional[np.ndarray]:
        return None if self.B is None or not self.controls[-1].constant else self.B[:, -1]

    @property
    def sensor_sizes(self) -> list[int]:
        """Measurements of each sensor; where none has a name there is one"""
        return [len(one.measurements) for one in self.sensors] or [self.m]

    @property
    def inputs(self) -> tuple[Quantity, ...]:
        """Controls that come from outside"""
        return tuple(one for one in self.controls if not one.constant)

    @property
    def frame(self) -> Model:
        """The model without D, for filters of z - D u; itself, where it has none"""
        if self.D is None:
            return self
        reach = [sum(abs(by) * (one.range or 0.0) for by, one in zip(row, self.controls) if by) for row in self.D]
        wider = [one if one.range is None else replace(one, range=one.range + more) for one, more in zip(self.measurements, reach)]
        return self.changed(D=None, measurements=wider)

    @classmethod
    @by_name("Model.of_continuous(F, H=..., R=..., Qc=..., dt=...)")
    def of_continuous(cls, F: ArrayLike, *, H: ArrayLike, R: ArrayLike, Qc: ArrayLike, dt: float,
                      B: Optional[ArrayLike] = None, c: Optional[ArrayLike] = None, L: Optional[ArrayLike] = None, jitter: float = 0.0, time_unit: str = "s",
                      **more: Any) -> Model:
        """Of x' = F x + B u + c + noise with spectral density Qc (n x n, or n of independent noises; unit^2 / s, where dt is in s),
        in steps of dt, or where rows have times, between those.  Controls stay as they are over a step.
        L: n x r, where r noises move the states, x' = F x + B u + L w: Qc is of w, r x r, or r of independent noises
        jitter: share of dt, below 1/2, by which a step may be off from a multiple of it, and is taken for that.
        time_unit: of dt, F and Qc, and of `times` that are given: ms, s, min, h, day, week or year (31556952 s)
        more: as in Model"""
        F_ = _square("F", F)
        n = len(F_)
        if isinstance(dt, bool) or not isinstance(dt, (int, float)) or not 0 < dt < np.inf:
            raise ModelError("dt", "is not a number above 0: the time of a row")
        if isinstance(jitter, bool) or not isinstance(jitter, (int, float)) or not 0 <= jitter < 0.5:
            raise ModelError("jitter", "is not a share of dt from 0 to below 0.5")
        if time_unit not in UNITS:
            raise ModelError("time_unit", f"is not one of {', '.join(UNITS)}")
        if B is None and more.get("D") is not None:  # controls that move nothing
            B = np.zeros((n, _columns("D", more["D"], len(_rows("H", H, n)), "measurement").shape[1]))
        density = _covariance("Qc", Qc, n) if L is None else _density(_columns("L", L, n), Qc)
        of = Continuous(F_, density, _pushes(B, c, n), float(dt), float(jitter), time_unit)
        A, Q, B_ = of.step(of.dt)
        if not all(np.all(np.isfinite(one)) for one in (A, Q)):
            raise ModelError("dt", "is so long that the model is not representable: give a shorter one, or take other units")
        if np.any(np.diag(Q) < 0):
            raise ModelError("Qc", "is no covariance: over a step of dt it makes a negative variance; an entry [i,j] is at most sqrt([i,i] [j,j])")
        made = cls(A, H=H, R=R, Q=Q, **_split(B_, c is not None), **more)
        made.continuous = of
        return made

    @classmethod
    def of(cls, **given: Any) -> Model:
        """Of what a model file or a builder gives: of continuous time, or of steps"""
        return (cls.of_continuous if "F" in given else cls)(**given)

    def flowing(self, *, F: Optional[np.ndarray] = None, Qc: Optional[np.ndarray] = None, **more: Any) -> Model:
        """A model in continuous time with another F, or Qc (None: as it is), and `more` as of `changed`"""
        assert self.continuous is not None
        of = replace(self.continuous, **{name: _fixed(one) for name, one in (("F", F), ("Qc", Qc)) if one is not None})
        A, Q, B = of.step(of.dt)
        made = self.changed(**more) if F is None and Qc is None else self.changed(A=A, Q=Q, B=B, **more)
        made.continuous = of
        return made

    def jittered(self, share: float) -> Model:
        """A model in continuous time with another jitter"""
        assert self.continuous is not None
        made = self.changed()
        made.continuous = replace(self.continuous, jitter=share)
        return made

    def _unknown(self, given: Union[str, Sequence[Union[int, str]]]) -> np.ndarray:
        mask = np.zeros(self.n, bool)
        names = [state.name for state in self.states]
        for which in range(self.n) if isinstance(given, str) and given == "all" else given:
            if which in names:
                mask[names.index(which)] = True
            elif isinstance(which, (int, np.integer)) and 0 <= which < self.n:
                mask[which] = True
            else:
                raise ModelError("unknown", f"there is no state {which!r}")
        mask.setflags(write=False)
        return mask

    def changed(self, **what: object) -> Model:
        """The model with some of what it was made of in another way."""
        made = dict(
            A=self.A, H=self.H, R=self.R, Q=None if self.G is not None else self.Q, G=self.G,
            **_split(self.B, self.c is not None), D=self.D, d=self.d, x0=self.x0, P0=self.P0, unknown=np.flatnonzero(self.unknown).tolist(), states=self.states,
            measurements=self.measurements, controls=self.inputs, gaps=self.gaps, name=self.name)
        if "Q" in what:
            made["G"] = None
        if "G" in what:
            made["Q"] = None
        if self.c is not None and np.shape(what.get("B")) == self.B.shape and "c" not in what:  # with c in it
            what = {**what, **_split(np.asarray(what["B"]), True)}
        other = Model(**{**made, **what})  # type: ignore[arg-type]
        other.continuous = None if what.keys() & {"A", "B", "c", "Q", "G"} else self.continuous
        other.sensors = self.sensors if [one.name for one in other.measurements] == [one.name for one in self.measurements] else ()
        other.builder = self.builder if what.keys() <= {"states", "measurements", "gaps", "name", "d"} and self.D is None else None
        other.recording = self.recording
        if other.builder and "d" in what:
            offsets = {} if other.d is None else {"d": other.d.tolist()}
            other.builder = {**{key: one for key, one in other.builder.items() if key != "d"}, **offsets}
        return other

    def with_noise(self, name: str, given: np.ndarray) -> Model:
        """`changed` of a Q, G or R that was looked at: the rest is shared"""
        made, array = copy(self), _fixed(given)
        made.__dict__.update({"R": array} if name == "R" else {"Q": array, "G": None} if name == "Q" else {"G": array, "Q": _fixed(array @ array.T)})
        return made

    if not TYPE_CHECKING:
        def __setattr__(self, name: str, value: Any) -> None:
            if name in _FIXED and name in self.__dict__:
                raise AttributeError(f"{name}: a model stays as it is: model.changed({name}=...) answers another one")
            super().__setattr__(name, value)

    def __repr__(self) -> str:
        return f"Model({self.name!r}, n={self.n}, m={self.m}, l={len(self.inputs)})"


ONE = Quantity("1", range=1.0, fraction=30, constant=True)


def _pushes(B: Optional[ArrayLike], c: Optional[ArrayLike], n: int) -> Optional[np.ndarray]:
    """B, and c as its last column"""
    if c is None:
        return None if B is None else _columns("B", B, n)
    offset = _vector("c", c, n)[:, None]
    return _columns("B", offset if B is None else np.hstack([_columns("B", B, n), offset]), n)


def _split(B: Optional[np.ndarray], has_offset: bool) -> dict[str, Optional[np.ndarray]]:
    """The other way round, as a Model takes them"""
    if not has_offset or B is None:
        return {"B": B}
    return {"B": B[:, :-1] if B.shape[1] > 1 else None, "c": B[:, -1]}


def root_of(P: np.ndarray) -> np.ndarray:
    """L with P = L L', of a P that may be singular, or of several.  Eigenvalues lose variances that are far below others: such a P has the
    root of its correlations.  Others keep theirs, so that a seed draws what it drew"""
    sigma = np.sqrt(np.diagonal(P, axis1=-2, axis2=-1))[..., None]
    unit = np.where(sigma > 0, sigma, 1.0)
    of_pairs = unit * unit.swapaxes(-1, -2)
    made, scaled = _eigen_root(P), unit * _eigen_root(P / of_pairs)
    is_lost = np.any(np.abs(made @ made.swapaxes(-1, -2) - P) > ROOT_LOST * of_pairs, axis=(-2, -1))
    return np.where(is_lost[..., None, None], scaled, made)


def _eigen_root(P: np.ndarray) -> np.ndarray:
    values, vectors = np.linalg.eigh(P)
    return vectors * np.sqrt(values.clip(0))[..., None, :]


def _fixed(array: np.ndarray) -> np.ndarray:
    made = np.array(array, np.float64, order="C")
    made.setflags(write=False)
    return made


def _numbers(name: str, given: ArrayLike) -> np.ndarray:
    try:
        array = numbers_of(given)
    except (TypeError, ValueError, OverflowError) as problem:
        lost = f" ({problem})" if "complex" in str(problem) else ""
        raise ModelError(name, f"not an array of numbers, with rows of one length{lost}") from problem
    if not np.all(np.isfinite(array)):
        raise not_finite(name, array)
    return array


def not_finite(name: str, array: np.ndarray) -> ModelError:
    at = np.argwhere(~np.isfinite(array))[0]
    return ModelError(name, f"has an entry that is not finite: {f'{name}[{chr(44).join(map(str, at))}]' if len(at) else 'it'} is {array[tuple(at)]}")


def _shape(array: np.ndarray) -> str:
    return " x ".join(map(str, array.shape)) if array.ndim else "a number"


def _square(name: str, given: ArrayLike) -> np.ndarray:
    array = np.atleast_1d(_numbers(name, given))
    if array.ndim == 1 and len(array) == 1:
        array = array.reshape(1, 1)
    if array.ndim != 2 or array.shape[0] != array.shape[1]:
        raise ModelError(name, f"is {_shape(array)}, not square")
    return _sized(name, array)


def _sized(name: str, array: np.ndarray) -> np.ndarray:
    if not 1 <= len(array) <= SIZE_MAX:
        raise ModelError(name, f"has {len(array)} rows; there are 1 to {SIZE_MAX}")
    return _fixed(array)


def _rows(name: str, given: ArrayLike, columns: int) -> np.ndarray:
    """r x columns; one row may be flat."""
    array = _numbers(name, given)
    if array.ndim < 2:
        array = array.reshape(1, -1)
    if array.ndim != 2 or array.shape[1] != columns:
        raise ModelError(name, f"is {_shape(array)}: it has a column for each of {counted(columns, 'state')}")
    return _sized(name, array)


def _columns(name: str, given: ArrayLike, rows: int, of: str = "state") -> np.ndarray:
    """rows x c; one column may be flat, and of measurements one row."""
    array = _numbers(name, given)
    if array.ndim < 2:
        array = array.reshape((1, -1) if of == "measurement" and rows == 1 else (-1, 1))
    if array.ndim != 2 or array.shape[0] != rows or not 1 <= array.shape[1] <= SIZE_MAX:
        raise ModelError(name, f"is {_shape(array)}: it has a row for each of {counted(rows, of)}")
    return _fixed(array)


def _vector(name: str, given: ArrayLike, length: int) -> np.ndarray:
    array = np.atleast_1d(_numbers(name, given))
    if array.shape != (length,):
        raise ModelError(name, f"is {_shape(array)}, not {counted(length, 'number')}")
    return _fixed(array)


def _covariance(name: str, given: ArrayLike, size: int) -> np.ndarray:
    array = np.atleast_1d(_numbers(name, given))
    if array.shape == (size,):
        array = np.diag(array)
    if array.shape != (size, size):
        raise ModelError(name, f"is {_shape(array)}, not {size} x {size}, nor {counted(size, 'variance')}")
    if not np.array_equal(array, array.T) and not np.allclose(array, array.T, rtol=1e-12, atol=0):
        raise ModelError(name, "is not symmetric")
    if np.any(np.diag(array) < 0):
        k = int(np.argmin(np.diag(array)))
        raise ModelError(name, f"has a negative variance: {name}[{k},{k}] = {array[k, k]:g}")
    return _fixed((array + array.T) / 2)


def _density(L: np.ndarray, Qc: ArrayLike) -> np.ndarray:
    """L Qc L', symmetric where its sums round otherwise, too"""
    with np.errstate(over="ignore", invalid="ignore"):
        made = L @ _covariance("Qc", Qc, L.shape[1]) @ L.T
    if not np.all(np.isfinite(made)):
        raise ModelError("L", "L Qc L' is not representable: take other units")
    return _fixed((made + made.T) / 2)


def _quantities(name: str, given: Quantities, size: int, letter: str) -> tuple[Quantity, ...]:
    if given is None:
        return tuple(Quantity(f"{letter}{k + 1}") for k in range(size))
    made = tuple(one if isinstance(one, Quantity) else Quantity(str(one)) for one in given)
    if len(made) != size:
        raise ModelError(name, f"are {len(made)}, not {size}")
    names = [one.name for one in made]
    if len(set(names)) != size:
        twice = next(one for k, one in enumerate(names) if one in names[:k])
        raise ModelError(name, f"have one name twice, {twice}: each needs its own")
    return made
