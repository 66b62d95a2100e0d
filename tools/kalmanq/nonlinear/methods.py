"""How a filter linearises: at its mean, over its density, where the update comes out, or at a smoothed run."""

from __future__ import annotations

from typing import Any, Callable, Optional

import numpy as np

NonlinearFilter = Any  # of filters.py, which imports this file


class Update:
    """An update that has been prepared: its sensor and its innovation.  by_points: takes all components of z into the
    filter as kq_update_sigma_points does, which forms no Jacobian."""

    def __init__(self, sensor: Any, e: np.ndarray, by_points: Optional[Callable[[], None]] = None):
        self.sensor, self.e, self.by_points = sensor, e, by_points


class Extended:
    """Jacobians at the mean."""

    def predict(self, f: NonlinearFilter, t: float, u: np.ndarray) -> None:
        x = f.mean
        d = f.model.increment(x, t, u)
        f.steps.predict(f._handle, f.model.transition(x, t, u), d)

    def update(self, f: NonlinearFilter, z: np.ndarray, t: float, u: np.ndarray) -> Update:
        return jacobian_at(f, f.mean, f.mean, z, t, u)


class Iterated(Extended):
    """h linearised where the update comes out: `count` times, first at the mean."""

    def __init__(self, count: int):
        self.count = count

    def update(self, f: NonlinearFilter, z: np.ndarray, t: float, u: np.ndarray) -> Update:
        x = c = f.mean
        made = jacobian_at(f, x, c, z, t, u)
        for _ in range(self.count - 1):
            f.copy_to(f.trial)
            f.steps.try_update(f.trial._handle, made, z)
            c = f.trial.mean
            made = jacobian_at(f, x, c, z, t, u)
        return made


def jacobian_at(f: NonlinearFilter, x: np.ndarray, c: np.ndarray, z: np.ndarray, t: float, u: np.ndarray) -> Update:
    """The update of a filter at x with h linearised at c."""
    H = f.model.measurement(c, t, u)
    e = f.model.innovation(z, c, t, u)
    return Update(f.steps.measure(H), e - H @ (x - c))


class Points:
    """Sigma points of the filter's density."""

    def __init__(self, rule: str):
        self.rule = rule

    def predict(self, f: NonlinearFilter, t: float, u: np.ndarray) -> None:
        f.steps.predict_points(f._handle, lambda x: f.model.increment(x, t, u), self.rule)

    def update(self, f: NonlinearFilter, z: np.ndarray, t: float, u: np.ndarray) -> Update:
        made = points_at(f, f._handle, z, t, u, self.rule)
        return Update(made.sensor, made.e, lambda: f.steps.update_points(
            f._handle, innovation_of(f, z, t, u), self.rule))


class Posterior(Points):
    """Sigma points of the density that comes out of the update: `count` times, first those before it."""

    def __init__(self, count: int):
        super().__init__("cubature")
        self.count = count

    def update(self, f: NonlinearFilter, z: np.ndarray, t: float, u: np.ndarray) -> Update:
        made = points_at(f, f._handle, z, t, u, self.rule)
        for _ in range(self.count - 1):
            f.copy_to(f.trial)
            f.steps.try_update(f.trial._handle, made, z)
            made = points_at(f, f.trial._handle, z, t, u, self.rule)
        return made


def innovation_of(f: NonlinearFilter, z: np.ndarray, t: float, u: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    """The innovation at each sigma point, as the C core asks for it"""
    centre: list[np.ndarray] = []  # the innovation at the mean, which is called first

    def innovation(x: np.ndarray) -> np.ndarray:
        e = f.model.innovation(z, x, t, u, *centre)
        if not centre:
            centre.append(e)
        return e

    return innovation


def points_at(f: NonlinearFilter, at: Any, z: np.ndarray, t: float, u: np.ndarray, rule: str) -> Update:
    """The update of f with h linearised over the density `at`, itself or another one."""
    e, J = f.steps.linearise(at, innovation_of(f, z, t, u), f.model.m, rule)
    return Update(f.steps.measure_at(-J), e + J @ (f.number_of_mean(f._handle) - f.number_of_mean(at)))


class AtMeans:
    """Jacobians at given states: a pass of the iterated extended smoother."""

    def __init__(self, means: np.ndarray):
        self.means = means

    def predict(self, f: NonlinearFilter, t: float, u: np.ndarray) -> None:
        x, c = f.mean, self.means[f.row]
        A = f.model.transition(c, t, u)
        f.steps.predict(f._handle, A, f.model.increment(c, t, u) + (A - np.eye(len(c))) @ (x - c))

    def update(self, f: NonlinearFilter, z: np.ndarray, t: float, u: np.ndarray) -> Update:
        return jacobian_at(f, f.mean, self.means[f.row], z, t, u)


class AtDensities:
    """Sigma points of given densities: a pass of the iterated posterior linearisation smoother."""

    def __init__(self, densities: list[Any], rule: str):
        self.densities, self.rule = densities, rule

    def predict(self, f: NonlinearFilter, t: float, u: np.ndarray) -> None:
        at = self.densities[f.row]
        y, J = f.steps.linearise(at, lambda x: f.model.increment(x, t, u), f.model.n, self.rule)
        d = y + J @ (f.number_of_mean(f._handle) - f.number_of_mean(at))
        f.steps.predict_at(f._handle, J + np.eye(f.model.n), d)

    def update(self, f: NonlinearFilter, z: np.ndarray, t: float, u: np.ndarray) -> Update:
        return points_at(f, self.densities[f.row], z, t, u, self.rule)


# By name, of how often an update is linearised
METHODS: dict[str, Callable[[int], Any]] = {
    "extended": lambda _: Extended(), "iterated": Iterated, "cubature": lambda _: Points("cubature"),
    "central": lambda _: Points("central"), "posterior": Posterior}
BY_POINTS = tuple(name for name, make in METHODS.items() if isinstance(make(1), Points))
