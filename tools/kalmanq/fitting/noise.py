"""Where a model has process noise."""

from __future__ import annotations

from typing import Optional

import numpy as np

SINGULAR = 1e-10  # an eigenvalue of the correlations, from where a covariance is definite


class Noise:
    """Q = F Q' F' with Q' positive definite: F = I where Q is (None), otherwise the model's G, the states that have
    noise, or the directions that have.  `axes`: the states of Q', where it is of states."""

    def __init__(self, Q: np.ndarray, G: Optional[np.ndarray] = None):
        self.F: Optional[np.ndarray] = None
        self.axes: Optional[np.ndarray] = np.flatnonzero(np.diag(Q) > 0)
        n = len(Q)
        if not len(self.axes):
            self.inner = Q
        elif is_definite(Q[np.ix_(self.axes, self.axes)]):
            self.inner = Q[np.ix_(self.axes, self.axes)]
            self.F = None if len(self.axes) == n else np.eye(n)[:, self.axes]
        elif G is not None:
            self.F, self.axes = G[:, np.any(G != 0, axis=0)], None
            self.inner = np.eye(self.F.shape[1])
        else:
            deviation = np.sqrt(np.diag(Q))
            unit = np.where(deviation > 0, deviation, 1.0)  # of correlations: a noise that is small beside the others is one
            values, vectors = np.linalg.eigh(Q / np.outer(unit, unit))
            there = values > 1e-12 * values[-1]
            self.F, self.axes, self.inner = unit[:, None] * vectors[:, there], None, np.diag(values[there])

    def whole(self, inner: np.ndarray) -> np.ndarray:
        return inner if self.F is None else self.F @ inner @ self.F.T

    def of_model(self, inner: np.ndarray) -> dict[str, np.ndarray]:
        """Q, or a G that keeps its rank."""
        if self.F is None:
            return {"Q": inner}
        return {"Q": self.whole(inner)} if self.axes is not None else {"G": self.F @ np.linalg.cholesky(inner)}


def is_definite(C: np.ndarray) -> bool:
    deviation = np.sqrt(np.diag(C))
    if not np.all(deviation > 0):
        return False
    return bool(np.linalg.eigvalsh(C / np.outer(deviation, deviation))[0] > SINGULAR)
