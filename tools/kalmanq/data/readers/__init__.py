"""Files that are no CSV text, by libraries that are imported when such a file is read: a module a format, and what its files are known by.

A module defines `opened(source)`, which answers a Recorded: names of columns, and a function of the places that are wanted, whose
answer is an iterator of rows of cells as a CSV file would have them.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from importlib import import_module
from typing import Callable, Collection, Iterator, NamedTuple, Optional, Sequence, Union

from kalmanq.data.layouts import Source, TableError

HEAD = 4096  # bytes that tell what a file is
INSTALL = "pip install 'kalmanq[logs]', or './tools[logs]' in the project's folder"


class Reader(NamedTuple):
    """suffixes: of its files; mark: what others begin with that are it, too"""

    module: str
    what: str
    suffixes: tuple[str, ...]
    mark: Optional[bytes] = None


READERS = (
    Reader("gpx", "GPX", (".gpx",), rb"\s*(<\?xml[^>]*>)?\s*(<!--.*?-->\s*)*<gpx\b"),
    Reader("ulog", "ULog", (".ulg", ".ulog"), rb"ULog\x01\x12\x35"),
    Reader("nmea", "NMEA", (".nmea",), rb"\s*[$!][A-Z]{2}[A-Z0-9]{3},"),
    Reader("ubx", "UBX", (".ubx",), rb"\xb5\x62"),
    Reader("can_log", "CAN", (".asc", ".blf", ".trc"), rb"\s*\(\d+\.\d+\)\s+\S+\s+[0-9A-Fa-f]+#"),
    Reader("frames", "Parquet", (".parquet",), rb"PAR1"),
    Reader("frames", "Feather", (".feather", ".arrow"), rb"ARROW1"),
    Reader("frames", "Excel", (".xlsx", ".xls"), rb"PK\x03\x04|\xd0\xcf\x11\xe0"),
)
KNOWN = f"text with a row of names, or {', '.join(one.what for one in READERS)}"


class Cells(dict):
    """A row that has few of many columns: the others are empty"""

    def __missing__(self, place: int) -> str:
        return ""


Row = Union[Sequence[str], Cells]


@dataclass(frozen=True)
class Recorded:
    """header: names of columns; rows: of the places that are wanted; line: the header's"""

    source: Source
    header: list[str]
    rows: Callable[[Collection[int]], Iterator[Row]]
    line: int = 1


def reader_of(source: Source) -> Optional[Reader]:
    """By the end of its name; of another name, by how it begins; None: it may be CSV text"""
    found = next((one for one in READERS if source.path.suffix.lower() in one.suffixes), None)
    if found or source.is_standard_input or not source.path.is_file():
        return found
    with open(source.path, "rb") as file:
        head = file.read(HEAD)
    return next((one for one in READERS if one.mark and re.match(one.mark, head, re.S)), None)


def recorded(source: Source, reader: Reader) -> Recorded:
    """What a library cannot read is one line, whatever it says; of broken sizes that it has no memory"""
    if not source.path.is_file():
        raise TableError(source, "is a folder" if source.path.is_dir() else "no such file" if not source.exists() else
                         f"{reader.what} is read from a file, not from a pipe: write it to one")
    try:
        made = import_module(f"kalmanq.data.readers.{reader.module}").opened(source)
        return replace(made, rows=lambda places: _told(source, reader, made.rows(places)))
    except TableError:
        raise
    except ImportError as problem:
        missing = problem.name or (re.findall(r"(?:Import |dependency ')(\w+)", str(problem)) or ["a library"])[0]  # pandas says it in its text alone
        raise TableError(source, f"{reader.what} is read by {missing.split('.')[0]}, which is not installed: {INSTALL}") from None
    except Exception as problem:
        raise _unreadable(source, reader, problem) from None


def _told(source: Source, reader: Reader, rows: Iterator[Row]) -> Iterator[Row]:
    try:
        yield from rows
    except TableError:
        raise
    except Exception as problem:
        raise _unreadable(source, reader, problem) from None


def _unreadable(source: Source, reader: Reader, problem: Exception) -> TableError:
    said = " ".join(str(problem).split())[:100]
    return TableError(source, f"is no {reader.what} file that its library can read ({type(problem).__name__}{': ' * bool(said)}{said}): export it again, or as CSV")


def number(value: object) -> str:
    """A cell; None and NaN are empty"""
    return "" if value is None or value != value else repr(float(value))  # type: ignore[arg-type]
