"""What is made of the measurements of a block: states by the C core, with parameters known or fitted, or robust."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Callable, Optional, Sequence

import numpy as np

from kalmanq.errors import KalmanqWarning
from kalmanq.fitting import Estimation, fit
from kalmanq.model import Model
from kalmanq.run.filters import Filter, Smoother
from kalmanq.run.robust import Robust
from kalmanq.run.parts import Parts
from kalmanq.run.reweighting import ReweightedSmoother
from kalmanq_studies.heavy_tails.settings import SETTINGS, Setting

ITERATIONS, TOLERANCE = 300, 1e-5  # of EM; `iterations` of an ML, too
SIX = ("A", "H", "Q", "R", "x0", "P0")


def known(setting: Setting, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Filtered and smoothed states, runs x rows: the filter is given the Gaussian of the same sigma."""
    smoother = Smoother(setting.model())
    runs = [smoother.run(row, means_only=True) for row in z]
    return np.stack([run.mean[:, 0] for run in runs]), np.stack([run.smoothed[:, 0] for run in runs])


# ------------------------------------------------------------------------------ fitted parameters


@dataclass(frozen=True)
class Fitting:
    """Estimates the parameters `free`, each run by itself, from the known ones on, or from another c."""

    name: str
    method: str
    free: tuple[str, ...]
    iterations: int = ITERATIONS
    c: float = 1.0

    def model(self, setting: Setting, z: np.ndarray) -> tuple[Model, bool]:
        """Fitted to one run; did it converge?"""
        begin = setting.model().changed(H=[[self.c]])
        if self.method == "em":
            made = Estimation(begin, [z], self.free).run(self.iterations, TOLERANCE)
        else:
            made = fit(begin, [z], self.free, method="ml", iterations=self.iterations)
        return made.model, made.converged


DETERMINED = (Fitting("EM of Q", "em", ("Q",)), Fitting("EM of Q, R", "em", ("Q", "R")),
              Fitting("ML of Q, R", "ml", ("Q", "R")))
UNDETERMINED = (
    Fitting("ML of H, Q, R", "ml", ("H", "Q", "R"), 100), Fitting("EM of all six", "em", SIX),
    Fitting("EM of all six, 30 iterations", "em", SIX, 30), Fitting("ML of all six", "ml", SIX),
    Fitting("ML of all six from c = 2", "ml", SIX, c=2.0))


def fittings(setting: Setting) -> tuple[Fitting, ...]:
    """What the measurements do not determine is fitted in the reference setting alone: it takes long."""
    return DETERMINED + UNDETERMINED if setting == SETTINGS[0] else DETERMINED


@dataclass(frozen=True)
class Fitted:
    """A run with a fitted model: states, rows; what is fitted of the gain, as the weight of the last measurement."""

    filtered: np.ndarray
    smoothed: np.ndarray
    model: Model
    weight: float
    variance: float
    converged: bool


def fitted(fitting: Fitting, setting: Setting, z: np.ndarray) -> Fitted:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", KalmanqWarning)  # of R that is fitted to nearly 0
        model, converged = fitting.model(setting, z)
        smoother = Smoother(model)
        run = smoother.run(z)
    last = smoother.last.copy()
    last.predict()
    weight = float(last.gain()[0, 0] * model.H[0, 0])
    return Fitted(run.mean[:, 0], run.smoothed[:, 0], model, weight, float(run.sigma[-1, 0] ** 2), converged)


# ------------------------------------------------------------------------------ robust steps

JUMP = {2.0: 9.0, 0.02: 16.0}  # g, as robust.h has it

FILTERS: dict[str, Callable[[Setting], Optional[Robust]]] = {
    "plain": lambda setting: None, "gate": lambda setting: Robust("gate"), "Huber": lambda setting: Robust("huber"),
    "Student-t update": lambda setting: Robust("student"), "jump": lambda setting: Robust("jump", JUMP[setting.ratio])}
SMOOTHERS = {"plain": None, "reweighted": 5, "reweighted, 12 passes": 12}


def robust_filters(setting: Setting, z: np.ndarray) -> dict[str, np.ndarray]:
    """Filtered states of each way, runs x rows.

    A known state 0 one step before the first measurement is the same prior; a reweighted step can then
    lead to the first row, too.
    """
    parts, before = Parts(from_nothing(setting), "f64"), one_row_before(z)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", KalmanqWarning)  # of what was gated, or raised, as it should be
        return {name: np.stack([_filtered(parts, row, way(setting)) for row in before])
                for name, way in FILTERS.items()}


def robust_smoothers(setting: Setting, z: np.ndarray) -> dict[str, np.ndarray]:
    model, before = from_nothing(setting), one_row_before(z)
    made = {}
    for name, passes in SMOOTHERS.items():
        smoother = Smoother(model) if passes is None else ReweightedSmoother(model, passes=passes)
        made[name] = np.stack([smoother.run(row).smoothed[1:, 0] for row in before])
    return made


def from_nothing(setting: Setting) -> Model:
    return setting.model().changed(P0=np.zeros((1, 1)))


def one_row_before(z: np.ndarray) -> np.ndarray:
    return np.concatenate([np.full((len(z), 1), np.nan), z], axis=1)


def _filtered(parts: Parts, z: Sequence[float], robust: Optional[Robust]) -> np.ndarray:
    return Filter(parts.model, parts=parts).run(z, robust=robust).mean[1:, 0]
