"""A robot with two wheels that sees two landmarks; a row is 0.1 s"""
import numpy as np
import planar

states = {"names": ["east", "north", "heading"], "units": ["m", "m", "rad"]}
measurements = {"names": ["range a", "bearing a", "range b", "bearing b"], "units": ["m", "rad", "m", "rad"]}
controls = {"names": ["left wheel", "right wheel"], "units": ["m/s", "m/s"], "ranges": [5, 5]}
angles = ["bearing a", "bearing b"]
x0, P0, Q = [0.0, 0.0, 0.0], [0.25, 0.25, 0.01], [1e-4, 1e-4, 1e-5]
TRACK, STEP = 0.4, 0.1


def f(x, t, u):
    forward, turn = STEP * (u[0] + u[1]) / 2, STEP * (u[1] - u[0]) / TRACK
    x = np.array(x)
    x[:2] += planar.turned(x[2] + turn / 2, forward)
    x[2] += turn
    return x


sensors = {"a": (lambda x: planar.seen_from(x, (8.0, 9.0)), [0.01, 4e-4]),
           "b": (lambda x: planar.seen_from(x, (-7.0, 6.0)), [0.01, 4e-4])}


def simulated_controls(t):
    return [1.0, 1.0 + 0.08 * np.sin(0.01 * t) + 0.04]
