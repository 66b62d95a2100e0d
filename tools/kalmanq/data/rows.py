"""What comes in: rows of measurements and controls as arrays, lists or tables of pandas."""

from __future__ import annotations

from typing import Any, Optional, Sequence

import numpy as np
from numpy.typing import ArrayLike

from kalmanq.errors import KalmanqError
from kalmanq.model import Model, Quantity
from kalmanq.model.arrays import numbers_of


def rows_of(given: Any, quantities: Sequence[Quantity], name: str) -> np.ndarray:
    """T x k of float64: a flat array where k = 1; of a DataFrame the columns with the quantities' names."""
    columns = len(quantities)
    try:
        array = numbers_of(_values(given, quantities, name))
    except (TypeError, ValueError, OverflowError) as problem:
        raise KalmanqError(f"{name}: not an array of numbers{told(problem)}") from problem
    if array.ndim == 1 and columns == 1:
        array = array.reshape(-1, 1)
    if array.ndim != 2 or array.shape[1] != columns:
        raise KalmanqError(f"{name} is {' x '.join(map(str, array.shape))}, not T x {columns}")
    return np.ascontiguousarray(array)


def controls_of(u: Any, model: Model, rows: int) -> Optional[np.ndarray]:
    """A row for each row of z."""
    if u is None:
        return None
    made = rows_of(u, model.controls, "u")
    if len(made) != rows:
        raise KalmanqError(f"u has {len(made)} rows, z has {rows}")
    return made


def _values(given: Any, quantities: Sequence[Quantity], name: str) -> Any:
    if not is_table(given):
        return given
    if hasattr(given, "columns"):
        wanted, there = [one.name for one in quantities], list(given.columns)
        for one in wanted:
            if there.count(one) != 1:
                reason = f"the column {one} is there twice" if one in there else \
                    f"there is no column {one}; there are {', '.join(map(str, there))}"
                raise KalmanqError(f"{name}: {reason}")
        given = given[wanted]
    if _is_complex(given):
        return given.to_numpy()
    # what pandas calls missing is no float by itself
    return given.to_numpy(dtype=np.float64, na_value=np.nan)


def _is_complex(table: Any) -> bool:
    """pandas leaves imaginary parts out without an error"""
    columns = [table[name] for name in table.columns] if hasattr(table, "columns") else [table]
    return any(getattr(one.dtype, "kind", "") == "c" or one.dtype == object and any(
        isinstance(value, (complex, np.complexfloating)) for value in one) for one in columns)


def told(problem: Exception) -> str:
    """Of what numbers_of refuses"""
    return f" ({problem})" if "complex" in str(problem) else ""


def is_table(given: Any) -> bool:
    """A DataFrame or a Series?  A list has an `index`, too, which is another thing."""
    return hasattr(given, "to_numpy") and hasattr(given, "index")


def index_of(z: Any, u: Any = None) -> Optional[Any]:
    """Of the table that there is; two tables have to agree."""
    tables = [one for one in (z, u) if is_table(one)]
    if len(tables) == 2 and not tables[0].index.equals(tables[1].index):
        raise KalmanqError("z and u have different indices")
    return tables[0].index if tables else None


def present_of(z: np.ndarray) -> np.ndarray:
    """A mask for each row: bit c where component c is there."""
    bits = np.uint32(1) << np.arange(z.shape[1], dtype=np.uint32)
    return ((~np.isnan(z)) * bits).sum(axis=1, dtype=np.uint32)


def row_of(given: ArrayLike, size: int, name: str) -> np.ndarray:
    try:
        row = np.atleast_1d(numbers_of(given))
    except (TypeError, ValueError, OverflowError) as problem:
        raise KalmanqError(f"{name}: not an array of numbers{told(problem)}") from problem
    if row.shape != (size,):
        raise KalmanqError(f"{name} is {row.shape}, not {size} numbers")
    return row.reshape(1, size)
