"""A lithium cell: charge and polarisation by the voltage, its open-circuit voltage from a table"""
import numpy as np

states = {"names": ["charge", "polarisation"], "units": ["", "V"], "ranges": [1.5, 1]}
measurements = {"names": ["voltage"], "units": ["V"]}
controls = {"names": ["current"], "units": ["A"], "ranges": [20]}
x0, P0, Q, R = [0.6, 0], [0.01, 1e-4], [1e-9, 1e-7], 4e-6
CHARGE = [0.0, 0.1, 0.2, 0.35, 0.5, 0.65, 0.8, 0.9, 1.0]
VOLTAGE = [3.0, 3.42, 3.55, 3.63, 3.7, 3.83, 3.98, 4.07, 4.2]


def f(x, t, u):
    return [x[0] - u[0] / 7200, 0.97 * x[1] + 0.0005 * u[0]]


def h(x, t, u):
    return np.interp(x[0], CHARGE, VOLTAGE) - x[1] - 0.02 * u[0]


def simulated_controls(t):
    return 2.0 * np.sin(0.01 * t)
