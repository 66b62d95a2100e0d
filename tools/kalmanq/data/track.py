"""What was estimated as a track: measurements east, north and up of the states, as latitude, longitude and height."""

from __future__ import annotations

from contextlib import contextmanager
from pathlib import Path
from typing import Any, Callable, Iterator, Optional, Sequence

import numpy as np

from kalmanq.data.ground import AXES, Begun, degrees
from kalmanq.errors import KalmanqError
from kalmanq.model import Model

SUFFIX = ".gpx"


def axes_of(model: Any) -> list[int]:
    """Which measurements are east, north and up"""
    if not isinstance(model, Model):
        raise KalmanqError("a track of GPX is of a linear model: --out OUT.csv has all columns of a nonlinear one")
    columns = [one.reading.column or one.name for one in model.measurements]
    found = [columns.index(axis) for axis in AXES if axis in columns]
    if not set(AXES[:2]) <= set(columns):
        raise KalmanqError("a track of GPX is of measurements named east and north (and up), which latitude and longitude become: name them so")
    return found


def metres(model: Model, x: np.ndarray) -> np.ndarray:
    """Where the states (T x n) are, as sensors without noise would say it"""
    made = []
    for k in axes_of(model):
        seen, reading = np.flatnonzero(model.H[k]), model.measurements[k].reading  # other states may not be known yet
        z = x[:, seen] @ model.H[k, seen] + (0.0 if model.d is None else model.d[k])
        made.append((z - reading.offset) / reading.factor)
    return np.column_stack(made)


@contextmanager
def writing(path: Path, model: Any, inputs: Sequence[Any]) -> Iterator[Callable[[np.ndarray, Optional[np.ndarray], Begun], None]]:
    """`write` takes states, times in seconds, and what the data began with"""
    from kalmanq.data.readers import gpx  # its library is an extra

    with gpx.writing(path, inputs) as write:
        def places(x: np.ndarray, times: Optional[np.ndarray], begun: Begun) -> None:
            if begun.place is None:
                raise KalmanqError(f"--out {path}: the data have no latitude and longitude: write OUT.csv")
            dated = times is not None and begun.date is not None
            write(degrees(metres(model, x), begun.place), begun.date + np.round(times * 1e9).astype("timedelta64[ns]") if dated else None)

        yield places
