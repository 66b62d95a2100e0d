"""How a table is written: what is between its fields, its decimals, its letters, what is missing, and its names."""

from __future__ import annotations

import codecs
import csv
import io
import os
import re
import sys
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Iterator, Mapping, Optional, Sequence, TextIO, Union

from kalmanq.errors import KalmanqError

SEPARATORS = {",": "','", ";": "';'", "\t": "a tab"}
MISSING = ("", "na", "n/a", "#n/a", "<na>", "nan", "null", "none")  # in any letters
SHOWN = 60  # letters of a row
HEAD = 4096  # bytes that tell how the text is written


@dataclass(frozen=True)
class Layout:
    """What a user says of a table; what is not said is told by the table itself, where that is certain."""

    separator: Optional[str] = None
    decimal: Optional[str] = None
    missing: tuple[str, ...] = ()
    rename: Mapping[str, str] = field(default_factory=dict)  # what is called NAME here is COLUMN there
    time: Optional[str] = None  # the column of times, perhaps with its unit; "none": there is none
    sort: bool = False  # rows by their times
    jitter: Optional[float] = None  # in the place of the model's

    @property
    def numbers_missing(self) -> list[float]:
        return [value for value in map(_float, self.missing) if value is not None]


@dataclass(frozen=True)
class Source:
    """A file of data and its layout; "-" is the standard input."""

    path: Path
    layout: Layout = Layout()

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
        super().__init__(": ".join([str(path), *place, reason]))


def source_of(given: AnySource) -> Source:
    return given if isinstance(given, Source) else Source(given)


def layout_of(separator: Optional[str], decimal: Optional[str], missing: Sequence[str], rename: Sequence[str],
              time: Optional[str] = None, sort: bool = False, jitter: Optional[float] = None) -> Layout:
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
    return Layout(separator, decimal, tuple(one.strip() for one in missing), {name: column for name, _, column in pairs},
                  time, sort, jitter)


def options_of(layout: Layout) -> list[str]:
    """As they are written on a command line"""
    made = [("--separator", "tab" if layout.separator == "\t" else layout.separator), ("--decimal", layout.decimal),
            *(("--missing", one) for one in layout.missing), *(("--rename", f"{name}={column}") for name, column in layout.rename.items()),
            ("--time", layout.time), ("--jitter", None if layout.jitter is None else f"{layout.jitter:g}")]
    return [*(f"{option}={value}" for option, value in made if value is not None), *(["--sort"] if layout.sort else [])]


# ------------------------------------------------------------------------------ letters


def _latin_1(problem: UnicodeError) -> tuple[str, int]:
    """What is no UTF-8 is Latin-1: numbers are the same in both."""
    assert isinstance(problem, UnicodeDecodeError)
    return problem.object[problem.start : problem.end].decode("latin-1"), problem.end


codecs.register_error("kalmanq_latin_1", _latin_1)


def _encoding(source: Source, head: bytes) -> tuple[str, str]:
    for mark, name in ((codecs.BOM_UTF32_LE, "utf-32"), (codecs.BOM_UTF32_BE, "utf-32"),
                       (codecs.BOM_UTF16_LE, "utf-16"), (codecs.BOM_UTF16_BE, "utf-16")):
        if head.startswith(mark):
            return name, "strict"
    if b"\0" in head:
        raise TableError(source, "is not text, or in UTF-16 without a mark at its beginning: save it as UTF-8")
    return "utf-8-sig", "kalmanq_latin_1"


@contextmanager
def opened(source: Source) -> Iterator[TextIO]:
    """Its text, read once from the beginning to the end"""
    try:
        raw: Any = sys.stdin.buffer if source.is_standard_input else open(source.path, "rb")
    except FileNotFoundError:
        raise TableError(source, "no such file") from None
    except IsADirectoryError:
        raise TableError(source, "is a folder") from None
    try:
        text = io.TextIOWrapper(raw, *_encoding(source, raw.peek(HEAD)), newline="")
        try:
            yield text
        finally:
            text.detach()
    except UnicodeDecodeError as problem:
        raise TableError(source, f"is not {problem.encoding.upper()} text") from problem
    finally:
        if not source.is_standard_input:
            raw.close()


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
        names = {source.layout.rename.get(name, name) for name in wanted}
        fitting = [one for one in there if names <= set(map(without_unit, cells_of(header, one)))]
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


def places_of(source: Source, cells: Sequence[str], name: str) -> list[int]:
    """The columns of that name, or of that name with a unit behind it"""
    column = source.layout.rename.get(name, name)
    found = [k for k, cell in enumerate(cells) if cell == column]
    return found or [k for k, cell in enumerate(cells) if without_unit(cell) == column]


def place_of(source: Source, cells: Sequence[str], name: str, unit: str, line: int) -> int:
    """The one of them"""
    column, found = source.layout.rename.get(name, name), places_of(source, cells, name)
    if len(found) > 1:
        raise TableError(source, f"the column {column} is there twice: leave one out, or give it another name", line)
    is_number = [_float(cell) is not None for cell in cells]
    if not found and any(is_number) and not any(cell[:1].isalpha() for cell, one in zip(cells, is_number) if not one):
        raise TableError(source, f"there is no header: {', '.join(cells)[:SHOWN]} are no names; the first row has the names of the columns, "
                         f"{column} among them", line)
    if not found:
        raise TableError(source, f"there is no column {column}; there are {', '.join(cells)}"
                         + ("" if name in source.layout.rename else f" (--rename {name}=... says which it is)"), line)
    own = unit_of(cells[found[0]]) if cells[found[0]] != column else ""
    if own and unit and own != unit:
        raise TableError(source, f"{cells[found[0]]} is in {own}, the model has {name} in {unit}: convert it, or "
                         f"--rename '{name}={cells[found[0]]}' if the heading alone is wrong", line)
    return found[0]


# ------------------------------------------------------------------------------ numbers


def _float(text: str) -> Optional[float]:
    try:
        return None if "_" in text else float(text)
    except ValueError:
        return None


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
        self.numbers_missing = layout.numbers_missing

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

    def number(self, cell: str) -> float:
        """ValueError: it is none"""
        if cell.lower() in self.missing:
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
