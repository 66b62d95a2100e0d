"""CSV files: read in blocks, so that files of any length fit; written whole or not at all."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Iterator, Optional, Sequence, TextIO

import numpy as np

from kalmanq.errors import KalmanqError
from kalmanq.files import whole
from kalmanq.model import Model


@dataclass(frozen=True)
class Block:
    """Some rows of a file; first_row: the line in the file of the first of them."""

    first_row: int
    columns: dict[str, np.ndarray]


class TableError(KalmanqError):
    """PATH: row N, column NAME: why."""

    def __init__(self, path: Path, reason: str, line: Optional[int] = None, column: Optional[str] = None):
        place = [] if line is None else [f"row {line}" + ("" if column is None else f", column {column}")]
        super().__init__(": ".join([str(path), *place, reason]))


def read(path: Path, names: Sequence[str], rows: int = 65536) -> Iterator[Block]:
    """The columns `names`, in blocks of so many rows.  An empty cell is NaN; other columns are left out."""
    try:
        with open(path, newline="", encoding="utf-8-sig") as text:
            yield from _blocks(path, text, names, rows, _skip_comments(text))
    except FileNotFoundError:
        raise TableError(path, "no such file") from None
    except UnicodeDecodeError as problem:
        raise TableError(path, "is not UTF-8 text") from problem


def _skip_comments(text: TextIO) -> int:
    """Lines that begin with '#', above the header."""
    number, start = 0, text.tell()
    while text.readline().startswith("#"):
        number, start = number + 1, text.tell()
    text.seek(start)
    return number


def _blocks(path: Path, text: TextIO, names: Sequence[str], rows: int, comments: int) -> Iterator[Block]:
    reader = csv.reader(text)
    try:
        header = next(reader, None)
        width, places = _places(path, header, names, comments + 1)
        first, block = comments + 2, []
        blank = 0  # rows without a cell: of one column, a missing number; at the end, nothing
        for row in reader:
            if not row:
                blank += 1
                continue
            if blank and width > 1:
                raise TableError(path, "an empty row", first + len(block))
            block += [[""]] * blank
            blank = 0
            if len(row) != width:
                fields = "1 field" if len(row) == 1 else f"{len(row)} fields"
                raise TableError(path, f"{fields}, not {width}", first + len(block))
            block.append(row)
            if len(block) >= rows:
                yield _block(path, first, block, names, places)
                first, block = first + len(block), []
    except csv.Error as problem:
        raise TableError(path, str(problem), comments + reader.line_num) from problem
    if not block and first == comments + 2:
        raise TableError(path, "no data below the header")
    if block:
        yield _block(path, first, block, names, places)


def _places(path: Path, header: Optional[list[str]], names: Sequence[str],
            line: int) -> tuple[int, list[int]]:
    if not header or not any(cell.strip() for cell in header):
        raise TableError(path, "empty, or without a header of names", line)
    if len(header) == 1 and ";" in header[0]:
        raise TableError(path, "fields are separated by ';', not by ','", line)
    cells = [cell.strip() for cell in header]
    for name in names:
        if cells.count(name) > 1:
            raise TableError(path, f"the column {name} is there twice", line)
        if name not in cells:
            raise TableError(path, f"there is no column {name}; there are {', '.join(cells)}", line)
    return len(cells), [cells.index(name) for name in names]


def _block(path: Path, first: int, block: list[list[str]], names: Sequence[str], places: Sequence[int]) -> Block:
    columns = {}
    for name, place in zip(names, places):
        cells = [row[place].strip() for row in block]
        try:
            values = np.array([cell if cell else "nan" for cell in cells], dtype=np.float64)
        except ValueError:
            values = np.array([_number(path, first + k, name, cell) for k, cell in enumerate(cells)])
        wrong = np.isinf(values)
        if np.any(wrong):
            raise TableError(path, "is beyond the numbers", first + int(np.argmax(wrong)), name)
        columns[name] = values
    return Block(first, columns)


def _number(path: Path, line: int, name: str, cell: str) -> float:
    if not cell:
        return float("nan")
    try:
        if "_" in cell:
            raise ValueError
        return float(cell)
    except ValueError:
        hint = "; fields are separated by ','" if ";" in cell else \
            "; a decimal point, not a comma" if cell.replace(",", ".", 1).replace(".", "", 1).isdigit() else ""
        raise TableError(path, f"{cell[:40]!r} is not a number{hint}", line, name) from None


def joined(blocks: Sequence[Block]) -> Block:
    return Block(blocks[0].first_row, {name: np.concatenate([one.columns[name] for one in blocks])
                                       for name in blocks[0].columns})


def names_in(path: Path) -> list[str]:
    """The header's cells"""
    try:
        with open(path, newline="", encoding="utf-8-sig") as text:
            _skip_comments(text)
            return [cell.strip() for cell in next(csv.reader(text), [])]
    except FileNotFoundError:
        raise TableError(path, "no such file") from None
    except (UnicodeDecodeError, csv.Error) as problem:
        raise TableError(path, "is not UTF-8 text") from problem


def measurements_and_controls(path: Path, model: Model) -> tuple[np.ndarray, Optional[np.ndarray]]:
    """All rows of a model's columns: z (T x m) and u (T x l) or None."""
    measurements, controls = ([one.name for one in which] for which in (model.measurements, model.controls))
    block = joined(list(read(path, measurements + controls)))
    z = np.column_stack([block.columns[name] for name in measurements])
    u = np.column_stack([block.columns[name] for name in controls]) if controls else None
    if u is not None and np.any(np.isnan(u)):
        row, column = map(int, np.argwhere(np.isnan(u))[0])
        raise TableError(path, "a control is missing", block.first_row + row, controls[column])
    return z, u


def write_text(text: TextIO, names: Sequence[str], columns: Sequence[np.ndarray]) -> None:
    """Integers as they are, other numbers with as many digits as bring back the same bits."""
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(names)
    _write_rows(writer, columns)


def _write_rows(writer: "csv._writer", columns: Sequence[np.ndarray]) -> None:
    writer.writerows(zip(*([_cell(value) for value in column.tolist()] for column in columns)))


def _cell(value: object) -> str:
    if isinstance(value, float):
        return "" if value != value else format(value, ".17g")
    return str(value)


class Writer:
    """`with Writer(path, names, inputs) as writer:` writes rows of columns; the file appears at the end."""

    def __init__(self, path: Path, names: Sequence[str], inputs: Sequence[Path] = ()):
        self._whole = whole(path, inputs)
        self._names = names

    def __enter__(self) -> Writer:
        temporary = self._whole.__enter__()
        try:
            self._text = open(temporary, "w", newline="", encoding="utf-8")
        except OSError as problem:
            if not self._whole.__exit__(type(problem), problem, problem.__traceback__):
                raise
        self._writer = csv.writer(self._text, lineterminator="\n")
        self._writer.writerow(self._names)
        return self

    def write(self, columns: Sequence[np.ndarray]) -> None:
        _write_rows(self._writer, columns)

    def __exit__(self, kind: Optional[type[BaseException]], problem: Optional[BaseException],
                 trace: Optional[TracebackType]) -> None:
        try:
            self._text.close()
        except OSError as last:  # what was still to be written
            self._whole.__exit__(type(last), last, last.__traceback__)
            raise
        self._whole.__exit__(kind, problem, trace)
