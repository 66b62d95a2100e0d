"""The parameters of an entry under which its data are most likely."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Mapping, Optional

import numpy as np
from scipy.optimize import minimize

from kalmanq import fitting
from kalmanq.data.rows import Varying
from kalmanq.errors import KalmanqError
from kalmanq.model import Model
from kalmanq.run.filters import Filter, Smoother
from kalmanq.run.results import Run
from kalmanq_studies.gallery.entries import Entry
from kalmanq_studies.gallery.sources import Data

POSITIVE = ("variance", "noise", "drift", "density")  # are fitted by their logarithms
REFUSED = 1e10  # of minus the log-likelihood, where there is no such model


@dataclass(frozen=True)
class Fitted:
    """parameters: of the builder; log_likelihood: of `model`; converged: is it the optimum, as far as can be told?"""

    parameters: dict[str, Any]
    model: Model
    log_likelihood: float
    converged: bool


def varying_of(data: Data) -> Optional[Varying]:
    return None if data.regressors is None else Varying(H=data.regressors)


def run_of(model: Model, data: Data, arithmetic: str = "f64") -> Run:
    return Smoother(model, arithmetic).run(data.z, varying=varying_of(data))


def log_likelihood(model: Model, data: Data) -> float:
    if data.regressors is not None:
        return float(np.sum(Filter(model).run(data.z, varying=varying_of(data)).log_likelihood))
    return fitting.likelihood(model, [data.z])


def fit(entry: Entry, name: str) -> Fitted:
    data = entry.data()
    parameters, converged = (_by_fit if entry.by == "fit" else _by_builder)(entry, data)
    model = entry.model(parameters, name)
    return Fitted(parameters, model, log_likelihood(model, data), converged)


# ------------------------------------------------------------------------------ noises, by kalmanq.fit


def _by_fit(entry: Entry, data: Data) -> tuple[dict[str, Any], bool]:
    begun = entry.model()
    made = fitting.fit(begun, [data.z], ("Q", "R"), Q_form=entry.Q_form, R_form="diagonal")
    grown = np.diag(made.model.Q)[_pivots(begun)] / np.diag(begun.Q)[_pivots(begun)]
    first = entry.free[0]
    scale = grown[: np.size(entry.start[first])]
    fitted = {first: scale * entry.start[first], "noise": np.diag(made.model.R)}
    return _like_start(entry, fitted), made.converged


def _pivots(model: Model) -> np.ndarray:
    """Of each noise the state that it moves most: the variances of Q grow with those of the noises."""
    return np.argmax(np.abs(model.Q if model.G is None else model.G), axis=0)


def _like_start(entry: Entry, fitted: Mapping[str, Any]) -> dict[str, Any]:
    """All parameters, numbers and lists as a model file has them"""
    made = dict(entry.start)
    for name, value in fitted.items():
        shape = np.shape(entry.start[name])
        made[name] = np.reshape(value, shape).tolist()
    return made


# ------------------------------------------------------------------------------ any, over the builder's parameters


def _by_builder(entry: Entry, data: Data) -> tuple[dict[str, Any], bool]:
    def parameters(point: np.ndarray) -> dict[str, Any]:
        made, first = {}, 0
        for name in entry.free:
            size = np.size(entry.start[name])
            values = point[first : first + size]
            made[name] = np.exp(values) if name in POSITIVE else values
            first += size
        return _like_start(entry, made)

    def cost(point: np.ndarray) -> float:
        try:
            return -log_likelihood(entry.model(parameters(point)), data)
        except KalmanqError:  # not stationary, or not representable
            return REFUSED

    start = np.concatenate([np.log(np.ravel(entry.start[name])) if name in POSITIVE else np.ravel(entry.start[name])
                            for name in entry.free])
    found = minimize(cost, start, method="BFGS", options={"gtol": 1e-4})
    return parameters(found.x), bool(np.max(np.abs(found.jac)) < 1e-2)
