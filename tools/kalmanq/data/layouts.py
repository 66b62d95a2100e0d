"""How a table is written: what is between its fields, its decimals, its letters, what is missing, and its names."""

from __future__ import annotations

import csv
import os
import re
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Collection, Mapping, Optional, Sequence, Union

from kalmanq.errors import KalmanqError
from kalmanq.model import Quantity

SEPARATORS = {",": "','", ";": "';'", "\t": "a tab"}
MISSING = ("", "na", "n/a", "#n/a", "<na>", "nan", "null", "none")  # in any letters
SHOWN, LISTED = 60, 12  # letters of a row; names in a line


@dataclass(frozen=True)
class Layout:
    """What a user says of a table; what is not said is told by the table itself, where that is certain."""

    separator: Optional[str] = None
    decimal: Optional[str] = None
    missing: tuple[str, ...] = ()
    rename: Mapping[str, str] = field(default_factory=dict)  # what is called NAME here is COLUMN there
    time: Optional[str] = None  # the column of times, perhaps with its unit; "none": there is none
    time_format: Optional[str] = None  # of strptime
    sort: bool = False  # rows by their times
    skip_untimed: bool = False  # rows without a time are left out
    pause: Optional[float] = None  # seconds without a row that begin a new record
    jitter: Optional[float] = None  # in the place of the model's
    database: Optional[str] = None  # of the signals of a CAN log
    origin: Optional[Sequence[float]] = None  # latitude, longitude and perhaps height


@dataclass(frozen=True)
class Source:
    """A file of data and its layout; "-" is the standard input."""

    path: Path
    layout: Layout = Layout()

    def said(self, by_model: Mapping[str, Any]) -> Source:
        """With what a model file says, where the options say nothing"""
        of = {"separator": {"tab": "\t"}.get(by_model["separator"], by_model["separator"])} if "separator" in by_model else {}
        by_model = {key: value for key, value in by_model.items() if key != "time_format" or not self.layout.time}  # of the model's column
        new = {key: value for key, value in {**by_model, **of}.items() if getattr(self.layout, key) is None or getattr(self.layout, key) is False}
        return replace(self, layout=replace(self.layout, **new)) if new else self

    @property
    def is_standard_input(self) -> bool:
        return str(self.path) == "-"

    @property
    def name(self) -> str:
        return str(self) if self.is_standard_input else self.path.name

    def exists(self) -> bool:
        return not self.is_standard_input and self.path.exists()

    def stat(self) -> os.stat_result:
        return self.path.stat()

    def __fspath__(self) -> str:
        return str(self.path)

    def __str__(self) -> str:
        return "standard input" if self.is_standard_input else str(self.path)


AnySource = Union[Path, Source]


class TableError(KalmanqError):
    """PATH: row N, column NAME: why."""

    def __init__(self, path: AnySource, reason: str, line: Optional[int] = None, column: Optional[str] = None):
        place = [] if line is None else [f"row {line}" + ("" if column is None else f", column {column}")]
        super().__init__(" ".join(": ".join([str(path), *place, reason]).splitlines()))  # a name in quotes may have several


def source_of(given: AnySource) -> Source:
    return given if isinstance(given, Source) else Source(given)


def first_of(data: Any) -> Source:
    """Of a file, or of several"""
    return source_of(data[0] if isinstance(data, (list, tuple)) else data)


