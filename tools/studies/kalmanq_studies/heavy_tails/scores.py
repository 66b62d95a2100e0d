"""Errors with their standard errors, from the mean square and the mean size of the errors of each run."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

RESAMPLES = 200
DECIMALS = 4


@dataclass(frozen=True)
class Figure:
    value: float
    error: float  # standard

    def __format__(self, spec: str) -> str:
        """As many decimals as the standard error has a meaning to: two digits of it."""
        if not self.error > 0:
            return f"{self.value:.3g}"
        decimals = int(np.clip(np.ceil(1 - np.log10(self.error)), 0, DECIMALS))
        return f"{self.value:.{decimals}f} ± {self.error:.{decimals}f}"

    def __str__(self) -> str:
        return format(self, "")

    def above(self) -> Figure:
        """Of a ratio: per cent above 1"""
        return Figure(100 * (self.value - 1), 100 * self.error)


def mean(values: np.ndarray) -> Figure:
    return Figure(float(np.mean(values)), float(np.std(values, ddof=1) / np.sqrt(len(values))))


def root(figure: Figure) -> Figure:
    value = float(np.sqrt(figure.value))
    return Figure(value, figure.error / (2 * value))


def error_of(columns: dict[str, np.ndarray], kind: str, metric: str) -> Figure:
    """kind: filter, smoother, measured; metric: RMSE, MAE.  For alpha < 2 the standard error of an RMSE is that of the
    runs that were drawn: a sample does not show how wide a law without variance spreads."""
    return root(mean(columns[f"{kind}_square"])) if metric == "RMSE" else mean(columns[f"{kind}_size"])


def ratio_of(over: np.ndarray, under: np.ndarray) -> Figure:
    """Of two means over the same runs, or over runs of the same random numbers"""
    value = float(np.mean(over) / np.mean(under))
    spread = mean(over - value * under)
    return Figure(value, spread.error / float(np.mean(under)))


def relative(over: dict[str, np.ndarray], under: dict[str, np.ndarray], kind: str, metric: str,
             under_kind: str = "") -> Figure:
    """The error of one estimator over that of another"""
    column = "square" if metric == "RMSE" else "size"
    made = ratio_of(over[f"{kind}_{column}"], under[f"{under_kind or kind}_{column}"])
    return root(made) if metric == "RMSE" else made


def median(values: np.ndarray) -> Figure:
    """With half the distance of the order statistics a standard deviation of the count on either side"""
    ordered, count = np.sort(values), len(values)
    low, high = (int(np.clip(np.rint(count / 2 + sign * np.sqrt(count) / 2), 0, count - 1)) for sign in (-1, 1))
    return Figure(float(np.median(ordered)), float(ordered[high] - ordered[low]) / 2)


def crossing(alphas: np.ndarray, ratios: np.ndarray) -> float:
    """Where ratios pass 1 from above, counted from alpha = 2 downwards; NaN: nowhere"""
    for k in range(len(alphas) - 1, 0, -1):
        if ratios[k] < 1 <= ratios[k - 1]:
            share = (ratios[k - 1] - 1) / (ratios[k - 1] - ratios[k])
            return float(alphas[k - 1] + share * (alphas[k] - alphas[k - 1]))
    return float("nan")


def crossing_of(alphas: np.ndarray, over: np.ndarray, under: np.ndarray) -> Figure:
    """over, under: alphas x runs, of the same random numbers at each alpha; resampled over runs"""
    random = np.random.default_rng(0)
    runs = over.shape[1]
    drawn = [random.multinomial(runs, np.full(runs, 1 / runs)) for _ in range(RESAMPLES)]
    made = np.array([crossing(alphas, (over @ count) / (under @ count)) for count in drawn])
    return Figure(crossing(alphas, over.sum(1) / under.sum(1)), float(np.nanstd(made, ddof=1)))
