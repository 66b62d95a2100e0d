"""From a place to a maximum: SciPy's BFGS over the C core's likelihood and gradient, edges, Newton's steps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Optional

import numpy as np

from kalmanq.fitting.coordinates import Cholesky
from kalmanq.fitting.information import Information
from kalmanq.fitting.problem import Problem

ROUNDS = 8
RESCALED, RATIO, SHARP = 6, 2.0, 100.0  # climbs in other units; a ratio and a curvature that ask for them
SLOPE = 1e-5  # of a coordinate, at which a climb ends: about 1e-10 of log-likelihood where it is well determined
SAME = 1e-7  # of log-likelihood: a difference of no meaning, far above rounding
SINGULAR = 1e-4  # an eigenvalue of a correlation, below which there is no noise in its direction
FALL = 1e-5  # of log-likelihood: far enough above 0 to see what others make up for
STILL = 1e-2  # of a slope: what is steeper is under way
HARDLY = 0.05  # information on the log of a standard deviation: it may be anything between 0 and 100 times as large
UP = 3.0, 6.0, 12.0, 24.0, 48.0  # of a log standard deviation: where a variance of 0 differs from others
FAR = 1.0, 4.0, 16.0, 64.0  # standard deviations of what is well determined
FALLEN, LOWEST, NONE = 6.0, 30.0, -4.0  # of its log: has gone far down; as far as it goes; where it is as good as none
RISE = 24.0, 12.0, 6.0, 3.0, 1.0  # halves of a search upwards for the largest that is as good


@dataclass
class Optimum:
    """x: coordinates; value: the log-likelihood there; edge: the coordinates of variances that are best at 0."""

    x: np.ndarray
    value: float
    edge: np.ndarray
    information: Information
    is_exhausted: bool = False  # there was reason to go on, and no evaluation or round left
    is_cut: bool = False  # a covariance of lower rank is to be tried before more is done

    @property
    def distance(self) -> float:
        return self.information.distance


class Exhausted(Exception):
    """As many evaluations as were allowed."""


class Narrow(Exception):
    """A full covariance has become as good as singular, at x."""

    def __init__(self, x: np.ndarray, value: float, edge: np.ndarray):
        super().__init__("singular")
        self.x, self.value, self.edge = x, value, edge


def hardly_full(problem: Problem, found: Optimum) -> Optional[Cholesky]:
    """A full covariance with a direction of whose noise hardly anything is known."""
    hardly = is_tiny(problem, found)
    for block, part in zip(problem.blocks, problem.slices):
        if problem.may_be_singular(block) and block.rank > 1 and \
                any(not block.is_alone(int(k)) for k in np.flatnonzero(hardly[part])):
            return block
    return None


def fallen(problem: Problem, optimum: Optimum, k: int) -> tuple[np.ndarray, float]:
    """Where coordinate k is as far above its edge as the likelihood has fallen a little, and by how much."""
    x, fall = optimum.x.copy(), 0.0
    while not fall > FALL:
        x[k] += 1 / problem.units[k]
        if not problem.is_within(x):
            x[k] -= 1 / problem.units[k]
            break
        fall = optimum.value - problem.value(x)
    return x, fall


def is_tiny(problem: Problem, found: Optimum) -> np.ndarray:
    """Variances at the edge, or of which hardly anything is known."""
    curvature, slopes = (found.information.whole(part)
                         for part in (np.diag(found.information.J), found.information.slopes))
    hardly = (np.abs(curvature) < HARDLY * problem.units**2) & (np.abs(slopes) < STILL)
    return problem.logarithmic & (found.edge | hardly)


def search(problem: Problem, tolerance: float, ranks: Optional[dict[str, int]] = None,
           edges: Optional[dict[str, np.ndarray]] = None, may_narrow: bool = False) -> Optimum:
    """Climb, look how the top is curved, move what is best at 0 there, and again.

    ranks       of covariances that are singular
    edges       by block: coordinates that stay where they are
    may_narrow  raises Narrow when a covariance becomes singular; returns early when it may be
    """
    problem.anchor(ranks)
    edge = np.concatenate([(edges or {}).get(block.name, np.zeros(block.size, bool)) for block in problem.blocks])
    x = np.zeros(problem.size)
    for _ in range(ROUNDS):
        found = _top(problem, x, edge, may_narrow)
        found.is_cut = may_narrow and hardly_full(problem, found) is not None
        if found.is_exhausted or found.is_cut:
            break
        x, changed = _next(problem, found, tolerance)
        edge = found.edge
        if not changed:
            _polish(problem, found)
            break
    else:
        found.is_exhausted = True
    problem.put(found.x)
    return found


def _top(problem: Problem, x: np.ndarray, edge: np.ndarray, may_narrow: bool) -> Optimum:
    """Climb, and again wherever the units that were right where it began are wrong at the top."""
    for last in (False,) * RESCALED + (True,):
        x, slopes = climb(problem, x, edge, may_narrow)
        x, edge = _grounded(problem, x, slopes, edge)
        problem.put(x)
        if may_narrow and problem.is_narrower(SINGULAR):
            raise Narrow(x, problem.best, edge)
        ratio = _too_small(problem, x)
        if np.all(ratio == 1):
            information = Information(problem, x, slopes, edge)
            ratio = _too_large(problem, information)
        is_exhausted = problem.evaluations >= problem.allowed
        if last or is_exhausted or np.all(ratio == 1):
            break
        problem.rescale(ratio)
        x = x / ratio
    if not np.all(ratio == 1):  # nothing more is climbed, but the information is in the units of this place
        problem.rescale(ratio)
        x, slopes = x / ratio, slopes * ratio
        information = Information(problem, x, slopes, edge)
        is_exhausted = True
    return Optimum(x, problem.best, edge, information, is_exhausted)


def _too_small(problem: Problem, x: np.ndarray) -> np.ndarray:
    """How much larger the units of linear coordinates are at x than they were; 1 for what hardly grew."""
    grown = problem.grown(x)
    return np.where(grown > RATIO, grown, 1.0)


def _too_large(problem: Problem, information: Information) -> np.ndarray:
    """How much smaller units are to be where the likelihood is curved far more than by 1 a unit.

    Not what their size at x says: it goes to 0 with a variance, and what is known of its covariances does not."""
    curvature = np.ones(problem.size)
    curvature[information.inside] = np.diag(information.J)
    sharp = np.isfinite(curvature) & (curvature > SHARP) & ~problem.logarithmic
    return np.where(sharp, 1 / np.sqrt(np.where(sharp, curvature, 1.0)), 1.0)


def _polish(problem: Problem, found: Optimum) -> None:
    """The last digits of the parameters: a step of Newton, where the likelihood does not tell them any more."""
    if not found.distance < SAME:
        return
    at = found.x + found.information.newton()
    if problem.value(at) > found.value - SAME:
        found.x = at


def climb(problem: Problem, x: np.ndarray, edge: np.ndarray, may_narrow: bool = False) -> \
        tuple[np.ndarray, np.ndarray]:
    """The best point that BFGS finds, and the gradient there; what is at the edge stays.  With `may_narrow` no further
    than where a covariance becomes singular."""
    from scipy.optimize import minimize  # loading it takes longer than all else of the package

    free = np.flatnonzero(~edge)
    lowest = np.where(problem.logarithmic, np.minimum(-LOWEST / problem.units, x), -np.inf)
    problem.best, worst = -np.inf, [None]
    best = [x, np.zeros(problem.size)]

    def lost(part: np.ndarray) -> tuple[float, np.ndarray]:
        at = x.copy()
        at[free] = np.maximum(part, lowest[free])  # the likelihood is flat down there, and a step may be a long one
        value, slopes = problem.evaluate(at)
        if value > problem.best:
            problem.best, best[:] = value, [at, slopes]
        if not np.isfinite(value):  # far below what there was: the line search goes back
            return (0.0 if worst[0] is None else worst[0]) + 1e3, np.zeros(len(free))
        worst[0] = -value if worst[0] is None else max(worst[0], -value)
        if problem.evaluations >= problem.allowed:
            raise Exhausted
        return -value, np.where(part < lowest[free], 0.0, -slopes[free])

    def look(_: np.ndarray) -> None:
        if may_narrow and problem.is_narrower(SINGULAR):
            raise StopIteration

    try:
        if len(free):
            minimize(lost, x[free], jac=True, method="BFGS", callback=look, options={"gtol": SLOPE, "maxiter": 10**6})
        else:
            lost(x[free])
    except Exhausted:
        pass
    return best[0], best[1]


def _next(problem: Problem, found: Optimum, tolerance: float) -> tuple[np.ndarray, bool]:
    """Where the next round begins, and whether there is reason for one.  Moves edges."""
    x, edge = _edges(problem, found)
    moved = not np.array_equal(edge, found.edge)
    escaped = not np.array_equal(x, found.x)
    found.edge = edge
    if moved or escaped:
        return x, True
    information = found.information
    if not information.is_finite:
        return x, False
    if not information.is_maximum:
        return _beside(problem, found)
    if information.distance > 0.01 * tolerance:
        x = _along_flat(problem, found)
        if x is not None:
            return x, True
        step = information.newton()
        for share in (1.0, 0.25):
            if problem.value(found.x + share * step) > found.value:
                return found.x + share * step, True
    return found.x, False


def _along_flat(problem: Problem, found: Optimum) -> Optional[np.ndarray]:
    """Where the likelihood is flat, and yet has a slope: farther up along it."""
    direction = found.information.uphill()
    tried = [found.x + far * direction for far in FAR]
    values = [problem.value(x) for x in tried] if np.any(direction) else [-np.inf]
    best = int(np.argmax(values))
    return tried[best] if values[best] > found.value + SAME else None


def _beside(problem: Problem, found: Optimum) -> tuple[np.ndarray, bool]:
    """No maximum: to one side or the other of it."""
    direction = found.information.downhill()
    tried = [found.x + far * direction for far in (1, -1, 10, -10)]
    values = [problem.value(x) for x in tried]
    best = int(np.argmax(values))
    if values[best] > found.value + SAME:
        return tried[best], True
    found.information.take_for_flat()
    return found.x, False


def _edges(problem: Problem, found: Optimum) -> tuple[np.ndarray, np.ndarray]:
    """Variances that hardly matter: to 0 where the likelihood does not fall by that, upwards where it rises."""
    x, edge, value = found.x.copy(), found.edge.copy(), found.value
    curvature = np.zeros(problem.size)
    curvature[found.information.inside] = np.diag(found.information.J)
    slopes = found.information.whole(found.information.slopes)
    hardly = (np.abs(curvature) < HARDLY * problem.units**2) & (np.abs(slopes) < STILL)
    for k in np.flatnonzero(problem.logarithmic & hardly):
        above, far = _above(problem, x, k, value)
        if above > value:
            x, edge[k], value = moved(x, k, far), False, above
        elif above < value:
            x, edge[k] = _to_the_edge(problem, x, k, value, edge[k])
    return x, edge


def _grounded(problem: Problem, x: np.ndarray, slopes: np.ndarray, edge: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """With variances that have gone far down at their boundaries, before a difference is taken next to nothing."""
    edge = edge.copy()
    for k in np.flatnonzero(problem.logarithmic & ~edge & (x * problem.units < -FALLEN) & (np.abs(slopes) < STILL)):
        x, edge[k] = _to_the_edge(problem, x, int(k), problem.best)
    return x, edge


def _to_the_edge(problem: Problem, x: np.ndarray, k: int, value: float, is_there: bool = False) -> \
        tuple[np.ndarray, bool]:
    """The largest variance that is as good as next to none: the records tell no smaller ones from it.  One that is
    there stays, unless the others have changed and it is too large now."""
    none = problem.value(moved(x, k, NONE / problem.units[k]))
    if none < value - SAME or is_there and none < value + 0.2 * SAME:
        return x, is_there
    at = moved(x, k, NONE / problem.units[k])
    for steps in RISE:
        above = moved(at, k, steps / problem.units[k])
        if problem.value(above) > none - 0.1 * SAME:
            at = above
    return at, True


def _above(problem: Problem, x: np.ndarray, k: int, value: float) -> tuple[float, float]:
    """The likelihood as far above as it is another one, and how far that is; `value` where it is flat everywhere."""
    for steps in UP:
        far = steps / problem.units[k]
        if not problem.is_within(moved(x, k, far)):
            break
        found = problem.value(moved(x, k, far))
        if abs(found - value) > SAME:
            return found, far
    return value, 0.0


def moved(x: np.ndarray, k: int, far: float) -> np.ndarray:
    made = x.copy()
    made[k] += far
    return made
