"""UBX of u-blox: a row for each message with iTOW; columns MESSAGE.FIELD, lengths in m and speeds in m/s, in UTC where NAV-PVT says it."""

from __future__ import annotations

from datetime import datetime, timezone
from typing import Any, Collection, Iterator

import pyubx2

from kalmanq.data.layouts import Source, TableError
from kalmanq.data.readers import Cells, Recorded, number

FIRST = ("NAV-HPPOSLLH", "NAV-PVT", "NAV-POSLLH")  # whose position is taken where several have one
PER_METRE = {**dict.fromkeys(("height", "hMSL", "velN", "velE", "velD", "gSpeed", "sAcc", "relPosN", "relPosE", "relPosD"), 1000.0),
             "NAV-PVT.hAcc": 1000.0, "NAV-PVT.vAcc": 1000.0, "NAV-POSLLH.hAcc": 1000.0, "NAV-POSLLH.vAcc": 1000.0,
             **{f"NAV-VELNED.{field}": 100.0 for field in ("velN", "velE", "velD", "gSpeed", "speed", "sAcc")}}
WEEK = 604_800_000  # ms


def opened(source: Source) -> Recorded:
    with open(source.path, "rb") as stream:
        given = [one for _, one in pyubx2.UBXReader(stream, protfilter=pyubx2.UBX_PROTOCOL, quitonerror=pyubx2.ERR_IGNORE)
                 if hasattr(one, "iTOW")]
    if not given:
        raise TableError(source, "has no UBX message with a time (iTOW), such as NAV-PVT")
    names = {f"{one.identity}.{field}" for one in given for field in vars(one) if _is_number(one, field)}
    columns = sorted(names, key=lambda name: (name.partition(".")[0] not in FIRST, *name.split(".")))
    ahead = next((_utc(one) - one.iTOW for one in given if one.identity == "NAV-PVT" and one.validDate and one.validTime), None)
    return Recorded(source, ["time [ms]" if ahead is None else "time", *columns], lambda places: _rows(given, columns, places, ahead))


def _is_number(one: Any, field: str) -> bool:
    return field[0] != "_" and field != "iTOW" and isinstance(getattr(one, field), (int, float))


def _utc(one: Any) -> int:
    """In ms since 1970"""
    at = datetime(one.year, one.month, one.day, one.hour, one.min, min(one.second, 59), tzinfo=timezone.utc)
    return round(at.timestamp() * 1000 + one.nano * 1e-6)


def _rows(given: list[Any], columns: list[str], places: Collection[int], ahead: Any) -> Iterator[Cells]:
    wanted, weeks, last = {columns[place - 1]: place for place in places if place}, 0, given[0].iTOW
    for one in given:
        weeks, last = weeks + (last - one.iTOW > WEEK / 2), one.iTOW
        fields = {field: wanted[f"{one.identity}.{field}"] for field in vars(one) if f"{one.identity}.{field}" in wanted}
        if not fields:
            continue
        time = one.iTOW + WEEK * weeks
        row = Cells({0: str(time) if ahead is None else datetime.fromtimestamp((time + ahead) / 1000, timezone.utc).isoformat(timespec="milliseconds")})
        for field, place in fields.items():
            per = PER_METRE.get(f"{one.identity}.{field}", PER_METRE.get(field, 1.0))
            is_fix = field not in ("lat", "lon", "height", "hMSL") or getattr(one, "fixType", 3) >= 2
            row[place] = number(getattr(one, field) / per) if is_fix else ""
        yield row
