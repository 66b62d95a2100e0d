"""Are a model's Jacobians those of its functions?  And what else of its functions has to agree."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Optional, Sequence

import numpy as np

from kalmanq.formulas.tracing import Untraced
from kalmanq.formulas.program import Program
from kalmanq.nonlinear.formulas import values_of
from kalmanq.nonlinear.model import NonlinearModel

Point = tuple[np.ndarray, float, np.ndarray]  # x, t, u

ALLOWED = 1e-6  # of an entry
FIRST_ORDER = 1e-2  # of its row: of errors a Jacobian need only hold to first order
ALIKE, NOISES_ALIKE = 1e-12, 1e-9  # formulas and functions; of Q or R, of sigma_i sigma_j, of G of its row
ROUNDING = 16 * np.finfo(float).eps  # of the largest entry
EXACT = 1e-11  # of its row, each column by its scale: what the right entry itself is off by


@dataclass(frozen=True)
class Entry:
    """The entry of a Jacobian that is farthest off: `share` is its error, of what its row says over the prior."""

    which: str
    row: str
    column: str
    given: float
    right: float
    share: float
    is_wrong: bool
    point: Point

    def __str__(self) -> str:
        x, t, _ = self.point
        return (f"{self.which}[{self.row}, {self.column}] is {self.given:.7g}, not {self.right:.7g}, at x = "
                f"({', '.join(f'{value:.6g}' for value in x)}), t = {t:g}")


def worst_entry(model: NonlinearModel, which: str, points: Sequence[Point]) -> Optional[Entry]:
    """Of the model's own A or H over all the points: a wrong one, if there is any; None: the model gives none.  Untraced:
    its function has no formula to compare with."""
    if which not in model.given:
        return None
    entries = [_worst_at(model, which, point) for point in points]
    return max(entries, key=lambda one: (one.is_wrong, one.share), default=None)


def wrong_entries(model: NonlinearModel, points: Sequence[Point]) -> list[Entry]:
    """The worst one of A and of H, where it is wrong.  A function without a formula is not compared."""
    made = []
    for which in ("A", "H"):
        try:
            found = worst_entry(model, which, points)
        except Untraced:
            continue
        made += [found] if found and found.is_wrong else []
    return made


def unlike_formula(model: NonlinearModel, points: Sequence[Point]) -> Optional[str]:
    """Where the formulas of f (or increment) or h say something else than the function does, in words"""
    for rows, names, function in ((model.formulas.moved, model.carried_names, "moved" if "f" in model.given else "increment"),
                                  (model.formulas.expected, model.measurement_names, "expected")):
        program = Program(rows)
        for x, t, u in points:
            right = getattr(model, function)(x, t, u)
            made = np.array(program.values(values_of(x, t, u, model.dt)), float)
            off = ~(np.abs(made - right) <= ALIKE * (np.abs(right) + np.max(np.abs(x))))  # a formula that is NaN is no other's
            if np.any(off):
                i = int(np.argmax(off))
                return (f"of {names[i]} the formula is {made[i]:.9g} and the function {right[i]:.9g}, at x = "
                        f"({', '.join(f'{value:.6g}' for value in x)}), t = {t:g}")
    return _unlike_noise(model, points)


def _unlike_noise(model: NonlinearModel, points: Sequence[Point]) -> Optional[str]:
    """As unlike_formula, of Q, G and R that are functions"""
    f = model.formulas
    for name, rows, function in (("Q" if "Q" in model.given else "G", f.noise_of_step, lambda *at: [*model.process_noise(*at).values()][0]),
                                 ("R", f.noise_of_sensors, model.measurement_noise)):
        program = Program([one for row in rows or [] for one in row])
        for x, t, u in points if rows else ():
            right = np.asarray(function(x, t, u))
            made = np.array(program.values(values_of(x, t, u, model.dt)), float).reshape(right.shape)
            size = np.abs(right).max(axis=1, keepdims=True) if name == "G" else np.sqrt(np.outer(np.diag(right), np.diag(right)))
            off = ~(np.abs(made - right) <= NOISES_ALIKE * size + ROUNDING * np.abs(right).max())
            if np.any(off):
                i = tuple(np.argwhere(off)[0])
                return (f"of {name} an entry of the formula is {made[i]:.9g} and of the function {right[i]:.9g}, at x = "
                        f"({', '.join(f'{value:.6g}' for value in x)}), t = {t:g}")
    return None


def _worst_at(model: NonlinearModel, which: str, point: Point) -> Entry:
    given, right = (model.transition(*point), model.found_transition(*point)) if which == "A" else \
        (model.measurement(*point), model.found_measurement(*point))
    sigma = np.sqrt(np.diag(model.P0))
    scale = sigma if model.has_errors else np.maximum(np.abs(point[0]), sigma)
    scale = np.where(scale > 0, scale, 1.0)
    row = np.sum(np.abs(right) * scale, axis=1, keepdims=True)
    error = np.abs(given - right)
    wrong = error > (FIRST_ORDER * row / scale if model.has_errors else ALLOWED * np.abs(right) + EXACT * row / scale)
    share = error * scale / np.where(row > 0, row, 1.0)
    i, j = map(int, np.unravel_index(np.argmax(np.where(wrong, 1.0 + share, share / (1.0 + share))), error.shape))
    rows = model.state_names if which == "A" else model.measurement_names
    return Entry(which, rows[i], model.state_names[j], float(given[i, j]), float(right[i, j]), float(share[i, j]),
                 bool(wrong[i, j]), point)


def unlike_increment(model: NonlinearModel, points: Sequence[Point]) -> Optional[str]:
    """Where increment is not f(x) - x, in words"""
    for x, t, u in points:
        d, f = model.increment(x, t, u), model.moved(x, t, u)
        allowed = 1e-9 * (np.abs(x) + np.abs(f) + np.abs(d))
        i = int(np.argmax(np.abs(f - x - d) - allowed))
        if abs(f[i] - x[i] - d[i]) > allowed[i]:
            return f"of {model.state_names[i]} it is {d[i]:.7g}, and f(x) - x is {f[i] - x[i]:.7g}, at t = {t:g}"
    return None


def unlike_innovation(model: NonlinearModel, points: Sequence[Point]) -> Optional[str]:
    """Where innovation of z = h(x) + a sigma is not a sigma, in words"""
    for x, t, u in points:
        sigma = np.sqrt(np.diag(model.measurement_noise(x, t, u)))
        h = model.expected(x, t, u)
        e = model.innovation(h + sigma, x, t, u)
        allowed = 1e-6 * sigma + 1e-12 * np.abs(h)
        c = int(np.argmax(np.abs(e - sigma) - allowed))
        if abs(e[c] - sigma[c]) > allowed[c]:
            return (f"of {model.measurement_names[c]} it is {e[c]:.7g} where z - h(x) is {sigma[c]:.7g}, at t = {t:g}")
    return None


def prior_points(model: NonlinearModel, at: Optional[float] = None) -> list[Point]:
    """The mean before the first measurement, and a sigma each way along each principal axis of P0; at: t of the first row"""
    values, vectors = np.linalg.eigh(model.P0)
    t = model.at_row(0) if at is None else at
    u = model.controls_at(t)
    made = [(model.x0.copy(), t, u)]
    for column, value in zip(vectors.T, values):
        if value > 0:
            made += [(model.plus(model.x0, sign * np.sqrt(value) * column), t, u) for sign in (1, -1)]
    return made


def points_along(states: np.ndarray, u: np.ndarray, at: Optional[Sequence[float]] = None) -> list[Point]:
    """Rows of a run; at: t of each, if not their numbers"""
    return [(x.copy(), t, of) for x, t, of in zip(states, range(len(u)) if at is None else at, u)]
