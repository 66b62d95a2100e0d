"""Parameters of a model estimated from records: expectation and maximisation in the C core (em.h)."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Callable, Optional, Sequence

import numpy as np
from numpy.typing import ArrayLike

from kalmanq.core import ffi, lib, require
from kalmanq.data import controls_of, present_of, rows_of
from kalmanq.errors import KalmanqError
from kalmanq.model import Model
from kalmanq.parts import Parts

FREE = {"A": lib.KQ_EM_A, "H": lib.KQ_EM_H, "Q": lib.KQ_EM_Q, "R": lib.KQ_EM_R, "x0": lib.KQ_EM_X0,
        "P0": lib.KQ_EM_P0}
FORMS = {"full": lib.KQ_EM_FULL, "diagonal": lib.KQ_EM_DIAGONAL, "multiple": lib.KQ_EM_MULTIPLE}


@dataclass
class Estimate:
    """model           with what was estimated
    log_likelihood  of it
    course          the log-likelihood before each iteration, and at last
    is_settled      did it end by its tolerance?
    distance        what is left of the log-likelihood, extrapolated; NaN where that is not known
    """

    model: Model
    log_likelihood: float
    course: list[float] = field(default_factory=list)
    is_settled: bool = False
    distance: float = float("nan")


class Estimation:
    """EM of a model from one record, or several.

    free    of A, H, Q, R, x0, P0, by name
    forms   of Q and R: "full", "diagonal", "multiple" (of what it is)
    u       for each record
    """

    def __init__(self, model: Model, z: Sequence[ArrayLike], free: Sequence[str] = ("Q", "R"), *,
                 u: Optional[Sequence[Optional[ArrayLike]]] = None, Q_form: str = "full", R_form: str = "full",
                 arithmetic: str = "f64"):
        if np.any(model.unknown):
            raise KalmanqError("EM needs a known start: give P0 for every state")
        unknown = [name for name in free if name not in FREE]
        if unknown:
            raise KalmanqError(f"{unknown[0]} is no parameter: {', '.join(FREE)}")
        if arithmetic == "q31":
            raise KalmanqError("EM is in f32 and f64")
        self.model, self.parts = model, Parts(model, arithmetic)
        self._arrays = self._parameters()
        self._records = [self._record(z[k], None if u is None else u[k]) for k in range(len(z))]
        a = self.parts.arithmetic
        self._recordings = ffi.new(f"kq_recording_{a.name}[]", [made for made, _ in self._records])
        self._choice = ffi.new("kq_em_choice *", {
            "free": sum(FREE[name] for name in set(free)), "Q_form": FORMS[Q_form], "R_form": FORMS[R_form]})
        self._em = a.struct("em")
        longest = max(int(made["steps"]) for made, _ in self._records)
        require(a.function("em_assign")(self._em, model.n, model.m, *self.parts.memory(
            a.function("em_length")(model.n, model.m, longest))), "EM")
        require(a.function("em_init")(self._em, self._parameters_of_c, self._choice, self._recordings,
                                      len(self._records)), "EM")

    def _parameters(self) -> dict[str, np.ndarray]:
        model, a = self.model, self.parts.arithmetic
        noise = np.eye(model.G.shape[1]) if model.G is not None else model.Q
        arrays = {"A": model.A, "Q": noise, "H": model.H, "R": model.R, "x0": model.x0, "P0": model.P0}
        made = {name: np.array(array, a.number, order="C") for name, array in arrays.items()}
        fixed = {"B": model.B, "F": model.G}
        given = {name: self.parts.array(array) for name, array in fixed.items() if array is not None}
        self._parameters_of_c = ffi.new(f"kq_parameters_{a.name} *", {
            "controls": model.l, "noises": 0 if model.G is None else model.G.shape[1], **given,
            **{name: a.pointer(array) for name, array in made.items()}})
        return made

    def _record(self, z: ArrayLike, u: Optional[ArrayLike]) -> tuple[dict[str, Any], list[np.ndarray]]:
        a = self.parts.arithmetic
        given = rows_of(z, self.model.measurements, "z")
        if not len(given):
            raise KalmanqError("a record without rows")
        words = np.where(np.isnan(given), 0, given).astype(a.number)
        present = present_of(given).astype(np.uint16)
        controls = controls_of(u, self.model, len(given))
        controls = None if controls is None else np.ascontiguousarray(controls, a.number)
        kept = [words, present] + ([] if controls is None else [controls])
        return {"steps": len(given), "z": a.pointer(words), "present": a.pointer(present, "uint16_t"),
                "u": a.pointer(controls)}, kept

    def run(self, iterations: int = 200, tolerance: float = 1e-6,
            report: Optional[Callable[[int, float], None]] = None) -> Estimate:
        """Iterates until no parameter moves by more than `tolerance`, relative; `report(k, log_likelihood)`."""
        a, course, settled = self.parts.arithmetic, [], False
        for k in range(iterations):
            require(a.function("em_iterate")(self._em), "EM")
            course.append(float(a.function("em_log_likelihood")(self._em)))
            if report:
                report(k, course[-1])
            settled = bool(a.function("em_is_settled")(self._em, tolerance))
            if settled:
                break
        distance = float(a.function("em_distance")(self._em))
        model = self._estimated()
        last = self._likelihood(model)
        return Estimate(model, last, course + [last], settled, distance)

    def _estimated(self) -> Model:
        made = {name: np.asarray(array, np.float64).copy() for name, array in self._arrays.items()}
        for name in ("Q", "R", "P0"):
            made[name] = (made[name] + made[name].T) / 2
        if self.model.G is not None:
            noise = made.pop("Q")
            if not np.array_equal(noise, np.eye(len(noise))):
                made["Q"] = self.model.G @ noise @ self.model.G.T
                made["Q"] = (made["Q"] + made["Q"].T) / 2
        return self.model.changed(**made)

    def _likelihood(self, model: Model) -> float:
        from kalmanq.filters import Filter

        total = 0.0
        for made, kept in self._records:
            z = np.asarray(kept[0], np.float64).copy()
            bits = (kept[1][:, None] >> np.arange(model.m)) & 1
            z[bits == 0] = np.nan
            run = Filter(model, self.parts.arithmetic.name)
            run.run(z, kept[2].astype(np.float64) if len(kept) > 2 else None)
            total += run.log_likelihood
        return total
