"""Dates such as 31.05.2026 8:00 or 5/31/2026 8:00 PM, as those of ISO 8601: by pandas, where it is certain which is the day."""

from __future__ import annotations

import re
from typing import Optional, Sequence

from kalmanq.data.layouts import Source, TableError

LOCAL = re.compile(r"(\d{1,2})[./](\d{1,2})[./]\d{4}\b")
ISO = "such as 2026-05-31 08:00:10"


class LocalDates:
    """Of one column: what its first rows tell of the order holds for those that follow."""

    def __init__(self, source: Source, name: str):
        self.source, self.name = source, name
        self._is_day_first: Optional[bool] = None

    def in_iso(self, cells: Sequence[str], line: int) -> list[str]:
        """line: of the first of these rows.  Cells of which the first is no such date stay."""
        found = [LOCAL.match(cell) for cell in cells]
        if not found or not found[0]:
            return list(cells)
        pandas = self._pandas(cells[0], line)
        if self._is_day_first is None:
            self._is_day_first = self._order([one for one in found if one], line)
        try:
            made = pandas.to_datetime(list(cells), dayfirst=self._is_day_first, format="mixed")
        except ValueError:
            wrong = next((k for k, one in enumerate(found) if not one), 0)
            raise TableError(self.source, f"{cells[wrong][:40]!r} is no such date as the others: write ISO 8601, {ISO}",
                             line + wrong, self.name) from None
        return [one.isoformat(" ") for one in made]

    def _order(self, found: Sequence[re.Match], line: int) -> bool:
        """Does the day come first?"""
        day, month = (max(int(one.group(k)) for one in found) for k in (1, 2))
        if (day > 12) == (month > 12):
            raise TableError(self.source, f"{found[0].string[:40]!r} is a date whose day and month are not certain: write ISO 8601, "
                             f"{ISO}", line, self.name)
        return day > 12

    def _pandas(self, cell: str, line: int):  # type: ignore[no-untyped-def]
        try:
            import pandas  # an extra, which nothing else needs
        except ImportError:
            raise TableError(self.source, f"{cell[:40]!r} is no date of ISO 8601, {ISO}; pandas reads it, which is not installed: "
                             "pip install './tools[pandas]'", line, self.name) from None
        return pandas
