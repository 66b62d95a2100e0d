"""A house: air, walls, and a leak that changes; its radiator gives a power of the temperature between; 10 minutes"""
import numpy as np

states = {"names": ["air", "walls", "leak"], "units": ["°C", "°C", "1"]}
measurements = {"names": ["thermostat"], "units": ["°C"]}
controls = {"names": ["radiator", "outside"], "units": ["°C", "°C"], "ranges": [90, 60]}
x0, P0, Q, R = [20, 18, 1], [1, 4, 0.04], [0.01, 0.001, 1e-6], 0.04


def f(x, t, u):
    heat = 0.02 * np.maximum(u[0] - x[0], 0.01) ** 1.3
    air = x[0] + heat + 0.1 * (x[1] - x[0]) + 0.04 * x[2] * (u[1] - x[0])
    return air, x[1] + 0.02 * (x[0] - x[1]) + 0.005 * (u[1] - x[1]), x[2]


def h(x):
    return x[0]


def simulated_controls(t):
    return [45.0 if t % 48 > 20 else 30.0, 5 + 6 * np.sin(2 * np.pi * t / 144)]
