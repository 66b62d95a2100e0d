"""A car whose position is measured at irregular times; its course is the noisier, the more it turns."""

import numpy as np
states = {"names": ["east", "north", "speed", "heading"], "ranges": [4000, 4000, 60, 60]}
measurements = {"names": ["gps_east", "gps_north"], "ranges": [4000, 4000]}
controls = ["yaw_rate"]
dt = 1.0
x0, P0, R = [0, 0, 15, 0], [25, 25, 1, 0.1], [4, 4]
def f(x, u, dt): return [x[0] + x[2] * np.cos(x[3]) * dt, x[1] + x[2] * np.sin(x[3]) * dt, x[2], x[3] + u[0] * dt]
def A(x, u, dt):
    c, s = np.cos(x[3]) * dt, np.sin(x[3]) * dt
    return [[1, 0, c, -x[2] * s], [0, 1, s, x[2] * c], [0, 0, 1, 0], [0, 0, 0, 1]]
def Q(x, t, u, dt): return np.diag([0, 0, 0.02, 1e-4]) * dt + 1e-3 * u[0]**2 * np.array(
    [[dt**3 / 3, 0, 0, 0], [0, dt**3 / 3, 0, dt**2 / 2], [0, 0, 0, 0], [0, dt**2 / 2, 0, dt]])
def h(x): return x[:2]
def H(x): return np.eye(2, 4)
def simulated_controls(t): return [0.3 * np.sin(0.2 * t)]
