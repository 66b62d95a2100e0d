"""The C of a nonlinear model, run over data on this machine as kalmanq.nonlinear's filters are.

Means and covariances are the C's.  Innovations, NIS and the likelihood are worked out of them in double, of all sensors of
a row at the mean before it.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache, partial
from typing import Any, Optional

import numpy as np

from kalmanq.compiler.algorithm.fixed.device import EVENTS
from kalmanq.compiler.given.request import Options
from kalmanq.compiler.run.equation_records import recorded
from kalmanq.compiler.run.fixed_records import simulated
from kalmanq.compiler.run.fixed_run import LIBRARY, FixedRun
from kalmanq.compiler.run.host import Ran, numbered
from kalmanq.compiler.run.record import clock_of
from kalmanq.compiler.run.simulation import NAME, CompiledFilter, CompiledRun, scored
from kalmanq.compiler.text.emit import PREDICTS
from kalmanq.compiler.text.equation_product import compiled_equations
from kalmanq.compiler.text.fixed_device_text import compiled_fixed
from kalmanq.core import names_of
from kalmanq.data.rows import rising
from kalmanq.errors import KalmanqError
from kalmanq.firmware.steps_kept import MOST_STEPS
from kalmanq.formulas.program import Program
from kalmanq.nonlinear import NonlinearModel
from kalmanq.nonlinear.formulas import values_of

FNV = 2166136261  # where the digest of words begins


class EquationRun(CompiledRun):
    def columns(self) -> dict[str, np.ndarray]:
        """Means of what is carried, sigmas of the states"""
        if not self.model.has_errors:
            return super().columns()
        carried, states = self.model.carried, self.model.states
        made = {f"{one.name}_{suffix}": array[:, i] for suffix, array, names in (
            ("mean", self.mean, carried), ("sigma", self.sigma, states), ("smoothed", self.smoothed, carried),
            ("smoothed_sigma", self.smoothed_sigma, states)) if array is not None for i, one in enumerate(names)}
        made.update({f"{one.name}_innovation": self.innovation[:, c] for c, one in enumerate(self.model.measurements)})
        return {**made, "nis": self.nis, "loglik": self.log_likelihood}


class CompiledEquations(CompiledFilter):
    """A context.  run(z, u) goes on where the one before ended.  smooths: of so many rows, of which one run is"""

    made = EquationRun

    def __init__(self, model: NonlinearModel, arithmetic: str, iterate: int = 1, smooths: int = 0):
        if smooths > MOST_STEPS:
            raise KalmanqError(f"--smooth: {smooths} rows; the C's history holds {MOST_STEPS}" + (
                ": give fewer rows" if model.has_errors else ": without --compiled there is no limit"))
        options = Options(arithmetic, iterate=iterate, smooth=smooths)
        super().__init__(model, arithmetic, compiled_equations(model, NAME, options))
        self.method, self.programs = "iterated" if iterate > 1 else "extended", _programs(model)

    def restart(self) -> None:
        super().restart()
        self.mean, self.row, self.last = np.array(self.model.x0), 0, None

    def _see(self, times: Optional[np.ndarray], rows: int) -> None:
        """The clock of the rows; last: the time of the last one before them"""
        if self.row and (times is None) != (self.last is None):
            raise KalmanqError("times: give the times of all rows, or of none")
        if times is None and self.model.takes_step and self.model.dt is None:
            raise self.model.step_error()
        if times is None and self.model.dt is None:
            self.clock = numbered(rows, self.row)
        else:
            at = self.model.dt * np.arange(self.row, self.row + rows) if times is None else times
            self.clock = clock_of(at, self.model.dt or np.nan) if self.last is None or times is None else clock_of(np.append(self.last, at))[1:]
            self.last = self.last if times is None or not rows else float(times[-1])

    def _ran(self, z: np.ndarray, u: Optional[np.ndarray]) -> Ran:
        ran = self.host.run(z, self._carried(u, len(z)), goes_on=not self.begins, now=u, clock=self.clock)
        self.digest, self.row = ran.digest, self.row + len(z)
        return ran

    def run(self, z: np.ndarray, u: Optional[np.ndarray] = None, times: Optional[np.ndarray] = None, **_: Any) -> CompiledRun:
        self._see(rising(times, len(z), repeats=self.model.has_empty_steps)[0] if times is not None else None, len(z))
        run = self._run(z, u)
        if self.product.given.options.smooth:
            back = self.host.smoothed(PREDICTS * (np.arange(len(run)) > 0))
            run.smoothed, run.smoothed_covariance = back.mean, back.covariance
            run.smoothed_sigma = np.sqrt(np.diagonal(back.covariance, axis1=1, axis2=2).clip(0))
        return run

    def _explain(self, run: Any, z: np.ndarray, u: Optional[np.ndarray], ran: Ran) -> None:
        model, rows = self.model, len(z)
        left, step, t = self.clock.T
        before, P = np.vstack([self.mean[None], ran.mean[:-1]]), np.concatenate([self.covariance[None], ran.covariance[:-1]])
        at = values_of(before.T, left, self._carried(u, rows).T, step)
        x = self._values(0, at, rows) + (0 if "f" in model.given else before)
        A = self._values(1, at, rows).reshape(rows, model.n, model.n)
        P = A @ P @ A.transpose(0, 2, 1) + self._noise(model.Q, 4, at, rows)
        if self.begins:
            x[0], P[0] = self.mean, self.covariance
        now = values_of(x.T, t, (np.zeros((rows, model.l)) if u is None else np.asarray(u, float).reshape(rows, -1)).T)
        e = self._values(2, {**now, **{f"z{c}": column for c, column in enumerate(z.T)}}, rows)
        H = self._values(3, now, rows).reshape(rows, model.m, model.n)
        with np.errstate(invalid="ignore"):  # where R is no covariance: the C has refused the row
            scored(run, np.where(np.isnan(z), np.nan, e), H @ P @ H.transpose(0, 2, 1) + self._noise(model.R, 5, now, rows), ran)

    def _noise(self, constant: Optional[np.ndarray], which: int, given: dict[str, Any], rows: int) -> np.ndarray:
        """Q or R of each row"""
        if constant is not None:
            return constant
        made = self._values(which, given, rows).reshape(rows, self.model.n if which == 4 else self.model.m, -1)
        return made @ made.transpose(0, 2, 1) if "G" in self.model.given and which == 4 else made

    def _values(self, which: int, given: dict[str, Any], rows: int) -> np.ndarray:
        made = self.programs[which].values(given)
        return np.stack([np.broadcast_to(np.asarray(one, float), rows) for one in made], axis=1) if made else np.zeros((rows, 0))


class FixedEquations(CompiledEquations):
    """Over the library in q31, as compile --library --arith q31 writes it: the chip's own words"""

    def __init__(self, model: NonlinearModel):
        self.model, self.arithmetic, self.method, self.coarse = model, "q31", "extended", ""
        self.product, self.programs = compiled_fixed(model, NAME, simulated(model)), _programs(model)
        self.restart()

    def restart(self) -> None:
        self.mean, self.covariance, self.row = np.array(self.model.x0, float), np.array(self.model.P0, float), 0
        self.last, self.begins, self.left, self.events, self.digest = None, True, np.zeros(self.model.l), 0, FNV
        self.device = FixedRun(self.product.arithmetic)
        self._ahead = []

    def __enter__(self) -> CompiledEquations:
        return self

    def __exit__(self, *given: object) -> None:
        pass

    def _ran(self, z: np.ndarray, u: Optional[np.ndarray]) -> Ran:
        if self.last is not None:
            raise KalmanqError("--arith q31: t is the number of the row in its C: --time none takes rows so, f32 and f64 take times")
        now = np.zeros((len(z), self.model.l)) if u is None else np.asarray(u, float).reshape(len(z), -1)
        record = recorded(self.model, np.asarray(z, float).reshape(len(z), -1), now)
        record.what[:1] |= 0 if self.begins else PREDICTS
        ran = self.device.run(replace(record, u=self._carried(u, len(z))), self.row)
        for word in ran.reading.astype(np.int64).ravel().tolist():
            self.digest = (self.digest ^ word & 0xffffffff) * 16777619 & 0xffffffff
        self.row += len(z)
        np.bitwise_and(ran.taken, 0x7fffffff, out=ran.taken)  # without that of a refused predict
        return ran

    def _told(self, events: int) -> list[tuple[str, str]]:
        own = [(name.lower().replace("_", " "), meaning) for bit, (name, meaning) in enumerate(EVENTS) if events >> bit & 1]
        return [*own, *((name, "of the library") for name in names_of(events >> LIBRARY))]


