"""A model in continuous time at any times: its log-likelihood and gradient, what Expectation is to a model of steps that are alike.

The likelihood is the C core's.  Its slopes to each step's A, Q and B, to R and to the start are those of the disturbance smoother
(slopes.h), which inverts no Q.  Those to F, Qc and a builder's parameters follow by going back through the steps.
"""

from __future__ import annotations

from typing import Any, NamedTuple, Sequence

import numpy as np

from kalmanq.core import lib
from kalmanq.errors import KalmanqError
from kalmanq.fitting.noise import Noise
from kalmanq.fitting.slopes import Slopes, Steps, agrees, recorded
from kalmanq.model import Model
from kalmanq.model.builders import searched
from kalmanq.model.model_file import rebuilt
from kalmanq.run.filters import Filter
from kalmanq.run.parts import Parts

ARRAYS = ("F", "Q", "H", "R", "x0", "P0")  # Q is of Qc
STEP = 1e-3  # share of a builder's parameter, of differences of what it makes
# x[k + 1] - x[k - 1] and x[k + 2] - x[k - 2], in steps: a derivative whose error is of fourth order
STENCIL = ((1, 2 / 3), (-1, -2 / 3), (2, -1 / 12), (-2, 1 / 12))
FLAT = 16 * np.finfo(float).eps  # of a change of EM, rounded up


class Flow:
    """What is free: numbers of the model's builder (`labels`: parameter and place of each), or of ARRAYS"""

    def __init__(self, model: Model, names: Sequence[str]):
        self.model, self.labels = model, {}
        known = searched(model.builder)
        if any(name.partition("[")[0] in known for name in names):
            self._label(known, names)
        elif set(names) - {*ARRAYS, "Qc"}:
            name = next(one for one in names if one not in (*ARRAYS, "Qc"))
            more = f", and {', '.join(known)} of its builder" if known else ""
            raise KalmanqError(f"{name} of records at irregular times is not fitted: leave it out of --free. Free are Q (that is Qc), R, F, H, "
                               f"x0 and P0{more}; --time none takes each row for a step of dt")
        self.free = tuple(self.labels) or tuple(name for name in ARRAYS if name in names or name == "Q" and "Qc" in names)
        self.noises = {label for label, (name, _) in self.labels.items() if name in ("density", "sigma", "noise")}

    def _label(self, known: Sequence[str], names: Sequence[str]) -> None:
        size = next(name for name in ("density", "sigma") if name in known)
        for name in ({"Q": size, "Qc": size, "R": "noise"}.get(one, one) for one in names):
            parameter, _, entry = name.rstrip("]").partition("[")
            if parameter not in known:
                raise KalmanqError(f"{name} cannot be free beside parameters of the builder: {', '.join(known)}, Q (its {size}) and "
                                   "R (its noise) can")
            values = self.values_of(self.model, parameter)
            places = [int(entry)] if entry.isdigit() else np.flatnonzero(values).tolist()
            if entry and not (entry.isdigit() and int(entry) < len(values)):
                raise KalmanqError(f"{name} is not there: {parameter} has {len(values)} number{'s' * (len(values) > 1)}")
            if not places or not np.all(values[places] > 0):
                raise KalmanqError(f"{name} is not above 0, and its logarithm is searched: begin above 0")
            for at in places:
                self.labels[parameter if len(values) == 1 else f"{parameter}[{at}]"] = parameter, at

    @staticmethod
    def values_of(model: Model, parameter: str) -> np.ndarray:
        return np.atleast_1d(np.array(model.builder.get(parameter, 0.0), float))

    def model_at(self, arrays: dict[str, np.ndarray], noise: Noise) -> Model:
        """With what is free as it is in `arrays`"""
        if not self.labels:
            made = {name: arrays[name] for name in self.free if name in ("H", "R", "x0", "P0")}
            return self.model.flowing(F=arrays["F"] if "F" in self.free else None,
                                      Qc=noise.whole(arrays["Q"]) if "Q" in self.free else None, **made)
        given: dict[str, Any] = {}
        for label, (name, at) in self.labels.items():
            given.setdefault(name, self.values_of(self.model, name))[at] = arrays[label][0]
        made = rebuilt(self.model, {name: values.tolist() if np.ndim(self.model.builder[name]) else float(values[0])
                                    for name, values in given.items()})
        made.constants = {label: float(arrays[label][0]) for label in self.labels}
        return made


class Change(NamedTuple):
    """Of a model, or of its log-likelihood by it"""

    F: np.ndarray
    Qc: np.ndarray
    H: np.ndarray
    R: np.ndarray
    x0: np.ndarray
    P0: np.ndarray

    @classmethod
    def of(cls, model: Model) -> Change:
        return cls(model.continuous.F, model.continuous.Qc, model.H, model.R, model.x0, model.P0)

    def times(self, share: float) -> Change:
        return Change(*(share * one for one in self))

    def plus(self, other: Change) -> Change:
        return Change(*(a + b for a, b in zip(self, other)))


