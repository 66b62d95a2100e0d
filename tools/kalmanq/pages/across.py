"""What is across a picture: rows, or their times."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Optional

import numpy as np


@dataclass(frozen=True)
class Across:
    """at: T, where each row is; unit: of times, "" of rows; step: from a row to the next, as the model has it"""

    at: np.ndarray
    unit: str = ""
    step: float = 1.0

    @property
    def label(self) -> str:
        return f"time [{self.unit}]" if self.unit else "row"

    def lasts(self, length: float) -> str:
        return f"{length:.3g} {self.unit}" if self.unit else f"{length:.0f} {'row' if length == 1 else 'rows'}"


def across(model: Any, rows: int, times: Optional[np.ndarray]) -> Across:
    of = getattr(model, "continuous", None)  # a nonlinear model has none
    if times is None:
        return Across(np.arange(rows, dtype=float))
    return Across(times, of.unit if of else "s", of.dt if of else 1.0)


@dataclass(frozen=True)
class Spoken:
    """How often a measurement was there: how many times, how long from one to the next as a rule, and at most"""

    count: int
    usual: float
    longest: float


def spoken(there: np.ndarray, along: Across) -> Spoken:
    """there: T, is it in this row?  The record's ends count as gaps, too."""
    at = along.at[there]
    if not len(at):
        return Spoken(0, np.nan, float(along.at[-1] - along.at[0]) if len(along.at) else 0.0)
    between = np.diff(at)
    ends = [at[0] - along.at[0], along.at[-1] - at[-1]]
    return Spoken(len(at), float(np.median(between)) if len(between) else np.nan, float(max([*between, *ends])))
