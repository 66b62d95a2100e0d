"""Products as their makers would write them: sixteen ordinary ones for design and compile, and others for compile alone."""

from __future__ import annotations

import numpy as np

from kalmanq import Model, Quantity
from kalmanq.model import Gaps


def _velocity(dt: float, sigma: float) -> tuple[list, np.ndarray]:
    return [[1, dt], [0, 1]], sigma * np.array([dt * dt / 2, dt])


def fridge() -> Model:
    """Temperature once a minute; it wanders"""
    return Model(1, H=1, R=0.04, Q=0.0025, P0=25, x0=5, states=[Quantity("temperature", "C", 60)], name="fridge",
                 measurements=[Quantity("ntc", "C", 80)])


def press() -> Model:
    """Pressure that fades to its mean, and the drifting bias of the cheaper of two sensors"""
    return Model([[0.95, 0], [0, 1]], H=[[1, 0], [1, 1]], R=[4, 0.04], Q=[1, 1e-4], P0=[100, 1], name="press",
                 states=[Quantity("pressure", "bar", 100), Quantity("bias", "bar", 20)],
                 measurements=[Quantity("good", "bar", 120), Quantity("cheap", "bar", 120)])


def tilt() -> Model:
    """Angle by an accelerometer, and the bias of the gyro that drives it"""
    return Model([[1, -0.01], [0, 1]], H=[1, 0], R=1e-3, Q=[1e-6, 1e-10], B=[0.01, 0], P0=[0.1, 1e-3], name="tilt",
                 states=[Quantity("angle", "rad", 3.2), Quantity("bias", "rad/s", 0.2)],
                 measurements=[Quantity("accelerometer", "rad", 3.5)], controls=[Quantity("gyro", "rad/s", 9)])


def battery() -> Model:
    """Charge by current and by the voltage's slope, once a second"""
    return Model([[1, 0], [0, 0.98]], H=[1.2, -1], R=1e-4, Q=[1e-9, 1e-6], B=[-1 / 7200, 0.001], P0=[0.1, 1e-3],
                 x0=[0.8, 0], name="battery", states=[Quantity("charge", "", 1.5), Quantity("polarisation", "V", 1)],
                 measurements=[Quantity("voltage", "V", 3)], controls=[Quantity("current", "A", 20)])


def barometer() -> Model:
    """Altitude at 50 Hz"""
    A, G = _velocity(0.02, 0.5)
    return Model(A, H=[1, 0], R=0.09, G=G, P0=[100, 4], name="barometer", measurements=["altitude"],
                 states=[Quantity("height", "m"), Quantity("climb", "m/s")])


def load_cell() -> Model:
    return Model(1, H=1, R=1.0, Q=0.01, P0=1e4, states=["weight"], measurements=["cell"], name="load_cell")


def gps() -> Model:
    A, G = _velocity(1.0, 0.3)
    return Model(np.kron(np.eye(2), A), H=[[1, 0, 0, 0], [0, 0, 1, 0]], R=[9, 9], G=np.kron(np.eye(2), G[:, None]),
                 P0=[100, 25, 100, 25], name="gps", gaps=Gaps(10),
                 states=[Quantity("x", "m", 2e4), Quantity("vx", "m/s", 100), Quantity("y", "m", 2e4),
                         Quantity("vy", "m/s", 100)],
                 measurements=[Quantity("east", "m", 2e4), Quantity("north", "m", 2e4)])


def clock() -> Model:
    """Offset in ns and drift beside a reference"""
    return Model([[1, 1], [0, 1]], H=[1, 0], R=400, Q=[1, 1e-4], P0=[1e6, 100], name="clock", gaps=Gaps(30),
                 states=[Quantity("offset", "ns"), Quantity("drift", "ns/s")], measurements=["reference"])


def motor() -> Model:
    """Angle by an encoder, speed, and a load that wanders; driven by current at 1 kHz"""
    return Model([[1, 1e-3, 0], [0, 0.999, -1e-2], [0, 0, 1]], H=[1, 0, 0], R=1e-6, Q=[0, 1e-4, 1e-5], B=[0, 0.05, 0],
                 P0=[1, 1, 1], name="motor", measurements=[Quantity("encoder", "rad", 100)],
                 states=[Quantity("angle", "rad", 100), Quantity("speed", "rad/s", 500), Quantity("load", "Nm", 5)],
                 controls=[Quantity("current", "A", 10)])


