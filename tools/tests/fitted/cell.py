"""A cell: its capacity, its resistances and its time constant are free, and the noises"""
import numpy as np

states = ["charge", "slow"]
measurements = ["voltage"]
controls = ["current"]
free = ["CAPACITY", "TAU", "R1", "R0", "SIGMA", "NOISE"]
STEP, CAPACITY = 10.0, 9000.0  # s, A s
TAU, R1, R0 = 60.0, 0.02, 0.03
DECAY = np.exp(-STEP / TAU)  # of what is free
SIGMA: float = 2e-3
NOISE = 5e-3  # V
x0, P0 = [0.8, 0.0], [1e-4, 1e-6]
Q = [1e-10, SIGMA**2]
R = NOISE**2


def f(x, t, u):
    return [x[0] - STEP * u[0] / CAPACITY, DECAY * x[1] + R1 * (1 - DECAY) * u[0]]


def h(x, t, u):
    return 3.3 + 0.9 * x[0] - 0.15 * np.exp(-20 * x[0]) + 0.1 * np.sin(6 * x[0]) - x[1] - R0 * u[0]


def simulated_controls(t):
    return 2 * (1 + np.sin(0.1 * t)) if t % 40 < 30 else 0.0
