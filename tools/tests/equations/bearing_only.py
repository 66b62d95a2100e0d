"""A ship, by its bearing from a boat that goes in a zigzag; 10 s"""
import numpy as np

states = {"names": ["east", "north", "v east", "v north"], "units": ["m", "m", "m/s", "m/s"]}
measurements = {"names": ["bearing"], "units": ["rad"]}
angles = ["bearing"]
x0, P0 = [3000, 4000, -4, 2], [250000, 250000, 4, 4]
G, R = [[50, 0], [0, 50], [10, 0], [0, 10]], 1e-4
G = 0.001 * np.array(G)


def boat(t):
    side = 800 * np.abs(np.mod(t / 40, 2) - 1)
    return np.array([side, 30.0 * t])


def f(x):
    F = np.eye(4) + 10 * np.eye(4, k=2)
    return F @ x


def h(x, t):
    away = x[:2] - boat(t)
    return np.arctan2(away[0], away[1])
