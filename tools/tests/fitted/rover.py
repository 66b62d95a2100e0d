"""A rover with odometry whose scale and lever arm are free, a compass and a radio beacon: two sensors, correlated noise"""
import math

import numpy as np

states = ["east", "north", "heading"]
measurements = ["compass", "range", "bearing"]
controls = ["speed", "turn"]
angles = ["compass", "bearing"]
free = ["SCALE", "LEVER", "DRIFT", "FAR", "ACROSS", "TOGETHER"]
SCALE = 1.05
LEVER = np.array([0.4, -0.2])  # m, of the antenna
DRIFT = 0.02  # rad/s
BEACON = (30.0, 40.0)
FAR, ACROSS, TOGETHER = 0.2, 0.02, 0.3  # m, rad, their correlation
R_RADIO = np.array([[FAR**2, TOGETHER * FAR * ACROSS], [TOGETHER * FAR * ACROSS, ACROSS**2]])
x0, P0 = [0, 0, 0.3], [0.01, 0.01, 1e-4]
Q = np.array([[1e-4, 2e-5, 0], [2e-5, 1e-4, 0], [0, 0, 1e-6]])


def f(x, t, u):
    step = 0.1 * SCALE * u[0]
    return [x[0] + step * np.cos(x[2]), x[1] + step * np.sin(x[2]), x[2] + 0.1 * (u[1] - DRIFT)]


def compass(x):
    return x[2]


def radio(x):
    c, s = math.cos(x[2]), math.sin(x[2])
    east = BEACON[0] - x[0] - c * LEVER[0] + s * LEVER[1]
    north = BEACON[1] - x[1] - s * LEVER[0] - c * LEVER[1]
    return [math.hypot(east, north), math.atan2(north, east) - x[2]]


sensors = {"compass": (compass, [1e-3]), "radio": (radio, R_RADIO)}


def simulated_controls(t):
    return [2.0, 0.5 * np.sin(0.05 * t)]
