"""A car that turns, from a radar that has range, bearing and range rate, of correlated errors; 50 ms"""
import numpy as np

states = {"names": ["x", "y", "speed", "course", "turn rate"], "units": ["m", "m", "m/s", "rad", "rad/s"]}
measurements = {"names": ["range", "bearing", "range rate"], "units": ["m", "rad", "m/s"]}
angles = ["bearing"]
x0, P0 = [60, -20, 15, 1.6, 0.3], [4, 4, 4, 0.1, 0.01]
Q = [1e-4, 1e-4, 0.01, 1e-5, 1e-5]
R = [[0.09, 0, 0.02], [0, 1e-4, 0], [0.02, 0, 0.04]]


def f(x):
    px, py, v, c, w = x
    chord = 0.05 * v * (1 - (0.05 * w) ** 2 / 24)
    return [px + chord * np.cos(c + 0.025 * w), py + chord * np.sin(c + 0.025 * w), v, c + 0.05 * w, w]


def h(x):
    r = np.sqrt(x[0] ** 2 + x[1] ** 2)
    return [r, np.arctan2(x[1], x[0]), x[2] * (x[0] * np.cos(x[3]) + x[1] * np.sin(x[3])) / r]
