"""What words of so many bits do to a settled mean, where states and innovations are large beside their sigmas: a bound.

A record that is tried (search.c) stays small, and does not show it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Callable

import numpy as np

from kalmanq.compiler.proven.classes import Means
from kalmanq.compiler.exact import Numbers, Settled
from kalmanq.compiler.proven.fixed import TWO, Formats, held, rounded
from kalmanq.model import Model

FAR = 1000  # sigma, of a state that has no range
ROUNDED = 2.0**-24  # of a float, relative
FADED = 1e-6
MOST_ROWS = 100_000


@dataclass(frozen=True)
class Off:
    """How far the words of A, B, H and of the settled gain are from those numbers; moved, seen: the rounding of a row,
    of each mean, of what is expected of each measurement"""

    A: np.ndarray
    B: np.ndarray
    H: np.ndarray
    gain: np.ndarray
    moved: np.ndarray
    seen: np.ndarray


@dataclass(frozen=True)
class Most:
    """States, controls and innovations at most"""

    x: np.ndarray
    u: np.ndarray
    y: np.ndarray


def of_floats(model: Model, of: Numbers, settled: Settled) -> float:
    """In sigma.  Coefficients are rounded once; what changes a mean, (A - I) x, and what a row of H is expected to be
    at each row: the word of x, its products, their sums.  So are an innovation, its gains, their products and sums."""
    d, K, sigma = of.doubles(), settled.gain.astype(float), _sigma(settled)
    states = np.array([one.range or FAR * float(value) for one, value in zip(model.states, sigma)])
    controls = np.array([one.range or 1.0 for one in model.controls])
    expected = np.abs(d.H) @ states
    y = expected + np.array([one.range or value for one, value in zip(model.measurements, expected)])
    B = np.zeros_like(d.B) if model.B is None else model.B
    moved = ROUNDED * (3 * np.abs(d.A - np.eye(of.n)) @ states + 2 * np.abs(d.B) @ controls)
    seen = np.array([0 if _is_plain(row) else ROUNDED * 2 * value for row, value in zip(d.H, expected)])
    gain = np.abs(K - K.astype(np.float32)) + ROUNDED * (3 + of.m) * np.abs(K)
    off = Off(model.A - d.A, B - d.B, model.H - d.H, gain, moved, seen)
    return _of_means(d, K, sigma, off, Most(states, controls, y))


def of_words(model: Model, of: Numbers, settled: Settled, f: Formats, means: Means) -> float:
    """In sigma, for any measurements and controls within their ranges.  Coefficients have words whose points are
    those of what they multiply and make; products are cut off at the mean's point, innovations rounded at theirs."""
    d, K, n = of.doubles(), settled.gain.astype(float), of.n

    def off(values: np.ndarray, point: Callable[[int, int], int], word: Callable = rounded) -> np.ndarray:
        made = np.zeros(values.shape)
        for (i, k), value in np.ndenumerate(values):
            scale = TWO ** point(i, k)
            made[i, k] = float(word(value * scale) / scale - value)
        return made

    units, points = 2.0 ** -np.array(f.x, float), 2.0 ** -np.array(f.rows, float)
    apart = Off(off(of.A, lambda i, k: f.x[i] - f.x[k], held), off(of.B, lambda i, k: f.x[i] - f.u[k]),
                off(of.H, lambda j, i: f.rows[j] - f.x[i], held), off(settled.gain, lambda i, j: f.x[i] - f.settled[j]),
                n * units, 2.0 ** -np.array(f.settled, float) + n * points)
    controls = np.array([one.range or 0.0 for one in model.controls])
    return _of_means(d, K, _sigma(settled), apart, Most(means.x, controls, means.settled))


def _of_means(d: Numbers, K: np.ndarray, sigma: np.ndarray, off: Off, most: Most) -> float:
    """By the closed loop's L1 norm: an error e of a mean goes on as (I - K H) (A e + dA x + dB u) + K dH x + dK y."""
    kept = np.eye(len(K)) - K @ d.H
    pushes = [(kept @ off.A, most.x), (K @ off.H, most.x), (kept @ off.B, most.u), (off.gain, most.y),
              (kept, off.moved), (K, off.seen)]
    total = first = sum(np.abs(push) @ values for push, values in pushes)
    for _ in range(MOST_ROWS):
        pushes = [(kept @ d.A @ push, values) for push, values in pushes]
        more = sum(np.abs(push) @ values for push, values in pushes)
        total = total + more
        if np.all(more <= FADED * first):
            break
    return float(np.max(np.divide(total, sigma, out=np.zeros_like(sigma), where=sigma > 0)))


def _sigma(settled: Settled) -> np.ndarray:
    return np.sqrt(np.maximum(np.diag(settled.filtered.astype(float)), 0))


def _is_plain(row: np.ndarray) -> bool:
    """One state as it is: nothing is rounded."""
    return np.count_nonzero(row) == 1 and np.abs(row).max() == 1
