"""Times that are read: numbers, dates of ISO 8601 or clocks, in seconds, each after the one before."""

from __future__ import annotations

import re
import warnings
from dataclasses import dataclass
from typing import Optional, Sequence

import numpy as np

from kalmanq.data.layouts import MISSING, Source, TableError, unit_of, without_unit
from kalmanq.data.moments import DATE, Dates
from kalmanq.data.times import CLOCK, NONE, clocks, plain
from kalmanq.errors import KalmanqWarning
from kalmanq.model.continuous import UNITS

ZONE = re.compile(r"(?<=[\d ])\s*(?:[Zz]|UTC|[+-]\d\d:?\d\d)$")
LOCAL_DATE = re.compile(r"\d{1,4}[./]\d{1,2}[./]\d{1,4}\b")
DECIMAL = re.compile(r"\d+(\.\d*)?")
PER_SECOND = {"s": 1.0, "sec": 1.0, "second": 1.0, "seconds": 1.0, "ms": 1e3, "us": 1e6, "\u00b5s": 1e6, "\u03bcs": 1e6, "ns": 1e9,
              "min": 1 / 60, "h": 1 / 3600, **{name: 1 / UNITS[name] for name in ("day", "week", "year")}}
SPELT = {"millis": "ms", "micros": "us"}
UNITS_ALONE = ("ms", "seconds")  # a whole name that is a unit; "h" or "year" may be something else
EPOCH = ((1e17, 1e9), (1e14, 1e6), (1e11, 1e3))  # such a number is of nanoseconds, ... since 1970
SINCE_1970 = 1e9, 4e9  # seconds that are a date: from 2001 on
UNIT_KNOWN = 30.0  # a median step within this of dt, either way, is in the unit that was taken
FAR = 300.0  # of dt, either way: one of them may be in another unit


@dataclass(frozen=True)
class Origin:
    """What seconds are counted from: a whole number of `per_second`, and a part, of numbers, dates or clocks"""

    kind: str
    count: int
    part: float
    per_second: float
    zone: str = ""


def unit_in(name: str, said: str = "") -> str:
    """Of times whose column has that name; said: what is known of it otherwise"""
    said = said or unit_of(name) or re.split("[ _]", without_unit(name))[-1]
    said = SPELT.get(said.lower(), said)
    return said if said in PER_SECOND and (said != name or name in UNITS_ALONE) else ""


