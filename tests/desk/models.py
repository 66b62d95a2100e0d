"""Models and data that several tests share, and the textbook's filter and smoother beside them."""

from __future__ import annotations

import numpy as np

import kalmanq
from kalmanq import Quantity

DT = 0.5


def cart() -> kalmanq.Model:
    """Position and velocity, pushed by a control."""
    return kalmanq.Model(
        [[1, DT], [0, 1]], [1, 0], 4.0, G=[0.3 * DT**2 / 2, 0.3 * DT], B=[0, DT], P0=[100, 10],
        states=[Quantity("position", "m", 5000), Quantity("velocity", "m/s", 200)],
        measurements=[Quantity("range", "m", 5000)], controls=[Quantity("push", "m/s2", 10)])


def pair() -> kalmanq.Model:
    """Two correlated components of three states, of which one is not measured by itself."""
    return kalmanq.Model(
        [[0.9, 0.2, 0], [0, 0.95, 0.1], [0.05, 0, 0.8]], [[1, 0, 0.5], [0, 1, 0]], [[1, 0.4], [0.4, 2]],
        np.diag([0.1, 0.2, 0.05]), x0=[1, -1, 0], P0=np.diag([4.0, 4, 1]),
        states=[Quantity(name, "", 64) for name in "abc"],
        measurements=[Quantity("first", "", 256), Quantity("second", "", 256)])


def data(model: kalmanq.Model, rows: int, seed: int) -> tuple[np.ndarray, np.ndarray | None]:
    """Measurements with some of them missing, and controls"""
    draw = np.random.default_rng(seed)
    u = draw.normal(size=(rows, model.l)) if model.l else None
    noise = np.linalg.cholesky(model.Q + 1e-15 * np.eye(model.n))
    error, x = np.linalg.cholesky(model.R), model.x0.copy()
    z = np.empty((rows, model.m))
    for t in range(rows):
        if t:
            x = model.A @ x + noise @ draw.normal(size=model.n)
            x += 0 if u is None else model.B @ u[t - 1]
        z[t] = model.H @ x + error @ draw.normal(size=model.m)
    z[draw.random(z.shape) < 0.1] = np.nan
    z[rows // 2 : rows // 2 + 6] = np.nan
    return z, u


def textbook(model: kalmanq.Model, z: np.ndarray, u: np.ndarray | None) -> dict[str, np.ndarray]:
    """Means, covariances and log-likelihood terms, filtered; means and covariances, smoothed."""
    A, Q = model.A, model.Q
    x, P = model.x0, model.P0
    mean, full, before, terms = [], [], [], []
    for t in range(len(z)):
        if t:
            x = A @ x + (0 if u is None else model.B @ u[t - 1])
            P = A @ P @ A.T + Q
        before.append((x, P))
        there = ~np.isnan(z[t])
        H, R, term = model.H[there], model.R[np.ix_(there, there)], 0.0
        if np.any(there):
            S, e = H @ P @ H.T + R, z[t][there] - H @ x
            K = np.linalg.solve(S, H @ P).T
            x, P = x + K @ e, P - K @ S @ K.T
            term = -0.5 * (np.log(np.linalg.det(2 * np.pi * S)) + e @ np.linalg.solve(S, e))
        mean.append(x), full.append(P), terms.append(term)
    smoothed, smoothed_full = [mean[-1]], [full[-1]]
    for t in range(len(z) - 2, -1, -1):
        C = np.linalg.solve(before[t + 1][1], A @ full[t]).T
        smoothed.insert(0, mean[t] + C @ (smoothed[0] - before[t + 1][0]))
        smoothed_full.insert(0, full[t] + C @ (smoothed_full[0] - before[t + 1][1]) @ C.T)
    return {name: np.array(of) for name, of in (
        ("mean", mean), ("covariance", full), ("log_likelihood", terms), ("smoothed", smoothed),
        ("smoothed_covariance", smoothed_full))}
