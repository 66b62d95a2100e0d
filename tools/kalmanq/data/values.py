"""Cells of a quantity as its values: what is missing, its unit, what is plausible and what its range allows."""

from __future__ import annotations

import warnings
from typing import Sequence

import numpy as np

from kalmanq.data.layouts import Numbers, Source, TableError, numbers_in
from kalmanq.errors import KalmanqWarning
from kalmanq.model import Quantity


class Values:
    """Of all blocks of a table alike.  has_to_fit: what is beyond its range is refused, otherwise it is warned of"""

    def __init__(self, source: Source, has_to_fit: bool):
        self.source, self._cells, self._has_to_fit = source, Numbers(source.layout), has_to_fit
        self._noted: dict[tuple[str, str], tuple[str, int, int]] = {}  # of a quantity and a reason: what is told, the first row, how many

    def look(self, columns: Sequence[Sequence[str]]) -> None:
        self._cells.look(columns)

    def warn(self) -> None:
        for why, line, count in self._noted.values():
            warnings.warn(f"{self.source}: row {line}: {why}{more(count)}", KalmanqWarning, stacklevel=2)

    def take(self, one: Quantity, values: np.ndarray, lines: Sequence[int]) -> np.ndarray:
        reading = one.reading
        for missing in [*self._cells.numbers_missing, *numbers_in(reading.missing)]:
            values[values == missing] = np.nan
        values = reading.factor * values + reading.offset if reading.converts else values
        wrong = np.isinf(values)
        if np.any(wrong):
            raise TableError(self.source, "is not representable: take other units", lines[int(np.argmax(wrong))], one.name)
        if reading.plausible:
            low, high = reading.plausible
            self._note(one, values, (values < low) | (values > high), lines, f"is not plausible, {low:g} to {high:g} is: it is missing")
            values[(values < low) | (values > high)] = np.nan
        if one.range is not None:
            self._look_at_range(one, values, one.ends or (-one.range, one.range), lines)
        return values

    def numbers(self, one: Quantity, cells: list[str], lines: Sequence[int]) -> np.ndarray:
        try:
            values = np.array(self._cells.plain(cells), dtype=np.float64)
            if values.shape == (len(cells),):
                return values
        except (TypeError, ValueError):
            pass
        missing = [cell.lower() for cell in one.reading.missing if isinstance(cell, str)]
        return np.array([self._number(line, one.name, cell, missing) for line, cell in zip(lines, cells)])

    def _look_at_range(self, one: Quantity, values: np.ndarray, ends: tuple[float, float], lines: Sequence[int]) -> None:
        wrong = (values < ends[0]) | (values > ends[1])
        if not np.any(wrong):
            return
        unfit = np.abs(values) > (one.range or 0)  # its format has no word for these
        row = int(np.argmax(unfit if self._has_to_fit and np.any(unfit) else wrong))
        value, cell = f"{values[row]:g}", f"{(values[row] - one.reading.offset) / one.reading.factor:g}"
        why = f"is beyond its declared range of {one.span}: --missing {cell} if that stands for nothing, otherwise a wider range in the model"
        if self._has_to_fit and np.any(unfit):
            raise TableError(self.source, f"{one.name} = {value} {why}", lines[row])
        self._note(one, values, wrong, lines, why)

    def _note(self, one: Quantity, values: np.ndarray, wrong: np.ndarray, lines: Sequence[int], why: str) -> None:
        """Told at the end: the first of them, and how many"""
        if np.any(wrong):
            row, key = int(np.argmax(wrong)), (one.name, why[:20])
            before = self._noted.get(key, (f"{one.name} = {values[row]:g} {why}", lines[row], 0))
            self._noted[key] = (*before[:2], before[2] + int(np.sum(wrong)))

    def _number(self, line: int, name: str, cell: str, missing: Sequence[str]) -> float:
        try:
            return self._cells.number(cell, missing)
        except ValueError:
            raise TableError(self.source, f"{cell[:40]!r} is not a number{self._cells.hint(cell)}", line,
                             name) from None


def more(count: int) -> str:
    return f" (and {count - 1} more)" if count > 1 else ""
