"""The C core's E-step over one set of arrays: log-likelihood and gradient, as often as they are wanted (em.h)."""

from __future__ import annotations

from typing import Any, Iterator, Mapping, Optional, Sequence, Union

import numpy as np
from numpy.typing import ArrayLike

from kalmanq.core import ffi, lib, require
from kalmanq.data.rows import Rows, Varying, present_of, rows_of
from kalmanq.errors import KalmanqError
from kalmanq.model import ColumnModel, Model
from kalmanq.model.spellings import require_model
from kalmanq.nonlinear import NonlinearModel
from kalmanq.nonlinear.filters import rows_at
from kalmanq.run.filters import Smoother
from kalmanq.run.parts import Parts

FREE = {"A": lib.KQ_EM_A, "H": lib.KQ_EM_H, "Q": lib.KQ_EM_Q, "R": lib.KQ_EM_R, "x0": lib.KQ_EM_X0,
        "P0": lib.KQ_EM_P0}
FORMS = {"full": lib.KQ_EM_FULL, "diagonal": lib.KQ_EM_DIAGONAL, "multiple": lib.KQ_EM_MULTIPLE}
# A start that is in part unknown has variances far beyond what the data say
FAR = 1e12  # times the variance of the first state given all rows
EXACT = 1e6  # times the variance of the measurements, of a state that is measured without noise or not at all


class Records:
    """Rows that have been looked at once: z (T x m; NaN: missing) and u (T x l, or None) of each record; `times` (T, or None)
    where not all steps are dt, otherwise None.  varying: of each, whose matrices are not looked at"""

    def __init__(self, model: Union[Model, NonlinearModel], z: Sequence[ArrayLike], u: Optional[Sequence[Optional[ArrayLike]]] = None,
                 times: Optional[Sequence[Optional[ArrayLike]]] = None, varying: Optional[Sequence[Varying]] = None):
        if not isinstance(model, NonlinearModel):
            require_model(model, Model, "")
        if hasattr(z, "index") and not isinstance(z, (list, tuple)) or isinstance(z, np.ndarray) and z.ndim == 1:
            raise KalmanqError("z: one record: give a list of them, [z]")
        for name, one in (("u", u), ("times", times)):
            if one is not None and len(one) != len(z):
                raise KalmanqError(f"{name} has {len(one)} records, z has {len(z)}")
        given = [[None] * len(z) if one is None else one for one in (u, times, varying)]
        made = [rows_at(model, *one[:3]) if isinstance(model, NonlinearModel) else Rows.of(model, *one) for one in zip(z, *given)]
        self.z, self.u = [one.z for one in made], [one.u for one in made]
        if isinstance(model, ColumnModel):
            self.u = [rows_of(one[0] if one[1] is None else one[1], model.inputs, "u") for one in zip(z, given[0])]
        if not self.z:
            raise KalmanqError("there is no record")
        if not all(map(len, self.z)):
            raise KalmanqError("a record without rows")
        if any(np.any(np.isinf(one)) for one in self.z):
            raise KalmanqError("z: a measurement is not finite")
        at, of = [one.times for one in made], getattr(model, "continuous", None)
        self.times = at if any(one is not None and (of is None or np.any(of.between(one) != of.dt)) for one in at) else None

    def require_steps(self, what: str) -> None:
        """Of what knows nothing of times"""
        if self.times is not None:
            raise KalmanqError(f"{what}: of records whose rows are dt apart: fit and likelihood take others")

    def __len__(self) -> int:
        return len(self.z)

    def each(self) -> Iterator[tuple[np.ndarray, Any, Optional[np.ndarray]]]:
        """z, u and times of each record"""
        return zip(self.z, self.u, self.times or [None] * len(self))

    def rows(self, model: Model) -> list[Rows]:
        """Of each record, its measurements without the model's offset"""
        return [Rows.of(model, z if model.d is None else z - model.d, u, times) for z, u, times in self.each()]

    @property
    def steps(self) -> int:
        return sum(map(len, self.z))

    @property
    def measurements(self) -> int:
        return sum(int(np.sum(~np.isnan(one))) for one in self.z)


def known_start(model: Model, records: Records) -> tuple[np.ndarray, np.ndarray]:
    """x0 (n) and P0 (n x n) with FAR times the smoothed variance for each unknown state, around its smoothed mean.

    The log-likelihood is then the exact one less half the logarithms of these variances, and its gradient the
    exact one but for 1 / FAR of its size: the unknown direction has no slope (Durbin and Koopman 2012, ch. 5).
    """
    means, variances = [], []
    for z, u in zip(records.z, records.u):
        run = Smoother(model).run(z, u)
        means.append(run.smoothed[0])
        variances.append(run.smoothed_sigma[0] ** 2)
    x0, P0 = model.x0.copy(), np.array(model.P0)
    unknown = model.unknown
    mean, variance = np.nanmean(means, axis=0), np.nanmax(variances, axis=0)
    spread = max(float(np.max(np.nanvar(z[:, ~np.all(np.isnan(z), axis=0)], axis=0), initial=0.0))
                 for z in records.z)
    P0[unknown], P0[:, unknown] = 0, 0
    P0[unknown, unknown] = np.fmax(FAR * variance, EXACT * spread)[unknown]
    P0[unknown, unknown] = np.where(P0[unknown, unknown] > 0, P0[unknown, unknown], 1.0)
    if not np.all(np.isfinite(P0)):
        raise KalmanqError("P0 of the diffuse start: the records are so large that no variance stands for it: give P0, or take other units")
    x0[unknown] = np.where(np.isfinite(mean), mean, 0.0)[unknown]
    return x0, P0


