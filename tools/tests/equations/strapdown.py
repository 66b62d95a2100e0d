"""GPS and a strapdown IMU: position, velocity and a quaternion; the nine states are their errors; 100 Hz"""
import numpy as np
from rotations import between, to_world, turned

nominal = ["p_x", "p_y", "p_z", "v_x", "v_y", "v_z", "q_w", "q_x", "q_y", "q_z"]
states = ["d_p_x", "d_p_y", "d_p_z", "d_v_x", "d_v_y", "d_v_z", "roll", "pitch", "yaw"]
measurements = ["gps_x", "gps_y", "gps_z"]
controls = ["a_x", "a_y", "a_z", "w_x", "w_y", "w_z"]
x0 = [0, 0, 0, 0, 0, 0, 1, 0, 0, 0]
P0, Q, R = [4] * 3 + [1] * 3 + [0.04] * 3, [1e-6] * 3 + [1e-4] * 3 + [1e-6] * 3, [1] * 3
STEP, GRAVITY = 0.01, np.array([0, 0, -9.81])


def plus(x, d):
    return np.concatenate([x[:6] + d[:6], turned(x[6:], d[6:])])


def minus(a, b):
    return np.concatenate([a[:6] - b[:6], between(a[6:], b[6:])])


def f(x, t, u):
    return np.concatenate([x[:3] + STEP * x[3:6], x[3:6] + STEP * (to_world(x[6:], u[:3]) + GRAVITY), turned(x[6:], STEP * u[3:])])


def A(x, t, u):
    """Of small errors"""
    made = np.eye(9)
    made[:3, 3:6] = STEP * np.eye(3)
    for k, axis in enumerate(np.eye(3)):
        made[3:6, 6 + k] = STEP * to_world(x[6:], np.cross(axis, u[:3]))
        made[6:, 6 + k] = axis - np.cross(STEP * u[3:], axis)
    return made


def h(x):
    return x[:3]


def H(x):
    return np.eye(3, 9)


def simulated_controls(t):
    return [0.5 * np.sin(0.011 * t), 0.5 * np.cos(0.017 * t), 9.81 + 0.5 * np.sin(0.005 * t),
            0.2 * np.sin(0.01 * t), 0.2 * np.cos(0.007 * t), 0.3 * np.sin(0.003 * t + 1)]
