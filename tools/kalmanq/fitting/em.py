"""Parameters of a model estimated from records: expectation and maximisation in the C core (em.h)."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Callable, Optional, Sequence

import numpy as np
from numpy.typing import ArrayLike

from kalmanq.core import require
from kalmanq.errors import KalmanqError
from kalmanq.fitting.expectation import FREE, Expectation, Records
from kalmanq.fitting.likelihood import likelihood
from kalmanq.model import Model


@dataclass
class Estimate:
    """model           with what was estimated
    log_likelihood  of it
    course          the log-likelihood before each iteration, and at last
    is_settled      did it end by its tolerance?
    distance        what is left of the log-likelihood, extrapolated; NaN where that is not known
    """

    model: Model
    log_likelihood: float
    course: list[float] = field(default_factory=list)
    is_settled: bool = False
    distance: float = float("nan")


class Estimation:
    """EM of a model from one record, or several.

    free    of A, H, Q, R, x0, P0, by name
    forms   of Q and R: "full", "diagonal", "multiple" (of what it is)
    u       for each record
    """

    def __init__(self, model: Model, z: Sequence[ArrayLike], free: Sequence[str] = ("Q", "R"), *,
                 u: Optional[Sequence[Optional[ArrayLike]]] = None, Q_form: str = "full", R_form: str = "full",
                 arithmetic: str = "f64"):
        unknown = [name for name in free if name not in FREE]
        if unknown:
            raise KalmanqError(f"{unknown[0]} is no parameter: {', '.join(FREE)}")
        self.model, self.records = model, Records(model, z, u)
        self._expectation = Expectation(model, self.records, free=free, forms=(Q_form, R_form), arithmetic=arithmetic)
        require(self._expectation.status, "EM")

    def run(self, iterations: int = 200, tolerance: float = 1e-6,
            report: Optional[Callable[[int, float], None]] = None) -> Estimate:
        """Iterates until no parameter moves by more than `tolerance`, relative; `report(k, log_likelihood)`."""
        e = self._expectation
        a, course, settled = e.parts.arithmetic, [], False
        for k in range(iterations):
            require(a.function("em_iterate")(e.em), "EM")
            course.append(e.log_likelihood)
            if report:
                report(k, course[-1])
            settled = bool(a.function("em_is_settled")(e.em, tolerance))
            if settled:
                break
        distance = float(a.function("em_distance")(e.em))
        model = self._estimated()
        last = likelihood(model, self.records.z, self.records.u, arithmetic=a.name)
        return Estimate(model, last, course + [last], settled, distance)

    def _estimated(self) -> Model:
        made = {name: np.asarray(array, np.float64).copy() for name, array in self._expectation.arrays.items()}
        for name in ("Q", "R", "P0"):
            made[name] = (made[name] + made[name].T) / 2
        if np.any(self.model.unknown):
            del made["x0"], made["P0"]
        if self.model.G is not None:
            noise = made.pop("Q")
            if not np.array_equal(noise, np.eye(len(noise))):
                made["G"] = self.model.G @ np.linalg.cholesky(noise)
        return self.model.changed(**made)
