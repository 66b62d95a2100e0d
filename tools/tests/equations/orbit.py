"""A satellite in the plane, its range and elevation from a station that turns with the Earth; thousands of km, 30 s"""
import numpy as np
from planar import rk4

states = {"names": ["x", "y", "vx", "vy"], "units": ["Mm", "Mm", "Mm/s", "Mm/s"]}
measurements, angles = {"names": ["range", "angle"], "units": ["Mm", "rad"]}, ["angle"]
x0, P0 = [7.0, 0.0, 0.0, 0.0076], [1e-4, 1e-4, 1e-10, 1e-10]
Q, R = [1e-12, 1e-12, 1e-14, 1e-14], [1e-8, 1e-7]
MU = 3.986e-4


def increment(x):
    def rate(x):
        r3 = (x[0] ** 2 + x[1] ** 2) ** 1.5
        return np.array([x[2], x[3], -MU * x[0] / r3, -MU * x[1] / r3])

    return rk4(rate, x, 30.0)


def h(x, t):
    turn = 7.292e-5 * 30 * t
    d = x[:2] - 6.378 * np.array([np.cos(turn), np.sin(turn)])
    return np.linalg.norm(d), np.arctan2(d[1], d[0])
