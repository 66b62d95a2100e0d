"""Sensors at different rates (--every): there is no full sample in each row, but a cycle of rows that settles.

A row counts from the last full sample.  As long as each row has the components that are due in it, N cycles after a
full sample the covariance of each row of the cycle is known, by the bound of `enclosure`.  From then on each row of the
cycle has a constant gain.
"""

from __future__ import annotations

import decimal
import math
from dataclasses import dataclass
from functools import reduce
from typing import Optional, Sequence

import numpy as np

from kalmanq.compiler.given.enclosure import DIGITS, GONE, MORE, Map, doublings, is_within, least_steps, sampled, steps
from kalmanq.compiler.given.exact import Numbers, decimals, symmetric
from kalmanq.compiler.given.request import Request, due
from kalmanq.errors import KalmanqError

LONGEST = 100  # rows
Matrix = np.ndarray


@dataclass(frozen=True)
class Row:
    """Of a row of the settled cycle.  due: bits of its components; gain: n x m, 0 for the others; variances: m, of
    innovations given those before them, infinite for the others"""

    due: int
    predicted: Matrix
    filtered: Matrix
    gain: Matrix
    variances: Matrix


@dataclass(frozen=True)
class Cycle:
    """rows[0] follows a full sample, and the last has one; cycles: after which it has settled"""

    rows: Sequence[Row]
    cycles: int
    tolerance: float

    @property
    def gains(self) -> list[Matrix]:
        return [row.gain.astype(float) for row in self.rows]

    @property
    def variances(self) -> Matrix:
        """m, the least in a row"""
        return np.min([row.variances for row in self.rows], axis=0)

    @property
    def means(self) -> Matrix:
        """Variances of the n means, the least in a row"""
        return np.min([np.diag(row.filtered).astype(float) for row in self.rows], axis=0)


def check(given: Request) -> None:
    every = given.options.every
    if given.of.m == 1:
        raise KalmanqError("--every: is of several measurements: leave --every out")
    if len(every) != given.of.m or min(every) < 1:
        raise KalmanqError(f"--every: give {given.of.m} whole numbers, the rows from one value to the next of each measurement, such as 1,10")
    if min(every) != 1:
        raise KalmanqError("--every: one measurement has to be in every row: give the model a longer step")
    if math.lcm(*every) > LONGEST:
        raise KalmanqError(f"--every: all measurements meet after {math.lcm(*every)} rows, at most {LONGEST}: give numbers that meet earlier, or leave --every out")
    options = given.options
    for other, is_given in (("--nis", options.nis), ("--robust gate", options.gate is not None), ("--lag", options.lag)):
        if is_given:
            raise KalmanqError(f"--every and {other}: a cycle of constant gains has no {other}: leave {other} or --every out; without "
                               "--every each row is worked out")


def settled(of: Numbers, every: Sequence[int], tolerance: float) -> Optional[Cycle]:
    with decimal.localcontext(DIGITS):
        masks = [due(every, row) for row in range(1, math.lcm(*every) + 1)]
        _, ahead = steps(of, [_components(of, mask) for mask in masks])
        doubled, floor = doublings(reduce(Map.then, ahead)), np.diag(of.P0) * GONE

        def has_settled(one: Map) -> bool:
            for step in ahead:
                if not is_within(one, tolerance, floor):
                    return False
                one = one.then(step)
            return True

        if not has_settled(doubled[-1]):
            return None
        return Cycle(_rows(of, masks, doublings(doubled[-1], MORE)[-1].Q), least_steps(doubled, has_settled), tolerance)


def _components(of: Numbers, mask: int) -> list[int]:
    return [j for j in range(of.m) if mask >> j & 1]


def _rows(of: Numbers, masks: Sequence[int], P: Matrix) -> list[Row]:
    made = []
    for mask in masks:
        taken = _components(of, mask)
        gain, variances = decimals(np.zeros((of.n, of.m))), np.full(of.m, np.inf)
        predicted, gain[:, taken], variances[taken], _ = sampled(of, P, taken)
        P = symmetric(predicted - gain[:, taken] @ of.H[taken] @ predicted)
        made.append(Row(mask, predicted, P, gain, variances))
    return made
