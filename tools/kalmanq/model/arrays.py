"""What is given as numbers: float64, without a part of them being lost on the way."""

from __future__ import annotations

from functools import wraps
from typing import Any, Callable, Sequence, cast

import numpy as np

from kalmanq.model.spellings import Call, spelled


def by_name(said: str, places: int = 1) -> Callable[[Call], Call]:
    """Of a call, beside its object: matrices after so many places have their names, as one of their size may be in another's place"""
    def of(call: Call) -> Call:
        inner = spelled(said)(call)

        @wraps(call)
        def named(*given: Any, **more: Any) -> Any:
            if len(given) > places + 1:
                raise TypeError(f"{said}: give the matrices by their names, in any order")
            return inner(*given, **more)
        return cast(Call, named)
    return of


def numbers_of(given: Any) -> np.ndarray:
    """A copy.  What is masked is NaN; complex numbers are refused.  TypeError or ValueError says why it is no array."""
    if isinstance(given, (list, tuple)) and any(map(np.ma.isMaskedArray, given)):
        given = np.ma.array(given)
    if isinstance(given, np.ma.MaskedArray):
        _refuse_complex(given.data)
        made = given.astype(np.float64)
        return np.array(made.filled(np.nan), np.float64)
    array = np.asarray(given)
    _refuse_complex(array)
    return np.array(array, np.float64)


def _refuse_complex(array: np.ndarray) -> None:
    if array.dtype.kind == "c" or array.dtype.kind == "O" and any(
            isinstance(one, (complex, np.complexfloating)) or getattr(getattr(one, "dtype", None), "kind", "") == "c"
            for one in array.flat):
        raise TypeError("complex numbers, of which the imaginary part would be lost")


def block_diagonal(parts: Sequence[np.ndarray]) -> np.ndarray:
    """Of numbers, or of formulas"""
    ends = np.cumsum([0, *map(len, parts)])
    made = np.zeros((ends[-1], ends[-1]), np.result_type(*parts))
    for begin, one in zip(ends, parts):
        made[begin : begin + len(one), begin : begin + len(one)] = one
    return made
