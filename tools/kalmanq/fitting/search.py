"""The maximum of the likelihood: SciPy's L-BFGS-B over the C core's likelihood and gradient, edges, Newton's steps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from kalmanq.fitting.information import Information
from kalmanq.fitting.problem import Problem

ROUNDS = 5
SLOPE = 1e-5  # of a coordinate, at which a climb ends: about 1e-10 of log-likelihood where it is well determined
SAME = 1e-7  # of log-likelihood: a difference of no meaning, far above rounding
HARDLY = 0.05  # information on the log of a standard deviation: it may be anything between 0 and 100 times as large
DOWN, UP = 4.0, (3.0, 6.0, 9.0)  # steps of a log standard deviation that tell a variance of 0 from another one


@dataclass
class Optimum:
    """x: coordinates; value: the log-likelihood there; edge: the coordinates of variances that are best at 0."""

    x: np.ndarray
    value: float
    edge: np.ndarray
    information: Information

    @property
    def distance(self) -> float:
        return self.information.distance


class Exhausted(Exception):
    """As many evaluations as were allowed."""


def maximise(problem: Problem, limit: int, tolerance: float) -> Optimum:
    """From the arrays as they are, in rounds: climb, look how the top is curved, move what is best at 0 there."""
    problem.anchor()
    problem.allowed = problem.evaluations + limit
    edge = np.zeros(problem.size, bool)
    x = np.zeros(problem.size)
    for _ in range(ROUNDS):
        x, slopes = climb(problem, x, edge)
        found = Optimum(x, problem.best, edge, Information(problem, x, slopes, edge))
        if problem.evaluations >= problem.allowed:
            break
        x, changed = _next(problem, found, tolerance)
        if not changed:
            break
        edge = found.edge
    problem.put(found.x)
    return found


def climb(problem: Problem, x: np.ndarray, edge: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The best point that L-BFGS-B finds, and the gradient there; what is at the edge stays."""
    free = np.flatnonzero(~edge)
    problem.best, worst = -np.inf, [None]
    best = [x, np.zeros(problem.size)]

    def lost(part: np.ndarray) -> tuple[float, np.ndarray]:
        at = x.copy()
        at[free] = part
        value, slopes = problem.evaluate(at)
        if value > problem.best:
            problem.best, best[:] = value, [at, slopes]
        if not np.isfinite(value):  # far below what there was: the line search goes back
            return (0.0 if worst[0] is None else worst[0]) + 1e3, np.zeros(len(free))
        worst[0] = -value if worst[0] is None else max(worst[0], -value)
        if problem.evaluations >= problem.allowed:
            raise Exhausted
        return -value, -slopes[free]

    try:
        if len(free):
            minimize(lost, x[free], jac=True, method="L-BFGS-B", bounds=[problem.bounds[k] for k in free],
                     options={"maxcor": 30, "ftol": 0.0, "gtol": SLOPE, "maxfun": 10**6, "maxiter": 10**6})
        else:
            lost(x[free])
    except Exhausted:
        pass
    return best[0], best[1]


def _next(problem: Problem, found: Optimum, tolerance: float) -> tuple[np.ndarray, bool]:
    """Where the next round begins, and whether there is reason for one.  Moves edges."""
    x, edge = _edges(problem, found)
    moved = not np.array_equal(edge, found.edge)
    escaped = not np.array_equal(x[~edge], found.x[~edge])
    found.edge = edge
    if moved or escaped:
        return x, True
    information = found.information
    if not information.is_finite:
        return x, False
    if not information.is_maximum:
        return _beside(problem, found)
    if information.distance > 0.01 * tolerance:
        step = information.newton()
        for share in (1.0, 0.25):
            if problem.value(found.x + share * step) > found.value:
                return found.x + share * step, True
    return x, False


def _beside(problem: Problem, found: Optimum) -> tuple[np.ndarray, bool]:
    """No maximum: to one side or the other of it."""
    direction = found.information.downhill()
    tried = [found.x + far * direction for far in (1, -1, 10, -10)]
    values = [problem.value(x) for x in tried]
    best = int(np.argmax(values))
    return (tried[best], True) if values[best] > found.value + SAME else (found.x, False)


def _edges(problem: Problem, found: Optimum) -> tuple[np.ndarray, np.ndarray]:
    """Variances that hardly matter: to 0 where the likelihood does not fall by that, upwards where it rises."""
    x, edge, value = found.x.copy(), found.edge.copy(), found.value
    curvature = np.zeros(problem.size)
    curvature[found.information.inside] = np.diag(found.information.J)
    for k in np.flatnonzero(problem.logarithmic):
        unit = problem.units[k]
        if not curvature[k] < HARDLY * unit**2:
            continue
        values = {far: problem.value(_moved(x, k, far / unit)) for far in (*UP, -DOWN)}
        up = max(UP, key=lambda far: values[far])
        if values[up] > value + SAME:
            x, edge[k], value = _moved(x, k, up / unit), False, values[up]
        elif not edge[k] and values[-DOWN] > value - SAME and values[UP[-1]] < value - SAME:
            x, edge[k], value = _moved(x, k, -DOWN / unit), True, values[-DOWN]
    return x, edge


def _moved(x: np.ndarray, k: int, far: float) -> np.ndarray:
    made = x.copy()
    made[k] += far
    return made
