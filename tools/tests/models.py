"""Models and data that several tests share, and the textbook's filter and smoother beside them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from library import saved

import kalmanq
from kalmanq import Quantity
from kalmanq.model import model_file

DT = 0.5
# A file of a sensor that is late
LATE = """
[model]
A = [[0.98, 0.05], [0.0, 0.9]]
B = [0.1, 0.0]
Q = [0.01, 0.02]
P0 = [4.0, 1.0]
[states]
names = ["a", "b"]
ranges = [100, 50]
[controls]
names = ["push"]
ranges = [10]
[[sensors]]
name = "quick"
H = [1.0, 0.0]
R = 0.25
ranges = [100]
[[sensors]]
name = "late"
H = [1.0, 1.0]
R = 0.1
ranges = [100]
delay = 3
"""


def file_of(model: kalmanq.Model, folder: Path) -> Path:
    return saved(folder / "model.toml", model_file.text_of(model))


def cart() -> kalmanq.Model:
    """Position and velocity, pushed by a control."""
    return kalmanq.Model(
        [[1, DT], [0, 1]], H=[1, 0], R=4.0, G=[0.3 * DT**2 / 2, 0.3 * DT], B=[0, DT], P0=[100, 10],
        states=[Quantity("position", "m", 5000), Quantity("velocity", "m/s", 200)],
        measurements=[Quantity("range", "m", 5000)], controls=[Quantity("push", "m/s2", 10)])


def pair() -> kalmanq.Model:
    """Two correlated components of three states, of which one is not measured by itself."""
    return kalmanq.Model(
        [[0.9, 0.2, 0], [0, 0.95, 0.1], [0.05, 0, 0.8]], H=[[1, 0, 0.5], [0, 1, 0]], R=[[1, 0.4], [0.4, 2]],
        Q=np.diag([0.1, 0.2, 0.05]), x0=[1, -1, 0], P0=np.diag([4.0, 4, 1]),
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


def updated(x: np.ndarray, P: np.ndarray, e: np.ndarray, H: np.ndarray, R: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
    """Mean, covariance (in Joseph's form) and term of the log-likelihood of an innovation; NaN: a component is missing"""
    there = ~np.isnan(e)
    if not np.any(there):
        return x, P, 0.0
    e, H, R = e[there], H[there], R[np.ix_(there, there)]
    S = H @ P @ H.T + R
    K = np.linalg.solve(S, H @ P).T
    left = np.eye(len(P)) - K @ H
    term = -(e @ np.linalg.solve(S, e) + np.linalg.slogdet(2 * np.pi * S)[1]) / 2
    return x + K @ e, left @ P @ left.T + K @ R @ K.T, float(term)


def varied(of: dict[str, np.ndarray], x: np.ndarray, P: np.ndarray, z: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, ...]:
    """Of each row: mean, covariance, both before its measurement, and its term of the log-likelihood; `of` has arrays of T
    matrices A, B, Q (of the step to the next row), H, R, D and of T vectors d"""
    made = []
    for t in range(len(z)):
        if t:
            x, P = of["A"][t - 1] @ x + of["B"][t - 1] @ u[t - 1], of["A"][t - 1] @ P @ of["A"][t - 1].T + of["Q"][t - 1]
        before = x, P
        x, P, term = updated(x, P, z[t] - of["H"][t] @ x - of["D"][t] @ u[t] - of["d"][t], of["H"][t], of["R"][t])
        made.append((x, P, *before, term))
    return tuple(map(np.array, zip(*made)))


def filtered(model: kalmanq.Model, z: np.ndarray, u: np.ndarray | None) -> tuple[np.ndarray, ...]:
    """The same of a model, whose matrices are the same in all rows"""
    T, n, m, l = len(z), model.n, model.m, 0 if u is None else model.l
    given = {name: getattr(model, name) for name in "AQHR"} | {"B": model.B if l else np.zeros((n, 0)), "D": np.zeros((m, l)), "d": np.zeros(m)}
    of = {name: np.broadcast_to(one, (T, *one.shape)) for name, one in given.items()}
    return varied(of, model.x0, model.P0, z, np.zeros((T, 0)) if u is None else u)


def textbook(model: kalmanq.Model, z: np.ndarray, u: np.ndarray | None) -> dict[str, np.ndarray]:
    """Means, covariances and log-likelihood terms, filtered; means and covariances, smoothed."""
    mean, full, x, P, terms = filtered(model, z, u)
    smoothed, smoothed_full = [mean[-1]], [full[-1]]
    for t in range(len(z) - 2, -1, -1):
        C = np.linalg.solve(P[t + 1], model.A @ full[t]).T
        smoothed.insert(0, mean[t] + C @ (smoothed[0] - x[t + 1]))
        smoothed_full.insert(0, full[t] + C @ (smoothed_full[0] - P[t + 1]) @ C.T)
    return {name: np.array(of) for name, of in (
        ("mean", mean), ("covariance", full), ("log_likelihood", terms), ("smoothed", smoothed),
        ("smoothed_covariance", smoothed_full))}


def moved(model: kalmanq.Model, x: np.ndarray, u: np.ndarray | None, t: int) -> np.ndarray:
    """The mean from row t - 1 to row t"""
    return model.A @ x + (0 if u is None else model.B @ u[t - 1])


def innovation(model: kalmanq.Model, x: np.ndarray, P: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, ...]:
    """Of the components that are there: e, S, K"""
    there = ~np.isnan(z)
    H = model.H[there]
    S = H @ P @ H.T + model.R[np.ix_(there, there)]
    return z[there] - H @ x, S, np.linalg.solve(S, H @ P).T


def gated(model: kalmanq.Model, z: np.ndarray, u: np.ndarray | None, limits: np.ndarray) -> tuple[np.ndarray, ...]:
    """Means and sigmas where what is above limits[components there - 1] is not taken, and which rows were not"""
    x, P, mean, sigma, rejected = model.x0, model.P0, [], [], []
    for t in range(len(z)):
        if t:
            x, P = moved(model, x, u, t), model.A @ P @ model.A.T + model.Q
        rejected.append(False)
        if np.any(~np.isnan(z[t])):
            e, S, K = innovation(model, x, P, z[t])
            rejected[-1] = bool(e @ np.linalg.solve(S, e) >= limits[len(e) - 1])
            if not rejected[-1]:
                x, P = x + K @ e, P - K @ S @ K.T
        mean.append(x), sigma.append(np.sqrt(np.diag(P)))
    return np.array(mean), np.array(sigma), np.array(rejected)


def settling(model: kalmanq.Model, z: np.ndarray, u: np.ndarray | None, settled: np.ndarray) -> dict[str, np.ndarray]:
    """A filter that moves its mean alone, by the gain of the last full row, in the rows that are `settled`"""
    x, P, K = model.x0, model.P0, np.zeros((model.n, model.m))
    made: dict[str, list] = {"mean": [], "sigma": [], "innovation": [], "innovation_sigma": []}
    for t in range(len(z)):
        before = P
        if t:
            x, P = moved(model, x, u, t), model.A @ P @ model.A.T + model.Q
        e, spread = np.full(model.m, np.nan), np.sqrt(np.diag(model.H @ P @ model.H.T + model.R))
        there = ~np.isnan(z[t])
        if np.any(there):
            e[there], S, now = innovation(model, x, P, z[t])
            if settled[t]:
                x, P = x + K @ e, before
            else:
                x, P, K = x + now @ e[there], P - now @ S @ now.T, now
        for name, value in zip(made, (x, np.sqrt(np.diag(P)), e, spread)):
            made[name].append(value)
    return {name: np.array(of) for name, of in made.items()}


def least_squares(H: np.ndarray, z: np.ndarray, r: np.ndarray, x0: np.ndarray, P0: np.ndarray,
                  forgetting: float) -> tuple[np.ndarray, np.ndarray, float, float]:
    """By the normal equations: x, its covariance, the minimum, the sum of weights"""
    weights = forgetting ** np.arange(len(z) - 1, -1, -1.0)
    prior = np.linalg.inv(P0) * forgetting ** len(z)
    P = np.linalg.inv(H.T @ (H * (weights / r)[:, None]) + prior)
    x = P @ (H.T @ (z * weights / r) + prior @ x0)
    residual = np.sum(weights / r * (z - H @ x) ** 2) + (x - x0) @ prior @ (x - x0)
    return x, P, float(residual), float(np.sum(weights))
