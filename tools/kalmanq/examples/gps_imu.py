"""Position, speed and heading of a vehicle from an IMU in the plane (10 Hz) with two biases, and a GPS receiver (1 Hz).

East and north are of a point near by: a float has 24 bits, 0.06 m at 1000 km.  The heading is not wrapped: nothing
measures it.  This file is a program: kalmanq executes it.
"""
import numpy as np

states = {"names": ["east", "north", "speed", "heading", "accelerometer bias", "gyro bias"],
          "units": ["m", "m", "m/s", "rad", "m/s2", "rad/s"]}
measurements = {"names": ["gps east", "gps north"], "units": ["m", "m"]}
controls = {"names": ["acceleration", "turn"], "units": ["m/s2", "rad/s"]}  # the IMU's readings: forward; to the left

STEP = 0.1  # s
x0 = [500.0, -300.0, 10.0, 0.5, 0.0, 0.0]
P0 = [4.0, 4.0, 1.0, 0.04, 0.01, 1e-4]
# In a step 1 mm, 0.1 m/s2 and 0.01 rad/s of the IMU, 1e-4 m/s2 and 1e-5 rad/s of its biases
Q = [1e-6, 1e-6, (0.1 * STEP) ** 2, (0.01 * STEP) ** 2, 1e-8, 1e-10]
R = [4.0, 4.0]


def increment(x, t, u):
    """f(x) - x over a step with the readings u"""
    ahead = STEP * x[2]
    return [ahead * np.cos(x[3]), ahead * np.sin(x[3]), STEP * (u[0] - x[4]), STEP * (u[1] - x[5]), 0, 0]


def h(x):
    return x[:2]


def simulated_controls(t):
    return [0.5 * np.cos(0.05 * t), 0.2 * np.sin(0.02 * t)]
