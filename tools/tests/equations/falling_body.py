"""A body that falls into the air, by its range from aside (Athans, Wishner and Bertolini 1968); feet, 1/16 s"""
import numpy as np
from planar import rk4

states = {"names": ["height", "speed", "drag"], "units": ["ft", "ft/s", "1/ft"]}
measurements = {"names": ["range"], "units": ["ft"]}
x0, P0 = [3e5, 2e4, 1e-3], [1e6, 4e6, 1e-7]
Q, R = [1e-2, 1e-2, 1e-14], 1e4


def increment(x):
    return rk4(lambda x: np.array([-x[1], -np.exp(-5e-5 * x[0]) * x[1] * x[1] * x[2], 0.0]), x, 1 / 16)


def h(x):
    return np.sqrt(1e10 + (x[0] - 1e5) ** 2)
