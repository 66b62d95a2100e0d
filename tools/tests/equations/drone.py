"""A drone: position, velocity, roll, pitch and yaw from its IMU; GPS, and a barometer; 20 ms"""
import numpy as np

states = ["x", "y", "z", "vx", "vy", "vz", "roll", "pitch", "yaw"]
measurements = {"names": ["gps x", "gps y", "gps z", "pressure"], "units": ["m", "m", "m", "hPa"]}
controls = ["ax", "ay", "az", "p", "q", "r"]
x0, P0 = [0] * 9, [4, 4, 4, 1, 1, 1, 0.01, 0.01, 0.1]
Q = [1e-6] * 3 + [1e-4] * 3 + [1e-6] * 3
T = 0.02


def f(x, t, u):
    (cr, cp, cy), (sr, sp, sy) = np.cos(x[6:]), np.sin(x[6:])
    body = np.array([[cp * cy, sr * sp * cy - cr * sy, cr * sp * cy + sr * sy],
                     [cp * sy, sr * sp * sy + cr * cy, cr * sp * sy - sr * cy], [-sp, sr * cp, cr * cp]])
    rates = np.array([[1, sr * sp / cp, cr * sp / cp], [0, cr, -sr], [0, sr / cp, cr / cp]])
    a = body @ u[:3] - np.array([0, 0, 9.81]) - 0.1 * x[3:6]
    return np.hstack([x[:3] + T * x[3:6] + T**2 / 2 * a, x[3:6] + T * a, x[6:] + T * (rates @ u[3:])])


sensors = {"gps": (lambda x: x[:3], np.diag([1.0, 1.0, 4.0])),
           "barometer": (lambda x: 1013.25 * (1 - 2.25577e-5 * x[2]) ** 5.25588, 0.01)}


def simulated_controls(t):
    return [0.2 * np.sin(0.01 * t), 0.2 * np.cos(0.02 * t), 9.8, 0.1 * np.cos(0.05 * t), 0.1 * np.sin(0.04 * t), 0.05]
