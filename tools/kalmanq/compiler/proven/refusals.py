"""What cannot be compiled at all, by name and with what would cure it."""

from __future__ import annotations

import numpy as np

from kalmanq.compiler.request import refuse_beyond
from kalmanq.errors import KalmanqError
from kalmanq.model import Model
from kalmanq.run.checks import unseen
from kalmanq.run.parts import is_diagonal

LASTING = 1 - 1e-12


def refuse(model: Model, arithmetic: str) -> None:
    """KalmanqError for the first thing that is in the way."""
    for name in ("c", "d"):
        if getattr(model, name) is not None:
            raise KalmanqError(f"{name}: the proven forms have no offsets: leave out --form, or use kalmanq design")
    _start(model)
    _noises(model)
    _settling(model)
    if arithmetic == "f32":
        refuse_beyond(model)


def _start(model: Model) -> None:
    if np.any(model.unknown):
        name = model.states[int(np.flatnonzero(model.unknown)[0])].name
        raise KalmanqError(f"P0: nothing is known of {name} at first; a compiled filter begins with a variance of each "
                           "state: give one, or use kalmanq design")


def _noises(model: Model) -> None:
    if not is_diagonal(model.R):
        raise KalmanqError("R: the components' noises are correlated; a compiled filter takes them one by one: give "
                           "variances, or use kalmanq design")
    for one, variance in zip(model.measurements, np.diag(model.R)):
        if variance <= 0:
            raise KalmanqError(f"R: {one.name} has no noise; give it a variance, or use kalmanq design")
    for name, matrix in (("Q", model.Q), ("P0", model.P0)):
        scale = np.sqrt(np.maximum(np.diag(matrix), 0))
        scaled = matrix / np.outer(np.where(scale > 0, scale, 1), np.where(scale > 0, scale, 1))
        if np.linalg.eigvalsh(scaled).min() < -1e-9:
            raise KalmanqError(f"{name}: is no covariance: not positive semi-definite")


def _settling(model: Model) -> None:
    for value in unseen(model.A, model.H):
        if abs(value) >= LASTING:
            raise KalmanqError(f"not observable: a direction with eigenvalue {value:.4g} is never measured and does "
                               "not decay; measure it or leave it out")
    scale = np.sqrt(np.maximum(np.diag(model.Q), 1e-300))
    driven = model.G if model.G is not None else scale[:, None] * np.linalg.eigh(model.Q / np.outer(scale, scale))[1] \
        * np.sqrt(np.maximum(np.linalg.eigh(model.Q / np.outer(scale, scale))[0], 0))
    for value in unseen(model.A.T, driven.T):
        if abs(value) >= LASTING:
            raise KalmanqError(f"not stabilisable: a direction with eigenvalue {value:.4g} has no process noise and "
                               "does not decay, so the covariance never settles; give it noise")
