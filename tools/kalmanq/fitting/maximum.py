"""The maximum of the likelihood: of covariances of every rank, and from beside what was found."""

from __future__ import annotations

from typing import Optional

import numpy as np

from kalmanq.fitting.coordinates import Cholesky
from kalmanq.fitting.problem import Problem, Singular
from kalmanq.fitting.search import (FALL, SAME, SINGULAR, STILL, Narrow, Optimum, fallen, hardly_full, is_tiny, moved,
                                    search)

DEEP = 1.0  # of log-likelihood: a variance that costs so much is no longer tiny
BESIDE = 1e-6, 1e-4, 1e-2  # shares of a variance by which a singular covariance is left


def maximise(problem: Problem, limit: int, tolerance: float) -> Optimum:
    """From the arrays as they are.  A full covariance that becomes singular is searched as a singular one.

    In the coordinates of a definite covariance the likelihood has a long bent ridge there, and no top: a logarithm
    goes to minus infinity, and rows below it count for nothing.  In the coordinates of its rank it has a top."""
    problem.allowed = problem.evaluations + limit
    kept, least, x = None, -np.inf, np.zeros(0)
    try:
        found = search(problem, tolerance, may_narrow=True)
        if not np.isfinite(found.value):  # nowhere
            return found
    except Narrow as place:
        kept, least, x = problem.coordinates, place.value - SAME, place.x
        found = _narrowed(problem, place, tolerance)
    found = _narrower(problem, found, tolerance)
    if problem.narrow_blocks:
        found = _wider(problem, found, tolerance)
    if problem.narrow_blocks and found.value > least:
        found = _from_ridges(problem, found, tolerance)
    else:
        if kept is not None and not found.value > least:
            problem.coordinates = kept
            problem.put(x)
            found = search(problem, tolerance)
        found = _from_above(problem, found, tolerance)
    problem.put(found.x)
    return found


def _narrowed(problem: Problem, place: Narrow, tolerance: float) -> Optimum:
    """Searches without the directions that have no noise there; again, while others lose theirs."""
    while True:
        problem.put(place.x)
        ranks = problem.ranks(SINGULAR)
        edges = problem.by_block(place.edge, ranks)
        try:
            return search(problem, tolerance, ranks, edges, may_narrow=True)
        except Narrow as narrower:
            place = narrower


def _narrower(problem: Problem, found: Optimum, tolerance: float) -> Optimum:
    """Tries a rank less, where hardly anything is known of the noise in a direction; keeps it, if it is as good."""
    block = hardly_full(problem, found)
    if block is None or problem.evaluations >= problem.allowed:
        found.is_exhausted |= found.is_cut
        return found
    kept, ranks = problem.coordinates, problem.now_ranks
    try:
        again = search(problem, tolerance, {**ranks, block.name: block.rank - 1}, may_narrow=True)
    except Narrow as place:
        again = _narrowed(problem, place, tolerance)
    again = _narrower(problem, again, tolerance)
    if again.value > found.value - SAME:
        return again
    problem.coordinates = kept
    problem.put(found.x)
    return search(problem, tolerance, ranks) if found.is_cut else found


def _wider(problem: Problem, found: Optimum, tolerance: float) -> Optimum:
    """Tries a rank more, as long as the likelihood rises with noise in one more direction."""
    while not found.is_exhausted:
        more, kept = _more_noise(problem, found), problem.coordinates
        if more is None:
            break
        name, C = more
        ranks = problem.now_ranks
        problem.put_inside(name, C)
        again = search(problem, tolerance, {**ranks, name: ranks[name] + 1})
        if not again.value > found.value + SAME:
            problem.coordinates = kept
            problem.put(found.x)
            break
        found = again
    return found


def _more_noise(problem: Problem, found: Optimum) -> Optional[tuple[str, np.ndarray]]:
    """Name and value of a covariance that is better with noise in one more direction; None: each is best without."""
    best, made = found.value + SAME, None
    for block in problem.narrow_blocks:
        for share in BESIDE:
            problem.put(found.x)
            C = _noisier(problem, block, share)
            if C is None:
                continue
            problem.put_inside(block.name, C)
            value = problem.value_here()
            if value > best:
                best, made = value, (block.name, C)
    problem.put(found.x)
    return made


def _noisier(problem: Problem, block: Cholesky, share: float) -> Optional[np.ndarray]:
    """A singular covariance with noise in one more direction: the one along which the likelihood rises most.  The
    noise is a share of the present variances, or of those in the beginning."""
    C = problem.inside(block.name, problem.arrays[block.name]).copy()
    begun = problem.inside(block.name, problem.begun[block.name])
    rows = block.order[block.rank:]
    deviation = np.sqrt(np.maximum(np.diag(C), np.diag(begun)))[rows]
    beside = C.copy()
    beside[rows, rows] += share * deviation**2
    problem.put_inside(block.name, beside)
    if not np.isfinite(problem.value_here()):
        return None
    slopes = problem.inside(block.name, problem.expectation.gradient()[block.name])[np.ix_(rows, rows)]
    if not np.all(np.isfinite(slopes)):
        return None
    way = deviation * np.linalg.eigh((slopes + slopes.T) * np.outer(deviation, deviation))[1][:, -1]
    C[np.ix_(rows, rows)] += share * np.outer(way, way)
    return C


def _from_above(problem: Problem, found: Optimum, tolerance: float) -> Optimum:
    """Once more with each variance that hardly matters so large that it does: beside the others a tiny one has no
    slope, though there may be a higher place above."""
    for k in np.flatnonzero(is_tiny(problem, found)) if found.distance < STILL else ():
        x = _raised(problem, found, int(k))
        if x is None or found.is_exhausted:
            continue
        kept = problem.coordinates
        problem.put(x)
        try:
            again = search(problem, tolerance)
        except Singular:  # another covariance, at the best point
            return found
        if again.value > found.value + SAME:
            return again
        problem.coordinates = kept
    return found


def _from_ridges(problem: Problem, found: Optimum, tolerance: float) -> Optimum:
    """Once more from where a tiny variance is less so, and the others make up for more than that costs."""
    if found.is_exhausted or not found.information.is_maximum:
        return found
    for k in np.flatnonzero(is_tiny(problem, found)):
        alone = np.arange(problem.size) == k
        x, fall = fallen(problem, found, int(k))
        at = x + found.information.holding(found.edge | alone).covariance() @ problem.slopes_at(x)
        if fall > FALL and np.all(np.isfinite(at)) and problem.value(at) > found.value + SAME:
            kept = problem.coordinates
            problem.put(at)
            try:
                again = search(problem, tolerance, problem.now_ranks)
            except Singular:  # no beginning there
                problem.coordinates = kept
                continue
            if again.value > found.value + max(SAME, tolerance) and not again.is_exhausted:
                return again
            problem.coordinates = kept
    return found


def _raised(problem: Problem, found: Optimum, k: int) -> Optional[np.ndarray]:
    """Where variance k is so large that the likelihood has fallen by DEEP; None where it does not."""
    x = moved(found.x, k, 1 / problem.units[k])
    while problem.is_within(x) and problem.evaluations < problem.allowed:
        if problem.value(x) < found.value - DEEP:
            return x
        x = moved(x, k, 1 / problem.units[k])
    return None
