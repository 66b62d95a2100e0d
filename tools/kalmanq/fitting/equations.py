"""The log-likelihood of a nonlinear model and its gradient, as often as they are wanted: what Expectation is to a linear one."""

from __future__ import annotations

from typing import Any, Sequence

import numpy as np

from kalmanq.core import lib
from kalmanq.errors import KalmanqError
from kalmanq.fitting.equation_program import Likelihood, Parameters
from kalmanq.fitting.noise import Noise
from kalmanq.nonlinear import NonlinearFilter, NonlinearModel
from kalmanq.nonlinear.constants import Numbers
from kalmanq.nonlinear.file import free_of, read

ARRAYS = ("Q", "R", "x0", "P0")


class Equations:
    """What a nonlinear model's fit shares: its formulas, and the C of its likelihood

    free: labels of constants, and of ARRAYS
    """

    def __init__(self, model: NonlinearModel, names: Sequence[str]):
        self.path, self.names = model.path, [one for one in names if one not in ARRAYS]
        self.traced = free_of(model, self.names)
        self.free = (*self.traced.symbols, *(one for one in ARRAYS if one in names))
        noises = {"Q": [model.given[key] for key in ("Q", "G") if key in model.given], "R": list(model.noises.functions.values())}
        for name, one in ((name, one) for name in names for one in noises.get(name, [])):
            raise one.error(f"is a function, so {name} cannot be free: make what it has a constant of the file, and that free")
        for name in ("Q", "R", "P0"):
            if name in names and self.traced.depends(getattr(self.traced, name)):
                raise KalmanqError(f"{name} is free, and depends on a constant that is free: leave one of them out")
        if "R" in names and len(model.sensors) > 1:
            raise KalmanqError("R of several sensors cannot be free: make what they have a constant of the file, and that free")
        if "Q" in names and model.G is not None:
            raise KalmanqError("Q cannot be free where the file has G: make the size of G a constant of the file, and that free")
        if "x0" in names and model.has_errors:
            raise KalmanqError("x0 cannot be free where the states are errors of nominal numbers: leave it out of --free")
        self.parameters = Parameters(model, self.free)
        self.likelihood = Likelihood(model, self.traced, self.parameters)
        self.noises = {label for label in self.traced.symbols if self.traced.only_in_noises(label)}
        for label in self.noises:
            if self.traced.values[label] == 0:
                raise KalmanqError(f"{label} is 0, and is of the noise: begin with some noise")


    def estimated(self, model: NonlinearModel, found: dict[str, np.ndarray]) -> NonlinearModel:
        """Its file with the constants that were found, and other arrays"""
        constants = {label: float(found[label][0]) for label in self.traced.symbols}
        arrays = {name: one for name, one in found.items() if name not in constants}
        made = read(self.path, Numbers(self.names, constants)) if self.path and constants else model
        made = made.changed(**arrays) if arrays else made
        made.constants = constants
        return made


def likelihood_of(model: NonlinearModel, records: Any, arithmetic: str = "f64") -> float:
    """By the library's filter; of error states, which it has not, by the C of the fit"""
    if not model.has_errors:
        return float(sum(np.sum(NonlinearFilter(model, arithmetic).run(z, u, times=times).log_likelihood) for z, u, times in records.each()))
    made = Likelihood(model, free_of(model, ()), Parameters(model, ()))
    return float(sum(made.at(model.instants(len(z), times), z, u, np.zeros(0), np.zeros(0))[0] for z, u, times in records.each()))


class EquationExpectation:
    """arrays: free parameters by name: Q of the noises (r x r, Q = F Q F'), R, x0, P0, and each constant as an array of one"""

    status = lib.KQ_OK

    def __init__(self, equations: Equations, model: NonlinearModel, records: Any, noise: Noise, forms: dict[str, str]):
        self.of, self.records, self.noise, self.forms, self.evaluations = equations, records, noise, forms, 0
        self.instants = [model.instants(len(z), times) for z, _, times in records.each()]
        values = {**equations.traced.values, **model.constants}
        self.arrays = {label: np.array([values[label]]) for label in equations.traced.symbols}
        self.arrays.update({name: np.array(array, float) for name, array in (("Q", noise.inner), ("R", model.noises.start), ("x0", model.x0), ("P0", model.P0))})
        self.log_likelihood = float("nan")

    def begin(self) -> int:
        return self.status

    def run(self) -> int:
        self.evaluations += 1
        self.log_likelihood = float(self._along(np.zeros(self.of.parameters.count))[0])
        return lib.KQ_OK

    def gradient(self) -> dict[str, np.ndarray]:
        """Of covariances as em.h has it: entries are taken for independent"""
        return {name: self.gradient_of(name) for name in self.of.free}

    def _along(self, direction: np.ndarray) -> np.ndarray:
        at = np.zeros(self.of.parameters.count)
        for name in self.of.free:
            self.of.parameters.put(at, name, self._whole(name, self.arrays[name]))
        return np.sum([self.of.likelihood.at(one, z, u, at, direction)
                       for one, z, u in zip(self.instants, self.records.z, self.records.u)], axis=0)

    def _whole(self, name: str, array: np.ndarray) -> np.ndarray:
        return self.noise.whole(array) if name == "Q" else array

    def gradient_of(self, name: str) -> np.ndarray:
        made = np.zeros_like(self.arrays[name])
        for at in np.ndindex(made.shape):
            if at == tuple(sorted(at, reverse=True)) and self._is_wanted(name, at):
                step = np.zeros_like(made)
                step[at] = step[at[::-1]] = 1
                direction = np.zeros(self.of.parameters.count)
                self.of.parameters.put(direction, name, self._whole(name, step))
                made[at] = made[at[::-1]] = self._along(direction)[1] / np.sum(step)
        return made

    def _is_wanted(self, name: str, at: tuple[int, ...]) -> bool:
        form = self.forms.get(name, "full") if len(at) == 2 else "full"
        return form == "full" or at[0] == at[1] or form == "multiple" and self.arrays[name][at] != 0
