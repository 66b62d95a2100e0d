"""Prey and hunters; the prey is counted"""
import numpy as np
from planar import rk4

states, measurements = ["prey", "hunters"], ["count"]
x0, P0, Q, R = [40, 9], [100, 9], [0.04, 0.01], 4


def rate(x):
    prey, hunters = x
    return np.array([0.5 * prey * (1 - prey / 200) - 0.03 * prey * hunters, 0.01 * prey * hunters - 0.3 * hunters])


def increment(x):
    return rk4(rate, x, 0.1)


def h(x):
    return [x[0]]