def layout_of(said: Mapping[str, Any]) -> Layout:
    """Of options, by their names"""
    separator, decimal, rename = said["separator"], said["decimal"], said["rename"]
    separator = {"tab": "\t", "\\t": "\t"}.get(separator or "", separator)
    if separator is not None and (len(separator) != 1 or separator in '"\r\n'):
        raise KalmanqError(f"--separator: {separator!r} is not one letter, nor tab")
    if decimal not in (None, ".", ","):
        raise KalmanqError(f"--decimal: {decimal!r} is neither . nor ,")
    if decimal is not None and decimal == separator:
        raise KalmanqError(f"--decimal: {decimal!r} is --separator, too: give another one of the two")
    pairs = [pair.partition("=") for pair in rename]
    for name, _, column in pairs:
        if not name or not column:
            raise KalmanqError("--rename: is not NAME=COLUMN, the model's name and the file's")
    names = [name for name, _, _ in pairs]
    if len(set(names)) < len(names):
        raise KalmanqError(f"--rename: {max(names, key=names.count)} is there twice")
    return Layout(**{**said, "separator": separator, "missing": tuple(one.strip() for one in said["missing"]),
                     "rename": {name: column for name, _, column in pairs}})


def options_of(layout: Layout) -> list[str]:
    """As they are written on a command line"""
    made = [("separator", "tab" if layout.separator == "\t" else layout.separator), ("decimal", layout.decimal),
            *(("missing", one) for one in layout.missing), *(("rename", f"{name}={column}") for name, column in layout.rename.items()),
            *((name, getattr(layout, name)) for name in ("time", "time_format", "database")),
            *((name, None if value is None else f"{value:g}") for name, value in (("pause", layout.pause), ("jitter", layout.jitter)))]
    return [*(f"--{name.replace('_', '-')}={value}" for name, value in made if value is not None),
            *(f"--{name.replace('_', '-')}" for name in ("sort", "skip_untimed") if getattr(layout, name))]


# ------------------------------------------------------------------------------ fields and names


def cells_of(line: str, separator: str) -> list[str]:
    """A header's, by a separator that it may have"""
    return [cell.strip() for cell in next(csv.reader([line], delimiter=separator), [])]


def separator_of(source: Source, header: str, wanted: Sequence[str], line: int) -> str:
    """The one that is said; otherwise the one that the header has, or by which it has the wanted names."""
    if source.layout.separator:
        return source.layout.separator
    bare = re.sub(r'"[^"]*"', "", header)
    there = [one for one in SEPARATORS if one in bare]
    if len(there) > 1:
        fitting = [one for one in there if set(wanted) <= set(map(without_unit, cells_of(header, one)))]
        if len(fitting) != 1:
            raise TableError(source, f"{' or '.join(SEPARATORS[one] for one in there)} may be between fields: "
                             "--separator says which", line)
        there = fitting
    if there:
        return there[0]
    return ";" if source.layout.decimal == "," else ","


_UNIT = re.compile(r"(.*\S)\s*(?:\[([^\[\]]*)\]|\(([^()]*)\))")


def without_unit(cell: str) -> str:
    found = _UNIT.fullmatch(cell)
    return found.group(1) if found else cell


def unit_of(cell: str) -> str:
    found = _UNIT.fullmatch(cell)
    return (found.group(2) or found.group(3) or "").strip() if found else ""


def column_of(source: Source, one: Quantity) -> str:
    """What it is called in the file: by --rename, by the model file, or by its own name"""
    return source.layout.rename.get(one.name, one.reading.column or one.name)


def places_of(source: Source, cells: Sequence[str], one: Quantity) -> list[int]:
    """The columns of that name, or of that name with a unit behind it, or with what it belongs to and a point before it"""
    column = column_of(source, one)
    ways = (lambda cell: cell, without_unit, lambda cell: without_unit(cell).rpartition(".")[2])
    return next((found for way in ways if (found := [k for k, cell in enumerate(cells) if way(cell) == column])), [])


def place_of(source: Source, cells: Sequence[str], one: Quantity, line: int) -> int:
    """The one of them"""
    column, found = column_of(source, one), places_of(source, cells, one)
    if len(found) > 1:
        raise TableError(source, f"the column {column} is there twice, {listed([cells[k] for k in found])}: leave one out, or give another name", line)
    is_number = [_float(cell) is not None for cell in cells]
    if not found and any(is_number) and not any(cell[:1].isalpha() for cell, number in zip(cells, is_number) if not number):
        raise TableError(source, f"there is no header: {', '.join(cells)[:SHOWN]} are no names; the first row has the names of the columns, "
                         f"{column} among them", line)
    if not found:
        cure = "" if one.name in source.layout.rename else f" (columns in the model file, or --rename {one.name}=..., says which it is)"
        raise TableError(source, f"there is no column {column}; there are {listed(cells)}{cure}", line)
    _refuse_unit(source, cells[found[0]], one, line)
    return found[0]


