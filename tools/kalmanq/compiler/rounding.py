"""What a float's 24 bits do to the means of f32 where states are large beside their sigmas."""

from __future__ import annotations

import numpy as np

from kalmanq.compiler.exact import Numbers, Settled
from kalmanq.model import Model

FAR = 1000  # sigma, of a state that has no range
ROUNDED = 2.0**-24  # of a float, relative
FADED = 1e-6
MOST_ROWS = 100_000


def of_means(model: Model, of: Numbers, settled: Settled) -> float:
    """How far, in sigma, a settled mean can be from that of the model with its own A, B and H: a bound (L1 norm), for
    states and controls within their ranges.

    Coefficients are rounded once, by W: an error e of a mean goes on as (I - K H) (A e + W x) - K W' x, of a constant
    W.  What changes a mean, (A - I) x, and what a row of H is expected to be are rounded at each row: the word of x,
    its products, their sums.
    """
    d, K = of.doubles(), settled.gain.astype(float)
    kept = np.eye(of.n) - K @ d.H
    sigma = np.sqrt(np.maximum(np.diag(settled.filtered.astype(float)), 0))
    states = np.array([one.range or FAR * float(value) for one, value in zip(model.states, sigma)])
    controls = np.array([one.range or 1.0 for one in model.controls])
    B = np.zeros_like(d.B) if model.B is None else model.B
    moved = ROUNDED * (3 * np.abs(d.A - np.eye(of.n)) @ states + 2 * np.abs(d.B) @ controls)
    seen = np.array([0 if _is_plain(row) else ROUNDED * 2 * np.abs(row) @ states for row in d.H])
    pushes = [(kept @ (model.A - d.A), states), (K @ (model.H - d.H), states), (kept @ (B - d.B), controls),
              (kept, moved), (K, seen)]
    total = first = sum(np.abs(push) @ most for push, most in pushes)
    for _ in range(MOST_ROWS):
        pushes = [(kept @ d.A @ push, most) for push, most in pushes]
        more = sum(np.abs(push) @ most for push, most in pushes)
        total = total + more
        if np.all(more <= FADED * first):
            break
    return float(np.max(np.divide(total, sigma, out=np.zeros_like(sigma), where=sigma > 0)))


def _is_plain(row: np.ndarray) -> bool:
    """One state as it is: nothing is rounded."""
    return np.count_nonzero(row) == 1 and np.abs(row).max() == 1
