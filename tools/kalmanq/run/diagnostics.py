"""Do data, or errors, fit the model?  Scores, and the bounds that they stay within where it is right."""

from __future__ import annotations

import numpy as np

from kalmanq.run.results import Run

# What is less than this of the largest eigenvalue of a correlation matrix is rounding, not variance.
ROUNDING = {"f32": 1e-5, "f64": 1e-12, "q31": 1e-7}


def chi_square_limit(probability: float, freedom: np.ndarray) -> np.ndarray:
    """What chi-square of so many degrees of freedom stays below with this probability."""
    from scipy import special  # late, here and below: what draws and filters needs no SciPy

    return 2 * special.gammaincinv(np.asarray(freedom) / 2, probability)


def mean_bounds(freedom: int) -> tuple[float, float]:
    """Of chi-square over its degrees of freedom: 95 %."""
    low, high = chi_square_limit(np.array([0.025, 0.975]), np.array([freedom, freedom])) / freedom
    return float(low), float(high)


def student_limit(freedom: int) -> float:
    from scipy import special

    return float(special.stdtrit(freedom, 0.975))


def share_bounds(count: int) -> tuple[float, float]:
    """Of the share of `count` trials of 5 % that succeed: 95 % of all cases are within."""
    from scipy import special

    successes = np.arange(count + 1)
    at_most = special.bdtr(successes, count, 0.05)
    low, high = np.searchsorted(at_most, [0.025, 0.975])
    return float(low / count), float(high / count)


def is_scored(run: Run, z: np.ndarray) -> np.ndarray:
    """The rows whose NIS is chi-square of `taken` degrees of freedom.

    A measurement that finds something of an unknown start adds nothing to the NIS: until all that is measured is
    known, rows are not scored.
    """
    return (run.taken > 0) & np.all(np.isnan(z) | np.isfinite(run.innovation_sigma), axis=1)


def nees(errors: np.ndarray, covariances: np.ndarray, arithmetic: str) -> tuple[np.ndarray, np.ndarray]:
    """e' P^-1 e of each row and its dimensions; in directions without variance nothing is scored.

    errors T x n, covariances T x n x n; a row with something unknown (NaN) has 0 dimensions.
    """
    known = np.all(np.isfinite(covariances), axis=(1, 2)) & np.all(np.isfinite(errors), axis=1)
    sigma = np.sqrt(np.maximum(np.diagonal(covariances, axis1=1, axis2=2), 0.0))
    unit = np.where(known[:, None] & (sigma > 0), sigma, 1.0)  # so that the units of states are no matter
    correlation = covariances / (unit[:, :, None] * unit[:, None, :])
    values, vectors = np.linalg.eigh(np.where(known[:, None, None], correlation, 0.0))
    scored = values > ROUNDING[arithmetic] * np.maximum(values[:, -1:], 0.0)
    along = np.einsum("tij,ti->tj", vectors, np.where(known[:, None], errors / unit, 0.0))
    score = np.sum(np.where(scored, along**2 / np.where(scored, values, 1.0), 0.0), axis=1)
    return score, np.sum(scored, axis=1)


def autocorrelation(series: np.ndarray, lags: int) -> tuple[np.ndarray, np.ndarray]:
    """Of lags 1 .. lags, and how many pairs each is of; NaN: missing, the mean is taken off."""
    known = ~np.isnan(series)
    centred = np.where(known, series - (np.mean(series[known]) if np.any(known) else 0.0), 0.0)
    count, power = int(known.sum()), float(centred @ centred)
    pairs = np.array([int(np.sum(known[k:] & known[:-k])) for k in range(1, lags + 1)], int)
    products = np.array([float(centred[k:] @ centred[:-k]) for k in range(1, lags + 1)])
    with np.errstate(invalid="ignore", divide="ignore"):
        return (products / pairs) / (power / count if count else np.nan), pairs


def ljung_box(correlation: np.ndarray, pairs: np.ndarray, count: int) -> float:
    """The probability of such correlations, or larger ones, where there are none.

    With no row missing it is the test of Ljung and Box, sum T (T + 2) / (T - k) r_k^2 with
    r_k = correlation (T - k) / T; missing rows leave fewer pairs.
    """
    from scipy import special

    used = np.isfinite(correlation)
    if count < 2 or not np.any(used):
        return float("nan")
    statistic = np.sum((count + 2) / count * pairs[used] * correlation[used] ** 2)
    return float(special.chdtrc(int(used.sum()), statistic))