def tank() -> Model:
    """Level, and the flow into it"""
    return Model([[1, 0.1], [0, 0.99]], H=[1, 0], R=0.25, Q=[1e-4, 1e-3], P0=[1e3, 1], name="tank", gaps=Gaps(5),
                 states=[Quantity("level", "cm"), Quantity("flow", "cm/s")], measurements=["float"])


def anemometer() -> Model:
    return Model(0.9, H=1, R=0.5, Q=0.19, P0=1, states=["wind"], measurements=["cups"], name="anemometer", gaps=Gaps(3, 5))


def heart() -> Model:
    """Beats a minute, by two sensors of which one loses contact"""
    return Model(1, H=[[1], [1]], R=[4, 25], Q=0.5, P0=400, x0=70, states=[Quantity("rate", "1/min", 250)], name="heart",
                 measurements=[Quantity("strap", "1/min", 300), Quantity("optical", "1/min", 300)], gaps=Gaps(5, 10))


def spring() -> Model:
    """A mass that swings with little damping"""
    return Model([[0.995, 0.1], [-0.1, 0.985]], H=[1, 0], R=0.01, Q=[1e-5, 1e-3], P0=[1, 1], name="spring",
                 states=["place", "speed"], measurements=["ruler"], gaps=Gaps(4))


def meter() -> Model:
    """Power of a house: level and a daily change that is slow"""
    return Model([[1, 1], [0, 1]], H=[1, 0], R=1e4, Q=[100, 1e-6], P0=[1e6, 1], name="meter",
                 states=[Quantity("power", "W", 2e4), Quantity("slope", "W/min", 100)],
                 measurements=[Quantity("pulse", "W", 3e4)])


def ultrasound() -> Model:
    A, G = _velocity(0.05, 2.0)
    return Model(A, H=[1, 0], R=1e-4, G=G, P0=[4, 4], name="ultrasound", gaps=Gaps(8),
                 states=[Quantity("distance", "m", 6), Quantity("speed", "m/s", 10)],
                 measurements=[Quantity("echo", "m", 6)])


def oven() -> Model:
    """Two temperatures that exchange heat, heated"""
    return Model([[0.98, 0.02], [0.01, 0.985]], H=[0, 1], R=0.25, Q=[0.01, 0.01], B=[0.5, 0], P0=[100, 100], x0=[20, 20],
                 name="oven", states=["wall", "air"], measurements=["probe"], controls=[Quantity("heater", "kW", 2)])


def drone() -> Model:
    """Three axes of position, velocity and acceleration, with jerk noise; height is measured better"""
    dt = 0.1
    A = [[1, dt, dt * dt / 2], [0, 1, dt], [0, 0, 1]]
    G = 5.0 * np.array([dt**3 / 6, dt * dt / 2, dt])
    states = [Quantity(f"{kind} {axis}", unit, most) for axis in "xyz" for kind, unit, most in
              (("position", "m", 1e4), ("velocity", "m/s", 100), ("acceleration", "m/s2", 50))]
    return Model(np.kron(np.eye(3), A), H=np.kron(np.eye(3), [[1, 0, 0]]), R=[4, 4, 0.25], G=np.kron(np.eye(3), G[:, None]),
                 P0=[100, 25, 4] * 3, states=states, measurements=[Quantity(axis, "m", 1e4) for axis in "xyz"],
                 name="drone", gaps=Gaps(20))


def calendar() -> Model:
    """Passengers an hour: a level, and a daily pattern of eight hours in companion form"""
    A = np.zeros((8, 8))
    A[0, 0] = 1
    A[1, 1:] = -1
    A[2:, 1:7] = np.eye(6)
    return Model(A, H=[1, 1, 0, 0, 0, 0, 0, 0], R=25, Q=[0.5, 0.2, 0, 0, 0, 0, 0, 0], P0=[1e4] + [400] * 7, x0=[200] + [0] * 7,
                 name="calendar", states=["level", *(f"hour {k}" for k in range(7))], measurements=["gate"])


def interferometer() -> Model:
    """A distance that is known to 1 mm at first and measured to 1 nm"""
    A, G = _velocity(1e-3, 1e-4)
    return Model(A, H=[1, 0], R=1e-18, G=G, P0=[1e-6, 1e-8], name="interferometer", measurements=["fringe"],
                 states=[Quantity("distance", "m"), Quantity("speed", "m/s")])


