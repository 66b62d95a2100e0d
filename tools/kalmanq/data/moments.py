"""Dates and clocks as loggers write them, in one column or in several, as those of ISO 8601."""

from __future__ import annotations

import re
from datetime import date, datetime, timedelta
from typing import Mapping, Optional, Sequence

from kalmanq.data.layouts import Source, TableError, without_unit
from kalmanq.data.times import CLOCK

LOCAL = re.compile(r"(\d{1,2})[./](\d{1,2})[./]\d{4}\b")
YEAR_FIRST = re.compile(r"(\d{4})([/.])(\d{1,2})\2(\d{1,2})(?=$|[ T])")
BASIC = re.compile(r"(\d{4})(\d\d)(\d\d)[T ](\d\d)(\d\d)(?:(\d\d)([.,]\d+)?)?(?=$|[Zz+-])")
DIGITS = re.compile(r"((?:19|20)\d\d)(\d\d)(\d\d)(\d\d)(\d\d)(\d\d)")  # in milliseconds since 1970 it would be after 2570
_IS_DAY = re.compile(r"(19|20)\d\d(0[1-9]|1[0-2])(0[1-9]|[12]\d|3[01])")
DAYS = ("date", "datum", "yyyymmdd")  # names of columns in which 20240131 is a day
DATE = re.compile(r"\d{4}-\d\d-\d\d.*")
DAY = re.compile(r"\d{4}-\d\d-\d\d")
ISO = "such as 2026-05-31 08:00:10"
ROLES = {"date": ("date", "datum"), "year": ("year", "yyyy", "jahr"), "month": ("month", "monat"),
         "day": ("day", "doy", "yday", "jday", "day_of_year", "tag"), "clock": ("time", "zeit", "uhrzeit", "clock"), "hhmm": ("hhmm", "hh:mm", "time_hhmm"),
         "hour": ("hour", "hh", "stunde"), "minute": ("minute", "minutes"), "second": ("second", "seconds")}
TOGETHER = (*((day, clock) for day in ("date", "day") for clock in ("clock", "hhmm", "hour")), ("year", "month"), ("year", "day"))


def places_said(source: Source, header: Sequence[str]) -> list[int]:
    """Of --time COLUMN,COLUMN"""
    said, names = source.layout.time or "", [without_unit(cell) for cell in header]
    return [names.index(one) for one in said.split(",")] if "," in said and said not in header and set(said.split(",")) <= set(names) else []


def roles_of(header: Sequence[str], taken: Sequence[int]) -> dict[str, int]:
    """Columns that are one time together, by their names: the place of each; none: there are not enough of them"""
    names = {without_unit(cell).lower(): place for place, cell in reversed(list(enumerate(header))) if place not in taken}
    found = {role: names[name] for role, of in ROLES.items() for name in reversed(of) if name in names}
    found = {role: place for role, place in found.items() if not (role == "day" and "month" not in found and "date" in found)}
    return found if any(set(some) <= set(found) for some in TOGETHER) else {}


def moment(cells: Mapping[str, str]) -> str:
    """Of the cells of such columns, by their role, in ISO 8601.  Empty: one is missing; ValueError: they are no time"""
    if not all(cells.values()):
        return ""
    day, clock = _day(cells), _clock(cells)
    if not DAY.fullmatch(day):
        raise ValueError
    return f"{day} {clock}" if clock else day


def _day(cells: Mapping[str, str]) -> str:
    if "date" in cells:
        return _of_digits(cells["date"]) if cells["date"].isdigit() else iso_of(cells["date"])
    year = _whole(cells.get("year", "1970"))  # of a day number alone
    if "month" in cells:
        return date(year, _whole(cells["month"]), _whole(cells.get("day", "1"))).isoformat()
    return (date(year, 1, 1) + timedelta(_whole(cells["day"]) - 1)).isoformat()


def _of_digits(cell: str) -> str:
    return datetime.strptime(cell, "%Y%m%d").date().isoformat()


def _whole(cell: str) -> int:
    if float(cell) != int(float(cell)):
        raise ValueError
    return int(float(cell))


def _clock(cells: Mapping[str, str]) -> str:
    if "clock" in cells:
        if not CLOCK.fullmatch(cells["clock"]):
            raise ValueError
        return f"{'0' * (cells['clock'][1] == ':')}{cells['clock']}"
    if "hhmm" in cells:  # without the zeros before it, too
        hours, minutes = divmod(_whole(cells["hhmm"].replace(":", "")), 100)
        return f"{hours:02}:{minutes:02}"
    if "hour" not in cells:
        return ""
    return f"{_whole(cells['hour']):02}:{_whole(cells.get('minute', '0')):02}:{float(cells.get('second', '0')):09.6f}"


