"""Heading by a gyro whose scale is free: the states are errors of a direction as cosine and sine, and of a bias"""
import numpy as np

nominal = ["c", "s", "bias"]
states = ["turn", "bias error"]
measurements = ["north", "east"]
controls = ["rate"]
free = ["GAIN", "WALK"]
GAIN, WALK = 0.97, 1e-3
x0, P0 = [1, 0, 0.01], [1e-3, 1e-4]
Q, R = [1e-6, WALK**2], [1e-3, 1e-3]


def turned(x, angle):
    c, s = np.cos(angle), np.sin(angle)
    return [c * x[0] - s * x[1], s * x[0] + c * x[1]]


def f(x, t, u):
    return [*turned(x, 0.1 * (GAIN * u[0] - x[2])), x[2]]


def h(x):
    return x[:2]


def plus(x, d):
    return [*turned(x, d[0]), x[2] + d[1]]


def minus(a, b):
    return [np.arctan2(a[1] * b[0] - a[0] * b[1], a[0] * b[0] + a[1] * b[1]), a[2] - b[2]]


def simulated_controls(t):
    return np.sin(0.03 * t)
