"""A damped oscillator of singular Q, measured with correlated noises; all of them vary."""

import numpy as np
states, measurements, controls, dt = ["a", "b", "c"], ["p", "q", "r"], ["v"], 0.1
x0, P0 = [1, 0, 0.5], [1, 1, 1]
def f(x, u, dt): return [x[0] + dt * x[1], x[1] + dt * (u[0] - 0.5 * x[1]), 0.9 * x[2]]
def Q(x, t, u, dt):
    g = np.array([dt**2 / 2, dt, 0])
    return np.outer(g, g) * (1 + 0.1 * np.sin(x[0])) + np.diag([0, 0, 0.01 * dt])
def h(x): return [x[0], x[1] * x[2], x[0] + x[2]]
def R(x, t, u):
    s = 1 + x[0]**2 / 10
    return [[s, 0.9 * np.sqrt(s), 0], [0.9 * np.sqrt(s), 2, 0], [0, 0, 0.5 + 0.1 * np.sin(t)]]
def simulated_controls(t): return [np.sin(t)]
