"""A pendulum that hangs from a cart; two rounds of Runge and Kutta a row of 20 ms"""
import numpy as np
from planar import rk4

states = {"names": ["cart", "angle", "cart speed", "angle rate"], "units": ["m", "rad", "m/s", "rad/s"]}
measurements, angles = ["cart", "angle"], [1]
controls = {"names": ["force"], "units": ["N"], "ranges": [10]}
x0, P0 = np.zeros(4), np.diag([0.01, 0.04, 0.1, 0.1])
G, R = [[0], [0], [0.01], [0.05]], [1e-4, 4e-4]
P0 = P0 + 0.001


def f(x, t, u):
    def rate(x):
        s, c = np.sin(x[1]), np.cos(x[1])
        pull = u[0] - 2.0 * x[2] - 1.0 * x[0] + 0.3 * s * (0.5 * x[3] ** 2 + 9.81 * c)
        ahead = pull / (1.0 + 0.3 * s**2)
        return np.array([x[2], x[3], ahead, -(ahead * c + 9.81 * s) / 0.5 - 0.2 * x[3]])

    for _ in range(2):
        x = x + rk4(rate, x, 0.01)
    return x


def h(x):
    return x[:2]


def simulated_controls(t):
    return 2.0 if t % 200 < 60 else -1.0
