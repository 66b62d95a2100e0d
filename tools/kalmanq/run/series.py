"""Many series of one model in one call, each from the model's start."""

from __future__ import annotations

from typing import Any, Optional

import numpy as np
from numpy.typing import ArrayLike

from kalmanq.core import ffi, require, warn_of
from kalmanq.data.rows import controls_of
from kalmanq.errors import KalmanqError
from kalmanq.model import Model
from kalmanq.model.arrays import numbers_of
from kalmanq.model.column_model import refuse_rows
from kalmanq.run.filters import Filter
from kalmanq.run.readings import Results
from kalmanq.run.results import Run


def run_series(model: Model, z: ArrayLike, u: Optional[ArrayLike] = None, arithmetic: str = "f64") -> Run:
    """A filter over each of S series of T rows: what `Filter(model, arithmetic).run(z[k], u[k])` says, with an axis more in front.

    Parameters
    ----------
    model : Model
    z : S x T x m, or S x T where m = 1; NaN: missing, also after the end of a shorter one
    u : S x T x l, or S x T where l = 1
    arithmetic : "f64", "f32" or "q31"

    Raises
    ------
    KalmanqError
        says at which series and row one stopped

    Examples
    --------
    >>> kalmanq.run_series(kalmanq.Model([1], H=[1], R=1, Q=1, P0=1), [[1.0, 2.0], [3.0, np.nan]]).mean.shape
    (2, 2, 1)
    """
    refuse_rows(model, "run_series", "give each series to Filter.run")
    measured, pushed = _of_series(z, model.m, "z"), None if u is None else _of_series(u, len(model.inputs), "u")
    S, T, _ = measured.shape
    if pushed is not None and pushed.shape[:2] != (S, T):
        raise KalmanqError(f"u: {pushed.shape[0]} series of {pushed.shape[1]} rows, z has {S} of {T}")
    f = Filter(model, arithmetic)
    words = _by_row(lambda: f.parts.words(measured.reshape(S * T, -1), "measurements"), T)
    controls = controls_of(None if pushed is None else pushed.reshape(S * T, -1), model, S * T)
    carried = None if controls is None else _carried(f, _by_row(lambda: f.parts.words(controls, "controls"), T), S, T)
    out, events = Results(f, S * T, False), 0
    q = ffi.new(f"kq_sequence_{f.arithmetic.name} *")
    q.filter, q.process, q.sensor, q.steps, q.begins = f._handle, f.parts.process, f.parts.sensor, T, True
    q.z, q.u = f._pointer(words), f._pointer(carried)
    if f.arithmetic.is_fixed:
        q.widest = ffi.cast("double *", f._widest.ctypes.data)
    out.ask(q)
    q.is_upper = not np.any(np.tril(model.A, -1))
    rests, run = _rests(q, out, model), f.arithmetic.function("sequence_run")
    for k in range(S):
        if k:
            f.begin()
            for name, rest in rests:
                setattr(q, name, getattr(q, name) + T * rest)
        status = run(q)
        if status < 0:
            require(status, f"series {k}", int(q.done))
        events |= f.events
    made = out.run()
    made.events = events
    warn_of(events, f"{model.name}, {f.arithmetic.name}")
    f.warn_of_wide()
    for name in ("mean", "sigma", "innovation", "innovation_sigma", "nis", "taken", "log_likelihood"):
        one = getattr(made, name)
        setattr(made, name, one.reshape(S, T, *one.shape[1:]))
    made.words = {name: one.reshape(S, T, *one.shape[1:]) for name, one in made.words.items()}
    return made


def _of_series(given: ArrayLike, columns: int, name: str) -> np.ndarray:
    try:
        made = numbers_of(given)
    except (TypeError, ValueError, OverflowError):  # series of several lengths, too
        raise KalmanqError(f"{name}: not an array of numbers: S x T x {columns}, with NaN after the end of a shorter series") from None
    made = made[..., None] if made.ndim == 2 and columns == 1 else made
    if made.ndim != 3 or made.shape[2] != columns or not made.size:
        raise KalmanqError(f"{name} is {' x '.join(map(str, made.shape)) or 'no array'}, not S x T x {columns}")
    return made


def _by_row(make: Any, T: int) -> np.ndarray:
    """Its KalmanqError says the series, too"""
    try:
        return make()
    except KalmanqError as problem:
        if problem.row is None:
            raise
        raise KalmanqError(f"series {problem.row // T}: {problem.text}", problem.status, problem.row % T) from None


def _carried(f: Filter, controls: np.ndarray, S: int, T: int) -> np.ndarray:
    """What moves the state to each row; nothing does to the first of a series"""
    made = f.arithmetic.empty(S, T, f.model.l)
    made[:, 1:] = controls.reshape(S, T, -1)[:, :-1]
    return made


def _rests(q: Any, out: Results, model: Model) -> list[tuple[str, int]]:
    """Pointers of a row after another, and the numbers of a row"""
    widths = {"z": model.m, "u": model.l, "taken": 1, **{name: 1 for name in out.scores},
              **{name: one.shape[1] for name, one in {**out.numbers, **out.any_size}.items()}}
    return [(name, width) for name, width in widths.items() if getattr(q, name) != ffi.NULL]
