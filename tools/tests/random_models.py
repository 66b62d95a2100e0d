"""Random models of many kinds: kinematic, dense and companion A, sensors that select states or mix them."""

from __future__ import annotations

import numpy as np

from kalmanq import Model
from kalmanq.model import Gaps


def kinematic(random: np.random.Generator, n: int) -> np.ndarray:
    """Axes of position, velocity, acceleration: nothing below the diagonal"""
    A, dt, i = np.eye(n), 0.1, 0
    while i < n:
        order = int(random.integers(1, 4))
        for a in range(i, min(i + order, n)):
            for b in range(a + 1, min(i + order, n)):
                A[a, b] = dt ** (b - a) / (1 if b - a == 1 else 2)
        i += order
    return A


def dense(random: np.random.Generator, n: int) -> np.ndarray:
    turn, _ = np.linalg.qr(random.standard_normal((n, n)))
    return 0.95 * turn


def companion(random: np.random.Generator, n: int) -> np.ndarray:
    A = np.eye(n, k=1)
    A[:, 0] = np.poly(random.uniform(-0.8, 0.8, n))[1:] * -1
    return A


def random_model(random: np.random.Generator, n: int, m: int) -> Model:
    A = (kinematic, dense, companion)[int(random.integers(3))](random, n)
    H = random.standard_normal((m, n)) if random.random() < 0.4 else np.eye(n)[random.permutation(n)[:m] if m <= n else
                                                                               random.integers(0, n, m)]
    G = random.standard_normal((n, n)) * 0.1
    if random.random() < 0.5:
        G = np.diag(np.diag(G)) + 0.01 * np.eye(n)
    R = np.diag(random.uniform(0.5, 2, m))
    if m > 1 and random.random() < 0.2:
        R = R + 0.3
    l = int(random.integers(1, 3)) if random.random() < 0.3 else 0
    unknown = [int(random.integers(n))] if random.random() < 0.2 else []
    return Model(A, H=H, R=R, Q=G @ G.T, B=random.standard_normal((n, l)) * 0.1 if l else None, P0=np.ones(n),
                 unknown=unknown, controls=[f"u{k}" for k in range(l)] if l else None, gaps=Gaps(0, 1))
