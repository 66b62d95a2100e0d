"""Parameters of a model estimated from records: expectation and maximisation in the C core (em.h)."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Callable, Mapping, Optional, Sequence

from numpy.typing import ArrayLike

from kalmanq.core import lib, require
from kalmanq.fitting.choice import Choice
from kalmanq.fitting.expectation import Expectation, Records
from kalmanq.fitting.likelihood import likelihood
from kalmanq.fitting.problem import Problem
from kalmanq.model import Model

Report = Optional[Callable[[int, float], None]]
NEAR = 1e-2  # the largest change of an iteration from where an extrapolation is believed (em.h)


@dataclass
class Estimate:
    """What EM has found.

    Attributes
    ----------
    model, log_likelihood : with what was estimated
    course : the log-likelihood before each iteration, and at last
    converged : is what is left of the log-likelihood, extrapolated, within the tolerance?
    distance : what is left of it, extrapolated; NaN where that is not known

    Examples
    --------
    >>> made = kalmanq.Estimation(kalmanq.Model([1], H=[1], R=1, Q=1, P0=1), [[1.0, 3.0, 2.0, 4.0]], ["R"]).run(3)
    >>> len(made.course), made.converged
    (4, False)
    """

    model: Model
    log_likelihood: float
    course: list[float] = field(default_factory=list)
    converged: bool = False
    distance: float = float("nan")


class Estimation:
    """EM of a model from one record, or several (Shumway and Stoffer 1982).

    Parameters
    ----------
    model : Model, where it begins
    z : records, each T x m; NaN: missing
    free : of A, H, Q, R, x0, P0, by name
    u : for each record T x l, or None
    Q_form, R_form : "full", "diagonal", "multiple" (of what it is)
    held : entries of A (n x n) and H (m x n) that stay, masks by name
    arithmetic : "f64" or "f32"

    Raises
    ------
    KalmanqError
        what EM cannot estimate, and what the core refuses

    Examples
    --------
    >>> made = kalmanq.Estimation(kalmanq.Model([1], H=[1], R=1, Q=1, P0=1), [[1.0, 3.0, 2.0, 4.0]], ["R"]).run(100)
    >>> bool(made.course[-1] > made.course[0])
    True
    """

    def __init__(self, model: Model, z: Sequence[ArrayLike], free: Sequence[str] = ("Q", "R"), *,
                 u: Optional[Sequence[Optional[ArrayLike]]] = None, Q_form: str = "full", R_form: str = "full",
                 held: Optional[Mapping[str, ArrayLike]] = None, arithmetic: str = "f64"):
        choice = Choice(model, free, Q_form, R_form, held)
        choice.require_em(model)
        self.model, self.records = model, Records(model, z, u)
        self.records.require_steps("EM of the core")
        self._problem = Problem(model, self.records, choice, arithmetic)
        require(self._problem.expectation.status, "EM")

    def run(self, iterations: int = 1000, tolerance: float = 1e-6, report: Report = None) -> Estimate:
        """Iterates until no more than `tolerance` of log-likelihood is left, extrapolated (em.h, kq_em_distance);
        `report(k, log_likelihood)`."""
        expectation = self._problem.expectation
        course, status = iterate(expectation, iterations, tolerance, report, self._problem.offset)
        require(status, "EM")
        model = self._problem.estimated()
        last = likelihood(model, self.records.z, self.records.u, arithmetic=expectation.parts.arithmetic.name)
        return Estimate(model, last, course + [last], is_near(expectation, tolerance), expectation.distance)


def iterate(expectation: Expectation, iterations: int, tolerance: float, report: Report = None,
            offset: float = 0.0) -> tuple[list[float], int]:
    """The log-likelihood before each iteration, and the status that ended them, KQ_OK where none did."""
    course: list[float] = []
    for k in range(iterations):
        status = expectation.iterate()
        if status < lib.KQ_OK:
            return course, status
        course.append(expectation.log_likelihood + offset)
        if report:
            report(k, course[-1])
        if is_near(expectation, tolerance):
            break
    return course, lib.KQ_OK


def is_near(expectation: Expectation, tolerance: float) -> bool:
    """Both: a small change alone may be a plateau, an extrapolation alone sees no further than the last ones."""
    return expectation.change <= NEAR and expectation.distance <= tolerance
