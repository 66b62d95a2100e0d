"""What covariances, gains and means can be where samples are missing as declared: bounds for fixed point.

Doubles, for decisions that leave a hundredth of room; what comes of them is proven by the search (search.py).  A gap
begins at any sample after the start, or once the covariance has settled again.  Its rows are missing as a whole or,
where samples in part are declared, each has some of its components: every sequence of them is followed.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from itertools import product
from typing import Iterator, Optional, Sequence

import numpy as np

from kalmanq.compiler.exact import Numbers, Settled, taken
from kalmanq.errors import KalmanqError

ROOM = 1.01
FADED = 1e-6  # what is left of a mean that counts as forgotten, well within ROOM
MOST_WAYS = 5000  # gaps of samples in part


@dataclass(frozen=True)
class Ways:
    """Several ways to go on from one place, another gap each.

    gains     ways x rows x m x n, of one component after the other; 0 where it is missing
    measured  ways x rows x m
    constant  ways x rows: taken by the constant gain, all components at once
    """

    gains: np.ndarray
    measured: np.ndarray
    constant: np.ndarray


@dataclass
class Reach:
    """Largest of each sigma (states, rows of H x), gain n x m, variance of an innovation; the least variance, too.

    begun    the rows after the start, without a gap
    started  ways to go on after so many of them, for each
    settled  ways to go on from where gaps begin: from a settled filter, or at any sample where the gain is constant
    """

    sigma: np.ndarray
    row_sigma: np.ndarray
    gain: np.ndarray
    variance: np.ndarray
    least_variance: np.ndarray
    begun: Ways
    started: list[Ways] = field(default_factory=list)
    settled: list[Ways] = field(default_factory=list)


@dataclass(frozen=True)
class Gap:
    """The gaps of a class: at most so many rows, missing as a whole or, in part, any components of them"""

    longest: int
    in_part: bool = False

    def patterns(self, m: int) -> Iterator[tuple[tuple[bool, ...], ...]]:
        """What is measured of each row of a gap; the shortest first, the first has no row"""
        rows = [one for one in product((False, True), repeat=m) if not all(one)] if self.in_part else [(False,) * m]
        for length in range(self.longest + 1):
            yield from product(rows, repeat=length)

    def count(self, m: int) -> int:
        return sum(self.count_of(m, length) for length in range(self.longest + 1))

    def count_of(self, m: int, length: int) -> int:
        return (2**m - 1 if self.in_part else 1) ** length


def reach_of(of: Numbers, state: Settled, settling: int, gap: Gap) -> Reach:
    d, n, m = of.doubles(), of.n, of.m
    patterns = list(gap.patterns(m))
    nothing = Ways(np.zeros((1, 0, m, n)), np.zeros((1, 0, m), bool), np.zeros((1, 0), bool))
    reach = Reach(np.zeros(n), np.zeros(m), np.abs(state.gain.astype(float)), np.zeros(m), np.full(m, np.inf), nothing)
    P = d.P0[None]
    _widen(d, P, reach)
    reach.started.append(walk(d, P[0], masks_of(patterns, m, 0, gap.longest, settling), reach))
    gains = np.zeros((1, settling + 1, m, n))
    for row in range(settling + 1):
        if row:
            P = predicted(d, P, reach)
        P, gains[:, row] = updated(d, P, np.ones((1, m), bool), reach)
        reach.started.append(walk(d, P[0], masks_of(patterns, m, row + 1, gap.longest, settling), reach))
    reach.begun = Ways(gains, np.ones((1, settling + 1, m), bool), np.arange(settling + 1)[None, :] >= settling - 1)
    if gap.longest:
        reach.settled.append(walk(d, state.filtered.astype(float),
                                  masks_of(patterns[1:], m, settling, gap.longest, settling), reach))
    return reach


def reach_by_gain(of: Numbers, state: Settled, settling: int, gap: Gap) -> Reach:
    """Of the constant gain: the same rows as a filter that has settled before it began"""
    d, gain = of.doubles(), np.abs(state.gain.astype(float))
    variances = np.array([float(value) for value in np.diag(state.variance)])
    sequential = _sequential(of, state)

    def ways(measured: np.ndarray) -> Ways:
        return Ways(np.where(measured[..., None], sequential, 0), measured, measured.all(axis=2))

    made = Reach(np.zeros(of.n), np.zeros(of.m), np.maximum(gain, np.abs(sequential.T)), variances, variances,
                 ways(np.ones((1, 1, of.m), bool)))
    _widen(d, state.predicted.astype(float)[None], made)
    if gap.longest:
        made.settled.append(ways(masks_of(list(gap.patterns(of.m))[1:], of.m, 0, gap.longest, settling)[0]))
    return made


def _sequential(of: Numbers, state: Settled) -> np.ndarray:
    """m x n: the settled gains of one component after the other, which come to the same mean"""
    P, gains = state.predicted, []
    for j in range(of.m):
        row = P @ of.H[j]
        gains.append(row / (of.H[j] @ row + of.R[j]))
        P = taken(of, P, j)
    return np.array(gains).astype(float)


def masks_of(patterns: Sequence, m: int, before: int, longest: int, settling: int) -> tuple[np.ndarray, np.ndarray]:
    """Which components of each row are measured, after so many whole samples in a row before, and which rows are taken
    by the constant gain: gaps, and rows until all have settled."""
    rows = longest + settling
    measured = np.ones((len(patterns), rows, m), bool)
    constant = np.zeros((len(patterns), rows), bool)
    for way, pattern in enumerate(patterns):
        if pattern:
            measured[way, :len(pattern)] = pattern
        since = np.arange(rows) - len(pattern)  # whole samples in a row
        constant[way] = (since >= 0) & (since + (0 if pattern else before) >= settling - 1)
    return measured, constant


def walk(d: Numbers, P: np.ndarray, masks: tuple[np.ndarray, np.ndarray], reach: Reach) -> Ways:
    measured, constant = masks
    made = Ways(np.zeros((*measured.shape, d.H.shape[1])), measured, constant)
    at = np.repeat(P[None], len(measured), axis=0)
    for row in range(measured.shape[1]):
        at = predicted(d, at, reach)
        at, made.gains[:, row] = updated(d, at, measured[:, row], reach)
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
    """ways x n x n; the gains ways x m x n.  What is not measured (ways x m) is left as it is."""
    gains = np.zeros((len(P), *d.H.shape))
    for j, h in enumerate(d.H):
        there = measured[:, j]
        if not np.any(there):
            continue
        row = P @ h
        s = row @ h + d.R[j]
        k = np.where(there[:, None], row / s[:, None], 0)
        gains[:, j] = k
        reach.gain[:, j] = np.maximum(reach.gain[:, j], np.abs(k).max(axis=0))
        reach.variance[j] = max(reach.variance[j], s[there].max())
        reach.least_variance[j] = min(reach.least_variance[j], s[there].min())
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
    """Largest |mean| of each state and |innovation| of each measurement: of one component after the other, and of all
    at once where the constant gain takes them; stays: |mean| at most after a gap that was not declared"""

    x: np.ndarray
    y: np.ndarray
    settled: np.ndarray
    stays: np.ndarray


@dataclass
class Inputs:
    """What a filter is given at most: measurements, controls"""

    z: np.ndarray
    u: np.ndarray


def means_of(of: Numbers, state: Settled, reach: Reach, gap: Gap, x: Sequence[float], z: Sequence[float],
             u: Sequence[float]) -> Means:
    """By the L1 norm of the closed loop's impulse response, over the ways of missing samples: for the worst
    measurements and controls within their ranges.  x: ranges of states, infinite where there is none"""
    d, given = of.doubles(), Inputs(np.array(z, float), np.array(u, float))
    ever = Ever.of(d, state.gain.astype(float), given)
    means = Means(np.abs(d.x0), np.zeros(of.m), np.zeros(of.m), np.minimum(x, ever.steady))
    box = np.maximum(ever.steady * ROOM, _started(d, reach, given, means, ever))
    box = np.maximum(box, _from_where_it_stays(d, reach, gap, given, means, ever))
    for _ in range(100):  # what filters come to, one gap after the other
        span, ends = Span(np.eye(of.n)[None], np.zeros((1, of.n, 0)), box, False), box
        for ways in reach.settled:
            ends = np.maximum(ends, ever.bound(_follow(d, span, ways, given, means), means))
        if np.all(ends <= box):
            return Means(np.maximum(means.x, box) * ROOM, means.y * ROOM, means.settled * ROOM, means.stays)
        box = np.maximum(box, ends) * 1.001
    return Means(*(np.full(size, np.inf) for size in (of.n, of.m, of.m, of.n)))


def _started(d: Numbers, reach: Reach, given: Inputs, means: Means, ever: Ever) -> np.ndarray:
    """The bound where filters have settled for the first time, after a gap at any row or none; of a constant gain from
    the start."""
    n = len(d.A)
    span = Span(np.eye(n)[None], np.zeros((1, n, 0)), d.x0, True)
    if not reach.started:
        return np.maximum(np.abs(d.x0), ever.bound(_taken(d, span, reach.begun, 0, given, means), means))
    ends = np.zeros(n)
    for row, ways in enumerate(reach.started):
        ends = np.maximum(ends, ever.bound(_follow(d, span, ways, given, means), means))
        if row < reach.begun.gains.shape[1]:
            if row:
                span = _advanced(d, span, given, means)
            span = _taken(d, span, reach.begun, row, given, means)
    return ends


def _from_where_it_stays(d: Numbers, reach: Reach, gap: Gap, given: Inputs, means: Means, ever: Ever) -> np.ndarray:
    """The bound where filters have settled after a gap that was not declared: where the longest declared one ends, from
    any mean within the box that it stays in"""
    ends, n = np.zeros(len(d.A)), len(d.A)
    box = Span(np.eye(n)[None], np.zeros((1, n, 0)), means.stays, False)
    longest = -gap.count_of(len(d.H), gap.longest)
    begun = [(ways, gap.longest) for ways in (*reach.started, *reach.settled)] if reach.started else [(reach.begun, 0)]
    for ways, first in begun:
        gaps = Ways(ways.gains[longest:], ways.measured[longest:], ways.constant[longest:])
        span = _taken(d, box.repeated(len(gaps.gains)), gaps, first, given, means)
        ends = np.maximum(ends, ever.bound(_follow(d, span, gaps, given, means, first + 1), means))
    return ends


@dataclass
class Ever:
    """A filter of constant gain for ever after: what is left of a mean after each row, and the worst that is added.

    left   rows x (2 n + m) x n: of the states, of the states before a sample, of the innovations
    added  rows x (2 n + m)
    """

    left: np.ndarray
    added: np.ndarray

    @staticmethod
    def of(d: Numbers, K: np.ndarray, given: Inputs) -> Ever:
        """Until what was there at first has faded; what comes later is less than ROOM has left."""
        n, m = len(d.A), len(d.H)
        change = np.eye(n) - K @ d.H
        ahead = np.concatenate([np.eye(n), d.A, -d.H @ d.A])
        push = d.B * given.u
        at_once = np.concatenate([np.zeros(n), np.abs(push).sum(axis=1), given.z + np.abs(d.H @ push).sum(axis=1)])
        power, term = np.eye(n), np.concatenate([K * given.z, change @ push], axis=1)
        total, start, left, added = np.zeros(2 * n + m), np.zeros(n), [], []
        for _ in range(100_000):
            left.append(ahead @ power)
            added.append(total + at_once)
            total = total + np.abs(ahead @ term).sum(axis=1)
            power, term = change @ d.A @ power, change @ d.A @ term
            start = np.maximum(start, np.abs(power) @ np.abs(d.x0))
            scale = np.maximum(total[:n], start)
            if np.all(np.abs(power) @ scale <= FADED * scale) and np.all(np.abs(term).sum(axis=1) <= FADED * scale):
                return Ever(np.array(left), np.array([*added[:-1], total + at_once]))
        return Ever(np.array(left), np.full((len(left), 2 * n + m), np.inf))

    @property
    def steady(self) -> np.ndarray:
        """Of the states of a filter that has been settled for ever"""
        return self.added[-1][:self.left.shape[2]]

    def bound(self, span: Span, means: Means) -> np.ndarray:
        """Of the states of these filters from now on; widens means by what is met."""
        n, most = self.left.shape[2], np.zeros(self.left.shape[1])
        for turned, columns in zip(span.turned, span.columns):
            own = (turned @ span.box)[:, None] if span.is_point else turned * span.box
            left = np.abs(self.left @ np.concatenate([own, columns], axis=1)).sum(axis=2)
            most = np.maximum(most, (left + self.added).max(axis=0))
        means.x = np.maximum(means.x, np.maximum(most[:n], most[n:2 * n]))
        means.settled = np.maximum(means.settled, most[2 * n:])
        return most[:n]


def _follow(d: Numbers, span: Span, ways: Ways, given: Inputs, means: Means, first: int = 0) -> Span:
    """Where the ways end, from a row; widens means by all that is met on them."""
    span = span.repeated(len(ways.gains)) if len(span.turned) == 1 else span
    for row in range(first, ways.gains.shape[1]):
        span = _taken(d, _advanced(d, span, given, means), ways, row, given, means)
    return span


def _advanced(d: Numbers, span: Span, given: Inputs, means: Means) -> Span:
    span = span.moved(d.A, d.B * given.u)
    means.x = np.maximum(means.x, span.bound().max(axis=0))
    return span


def _taken(d: Numbers, span: Span, ways: Ways, row: int, given: Inputs, means: Means) -> Span:
    """One component after the other; by the constant gain all of them at once come to the same."""
    if np.any(ways.constant[:, row]):
        at_once = span.bound(d.H)[ways.constant[:, row]].max(axis=0)
        means.settled = np.maximum(means.settled, given.z + at_once)
    for j, h in enumerate(d.H):
        there = ways.measured[:, row, j]
        if not np.any(there):
            continue
        means.y[j] = max(means.y[j], given.z[j] + span.bound(h[None])[there].max())
        k = ways.gains[:, row, j]
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


def rows_to_forget(of: Numbers, state: Settled, max_gap: int, most: int) -> int:
    """Measured rows after which the mean of a filter of constant gain is within FADED sigma of the optimal one's, from
    the start and from a gap: by the covariance of what is between them, which each gain's difference adds to."""
    d, K = of.doubles(), state.gain.astype(float)
    P = state.filtered.astype(float)
    starts = [d.P0]
    for _ in range(max_gap):
        P = d.A @ P @ d.A.T + d.Q
    starts += [d.A @ P @ d.A.T + d.Q] if max_gap else []
    return max(_rows_to_forget(d, K, state, P, most) for P in starts)