class FlowExpectation:
    """arrays: of what is free, and what else a problem asks for: Q of the noises (r x r, Qc = F Q F'), a label's one number"""

    def __init__(self, flow: Flow, model: Model, records: Any, noise: Noise, forms: dict[str, str]):
        self.flow, self.records, self.noise, self.forms, self.evaluations = flow, records, noise, forms, 0
        self.arrays = {label: Flow.values_of(model, name)[[at]] for label, (name, at) in flow.labels.items()}
        self.arrays.update({name: np.array(one) for name, one in zip(ARRAYS, Change.of(model))})
        self.arrays["Q"] = np.array(noise.inner)
        free = sum(self.arrays[name].size for name in flow.free if name not in ("Q", "R", "P0"))
        self.status = lib.KQ_OK if records.measurements > free else lib.KQ_ERR_FEW_DATA
        self.rows = records.rows(model)
        self.recorded, self._dt = recorded(model, self.rows, True)
        self._linear: dict[str, Change] = {}
        self.begin()

    def begin(self) -> int:
        """Forgets what iterations have been"""
        self.log_likelihood = self.change = self.distance = float("nan")
        return self.status

    def run(self) -> int:
        """By the filter in C; an unknown start is exact by slopes.h, where the filter of the chip rounds"""
        self.evaluations += 1
        try:
            self.model, total = self.flow.model_at(self.arrays, self.noise), 0.0
            parts, self._steps = Parts(self.model, "f64"), Steps.of(*self.model.continuous.steps(self._dt))
            for rows in self.rows:
                run = Filter(self.model, parts=parts)
                if rows.times is not None:
                    run._steps.know(self._dt, *self._steps)
                run._sequence(rows)
                if run.events & lib.KQ_EVENT_OVERFLOW:  # a measurement that the filter has left out
                    return lib.KQ_ERR_LIKELIHOOD
                total += run.log_likelihood
        except (KalmanqError, FloatingPointError):
            return lib.KQ_ERR_NOT_FINITE
        exact = sum(one.log_likelihood(self.model, self._steps, True) for one in self.recorded)
        is_unknown = bool(np.any(self.model.unknown))
        self._agrees = agrees(exact, total, is_unknown)
        self.log_likelihood = float(exact if is_unknown and self._agrees else total)
        return lib.KQ_OK

    # ------------------------------------------------------------------ slopes

    def gradient(self) -> dict[str, np.ndarray]:
        """After `run`; NaN where the covariances here lose what C's roots keep"""
        if not self._agrees:
            return {name: np.full_like(self.arrays[name], np.nan) for name in self.flow.free}
        by = Slopes.none(self.model, self._steps)
        for one in self.recorded:
            one.add_slopes(by)
        by_F, by_Qc = self.model.continuous.slopes(self._dt, by.A, by.Q, by.B)
        self._by = Change(by_F, by_Qc, by.H, by.R, by.x0, by.P0)
        return {name: self._of(name) for name in self.flow.free}

    def gradient_of(self, name: str) -> np.ndarray:
        self.run()
        return self.gradient()[name]

    def _of(self, name: str) -> np.ndarray:
        if name in self.flow.labels:
            change = self._tangent(name)
            return np.array([sum(float(np.sum(a * b)) for a, b in zip(self._by, change))])
        if name != "Q":
            return getattr(self._by, name)
        return self._by.Qc if self.noise.F is None else self.noise.F.T @ self._by.Qc @ self.noise.F

    def _tangent(self, label: str) -> Change:
        """What a builder's number moves, by its unit; densities and variances are as good as constants where nothing of F is free"""
        is_linear = self.flow.labels[label][0] in ("density", "noise") and set(self.flow.labels) == self.flow.noises
        if is_linear and label in self._linear:
            return self._linear[label]
        value, made = self.arrays[label][0], []
        for steps, weight in STENCIL:
            there = self.flow.model_at({**self.arrays, label: np.array([value * (1 + steps * STEP)])}, self.noise)
            made.append(Change.of(there).times(weight / (STEP * value)))
        change = made[0].plus(made[1]).plus(made[2]).plus(made[3])
        if is_linear:
            self._linear[label] = change
        return change

    # ------------------------------------------------------------------ EM

    @staticmethod
    def has_em(model: Model, noise: Noise, form: str) -> bool:
        """Is the best Qc, given the states, one that can be said?  A size, and what is Qc dt over each step"""
        return form == "multiple" or len(noise.inner) == 1 or not np.any(model.continuous.F @ noise.whole(noise.inner))

    def iterate(self) -> int:
        """The E-step, and the M-step by Fisher's identity: the best C of N, given the states, is C + 2 C G C / N"""
        before = self.log_likelihood
        status = self.run()
        if status < lib.KQ_OK:
            return status
        slopes, moved, gain, steps, made = self.gradient(), [], self.log_likelihood - before, self.records.steps, []
        for name, count in (("Q", max(steps - len(self.records), 1)), ("R", steps)):
            if name in self.flow.free:
                C = self.arrays[name]
                step = self._best(name, C, slopes[name], count) if np.all(np.isfinite(slopes[name])) else np.full_like(C, np.nan)
                deviation = np.sqrt(np.maximum(np.diag(C), 1e-300))
                moved.append(float(np.max(np.abs(step) / np.outer(deviation, deviation))))
                made.append((C, (step + step.T) / 2))
        if not np.all(np.isfinite(moved)):
            return lib.KQ_ERR_NOT_FINITE
        for C, step in made:
            C += step
        rate, self.change = (max(moved) + FLAT) / self.change, max(moved)
        self.distance = gain * rate**2 / (1 - rate) if rate < 1 else float("nan")
        return lib.KQ_OK

    def _best(self, name: str, C: np.ndarray, slope: np.ndarray, count: int) -> np.ndarray:
        """How far the M-step goes"""
        form = self.forms[name]
        if name == "Q" and (form == "multiple" or len(C) == 1):
            return 2 * C * np.sum(slope * C) / (count * self._reached())
        if form == "multiple":
            return 2 * C * np.sum(slope * C) / (count * np.count_nonzero(np.diag(C)))
        step = 2 * C @ slope @ C / count
        return np.diag(np.diag(step)) if form == "diagonal" else step

    def _reached(self) -> int:
        """States that the noise of a step moves"""
        of = self.model.continuous
        reached = np.diag(of.Qc) > 0
        for _ in reached:
            reached = reached | ((of.F != 0) @ reached)
        return int(np.sum(reached))