def iso_of(cell: str) -> str:
    """A date whose order is certain, in ISO 8601; others stay as they are"""
    if found := YEAR_FIRST.match(cell):
        return f"{found[1]}-{found[3]:0>2}-{found[4]:0>2}{cell[found.end():]}"
    if found := BASIC.match(cell):
        return f"{found[1]}-{found[2]}-{found[3]}T{found[4]}:{found[5]}:{found[6] or '00'}{found[7] or ''}{cell[found.end():]}"
    if found := DIGITS.fullmatch(cell):
        return f"{found[1]}-{found[2]}-{found[3]}T{found[4]}:{found[5]}:{found[6]}"
    return cell


class Together:
    """Columns that are one time.  Of a header and the first row; places: of each by its role, none: one column has all, or none has"""

    def __init__(self, source: Source, header: Sequence[str], first: Sequence[str], place: Optional[int], taken: Sequence[int]):
        said, own = source.layout.time or "", places_said(source, header)
        self._is_formatted = bool(source.layout.time_format)
        self.places = {} if said and not own else roles_of(header, [k for k in range(len(header)) if k not in own] if own else taken)
        if own and self._is_formatted:
            self.places = dict(zip(map(str, own), own))
        elif own and not self.places:
            raise TableError(source, f"--time {said}: these columns are no time together by their names: --time-format says how they are written")
        elif place is not None and place not in self.places.values() or not self._fits(first):
            self.places = {}

    def _fits(self, first: Sequence[str]) -> bool:
        try:
            return bool(self.places) and (not first or moment(self._parts(first)) is not None)
        except ValueError:
            return False

    def _parts(self, row: Sequence[str]) -> dict[str, str]:
        return {role: row[place].strip() for role, place in self.places.items()}

    def cell(self, row: Sequence[str]) -> str:
        parts = self._parts(row)
        try:
            return moment(parts) if not self._is_formatted else " ".join(parts.values()) * all(parts.values())
        except ValueError:
            return " ".join(parts.values())


class Dates:
    """Of one column: what its first rows tell of the order of day and month holds for those that follow."""

    def __init__(self, source: Source, name: str):
        self.source, self.name = source, name
        self._is_day_first: Optional[bool] = None

    def in_iso(self, cells: Sequence[str], lines: Sequence[int]) -> list[str]:
        """lines: of these rows.  Cells that are no dates stay."""
        if self.source.layout.time_format:
            return [self._by_format(cell, line) for cell, line in zip(cells, lines)]
        found = [LOCAL.match(cell) for cell in cells]
        if not found or not found[0]:
            if cells and without_unit(self.name).lower() in DAYS and _IS_DAY.fullmatch(cells[0]):
                return [_of_digits(cell) if _IS_DAY.fullmatch(cell) else cell for cell in cells]
            return list(map(iso_of, cells)) if cells and iso_of(cells[0]) != cells[0] else list(cells)
        pandas = self._pandas(cells[0], lines[0])
        if self._is_day_first is None:
            self._is_day_first = self._order([one for one in found if one], lines[0])
        try:
            made = pandas.to_datetime(list(cells), dayfirst=self._is_day_first, format="mixed")
        except ValueError:
            wrong = next((k for k, one in enumerate(found) if not one), 0)
            raise TableError(self.source, f"{cells[wrong][:40]!r} is no such date as the others: write ISO 8601, {ISO}",
                             lines[wrong], self.name) from None
        return [one.isoformat(" ") for one in made]

    def _by_format(self, cell: str, line: int) -> str:
        try:
            return datetime.strptime(cell, self.source.layout.time_format or "").isoformat(" ", "microseconds")
        except (ValueError, re.error):
            raise TableError(self.source, f"{cell[:40]!r} is not written as --time-format {self.source.layout.time_format} says", line, self.name) from None

    def _order(self, found: Sequence[re.Match], line: int) -> bool:
        """Does the day come first?"""
        day, month = (max(int(one.group(k)) for one in found) for k in (1, 2))
        if (day > 12) == (month > 12):
            raise TableError(self.source, f"{found[0].string[:40]!r} is a date whose day and month are not certain: --time-format '%d.%m.%Y' says "
                             f"it, or write ISO 8601, {ISO}", line, self.name)
        return day > 12

    def _pandas(self, cell: str, line: int):  # type: ignore[no-untyped-def]
        try:
            import pandas  # an extra, which nothing else needs
        except ImportError:
            raise TableError(self.source, f"{cell[:40]!r} is no date of ISO 8601, {ISO}; pandas reads it, which is not installed: "
                             "pip install './tools[pandas]'", line, self.name) from None
        return pandas