class Expectation:
    """E-steps with the numbers that are in `arrays`: A, H, R, x0, P0, and Q of the noises (r x r, Q = F Q F').

    Nothing is made anew from one E-step to the next: write into the arrays, then `run`.
    An unknown state begins with a variance far beyond what the data say (known_start).
    """

    def __init__(self, model: Model, records: Records, *, free: Sequence[str] = tuple(FREE), noise: Any = None,
                 forms: Sequence[str] = ("full", "full"), held: Optional[Mapping[str, np.ndarray]] = None,
                 arithmetic: str = "f64"):
        if arithmetic == "q31":
            raise KalmanqError("EM is in f32 and f64")
        self.model, self.parts, self.evaluations = model, Parts(model, arithmetic), 0
        self.steps = 2 * records.steps
        F, Q = (model.G, np.eye(model.G.shape[1])) if noise is None and model.G is not None else \
            noise or (None, model.Q)  # noise: F and Q of it
        x0, P0 = known_start(model, records) if np.any(model.unknown) else (model.x0, model.P0)
        a = self.parts.arithmetic
        self.arrays = {name: np.array(array, a.number, order="C") for name, array in
                       {"A": model.A, "Q": Q, "H": model.H, "R": model.R, "x0": x0, "P0": P0}.items()}
        self._kept: list[Any] = []
        self._bind(records, F, free, forms, held or {})

    def _bind(self, records: Records, F: Any, free: Sequence[str], forms: Sequence[str],
              held: Mapping[str, np.ndarray]) -> None:
        a, model = self.parts.arithmetic, self.model
        given = {name: self.parts.array(array) for name, array in (("B", model.B), ("F", F)) if array is not None}
        made = [self._record(z, u) for z, u in zip(records.z, records.u)]
        masks = {f"{name}_held": self._mask(held[name]) for name in ("A", "H") if name in held}
        given_to_c = [
            ffi.new(f"kq_parameters_{a.name} *", {
                "controls": model.l, "noises": 0 if F is None else F.shape[1], **given,
                **{name: a.pointer(array) for name, array in self.arrays.items()}}),
            ffi.new("kq_em_choice *", {"free": sum(FREE[name] for name in set(free)), "Q_form": FORMS[forms[0]],
                                       "R_form": FORMS[forms[1]], **masks}),
            ffi.new(f"kq_recording_{a.name}[]", made)]
        self._kept += given_to_c
        self.em, self._advance = a.struct("em"), a.function("em_advance")
        require(a.function("em_assign")(self.em, model.n, model.m, *self.parts.memory(
            a.length("em", model.n, model.m, max(map(len, records.z))))), "fit")
        self._init = lambda: a.function("em_init")(self.em, *given_to_c, len(records))
        self.status = self._init()
        self._slopes = {name: np.zeros_like(array) for name, array in self.arrays.items()
                        if name in ("Q", "R", "P0") or name in free}
        self._gradient = ffi.new(f"kq_gradient_{a.name} *", {
            name: a.pointer(array) for name, array in self._slopes.items()})

    def _mask(self, held: np.ndarray) -> Any:
        self._kept.append(np.ascontiguousarray(held, np.uint8))
        return ffi.cast("uint8_t *", self._kept[-1].ctypes.data)

    def _record(self, z: np.ndarray, u: Optional[np.ndarray]) -> dict[str, Any]:
        a = self.parts.arithmetic
        words = np.ascontiguousarray(np.where(np.isnan(z), 0, z), a.number)
        present = present_of(z).astype(np.uint16)
        controls = None if u is None else np.ascontiguousarray(u, a.number)
        self._kept += [words, present, controls]
        return {"steps": len(z), "z": a.pointer(words), "present": a.pointer(present, "uint16_t"),
                "u": a.pointer(controls)}

    def begin(self) -> int:
        """Forgets what iterations have been; its status."""
        self.status = self._init()
        return self.status

    def run(self) -> int:
        """The E-step; its status."""
        self.evaluations += 1
        advance, em, status = self._advance, self.em, 0
        for _ in range(self.steps):
            status = advance(em)
            if status:
                break
        return status

    @property
    def log_likelihood(self) -> float:
        return float(self.parts.arithmetic.function("em_log_likelihood")(self.em))

    def iterate(self) -> int:
        """Of EM; its status"""
        self.evaluations += 1
        return self.parts.arithmetic.function("em_iterate")(self.em)

    @property
    def change(self) -> float:
        """The largest one of the last iteration (em.h)"""
        return float(self.parts.arithmetic.function("em_change")(self.em))

    @property
    def distance(self) -> float:
        """Of the log-likelihood from the maximum that iterations go to, extrapolated; NaN: not known."""
        return float(self.parts.arithmetic.function("em_distance")(self.em))

    def gradient(self) -> dict[str, np.ndarray]:
        """After `run`: as kq_gradient has it, entries of a covariance independent; of arrays that stay."""
        require(self.parts.arithmetic.function("em_gradient")(self.em, self._gradient), "gradient")
        return self._slopes
