"""The bicycle model of a car: slip angle of its centre; GPS with correlated errors"""
import numpy as np

states = {"names": ["x", "y", "yaw", "v"], "units": ["m", "m", "rad", "m/s"]}
measurements = {"names": ["x", "y"], "units": ["m", "m"]}
controls = {"names": ["steering", "acceleration"], "units": ["rad", "m/s^2"], "ranges": [0.7, 12]}
x0, P0, Q = [0, 0, 0, 10], [4, 4, 0.05, 2], [1e-4, 1e-4, 1e-5, 0.01]
R = np.array([[1.0, -0.4], [-0.4, 0.8]])
FRONT, REAR, DT = 1.2, 1.5, 0.05


def increment(x, t, u):
    _, _, yaw, v = x
    slip = np.arctan(REAR / (FRONT + REAR) * np.tan(u[0]))
    return DT * np.array([v * np.cos(yaw + slip), v * np.sin(yaw + slip), v / REAR * np.sin(slip), u[1]])


def h(x):
    x, y, *_ = x
    return x, y


def simulated_controls(t):
    return [0.05 * np.sin(0.02 * t), 0.3 * np.cos(0.05 * t)]
