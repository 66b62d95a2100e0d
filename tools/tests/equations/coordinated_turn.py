"""A turn of unknown rate, by range and bearing once a second (Arasaratnam and Haykin 2009)"""
import numpy as np

states = {"names": ["east", "north", "v east", "v north", "turn"], "units": ["m", "m", "m/s", "m/s", "rad/s"]}
measurements, angles = ["range", "bearing"], ["bearing"]
x0, P0 = [1000, 1000, 300, 0, -np.pi / 60], [100, 100, 10, 10, 1e-4]
Q, R = np.zeros((5, 5)), [100, 1e-5]
Q[:4, :4] = np.kron([[0.1 / 3, 0.05], [0.05, 0.1]], np.eye(2))
Q[4, 4] = 1.75e-4


def f(x):
    w = x[4]
    if abs(w) > 1e-2:  # nearer to 0 a float loses the derivatives of quotients
        ahead, aside = np.sin(w) / w, 2 * np.sin(w / 2) ** 2 / w
    else:
        ahead, aside = 1 - w * w / 6, w / 2 - w ** 3 / 24
    s, c = np.sin(w), np.cos(w)
    return np.array([x[0] + ahead * x[2] - aside * x[3], x[1] + aside * x[2] + ahead * x[3],
                     c * x[2] - s * x[3], s * x[2] + c * x[3], w])


def h(x):
    return np.hypot(x[0], x[1]), np.arctan2(x[1], x[0])
