"""What covariances, gains and means can be where samples are missing as declared: bounds for fixed point.

Doubles, for decisions that leave a hundredth of room; what comes of them is proven by the search (search.py).  A gap
begins at any sample after the start, or once the covariance has settled again.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Optional, Sequence

import numpy as np

from kalmanq.compiler.exact import Numbers, Settled, taken

ROOM = 1.01


@dataclass(frozen=True)
class Ways:
    """Several ways to go on from one place, a gap of another length each.

    gains     ways x rows x m x n, of one component after the other; 0 where a row is missing
    measured  ways x rows
    """

    gains: np.ndarray
    measured: np.ndarray


@dataclass
class Reach:
    """Largest of each sigma (states, rows of H x), gain n x m, variance of an innovation; the least variance, too.

    begun    the rows after the start, without a gap
    started  ways to go on after so many of them, for each
    settled  ways to go on once settled
    """

    sigma: np.ndarray
    row_sigma: np.ndarray
    gain: np.ndarray
    variance: np.ndarray
    least_variance: np.ndarray
    begun: Ways
    started: list[Ways] = field(default_factory=list)
    settled: Optional[Ways] = None


def reach_of(of: Numbers, state: Settled, settling: int, max_gap: int) -> Reach:
    d, n, m = of.doubles(), of.n, of.m
    nothing = Ways(np.zeros((1, 0, m, n)), np.zeros((1, 0), bool))
    reach = Reach(np.zeros(n), np.zeros(m), np.abs(state.gain.astype(float)), np.zeros(m), np.full(m, np.inf), nothing)
    lengths = np.arange(max_gap + 1)
    P = d.P0[None]
    _widen(d, P, reach)
    reach.started.append(walk(d, P[0], lengths, settling, reach))
    gains = np.zeros((1, settling + 1, m, n))
    for row in range(settling + 1):
        if row:
            P = predicted(d, P, reach)
        P, gains[:, row] = updated(d, P, np.ones(1, bool), reach)
        reach.started.append(walk(d, P[0], lengths, settling, reach))
    reach.begun = Ways(gains, np.ones((1, settling + 1), bool))
    reach.settled = walk(d, state.filtered.astype(float), lengths, settling, reach)
    return reach


def reach_by_gain(of: Numbers, state: Settled, settling: int, max_gap: int) -> Reach:
    """Of the constant gain: the same rows as a filter that has settled before it began"""
    d, gain = of.doubles(), np.abs(state.gain.astype(float))
    nothing = Ways(np.zeros((1, 0, of.m, of.n)), np.zeros((1, 0), bool))
    variances = np.array([float(value) for value in np.diag(state.variance)])
    sequential = _sequential(of, state)
    made = Reach(np.zeros(of.n), np.zeros(of.m), np.maximum(gain, np.abs(sequential.T)), variances, variances, nothing)
    _widen(d, state.predicted.astype(float)[None], made)
    lengths = np.arange(max_gap + 1)
    measured = np.arange(max_gap + settling)[None, :] >= lengths[:, None]
    ways = Ways(np.where(measured[:, :, None, None], sequential, 0), measured)
    made.begun = Ways(np.broadcast_to(sequential, (1, settling + 1, *sequential.shape)),
                      np.ones((1, settling + 1), bool))
    made.started, made.settled = [ways] * (settling + 2), ways
    return made


def _sequential(of: Numbers, state: Settled) -> np.ndarray:
    """m x n: the settled gains of one component after the other, which come to the same mean"""
    P, gains = state.predicted, []
    for j in range(of.m):
        row = P @ of.H[j]
        gains.append(row / (of.H[j] @ row + of.R[j]))
        P = taken(of, P, j)
    return np.array(gains).astype(float)


def walk(d: Numbers, P: np.ndarray, lengths: np.ndarray, settling: int, reach: Reach) -> Ways:
    """Gaps of these lengths, and rows until all have settled"""
    ways, rows, (m, n) = len(lengths), int(lengths.max()) + settling, d.H.shape
    made = Ways(np.zeros((ways, rows, m, n)), np.arange(rows)[None, :] >= lengths[:, None])
    at = np.repeat(P[None], ways, axis=0)
    for row in range(rows):
        at = predicted(d, at, reach)
        at, made.gains[:, row] = updated(d, at, made.measured[:, row], reach)
    return made


def predicted(d: Numbers, P: np.ndarray, reach: Reach) -> np.ndarray:
    P = d.A @ P @ d.A.T + d.Q
    _widen(d, P, reach)
    return P


def _widen(d: Numbers, P: np.ndarray, reach: Reach) -> None:
    variances = np.diagonal(P, axis1=1, axis2=2).max(axis=0)
    of_rows = np.einsum("ji,wik,jk->wj", d.H, P, d.H).max(axis=0)
    reach.sigma = np.maximum(reach.sigma, np.sqrt(np.maximum(variances, 0)))
    reach.row_sigma = np.maximum(reach.row_sigma, np.sqrt(np.maximum(of_rows, 0)))


def updated(d: Numbers, P: np.ndarray, measured: np.ndarray, reach: Reach) -> tuple[np.ndarray, np.ndarray]:
    """ways x n x n; the gains ways x m x n.  What is not measured is left as it is."""
    gains = np.zeros((len(P), *d.H.shape))
    if not np.any(measured):
        return P, gains
    for j, h in enumerate(d.H):
        row = P @ h
        s = row @ h + d.R[j]
        k = np.where(measured[:, None], row / s[:, None], 0)
        gains[:, j] = k
        reach.gain[:, j] = np.maximum(reach.gain[:, j], np.abs(k).max(axis=0))
        reach.variance[j] = max(reach.variance[j], s[measured].max())
        reach.least_variance[j] = min(reach.least_variance[j], s[measured].min())
        P = P - k[:, :, None] * row[:, None, :]
        P = (P + P.transpose(0, 2, 1)) / 2
    return P, gains


# ------------------------------------------------------------------------------ means


@dataclass
class Span:
    """Sets of means, one a way: x = turned start + sum of columns times numbers of -1 to 1.

    turned ways x n x n, columns ways x n x c; the start is a box, or one point
    """

    turned: np.ndarray
    columns: np.ndarray
    box: np.ndarray
    is_point: bool

    def bound(self, rows: Optional[np.ndarray] = None) -> np.ndarray:
        """Of each state, or of rows of H x: ways x n"""
        turned, columns = (self.turned, self.columns) if rows is None else (rows @ self.turned, rows @ self.columns)
        own = np.abs(turned @ self.box) if self.is_point else np.abs(turned) @ self.box
        return own + np.abs(columns).sum(axis=2)

    def moved(self, A: np.ndarray, new: np.ndarray) -> Span:
        columns = A @ self.columns
        new = np.broadcast_to(new, (*columns.shape[:2], new.shape[-1]))
        return replace(self, turned=A @ self.turned, columns=np.concatenate([columns, new], axis=2))

    def repeated(self, ways: int) -> Span:
        return replace(self, turned=np.repeat(self.turned, ways, axis=0), columns=np.repeat(self.columns, ways, axis=0))


@dataclass
class Means:
    """Largest |mean| of each state and |innovation| of each measurement"""

    x: np.ndarray
    y: np.ndarray


@dataclass
class Inputs:
    """What a filter is given at most: measurements, controls"""

    z: np.ndarray
    u: np.ndarray


def means_of(of: Numbers, state: Settled, reach: Reach, z: Sequence[float], u: Sequence[float]) -> Means:
    """By the L1 norm of the closed loop's impulse response, over the ways of missing samples: for the worst
    measurements and controls within their ranges."""
    d, given = of.doubles(), Inputs(np.array(z, float), np.array(u, float))
    means = Means(np.abs(d.x0), np.zeros(of.m))
    box = np.maximum(_steady_box(d, state, given), _started(d, reach, given, means))
    assert reach.settled is not None
    for _ in range(100):  # what settled filters come to, one gap after the other
        span = Span(np.eye(of.n)[None], np.zeros((1, of.n, 0)), box, False)
        ends = _follow(d, span, reach.settled, given, means).bound().max(axis=0)
        if np.all(ends <= box):
            return Means(np.maximum(means.x, box) * ROOM, means.y * ROOM)
        box = np.maximum(box, ends) * 1.001
    return Means(np.full(of.n, np.inf), np.full(of.m, np.inf))


def _started(d: Numbers, reach: Reach, given: Inputs, means: Means) -> np.ndarray:
    """The bound where filters have settled for the first time, after a gap at any row or none."""
    n, ends = len(d.A), np.zeros(len(d.A))
    span = Span(np.eye(n)[None], np.zeros((1, n, 0)), d.x0, True)
    for row, ways in enumerate(reach.started):
        ends = np.maximum(ends, _follow(d, span, ways, given, means).bound().max(axis=0))
        if row < reach.begun.gains.shape[1]:
            if row:
                span = _advanced(d, span, given, means)
            span = _taken(d, span, reach.begun.gains[:, row], np.ones(1, bool), given, means)
    return ends


def _steady_box(d: Numbers, state: Settled, given: Inputs) -> np.ndarray:
    """Of a filter that has been settled for ever"""
    K = state.gain.astype(float)
    closed = (np.eye(len(d.A)) - K @ d.H) @ d.A
    term = np.concatenate([K * given.z, (np.eye(len(d.A)) - K @ d.H) @ d.B * given.u], axis=1)
    total = np.zeros(len(d.A))
    for _ in range(100_000):
        total += np.abs(term).sum(axis=1)
        term = closed @ term
        if np.abs(term).sum() < 1e-9 * total.max():
            return total * ROOM
    return np.full(len(d.A), np.inf)


def _follow(d: Numbers, span: Span, ways: Ways, given: Inputs, means: Means) -> Span:
    """Where the ways end; widens means by all that is met on them."""
    span = span.repeated(len(ways.gains))
    for row in range(ways.gains.shape[1]):
        span = _taken(d, _advanced(d, span, given, means), ways.gains[:, row], ways.measured[:, row], given, means)
    return span


def _advanced(d: Numbers, span: Span, given: Inputs, means: Means) -> Span:
    span = span.moved(d.A, d.B * given.u)
    means.x = np.maximum(means.x, span.bound().max(axis=0))
    return span


def _taken(d: Numbers, span: Span, gains: np.ndarray, measured: np.ndarray, given: Inputs, means: Means) -> Span:
    """One component after the other; innovations of all of them at once, as settled filters take them, are met, too."""
    if not np.any(measured):
        return span
    means.y = np.maximum(means.y, given.z + span.bound(d.H)[measured].max(axis=0))
    for j, h in enumerate(d.H):
        means.y[j] = max(means.y[j], given.z[j] + span.bound(h[None])[measured].max())
        k = gains[:, j]
        span = span.moved(np.eye(len(h)) - k[:, :, None] * h, (k * given.z[j])[:, :, None])
        means.x = np.maximum(means.x, span.bound().max(axis=0))
    return span


# ------------------------------------------------------------------------------ what a constant gain loses


def losses(of: Numbers, state: Settled, settling: int, max_gap: int) -> tuple[float, float]:
    """The largest sigma of a filter of constant gain over that of the optimal one, after a measured row: of the rows
    after the start, and of those after a gap."""
    d, K = of.doubles(), state.gain.astype(float)
    begun = _loss(d, K, d.P0, 0, settling, measured_first=True)
    gaps = [_loss(d, K, state.filtered.astype(float), gap, settling) for gap in range(1, max_gap + 1)]
    return begun, max(gaps, default=1.0)


def _loss(d: Numbers, K: np.ndarray, P: np.ndarray, gap: int, rows: int, measured_first: bool = False) -> float:
    kept, best, worst = P, P, 1.0
    change = np.eye(len(P)) - K @ d.H
    nobody = Reach(np.zeros(len(P)), np.zeros(len(d.H)), np.zeros(K.shape), np.zeros(len(d.H)),
                   np.full(len(d.H), np.inf),
                   Ways(np.zeros((1, 0, *d.H.shape)), np.zeros((1, 0), bool)))
    for row in range(gap + rows):
        if row or not measured_first:
            kept, best = (d.A @ one @ d.A.T + d.Q for one in (kept, best))
        if row >= gap:
            kept = change @ kept @ change.T + K * d.R @ K.T
            best = updated(d, best[None], np.ones(1, bool), nobody)[0][0]
            known = np.diag(best) > 0
            worst = max(worst, np.sqrt(np.max(np.diag(kept)[known] / np.diag(best)[known], initial=1.0)))
    return float(worst)
