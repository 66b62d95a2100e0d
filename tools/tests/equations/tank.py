"""A tank that runs out by its height's root; an ultrasonic sensor"""
from math import sqrt

states = {"names": ["level"], "units": ["m"], "ranges": [4]}
measurements = {"names": ["echo time"], "units": ["ms"]}
controls = {"names": ["inflow"], "units": ["m3/s"], "ranges": [1]}
x0, P0, Q, R = 1.0, 0.09, 1e-6, 1e-3


def f(x, t, u):
    level = x[0]
    out = 0.05 * sqrt(2 * 9.81 * level) if level > 0 else 0.0
    return level + 0.5 * (u[0] - out)


def h(x):
    return 2e3 * (4 - x[0]) / 343


def simulated_controls(t):
    return 0.2 + (0.1 if t % 100 < 50 else -0.05)
