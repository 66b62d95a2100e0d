"""Models that kalmanq compile is tried with: the five of its table, and random ones."""

from __future__ import annotations

from math import factorial

import numpy as np

from kalmanq import Model, Quantity
from kalmanq.model import Gaps

CORRELATED = np.array([[1, 0.3, 0.2], [0.3, 1, 0.1], [0.2, 0.1, 1]])
VARIANCES = (1.0, 1.5, 2.0)
KINDS = ("position", "velocity", "acceleration")
GAPS = Gaps(8, 48)


def kinematic(axes: int, order: int, dt: float = 0.5, mixing: np.ndarray = CORRELATED, variances: tuple = VARIANCES,
              ranged: bool = False, gaps: Gaps = GAPS) -> Model:
    """Axes of position and velocity (order 2), and acceleration (3), each position measured; noise between axes"""
    powers = np.arange(order)[::-1]
    noise = np.array([[dt ** (a + b + 1) / ((a + b + 1) * factorial(a) * factorial(b)) for b in powers]
                      for a in powers])
    A = sum(np.eye(order, k=k) * dt**k / factorial(k) for k in range(order))
    letters = "xyz" if axes > 1 else [""]
    states = [Quantity(f"{kind} {axis}".strip(), "") for axis in letters[:axes] for kind in KINDS[:order]]
    measurements = [Quantity(f"range {axis}".strip(), "m", 64.0 if ranged else None) for axis in letters[:axes]]
    return Model(np.kron(np.eye(axes), A), H=np.kron(np.eye(axes), np.eye(order)[:1]), R=np.diag(variances[:axes]),
                 Q=np.kron(mixing[:axes, :axes], noise), P0=np.full(axes * order, 4.0), states=states,
                 measurements=measurements, gaps=gaps, name=f"m{axes * order}{axes}")


def five(ranged: bool, dt: float = 0.5) -> list[Model]:
    gaps = GAPS if dt == 0.5 else Gaps(GAPS.max_gap, 200)  # the shorter a step, the more of them it takes to settle
    return [kinematic(axes, order, dt, ranged=ranged, gaps=gaps)
            for axes, order in ((1, 2), (1, 3), (2, 2), (3, 2), (3, 3))]


def random_model(seed: int, ranged: bool) -> Model:
    """1 to 6 states, scales over six decades, any A that fades or drifts, rows of H with one entry or several"""
    random = np.random.default_rng(seed)
    n = int(random.integers(1, 7))
    m = int(random.integers(1, min(n, 3) + 1))
    scale = 10 ** random.uniform(-3, 3, n)
    A = (drifting, turning, companion)[int(random.integers(3))](random, n)
    A = A * np.outer(scale, 1 / scale)
    H = np.eye(n)[random.permutation(n)[:m]]
    if random.random() < 0.5:
        H = random.standard_normal((m, n)) / scale
    G = scale[:, None] * random.standard_normal((n, n)) * 10 ** random.uniform(-2, 0)
    spread = np.einsum("ji,ik,jk->j", H, np.diag(scale**2), H)
    R = spread * 10 ** random.uniform(-2, 1, m)
    B = scale[:, None] * random.standard_normal((n, 1)) * 0.1 if random.random() < 0.3 else None
    span = 100 * np.sqrt(spread)
    return Model(A, H=H, R=R, G=G, B=B, P0=(scale * 10 ** random.uniform(-1, 1)) ** 2, name=f"random{seed}",
                 measurements=[Quantity(f"z{j}", "", float(span[j]) if ranged else None) for j in range(m)],
                 controls=None if B is None else [Quantity("u", "", 1.0)],
                 gaps=(Gaps(), Gaps(2, 400), Gaps(5, 400), Gaps(8, 60))[int(random.integers(4))])


def drifting(random: np.random.Generator, n: int) -> np.ndarray:
    """Integrators in a row, some of which fade"""
    return np.diag(random.choice([1.0, 1.0, 0.95, 0.6], n)) + np.eye(n, k=1) * random.choice([0.1, 0.5, 1.0])


def turning(random: np.random.Generator, n: int) -> np.ndarray:
    turn, _ = np.linalg.qr(random.standard_normal((n, n)))
    return random.choice([0.8, 0.95, 1.0]) * turn


def companion(random: np.random.Generator, n: int) -> np.ndarray:
    A = np.eye(n, k=1)
    A[:, 0] = -np.poly(random.uniform(-0.9, 0.9, n))[1:]
    return A
