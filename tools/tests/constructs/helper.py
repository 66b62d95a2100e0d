"""What a user's model file imports from beside it"""

import math
from math import cos, sin

import numpy as np

EARTH = 9.81


def multiplied(p, q):
    """Quaternions, scalar first"""
    w, v, a, b = p[0], np.asarray(p[1:]), q[0], np.asarray(q[1:])
    return np.concatenate([[w * a - v @ b], w * b + a * v + np.cross(v, b)])


def turned(angle):
    made = np.eye(2)
    made[0, 0] = made[1, 1] = cos(angle)
    made[0, 1] = -sin(angle)
    made[1, 0] = math.sin(angle)
    return made