def _rows_to_forget(d: Numbers, K: np.ndarray, state: Settled, P: np.ndarray, most: int) -> int:
    """P: before the first row"""
    closed, between = np.eye(len(P)) - K @ d.H, np.zeros_like(P)
    near = FADED**2 * np.diag(state.filtered.astype(float))
    for row in range(1, most + 1):
        S = d.H @ P @ d.H.T + np.diag(d.R)
        gain = np.linalg.solve(S, d.H @ P).T
        between = closed @ between @ closed.T + (gain - K) @ S @ (gain - K).T
        if np.all(np.diag(between) <= near):
            return row
        left = np.eye(len(P)) - gain @ d.H
        P = d.A @ (left @ P @ left.T + gain * d.R @ gain.T) @ d.A.T + d.Q
        between = d.A @ between @ d.A.T
    raise KalmanqError(f"--lag: a constant gain takes more than {most} rows to forget how it began: leave out "
                       "--form gain")


def _loss(d: Numbers, K: np.ndarray, P: np.ndarray, gap: int, rows: int, measured_first: bool = False) -> float:
    kept, best, worst = P, P, 1.0
    change = np.eye(len(P)) - K @ d.H
    m = len(d.H)
    nobody = Reach(np.zeros(len(P)), np.zeros(m), np.zeros(K.shape), np.zeros(m), np.full(m, np.inf),
                   Ways(np.zeros((1, 0, *d.H.shape)), np.zeros((1, 0, m), bool), np.zeros((1, 0), bool)))
    for row in range(gap + rows):
        if row or not measured_first:
            kept, best = (d.A @ one @ d.A.T + d.Q for one in (kept, best))
        if row >= gap:
            kept = change @ kept @ change.T + K * d.R @ K.T
            best = updated(d, best[None], np.ones((1, m), bool), nobody)[0][0]
            known = np.diag(best) > 0
            worst = max(worst, np.sqrt(np.max(np.diag(kept)[known] / np.diag(best)[known], initial=1.0)))
    return float(worst)