class TimeColumn:
    """A column that is read in seconds since its first row, or since another's.  Each row has a time, after the one before.

    step     the median of the first block's, in seconds
    repeats  rows may be of one time
    """

    def __init__(self, source: Source, name: str, place: int, dt: float, repeats: bool = False):
        self.source, self.name, self.place, self.dt, self.repeats = source, name, place, dt, repeats
        self.origin: Optional[Origin] = None
        self.step = np.nan
        self.unit = unit_in(name, unit_of(source.layout.time or ""))
        self.kind, self._zone = "", ""
        self._dates = Dates(source, name)
        self._per_second, self._base = 1.0, 0
        self._last: Optional[tuple[float, str]] = None

    @property
    def is_guess(self) -> bool:
        """Is the unit what such numbers mostly have?"""
        return self.kind == "numbers" and not self.unit

    @property
    def date(self) -> Optional[np.datetime64]:
        """Of the origin, in UTC"""
        of = self.origin
        if of is None or of.kind == "clocks" or of.kind == "numbers" and not SINCE_1970[0] < of.count / of.per_second < SINCE_1970[1]:
            return None
        return np.datetime64(round(of.count * int(1e9 / of.per_second) + of.part * (1e9 / of.per_second)), "ns")

    def read(self, cells: Sequence[str], lines: Sequence[int]) -> np.ndarray:
        """lines: of these rows"""
        cells = [cell.replace(",", ".", 1) for cell in cells]
        for k, cell in enumerate(cells):
            if cell.lower() in MISSING:
                raise TableError(self.source, "the time is missing: --skip-untimed leaves such rows out, or fill it in", lines[k], self.name)
        cells, is_first = self._dates.in_iso(cells, lines), not self.kind
        if is_first:
            self._begin(cells[0], lines[0])
        made = self._seconds(cells, lines)
        if is_first:
            self._look_at_steps(made)
        if not self.source.layout.sort:
            self._refuse_steps(made, cells, lines)
        self._last = float(made[-1]), cells[-1]
        return made

    def stamps(self, cells: Sequence[str], lines: Sequence[int], rows: TimeColumn) -> np.ndarray:
        """Times beside those of the rows, in any order; NaN: none"""
        made = np.full(len(cells), np.nan)
        there = [k for k, cell in enumerate(cells) if cell.lower() not in MISSING]
        for k, cell in zip(there, self._dates.in_iso([cells[k].replace(",", ".", 1) for k in there], [lines[k] for k in there])):
            if not self.kind:
                self.origin, self.unit = rows.origin, self.unit or rows.unit
                self._begin(cell, lines[k])
            made[k] = self._seconds([cell], [lines[k]])[0]
        return made

    def _begin(self, cell: str, line: int) -> None:
        self.kind = "dates" if DATE.match(cell) else "clocks" if CLOCK.fullmatch(cell) else "numbers"
        if self.kind == "dates":
            self._zone, self._per_second = _zone_of(cell), 1e9
        elif self.kind == "numbers":
            self._refuse_other_unit(line)
            value = self._parsed([cell], [line])[0]
            guessed = next((per for least, per in EPOCH if abs(value) >= least), 1.0)
            self._per_second = PER_SECOND[self.unit] if self.unit else guessed
        self._base = 0
        self._base = int(self._parsed([cell], [line])[0])
        self.origin = self.origin or Origin(self.kind, self._base, float(self._parsed([cell], [line])[0]), self._per_second,
                                            self._zone)
        if self.origin.kind != self.kind:
            raise TableError(self.source, f"the times are {self.kind}, the other file's are {self.origin.kind}: write both "
                             "alike", line, self.name)
        if bool(self.origin.zone) != bool(self._zone):
            said = [one or "no time zone" for one in (self._zone, self.origin.zone)]
            raise TableError(self.source, f"{cell}: {said[0]}, the other file's have {said[1]}: write both alike", line, self.name)

    def _refuse_other_unit(self, line: int) -> None:
        unit = unit_of(self.source.layout.time or "") or unit_of(self.name)
        if unit and not self.unit:
            raise TableError(self.source, f"{unit} is not one of the units {', '.join(PER_SECOND)}: --time "
                             f"'{without_unit(self.name)} [s]' says which it is", line, self.name)

    def _seconds(self, cells: Sequence[str], lines: Sequence[int]) -> np.ndarray:
        made, of = self._parsed(cells, lines), self.origin
        if of.per_second == self._per_second:
            return (made + (self._base - of.count) - of.part) / self._per_second
        return made / self._per_second + (self._base / self._per_second - of.count / of.per_second) - of.part / of.per_second

    def _parsed(self, cells: Sequence[str], lines: Sequence[int]) -> np.ndarray:
        """In the column's unit, less the base"""
        try:
            return self._parse(cells, lines)
        except (ValueError, OverflowError):
            wrong = next((k for k, cell in enumerate(cells) if not self._is_time(cell, lines[k])), 0)
            if LOCAL_DATE.match(cells[wrong]):
                raise TableError(self.source, f"{cells[wrong][:40]!r} is a date whose day and month are not certain: write ISO 8601, "
                                 "such as 2026-05-31 08:00:10", lines[wrong], self.name) from None
            raise TableError(self.source, f"{cells[wrong][:40]!r} is no time, as the others are {self.kind}: --time says which "
                             f"column has them, or {NONE}", lines[wrong], self.name) from None

    def _is_time(self, cell: str, line: int) -> bool:
        try:
            return len(self._parse([cell], [line])) == 1
        except (ValueError, OverflowError):
            return False

    def _parse(self, cells: Sequence[str], lines: Sequence[int]) -> np.ndarray:
        if self.kind == "dates":
            self._refuse_zones(cells, lines)
            bare = [ZONE.sub("", cell).strip() for cell in cells] if self._zone else list(cells)
            made = np.array(bare, "datetime64[ns]")
            if np.any(np.isnat(made)):
                raise ValueError
            return (made.astype(np.int64) - (self._base + _ahead_of_utc(self._zone))).astype(float)
        if self.kind == "clocks":
            return clocks(cells) - self._base
        if all(map(DECIMAL.fullmatch, cells)):  # without what a sum of seconds since 1970 and of their parts would lose
            parts = [cell.partition(".") for cell in cells]
            return np.array([int(whole) - self._base for whole, _, _ in parts], float) + \
                np.array([f"0.{part}" for _, _, part in parts], float)
        made = plain(cells) - self._base
        if not np.all(np.isfinite(made)) or any("_" in cell for cell in cells):
            raise ValueError
        return made

    def _refuse_zones(self, cells: Sequence[str], lines: Sequence[int]) -> None:
        for k, cell in enumerate(cells):
            zone = _zone_of(cell)
            if zone != self._zone:
                said = [one or "no time zone" for one in (zone, self._zone)]
                raise TableError(self.source, f"{cell}: {said[0]}, the rows before have {said[1]}: write all times in one zone",
                                 lines[k], self.name)

    def _look_at_steps(self, made: np.ndarray) -> None:
        steps = np.abs(np.diff(made))
        self.step = float(np.median(steps[steps > 0])) if np.any(steps > 0) else np.nan

    def _refuse_steps(self, made: np.ndarray, cells: Sequence[str], lines: Sequence[int]) -> None:
        last, said = self._last or (-np.inf, "")
        steps = np.diff(made, prepend=last)
        back = np.flatnonzero(steps < 0 if self.repeats else steps <= 0)
        if not len(back):
            return
        k = int(back[0])
        time, before = (made[k - 1], cells[k - 1]) if k else (last, said)
        if made[k] == time:
            raise TableError(self.source, f"{cells[k]} is the time of the row before, too: join the two rows, or leave one out; or --time says which other column has the times",
                             lines[k], self.name)
        clock = ", but a clock that begins anew needs a date (--time DAY,CLOCK where two columns have them)" if self.kind == "clocks" else \
            "; or did the logger begin anew?  Then cut the file there and give both: each is a record" if 0 <= made[k] < time / 2 else ""
        raise TableError(self.source, f"the time goes back, from {before} to {cells[k]}: --sort sorts the rows{clock}",
                         lines[k], self.name)


