"""A cart on a rail with a wheel that slips: a linear sensor, a bent one, and a step that varies."""
import numpy as np

states = {"names": ["place", "speed", "slip"], "units": ["m", "m/s", ""]}
measurements = {"names": ["place", "wheel", "echo"], "units": ["m", "m/s", "m"]}
controls = {"names": ["step", "push"], "units": ["s", "m/s2"]}
x0, P0 = [1.0, 0.0, 0.1], [1.0, 0.25, 0.01]
Q = np.diag([1e-4, 1e-3, 1e-6])


def f(x, t, u):
    return [x[0] + u[0] * x[1], x[1] + u[0] * (u[1] - 0.2 * x[1] * abs(x[1])), x[2]]


sensors = {"mark": (lambda x: [x[0]], [0.01]),
           "far": (lambda x: [x[1] * (1 + x[2]), np.sqrt(4 + x[0] ** 2)], np.array([[0.01, 0.002], [0.002, 0.04]]))}


def simulated_controls(t):
    return [0.1 + 0.05 * np.sin(t), np.cos(0.05 * t)]
