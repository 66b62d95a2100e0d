"""Records at irregular times: the spectral density Qc, and R, under which they are most likely.

By the filter's likelihood, its differences, and BFGS; then Newton's steps by the information at the top.
"""

from __future__ import annotations

from typing import Any, Callable, NamedTuple, Optional, Sequence

import numpy as np

from kalmanq.data.rows import Rows
from kalmanq.errors import KalmanqError
from kalmanq.fitting.coordinates import Cholesky, Infeasible, Multiple
from kalmanq.fitting.noise import is_definite
from kalmanq.fitting.problem import STENCIL
from kalmanq.model import Model
from kalmanq.run.filters import Filter

STEP, CURVE = 0.02, 0.05  # of a coordinate, in which 1 is about a standard error: of slopes, of curvatures
NEWTON = 10  # steps at most
FAR = 60.0  # coordinates that have gone so far are going to 0 or without an end


class Found(NamedTuple):
    """As the fields of a Fit"""

    model: Model
    log_likelihood: float
    standard_errors: dict[str, np.ndarray]
    evaluations: int
    course: list[float]
    converged: bool
    distance: float
    message: str


def fit_densities(model: Model, records: Sequence[Rows], free: Sequence[str], forms: dict[str, str], iterations: int,
                  tolerance: float, report: Optional[Callable[[int, float], None]] = None) -> Found:
    """free: of Q, which is Qc here, and R; forms: of both"""
    problem = Densities(model, records, free, forms, report)
    x, course = _climbed(problem, iterations)
    slopes, J, left = problem.slopes(x), problem.information(x), np.nan
    for _ in range(NEWTON):
        values, vectors = np.linalg.eigh(J) if np.all(np.isfinite(J)) else (np.full(1, np.nan), J)
        if not values[0] > 0:
            break
        step = vectors @ ((vectors.T @ slopes) / values)
        left = float(slopes @ step / 2)
        if left <= tolerance / 10:
            break
        x = x + step
        slopes, J = problem.slopes(x), problem.information(x)
    value = problem.value(x)
    course.append(value)
    is_top = bool(left <= tolerance) and np.max(np.abs(x * problem.units), initial=0) < FAR
    said = f"at the maximum: about {max(left, 1e-12):.1g} of log-likelihood is left" if is_top else \
        "no maximum: a variance goes to 0 or without an end; hold it by --q-form or --r-form multiple, or leave it out of --free"
    errors = problem.errors(np.linalg.inv(J)) if is_top else {}
    return Found(problem.model_at(x), value, errors, problem.evaluations, course, is_top, left, said)


def _climbed(problem: Densities, iterations: int) -> tuple[np.ndarray, list[float]]:
    from scipy.optimize import minimize

    course: list[float] = []

    def downhill(x: np.ndarray) -> tuple[float, np.ndarray]:
        value = problem.value(x)
        course.append(value)
        return (-value, -problem.slopes(x)) if np.isfinite(value) else (1e300, np.zeros(len(x)))

    found = minimize(downhill, np.zeros(problem.size), jac=True, method="BFGS", options={"maxiter": iterations, "gtol": 1e-3})
    return found.x, course


class Densities:
    """The log-likelihood in coordinates around the model's Qc and R"""

    def __init__(self, model: Model, records: Sequence[Rows], free: Sequence[str], forms: dict[str, str],
                 report: Optional[Callable[[int, float], None]]):
        for name in free:
            if name not in ("Q", "R"):
                raise KalmanqError(f"{name} of records at irregular times is not fitted, Q (that is Qc) and R are: leave it out "
                                   "of --free; --time none takes each row for a step of dt")
        self.model, self.records, self.report, self.evaluations = model, records, report, 0
        rows = sum(map(len, records))
        whole = {"Q": model.continuous.Qc, "R": model.R}
        self.whole = {name: whole[name] for name in ("Q", "R") if name in free}
        self.axes = {name: np.flatnonzero(np.diag(one) > 0) for name, one in self.whole.items()}
        self.blocks = [self._block(name, forms[name], rows) for name in self.whole]
        ends = np.cumsum([0, *(block.size for block in self.blocks)])
        self.slices = [slice(a, b) for a, b in zip(ends, ends[1:])]
        self.size = int(ends[-1])
        self.units = np.concatenate([np.where(block.logarithmic, block.units, 0) for block in self.blocks])

    def _block(self, name: str, form: str, rows: int) -> Any:
        axes = self.axes[name]
        start = self.whole[name][np.ix_(axes, axes)]
        said = "Qc" if name == "Q" else name
        if not len(axes):
            raise KalmanqError(f"{said} is 0, and stays 0: begin with some noise")
        if form == "multiple":
            return Multiple(name, start, rows)
        if not is_definite(start):
            raise KalmanqError(f"{said} is singular: --{name.lower()}-form multiple fits its size")
        if form == "diagonal" and np.any(start - np.diag(np.diag(start))):
            raise KalmanqError(f"{said} is not diagonal, and is to be")
        held = ~np.eye(len(axes), dtype=bool) if form == "diagonal" else np.zeros(start.shape, bool)
        return Cholesky(name, start, held, rows)

    def _part(self, name: str, inside: np.ndarray) -> np.ndarray:
        made = np.zeros((*self.whole[name].shape, *inside.shape[2:]))
        made[np.ix_(self.axes[name], self.axes[name])] = inside
        return made

    def model_at(self, x: np.ndarray) -> Model:
        made = {block.name: self._part(block.name, block.matrix(x[part])) for block, part in zip(self.blocks, self.slices)}
        return self.model.with_noise(made.get("Q"), made.get("R"))

    def value(self, x: np.ndarray) -> float:
        self.evaluations += 1
        try:
            model = self.model_at(x)
            runs = []
            for rows in self.records:
                runs.append(Filter(model))
                runs[-1]._sequence(rows)
            value = float(sum(run.log_likelihood for run in runs))
        except (KalmanqError, Infeasible, FloatingPointError):
            return -np.inf
        if self.report:
            self.report(self.evaluations, value)
        return value if np.isfinite(value) else -np.inf

    def slopes(self, x: np.ndarray) -> np.ndarray:
        moves = np.eye(self.size) * STEP
        return np.array([sum(weight * self.value(x + k * move) for k, weight in STENCIL) / STEP for move in moves])

    def information(self, x: np.ndarray) -> np.ndarray:
        moves = np.eye(self.size) * CURVE
        J = np.array([(self.slopes(x - move) - self.slopes(x + move)) / (2 * CURVE) for move in moves])
        return (J + J.T) / 2

    def errors(self, covariance: np.ndarray) -> dict[str, np.ndarray]:
        """Of the entries, at the last point"""
        made = {}
        for block, part in zip(self.blocks, self.slices):
            tangent = self._part(block.name, block.tangent())
            error = np.sqrt(np.einsum("ijk,kl,ijl->ij", tangent, covariance[part, part], tangent))
            made["Qc" if block.name == "Q" else block.name] = np.where(error > 0, error, np.nan)
        return made