def listed(names: Sequence[str]) -> str:
    """What a line has room for"""
    shown = [name[:SHOWN] for name in names[:LISTED]]
    return ", ".join(shown) + (f" and {len(names) - LISTED} more" if len(names) > LISTED else "")


def _refuse_unit(source: Source, cell: str, one: Quantity, line: int) -> None:
    """Where nothing says how to convert it"""
    own = unit_of(cell) if source.layout.rename.get(one.name) != cell else ""
    if own and one.unit and own != one.unit and not one.reading.converts:
        raise TableError(source, f"{cell} is in {own}, the model has {one.name} in {one.unit}: convert it, by factors and offsets of the model file, or "
                         f"--rename '{one.name}={cell}' if the heading alone is wrong", line)


# ------------------------------------------------------------------------------ numbers


def _float(text: str) -> Optional[float]:
    try:
        return None if "_" in text else float(text)
    except ValueError:
        return None


def numbers_in(cells: Sequence[Any]) -> list[float]:
    return [value for value in map(_float, map(str, cells)) if value is not None]


_DECIMAL_COMMA = re.compile(r"[+-]?\d*,\d*(?:[eE][+-]?\d+)?")
_THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2}(?:,\d{3})+")


def has_decimal_comma(cells: Sequence[str]) -> bool:
    """Is it certain that a comma in these cells is a decimal one?"""
    with_comma = [cell for cell in cells if "," in cell]
    return bool(with_comma) and all(map(_DECIMAL_COMMA.fullmatch, with_comma)) \
        and not all(map(_THOUSANDS.fullmatch, with_comma)) and not any("." in cell for cell in cells)


class Numbers:
    """Cells to numbers, in all blocks of a table alike"""

    def __init__(self, layout: Layout):
        self.decimal = layout.decimal
        self.missing = {*MISSING, *(one.lower() for one in layout.missing)}
        self.numbers_missing = numbers_in(layout.missing)

    def look(self, columns: Sequence[Sequence[str]]) -> None:
        """The first block tells whether there are decimal commas."""
        if self.decimal is None:
            self.decimal = "," if has_decimal_comma([cell for cells in columns for cell in cells]) else "."

    def plain(self, cells: Sequence[str]) -> Optional[list[str]]:
        """As Python has numbers, all at once; None: each has to be looked at"""
        joined = "".join(cells)
        if "_" in joined or (self.decimal == "," and "." in joined):
            return None
        if self.decimal == ",":
            cells = [cell.replace(",", ".") for cell in cells]
        return [cell if cell else "nan" for cell in cells]

    def number(self, cell: str, missing: Collection[str] = ()) -> float:
        """ValueError: it is none.  missing: cells of the column that mean nothing, too"""
        if cell.lower() in self.missing or cell.lower() in missing:
            return float("nan")
        if "_" in cell or (self.decimal == "," and "." in cell):
            raise ValueError
        return float(cell.replace(",", ".") if self.decimal == "," else cell)

    def hint(self, cell: str) -> str:
        if ";" in cell:
            return "; --separator says what is between fields"
        if "," in cell and ("." in cell or " " in cell):
            return "; digits are not grouped here: leave the marks of thousands out"
        if self.decimal == "," and "." in cell:
            return "; decimals have a comma here (--decimal)"
        if "," in cell:
            return "; a decimal point, not a comma; or --decimal ,"
        return "; if it is missing: --missing" if not any(c.isdigit() for c in cell) else ""
