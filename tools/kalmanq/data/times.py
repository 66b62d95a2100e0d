"""A column of times beside the data: which one it is; are the rows as far apart as a model takes them to be?"""

from __future__ import annotations

import re
import warnings
from typing import Optional, Sequence

import numpy as np

from kalmanq.data.layouts import MISSING, Source, TableError, without_unit
from kalmanq.errors import KalmanqWarning

NAMES = re.compile(r"(time|timestamp|datetime|date|datum|epoch|year|zeit|uhrzeit|utc|uptime|elapsed|itow|millis|micros|seconds|ms|ts|t)([ _].*)?"
                   "|.*[ _]time", re.I)
STEP = re.compile(r"(d|delta_?)t|step|.*interval.*", re.I)  # a model that has it as a control knows of the times
IRREGULAR = 0.2  # of the median step: months and rounded clocks are within
CLOCK = re.compile(r"\d{1,2}:\d\d(:\d\d(\.\d+)?)?")
LOOKED_AT = 1000  # rows that tell whether a column without such a name may be of times
NONE = "none"  # what --time says where there is no such column


def time_column(source: Source, cells: Sequence[str], wanted: Sequence[int], names: Sequence[str]) -> Optional[int]:
    """The place in a header of the column that was asked for, otherwise of the first one by its name that the model does not
    take"""
    asked = without_unit(source.layout.time) if source.layout.time else None
    if asked == NONE:
        return None
    if asked is not None:
        found = [place for place, cell in enumerate(cells) if asked in (cell, without_unit(cell)) or cell == source.layout.time]
        if len(found) != 1:
            raise TableError(source, f"--time: there is {'more than one' if found else 'no'} column {asked}; there are "
                             f"{', '.join(cells)}")
        return found[0]
    if any(map(STEP.fullmatch, names)):
        return None
    return next((place for place, cell in enumerate(cells) if place not in wanted and NAMES.fullmatch(without_unit(cell))), None)


def unnamed_times(header: Sequence[str], rows: Sequence[Sequence[str]], taken: Sequence[int]) -> Optional[str]:
    """The column that a model does not take and that rises like a clock: mostly by the same step, and not a count of rows"""
    for place, name in enumerate(header):
        if place in taken or name == "step" or name.endswith("_true"):
            continue
        values, _ = _numbers([row[place].strip() for row in rows[:LOOKED_AT]])
        if values is None or len(values) < 4:
            continue
        steps = np.diff(values)
        if np.all(steps > 0) and np.any(steps != 1) and np.mean(np.abs(steps / np.median(steps) - 1) < IRREGULAR) > 0.5:
            return name
    return None


class Times:
    """The steps of a column that goes on from row to row; one that does not is no time."""

    def __init__(self, name: str, place: int):
        self.name, self.place = name, place
        self._last: Optional[float] = None
        self._median: Optional[float] = None
        self._tolerance = 0.0
        self._is_time = True
        self._least, self._most, self._row = np.inf, -np.inf, 0

    def look(self, cells: Sequence[str], line: int) -> None:
        """line: of the first of these rows"""
        if not self._is_time:
            return
        times, unit = _numbers(cells)
        if times is None:
            self._is_time, self._last = self._median is not None, None
            return
        if self._last is not None:
            times, line = np.concatenate([[self._last], times]), line - 1
        there = np.flatnonzero(np.isfinite(times))
        if not len(there):
            return
        self._last = float(times[there[-1]])
        following = np.flatnonzero(np.diff(there) == 1)  # rows without a time between them say nothing
        steps = times[there[following + 1]] - times[there[following]]
        self.take(steps, line + there[following + 1], unit)

    def take(self, steps: np.ndarray, lines: np.ndarray, unit: float) -> None:
        """lines: of the row after each step; unit: of the last decimal"""
        if not len(steps):
            return
        if self._median is None:
            self._median = float(np.median(steps))
            self._is_time = self._median > 0 and np.mean(steps < 0) < 0.01
            # a rounded clock is off by its unit; where that is a step, it may be a row that is not there
            self._tolerance = max(IRREGULAR * self._median, 1.01 * unit if self._median > 1.9 * unit else 0)
        ahead = steps >= 0  # clocks begin anew
        if not self._is_time or not np.any(ahead):
            return
        far = np.abs(steps - self._median) > self._tolerance
        if np.any(far & ahead) and not self._row:
            self._row = int(lines[int(np.argmax(far & ahead))])
        self._least = min(self._least, float(steps[ahead].min()))
        self._most = max(self._most, float(steps[ahead].max()))

    def warn(self, source: str, cure: str, what: str = "", stacklevel: int = 2) -> None:
        """what: has these times, if no column"""
        if self._is_time and self._row:
            warnings.warn(f"{source}: row {self._row}: the times of {what or f'column {self.name}'} are irregular, steps are "
                          f"{self._least:.6g} to {self._most:.6g}, most {self._median:.6g}: each row is taken for one "
                          f"step of the model; {cure}", KalmanqWarning, stacklevel=stacklevel)


def _numbers(cells: Sequence[str]) -> tuple[Optional[np.ndarray], float]:
    """Numbers, dates in seconds, or clocks, and their last decimal's unit; None: none of these"""
    made = ["" if cell.lower() in MISSING else cell.replace(",", ".", 1) for cell in cells]
    for parse in (plain, _dates, clocks):
        try:
            return parse(made), 10.0 ** -max(len(cell.partition(".")[2].rstrip("Zz")) for cell in made)
        except (ValueError, OverflowError):
            continue
    return None, 0.0


def plain(cells: Sequence[str]) -> np.ndarray:
    return np.array([cell or "nan" for cell in cells], np.float64)


def _dates(cells: Sequence[str]) -> np.ndarray:
    """Years and months alone are numbered, so that a month is as long as another."""
    first = next((cell for cell in cells if cell), "")
    unit = "M" if re.fullmatch(r"\d{4}-\d\d", first) else "us"
    if not re.match(r"\d{4}-\d\d", first):
        raise ValueError
    made = np.array([re.sub(r"Z$|[+-]\d\d:?\d\d$", "", cell) if len(cell) > 10 else cell or "NaT" for cell in cells],
                    f"datetime64[{unit}]")
    values = made.astype(np.int64) * (1.0 if unit == "M" else 1e-6)
    return np.where(np.isnat(made), np.nan, values)


def clocks(cells: Sequence[str]) -> np.ndarray:
    if not all(CLOCK.fullmatch(cell) for cell in cells if cell):
        raise ValueError
    parts = [[float(part) for part in cell.split(":")] if cell else [0.0] for cell in cells]
    return np.array([3600 * one[0] + 60 * one[1] + (one[2] if len(one) > 2 else 0) if one[1:] else np.nan
                     for one in parts])
