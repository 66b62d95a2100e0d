"""Reads a CSV of measurements, or says in one line why it cannot be used.

Rows are counted as an editor counts lines, from 1.  Lines that begin with `#` are comments.  The
first row may be a header: a row without any number in it.  An empty field or `nan` is a
measurement that is missing.  Fields are separated by commas, or by semicolons or tabs where the
first row has one of these and no comma; numbers have a decimal point.
"""

from __future__ import annotations

import csv
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Iterator, TextIO

import numpy as np

from shared.errors import FileError, one_line

MAX_ROWS = 100_000
LARGEST = 1e15  # beyond it, squares leave the range of a float
TIME_NAMES = ("t", "time", "year", "seconds")
SPACING_TOLERANCE = 1e-3  # of a time step: times are often written with few digits


@dataclass(frozen=True)
class Layout:
    """Which columns a model takes."""

    description: str
    fewest: int  # measured columns
    most: int
    names: tuple[str, ...]  # of the measured columns where there is no header
    first_of_two_is_time: bool = False  # else only a header's name makes a column the time


LOCAL_LEVEL = Layout("1 value, after an optional column of times", 1, 1, ("level",), True)
POSITIONS = Layout("1 to 3 positions, after an optional column named time", 1, 3, ("x", "y", "z"))


@dataclass(frozen=True)
class Measurements:
    """What the file holds: T rows of m numbers, NaN where one is missing."""

    names: tuple[str, ...]
    values: np.ndarray  # T x m
    time: np.ndarray | None  # T, evenly spaced
    last_row: int  # of the file, for messages


@dataclass(frozen=True)
class Row:
    number: int
    fields: list[str]


def read(path: Path, layout: Layout) -> Measurements:
    """The measurements in a file, or an FileError."""
    header, rows = split_header(path, list(rows_of(path)))
    width = len(rows[0].fields) if header is None else len(header.fields)
    check_widths(path, rows, width)
    timed = has_time(header, width, layout)
    check_columns(path, header or rows[0], width - timed, layout)
    numbers = np.array([[number(path, row, c) for c in range(width)] for row in rows])
    time = even_times(path, rows, numbers[:, 0]) if timed else None
    values = numbers[:, int(timed) :]
    check_present(path, rows[-1].number, values, timed)
    return Measurements(names_of(header, width - timed, layout), values, time, rows[-1].number)


def rows_of(path: Path) -> Iterator[Row]:
    """The rows that hold data, or a header; blank lines are allowed at the end only."""
    blank: int | None = None
    for row in raw_rows(path):
        if not any(field.strip() for field in row.fields) and len(row.fields) < 2:
            blank = blank or row.number
        elif blank is not None:
            raise FileError(path, "blank line (write nan for a missing measurement)", blank)
        else:
            yield row


def raw_rows(path: Path) -> Iterator[Row]:
    """Every row but the comments."""
    number = 0
    try:
        with open(path, newline="", encoding="utf-8-sig") as file:
            reader = csv.reader(file, delimiter=separator_of(file))
            for fields in reader:
                number = reader.line_num
                if not (fields and fields[0].lstrip().startswith("#")):
                    yield Row(number, fields)
                if number > MAX_ROWS:
                    raise FileError(path, f"more than {MAX_ROWS} rows", number)
    except FileNotFoundError as problem:
        raise FileError(path, "no such file") from problem
    except OSError as problem:
        raise FileError(path, problem.strerror or "cannot be read") from problem
    except UnicodeDecodeError as problem:
        raise FileError(path, "not text in UTF-8", number + 1) from problem
    except csv.Error as problem:
        raise FileError(path, f"not a CSV: {one_line(str(problem))}", number + 1) from problem


def separator_of(file: TextIO) -> str:
    """What the first row that is no comment has between its fields; then back to the begin."""
    first = next((line for line in file if line.strip() and not line.lstrip().startswith("#")), "")
    file.seek(0)
    others = [mark for mark in ";\t" if mark in first]
    return others[0] if others and "," not in first else ","


