"""What a smoothed run is measured by: twice the negative logarithm of its density, but for a constant."""

from __future__ import annotations

from typing import Any, Mapping, Optional, Sequence

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


def objective(model: NonlinearModel, states: np.ndarray, z: np.ndarray, u: np.ndarray, at: Sequence[float],
              noises: Mapping[tuple[str, int, int], Any]) -> float:
    """sum e' R^-1 e + sum w' Q^-1 w + (x0's), at the run nearest to `states` that the noises can make.

    Where Q is singular, smoothed states of a linearised model are not exactly a run of the nonlinear one: each step's
    noise is the part of what is needed that Q has, and the run is what comes of it.
    at: t of each row; noises: Q or G, and R, of a row and the first number of a sensor, where they are functions
    """
    P0, Q = Noise(model.P0), None if model.Q is None else Noise(model.Q)
    moved, sum_ = P0.split(states[0] - model.x0)
    x = model.x0 + moved
    for t in range(len(states)):
        if t:
            f = model.moved(x, at[t - 1], u[t - 1])
            w, cost = (Q or Noise(_covariance(noises["Q", t - 1, 0]))).split(states[t] - f)
            x, sum_ = f + w, sum_ + cost
        if not np.all(np.isnan(z[t])):
            e = model.innovation(z[t], x, at[t], u[t])
            sum_ += sum(_of_sensor(z[t], e, one.rows, model.R if model.R is not None else noises.get(("R", t, one.first)))
                        for one in model.sensors)
    return sum_


def _of_sensor(z: np.ndarray, e: np.ndarray, own: slice, R: Optional[np.ndarray]) -> float:
    """e' R^-1 e of its numbers that are there"""
    there = np.flatnonzero(~np.isnan(z[own])) + own.start
    return float(e[there] @ np.linalg.pinv(R[np.ix_(there, there)], hermitian=True) @ e[there]) if len(there) else 0.0


def _covariance(noise: Mapping[str, np.ndarray]) -> np.ndarray:
    return noise["Q"] if "Q" in noise else noise["G"] @ noise["G"].T
