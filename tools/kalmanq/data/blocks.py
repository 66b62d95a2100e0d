"""Rows that were read, in blocks, so that files of any length fit."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Optional, Sequence

import numpy as np


@dataclass(frozen=True)
class Block:
    """Some rows of a file; first_row: the line in the file of the first of them; lines: of each, where they do not follow each other;
    times: of each, in seconds since the first row of all, or in the model's unit; is_joined: of several files; begun: where and when"""

    first_row: int
    columns: dict[str, np.ndarray]
    times: Optional[np.ndarray] = None
    lines: Optional[np.ndarray] = None
    is_joined: bool = False
    unit: str = "s"
    begun: Any = None

    @property
    def length(self) -> int:
        return len(next(iter(self.columns.values()))) if self.columns else len(self.times)

    def line(self, row: int) -> int:
        return self.first_row + row if self.lines is None else int(self.lines[row])

    def place(self, row: int) -> str:
        """How a message names it"""
        return f"at {self.times[row]:.9g} {self.unit}" if self.is_joined else f"row {self.line(row)}"


def part_of(block: Block, rows: slice) -> Block:
    columns = {name: one[rows] for name, one in block.columns.items()}
    times, lines = (None if one is None else one[rows] for one in (block.times, block.lines))
    return replace(block, first_row=block.first_row + (rows.start or 0), columns=columns, times=times, lines=lines)


def joined(blocks: Sequence[Block]) -> Block:
    if len(blocks) == 1:
        return blocks[0]
    lines = None
    if any(one.lines is not None for one in blocks):
        lines = np.concatenate([one.first_row + np.arange(one.length) if one.lines is None else one.lines for one in blocks])
    columns = {name: np.concatenate([one.columns[name] for one in blocks]) for name in blocks[0].columns}
    return replace(blocks[-1], first_row=blocks[0].first_row, columns=columns, lines=lines,
                   times=None if blocks[0].times is None else np.concatenate([one.times for one in blocks]))
