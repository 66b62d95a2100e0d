"""Alpha-stable noise S(alpha, beta, sigma): drawn, its characteristic function and its density.

Parameters are those of Samorodnitsky and Taqqu (Stable Non-Gaussian Random Processes, 1994): 0 < alpha <= 2,
-1 <= beta <= 1, location 0.  alpha = 2 is Gaussian with variance 2 sigma^2, alpha = 1 with beta = 0 is Cauchy's.  For
alpha > 1 the mean is 0; for alpha < 2 there is no variance.
"""

from __future__ import annotations

from typing import Union

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import gammaln

HALF_PI = np.pi / 2


def draw(random: np.random.Generator, size: Union[int, tuple[int, ...]], alpha: float, beta: float = 0.0,
         sigma: float = 1.0) -> np.ndarray:
    """Chambers, Mallows and Stuck (J. Amer. Statist. Assoc. 71, 1976), as corrected by Weron (Statistics and
    Probability Letters 28, 1996)."""
    _require(alpha, beta, sigma)
    angle = random.uniform(-HALF_PI, HALF_PI, size)
    wait = random.standard_exponential(size)
    if alpha == 1:
        turned = HALF_PI + beta * angle
        shape = (turned * np.tan(angle) - beta * np.log(HALF_PI * wait * np.cos(angle) / turned)) / HALF_PI
        return sigma * (shape + beta * np.log(sigma) / HALF_PI)
    skew = beta * np.tan(HALF_PI * alpha)
    turned = alpha * angle + np.arctan(skew)
    scale = sigma * (1 + skew**2) ** (0.5 / alpha)
    return scale * (np.sin(turned) / np.cos(angle) ** (1 / alpha)
                    * (np.cos(angle - turned) / wait) ** ((1 - alpha) / alpha))


def characteristic(k: ArrayLike, alpha: float, beta: float = 0.0, sigma: float = 1.0) -> np.ndarray:
    """E exp(i k X), complex, for each k."""
    _require(alpha, beta, sigma)
    given = np.asarray(k, float)
    size = np.abs(sigma * given)
    if alpha == 1:
        with np.errstate(divide="ignore", invalid="ignore"):
            lean = np.where(given == 0, 0, -np.log(np.abs(given)) / HALF_PI)
    else:
        lean = np.tan(HALF_PI * alpha)
    return np.exp(-(size**alpha) * (1 - 1j * beta * np.sign(given) * lean))


def _require(alpha: float, beta: float, sigma: float) -> None:
    if not (0 < alpha <= 2 and -1 <= beta <= 1 and sigma > 0):
        raise ValueError(f"S({alpha}, {beta}, {sigma}) is no stable law")


# ------------------------------------------------------------------------------ the density where beta = 0

FAR = 20.0  # from where the series of the tail is right to 1e-6 for alpha of 1.1 or more
STEP = 1e-3  # of the inversion, in the root of k
TERMS = 6  # of the tail's series


def density(x: ArrayLike, alpha: float, sigma: float = 1.0) -> np.ndarray:
    """The density of S(alpha, 0, sigma), 1 <= alpha <= 2."""
    size = np.abs(np.asarray(x, float)) / sigma
    if alpha == 2:
        return np.exp(-(size**2) / 4) / np.sqrt(4 * np.pi) / sigma
    made = np.empty(size.shape)
    near = size < FAR
    made[near] = _inverted(size[near], alpha)
    made[~near] = _tail(size[~near], alpha)
    return made / sigma


def _inverted(x: np.ndarray, alpha: float) -> np.ndarray:
    """The Fourier integral of exp(-k^alpha) with k = u^2, by the trapezoid rule, corrected for the slope at u = 0."""
    u = np.arange(STEP, 36 ** (0.5 / alpha), STEP)
    weights = np.exp(-(u ** (2 * alpha))) * 2 * u
    made = [np.cos(np.outer(part, u * u)) @ weights for part in np.array_split(x, 1 + len(x) // 256)]
    return (np.concatenate(made) + STEP / 6) * STEP / np.pi


def _tail(x: np.ndarray, alpha: float) -> np.ndarray:
    """Bergström's series in 1 / x, which for alpha > 1 is asymptotic (Arkiv för Matematik 2, 1952)."""
    j = np.arange(1, TERMS + 1)
    factors = (-1.0) ** (j + 1) * np.exp(gammaln(alpha * j + 1) - gammaln(j + 1)) * np.sin(j * HALF_PI * alpha)
    return (x[..., None] ** (-alpha * j - 1)) @ factors / np.pi
