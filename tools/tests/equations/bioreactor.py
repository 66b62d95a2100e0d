"""A fed reactor: biomass and substrate by Monod's law, and the growth rate that there can be; 3 minutes"""
import numpy as np

states = {"names": ["biomass", "substrate", "growth"], "units": ["g/l", "g/l", "1/h"]}
measurements = {"names": ["turbidity", "probe"], "units": ["", "g/l"]}
controls = {"names": ["dilution"], "units": ["1/h"], "ranges": [1]}
x0, P0, Q, R = [2, 5, 0.4], [0.25, 1, 0.01], [1e-5, 1e-4, 1e-6], [1e-3, 0.04]


def f(x, t, u):
    b, s, most = x
    for _ in range(3):
        growth = most * s / (0.5 + abs(s)) * b
        b, s = b + (growth - u[0] * b) / 60, s + (u[0] * (10 - s) - growth / 0.45) / 60
    return np.array([b, s, most])


turbidity = (lambda x: 0.8 * x[0] / (1 + 0.05 * x[0]), 1e-3)
sensors = {"turbidity": turbidity, "probe": (lambda x: np.fmax(x[1], 0.0), 0.04)}
del R


def simulated_controls(t):
    return [0.2 + 0.1 * np.sin(0.02 * t)]
