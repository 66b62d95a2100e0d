"""NMEA 0183: a row for each epoch of GGA, RMC, GLL, VTG and their like; a field that several sentences say is the first one's."""

from __future__ import annotations

import warnings
from datetime import date, datetime, time, timedelta
from typing import Any, Iterator, Optional

import pynmea2

from kalmanq.data.layouts import Source, TableError
from kalmanq.data.readers import Recorded, number
from kalmanq.errors import KalmanqWarning

FIELDS = {"lat": "latitude", "lon": "longitude", "alt": "altitude", "speed": "spd_over_grnd", "course": "true_course", "hdop": "horizontal_dil",
          "satellites": "num_sats"}


def opened(source: Source) -> Recorded:
    text = source.path.read_text(encoding="ascii", errors="replace").splitlines()
    sentences = [one for one in map(_sentence, text) if one is not None]
    timed = [one for one in sentences if _time_of(one)]
    if not timed:
        raise TableError(source, "has no NMEA sentence with a time, such as GGA or RMC")
    wrong = sum(bool(line.strip()) for line in text) - len(sentences)
    if wrong:
        warnings.warn(f"{source}: {wrong} lines are no NMEA sentences, or their check sums are wrong: they are left out", KalmanqWarning, stacklevel=2)
    begun = next((one.datestamp for one in timed if getattr(one, "datestamp", None)), date(1970, 1, 1))
    return Recorded(source, ["time", *FIELDS], lambda _: _epochs(sentences, begun))


def _sentence(line: str) -> Optional[Any]:
    try:
        return pynmea2.parse(line.strip(), check=True)
    except (pynmea2.ParseError, ValueError):
        return None


def _time_of(one: Any) -> Optional[time]:
    """Not of a leap second, 23:59:60: it is of the epoch before"""
    at = getattr(one, "timestamp", None)
    return at if isinstance(at, time) else None


def _epochs(sentences: list[Any], day: date) -> Iterator[list[str]]:
    """A sentence without a time is of the epoch before"""
    now, cells = None, {}
    for one in sentences:
        at = _time_of(one)
        if at and (now is None or at.replace(tzinfo=None) != now.time()):
            if now is not None:
                yield [now.isoformat() + "Z", *(cells.get(name, "") for name in FIELDS)]
                day += timedelta(days=int(now.time().hour - at.hour > 12))  # over midnight
            now, cells = datetime.combine(day, at.replace(tzinfo=None)), {}
        if getattr(one, "gps_qual", 1) and getattr(one, "status", "A") == "A":  # with a fix
            for name, field in FIELDS.items():
                cells.setdefault(name, _cell(one, field)) if _cell(one, field) else None
    if now is not None:
        yield [now.isoformat() + "Z", *(cells.get(name, "") for name in FIELDS)]


def _cell(one: Any, field: str) -> str:
    value = getattr(one, field, None)
    if value in (None, "") or field in ("latitude", "longitude") and not getattr(one, field[:3], ""):
        return ""
    return number(float(value) * (1852 / 3600 if field == "spd_over_grnd" else 1.0))
