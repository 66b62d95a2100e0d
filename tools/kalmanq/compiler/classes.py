"""What covariances, gains and means can be where samples are missing as declared: bounds for fixed point.

Doubles, for decisions that leave a hundredth of room; what comes of them is proven by the search (search.py).  A gap
begins at any sample after the start, or once the covariance has settled again.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Iterator, Optional, Sequence

import numpy as np

from kalmanq.compiler.exact import Numbers, Settled

ROOM = 1.01


@dataclass(frozen=True)
class Doubles:
    """The same numbers as arrays of float64."""

    A: np.ndarray
    B: np.ndarray
    H: np.ndarray
    Q: np.ndarray
    R: np.ndarray
    x0: np.ndarray
    P0: np.ndarray

    @staticmethod
    def of(numbers: Numbers) -> Doubles:
        names = ("A", "B", "H", "Q", "R", "x0", "P0")
        return Doubles(*(getattr(numbers, name).astype(float) for name in names))


Taken = tuple[np.ndarray, list[int]]  # a gain n x r, and the components that it is of
Row = list[Taken]


@dataclass
class Reach:
    """Largest of each sigma (states, rows of H x), gain n x m, variance of an innovation; the least variance, too"""

    sigma: np.ndarray
    row_sigma: np.ndarray
    gain: np.ndarray
    variance: np.ndarray
    least_variance: np.ndarray
    patterns: list[tuple[Optional[list[Row]], list[Row]]] = field(default_factory=list)


def rows(d: Doubles, P: np.ndarray, missing: int, measured: int, reach: Reach) -> Iterator[tuple[np.ndarray, Row]]:
    """Of each row: the covariance after it, and the gains of its components; none where it is missing"""
    for row in range(missing + measured):
        P = d.A @ P @ d.A.T + d.Q
        _wider(d, P, reach)
        gains: Row = []
        if row >= missing:
            P, gains = update(d, P, reach)
        yield P, gains


def _wider(d: Doubles, P: np.ndarray, reach: Reach) -> None:
    reach.sigma = np.maximum(reach.sigma, np.sqrt(np.maximum(np.diag(P), 0)))
    reach.row_sigma = np.maximum(reach.row_sigma, np.sqrt(np.maximum(np.einsum("ji,ik,jk->j", d.H, P, d.H), 0)))


def update(d: Doubles, P: np.ndarray, reach: Reach) -> tuple[np.ndarray, Row]:
    gains: Row = []
    for j in range(len(d.H)):
        row = P @ d.H[j]
        s = d.H[j] @ row + d.R[j]
        k = row / s
        reach.gain[:, j] = np.maximum(reach.gain[:, j], np.abs(k))
        reach.variance[j], reach.least_variance[j] = max(reach.variance[j], s), min(reach.least_variance[j], s)
        P = P - np.outer(k, row)
        P = (P + P.T) / 2
        gains.append((k[:, None], [j]))
    return P, gains


def reach_of(of: Numbers, state: Settled, settling: int, max_gap: int) -> Reach:
    """patterns: of each way the rows before a gap (None: settled for long), and those after, for means_of"""
    d, n, m = Doubles.of(of), of.n, of.m
    reach = Reach(np.zeros(n), np.zeros(m), np.abs(state.gain.astype(float)), np.zeros(m), np.full(m, np.inf))
    _wider(d, d.P0, reach)
    P, gains = update(d, d.P0, reach)
    begun, covariances = [gains], [P]
    for P, gains in rows(d, P, 0, settling, reach):
        begun.append(gains), covariances.append(P)
    before: list[tuple[Optional[list[Row]], np.ndarray]] = [([[]], d.P0)]
    before += [(begun[:k + 1], P) for k, P in enumerate(covariances)]
    for history, P in [*before, (None, state.filtered.astype(float))]:
        for gap in range(0 if history is None else 1, max_gap + 1):
            after = [gains for _, gains in rows(d, P, gap, settling, reach)]
            reach.patterns.append((history, after))
    return reach


# ------------------------------------------------------------------------------ means


@dataclass
class Span:
    """A set of means: x = turned start + sum of columns times numbers of -1 to 1.  start: a box, or one point"""

    turned: np.ndarray
    columns: np.ndarray

    def bound(self, box: np.ndarray, is_point: bool) -> np.ndarray:
        own = np.abs(self.turned @ box) if is_point else np.abs(self.turned) @ box
        return own + np.abs(self.columns).sum(axis=1)

    def moved(self, A: np.ndarray, new: np.ndarray) -> Span:
        return Span(A @ self.turned, np.concatenate([A @ self.columns, new], axis=1))


@dataclass
class Means:
    """Largest |mean| of each state and |innovation| of each measurement"""

    x: np.ndarray
    y: np.ndarray


def means_of(of: Numbers, state: Settled, reach: Reach, z: Sequence[float], u: Sequence[float], settling: int) -> Means:
    """By the L1 norm of the closed loop's impulse response, over the patterns of missing samples: for the worst
    measurements and controls within their ranges."""
    d, n, m = Doubles.of(of), of.n, of.m
    z, u = np.array(z, float), np.array(u, float)
    means = Means(np.abs(d.x0), np.zeros(m))
    settled = _settled_rows(state, 2 * settling)
    box = _steady_box(d, state, z, u)
    for history, after in reach.patterns:
        if history is not None:
            _follow(d, [*history, *after, *settled], np.eye(n), d.x0, True, z, u, means, first=True)
    for _ in range(100):  # what settled filters come to, one gap after the other
        ends = [_follow(d, [*after, *settled], np.eye(n), box, False, z, u, means)
                for history, after in reach.patterns if history is None]
        wider = np.maximum.reduce([box, *ends])
        if np.all(wider <= box * 1.0001):
            return Means(np.maximum(means.x, wider) * ROOM, means.y * ROOM)
        box = wider * 1.0001
    return Means(np.full(n, np.inf), np.full(m, np.inf))


def _settled_rows(state: Settled, count: int) -> list[Row]:
    gain = state.gain.astype(float)
    return [[(gain, list(range(gain.shape[1])))]] * count


def _steady_box(d: Doubles, state: Settled, z: np.ndarray, u: np.ndarray) -> np.ndarray:
    """Of a filter that has been settled for ever"""
    K = state.gain.astype(float)
    closed = (np.eye(len(d.A)) - K @ d.H) @ d.A
    inputs = np.concatenate([K * z, (np.eye(len(d.A)) - K @ d.H) @ d.B * u], axis=1)
    total, term = np.zeros(len(d.A)), inputs
    for _ in range(100_000):
        total += np.abs(term).sum(axis=1)
        term = closed @ term
        if np.abs(term).sum() < 1e-9 * total.max():
            return total * ROOM
    return np.full(len(d.A), np.inf)


def _see(d: Doubles, span: Span, box: np.ndarray, is_point: bool, z: np.ndarray, means: Means,
         taken: Sequence[int]) -> None:
    seen = Span(d.H @ span.turned, d.H @ span.columns).bound(box, is_point)
    for j in taken:
        means.y[j] = max(means.y[j], z[j] + seen[j])


def _follow(d: Doubles, gains: Sequence[Row], turned: np.ndarray, box: np.ndarray, is_point: bool,
            z: np.ndarray, u: np.ndarray, means: Means, first: bool = False) -> np.ndarray:
    """Widens means by all that is met on a way; answers the bound at its end.  first: its first row is no step"""
    span = Span(turned, np.zeros((len(turned), 0)))
    for t, row in enumerate(gains):
        if not (first and t == 0):
            span = span.moved(d.A, d.B * u)
            means.x = np.maximum(means.x, span.bound(box, is_point))
        for k, taken in row:
            _see(d, span, box, is_point, z, means, taken)
            span = span.moved(np.eye(len(k)) - k @ d.H[taken], k * z[taken])
            means.x = np.maximum(means.x, span.bound(box, is_point))
    return span.bound(box, is_point)
