"""The table: its rows, as a file, and what has changed since it was made.

The file is a CSV, its first lines comments with the compilers' versions.
"""

from __future__ import annotations

import csv
from dataclasses import astuple, dataclass, fields
from pathlib import Path
from typing import Any, Iterable, Iterator

from errors import FileError, one_line
from outputs import csv_text


@dataclass(frozen=True)
class Row:
    """The columns, in their order."""

    core: str
    arithmetic: str
    n: int
    m: int
    sizes: str
    profile: str
    what: str
    instructions: int
    cycles_estimate: int
    stack_bytes: int
    instructions_worst: int | None
    stack_worst: int | None
    ram_program: int | None
    flash_program: int | None

    @property
    def key(self) -> tuple[object, ...]:
        """What is measured; the rest is what came out."""
        return (self.core, self.arithmetic, self.n, self.m, self.sizes, self.profile, self.what)


@dataclass(frozen=True)
class Table:
    versions: tuple[str, ...]  # of the compilers
    rows: tuple[Row, ...]


COLUMNS = tuple(field.name for field in fields(Row))
NUMBERS = tuple(field.name for field in fields(Row) if "int" in str(field.type))
OPTIONAL = tuple(field.name for field in fields(Row) if "None" in str(field.type))


# ---- the file --------------------------------------------------------------------------------


def to_csv(table: Table) -> str:
    comments = "".join(f"# {version}\n" for version in table.versions)
    return comments + csv_text([COLUMNS, *(astuple(row) for row in table.rows)])


def read(path: Path) -> Table:
    """The table in a file, or a FileError with the row, counted as an editor counts lines."""
    lines = lines_of(path)
    comments = [line for line in lines if line.startswith("#")]
    if len(lines) <= len(comments):
        raise FileError(path, "no header, no rows", len(lines) + 1)
    reader = csv.reader(lines[len(comments) :])
    check_header(path, len(comments) + 1, next(reader))
    rows: dict[tuple[object, ...], Row] = {}
    for number, values in enumerate(reader, len(comments) + 2):
        row = row_of(path, number, values)
        if row.key in rows:
            raise FileError(path, "the same as an earlier one", number)
        rows[row.key] = row
    return Table(tuple(line[1:].strip() for line in comments), tuple(rows.values()))


def lines_of(path: Path) -> list[str]:
    try:
        return path.read_text(encoding="utf-8").splitlines()
    except FileNotFoundError as problem:
        raise FileError(path, "no such file; tools/cost.py makes it") from problem
    except UnicodeDecodeError as problem:
        raise FileError(path, "not text in UTF-8", 1) from problem


def check_header(path: Path, number: int, names: list[str]) -> None:
    if tuple(names) != COLUMNS:
        raise FileError(path, f"the columns must be {', '.join(COLUMNS)}", number)


def row_of(path: Path, number: int, values: list[str]) -> Row:
    if len(values) != len(COLUMNS):
        raise FileError(path, f"{len(values)} fields, not {len(COLUMNS)}", number)
    found: dict[str, Any] = dict(zip(COLUMNS, values))
    for name in NUMBERS:
        if name in OPTIONAL and not found[name]:
            found[name] = None
            continue
        if not (found[name].isascii() and found[name].isdigit()):
            reason = f"{name} is '{found[name]}', not a whole number"
            raise FileError(path, one_line(reason), number)
        found[name] = int(found[name])
    return Row(**found)


# ---- changes ---------------------------------------------------------------------------------

COMPARED = (
    "instructions", "stack_bytes", "instructions_worst", "stack_worst", "ram_program",
    "flash_program",
)
TOLERANCE = 3  # percent


@dataclass(frozen=True)
class Change:
    row: Row  # as measured
    column: str
    before: int
    now: int

    @property
    def share(self) -> float:
        return self.now / self.before - 1 if self.before else float(self.now > 0)

    @property
    def is_worse(self) -> bool:
        return 100 * (self.now - self.before) > TOLERANCE * self.before

    @property
    def is_better(self) -> bool:
        return 100 * (self.before - self.now) > TOLERANCE * self.before


@dataclass(frozen=True)
class Comparison:
    worse: list[Change]
    better: list[Change]  # by as much
    not_measured: list[Row]  # in the table only
    not_in_table: list[Row]  # measured only

    @property
    def passes(self) -> bool:
        return not (self.worse or self.not_measured or self.not_in_table)


def compare(table: Iterable[Row], measured: Iterable[Row]) -> Comparison:
    before = {row.key: row for row in table}
    now = {row.key: row for row in measured}
    changed = [change for key, row in now.items() if key in before for change in changes(before[key], row)]
    return Comparison(
        worse=[change for change in changed if change.is_worse],
        better=[change for change in changed if change.is_better],
        not_measured=[row for key, row in before.items() if key not in now],
        not_in_table=[row for key, row in now.items() if key not in before])


def changes(before: Row, now: Row) -> Iterator[Change]:
    for column in COMPARED:
        values = getattr(before, column), getattr(now, column)
        if values != (None, None):
            yield Change(now, column, *(value or 0 for value in values))
