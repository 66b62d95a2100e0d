"""Nonlinear models of the textbooks, and filters and smoothers for them in the covariance form, in NumPy.

A model's f and h take a state, or many as columns, of complex numbers, so that a Jacobian is exact: that of its
imaginary part (Squire and Trapp, SIAM Review 40, 1998).
"""
from __future__ import annotations

import numpy as np
from scipy.special import chdtri

STEP = 1e-200


def angle(y, x):
    """atan2; of complex numbers with the derivative in the imaginary part"""
    if not (np.iscomplexobj(y) or np.iscomplexobj(x)):
        return np.arctan2(y, x)
    return np.arctan2(np.real(y), np.real(x)) + 1j * (np.real(x) * np.imag(y) - np.real(y) * np.imag(x)) / (
        np.real(x) ** 2 + np.real(y) ** 2)


def jacobian(function, x):
    """rows x n: d function / dx at x"""
    return np.imag(function(x[:, None] + 1j * STEP * np.eye(len(x)))) / STEP


def chance_band(freedom, chance=1e-3):
    """Where a chi-square of so much freedom, divided by it, is but for that chance"""
    return chdtri(freedom, 1 - chance / 2) / freedom, chdtri(freedom, chance / 2) / freedom


class Model:
    """x[t+1] = x + increment(x, t) + w, z = h(x, t) + v; components `angles` of z are angles, the states `position` are
    what errors are told of"""
    angles, position = (), (0,)
    steps = 60

    def measures(self, t):
        return True

    def increment(self, x, t):
        raise NotImplementedError

    def innovation(self, z, x, t):
        e = z - np.real(self.h(x, t))
        for c in self.angles:
            e[c] = (e[c] + np.pi) % (2 * np.pi) - np.pi
        return e

    def simulate(self, random):
        """True states (steps x n) and measurements (steps x m)"""
        x = self.true_start(random)
        states, z = [], []
        for t in range(self.steps):
            if t:
                x = x + np.real(self.increment(x, t - 1)) + self.noise(random)
            states.append(x)
            z.append(np.real(self.h(x, t)) + np.linalg.cholesky(self.R) @ random.standard_normal(len(self.R)))
        return np.array(states), np.array(z)

    def true_start(self, random):
        return self.x0 + np.sqrt(np.diag(self.P0)) * random.standard_normal(len(self.x0))

    def noise(self, random):
        values, vectors = np.linalg.eigh(self.Q)
        return vectors @ (np.sqrt(np.maximum(values, 0)) * random.standard_normal(len(values)))


class RangeBearing(Model):
    """Constant velocity past a radar at 20 m; m, m/s"""
    angles, position = (1,), (0, 1)

    def __init__(self, r=(0.5, 0.02), steps=60):
        self.x0, self.P0 = np.array([-150.0, 20, 5, 0]), np.diag([25.0, 25, 1, 1])
        self.Q = 0.05 * np.kron([[1 / 3, 1 / 2], [1 / 2, 1]], np.eye(2))
        self.R, self.steps = np.diag(np.square(r)), steps

    def increment(self, x, t):
        return np.array([x[2], x[3], 0 * x[2], 0 * x[3]])

    def h(self, x, t):
        return np.array([np.sqrt(x[0] ** 2 + x[1] ** 2), angle(x[1], x[0])])


class Battery(Model):
    """State of charge and the voltage of an RC pair, 10 s steps, the terminal voltage measured"""
    steps = 200

    def __init__(self):
        self.x0, self.P0 = np.array([0.8, 0.0]), np.diag([0.01, 1e-4])
        self.Q, self.R = np.diag([1e-10, 1e-8]), np.array([[1e-4]])

    def current(self, t):
        return 2 * (1 + np.sin(0.1 * t)) * (t % 40 < 30)

    def increment(self, x, t):
        return np.array([-10 * self.current(t) / 9000 + 0 * x[0],
                         (np.exp(-10 / 60) - 1) * x[1] + 0.02 * (1 - np.exp(-10 / 60)) * self.current(t)])

    def h(self, x, t):
        s = x[0]
        return np.array([3.3 + 0.9 * s - 0.15 * np.exp(-20 * s) + 0.1 * np.sin(6 * s) - x[1] - 0.03 * self.current(t)])


class GpsImu(Model):
    """Position, speed, heading, biases of the accelerometer and the gyro; 10 Hz, a position each second; m, s, rad"""
    steps, position = 300, (0, 1)

    def __init__(self):
        self.x0, self.P0 = np.array([500.0, -300, 10, 0.5, 0, 0]), np.diag([4, 4, 1, 0.04, 0.01, 1e-4])
        self.Q, self.R = np.diag([1e-6, 1e-6, 1e-4, 1e-6, 1e-8, 1e-10]), np.diag([4.0, 4.0])

    def measures(self, t):
        return t % 10 == 0

    def increment(self, x, t):
        turn, push = 0.2 * np.sin(0.02 * t), 0.5 * np.cos(0.05 * t)
        return 0.1 * np.array([x[2] * np.cos(x[3]), x[2] * np.sin(x[3]), push - x[4], turn - x[5], 0 * x[4], 0 * x[5]])

    def h(self, x, t):
        return np.array([x[0], x[1]])


class UnivariateGrowth(Model):
    """Of two minds: x and -x look the same (Kitagawa 1996)"""
    steps = 100

    def __init__(self):
        self.x0, self.P0 = np.array([0.0]), np.array([[5.0]])
        self.Q, self.R = np.array([[10.0]]), np.array([[1.0]])

    def increment(self, x, t):
        return -x / 2 + 25 * x / (1 + x ** 2) + 8 * np.cos(1.2 * (t + 1))

    def h(self, x, t):
        return x ** 2 / 20


