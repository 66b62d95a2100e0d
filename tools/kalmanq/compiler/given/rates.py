"""Sensors at different rates, as rows of data show them: what --every is given."""

from __future__ import annotations

import math
from collections import Counter
from typing import Optional

import numpy as np

LONGEST = 100  # rows, after which all have met
MOST = 0.8  # of a measurement's values: they come in its rhythm, the others fail or come twice
LEAST = 3  # values of which a rhythm is judged


def rates_of(z: np.ndarray) -> tuple[int, ...]:
    """Of each measurement the rows from one value to the next; (): all come in each row, or in no rhythm that --every takes"""
    there = ~np.isnan(np.asarray(z, float))
    full = np.flatnonzero(there.all(axis=1))
    made = [_rhythm(np.flatnonzero(column), full) for column in there.T]
    if any(one is None for one in made) or min(made, default=2) != 1 or max(made) == 1 or math.lcm(*made) > LONGEST:
        return ()
    return tuple(made)


def _rhythm(rows: np.ndarray, full: np.ndarray) -> Optional[int]:
    if len(rows) < LEAST or not len(full):
        return None
    every, count = Counter(np.diff(rows).tolist()).most_common(1)[0]
    in_step = np.count_nonzero((rows - full[0]) % every == 0)
    return every if count >= MOST * (len(rows) - 1) and in_step >= MOST * len(rows) else None
