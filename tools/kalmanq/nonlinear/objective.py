"""What a smoothed run is measured by: twice the negative logarithm of its density, but for a constant."""

from __future__ import annotations

import numpy as np

from kalmanq.nonlinear.model import NonlinearModel

SINGULAR = 1e-12  # of the largest eigenvalue of a correlation matrix: no noise in that direction


class Noise:
    """A covariance that may be singular."""

    def __init__(self, covariance: np.ndarray):
        sigma = np.sqrt(np.diag(covariance))
        self.unit = np.where(sigma > 0, sigma, 1.0)
        values, vectors = np.linalg.eigh(covariance / np.outer(self.unit, self.unit))
        there = values > SINGULAR * max(values[-1], 0.0)
        self.vectors, self.values = vectors[:, there], values[there]

    def split(self, w: np.ndarray) -> tuple[np.ndarray, float]:
        """The part of w that this noise can be, and w' Q^-1 w of it"""
        along = self.vectors.T @ (w / self.unit)
        return self.unit * (self.vectors @ along), float(np.sum(along**2 / self.values))


def objective(model: NonlinearModel, states: np.ndarray, z: np.ndarray, u: np.ndarray) -> float:
    """sum e' R^-1 e + sum w' Q^-1 w + (x0's), at the run nearest to `states` that the noises can make.

    Where Q is singular, smoothed states of a linearised model are not exactly a run of the nonlinear one: each step's
    noise is the part of what is needed that Q has, and the run is what comes of it.
    """
    P0, Q = Noise(model.P0), Noise(model.Q)
    moved, sum_ = P0.split(states[0] - model.x0)
    x = model.x0 + moved
    for t in range(len(states)):
        if t:
            f = model.moved(x, t - 1, u[t - 1])
            w, cost = Q.split(states[t] - f)
            x, sum_ = f + w, sum_ + cost
        there = ~np.isnan(z[t])
        if np.any(there):
            e = model.innovation(z[t], x, t, u[t])[there]
            sum_ += float(e @ np.linalg.pinv(model.R[np.ix_(there, there)], hermitian=True) @ e)
    return sum_
