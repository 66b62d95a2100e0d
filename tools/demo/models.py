"""State-space models: x[t+1] = A x[t] + w, w ~ N(0, Q);  z[t] = H x[t] + v, v ~ N(0, R).

x0 and P0 hold before the first measurement.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Sequence

import numpy as np


@dataclass(frozen=True)
class Model:
    kind: str
    states: tuple[str, ...]  # names
    measured: tuple[str, ...]  # names
    A: np.ndarray
    Q: np.ndarray
    H: np.ndarray
    R: np.ndarray
    x0: np.ndarray
    P0: np.ndarray
    # m, as --q has them; Q is proportional to them
    q: np.ndarray = field(default_factory=lambda: np.zeros(0))

    @property
    def r(self) -> np.ndarray:
        return np.diag(self.R)

    def with_noise(self, Q: np.ndarray, R: np.ndarray) -> Model:
        """The same model with other noise; Q is a multiple of what it was."""
        return replace(self, Q=Q, R=R, q=self.q * (Q[0, 0] / self.Q[0, 0]))


def local_level(name: str, q: float, r: float, x0: float, p0: float) -> Model:
    """A level that walks at random, q per step, measured with noise of variance r."""
    return Model(
        kind="local level",
        states=(name,),
        measured=(name,),
        A=np.eye(1),
        Q=np.array([[q]]),
        H=np.eye(1),
        R=np.array([[r]]),
        x0=np.array([x0]),
        P0=np.array([[p0]]),
        q=np.array([q]),
    )


def constant_velocity(
    axes: Sequence[str],
    dt: float,
    q: Sequence[float],
    r: Sequence[float],
    x0: Sequence[float],
    p0: Sequence[float],
) -> Model:
    """Axes that move independently, each with the states position, velocity.

    The velocity is driven by white noise of spectral density q (length^2 / time^3); Q is exact
    for any dt.  x0 and p0 (variances) are given state by state.
    """
    d = len(axes)
    position = np.array([[1.0, 0.0]])
    return Model(
        kind="constant velocity",
        states=tuple(name for axis in axes for name in (axis, f"v{axis}")),
        measured=tuple(axes),
        A=np.kron(np.eye(d), np.array([[1.0, dt], [0.0, 1.0]])),
        Q=np.kron(np.diag(q), velocity_noise(dt)),
        H=np.kron(np.eye(d), position),
        R=np.diag(np.asarray(r, dtype=float)),
        x0=np.asarray(x0, dtype=float),
        P0=np.diag(np.asarray(p0, dtype=float)),
        q=np.asarray(q, dtype=float),
    )


def noise_text(model: Model, q_origin: str = "", r_origin: str = "") -> str:
    """q and r of every measured component, which is named where there are several."""
    pairs = [f"q = {q:.6g}{q_origin}, r = {r:.6g}{r_origin}" for q, r in zip(model.q, model.r)]
    if len(pairs) == 1:
        return pairs[0]
    return "; ".join(f"{name}: {pair}" for name, pair in zip(model.measured, pairs))


def velocity_noise(dt: float) -> np.ndarray:
    """Q of one axis over a step, for unit spectral density."""
    return np.array([[dt**3 / 3, dt**2 / 2], [dt**2 / 2, dt]])
