"""Latitude and longitude as metres east, north and up of an origin, and back: on the ellipsoid of WGS 84, by pymap3d."""

from __future__ import annotations

from functools import partial
from typing import Any, NamedTuple, Optional, Sequence

import numpy as np

from kalmanq.data.layouts import Source, TableError, unit_of, without_unit
from kalmanq.data.readers import INSTALL
from kalmanq.errors import KalmanqError

AXES = ("east", "north", "up")
LATITUDES, LONGITUDES = ("lat", "latitude", "latitude_deg"), ("lon", "lng", "long", "longitude", "longitude_deg")
HEIGHTS = ("height", "ele", "elevation", "alt", "altitude", "altitude_msl_m", "hmsl")  # the first one that is there
METRES = {"": 1.0, "m": 1.0, "mm": 1e-3, "cm": 1e-2, "km": 1e3, "ft": 0.3048}
WHOLE = 1e-7  # degrees, of receivers that say whole numbers


class Begun(NamedTuple):
    """Of the rows of a table: latitude, longitude and height of the origin, and the date that times are counted from, where they have them"""

    place: Optional[tuple[float, float, float]] = None
    date: Optional[np.datetime64] = None


class Ground:
    """Columns of a table that say where it was.  axes: what can be made of them; places: of latitude, longitude, and height if there is one"""

    def __init__(self, source: Source, header: Sequence[str]):
        self.source, self.header = source, header
        self.places = _places(header)
        self.axes = AXES[:len(self.places)] if self.places else ()
        self.origin: Optional[tuple[float, float, float]] = None

    def metres(self, columns: Sequence[np.ndarray], lines: Sequence[int]) -> dict[str, np.ndarray]:
        """columns: of `places`"""
        latitude, longitude = (self._degrees(column, most, place, lines) for column, most, place in zip(columns, (90, 360), self.places))
        height = columns[2] * METRES.get(unit_of(self.header[self.places[2]]), 1.0) if len(columns) > 2 else 0.0 * latitude
        is_there = ~np.isnan(latitude + longitude)
        if self.origin is None and np.any(is_there):
            self.origin = self._begun(latitude, longitude, height, int(np.argmax(is_there)))
        if self.origin is None:
            return {axis: np.full(len(latitude), np.nan) for axis in self.axes}
        level = np.where(np.isnan(height), self.origin[2], height)
        east, north, up = _pymap3d(self.source).geodetic2enu(latitude, longitude, level, *self.origin)
        return dict(zip(self.axes, (east, north, np.where(np.isnan(height), np.nan, up))))

    def _degrees(self, values: np.ndarray, most: float, place: int, lines: Sequence[int]) -> np.ndarray:
        there = values[~np.isnan(values)]
        if np.any(np.abs(there) > 1e4) and np.all(there == np.round(there)):
            values = WHOLE * values
        wrong = np.abs(values) > most
        if np.any(wrong):
            row = int(np.argmax(wrong))
            raise TableError(self.source, f"{values[row]:.9g} is no angle in degrees, nor a whole number of 1e-7 degrees: convert it, or name a column that is",
                             lines[row], self.header[place])
        return values

    def _begun(self, latitude: np.ndarray, longitude: np.ndarray, height: np.ndarray, row: int) -> tuple[float, float, float]:
        """As the model file says it, or the first place"""
        said = list(self.source.layout.origin or (latitude[row], longitude[row]))
        there = height[~np.isnan(height)]
        return float(said[0]), float(said[1]), float(said[2] if len(said) > 2 else there[0] if len(there) else 0.0)


def _places(header: Sequence[str]) -> tuple[int, ...]:
    """The first pair whose names have one beginning, as GPS.lat and GPS.lon"""
    names = [without_unit(cell).rpartition(".") for cell in header]
    for place, (before, _, name) in enumerate(names):
        if name.lower() in LATITUDES:
            others = [next((k for name in of for k, one in enumerate(names) if one[0] == before and one[2].lower() == name), None)
                      for of in (LONGITUDES, HEIGHTS)]
            if others[0] is not None:
                return tuple(one for one in (place, *others) if one is not None)
    return ()


def degrees(metres: np.ndarray, origin: tuple[float, float, float]) -> np.ndarray:
    """T x 2 or T x 3 of metres.  Without `up`, or where it is not known, at the height of the origin, however far"""
    pymap3d = _pymap3d(None)
    if metres.shape[1] > 2:
        made = np.column_stack(pymap3d.enu2geodetic(*metres.T, *origin))
        if (flat := np.isnan(metres[:, 2])).any():
            made[flat, :2] = degrees(metres[flat, :2], origin)
        return made
    up = np.zeros(len(metres))
    for _ in range(4):  # the plane leaves the ellipsoid by 8 m in 10 km
        made = np.column_stack(pymap3d.enu2geodetic(*metres.T, up, *origin))
        up = up - (made[:, 2] - origin[2])
    return made[:, :2]


def _pymap3d(source: Optional[Source]) -> Any:
    try:
        import pymap3d  # an extra, which nothing else needs
    except ImportError:
        raise (KalmanqError if source is None else partial(TableError, source))(f"metres of latitude and longitude are made by pymap3d, which is not installed: {INSTALL}") from None
    return pymap3d
