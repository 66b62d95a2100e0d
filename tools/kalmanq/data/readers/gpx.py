"""GPX: the points of all tracks and routes, or else the waypoints; and a track of what was estimated."""

from __future__ import annotations

from contextlib import contextmanager
from datetime import timezone
from math import isnan
from pathlib import Path
from typing import Any, Callable, Iterator, Optional, Sequence

import gpxpy
import gpxpy.gpx
import numpy as np

from kalmanq.data.files import whole
from kalmanq.data.layouts import Source, TableError
from kalmanq.data.readers import Recorded, number

HEADER = ["time", "lat", "lon", "ele", "speed", "course", "hdop", "vdop", "pdop", "sat"]


def opened(source: Source) -> Recorded:
    with open(source.path, encoding="utf-8-sig") as text:
        given = gpxpy.parse(text)
    points = [point for track in given.tracks for segment in track.segments for point in segment.points] or \
        [point for route in given.routes for point in route.points] or given.waypoints
    if not points:
        raise TableError(source, "has no points")
    return Recorded(source, HEADER, lambda _: map(_cells, points))


def _cells(point: Any) -> list[str]:
    time = "" if point.time is None else point.time.isoformat()
    return [time, *(number(getattr(point, name, None)) for name in ("latitude", "longitude", "elevation", "speed", "course", "horizontal_dilution",
                                                                    "vertical_dilution", "position_dilution", "satellites"))]


@contextmanager
def writing(path: Path, inputs: Sequence[Any]) -> Iterator[Callable[[np.ndarray, Optional[np.ndarray]], None]]:
    """`write` takes rows of latitude, longitude and height, NaN where it is not known; and dates of UTC, or None"""
    made = gpxpy.gpx.GPX()
    made.creator = "kalmanq"
    segment = gpxpy.gpx.GPXTrackSegment()
    made.tracks.append(gpxpy.gpx.GPXTrack(name="smoothed"))
    made.tracks[0].segments.append(segment)

    def write(places: np.ndarray, dates: Optional[np.ndarray]) -> None:
        at = [None] * len(places) if dates is None else [one.replace(tzinfo=timezone.utc) for one in dates.astype("datetime64[us]").tolist()]
        for place, time in zip(places.tolist(), at):
            if not any(map(isnan, place[:2])):  # where it is not known yet is no point
                segment.points.append(gpxpy.gpx.GPXTrackPoint(*(one for one in place if not isnan(one)), time=time))

    yield write
    with whole(path, inputs) as temporary:
        temporary.write_text(made.to_xml(), encoding="utf-8")
