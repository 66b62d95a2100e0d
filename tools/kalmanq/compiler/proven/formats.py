"""Where the binary points of a model are: from what it can reach, or why it does not fit words of 32 bits."""

from __future__ import annotations

from decimal import Decimal
from typing import Sequence

import numpy as np

from kalmanq.compiler.proven.classes import ROOM, Means, Reach
from kalmanq.compiler.exact import Numbers, Settled, inverse
from kalmanq.compiler.proven.fixed import TWO, Formats, ceil_log2, floor_log2
from kalmanq.errors import KalmanqError
from kalmanq.model import Model, Quantity

LEAST_R = 8  # bits of a measurement's variance in the word of its innovation's
NO_SIGMA = -40  # of what is known for ever


def up(value: float) -> int:
    """The least k with value <= 2^k"""
    return ceil_log2(Decimal(float(value))) if value > 0 else NO_SIGMA


def ranges_of(which: str, quantities: Sequence[Quantity]) -> list[float]:
    for one in quantities:
        if not one.range:
            raise KalmanqError(f"{which}: {one.name} has no range; q31 needs one, f32 does not")
    return [float(one.range or 0) for one in quantities]


def formats_of(model: Model, of: Numbers, settled: Settled, reach: Reach, means: Means) -> Formats:
    """KalmanqError where something does not fit, by its name"""
    sigma = [up(value * ROOM) for value in reach.sigma]
    row_sigma = [_row_sigma(of, sigma, reach, j) for j in range(of.m)]
    y = [_innovation(one, most) for one, most in zip(model.measurements, means.y)]
    u = [_fraction(one, ranges_of("controls", [one])[0]) for one in model.controls]
    variance, zeros = [], []
    for j in range(of.m):
        variance.append(min(31 - up(reach.variance[j] * ROOM), 30 - 2 * row_sigma[j]))
        least = Decimal(float(reach.least_variance[j] / ROOM)) * TWO ** variance[j]
        zeros.append(31 - floor_log2(least))
        if of.R[j] * TWO ** variance[j] < 1 << LEAST_R:
            raise KalmanqError(f"R of {model.measurements[j].name} has {of.R[j] * TWO ** variance[j]:.1g} steps' worth "
                               f"in the word of its innovation's variance, {reach.variance[j]:.3g} at most: a start "
                               "that is better known, a smaller max_gap, or f32")
    weighed = [30 - up(most * ROOM) for most in _weighed(settled, reach, means)]
    fine = [_innovation(one, most) for one, most in zip(model.measurements, means.settled)]
    coarser = [min(both) for both in zip(y, fine)]
    nis = min(a + b for a, b in zip(weighed, coarser)) - 2 - of.m.bit_length()
    x = _means(of, reach, means, coarser, u, [one.range or 0 for one in model.controls])
    rows = [points_of_row(of, x, float(np.abs(of.H[j].astype(float)) @ means.x), j) for j in range(of.m)]
    for one, coarse, point in zip(model.measurements, y, rows):
        if point <= coarse:
            raise KalmanqError(f"{one.name}: what it measures reaches too far for 64 bits beside its own 2^-{coarse}: "
                               "smaller ranges, or f32")
    fine = [min(word, point - 1) for word, point in zip(fine, rows)]
    spans = ranges_of("measurements", model.measurements)  # and half a place, by which they are rounded
    z = [_fraction(one, span + 2.0 ** (-1 - coarse), word)
         for one, span, coarse, word in zip(model.measurements, spans, coarser, fine)]
    return Formats(sigma, row_sigma, variance, zeros, x, rows, z, y, fine, u, weighed, nis)


def _weighed(settled: Settled, reach: Reach, means: Means) -> np.ndarray:
    """The largest innovations over their variances: of one component after the other, and of all at once"""
    at_once = np.abs(inverse(settled.variance).astype(float)) @ means.settled
    return np.maximum(means.y / reach.least_variance, at_once)


def _row_sigma(of: Numbers, sigma: Sequence[int], reach: Reach, j: int) -> int:
    """Of one state that is measured as it is: that state's, so that a row of P is taken as it stands."""
    seen = [i for i in range(of.n) if of.H[j][i]]
    if len(seen) == 1 and abs(of.H[j][seen[0]]) == 1:
        return sigma[seen[0]]
    return up(reach.row_sigma[j] * ROOM)


def _fraction(one: Quantity, span: float, most: int = 31) -> int:
    """As declared, or as fine as a word holds and is of use"""
    if one.fraction is not None:
        if span * ROOM * 2.0 ** one.fraction >= 2.0 ** 31:
            raise KalmanqError(f"{one.name}: {span:.4g} does not fit Q{31 - one.fraction}.{one.fraction}")
        return one.fraction
    return min(31 - up(span * ROOM), most)


def _innovation(one: Quantity, span: float) -> int:
    if not np.isfinite(span):
        raise KalmanqError(f"{one.name}: its innovation has no bound: a smaller max_gap, or f32")
    return 31 - up(span * ROOM)


def _means(of: Numbers, reach: Reach, means: Means, y: Sequence[int], u: Sequence[int],
           pushes: Sequence[float]) -> list[int]:
    """Points of the means: no sum on the way overflows, gains fit, and so do the coefficients of controls."""
    A, B = (np.abs(matrix.astype(float)) for matrix in (of.A, of.B))
    moved, corrected = A @ means.x + B @ np.array(pushes), means.x + reach.gain @ np.maximum(means.y, means.settled)
    x = []
    for i in range(of.n):
        # a whole number of times another state is at most twice its coefficient
        most = [61 - up(max(moved[i], corrected[i], float(abs(of.x0[i])), 1e-30) * ROOM)]
        most += [30 - up(reach.gain[i][j] * ROOM) + y[j] for j in range(of.m) if reach.gain[i][j] > 0]
        most += [30 - ceil_log2(of.B[i][k]) + u[k] for k in range(of.l) if of.B[i][k]]
        x.append(min(most))
    return x


def points_of_row(of: Numbers, x: Sequence[int], span: float, j: int) -> int:
    """Where the point of a row of H x is: as fine as its states are, and no sum on the way overflows"""
    finest = min(x[i] - max(0, ceil_log2(of.H[j][i])) for i in range(of.n) if of.H[j][i])
    return min(finest, 61 - up(max(span, 1e-30) * ROOM))


def readings_of(model: Model, means: Means, made: Formats) -> list[int]:
    """Fractions of the words in which means are read"""
    return [_fraction(one, max(float(span), 1e-30)) if one.fraction is not None else
            min(31 - up(max(float(span), 1e-30)), point - 1)
            for one, span, point in zip(model.states, means.x, made.x)]