class FallingBody(Model):
    """Altitude, speed, ballistic coefficient (Athans, Wishner and Bertolini 1968); ft, s; a radar's range.
    The literature's P0 of the coefficient is 1e-4; with 1e-3 the RMS are those of test_nonlinear_many.py."""
    steps, parts = 60, 64

    def __init__(self):
        self.x0, self.P0 = np.array([3e5, 2e4, 3e-5]), np.diag([1e6, 4e6, 1e-3])
        self.Q, self.R = np.zeros((3, 3)), np.array([[1e4]])

    def true_start(self, random):
        return np.array([3e5, 2e4, 1e-3])

    def increment(self, x, t):
        """`parts` steps of the classical Runge-Kutta method"""
        def slope(fallen, faster):
            speed = x[1] + faster
            return -speed, -np.exp(-5e-5 * (x[0] + fallen)) * speed * speed * x[2]

        p, v, k = 0 * x[0], 0 * x[1], 1 / self.parts
        for _ in range(self.parts):
            a = slope(p, v)
            b = slope(p + a[0] * k / 2, v + a[1] * k / 2)
            c = slope(p + b[0] * k / 2, v + b[1] * k / 2)
            d = slope(p + c[0] * k, v + c[1] * k)
            p += (a[0] + 2 * b[0] + 2 * c[0] + d[0]) * k / 6
            v += (a[1] + 2 * b[1] + 2 * c[1] + d[1]) * k / 6
        return np.array([p, v, 0 * x[2]])

    def h(self, x, t):
        return np.array([np.sqrt(1e10 + (x[0] - 1e5) ** 2)])


class CoordinatedTurn(Model):
    """An aircraft turns (Arasaratnam and Haykin 2009): position and velocity by axis, turn rate; m, s, rad"""
    steps, angles, position = 100, (1,), (0, 2)

    def __init__(self):
        self.x0 = np.array([1000, 300, 1000, 0, -np.pi / 60])
        self.P0 = np.diag([100, 10, 100, 10, 1e-4])
        block = 0.1 * np.array([[1 / 3, 1 / 2], [1 / 2, 1]])
        self.Q = np.zeros((5, 5))
        self.Q[:2, :2] = self.Q[2:4, 2:4] = block
        self.Q[4, 4] = 1.75e-4
        self.R = np.diag([100.0, 1e-5])

    def increment(self, x, t):
        w, s, c = x[4], np.sin(x[4]), np.cos(x[4])
        return np.array([s / w * x[1] - (1 - c) / w * x[3], (c - 1) * x[1] - s * x[3],
                         (1 - c) / w * x[1] + s / w * x[3], s * x[1] + (c - 1) * x[3], 0 * w])

    def h(self, x, t):
        return np.array([np.sqrt(x[0] ** 2 + x[2] ** 2), angle(x[2], x[0])])


# ------------------------------------------------------------------ the references


def upper_root(P):
    return np.linalg.cholesky(P[::-1, ::-1])[::-1, ::-1]


def linearise_extended(function, x, P):
    return np.real(function(x + 0j)), jacobian(function, x), 0


def linearise_cubature(function, x, P):
    n = len(x)
    S = np.sqrt(n) * upper_root(P)
    points = np.concatenate([S.T, -S.T])
    values = np.real(function(x[:, None] + points.T)).T
    mean = values.mean(0)
    cross = (values - mean).T @ points / (2 * n)
    J = np.linalg.solve(P, cross.T).T
    return mean, J, (values - mean).T @ (values - mean) / (2 * n) - J @ P @ J.T


def run(model, z, linearise):
    """Filtered and smoothed means and covariances: by the gains K and G of the textbooks"""
    x, P, identity = model.x0.copy(), model.P0.copy(), np.eye(len(model.x0))
    filtered, predicted, A_of = [], [], []
    for t in range(model.steps):
        if t:
            d, J, left = linearise(lambda y: model.increment(y, t - 1), x, P)
            A = J + identity
            x, P = x + d, A @ P @ A.T + left + model.Q
            predicted.append((x, P))
            A_of.append(A)
        if model.measures(t):
            mean, H, left = linearise(lambda y: unwrapped(model, y, x, t), x, P)
            S = H @ P @ H.T + left + model.R
            K = np.linalg.solve(S, H @ P).T
            x = x + K @ wrapped(model, z[t] - mean)
            P = P - K @ S @ K.T
            P = (P + P.T) / 2
        filtered.append((x, P))
    smoothed = [filtered[-1]]
    for t in range(model.steps - 2, -1, -1):
        x, P = filtered[t]
        xp, Pp = predicted[t]
        scale = 1 / np.sqrt(np.diag(Pp))
        G = (np.linalg.solve(Pp * np.outer(scale, scale), (A_of[t] @ P) * scale[:, None]) * scale[:, None]).T
        xs, Ps = smoothed[0]
        smoothed.insert(0, (x + G @ (xs - xp), P + G @ (Ps - Pp) @ G.T))
    return filtered, smoothed


def wrapped(model, e):
    e = np.array(e)
    for c in model.angles:
        e[c] = (e[c] + np.pi) % (2 * np.pi) - np.pi
    return e


def unwrapped(model, y, centre, t):
    """h(y), its angles around those at the centre"""
    value, at = model.h(y, t), np.real(model.h(centre, t))
    for c in model.angles:
        value[c] -= 2 * np.pi * np.round((np.real(value[c]) - at[c]) / (2 * np.pi))
    return value