def judge_units(columns: Sequence[TimeColumn]) -> None:
    """Of files that are read together: numbers without a unit are refused where their steps are far from dt, others are told"""
    least = min((one.step for one in columns if one.step > 0), default=np.nan)
    for one in columns:
        ratio, name = one.step / one.dt, without_unit(one.name)
        most = UNIT_KNOWN if one.step == least else UNIT_KNOWN**2  # beside another file with shorter steps
        if one.is_guess and not (1 / UNIT_KNOWN <= ratio <= most or np.isnan(ratio)):
            raise TableError(one.source, f"column {one.name}: the unit of the times is not certain: as seconds, the median step is "
                             f"{one.step:.6g}, dt is {one.dt:g}: --time '{name} [ms]' says it, or [s], or a header {name} [ms]")
        if ratio > FAR or ratio < 1 / FAR:
            cure = f"; or --time '{name} [ms]' says another unit of the column" if one.kind == "numbers" else ""
            warnings.warn(f"{one.source}: the median step of column {one.name} is {one.step:.6g} s, dt is {one.dt:g}: times are in "
                          f"seconds here, and dt, F and Qc have to be, too{cure}", KalmanqWarning, stacklevel=2)


def _ahead_of_utc(zone: str) -> int:
    """In nanoseconds; 0 where nothing is known"""
    if zone in ("", "UTC"):
        return 0
    return (-1 if zone[0] == "-" else 1) * 60 * 10**9 * (60 * int(zone[1:3]) + int(zone[3:5]))


def _zone_of(cell: str) -> str:
    found = ZONE.search(cell) if len(cell) > 10 else None
    zone = found.group().strip().upper().replace(":", "") if found else ""
    return "UTC" if zone in ("Z", "UTC", "+0000", "-0000") else zone
