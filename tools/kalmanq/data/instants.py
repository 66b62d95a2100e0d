"""Rows of one time: those whose cells do not overlap are one row; a cell that is given twice is two measurements."""

from __future__ import annotations

import warnings
from dataclasses import replace
from typing import Collection, Iterable, Iterator, Optional

import numpy as np

from kalmanq.data.blocks import Block, joined, part_of
from kalmanq.errors import KalmanqWarning, counted


class Instants:
    """Blocks of rows in the order of time, each time whole in one of them.  controls: columns whose last cell at a time holds"""

    def __init__(self, source: object, controls: Collection[str]):
        self._source, self._controls = source, controls
        self._count, self._line, self._same = 0, 0, 0  # rows that give a cell again; those of them whose numbers are the same

    def of(self, blocks: Iterable[Block]) -> Iterator[Block]:
        """The rows of the last time wait for the next block."""
        waiting: Optional[Block] = None
        for block in blocks:
            block = block if waiting is None else joined([waiting, block])
            first = int(np.searchsorted(block.times, block.times[-1]))
            waiting = part_of(block, slice(first, None))
            if first:
                yield self._merged(part_of(block, slice(0, first)))
        if waiting is not None:
            yield self._merged(waiting)
        if self._count:
            more = f" (and {self._count - 1} more)" if self._count > 1 else ""
            same = f"; {counted(self._same, 'row')} with the same numbers: leave out what a logger only repeats" if self._same else ""
            warnings.warn(f"{self._source}: row {self._line}: gives a cell again at the time of the row before: both are taken, as two "
                          f"measurements{more}{same}", KalmanqWarning, stacklevel=2)

    def _merged(self, block: Block) -> Block:
        is_same = np.diff(block.times, prepend=np.nan) == 0
        if not np.any(is_same):
            return block
        measured = [name for name in block.columns if name not in self._controls]
        there = np.zeros(block.length, np.int64)
        for k, name in enumerate(measured):
            there |= (~np.isnan(block.columns[name])).astype(np.int64) << k
        row, now, taken = np.empty(block.length, int), -1, 0
        for k, (same, bits) in enumerate(zip(is_same.tolist(), there.tolist())):
            overlaps = same and taken & bits
            if overlaps:
                self._count, self._line = self._count + 1, self._line or block.line(k)
                self._same += all(one[k] == one[k - 1] or one[k] != one[k] for name, one in block.columns.items() if name in measured)
            now, taken = (now, taken | bits) if same and not overlaps else (now + 1, bits)
            row[k] = now
        return self._made(block, row, is_same)

    def _made(self, block: Block, row: np.ndarray, is_same: np.ndarray) -> Block:
        """row: of each of the block's, the one that it goes into"""
        first = np.flatnonzero(np.diff(row, prepend=-1))
        columns = {}
        for name, values in block.columns.items():
            if name in self._controls:
                values = _held(values, is_same)
            columns[name] = made = np.full(len(first), np.nan)
            is_there = ~np.isnan(values)
            made[row[is_there]] = values[is_there]
        lines = np.array([block.line(int(k)) for k in first])
        return replace(block, columns=columns, times=block.times[first], lines=lines)


def _held(values: np.ndarray, is_same: np.ndarray) -> np.ndarray:
    """A control that is not there is the one of the row before, if that is of the same time."""
    made = values.copy()
    for k in np.flatnonzero(is_same & np.isnan(values)):
        made[k] = made[k - 1]
    return made
