"""kalmanq.fit: parameters of a model from records."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Callable, Mapping, Optional, Sequence

import numpy as np
from numpy.typing import ArrayLike

from kalmanq.fitting.em import Estimation
from kalmanq.model import Model


@dataclass
class Fit:
    """model            with what was estimated
    log_likelihood   of it; the exact one where the start is unknown
    standard_errors  of the entries of each free parameter, in arrays of their shapes; NaN where there is none
    boundary         names of variances whose best value is 0, such as "Q[1,1]"
    evaluations      E-steps: each is a log-likelihood and its gradient
    course           the log-likelihood after each evaluation
    is_settled       is this the optimum, as far as can be told?
    distance         of the log-likelihood from the optimum, extrapolated; NaN where that is not known
    message          one line: how it ended
    """

    model: Model
    log_likelihood: float
    standard_errors: dict[str, np.ndarray] = field(default_factory=dict)
    boundary: tuple[str, ...] = ()
    evaluations: int = 0
    course: list[float] = field(default_factory=list)
    is_settled: bool = False
    distance: float = float("nan")
    message: str = ""


def fit(model: Model, records: Sequence[ArrayLike], free: Sequence[str] = ("Q", "R"), *,
        u: Optional[Sequence[Optional[ArrayLike]]] = None, method: str = "both", Q_form: str = "full",
        R_form: str = "full", held: Optional[Mapping[str, ArrayLike]] = None, starts: int = 1, seed: int = 0,
        iterations: int = 500, tolerance: float = 1e-7, arithmetic: str = "f64",
        report: Optional[Callable[[int, float], None]] = None) -> Fit:
    """Parameters of `model` under which `records` are most likely."""
    estimate = Estimation(model, records, free, u=u, Q_form=Q_form, R_form=R_form,
                          arithmetic=arithmetic).run(iterations, tolerance, report)
    return Fit(estimate.model, estimate.log_likelihood, {}, (), len(estimate.course), estimate.course,
               estimate.is_settled, estimate.distance, "EM")
