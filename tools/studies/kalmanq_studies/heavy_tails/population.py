"""What no number of runs has to be waited for: the mean error of a filter and a smoother with known parameters.

Both are linear, so that the error of a row is a sum of the steps w and the noises v with weights, a stable variable and
a Gaussian one, and its mean size follows from its characteristic function (von Bahr, Ann. Math. Statist. 36, 1965):

    E|e| = 2 / pi  integral over k > 0 of (1 - Re phi(k)) / k^2           finite for alpha > 1
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from scipy.integrate import trapezoid
from scipy.optimize import brentq

from kalmanq.run.steady import steady_state
from kalmanq_studies.heavy_tails import estimators
from kalmanq_studies.heavy_tails.settings import Setting

LN_K = np.arange(-40, 12, 0.05)
KINDS = ("filter", "smoother")


@lru_cache(maxsize=None)
def weights(setting: Setting, kind: str) -> tuple[np.ndarray, np.ndarray]:
    """rows x rows each: of w (the state before the first measurement first) and of v in the error of each row.
    They are what the C core answers to one step, or one noise, of size 1."""
    place = KINDS.index(kind)
    steps = np.triu(np.ones((setting.rows, setting.rows)))
    of_steps, of_noise = (estimators.known(setting, given)[place] for given in (steps, np.eye(setting.rows)))
    return (of_steps - steps).T, of_noise.T


def mean_size(setting: Setting, kind: str, alpha: float, beta: float = 0.0) -> float:
    """E|error|, the mean over all rows; alpha > 1"""
    of_steps, of_noise = weights(setting, kind)
    powers = np.abs(of_steps) ** alpha
    scale = (setting.sigma**alpha) * powers.sum(axis=1)
    skew = beta * (np.sign(of_steps) * powers).sum(axis=1) / powers.sum(axis=1)
    variance = (of_noise**2).sum(axis=1)
    made = [_mean_size(of_step, of_noise, alpha, lean)
            for of_step, of_noise, lean in zip(scale, variance, skew * np.tan(np.pi * alpha / 2))]
    return float(np.mean(made))


def _mean_size(scale: float, variance: float, alpha: float, lean: float) -> float:
    """By the trapezoid rule in ln k; below it 1 - Re phi is scale k^alpha, above it 1.  scale: sigma^alpha"""
    k = np.exp(LN_K)
    size, turn = scale * k**alpha + 0.5 * variance * k**2, scale * lean * k**alpha
    missing = -np.expm1(-size) + 2 * np.exp(-size) * np.sin(turn / 2) ** 2
    inside = trapezoid(missing / k, LN_K)
    return 2 / np.pi * (inside + scale * k[0] ** (alpha - 1) / (alpha - 1) + 1 / k[-1])


def crossing(setting: Setting) -> float:
    """The alpha where smoother and filter have the same mean error"""
    return float(brentq(lambda alpha: mean_size(setting, "smoother", alpha) - mean_size(setting, "filter", alpha),
                        1.02, 1.98, xtol=1e-4))


def jump_ratio(weight: float) -> float:
    """RMSE of the smoother over that of the filter where the squares are those of a few large jumps, as they are for
    every alpha < 2 if there are runs enough.

    With the settled weight K of a measurement, the filter's error j rows after a jump is r^(j+1) of it, r = 1 - K, and
    the smoother's r^(j+1) / (1 + r) after it as before it: the squares have the ratio 2 / (1 + r)^2.
    """
    return float(np.sqrt(2) / (2 - weight))


def settled_weight(setting: Setting) -> float:
    return float(steady_state(setting.model()).gain[0, 0])


def even_ratio() -> float:
    """Q / R where jump_ratio is 1: below it smoothing gains in RMSE, too"""
    weight = 2 - np.sqrt(2)
    return float(weight**2 / (1 - weight))
