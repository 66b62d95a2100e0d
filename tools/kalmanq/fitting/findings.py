"""What an optimum says of the parameters: standard errors, variances that are 0, what is not determined."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from kalmanq.fitting.coordinates import FARTHEST, Cholesky
from kalmanq.fitting.entries import label_of
from kalmanq.fitting.information import ROUNDING
from kalmanq.fitting.problem import Problem
from kalmanq.fitting.search import FALL, SINGULAR, STILL, Optimum, climb, fallen

MOVES = 1e-2  # share of a direction, from where it moves a coordinate or a parameter
UNKNOWN = 1e-4  # information on a relative change, below which nothing is known of it: its standard error is 100
NONE = 1e-5  # information on the log of a standard deviation: there is none
ALONE, DOWN = 0.99, 8.0  # share of a flat direction that is one variance; of its log deviation, from where it is 0
COSTS, CLIMB = 0.1, 500  # of log-likelihood: where others have to make up for a variance; evaluations to see it
RIDGE = 0.02  # share of a fall that others leave, below which they make up for it
NAMED = 0.05  # share of the largest change, from where a parameter is named


@dataclass
class Findings:
    """errors        standard errors of the entries of each free parameter, NaN where there is none
    boundary      variances whose best value is 0, or so small that 0 is as good
    undetermined  for each flat direction, how much of each parameter makes no difference
    runaway       variances that the likelihood drives to 0 or infinity without an end
    """

    errors: dict[str, np.ndarray]
    boundary: tuple[str, ...]
    undetermined: tuple[str, ...]
    runaway: tuple[str, ...]


def findings(problem: Problem, optimum: Optimum) -> Findings:
    problem.put(optimum.x)
    optimum = replace(optimum, edge=_all_edges(problem, optimum))
    tangents = problem.tangents()
    none = _without_covariances(problem, optimum.edge)
    held = replace(optimum, edge=none, information=optimum.information.holding(none | optimum.information.edge))
    flat = _flat_ones(problem, held, tangents)
    errors = {name: _errors(tangent, held, flat) for name, tangent in tangents.items()}
    for block, part in zip(problem.blocks, problem.slices):
        _mark(problem, block, none[part], errors[block.name])
    undetermined = [_said(problem, tangents, way) for way in flat] + _ridges(problem, optimum)
    return Findings(errors, tuple(_edges(problem, optimum, flat)), tuple(dict.fromkeys(undetermined)),
                    tuple(_runaway(problem, optimum)))


def _ridges(problem: Problem, optimum: Optimum) -> list[str]:
    """Variances that are best at 0 but need not be 0: where one rises, others make up for all of it.

    With it at a place where the likelihood has fallen, the step of Newton of the others is g' J^-1 g / 2 upwards."""
    made: list[str] = []
    if not optimum.information.is_maximum:
        return made
    covariance, singular = optimum.information.covariance(), _singular(problem)
    for block, part in zip(problem.blocks, problem.slices):
        for k in np.flatnonzero(optimum.edge[part]) if block.name not in singular else ():
            x, fall = fallen(problem, optimum, part.start + int(k))
            slopes = np.where(optimum.edge, 0.0, problem.slopes_at(x))
            if fall > FALL and fall - slopes @ covariance @ slopes / 2 < RIDGE * fall and \
                    _is_made_up(problem, optimum, x, part.start + int(k)):
                step = covariance @ slopes
                made.append(f"{_name(problem, block, int(k))} for {_said(problem, problem.tangents(), step)}")
            problem.put(optimum.x)
    return made


def _is_made_up(problem: Problem, optimum: Optimum, x: np.ndarray, k: int) -> bool:
    """Do the others also make up for coordinate k where it costs more than at x?  Near a maximum all is flat."""
    x, fall = x.copy(), 0.0
    while fall < COSTS:
        x[k] += 0.25 / problem.units[k]
        if not problem.is_within(x):
            return True
        fall = optimum.value - problem.value(x)
    problem.allowed = problem.evaluations + CLIMB
    climb(problem, x, optimum.edge | (np.arange(problem.size) == k))
    return optimum.value - problem.best < RIDGE * fall


def _all_edges(problem: Problem, optimum: Optimum) -> np.ndarray:
    """With those on which there is no information, and which are not under way."""
    known = optimum.information
    if not known.is_finite:
        return optimum.edge
    curvature, slopes = known.whole(np.diag(known.J)), known.whole(known.slopes)
    hardly = (np.abs(curvature) < NONE * problem.units**2) & (np.abs(slopes) < STILL)
    for _, way in known.flat():
        hardly[np.abs(way) > ALONE] = True
    edge = optimum.edge.copy()
    for k in np.flatnonzero(problem.logarithmic & hardly & ~edge):
        edge[k] = _is_as_good_as_0(problem, optimum, int(k))
    problem.put(optimum.x)
    return edge


def _is_as_good_as_0(problem: Problem, optimum: Optimum, k: int) -> bool:
    """Is the likelihood next to 0 what it is here, and lower above?  A logarithm may be flat by that alone.  What is as
    small as it may be is next to 0."""
    x = optimum.x.copy()
    x[k] -= DOWN / problem.units[k]
    is_next = not problem.is_within(x) or problem.value(x) > optimum.value - UNKNOWN
    return is_next and fallen(problem, optimum, k)[1] > FALL


def _without_covariances(problem: Problem, edge: np.ndarray) -> np.ndarray:
    """With the covariances of variances that are 0: they are 0, too."""
    made = edge.copy()
    for block, part in zip(problem.blocks, problem.slices):
        if isinstance(block, Cholesky):
            none = {block.cells[k][0] for k in np.flatnonzero(edge[part]) if block.is_alone(int(k))}
            made[part] |= np.array([i != j and bool({i, j} & none) for i, j in block.cells], bool)
    return made


