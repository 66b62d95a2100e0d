"""A cell with two RC pairs and a resistance that ages; the time step varies, so it is a control"""
import numpy as np

states = {"names": ["charge", "fast", "slow", "resistance"], "units": ["", "V", "V", "mOhm"]}
measurements = ["terminal voltage"]
controls = {"names": ["current", "step"], "units": ["A", "s"], "ranges": [50, 20]}
x0, P0, Q, R = [0.7, 0, 0, 20], [0.0025, 1e-6, 1e-4, 9], [1e-9, 1e-9, 1e-9, 1e-5], 1e-6


def f(x, t, u):
    i, dt = u
    a, b = np.exp(-dt / 8), np.exp(-dt / 300)
    return [x[0] - dt * i / 36000, a * x[1] + (1 - a) * 0.004 * i, b * x[2] + (1 - b) * 0.01 * i, x[3]]


def h(x, t, u):
    s = np.clip(x[0], 0.01, 0.99)
    return 3.5 + 0.35 * s + 0.05 * np.log(s / (1 - s)) - x[1] - x[2] - 1e-3 * x[3] * u[0]


def simulated_controls(t):
    return [8 * np.sin(0.02 * t), 1.0 + (t % 3) / 2]
