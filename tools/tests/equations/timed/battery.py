"""A cell whose noises grow with the current."""

import numpy as np
states = {"names": ["charge", "polarisation"], "ranges": [4, 4]}
measurements = {"names": ["voltage"], "ranges": [16]}
controls = ["current"]
x0, P0 = [0.8, 0.0], [0.01, 1e-4]
def Q(x, t, u): return [1e-8 + 1e-7 * u[0]**2, 1e-7 + 1e-6 * u[0]**2]
def R(x, t, u): return 1e-4 + 1e-4 * u[0]**2 * (2 - x[0]) * (1 + 0.5 * np.sin(t))
def increment(x, t, u): return [-u[0] / 900, -0.15 * x[1] + 0.003 * u[0]]
def A(x): return [[1, 0], [0, 0.85]]
def h(x, t, u): return 3.3 + 0.9 * x[0] - 0.15 * np.exp(-20 * x[0]) - x[1] - 0.03 * u[0]
def H(x): return [0.9 + 3 * np.exp(-20 * x[0]), -1]
def simulated_controls(t): return [2 + np.sin(0.1 * t)]
