"""How sharply the records determine the parameters: the observed information, from differences of the gradient."""

from __future__ import annotations

import copy
from typing import Iterator

import numpy as np

from kalmanq.fitting.problem import Problem

STEP = 1e-3  # of a coordinate: the third derivatives then count for 1e-6 of the second
FLAT = 1e-4  # curvature, times the rows, below which a direction counts as undetermined: a standard error of e^70
CURVED = 1e-5  # the largest curvature upwards that may be flat
ROUNDING = 1e-8  # of a curvature


class Information:
    """At x, in the coordinates that are not at the `edge` (a mask): J = -d gradient / dx, and its eigenvalues.

    distance      g' J^-1 g / 2: what is left of the log-likelihood, where it is a parabola; NaN where it is none
    undetermined  directions (k x d, whole coordinates) along which the likelihood is flat
    """

    def __init__(self, problem: Problem, x: np.ndarray, slopes: np.ndarray, edge: np.ndarray):
        self.problem, self.edge = problem, edge
        self.inside = np.flatnonzero(~edge)
        self.slopes = slopes[self.inside]
        columns = [self._column(x, int(k)) for k in self.inside]
        J = np.array(columns).reshape(len(columns), len(columns))
        self.is_finite = bool(np.all(np.isfinite(J)))
        self.J = (J + J.T) / 2
        self.values, self.vectors = np.linalg.eigh(self.J) if self.is_finite else (
            np.full(len(J), np.nan), np.eye(len(J)))
        self.limit = FLAT / problem.records.steps + ROUNDING

    @property
    def is_flat(self) -> np.ndarray:
        return np.abs(self.values) <= self.limit

    def holding(self, edge: np.ndarray) -> Information:
        """That on the others, where what is at `edge`, too, stays."""
        made, keep = copy.copy(self), ~edge[self.inside]
        made.edge, made.inside, made.slopes = edge, self.inside[keep], self.slopes[keep]
        made.J = self.J[np.ix_(keep, keep)]
        made.values, made.vectors = np.linalg.eigh(made.J) if self.is_finite else (
            np.full(len(made.J), np.nan), np.eye(len(made.J)))
        return made

    def take_for_flat(self) -> None:
        """What is curved upwards by so little that no step along it has found a higher place."""
        self.limit = max(self.limit, min(-1.01 * float(self.values[0]), CURVED))

    def _column(self, x: np.ndarray, k: int) -> np.ndarray:
        """Minus the second derivatives to coordinate k and each other."""
        move = np.zeros_like(x)
        move[k] = STEP
        ahead, behind = (self.problem.slopes_at(x + sign * move)[self.inside] for sign in (1, -1))
        return (behind - ahead) / (2 * STEP)

    @property
    def is_maximum(self) -> bool:
        """Positive definite but for what is flat?"""
        return self.is_finite and bool(np.all(self.values > -self.limit))

    @property
    def distance(self) -> float:
        if not self.is_maximum:
            return float("nan")
        steep = ~self.is_flat
        along = self.vectors.T @ self.slopes
        return float(np.sum(along[steep] ** 2 / self.values[steep]) / 2 + np.sum(np.abs(along[~steep])))

    def newton(self) -> np.ndarray:
        """The step to the top of the parabola, in all coordinates."""
        steep = ~self.is_flat
        along = (self.vectors.T @ self.slopes)[steep] / self.values[steep]
        return self.whole(self.vectors[:, steep] @ along)

    def uphill(self) -> np.ndarray:
        """The direction of the slope, of length 1, among those in which the likelihood is flat; 0 without a slope."""
        flat = self.vectors[:, self.is_flat]
        slope = flat @ (flat.T @ self.slopes)
        return self.whole(slope / max(float(np.linalg.norm(slope)), 1e-300))

    def downhill(self) -> np.ndarray:
        """The direction in which the likelihood is curved upwards most."""
        return self.whole(self.vectors[:, 0])

    def whole(self, part: np.ndarray) -> np.ndarray:
        made = np.zeros(len(self.edge))
        made[self.inside] = part
        return made

    def covariance(self) -> np.ndarray:
        """Of the coordinates; 0 for what is at the edge or flat."""
        steep = ~self.is_flat
        root = self.vectors[:, steep] / np.sqrt(self.values[steep])
        made = np.zeros((len(self.edge), len(self.edge)))
        made[np.ix_(self.inside, self.inside)] = root @ root.T
        return made

    def flat(self) -> Iterator[tuple[float, np.ndarray]]:
        """Curvature and direction."""
        for k in np.flatnonzero(self.is_flat):
            yield float(self.values[k]), self.whole(self.vectors[:, k])
