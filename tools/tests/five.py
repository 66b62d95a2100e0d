"""Five models as they are designed: a level, mixed units, a track, attitude and bias, trend and season."""

from __future__ import annotations

import numpy as np

from kalmanq import Model, Quantity
from kalmanq.model import Gaps


def level() -> Model:
    return Model(1, H=1, R=4.0, Q=0.5, P0=100, states=[Quantity("level", "mm", 200)], name="level",
                 measurements=[Quantity("gauge", "mm", 250)])


def mixed_units() -> Model:
    """Position in km, velocity in mm/s, measured in m every 0.1 s"""
    dt = 0.1
    A = [[1, dt * 1e-6], [0, 1]]
    G = np.array([dt * dt / 2 * 1e-3, dt * 1e3]) * 0.5
    return Model(A, H=[1000, 0], R=4.0, G=G, P0=[1e-4, 1e6], name="mixed_units", gaps=Gaps(5, 10),
                 states=[Quantity("position", "km", 2), Quantity("velocity", "mm/s", 2e5)],
                 measurements=[Quantity("range", "m", 2100)])


def track() -> Model:
    dt = 0.5
    A, G = np.eye(4), np.zeros((4, 2))
    A[0, 1] = A[2, 3] = dt
    G[0, 0] = G[2, 1] = dt * dt / 2
    G[1, 0] = G[3, 1] = dt
    return Model(A, H=[[1, 0, 0, 0], [0, 0, 1, 0]], R=[4.0, 4.0], G=0.4 * G, P0=[100, 25, 100, 25], name="track",
                 states=[Quantity("x", "m", 20000), Quantity("vx", "m/s", 200), Quantity("y", "m", 20000),
                         Quantity("vy", "m/s", 200)],
                 measurements=[Quantity("east", "m", 20100), Quantity("north", "m", 20100)])


def attitude() -> Model:
    """Three small angles and the biases of three gyros, which are the controls"""
    dt = 0.01
    A, B = np.eye(6), np.zeros((6, 3))
    A[:3, 3:] = -dt * np.eye(3)
    B[:3] = dt * np.eye(3)
    names = ["roll", "pitch", "yaw"]
    Q = [(1e-3 * dt) ** 2] * 3 + [(1e-5) ** 2 * dt] * 3
    return Model(A, H=np.eye(3, 6), R=[1e-4] * 3, Q=Q, B=B, P0=[0.1] * 3 + [1e-3] * 3, name="attitude", gaps=Gaps(9, 1),
                 states=[Quantity(name, "rad", 1.5) for name in names] +
                        [Quantity(f"{name}_bias", "rad/s", 0.2) for name in names],
                 measurements=[Quantity(f"{name}_seen", "rad", 1.6) for name in names],
                 controls=[Quantity(f"{name}_rate", "rad/s", 2) for name in names])


def trend_season() -> Model:
    A = np.zeros((5, 5))
    A[:2, :2] = [[1, 1], [0, 1]]
    A[2, 2:] = -1
    A[3, 2] = A[4, 3] = 1
    return Model(A, H=[1, 0, 1, 0, 0], R=1.0, Q=[0.05, 1e-4, 0.02, 0, 0], P0=[25, 0.01, 4, 4, 4], name="trend_season",
                 states=[Quantity(name, "", span) for name, span in
                         (("level", 500), ("slope", 5), ("season", 40), ("season_1", 40), ("season_2", 40))],
                 measurements=[Quantity("sales", "", 600)])


FIVE = (level, mixed_units, track, attitude, trend_season)
