"""Braking: speed of the car, of a wheel's rim, and what the road gives; a tyre by the magic formula"""
import math

states = {"names": ["car", "rim", "grip"], "units": ["m/s", "m/s", ""]}
measurements = {"names": ["wheel sensor", "accelerometer"], "units": ["m/s", "m/s2"]}
controls = {"names": ["brake"], "units": ["m/s2"], "ranges": [60]}
x0, P0, Q, R = [30, 29.9, 0.9], [1, 1, 0.04], [1e-4, 1e-2, 1e-6], [0.01, 0.04]
DT = 0.002


def friction(x):
    if x[0] > 1.0:
        slip = (x[0] - x[1]) / x[0]
    elif x[0] > 0.1:
        slip = (x[0] - x[1])
    else:
        slip = 0.0
    return x[2] * 9.81 * math.sin(1.65 * math.atan(10 * slip))


def f(x, t, u):
    a = friction(x)
    return [x[0] - DT * a + 0.01 * DT * (30 - x[0]), x[1] + DT * (8 * a - u[0]), x[2]]


def h(x):
    return [x[1], friction(x)]


def simulated_controls(t):
    return [25 + 15 * math.sin(0.03 * t) if t % 300 < 150 else 0.0]
