"""The attitude of a board from its gyroscope, accelerometer and magnetometer; 100 Hz"""
import numpy as np
from rotations import between, to_body, turned

nominal = ["q_w", "q_x", "q_y", "q_z", "b_x", "b_y", "b_z"]
states = {"names": ["roll", "pitch", "yaw", "d_b_x", "d_b_y", "d_b_z"], "units": ["rad"] * 3 + ["rad/s"] * 3}
measurements = {"names": ["a_x", "a_y", "a_z", "m_x", "m_y", "m_z"], "units": ["m/s2"] * 3 + [""] * 3}
controls = {"names": ["w_x", "w_y", "w_z"], "units": ["rad/s"] * 3}
x0 = [1, 0, 0, 0, 0, 0, 0]
P0, Q = [0.01] * 3 + [1e-3] * 3, [1e-6] * 3 + [1e-9] * 3
STEP, GRAVITY, NORTH = 0.01, np.array([0, 0, 9.81]), np.array([0.4, 0, -0.9])


def plus(x, d):
    return np.concatenate([turned(x[:4], d[:3]), x[4:] + d[3:]])


def minus(a, b):
    return np.concatenate([between(a[:4], b[:4]), a[4:] - b[4:]])


def f(x, t, u):
    return np.concatenate([turned(x[:4], STEP * (u - x[4:])), x[4:]])


sensors = {"accelerometer": (lambda x: to_body(x[:4], GRAVITY), [0.05] * 3),
           "magnetometer": (lambda x: to_body(x[:4], NORTH), 2e-3 * np.array([[2, 1, 0], [1, 2, 0], [0, 0, 1]]))}


def simulated_controls(t):
    return [0.6 * np.sin(0.012 * t), 0.3 * np.cos(0.009 * t), 0.2]
