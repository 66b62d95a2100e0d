"""What all tasks came to, by setting, noise and estimator; and as a table."""

from __future__ import annotations

from typing import Any, Iterable, Iterator, NamedTuple, Optional, Sequence

import numpy as np

from kalmanq_studies.heavy_tails import scores
from kalmanq_studies.heavy_tails.scores import Figure
from kalmanq_studies.heavy_tails.settings import Task

GAUSSIAN = 2.0  # alpha
KINDS = ("filter", "smoother")
ESTIMATES = ("Q", "R", "H", "A", "P", "K")
HEADER = ("part", "Q_over_R", "rows", "runs", "alpha", "beta", "estimator", "of", "rmse", "rmse_error", "mae",
          "mae_error", "converged", *(f"{name}_{share}" for name in ESTIMATES for share in ("low", "median", "high")))


class Key(NamedTuple):
    part: str
    ratio: float
    alpha: float
    beta: float
    estimator: str


class Collected:
    """Columns over all runs of a key: `collected.of("known", 2.0, 1.3)["filter_square"]`."""

    def __init__(self, tasks: Sequence[Task], results: Iterable[dict[str, dict[str, list[float]]]]):
        found: dict[Key, dict[str, list[float]]] = {}
        self.rows = {task.setting.ratio: task.setting.rows for task in tasks}
        for task, result in zip(tasks, results):
            for name, columns in result.items():
                of = found.setdefault(Key(task.part, task.setting.ratio, task.alpha, task.beta, name), {})
                for column, values in columns.items():
                    of.setdefault(column, []).extend(values)
        self.columns = {key: {column: np.array(values, float) for column, values in of.items()}
                        for key, of in found.items()}

    def of(self, part: str, ratio: float, alpha: float, estimator: str = "known",
           beta: float = 0.0) -> dict[str, np.ndarray]:
        return self.columns[Key(part, ratio, alpha, beta, estimator)]

    def alphas(self, part: str) -> np.ndarray:
        return np.array(sorted({key.alpha for key in self.columns if key.part == part}))

    def betas(self) -> np.ndarray:
        return np.array(sorted({key.beta for key in self.columns if key.part == "skewed"}))

    def estimators(self, part: str, kind: str = "filter") -> list[str]:
        return list(dict.fromkeys(key.estimator for key, of in self.columns.items()
                                  if key.part == part and f"{kind}_square" in of))

    def runs(self, part: str) -> int:
        return next(len(of["filter_square"]) for key, of in self.columns.items() if key.part == part)

    def beside_gaussian(self, part: str, ratio: float, alpha: float, estimator: str, metric: str,
                        kind: str = "filter") -> Figure:
        """The error over that of the filter with known parameters at alpha = 2, from the same random numbers"""
        return scores.relative(self.of(part, ratio, alpha, estimator), self.of(part, ratio, GAUSSIAN), kind, metric,
                               under_kind="filter")

    def beside_exact(self, ratio: float, alpha: float, estimator: str, metric: str, kind: str) -> Figure:
        return scores.relative(self.of("robust", ratio, alpha, estimator), self.of("robust", ratio, alpha, "exact"),
                               kind, metric)

    def table(self) -> Iterator[list[Any]]:
        """Rows under HEADER, of six digits"""
        for key, of in self.columns.items():
            for kind in KINDS:
                if f"{kind}_square" in of:
                    rmse, mae = (scores.error_of(of, kind, metric) for metric in ("RMSE", "MAE"))
                    numbers = [rmse.value, rmse.error, mae.value, mae.error,
                               float(np.mean(of["converged"])) if "converged" in of else None, *_estimates(of)]
                    yield [key.part, f"{key.ratio:g}", self.rows[key.ratio], len(of[f"{kind}_square"]),
                           f"{key.alpha:g}", f"{key.beta:g}", key.estimator, kind,
                           *("" if number is None else f"{number:.6g}" for number in numbers)]


def _estimates(of: dict[str, np.ndarray]) -> list[Optional[float]]:
    """Quartiles: estimates have tails, too"""
    return [value for name in ESTIMATES
            for value in (np.quantile(of[name], (0.25, 0.5, 0.75)).tolist() if name in of else [None] * 3)]
