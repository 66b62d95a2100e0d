"""The attitude of a body that turns, from a gyro (100 Hz) with a bias, an accelerometer and a magnetometer (10 Hz).

The states are errors of the nominal numbers: a small rotation of the body and what is wrong in the bias.  World axes: x to
the north, z up.  Body axes: those of the sensors.  This file is a program: kalmanq executes it.
Source: Lefferts, Markley and Shuster, Kalman filtering for spacecraft attitude estimation, J. Guidance 5 (1982).
"""
import numpy as np

nominal = ["q_w", "q_x", "q_y", "q_z", "bias_x", "bias_y", "bias_z"]  # q turns body axes into world axes
states = {"names": ["turn_x", "turn_y", "turn_z", "off_x", "off_y", "off_z"], "units": ["rad"] * 3 + ["rad/s"] * 3}
measurements = {"names": ["up_x", "up_y", "up_z", "north_x", "north_y", "north_z"], "units": ["g"] * 3 + [""] * 3}
controls = {"names": ["gyro_x", "gyro_y", "gyro_z"], "units": ["rad/s"] * 3}

STEP = 0.01  # s
x0 = [1, 0, 0, 0, 0, 0, 0]  # level and to the north
P0 = [0.3**2] * 3 + [0.03**2] * 3  # 17 degrees
Q = [(0.3 * STEP) ** 2] * 3 + [0.0005**2] * 3  # of a gyro that is shaken, and of its bias that drifts
UP, FIELD = np.array([0, 0, 1.0]), np.array([0.5, 0, 0.866])  # at rest, in g; the Earth's, its length 1


def turned(q, v):
    """q and then a rotation by the vector v, in the body's axes"""
    half = v / 2
    angle = np.sqrt(np.dot(half, half))
    cosine, share = (np.cos(angle), np.sin(angle) / angle) if angle > 5e-5 else (1.0, 1.0)
    made = product(q, np.concatenate([[cosine], share * half]))
    return made / np.sqrt(np.dot(made, made))


def product(p, q):
    return np.concatenate([[p[0] * q[0] - np.dot(p[1:], q[1:])], p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:])])


def to_body(q, v):
    t = 2 * np.cross(v, q[1:])
    return v + q[0] * t + np.cross(t, q[1:])


def cross(v):
    """The matrix of the cross product with v"""
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def plus(x, d):
    return np.concatenate([turned(x[:4], d[:3]), x[4:] + d[3:]])


def minus(a, b):
    back = np.concatenate([b[:1], -b[1:4]])
    return np.concatenate([2 * product(back, a[:4])[1:], a[4:] - b[4:]])


def f(x, t, u):
    return np.concatenate([turned(x[:4], STEP * (u - x[4:])), x[4:]])


def A(x, t, u):
    """The error turns against the body, and grows by what is wrong in the bias; to the first order of a step."""
    turn = cross(STEP * (u - x[4:]))
    return np.block([[np.eye(3) - turn, -STEP * np.eye(3)], [np.zeros((3, 3)), np.eye(3)]])


def seen(of_world):
    """What points there in the world, in the body's axes, its variances and its Jacobian"""
    return (lambda x: to_body(x[:4], of_world), [0.03**2] * 3,
            lambda x: np.hstack([cross(to_body(x[:4], of_world)), np.zeros((3, 3))]))


sensors = {"accelerometer": seen(UP), "magnetometer": seen(FIELD)}


def simulated_controls(t):
    return [0.5 * np.sin(0.03 * t), 0.4 * np.cos(0.02 * t), 0.3]
