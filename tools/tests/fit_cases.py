"""Models and records that fits are tried on, and figures of theirs that statsmodels has found (fit_peers.py)."""

from __future__ import annotations

from pathlib import Path

import numpy as np

# UnobservedComponents of statsmodels 0.14, the maximum by BFGS: log-likelihood, R, variances of the state noises.
NILE_EXACT = (-633.4645636, 15098.51826, 1469.176301)
NILE_ERRORS = {"R": 3145.547780, "Q": 1280.375333}  # standard errors by the exact Hessian: cov_type "approx", complex steps
NILE_KNOWN = (-641.5855783, 15099.68582, 1468.500254)
TREND_EXACT = (-324.7311124, 0.9267381707, 0.04532407608, 0.007773471204)

# `pushed` by seed and quiet row: the best of 20 random starts of SciPy's L-BFGS-B, Q = L L' with L linear, log of R
PUSHED_BEST = {
    (101, 0): -359.00149365, (103, 0): -349.69656168, (108, 1): -531.89512316, (114, 0): -364.83887920,
    (116, 0): -346.71541111, (116, 3): -496.21678705, (120, 1): -532.02838918, (128, 0): -363.12931872,
    (129, 3): -508.66055291}


def nile(examples: Path) -> np.ndarray:
    rows = np.genfromtxt(examples / "nile.csv", delimiter=",", comments="#")
    return rows[~np.isnan(rows[:, -1]), -1]


def root(C: np.ndarray) -> np.ndarray:
    """L of C = L L', by which NumPy's multivariate_normal draws, without a decomposition for each"""
    vectors, values, _ = np.linalg.svd(C)
    return vectors * np.sqrt(values)


def drawn(A, H, Q, R, T: int, seed: int, P0=None, B=None) -> tuple[np.ndarray, np.ndarray]:
    """z (T x m) and u (T x l) of a model, from a state N(0, P0)"""
    random = np.random.default_rng(seed)
    A, H, Q, R = (np.atleast_2d(np.asarray(one, float)) for one in (A, H, Q, R))
    n = len(A)
    by_Q, by_R = root(Q), root(R)
    x = random.multivariate_normal(np.zeros(n), np.eye(n) if P0 is None else P0)
    u = random.normal(size=(T, 0 if B is None else np.shape(B)[1]))
    z = np.empty((T, len(H)))
    for t in range(T):
        z[t] = H @ x + by_R @ random.standard_normal(len(H))
        x = A @ x + by_Q @ random.standard_normal(n) + (0 if B is None else np.asarray(B) @ u[t])
    return z, u


MATRIX = np.array([[0.9, 0.3], [-0.2, 0.7]])
SENSORS = np.array([[1, 0.2], [0.4, 1]])
AXES = np.kron(np.eye(2), [[1.0, 1.0], [0.0, 1.0]])  # position and velocity of two axes
PLACES = np.kron(np.eye(2), [1.0, 0.0])


def ar1(seed: int) -> np.ndarray:
    return drawn(0.8, 1, 0.5, 1, 200, seed)[0]


def pair(seed: int) -> np.ndarray:
    return drawn(MATRIX, SENSORS, [[0.5, 0.1], [0.1, 0.3]], [[1, 0.5], [0.5, 0.8]], 200, seed)[0]


def track(seed: int) -> np.ndarray:
    """Each axis is pushed by one noise: the best Q is singular"""
    push = np.kron(np.eye(2), np.array([[0.25, 0.5], [0.5, 1]]) * 0.1)
    return drawn(AXES, PLACES, push + 1e-12 * np.eye(4), np.eye(2), 200, seed)[0]


def pushed(seed: int, quiet: int) -> np.ndarray:
    """Two axes, each pushed by one noise, all four states measured, one of them without noise"""
    random, x = np.random.default_rng(seed), np.zeros((120, 4))
    push = np.kron(np.eye(2), [[0.5], [1]])
    for t in range(1, len(x)):
        x[t] = AXES @ x[t - 1] + push @ (0.3 * random.standard_normal(2))
    noise = [1.0, 0.5, 1.0, 0.5 if quiet != 3 else 0.0]
    noise[quiet] = 0.0
    return x + random.standard_normal((len(x), 4)) * noise


def quarters(seed: int) -> np.ndarray:
    """Level, slope and season whose slope has no noise"""
    A = np.zeros((5, 5))
    A[:2, :2], A[2, 2:], A[3, 2], A[4, 3] = [[1, 1], [0, 1]], -1, 1, 1
    return drawn(A, [1, 0, 1, 0, 0], np.diag([0.1, 0, 0.01, 0, 0]), 1, 160, seed)[0]


def trend(seed: int) -> np.ndarray:
    return drawn([[1, 1], [0, 1]], [1, 0], np.diag([0.1, 0.01]), 1, 200, seed)[0]


# Of a trend with so many waves of a period of 24 rows, whose start is not known: the exact diffuse log-likelihood
DIFFUSE = {0: -1091.896048777281, 1: -675.2120191708, 2: -786.2967263634}


def waves(harmonics: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """A, Q, H, R and 300 rows, some missing"""
    n, random = 2 + 2 * harmonics, np.random.default_rng(harmonics)
    A, H, Q = np.eye(n), np.zeros((1, n)), np.diag([0.02, 1e-4] + [1e-3] * (n - 2))
    A[0, 1] = H[0, 0] = 1
    for k in range(1, harmonics + 1):
        c, s = np.cos(2 * np.pi * k / 24), np.sin(2 * np.pi * k / 24)
        A[2 * k : 2 * k + 2, 2 * k : 2 * k + 2], H[0, 2 * k] = [[c, s], [-s, c]], 1
    z = 20 + random.normal(size=(300, 1)).cumsum(axis=0) + random.normal(size=(300, 1))
    z[random.random(300) < 0.1] = np.nan
    return A, Q, H, np.array([[0.5]]), z
