"""The textbook Kalman filter and Rauch-Tung-Striebel smoother in double precision: what the table
compares the library with.  Written from the formulas, and sharing no code with it.

    predict   x- = A x                  P- = A P A' + Q
    update    e  = z - H x-             S  = H P- H' + R
              K  = P- H' S^-1           x  = x- + K e          P = P- - K S K'
    smooth    G  = P A' (P-_{t+1})^-1
              x_t|T = x + G (x_t+1|T - x-_{t+1})
              P_t|T = P + G (P_t+1|T - P-_{t+1}) G'

Both covariances are computed in Joseph's form, a sum of positive terms instead of a difference:
P = (I - K H) P- (I - K H)' + K R K', and likewise for the smoother.  A wide prior would cost the
difference so many digits that the table showed the reference's errors, not the library's.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from estimates import Band, Estimates
from jobs import Model


@dataclass
class Gaussian:
    """A mean x and its covariance P."""

    x: np.ndarray
    P: np.ndarray


def run(model: Model, z: np.ndarray, ahead: int) -> Estimates:
    """Filters, smooths and forecasts T x m measurements, NaN where one is missing."""
    predicted, filtered, log_likelihood = run_filter(model, z)
    future = run_forecast(model, filtered[-1], ahead)
    return Estimates(
        filtered=band(filtered, len(model.x0)),
        smoothed=band(run_smoother(model, predicted, filtered), len(model.x0)),
        forecast=band(future, len(model.x0)),
        forecast_z=band([measurement(model, state) for state in future], len(model.H)),
        log_likelihood=log_likelihood,
    )


def run_filter(model: Model, z: np.ndarray) -> tuple[list[Gaussian], list[Gaussian], float]:
    """The states before and after each measurement, and the log-likelihood."""
    predicted, filtered, log_likelihood = [], [], 0.0
    state = Gaussian(model.x0, model.P0)
    for row in z:
        predicted.append(state)
        state, term = update(model, state, row)
        filtered.append(state)
        log_likelihood += term
        state = predict(model, state)
    return predicted, filtered, log_likelihood


def predict(model: Model, state: Gaussian) -> Gaussian:
    P = model.A @ state.P @ model.A.T + model.Q
    return Gaussian(model.A @ state.x, (P + P.T) / 2)


def update(model: Model, state: Gaussian, z: np.ndarray) -> tuple[Gaussian, float]:
    """The state given the components of z that are there, and their log-likelihood."""
    there = ~np.isnan(z)
    if not there.any():
        return state, 0.0
    H = model.H[there]
    e = z[there] - H @ state.x
    S = H @ state.P @ H.T + model.R[np.ix_(there, there)]
    K = np.linalg.solve(S, H @ state.P).T
    P = joseph(K, H, state.P, model.R[np.ix_(there, there)])
    _, log_determinant = np.linalg.slogdet(S)
    term = -(len(e) * math.log(2 * math.pi) + log_determinant + e @ np.linalg.solve(S, e)) / 2
    return Gaussian(state.x + K @ e, P), float(term)


def joseph(K: np.ndarray, H: np.ndarray, P: np.ndarray, R: np.ndarray) -> np.ndarray:
    """(I - K H) P (I - K H)' + K R K', symmetric."""
    rest = np.eye(len(P)) - K @ H
    result = rest @ P @ rest.T + K @ R @ K.T
    return (result + result.T) / 2


def run_smoother(
    model: Model, predicted: list[Gaussian], filtered: list[Gaussian]
) -> list[Gaussian]:
    smoothed = [filtered[-1]]
    for now, after in zip(filtered[-2::-1], predicted[:0:-1]):
        later = smoothed[-1]
        G = np.linalg.solve(after.P, model.A @ now.P).T
        P = joseph(G, model.A, now.P, model.Q + later.P)
        smoothed.append(Gaussian(now.x + G @ (later.x - after.x), P))
    return smoothed[::-1]


def run_forecast(model: Model, state: Gaussian, ahead: int) -> list[Gaussian]:
    future = []
    for _ in range(ahead):
        state = predict(model, state)
        future.append(state)
    return future


def measurement(model: Model, state: Gaussian) -> Gaussian:
    return Gaussian(model.H @ state.x, model.H @ state.P @ model.H.T + model.R)


def band(states: list[Gaussian], width: int) -> Band:
    mean = np.array([state.x for state in states]).reshape(-1, width)
    variance = np.array([np.diag(state.P) for state in states]).reshape(-1, width)
    return Band(mean, np.sqrt(np.maximum(variance, 0.0)))
