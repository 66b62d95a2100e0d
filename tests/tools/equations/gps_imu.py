"""GPS and an IMU in the plane, with the biases of both of its sensors; 0.1 s"""
import numpy as np
from planar import turned

states = {"names": ["east", "north", "speed", "heading", "accelerometer bias", "gyro bias"],
          "units": ["m", "m", "m/s", "rad", "m/s2", "rad/s"]}
measurements = ["gps east", "gps north"]
controls = {"names": ["acceleration", "turn"], "units": ["m/s2", "rad/s"]}
x0, P0 = [0, 0, 5, 0, 0, 0], [4, 4, 1, 0.1, 0.01, 1e-3]
Q, R = [1e-6, 1e-6, 1e-3, 1e-5, 1e-8, 1e-10], [4, 4]


def increment(x, t, u):
    east, north = turned(x[3], 0.1 * x[2])
    return [east, north, 0.1 * (u[0] - x[4]), 0.1 * (u[1] - x[5]), 0, 0]


def h(x):
    return x[:2]


def simulated_controls(t):
    return [0.3 * np.sin(0.02 * t), 0.2 * np.cos(0.013 * t)]
