"""Sixteen ordinary products, as their makers would write them: what design and compile are tried with."""

from __future__ import annotations

import numpy as np

from kalmanq import Model, Quantity
from kalmanq.model import Gaps


def _velocity(dt: float, sigma: float) -> tuple[list, np.ndarray]:
    return [[1, dt], [0, 1]], sigma * np.array([dt * dt / 2, dt])


def fridge() -> Model:
    """Temperature once a minute; it wanders"""
    return Model(1, 1, 0.04, 0.0025, P0=25, x0=5, states=[Quantity("temperature", "C", 60)], name="fridge",
                 measurements=[Quantity("ntc", "C", 80)])


def press() -> Model:
    """Pressure that fades to its mean, and the drifting bias of the cheaper of two sensors"""
    return Model([[0.95, 0], [0, 1]], [[1, 0], [1, 1]], [4, 0.04], [1, 1e-4], P0=[100, 1], name="press",
                 states=[Quantity("pressure", "bar", 100), Quantity("bias", "bar", 20)],
                 measurements=[Quantity("good", "bar", 120), Quantity("cheap", "bar", 120)])


def tilt() -> Model:
    """Angle by an accelerometer, and the bias of the gyro that drives it"""
    return Model([[1, -0.01], [0, 1]], [1, 0], 1e-3, [1e-6, 1e-10], B=[0.01, 0], P0=[0.1, 1e-3], name="tilt",
                 states=[Quantity("angle", "rad", 3.2), Quantity("bias", "rad/s", 0.2)],
                 measurements=[Quantity("accelerometer", "rad", 3.5)], controls=[Quantity("gyro", "rad/s", 9)])


def battery() -> Model:
    """Charge by current and by the voltage's slope, once a second"""
    return Model([[1, 0], [0, 0.98]], [1.2, -1], 1e-4, [1e-9, 1e-6], B=[-1 / 7200, 0.001], P0=[0.1, 1e-3],
                 x0=[0.8, 0], name="battery", states=[Quantity("charge", "", 1.5), Quantity("polarisation", "V", 1)],
                 measurements=[Quantity("voltage", "V", 3)], controls=[Quantity("current", "A", 20)])


def barometer() -> Model:
    """Altitude at 50 Hz"""
    A, G = _velocity(0.02, 0.5)
    return Model(A, [1, 0], 0.09, G=G, P0=[100, 4], name="barometer", measurements=["altitude"],
                 states=[Quantity("height", "m"), Quantity("climb", "m/s")])


def load_cell() -> Model:
    return Model(1, 1, 1.0, 0.01, P0=1e4, states=["weight"], measurements=["cell"], name="load_cell")


def gps() -> Model:
    A, G = _velocity(1.0, 0.3)
    return Model(np.kron(np.eye(2), A), [[1, 0, 0, 0], [0, 0, 1, 0]], [9, 9], G=np.kron(np.eye(2), G[:, None]),
                 P0=[100, 25, 100, 25], name="gps", gaps=Gaps(10),
                 states=[Quantity("x", "m", 2e4), Quantity("vx", "m/s", 100), Quantity("y", "m", 2e4),
                         Quantity("vy", "m/s", 100)],
                 measurements=[Quantity("east", "m", 2e4), Quantity("north", "m", 2e4)])


def clock() -> Model:
    """Offset in ns and drift beside a reference"""
    return Model([[1, 1], [0, 1]], [1, 0], 400, [1, 1e-4], P0=[1e6, 100], name="clock", gaps=Gaps(30),
                 states=[Quantity("offset", "ns"), Quantity("drift", "ns/s")], measurements=["reference"])


def motor() -> Model:
    """Angle by an encoder, speed, and a load that wanders; driven by current at 1 kHz"""
    return Model([[1, 1e-3, 0], [0, 0.999, -1e-2], [0, 0, 1]], [1, 0, 0], 1e-6, [0, 1e-4, 1e-5], B=[0, 0.05, 0],
                 P0=[1, 1, 1], name="motor", measurements=[Quantity("encoder", "rad", 100)],
                 states=[Quantity("angle", "rad", 100), Quantity("speed", "rad/s", 500), Quantity("load", "Nm", 5)],
                 controls=[Quantity("current", "A", 10)])


def tank() -> Model:
    """Level, and the flow into it"""
    return Model([[1, 0.1], [0, 0.99]], [1, 0], 0.25, [1e-4, 1e-3], P0=[1e3, 1], name="tank", gaps=Gaps(5),
                 states=[Quantity("level", "cm"), Quantity("flow", "cm/s")], measurements=["float"])


def anemometer() -> Model:
    return Model(0.9, 1, 0.5, 0.19, P0=1, states=["wind"], measurements=["cups"], name="anemometer", gaps=Gaps(3, 5))


def heart() -> Model:
    """Beats a minute, by two sensors of which one loses contact"""
    return Model(1, [[1], [1]], [4, 25], 0.5, P0=400, x0=70, states=[Quantity("rate", "1/min", 250)], name="heart",
                 measurements=[Quantity("strap", "1/min", 300), Quantity("optical", "1/min", 300)], gaps=Gaps(5, 10))


def spring() -> Model:
    """A mass that swings with little damping"""
    return Model([[0.995, 0.1], [-0.1, 0.985]], [1, 0], 0.01, [1e-5, 1e-3], P0=[1, 1], name="spring",
                 states=["place", "speed"], measurements=["ruler"], gaps=Gaps(4))


def meter() -> Model:
    """Power of a house: level and a daily change that is slow"""
    return Model([[1, 1], [0, 1]], [1, 0], 1e4, [100, 1e-6], P0=[1e6, 1], name="meter",
                 states=[Quantity("power", "W", 2e4), Quantity("slope", "W/min", 100)],
                 measurements=[Quantity("pulse", "W", 3e4)])


def ultrasound() -> Model:
    A, G = _velocity(0.05, 2.0)
    return Model(A, [1, 0], 1e-4, G=G, P0=[4, 4], name="ultrasound", gaps=Gaps(8),
                 states=[Quantity("distance", "m", 6), Quantity("speed", "m/s", 10)],
                 measurements=[Quantity("echo", "m", 6)])


def oven() -> Model:
    """Two temperatures that exchange heat, heated"""
    return Model([[0.98, 0.02], [0.01, 0.985]], [0, 1], 0.25, [0.01, 0.01], B=[0.5, 0], P0=[100, 100], x0=[20, 20],
                 name="oven", states=["wall", "air"], measurements=["probe"], controls=[Quantity("heater", "kW", 2)])


PRODUCTS = (fridge, press, tilt, battery, barometer, load_cell, gps, clock, motor, tank, anemometer, heart, spring,
            meter, ultrasound, oven)
