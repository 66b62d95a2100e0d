"""A solar panel: clearness of the sky and temperature of its cells, by current and temperature; 5 minutes"""
from math import exp, pi, sin

states = {"names": ["clearness", "cell temperature"], "units": ["", "C"]}
measurements = {"names": ["current", "sensor"], "units": ["A", "C"]}
controls = {"names": ["voltage"], "units": ["V"]}
x0, P0, Q, R = [0.7, 25.0], [0.04, 25.0], [4e-4, 0.04], [0.0025, 0.25]


def sun(t):
    return max(0.0, sin(2 * pi * t / 288))


def f(x, t, u):
    warmth = 18 + 6 * sin(2 * pi * t / 288 - 0.5)
    return [0.7 + 0.98 * (x[0] - 0.7), x[1] + 0.2 * (warmth + 28 * x[0] * sun(t) - x[1])]


def h(x, t, u):
    photo = 9.0 * x[0] * sun(t) * (1 + 0.0005 * (x[1] - 25))
    return photo - 1e-7 * (exp(u[0] / (1.9 * (1 + x[1] / 273))) - 1), x[1]


def simulated_controls(t):
    return 28 + 3 * sin(0.1 * t)
