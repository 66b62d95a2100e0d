"""From one start to a maximum: EM, maximum likelihood, or the one and then the other."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Callable, Optional

import numpy as np

from kalmanq.core import lib, require, words_of
from kalmanq.fitting import em
from kalmanq.fitting.choice import Choice
from kalmanq.fitting.expectation import Records
from kalmanq.fitting.information import Information
from kalmanq.fitting.likelihood import likelihood
from kalmanq.fitting.maximum import maximise
from kalmanq.fitting.problem import Problem, Singular
from kalmanq.fitting.search import Optimum
from kalmanq.model import Model

FIRST = 3  # iterations of EM before ML: they find the sizes of noises that are far off
AGREES = 1e-6  # of log-likelihood, between an unknown start and the known one that stands for it
SPREAD = 1.5  # of the logarithms of standard deviations of further starts: a variance by e^3
NOTHING_TO_FIT = (lib.KQ_ERR_NO_DATA, lib.KQ_ERR_FEW_DATA)


@dataclass
class Task:
    """What `fit` was asked for."""

    model: Model
    records: Records
    choice: Choice
    method: str
    iterations: int
    tolerance: float
    arithmetic: str
    report: Optional[Callable[[int, float], None]]
    has_no_unit: bool = False  # H and Q are free, and nothing says in which units the states are

    def problem(self, model: Optional[Model] = None) -> Problem:
        return Problem(model or self.model, self.records, self.choice, self.arithmetic)

    def impossible(self) -> str:
        """Why these records cannot be fitted; empty where they can."""
        if not self.records.measurements:
            return "there is no data: every measurement is missing"
        status = self.problem().expectation.status
        self.has_no_unit = status == lib.KQ_NOT_IDENTIFIED
        if status in NOTHING_TO_FIT:
            there = self.records.measurements
            return f"{words_of(status)}: {there} measurement{'s' * (there != 1)}"
        require(status, "fit")
        return ""


@dataclass
class Ended:
    """Where a start has led; the problem's arrays are there."""

    problem: Problem
    model: Model
    value: float
    course: list[float] = field(default_factory=list)
    em_evaluations: int = 0
    evaluations: int = 0
    optimum: Optional[Optimum] = None
    status: int = lib.KQ_OK  # of EM
    em_is_near: bool = True
    em_distance: float = float("nan")

    @property
    def distance(self) -> float:
        """The larger one of what is left of the log-likelihood, as EM and as the information has it."""
        return float(np.fmax(self.em_distance, self.optimum.distance if self.optimum else np.nan))


def one_start(task: Task, random: Optional[np.random.Generator] = None) -> Ended:
    """From the model, or from a random place.  Where the known start that stands for an unknown one no longer does,
    once more from there."""
    problem = task.problem()
    if random:
        problem.scatter(random, SPREAD)
    ended = _search(task, problem)
    if not np.isfinite(ended.value):
        return ended
    for _ in range(3):
        exact = likelihood(ended.model, task.records.z, task.records.u, times=task.records.times, arithmetic=task.arithmetic)
        if abs(exact - ended.value) <= AGREES or not np.isfinite(exact):
            break
        try:
            before, ended = ended, _search(task, task.problem(ended.model))
        except Singular:
            break
        ended.course, ended.em_evaluations = before.course + ended.course, before.em_evaluations
        ended.evaluations += before.evaluations
    ended.value = exact
    return ended


def _search(task: Task, problem: Problem) -> Ended:
    problem.report = task.report
    count = {"em": task.iterations, "ml": 0, "both": FIRST if task.choice.is_for_em(task.model) else 0}[task.method]
    course, status = em.iterate(problem.expectation, min(count, task.iterations), task.tolerance, task.report,
                                problem.offset) if count else ([], lib.KQ_OK)
    if task.method == "em":
        return _after_em(task, problem, course, status)
    optimum = maximise(problem, max(task.iterations - len(course), 1), task.tolerance)
    return Ended(problem, problem.estimated(), optimum.value, course + problem.course, len(course),
                 problem.evaluations, optimum)


def _after_em(task: Task, problem: Problem, course: list[float], status: int) -> Ended:
    """EM believes its own extrapolation only where the information there says the same."""
    near, left = em.is_near(problem.expectation, task.tolerance), problem.expectation.distance
    optimum = None
    if task.arithmetic == "f64":
        problem.anchor()
        x, edge = np.zeros(problem.size), np.zeros(problem.size, bool)
        value, slopes = problem.evaluate(x)
        optimum = Optimum(x, value, edge, Information(problem, x, slopes, edge))
        problem.put(x)
    model = problem.estimated()
    if not course and status < lib.KQ_OK:  # the filter leaves out what overflows, so its likelihood says nothing
        return Ended(problem, model, -np.inf, course, 0, problem.evaluations, status=status)
    value = likelihood(model, task.records.z, task.records.u, times=task.records.times, arithmetic=task.arithmetic)
    return Ended(problem, model, value, course + [value], len(course) + 1, problem.evaluations, optimum, status, near,
                 left)


