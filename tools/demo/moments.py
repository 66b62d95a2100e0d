"""Noise levels q and r by the method of moments: differences remove the level (or the position
and the velocity), and what is left has variances that are known functions of q and r.

Local level, first differences d[t] = z[t+1] - z[t] = w + v' - v:

    c0 = var d = q + 2 r        c1 = cov(d[t], d[t+1]) = -r

Constant velocity, second differences s[t] = z[t+2L] - 2 z[t+L] + z[t] over a stride of L steps,
that is over h = L dt:

    var s = 6 r + (2/3) q h^3   cov(s[t], s[t+L]) = -4 r + (1/6) q h^3

r is taken from L = 1, where the noise of the measurements stands out; q from the shortest stride
at which the motion does (or the longest that the data allow).
"""

from __future__ import annotations

import math

import numpy as np

FEWEST = 4  # products that a moment is averaged over
SMALLEST = 1e-4  # of the variance of the differences: no estimate is below it


class TooFewData(Exception):
    """There are too few differences between measurements."""


def local_level(z: np.ndarray, q: float | None, r: float | None) -> tuple[float, float]:
    """q per step and r; what is given is kept."""
    if q is not None and r is not None:
        return q, r
    d = z[1:] - z[:-1]
    c0 = mean_product(d, d) or tiny(z)
    if r is not None:
        return max(c0 - 2 * r, SMALLEST * c0), r
    if q is not None:
        return q, max((c0 - q) / 2, SMALLEST * c0)
    c1 = mean_product(d[1:], d[:-1])
    return max(c0 + 2 * c1, SMALLEST * c0), max(-c1, SMALLEST * c0)


def constant_velocity(
    z: np.ndarray, dt: float, q: float | None, r: float | None
) -> tuple[float, float]:
    """Spectral density q and r of one axis; what is given is kept."""
    if q is not None and r is not None:
        return q, r
    s = second_difference(z, 1)
    c0 = mean_product(s, s) or tiny(z)
    if q is not None:
        return q, max((c0 - q * dt**3 * 2 / 3) / 6, SMALLEST * c0)
    if r is None:
        r = max((c0 - 4 * mean_product(s[1:], s[:-1])) / 22, SMALLEST * c0)
    return motion_density(z, dt, r), r


def motion_density(z: np.ndarray, dt: float, r: float) -> float:
    """q, from the shortest stride at which the motion is as large as the noise."""
    stride = 1
    variance = stride_variance(z, stride)
    while variance < 12 * r and 8 * stride <= len(z):
        try:
            variance = stride_variance(z, 2 * stride)
        except TooFewData:
            break
        stride *= 2
    density = 1.5 * max(variance - 6 * r, 0.01 * r)
    return density / (stride * dt) ** 3


def stride_variance(z: np.ndarray, stride: int) -> float:
    s = second_difference(z, stride)
    return mean_product(s, s)


def second_difference(z: np.ndarray, stride: int) -> np.ndarray:
    return z[2 * stride :] - 2 * z[stride:-stride] + z[: -2 * stride]


def mean_product(a: np.ndarray, b: np.ndarray) -> float:
    """The mean of a b over the pairs where neither is missing."""
    products = a * b
    products = products[~np.isnan(products)]
    if len(products) < FEWEST:
        raise TooFewData
    return float(products.mean())


def tiny(z: np.ndarray) -> float:
    """A variance for data that do not vary at all: a millionth of their size, squared."""
    size = float(np.nanmax(np.abs(z)))
    return (1e-6 * size) ** 2 if size > 0 and math.isfinite(size) else 1e-12