def _errors(tangent: np.ndarray, optimum: Optimum, flat: list[np.ndarray]) -> np.ndarray:
    """By the delta method: sqrt(d' J^-1 d) of each entry, d its derivative to the coordinates."""
    if not optimum.information.is_maximum:
        return np.full(tangent.shape[:-1], np.nan)
    made = np.sqrt(np.einsum("...k,kl,...l->...", tangent, optimum.information.covariance(), tangent))
    length = np.linalg.norm(tangent, axis=-1)
    made[length == 0] = np.nan
    for way in flat:
        made[np.abs(tangent @ way) > MOVES * length] = np.nan
    return made


def _flat_ones(problem: Problem, optimum: Optimum, tangents: dict[str, np.ndarray]) -> list[np.ndarray]:
    """Flat directions that move a parameter.  Others are of coordinates that do not matter, or of a covariance that
    is singular, of which that is said.

    The curvature is compared with the square of how much the largest relative change of a parameter is, and with
    what it is known to: where the slope is not 0, coordinates that bend have some."""
    known = optimum.information
    if not known.is_finite:
        return []
    singular = _singular(problem)
    one = 1 / np.sqrt(problem.records.steps)
    noise = ROUNDING + one * float(np.max(np.abs(known.slopes), initial=0.0))
    made = []
    for curvature, way in known.flat():
        moved = max((float(np.max(np.abs(tangent @ way) / _unit(problem, name))) for name, tangent in tangents.items()
                     if name not in singular), default=0.0)
        if moved > MOVES * one and abs(curvature) < max(noise, UNKNOWN * moved * moved):
            made.append(way)
    return made


def _singular(problem: Problem) -> set[str]:
    return {block.name for block in problem.blocks if isinstance(block, Cholesky) and _rank(block) < len(block.L)}


def _unit(problem: Problem, name: str) -> np.ndarray:
    """What a change of each entry is compared with."""
    value = problem.whole(name)
    if value.ndim == 2 and name in ("Q", "R", "P0"):
        deviation = np.sqrt(np.diag(value))
        return np.maximum(np.outer(deviation, deviation), 1e-300)
    return np.maximum(np.abs(value), 1e-3 * max(float(np.max(np.abs(value))), 1e-300))


def _mark(problem: Problem, block: object, edge: np.ndarray, errors: np.ndarray) -> None:
    """No standard errors at an edge: of the variance and its covariances, or of a whole matrix that is singular
    there."""
    if not isinstance(block, Cholesky):
        errors[...] = np.nan if np.any(edge) else errors
        return
    if _rank(block) < len(block.L):
        errors[...] = np.nan
    for k in np.flatnonzero(edge):
        i, j = (problem.place(block.name, row) for row in block.cells[k])
        if i is None:
            errors[...] = np.nan
        else:
            errors[i, j] = errors[j, i] = np.nan


def _rank(block: Cholesky) -> int:
    """Directions that have noise, of a matrix that is not diagonal."""
    if np.all(block.logarithmic) or block.rank < len(block.L):
        return block.rank
    C = block.L @ block.L.T
    deviation = np.sqrt(np.diag(C))
    return int(np.sum(np.linalg.eigvalsh(C / np.outer(deviation, deviation)) >= SINGULAR))


def _edges(problem: Problem, optimum: Optimum, flat: list[np.ndarray]) -> list[str]:
    moved, made = np.zeros(problem.size, bool), []
    for way in flat:
        moved |= np.abs(way) > MOVES
    for block, part in zip(problem.blocks, problem.slices):
        made += [_name(problem, block, int(k)) for k in np.flatnonzero(optimum.edge[part] & ~moved[part])
                 if not isinstance(block, Cholesky) or block.is_alone(k)]
        if isinstance(block, Cholesky) and _rank(block) < len(block.L):
            made.append(f"{block.name} (singular: rank {_rank(block)} of {len(block.L)})")
    return made


def _name(problem: Problem, block: object, k: int) -> str:
    if not isinstance(block, Cholesky):
        return block.name  # type: ignore[attr-defined]
    place = problem.place(block.name, block.cells[k][0])
    return f"{block.name} (noise {block.cells[k][0]} of G)" if place is None else f"{block.name}[{place},{place}]"


def _runaway(problem: Problem, optimum: Optimum) -> list[str]:
    """Variances that have gone as far as they may: the likelihood has no maximum."""
    made = []
    slopes = optimum.information.whole(optimum.information.slopes)
    for block, part in zip(problem.blocks, problem.slices):
        far = block.logarithmic & (np.abs(optimum.x[part]) * block.units > 0.3 * FARTHEST)
        far &= np.abs(slopes[part]) > STILL
        made += [_name(problem, block, int(k)) for k in np.flatnonzero(far & ~optimum.edge[part])]
    return made


def _said(problem: Problem, tangents: dict[str, np.ndarray], way: np.ndarray) -> str:
    """H[0,0] +1 %, Q[0,0] -2 %"""
    changes = []
    for name, tangent in tangents.items():
        change = tangent @ way / _unit(problem, name)
        for at in np.ndindex(change.shape):
            if len(at) == 1 or name not in ("Q", "R", "P0") or at[0] >= at[1]:
                changes.append((change[at], label_of(name, at)))
    largest = max(abs(change) for change, _ in changes)
    sign = np.sign(next(change for change, _ in changes if abs(change) > NAMED * largest))
    least = min(abs(change) for change, _ in changes if abs(change) > NAMED * largest)
    return ", ".join(f"{name} {sign * change / least:+.3g} %" for change, name in changes
                     if abs(change) > NAMED * largest)
