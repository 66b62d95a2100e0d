"""UBX of u-blox: a row for each message with iTOW; columns MESSAGE.FIELD, lengths in m and speeds in m/s, in UTC where NAV-PVT says it."""

from __future__ import annotations

import warnings
from contextlib import suppress
from datetime import datetime, timezone
from typing import Any, Collection, Iterator, Optional

import pyubx2

from kalmanq.data.layouts import Source, TableError
from kalmanq.data.readers import Cells, Recorded, number
from kalmanq.errors import KalmanqWarning

FIRST = ("NAV-HPPOSLLH", "NAV-PVT", "NAV-POSLLH")  # whose position is taken where several have one
PER_METRE = {**dict.fromkeys(("height", "hMSL", "velN", "velE", "velD", "gSpeed", "sAcc", "relPosN", "relPosE", "relPosD"), 1000.0),
             "NAV-PVT.hAcc": 1000.0, "NAV-PVT.vAcc": 1000.0, "NAV-POSLLH.hAcc": 1000.0, "NAV-POSLLH.vAcc": 1000.0,
             **{f"NAV-VELNED.{field}": 100.0 for field in ("velN", "velE", "velD", "gSpeed", "speed", "sAcc")}}
WEEK = 604_800_000  # ms
SYNC = b"\xb5b"


def opened(source: Source) -> Recorded:
    given, wrong = [], 0
    for data in _messages(source.path.read_bytes()):
        wrong += data is None
        with suppress(pyubx2.UBXMessageError, pyubx2.UBXParseError, pyubx2.UBXTypeError):  # messages that the library does not know
            given += [one for one in [data and pyubx2.UBXReader.parse(data)] if hasattr(one, "iTOW")]
    if not given:
        raise TableError(source, "has no UBX message with a time (iTOW), such as NAV-PVT")
    if wrong:
        warnings.warn(f"{source}: {wrong} UBX messages are cut off, or their check sums are wrong: they are left out", KalmanqWarning, stacklevel=2)
    names = {f"{one.identity}.{field}" for one in given for field in vars(one) if _is_number(one, field)}
    columns = sorted(names, key=lambda name: (name.partition(".")[0] not in FIRST, *name.split(".")))
    ahead = next((_utc(one) - one.iTOW for one in given if one.identity == "NAV-PVT" and one.validDate and one.validTime), None)
    return Recorded(source, ["time [ms]" if ahead is None else "time", *columns], lambda places: _rows(given, columns, places, ahead))


def _messages(data: bytes) -> Iterator[Optional[bytes]]:
    """Each one, None where its length or check sum is wrong: the next one may begin within it"""
    at = data.find(SYNC)
    while at >= 0:
        end = at + 8 + int.from_bytes(data[at + 4:at + 6], "little")
        is_whole = end <= len(data) and pyubx2.calc_checksum(data[at + 2:end - 2]) == data[end - 2:end]
        yield data[at:end] if is_whole else None
        at = data.find(SYNC, end if is_whole else at + 2)


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
