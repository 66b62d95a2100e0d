"""What has changed since the table was made."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Iterable, Iterator

from row import Row

COMPARED = (
    "instructions", "stack_bytes", "instructions_worst", "stack_worst", "ram_program",
    "flash_program",
)  # fmt: skip
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
    changed = [
        change for key, row in now.items() if key in before for change in changes(before[key], row)
    ]
    return Comparison(
        worse=[change for change in changed if change.is_worse],
        better=[change for change in changed if change.is_better],
        not_measured=[row for key, row in before.items() if key not in now],
        not_in_table=[row for key, row in now.items() if key not in before],
    )


def changes(before: Row, now: Row) -> Iterator[Change]:
    for column in COMPARED:
        values = getattr(before, column), getattr(now, column)
        if values != (None, None):
            yield Change(now, column, *(value or 0 for value in values))
