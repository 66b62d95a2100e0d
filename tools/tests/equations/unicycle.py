"""A vehicle by GPS, whose errors are correlated, and by the speed of its wheel"""
import numpy as np
from math import cos, sin

states = {"names": ["east", "north", "heading", "speed"], "units": ["m", "m", "rad", "m/s"]}
measurements = ["gps east", "gps north", "wheel"]
controls = {"names": ["yaw rate", "acceleration"], "units": ["rad/s", "m/s2"], "ranges": [2, 20]}
x0, P0, Q = [0, 0, 0.5, 4], [9, 9, 0.1, 1], np.diag([1e-4, 1e-4, 1e-4, 1e-2])


def increment(x, t, u):
    T = 0.1
    return [T * x[3] * cos(x[2]), T * x[3] * sin(x[2]), T * u[0], T * (u[1] - 0.02 * abs(x[3]) * x[3])]


def gps(x):
    return x[0:2]


def wheel(x, t, u):
    return x[3] * (1 + 0.01 * u[0] ** 2)


sensors = {"gps": (gps, [[4.0, 1.5], [1.5, 3.0]]), "wheel": (wheel, 0.01)}


def simulated_controls(t):
    return 0.2 * np.sin(t / 50), 0.4 + 0.2 * np.cos(t / 30)
