"""Times that are given as dates, durations or numbers, and those that the index of a table has.  pandas is not needed for it."""

from __future__ import annotations

import warnings
from datetime import date, datetime, timedelta, timezone
from typing import Any, Optional

import numpy as np

from kalmanq.data.time_columns import PER_SECOND, unit_in
from kalmanq.data.times import IRREGULAR, NAMES, Times
from kalmanq.errors import KalmanqError, KalmanqWarning
from kalmanq.model.arrays import numbers_of

NO_TIMES = "times: not numbers, dates or durations: numpy.array(texts, 'datetime64[ns]') or pandas.to_datetime makes dates of texts"
COUNTED = ("ns", "us", "ms", "s")  # whole numbers of such a unit are exact as dates


def numbers_from(given: Any, unit: float, origin: Optional[np.datetime64] = None) -> tuple[np.ndarray, Optional[np.datetime64]]:
    """Times in units of so many seconds, dates since `origin` or the first of them; and what dates are counted from"""
    made, begun = _moments(given), None
    if made.dtype.kind == "M":
        begun = made.flat[0] if origin is None and made.size else origin
        made = made - begun if made.size else made.astype(float)
    return (made / np.timedelta64(1, "s") / unit if made.dtype.kind == "m" else made), begun


def step_from(given: Any, unit: float) -> float:
    """The time to the next row, in units of so many seconds"""
    made, begun = numbers_from([given], unit)
    if begun is not None or made.shape != (1,) or not 0 < made[0] < np.inf:
        raise KalmanqError("dt: not a number or a duration above 0")
    return float(made[0])


def _moments(given: Any) -> np.ndarray:
    """datetime64, timedelta64 or float64; what is missing is NaT or NaN"""
    try:
        made = given if isinstance(given, np.ma.MaskedArray) else np.asarray(given)
        made = _of_objects(made) if made.dtype.kind == "O" else made
        if made.dtype.kind not in "mM":
            return numbers_of(made)
        if isinstance(made, np.ma.MaskedArray):
            made = made.filled(made.dtype.type("NaT"))
        unit = np.datetime_data(made.dtype)[0]
        if unit == "generic" or made.dtype.kind == "m" and unit in "YM":
            raise KalmanqError("times: durations in months, or without a unit, have no length: give them in seconds")
        return made.astype("datetime64[D]") if unit in "YM" else made
    except (TypeError, ValueError, OverflowError) as problem:
        raise KalmanqError(NO_TIMES) from problem


def _of_objects(array: np.ndarray) -> np.ndarray:
    """Dates and durations of Python, NumPy or pandas; numbers stay"""
    there = [one for one in array.flat if one is not None and one == one]
    if not there or not any(isinstance(there[0], kind) for kind in (date, timedelta, np.datetime64, np.timedelta64)) and \
            not hasattr(there[0], "to_timestamp"):
        return array
    if len({getattr(one, "tzinfo", None) is None for one in there}) > 1:
        raise KalmanqError("times: some have a time zone, others have none: write all alike")
    missing = type(_moment(there[0]))("NaT")
    return np.array([_moment(one) if one is not None and one == one else missing for one in array.flat]).reshape(array.shape)


def _moment(one: Any) -> Any:
    """datetime64 (of UTC, where it has a time zone) or timedelta64"""
    one = one.to_timestamp() if hasattr(one, "to_timestamp") else one  # a period of pandas begins then
    for name in ("to_datetime64", "to_timedelta64"):
        if hasattr(one, name):
            return getattr(one, name)()  # with nanoseconds, which a datetime has not
    if isinstance(one, datetime) and one.tzinfo is not None:
        one = one.astimezone(timezone.utc).replace(tzinfo=None)
    if isinstance(one, (date, np.datetime64)):
        return np.datetime64(one)
    if isinstance(one, (timedelta, np.timedelta64)):
        return np.timedelta64(one)
    raise TypeError


# ------------------------------------------------------------------------------ the index of a table


def counts_rows(index: Any) -> bool:
    return _kind(index) == "i" and bool(np.all(np.diff(np.asarray(index)) == 1)) and not _is_named_time(index)


def in_index(index: Any, unit: float, dt: Optional[float], name: str, what: str = "index") -> Optional[Any]:
    """What an index, or a column, says of when the rows are: dates, durations, or numbers in units of so many seconds; None: it counts
    rows.  KalmanqError: it may be either, or is neither.  dt: of a row, in the same unit, if it is known"""
    kind, values = _kind(index), np.asarray(index)
    if kind in "mM":
        return index
    cure = f"give times=, or {name}.to_numpy() where each row is one step"
    said = _unit_of(index)
    if kind == "f":
        return values / PER_SECOND[said] / unit if said else values
    if kind != "i":
        raise KalmanqError(f"{name}: its {what} has no times: pandas.to_datetime makes dates of texts; or {cure}")
    if said:
        return values.astype(f"datetime64[{said}]") if said in COUNTED else values / PER_SECOND[said] / unit
    if counts_rows(index) or dt is not None and np.all(np.diff(values) == dt):
        return None
    raise KalmanqError(f"{name}: its {what} of whole numbers may be times or numbers of rows: {cure}")


def warn_of_steps(index: Any, name: str, what: str, cure: str) -> None:
    """Of a model that takes each row for one step, where the index says that they are not alike"""
    kind = _kind(index)
    if kind not in "mMif" or len(index) < 3:
        return
    steps = np.diff(numbers_from(index, 1.0)[0])
    steps = np.where(np.isfinite(steps), steps, 0.0) if kind in "mM" else steps
    if getattr(index, "freq", None) is not None and np.all(steps > 0):
        return  # business days, too, are what someone has called a step
    if kind == "i" and not _is_named_time(index) and not _rises_like_a_clock(steps):
        return
    if kind in "mMf" and np.any(steps <= 0):
        warnings.warn(f"{name}: row {int(np.argmax(steps <= 0)) + 1}: the time of the {what} is not after the one before: each row is taken "
                      "for one step of the model; sort the rows, and join rows of one time", KalmanqWarning, stacklevel=5)
        return
    judged = Times("", 0)
    judged.take(steps, np.arange(1, len(index)), 0.0)
    judged.warn(name, cure, f"the {what}", 6)


def _kind(index: Any) -> str:
    """m, M, i, f as of NumPy; O: of neither times nor numbers"""
    if getattr(index, "nlevels", 1) > 1:
        return "O"
    values = np.asarray(index)
    if values.dtype.kind == "O":
        try:
            values = _moments(values)
        except KalmanqError:
            return "O"
    return {"u": "i"}.get(values.dtype.kind, values.dtype.kind)


def _unit_of(index: Any) -> str:
    return unit_in(index.name) if isinstance(getattr(index, "name", None), str) else ""


def _is_named_time(index: Any) -> bool:
    name = getattr(index, "name", None)
    return isinstance(name, str) and bool(NAMES.fullmatch(name) or unit_in(name))


def _rises_like_a_clock(steps: np.ndarray) -> bool:
    """Mostly by the same step: rows were left out of it"""
    return bool(np.all(steps > 0) and np.mean(np.abs(steps / np.median(steps) - 1) < IRREGULAR) > 0.5)
