"""The table as a file: a CSV, its first lines comments with the compilers' versions."""

from __future__ import annotations

import csv
import io
from dataclasses import astuple, dataclass, fields
from pathlib import Path
from typing import Any

from errors import CostError, one_line
from row import Row

COLUMNS = tuple(field.name for field in fields(Row))
NUMBERS = tuple(field.name for field in fields(Row) if "int" in str(field.type))
OPTIONAL = tuple(field.name for field in fields(Row) if "None" in str(field.type))


@dataclass(frozen=True)
class Table:
    versions: tuple[str, ...]  # of the compilers
    rows: tuple[Row, ...]


def to_csv(table: Table) -> str:
    text = io.StringIO()
    for version in table.versions:
        text.write(f"# {version}\n")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    writer.writerows(astuple(row) for row in table.rows)
    return text.getvalue()


def read(path: Path) -> Table:
    """The table in a file, or a CostError with the row, counted as an editor counts lines."""
    lines = lines_of(path)
    comments = [line for line in lines if line.startswith("#")]
    if len(lines) <= len(comments):
        raise CostError(f"{shown(path)}: row {len(lines) + 1}: no header, no rows")
    reader = csv.reader(lines[len(comments) :])
    check_header(path, len(comments) + 1, next(reader))
    rows: dict[tuple[object, ...], Row] = {}
    for number, values in enumerate(reader, len(comments) + 2):
        row = row_of(path, number, values)
        if row.key in rows:
            raise CostError(f"{shown(path)}: row {number}: the same as an earlier one")
        rows[row.key] = row
    return Table(tuple(line[1:].strip() for line in comments), tuple(rows.values()))


def lines_of(path: Path) -> list[str]:
    try:
        return path.read_text(encoding="utf-8").splitlines()
    except FileNotFoundError as problem:
        raise CostError(f"{shown(path)}: no such file; tools/cost.py makes it") from problem
    except UnicodeDecodeError as problem:
        raise CostError(f"{shown(path)}: row 1: not text in UTF-8") from problem


def check_header(path: Path, number: int, names: list[str]) -> None:
    if tuple(names) != COLUMNS:
        raise CostError(f"{shown(path)}: row {number}: the columns must be {', '.join(COLUMNS)}")


def row_of(path: Path, number: int, values: list[str]) -> Row:
    if len(values) != len(COLUMNS):
        reason = f"{len(values)} fields, not {len(COLUMNS)}"
        raise CostError(f"{shown(path)}: row {number}: {reason}")
    found: dict[str, Any] = dict(zip(COLUMNS, values))
    for name in NUMBERS:
        if name in OPTIONAL and not found[name]:
            found[name] = None
            continue
        if not (found[name].isascii() and found[name].isdigit()):
            reason = f"{name} is '{found[name]}', not a whole number"
            raise CostError(f"{shown(path)}: row {number}: {one_line(reason)}")
        found[name] = int(found[name])
    return Row(**found)


def shown(path: Path) -> str:
    return one_line(str(path))