def borehole() -> Model:
    """A temperature that hardly moves, of which next to nothing is known at first"""
    return Model([[1, 1], [0, 0.9]], H=[1, 0], R=1e-4, Q=[1e-10, 1e-10], P0=[1e6, 1], name="borehole",
                 states=[Quantity("temperature", "C"), Quantity("trend", "C/h")], measurements=["probe"])


def scale() -> Model:
    """A weight that changes, on a scale of which the offset never does; a second, coarse one has none"""
    return Model(np.eye(2), H=[[1, 1], [1, 0]], R=[0.01, 4], Q=[0.5, 0], P0=[1e4, 100], name="scale",
                 states=["weight", "offset"], measurements=["fine", "coarse"])


def quartz() -> Model:
    """An oscillation without noise, and what it is measured on; 10 kHz"""
    turn = 2 * np.pi * 50 / 1e4
    A = [[np.cos(turn), np.sin(turn), 0], [-np.sin(turn), np.cos(turn), 0], [0, 0, 0.99]]
    return Model(A, H=[1, 0, 1], R=0.04, Q=[0, 0, 1e-3], P0=[1, 1, 0.1], name="quartz",
                 states=["sine", "cosine", "hum"], measurements=[Quantity("mains", "V", 50)])


def rover() -> Model:
    """Speed and turn rate, driven by two motors; both odometers share the slip of the floor"""
    return Model([[0.9, 0], [0, 0.8]], H=[[1, -0.2], [1, 0.2]], R=[[0.01, 0.006], [0.006, 0.02]], Q=[1e-3, 1e-2],
                 B=[[0.05, 0.05], [-0.2, 0.2]], P0=[1, 1], name="rover", gaps=Gaps(4),
                 states=[Quantity("speed", "m/s"), Quantity("turn", "rad/s")],
                 measurements=[Quantity("left", "m/s", 5), Quantity("right", "m/s", 5)],
                 controls=[Quantity("left motor", "V", 12), Quantity("right motor", "V", 12)])


def well() -> Model:
    """Depth and its trend, of which nothing is known at first; a fast and a slow sensor"""
    return Model([[1, 0.5], [0, 1]], H=[[1, 0], [1, 0]], R=[0.01, 1e-4], Q=[1e-6, 1e-8], P0=None, unknown="all", name="well",
                 states=[Quantity("depth", "m", 200), Quantity("trend", "m/h", 5)], gaps=Gaps(12),
                 measurements=[Quantity("pressure", "m", 200), Quantity("tape", "m", 200)])


def pll() -> Model:
    """A phase-locked loop at 10 kHz: phase beside an oscillator that is driven, by a detector good to a thousandth of a radian"""
    A, G = _velocity(1e-4, 200.0)
    return Model(A, H=[1, 0], R=1e-6, G=G, B=[-1e-4, 0], P0=[10, 1e6], name="pll", gaps=Gaps(3),
                 states=[Quantity("phase", "rad", 6.4), Quantity("frequency", "rad/s", 5000)],
                 measurements=[Quantity("detector", "rad", 6.4)], controls=[Quantity("oscillator", "rad/s", 5000)])


def gnss_odo() -> Model:
    """Along a track: GNSS once a second, and an odometer with a bias that drifts"""
    G = [[0.25, 0], [0.5, 0], [0, 1e-3]]
    return Model([[1, 1, 0], [0, 1, 0], [0, 0, 1]], H=[[1, 0, 0], [0, 1, 1]], R=[9, 0.01], G=G, P0=[1e8, 400, 0.25], name="gnss_odo", gaps=Gaps(60),
                 states=[Quantity("position", "m", 5e4), Quantity("speed", "m/s", 60), Quantity("bias", "m/s", 2)],
                 measurements=[Quantity("gnss", "m", 5e4), Quantity("odometer", "m/s", 65)])


def bldc() -> Model:
    """Angle, speed and load of a brushless motor at 10 kHz, and the bias of its current sensor"""
    return Model([[1, 1e-4, 0, 0], [0, 0.9998, -0.02, 0.05], [0, 0, 1, 0], [0, 0, 0, 1]], H=[[1, 0, 0, 0], [0, 0, 0, 1]], R=[4e-6, 0.04],
                 Q=[0, 1e-4, 1e-8, 1e-10], B=[0, 0.05, 0, 0], P0=[10, 1e4, 1, 0.25], name="bldc",
                 states=[Quantity("angle", "rad", 400), Quantity("speed", "rad/s", 1000), Quantity("load", "Nm", 5), Quantity("bias", "A", 2)],
                 measurements=[Quantity("resolver", "rad", 400), Quantity("idle", "A", 5)], controls=[Quantity("current", "A", 20)])


