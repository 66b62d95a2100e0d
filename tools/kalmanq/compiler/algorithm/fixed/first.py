"""The largest P0 with which formats are so and so many bits finer: a row of S is as coarse as its largest sigma, which is the first
one in most models."""

from __future__ import annotations

import math
from typing import Mapping, Optional, Sequence

import numpy as np

from kalmanq.compiler.algorithm.fixed.formats import BITS, Formats, formats, gap_of, largest_sigmas, ranged
from kalmanq.compiler.given.enclosure import Settled
from kalmanq.compiler.given.request import Request, request
from kalmanq.compiler.given.slow import after_long

MARGIN = 1  # bits, beyond those that it lacks
ROWS = 13  # a power of two: sigmas of what never settles


def told_variances(given: Request, of: Formats, steady: Optional[Settled], times: float) -> str:
    """Of P0, with two digits, rounded down"""
    states = given.model.states
    return ", ".join(f"{states[i].name} {_down(one)}" for i, one in first_variances(given, of, steady, times).items())


def first_variances(given: Request, of: Formats, steady: Optional[Settled], times: float) -> Mapping[int, float]:
    """By state: diagonals of P0 that make errors so many times smaller, and all rows of S as fine as the coarsest becomes; none: P0
    does not make them coarse"""
    bits = math.ceil(math.log2(times)) + MARGIN
    sigma = _sigmas(given, steady)
    has = np.log2(np.maximum(sigma, 1e-300)) + BITS - of.exponent
    wanted = np.ceil((has.min() + bits - has).clip(0)).astype(int)
    P0 = given.of.doubles().P0 * np.outer(2.0**-wanted, 2.0**-wanted)
    made = request(given.model.changed(P0=P0, unknown=[]), given.name, given.options)
    most = largest_sigmas(made.of, gap_of(made.model))
    after = formats(made, ranged(made.model, most), None, [], most).exponent
    is_done = all(now <= was - more for now, was, more in zip(after, of.exponent, wanted))
    return {int(i): float(P0[i, i]) for i in np.flatnonzero(wanted)} if is_done else {}


def _down(value: float) -> str:
    unit = 10.0 ** (math.floor(math.log10(value)) - 1)
    return f"{math.floor(value / unit) * unit:.2g}"


def _sigmas(given: Request, steady: Optional[Settled]) -> np.ndarray:
    if steady is not None:
        return np.sqrt(steady.means)
    found: Sequence[np.ndarray] = [P for _, P in after_long(given.of, 0, range(ROWS, ROWS + 1))]
    return np.sqrt(np.diag(found[0]).astype(float)) if found else np.sqrt(np.diag(given.of.P0).astype(float))
