"""What is to be compiled: a model as its C has it, and the options."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Iterable, Optional, Sequence

import numpy as np

from kalmanq.compiler.given.exact import Numbers, decimals, joseph
from kalmanq.compiler.given.names import identifiers, named
from kalmanq.errors import KalmanqError
from kalmanq.firmware.steps_kept import latest_of
from kalmanq.model import Model, Quantity
from kalmanq.model.column_model import refuse_rows

ARITHMETICS = ("f32", "f64", "q31")
FLOATS = {"f32": np.float32, "f64": np.float64}
GAP = 8  # samples that may be missing where the model declares none
LONGEST_GAP = 16  # samples, of which it is known how soon the gain is constant again
STUDENT_STEPS = 3  # of EM, to the variance that a measurement with the noise of Student is taken with
RUN = 8  # rejections in a row after which a gate takes all, until one is near again
INSTEAD = {  # of the C without the library: an option, and over the library what is in its place
    "gate": ("--robust gate", "kq_update_robust with kq_loss_gate (kalmanq/robust.h)"),
    "student": ("--robust student", "kq_update_robust with kq_loss_student (kalmanq/robust.h)"),
    "nis": ("--nis", "kq_nis and kq_log_likelihood of NAME_filter (kalmanq/filter.h)"),
    "smooth": ("--smooth", "kq_smooth of a history (kalmanq/smoother.h)"),
    "lag": ("--lag", "kq_lag, attached to NAME_filter (kalmanq/lag.h)"),
    "every": ("--every", "NAME_update, which takes what is present of a row"),
    "tunable": ("--tunable", "`kalmanq design --any-dt` for steps of any length, and for other A, Q and R leave --library out instead"),
    "loops": ("--loops or --straight", "loops in any case")}
FLOAT = np.finfo(np.float32)
WIDE = 1e4  # sigma of an unknown state, in sigmas that it has once it is known


@dataclass(frozen=True)
class Options:
    """settle: of a variance, relative, where the gain counts as constant; gate: of an innovation, in sigma;
    student: degrees of freedom; nis: NIS, the likelihood and variances of innovations are kept; tunable: A, Q and R are fields; lag: the mean so many samples ago, too;
    loops: of the factor in the place of straight lines; None: where those would be very long;
    every: of each measurement, in rows, where they have different rates; iterate: linearisations of h in an update, of a
    nonlinear model; smooth: steps that its history holds"""

    arithmetic: str = "f32"
    settle: float = 1e-6
    nis: bool = False
    gate: Optional[float] = None
    student: Optional[float] = None
    tunable: bool = False
    lag: int = 0
    loops: Optional[bool] = None
    every: Sequence[int] = ()
    iterate: int = 1
    smooth: int = 0

    @property
    def settles(self) -> bool:
        """May the gain be a constant?"""
        return self.student is None and not self.tunable


def refuse_over_library(options: Options, fields: Iterable[str]) -> None:
    for field in fields:
        if getattr(options, field) != getattr(Options(), field):
            option, instead = INSTEAD[field]
            raise KalmanqError(f"--library and {option}: leave {option} out; over the library it is {instead}")


@dataclass(frozen=True, eq=False)  # what is worked out of one is kept by which it is
class Request:
    """mixing: m x m, unit lower: what the filter takes is mixing * z, whose noises are independent; together: of each
    component, the bits of those that are taken only with it; nominal: names of what the states are errors of"""

    name: str
    model: Model
    of: Numbers
    mixing: np.ndarray
    together: Sequence[int]
    states: Sequence[str]
    measurements: Sequence[str]
    controls: Sequence[str]
    options: Options
    nominal: Sequence[str] = ()

    @property
    def carried(self) -> Sequence[str]:
        """Names of the numbers of its mean: of the states, or of what these are errors of"""
        return self.nominal or self.states

    @property
    def all(self) -> int:
        return (1 << self.of.m) - 1

    @property
    def inputs(self) -> int:
        """Controls that are given"""
        return sum(not one.constant for one in self.model.controls)

    @property
    def offsets(self) -> np.ndarray:
        """Of what is taken of the measurements"""
        d = getattr(self.model, "d", None)
        return np.zeros(self.of.m) if d is None else self.mixing @ d

    @property
    def sensors(self) -> list[tuple[str, int, int]]:
        """Of a model file that names several: of each its name in C, its first component, and how many it has"""
        of = self.model.sensors if isinstance(self.model, Model) and self.of.m > 1 else ()
        sizes = [len(one.measurements) for one in of]
        first = np.concatenate([[0], np.cumsum(sizes)[:-1]]).astype(int) if sizes else []
        names = ["some_" if name == "some" else name for name in identifiers([Quantity(one.name) for one in of])]
        return [(name, int(at), size) for name, at, size in zip(names, first, sizes)]

    @property
    def type(self) -> str:
        return f"{self.name}_filter"

    @property
    def upper(self) -> str:
        return self.name.upper()


def due(every: Sequence[int], row: int) -> int:
    """Bits of the measurements that a row has"""
    return sum(1 << j for j, one in enumerate(every) if row % one == 0)


def request(model: Model, name: str, options: Options) -> Request:
    refuse_rows(model, "C of a constant model", "kalmanq compile writes C of functions of its columns and controls")
    _refuse(model, options)
    made = _independent(model)
    start = model.P0 if not np.any(model.unknown) else _wide_start(model, made[0])
    of = replace(made[0], P0=decimals(np.asarray(start, float)))
    return Request(name, model, of, *made[1:], *named(model.states, model.measurements, model.controls), options)


def _independent(model: Model) -> tuple[Numbers, np.ndarray, list[int]]:
    """Its numbers, which the C has as its arithmetic rounds them; measurements are mixed where their noises are correlated."""
    B = np.zeros((model.n, 0)) if model.B is None else model.B
    lower, variances = _unit_lower(model.R)
    mixing = np.linalg.inv(lower)
    made = [decimals(np.asarray(one, float)) for one in
            (model.A, B, mixing @ model.H, model.Q, variances, model.x0, model.P0)]
    return Numbers(*made), mixing, groups(model.R)


def _unit_lower(R: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    root = np.linalg.cholesky(R)
    diagonal = np.diag(root)
    alone = np.count_nonzero(R, axis=1) == 1  # its variance to the last bit
    return root / diagonal, np.where(alone, np.diag(R), diagonal**2)


def groups(R: np.ndarray) -> list[int]:
    """Of each component the bits of all whose noises depend on its own, in one way or another"""
    m = len(R)
    linked = (np.abs(R) > 0) | np.eye(m, dtype=bool)
    for _ in range(m):
        linked = (linked.astype(int) @ linked.astype(int)) > 0
    return [sum(1 << j for j in range(m) if linked[k, j]) for k in range(m)]


def _wide_start(model: Model, of: Numbers) -> np.ndarray:
    """P0 with a sigma for what is unknown, 10^4 times what it is once it is known: off by 10^-8 then.

    Known: by the information of so many samples that it has full rank."""
    known = np.diag(model.P0).copy()
    least = first_variances(of.doubles(), model.unknown)
    ranges = np.array([np.inf if one.range is None else one.range for one in model.states])
    sigma = np.minimum(WIDE * np.sqrt(np.where(np.isfinite(least), least, 1.0)), ranges)
    P0 = np.where(np.logical_or.outer(model.unknown, model.unknown), 0, model.P0)
    np.fill_diagonal(P0, np.where(model.unknown, np.maximum(sigma**2, known), known))
    return P0


def first_variances(of: Numbers, unknown: np.ndarray) -> np.ndarray:
    """The variance that each state has when the first n + 1 samples are in, from next to no prior"""
    scale = 1 / np.maximum(np.abs(of.H).max(axis=0), 1e-30)
    wide = np.where(unknown, 1e8 * of.R.max() * np.maximum(scale, scale[np.abs(of.H).max(axis=0) > 0].min())**2,
                    np.diag(of.P0))
    P = np.diag(np.minimum(wide, 1e30))
    for _ in range(2 * of.n + 1):
        for h, r in zip(of.H, of.R):
            P = joseph(P, h, r)
        P = of.A @ P @ of.A.T + of.Q
    return np.diag(P)


def no_noise(name: str) -> KalmanqError:
    return KalmanqError(f"R: {name} has no noise, and a filter divides by its variance: give it one, for example the square of the "
                        "sensor's resolution over 12")


def _refuse(model: Model, options: Options) -> None:
    latest_of(model)
    for one, variance in zip(model.measurements, np.diag(model.R)):
        if variance <= 0:
            raise no_noise(one.name)
    for name, matrix in (("Q", model.Q), ("P0", model.P0), ("R", model.R)):
        scale = np.sqrt(np.maximum(np.diag(matrix), 0))
        scaled = matrix / np.outer(np.where(scale > 0, scale, 1), np.where(scale > 0, scale, 1))
        if np.linalg.eigvalsh(scaled).min() < (1e-12 if name == "R" else -1e-9):
            raise KalmanqError(f"{name}: is no covariance: it is not positive {'' if name == 'R' else 'semi-'}definite: give one whose "
                               f"eigenvalues are {'above 0' if name == 'R' else '0 or more'}")
    if options.arithmetic == "f32":
        _refuse_beyond(model)
    for one in (*model.states, *model.measurements, *model.controls) if options.arithmetic != "f64" else ():
        _require_float(f"the range of {one.name}", 1.0 if one.range is None else one.range)
    for name, value in (("--robust gate", options.gate), ("--robust student", options.student), ("settle", options.settle)):
        if value is not None and not 0 < value < np.inf:
            raise KalmanqError(f"{name}: {value:g} is not a positive number: give one above 0")
    if options.loops and options.tunable:
        raise KalmanqError("--loops: the tables of loops are constants: leave --tunable or --loops out")
    if options.gate is not None and options.student is not None:
        raise KalmanqError("gate and student: each is an answer to outliers: leave one of them out")


def _refuse_beyond(model: Model) -> None:
    """What a float cannot hold"""
    for name in ("A", "B", "H", "Q", "R", "x0", "P0"):
        matrix = getattr(model, name)
        for at in np.argwhere(matrix != 0) if matrix is not None else ():
            _require_float(f"{name}[{','.join(map(str, at))}]", matrix[tuple(at)])


def _require_float(name: str, value: float) -> None:
    if not FLOAT.tiny <= abs(value) <= FLOAT.max:
        raise KalmanqError(f"{name}: {value:g} is {'above' if abs(value) > 1 else 'below'} what a float can hold; use other units, or --arith f64")