def thermistors() -> Model:
    """Four temperatures of a cabinet, once a second, that follow each other in hours"""
    tau = np.array([[0, 3600, 0, 0], [3600, 0, 7200, 7200], [0, 7200, 0, 0], [0, 7200, 0, 0]], float)
    rate = np.where(tau > 0, 1 / np.where(tau > 0, tau, 1), 0)
    A = np.eye(4) + rate - np.diag(rate.sum(axis=1))
    return Model(A, H=np.eye(4), R=[0.01] * 4, Q=[1e-8, 1e-9, 1e-8, 1e-9], P0=[100] * 4, x0=[20] * 4, name="thermistors",
                 states=[Quantity(one, "C", 150) for one in ("heatsink", "air", "board", "wall")],
                 measurements=[Quantity(f"ntc {k}", "C", 160) for k in range(4)])


def variometer() -> Model:
    """Height by pressure, driven by an accelerometer that reads gravity, too; its bias walks"""
    return Model([[1, 0.02, -2e-4], [0, 1, -0.02], [0, 0, 1]], H=[1, 0, 0], R=0.09, B=[2e-4, 0.02, 0], c=[-1.96133e-3, -0.196133, 0],
                 Q=[[1e-8, 1e-6, 0], [1e-6, 2.5e-4, 0], [0, 0, 1e-10]], x0=[300, 0, 0], P0=[2500, 4, 0.04], name="variometer",
                 states=[Quantity("height", "m", 12000), Quantity("climb", "m/s", 60), Quantity("bias", "m/s2", 2)],
                 measurements=[Quantity("baro", "m", 12000)], controls=[Quantity("accelerometer", "m/s2", 80)])


# ------------------------------------------------------------------------------ whose states are far beyond their sigma


def spindle() -> Model:
    """An angle over thousands of turns, at 1 kHz, by an encoder good to a milliradian"""
    A, G = _velocity(1e-3, 0.5)
    return Model(A, H=[1, 0], R=1e-6, G=G, P0=[1, 1e4], name="spindle", measurements=[Quantity("encoder", "rad", 2e4)],
                 states=[Quantity("angle", "rad", 2e4), Quantity("speed", "rad/s", 2500)])


def tide() -> Model:
    """Level of the sea once a minute: the mean level and the tide of half a day, which nothing but the moon moves"""
    turn = 2 * np.pi * 60 / 44714.16
    A = [[1, 0, 0], [0, np.cos(turn), np.sin(turn)], [0, -np.sin(turn), np.cos(turn)]]
    return Model(A, H=[1, 1, 0], R=100, Q=[1e-2, 1e-4, 1e-4], P0=[1e4, 9e4, 9e4], name="tide", measurements=[Quantity("radar", "mm", 2e4)],
                 states=[Quantity("level", "mm", 1e4), Quantity("tide", "mm", 6e3), Quantity("quadrature", "mm", 6e3)])


def airdata() -> Model:
    """Static pressure and its rate at 25 Hz, by a good sensor and one whose bias drifts"""
    A = [[1, 0.04, 0], [0, 0.999, 0], [0, 0, 0.9999]]
    return Model(A, H=[[1, 0, 0], [1.0003, 0, 1]], R=[4, 1], Q=[0, 0.04, 1e-4], P0=[1e6, 1e4, 1e4], x0=[1e5, 0, 0], name="airdata",
                 states=[Quantity("static", "Pa", 1.1e5), Quantity("rate", "Pa/s", 2000), Quantity("bias", "Pa", 400)],
                 measurements=[Quantity("good", "Pa", 1.1e5), Quantity("cheap", "Pa", 1.1e5)])


def hydraulic() -> Model:
    """Oil of a press at 2 kHz: what leaks, what the valve lets in, and the offset of its sensor against the one of the pump"""
    return Model([[0.9996, 0.35, 0], [0, 0.98, 0], [0, 0, 1]], H=[[1, 0, 1], [1, 0, 0]], R=[0.01, 0.25], Q=[1e-6, 1e-4, 1e-8], B=[0, 0.7, 0],
                 P0=[4e4, 100, 100], name="hydraulic", states=[Quantity("oil", "kPa", 3.5e4), Quantity("flow", "l/min", 300), Quantity("offset", "kPa", 50)],
                 measurements=[Quantity("cylinder", "kPa", 3.6e4), Quantity("pump", "kPa", 3.6e4)], controls=[Quantity("valve", "V", 10)])