def _programs(model: NonlinearModel) -> list[Program]:
    """Of f or its increment, A, innovations, H, Q or G, R"""
    f = model.formulas
    return [Program(rows) for rows in (f.moved if "f" in model.given else f.change, _flat(f.transition), f.innovation,
                                       _flat(f.measurement), _flat(f.noise_of_step or []), _flat(f.noise_of_sensors or []))]


def _flat(rows: list) -> list:
    return [one for row in rows for one in row]


def compiled_equations_run(model: NonlinearModel, arithmetic: str, z: np.ndarray, u: Optional[np.ndarray],
                           times: Optional[np.ndarray] = None) -> EquationRun:
    """From the start.  The C is built once, for as many runs of a model as come one after the other."""
    made = _built(model, arithmetic)
    made.restart()
    return made.run(z, u, times=times)


def _beside(arithmetic: str, model: NonlinearModel, z: np.ndarray, u: Optional[np.ndarray], times: Optional[np.ndarray] = None) -> EquationRun:
    return compiled_equations_run(model, arithmetic, z, u, times)


COMPILED = {f"compiled {name}": partial(_beside, name) for name in ("f32", "f64", "q31")}  # for nonlinear.comparison


@lru_cache(maxsize=4)
def _built(model: NonlinearModel, arithmetic: str) -> CompiledEquations:
    with FixedEquations(model) if arithmetic == "q31" else CompiledEquations(model, arithmetic) as made:
        return made  # of a library that is loaded, the folder may go
