"""Q and R from the data: what EM (estimate.c) makes of a guess, and the job with its estimate."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from estimates import Estimates
from job import Job
from models import Model, noise_text

TAKEN = "f64"  # the arithmetic whose estimate is worked with
MILESTONES = (0, 1, 10, 100)  # iterations that are shown, besides the last


@dataclass(frozen=True)
class Course:
    """The iterations of one arithmetic, from the guess, which is iteration 0."""

    log_likelihood: np.ndarray  # K + 1
    models: list[Model]  # K + 1
    settled: bool
    distance: float  # of the last log-likelihood to its maximum, extrapolated; NaN: not known

    @property
    def last(self) -> int:
        return len(self.models) - 1

    @property
    def rise(self) -> float:
        return float(self.log_likelihood[-1] - self.log_likelihood[0])


@dataclass(frozen=True)
class Learning:
    guess: Job
    courses: dict[str, Course]  # by arithmetic
    before: Estimates  # with the guess, of the arithmetic that is drawn

    @property
    def estimate(self) -> Job:
        """The job with the noise as it is estimated."""
        model = self.courses[TAKEN].models[-1]
        note = f"estimate (EM in {TAKEN}): {noise_text(model)}\nguess: {self.guess.note}"
        return replace(self.guess, model=model, note=note, to_estimate=False)

    @property
    def milestones(self) -> list[int]:
        """The iterations to be shown that all arithmetics have, before their last."""
        return [k for k in MILESTONES if all(k < course.last for course in self.courses.values())]
