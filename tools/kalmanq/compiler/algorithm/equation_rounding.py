"""Where a float rounds a measurement's formula by more than the measurement's sigma: what the C looks at.

A float rounds each part of a formula by half a unit in its last place at most, and the formula moves by that times its
derivative by the part.  The C sums the squares of those parts that count, and sets an event where the root is above sigma.
A sensor whose rounding is far below sigma, in simulated rows and over the prior, is not looked at.
"""

from __future__ import annotations

from typing import Any, Iterator, Sequence

import numpy as np

from kalmanq.errors import KalmanqError
from kalmanq.formulas.calculus import partial
from kalmanq.formulas.graph import CONDITIONS, Node, add, constant, dot, mul, needed
from kalmanq.formulas.program import Program
from kalmanq.nonlinear import NonlinearModel, prior_points, simulate
from kalmanq.nonlinear.formulas import values_of
from kalmanq.nonlinear.jacobians import Point, points_along

ROWS, SEED = 400, 1
EPSILON = 2.0**-24  # rounding of a float
NEAR = 1 / 8  # sigma: a sensor that is never rounded by more is not looked at
KEPT = 1 / 4  # of the sum of squares, that the parts which are looked at are
PER_SIGMA = EPSILON**-2  # a sum of squares beyond this times R is an event
Values = dict[str, Any]


def chosen(model: NonlinearModel, innovations: Sequence[Node], H: Sequence[Sequence[Node]], variances: Sequence[Node],
           single: str = "a") -> dict[int, list[int]]:
    """By component: which parts are looked at, where their rounding can come near sigma; single: first letter of symbols of a
    mean in one float, by default of the point that an update is iterated at"""
    given, made = visited(model), {}
    for j, (one, row, variance) in enumerate(zip(innovations, H, variances)):
        R = Program([variance]).values(given)[0]
        if not all(slope.equals(0) for slope in row) and (parts := _chosen(parts_of(one, single), R, given)):
            made[j] = parts
    return made


def watched(innovations: Sequence[Node], which: dict[int, list[int]], single: str = "a") -> dict[int, Node]:
    """By component: the sum of squares of the parts that were chosen"""
    made = {}
    for j, some in which.items():
        parts = parts_of(innovations[j], single)
        made[j] = dot((parts[k], parts[k]) for k in some)
    return made


def _chosen(parts: Sequence[Node], R: Any, given: Values) -> list[int]:
    values = np.broadcast_arrays(given["x0"], *Program(parts).values(given))[1:]
    squares = {k: value**2 for k, value in enumerate(values) if np.all(np.isfinite(value))}  # a branch not taken need not be
    total = sum(squares.values(), np.zeros(len(given["x0"])))
    seen = total > 0
    if not np.any(seen & (total > NEAR**2 * PER_SIGMA * R)):
        return []
    return _kept({k: one[seen] / total[seen] for k, one in squares.items()})


def _kept(shares: dict[int, np.ndarray]) -> list[int]:
    """Of the parts those that are enough at each point"""
    there, kept = np.zeros_like(next(iter(shares.values()))), set()
    while there.min() < KEPT:
        kept.add(max(shares, key=lambda k: shares[k][np.argmin(there)] if k not in kept else -1))
        there = sum(shares[k] for k in kept)
    return sorted(kept)


def parts_of(root: Node, single: str = "a") -> list[Node]:
    """Each part of a formula that is rounded, times the derivative of the formula by it"""
    order, _ = needed([root])
    slopes = {id(root): constant(1)}
    for one in reversed(order):
        for argument, slope in _arguments(one) if id(one) in slopes else ():
            slopes[id(argument)] = add(slopes.get(id(argument), constant(0)), mul(slopes[id(one)], slope))
    made = [mul(slopes[id(one)], _rounded(one, single)) for one in order if id(one) in slopes]
    return [one for one in made if not one.equals(0)]


def _arguments(one: Node) -> Iterator[tuple[Node, Node]]:
    """Each once, and the derivative by it"""
    for argument in {id(part): part for part in one.args if isinstance(part, Node)}.values():
        if argument.op not in CONDITIONS:
            yield argument, partial(one, argument)


def _rounded(one: Node, single: str) -> Node:
    """What half a unit in the last place is a share of; 0 of what is given, and of what the filter keeps in two floats"""
    if one.is_constant:
        return constant((float(np.float32(one.value)) - one.value) / EPSILON)
    return constant(0) if one.op == "symbol" and one.args[0][0] != single else one


def visited(model: NonlinearModel) -> Values:
    """Symbols of the C at a sensor's updates: over the prior, and in simulated rows if there are any"""
    x, t, u = (np.array(column, float) for column in zip(*_points(model)))
    made = values_of(x.T, t, u.T, model.dt)
    made.update({f"a{i}": column for i, column in enumerate(x.T)}, **{f"l{i}": np.zeros(len(x)) for i in range(x.shape[1])})
    expected = Program(model.formulas.expected).values(made)
    return {**made, **{f"z{c}": np.broadcast_to(one, len(x)) for c, one in enumerate(expected)}}


def _points(model: NonlinearModel) -> list[Point]:
    """As far as its functions have values"""
    made = [(np.array(model.x0, float), 0.0, np.zeros(model.l))]
    try:
        made += prior_points(model)
        states, _, controls = simulate(model, ROWS, SEED)
        made += points_along(states, controls, model.instants(ROWS))
    except KalmanqError:
        pass
    return made
