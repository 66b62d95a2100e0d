"""An arm of two links in a vertical plane: a camera sees its hand, an encoder its elbow; 5 ms"""
import numpy as np

states = ["shoulder", "elbow", "shoulder rate", "elbow rate"]
measurements = ["hand x", "hand y", "encoder"]
controls = {"names": ["torque 1", "torque 2"], "units": ["Nm", "Nm"], "ranges": [40, 40]}
x0, P0, Q = [-1.2, 0.4, 0, 0], [0.01, 0.01, 0.1, 0.1], [1e-8, 1e-8, 1e-4, 1e-4]
L1, L2, M1, M2, T = 0.5, 0.4, 2.0, 1.2, 0.005


def f(x, t, u):
    q, w = x[:2], x[2:]
    c2, s2 = np.cos(q[1]), np.sin(q[1])
    k = M2 * L1 * L2
    inertia = np.array([[(M1 + M2) * L1**2 + M2 * L2**2 + 2 * k * c2, M2 * L2**2 + k * c2], [M2 * L2**2 + k * c2, M2 * L2**2]])
    spin = np.array([-k * s2 * (2 * w[0] * w[1] + w[1] ** 2), k * s2 * w[0] ** 2])
    weight = 9.81 * np.array([(M1 + M2) * L1 * np.cos(q[0]) + M2 * L2 * np.cos(q[0] + q[1]), M2 * L2 * np.cos(q[0] + q[1])])
    w = w + T * np.linalg.solve(inertia, u - spin - weight - np.array([1.5, 0.8]) * w)
    return np.concatenate([q + T * w, w])


def camera(x):
    return [L1 * np.cos(x[0]) + L2 * np.cos(x[0] + x[1]), L1 * np.sin(x[0]) + L2 * np.sin(x[0] + x[1])]


sensors = {"camera": (camera, [1e-4, 1e-4]), "encoder": (lambda x: [x[1]], [1e-6])}


def simulated_controls(t):
    return [4 * np.sin(0.02 * t), 2 * np.cos(0.013 * t)]
