"""An induction motor: flux and speed by the currents of its stator; 0.1 ms"""
import numpy as np

states = ["current a", "current b", "flux a", "flux b", "speed"]
measurements = {"names": ["current a", "current b"], "units": ["A", "A"]}
controls = {"names": ["voltage a", "voltage b"], "units": ["V", "V"]}
x0, P0 = [0, 0, 0, 0, 0], [1, 1, 0.1, 0.1, 100]
Q, R = [1e-4, 1e-4, 1e-8, 1e-8, 1e-2], [0.01, 0.01]
LS, LR, LM, RS, RR, T = 0.16, 0.16, 0.15, 1.2, 1.0, 1e-4
SIGMA = 1 - LM**2 / (LS * LR)


def f(x, t, u):
    i, p, w = x[0:2], x[2:4], x[4]
    turned = np.array([-p[1], p[0]])
    back = RR / LR * p - w * turned
    di = (u - (RS + RR * (LM / LR) ** 2) * i + LM / LR * back) / (SIGMA * LS)
    torque = 3.0 * LM / LR * (p[0] * i[1] - p[1] * i[0])
    return np.concatenate([i + T * di, p + T * (RR * LM / LR * i - RR / LR * p + w * turned), [w + T * 50 * (torque - 0.02 * w)]])


def h(x):
    return x[:2]


def simulated_controls(t):
    return 120 * np.array([np.cos(0.0314 * t), np.sin(0.0314 * t)])
