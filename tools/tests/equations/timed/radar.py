"""A target whose range and bearing are the less accurate, the farther away it is; and a receiver of its own."""

import numpy as np
states = {"names": ["east", "north", "v_east", "v_north"], "ranges": [8000, 8000, 100, 100]}
measurements = {"names": ["range", "bearing", "gps"], "ranges": [8000, 64, 8000]}
angles = ["bearing"]
dt = 0.5
x0, P0 = [300, 150, -2, 1], [100, 100, 4, 4]
def increment(x, dt): return [dt * x[2], dt * x[3], 0, 0]
def A(x, dt): return np.eye(4) + dt * np.eye(4, k=2)
def G(x, t, u, dt): return 0.3 * np.array([[dt * dt / 2, 0], [0, dt * dt / 2], [dt, 0], [0, dt]])
def h_radar(x): return [np.hypot(x[0], x[1]), np.arctan2(x[1], x[0])]
def H_radar(x):
    r = np.hypot(x[0], x[1])
    return [[x[0] / r, x[1] / r, 0, 0], [-x[1] / r**2, x[0] / r**2, 0, 0]]
def R_radar(x): return [(0.5 + 0.01 * np.hypot(x[0], x[1]))**2, (0.01 + 1e-5 * np.hypot(x[0], x[1]))**2]
sensors = {"radar": (h_radar, R_radar, H_radar), "gps": (lambda x: x[0], 9.0, lambda x: np.eye(1, 4))}