def split_header(path: Path, rows: list[Row]) -> tuple[Row | None, list[Row]]:
    if not rows:
        raise FileError(path, "the file is empty", 1)
    header = rows[0] if is_header(rows[0]) else None
    rest = rows if header is None else rows[1:]
    if not rest:
        raise FileError(path, "nothing but a header, no data", rows[0].number)
    return header, rest


def is_header(row: Row) -> bool:
    """No number in it, but something."""
    values = [value_of(field) for field in row.fields]
    return None in values and all(
        value is None or not field.strip() for field, value in zip(row.fields, values)
    )


def value_of(field: str) -> float | None:
    """The number in a field, NaN if it is empty, None if it is something else."""
    try:
        return None if "_" in field else float(field.strip() or "nan")
    except ValueError:
        return None


def check_widths(path: Path, rows: list[Row], width: int) -> None:
    for row in rows:
        if len(row.fields) != width:
            count = len(row.fields)
            raise FileError(path, f"{count} field{'s' * (count != 1)}, not {width}", row.number)


def has_time(header: Row | None, width: int, layout: Layout) -> bool:
    if layout.first_of_two_is_time:
        return width == 2
    if header is None or width < 2:
        return False
    return plain_name(header.fields[0]).lower() in TIME_NAMES


def plain_name(field: str) -> str:
    """A header's name without its unit: `time [s]` is `time`."""
    return field.split("[")[0].split("(")[0].strip()


def check_columns(path: Path, row: Row, measured: int, layout: Layout) -> None:
    if not layout.fewest <= measured <= layout.most:
        total = len(row.fields)
        reason = f"{total} column{'s' * (total != 1)}; the model takes {layout.description}"
        raise FileError(path, reason, row.number)


def number(path: Path, row: Row, column: int) -> float:
    field = row.fields[column].strip()
    value = value_of(field)
    if value is None:
        reason = f"'{one_line(field, 40)}' is not a number{hint(field)}"
        raise FileError(path, reason, row.number, column + 1)
    if abs(value) > LARGEST:
        reason = f"'{one_line(field, 40)}' is beyond {LARGEST:g} (scale the data)"
        raise FileError(path, reason, row.number, column + 1)
    return value


def hint(field: str) -> str:
    if ";" in field or "\t" in field:
        return " (one separator everywhere: commas, or semicolons or tabs)"
    return " (decimal points, no commas)" if value_of(field.replace(",", ".")) is not None else ""


def even_times(path: Path, rows: list[Row], time: np.ndarray) -> np.ndarray:
    """The times, if every step is as long as the first."""
    for row, value in zip(rows, time):
        if math.isnan(value):
            raise FileError(path, "the time is missing", row.number, 1)
    if len(time) < 2:
        return time
    first = time[1] - time[0]
    if first <= 0:
        raise FileError(path, "the time does not increase", rows[1].number, 1)
    for row, step in zip(rows[1:], np.diff(time)):
        if abs(step - first) > SPACING_TOLERANCE * first:
            reason = f"time step {step:.6g}, not {first:.6g} as before (give every row)"
            raise FileError(path, reason, row.number, 1)
    return time


def check_present(path: Path, last_row: int, values: np.ndarray, timed: bool) -> None:
    for c in range(values.shape[1]):
        if np.isnan(values[:, c]).all():
            raise FileError(path, "no measurement in any row", last_row, c + 1 + timed)


def times(data: Measurements, step: float) -> np.ndarray:
    """The file's, or steps from 0 on."""
    return step * np.arange(len(data.values)) if data.time is None else data.time


def names_of(header: Row | None, measured: int, layout: Layout) -> tuple[str, ...]:
    if header is None:
        return layout.names[:measured]
    names = [one_line(plain_name(field), 24) for field in header.fields[-measured:]]
    if len(set(names)) < measured or not all(names):
        return layout.names[:measured]
    return tuple(names)
