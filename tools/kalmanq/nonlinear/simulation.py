"""Runs drawn from a nonlinear model."""

from __future__ import annotations

from typing import Optional, Union

import numpy as np

from kalmanq.errors import KalmanqError
from kalmanq.model import root_of
from kalmanq.nonlinear.angles import wrapped
from kalmanq.nonlinear.model import NonlinearModel


def simulate(model: NonlinearModel, rows: int, seed: Union[int, np.random.SeedSequence],
             controls: Optional[np.ndarray] = None, times: Optional[np.ndarray] = None) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """States, or nominal numbers (rows x n), measurements (rows x m), controls (rows x l: those that are given, or the model's own).  An
    angle is measured within half a turn.  times: of the rows, in seconds"""
    draw = np.random.Generator(np.random.PCG64(seed))
    G = model.G if model.Q is None or model.G is not None else root_of(model.Q)
    V, S, at = None if model.R is None else root_of(model.R), root_of(model.P0), model.instants(rows, times)
    x, z, u = (np.empty((rows, size)) for size in (len(model.carried), model.m, model.l))
    x[0] = model.plus(model.x0, S @ draw.standard_normal(model.n))
    noise = draw.standard_normal((rows, model.n if G is None else G.shape[1])) if "G" not in model.given else None
    error = draw.standard_normal((rows, model.m))
    for t in range(rows):
        try:
            u[t] = model.controls_at(at[t]) if controls is None else controls[t]
            if t:
                root = _root(model, x[t - 1], at[t - 1], u[t - 1]) if G is None else G
                w = root @ (draw.standard_normal(root.shape[1]) if noise is None else noise[t])
                x[t] = _next(model, x[t - 1], at[t - 1], u[t - 1], w)
            v = (root_of(model.measurement_noise(x[t], at[t], u[t])) if V is None else V) @ error[t]
            z[t] = model.expected(x[t], at[t], u[t]) + v
        except KalmanqError as problem:
            raise KalmanqError(f"{problem}{_left(model, x[:t])}", problem.status, t) from problem
    return x, wrapped(z, model.angles), u


def _left(model: NonlinearModel, x: np.ndarray) -> str:
    """The first row with a number beyond its declared range"""
    ends = [one.ends or (-(one.range or np.inf), one.range or np.inf) for one in model.carried]
    beyond = np.argwhere((x < [low for low, _ in ends]) | (x > [high for _, high in ends]))
    if not len(beyond):
        return ""
    t, i = beyond[0]
    return f"; {model.carried[i].name} left its range in row {t}, at {x[t, i]:.3g}: take a smaller step, or correct the ranges, x0 or the controls"


def rows_of_run(model: NonlinearModel, rows: int, seed: np.random.SeedSequence, gap: Optional[tuple[int, int]],
                controls: Optional[np.ndarray], times: Optional[np.ndarray] = None
                ) -> tuple[np.ndarray, np.ndarray, Optional[np.ndarray]]:
    """As of a campaign: without measurements in the gap"""
    x, z, u = simulate(model, rows, seed, controls, times)
    if gap:
        z[gap[0]:gap[1]] = np.nan
    return x, z, u if model.l else None


def errors_of_run(model: NonlinearModel, mean: np.ndarray, x: np.ndarray) -> np.ndarray:
    return np.array([model.minus(*pair) for pair in zip(mean, x)]) if model.has_errors else mean - x


def _root(model: NonlinearModel, x: np.ndarray, t: float, u: np.ndarray) -> np.ndarray:
    """G, or a root of Q, of a step"""
    noise = model.process_noise(x, t, u)
    return noise["G"] if "G" in noise else root_of(noise["Q"])


def _next(model: NonlinearModel, x: np.ndarray, t: float, u: np.ndarray, noise: np.ndarray) -> np.ndarray:
    return model.plus(model.moved(x, t, u), noise) if model.has_errors else x + model.increment(x, t, u) + noise