def lift() -> Model:
    """A cabin in a shaft of 500 m at 100 Hz, by its rope and an accelerometer that reads gravity, too"""
    return Model([[1, 0.01, -5e-5], [0, 1, -0.01], [0, 0, 1]], H=[1, 0, 0], R=4e-6, B=[5e-5, 0.01, 0], c=[-4.903325e-4, -0.0980665, 0],
                 Q=[[1e-12, 1e-10, 0], [1e-10, 4e-8, 0], [0, 0, 1e-12]], x0=[10, 0, 0], P0=[1, 0.01, 0.01], name="lift",
                 states=[Quantity("height", "m", 500), Quantity("speed", "m/s", 10), Quantity("bias", "m/s2", 1)],
                 measurements=[Quantity("rope", "m", 500)], controls=[Quantity("accelerometer", "m/s2", 30)])


def picoammeter() -> Model:
    """A current that wanders and what the cable leaks as it dries, which a shutter shows alone; 10 Hz"""
    return Model([[1, 0], [0, 0.99993]], H=[[1.02, 1], [0, 1]], R=[0.04, 1], Q=[1e-4, 1e-7], P0=[1e6, 1e4], name="picoammeter",
                 states=[Quantity("current", "pA", 2e4), Quantity("leak", "pA", 500)],
                 measurements=[Quantity("open", "pA", 2.1e4), Quantity("shutter", "pA", 600)])


def gpsdo() -> Model:
    """Phase, frequency and drift of an oven that GPS disciplines by a voltage, once a second"""
    return Model([[1, 1, 0.5], [0, 1, 1], [0, 0, 0.9999]], H=[1, 0, 0], R=100, B=[0.15, 0.3, 0], Q=[1e-4, 1e-6, 1e-12], P0=[1e8, 1e4, 1e-4], name="gpsdo",
                 states=[Quantity("phase", "ns", 1e6), Quantity("frequency", "ns/s", 1000), Quantity("drift", "ns/s2", 0.1)],
                 measurements=[Quantity("pps", "ns", 1e6)], controls=[Quantity("dac", "V", 5)], gaps=Gaps(20))


def calorimeter() -> Model:
    """Sample, can and jacket that exchange heat over minutes, in mK, heated by milliwatts; every 0.5 s"""
    A = [[1 - 1 / 240, 1 / 240, 0], [1 / 700, 1 - 1 / 700 - 1 / 3000, 1 / 3000], [0, 1 / 9000, 1 - 1 / 9000]]
    return Model(A, H=[[1, 0, 0], [0, 0, 1]], R=[0.25, 1], Q=[1e-6, 1e-6, 1e-5], B=[0.035, 0, 0], P0=[1e6] * 3, x0=[25000] * 3, name="calorimeter",
                 states=[Quantity(one, "mK", 6e4) for one in ("sample", "can", "jacket")], measurements=[Quantity("thermistor", "mK", 6e4), Quantity("bath", "mK", 6e4)],
                 controls=[Quantity("heater", "mW", 500)])


def truckscale() -> Model:
    """A weight, the creep of its cell over hours and an offset, by a cell and a display with correlated noise"""
    return Model([[1, 0, 0], [2e-6, 0.9998, 0], [0, 0, 1]], H=[[1, 1, 1], [1, 0, 0]], R=[[1, 0.6], [0.6, 4]], Q=[0.01, 1e-6, 1e-8], P0=[1e8, 1, 100],
                 name="truckscale", states=[Quantity("weight", "kg", 6e4), Quantity("creep", "kg", 600), Quantity("offset", "kg", 100)],
                 measurements=[Quantity("cell", "kg", 6.2e4), Quantity("display", "kg", 6.2e4)], d=[1200.3, 0])


PRODUCTS = (fridge, press, tilt, battery, barometer, load_cell, gps, clock, motor, tank, anemometer, heart, spring,
            meter, ultrasound, oven)
OTHERS = (drone, calendar, interferometer, borehole, scale, quartz, rover, well, pll, gnss_odo, bldc, thermistors, variometer)
FAR = (spindle, tide, airdata, hydraulic, lift, picoammeter, gpsdo, calorimeter, truckscale)
ALL = (*PRODUCTS, *OTHERS, *FAR)
