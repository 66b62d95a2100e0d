"""Helpers of the models of vehicles in the plane"""
import numpy as np


def turned(angle, forward):
    """A distance ahead, as east and north"""
    return np.array([forward * np.cos(angle), forward * np.sin(angle)])


def seen_from(x, place):
    """Range and bearing of a place, from a vehicle at x[0], x[1] with the heading x[2]"""
    east, north = place[0] - x[0], place[1] - x[1]
    return np.hypot(east, north), np.arctan2(north, east) - x[2]


def rk4(rate, x, step):
    k1 = rate(x)
    k2 = rate(x + step / 2 * k1)
    k3 = rate(x + step / 2 * k2)
    k4 = rate(x + step * k3)
    return step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
