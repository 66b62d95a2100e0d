"""What the C core is asked of a nonlinear step, in numbers of the arithmetic: as a firmware asks it."""

from __future__ import annotations

from typing import Any, Callable, Mapping

import numpy as np

from kalmanq.core import ffi, lib, nearest, require
from kalmanq.data.rows import present_of
from kalmanq.errors import KalmanqError, counted
from kalmanq.nonlinear.callbacks import Answer
from kalmanq.nonlinear.model import NonlinearModel
from kalmanq.run.parts import Parts, doubles

RULES = {"cubature": lib.KQ_SIGMA_POINTS_CUBATURE, "central": lib.KQ_SIGMA_POINTS_CENTRAL}


class Steps:
    """Predicts and updates of one filter.  It owns what its process and sensors refer to."""

    def __init__(self, model: NonlinearModel, parts: Parts):
        self.model, self.parts, self.arithmetic = model, parts, parts.arithmetic
        a, n, m = self.arithmetic, model.n, model.m
        self._A, self._H = (self._table(rows * n) for rows in (n, m))
        parts.take_innovations()
        self.noise = parts  # process and sensor with the noises of the row
        self._before = parts  # what the last process or sensor refers to stays
        self.loss: Any = None  # of the next update; None: a plain one
        if not a.is_fixed:
            self._y, self._J, self._E = a.empty(max(n, m)), a.empty(max(n, m) * n), a.empty(max(n, m) * n)
            self._R = a.empty(m, m)
            self._work = a.empty(2 * n * n + 3 * n + n * (n + 1) // 2 + m + 2 * m * n + m * m + m * (m + 1) // 2)
            self.process = self._assigned("process", n, 0, length=a.length("process", n))
            self.sensor = self._assigned("sensor", n, m, length=a.length("sensor", m))

    def _table(self, count: int) -> Any:
        if self.arithmetic.is_fixed:
            return ffi.new("kq_scaled_q31[]", count)
        return self.arithmetic.empty(count)

    def _assigned(self, stem: str, *sizes: int, length: int) -> Any:
        made = self.arithmetic.struct(stem)
        require(self.arithmetic.function(f"{stem}_assign")(made, *sizes, *self.parts.memory(length)), stem)
        return made

    def take(self, noises: Mapping[str, np.ndarray]) -> None:
        """Q, G or R of this row"""
        [(name, noise)] = noises.items()
        self.noise, self._before = self.noise.with_noise(name, noise), self.noise

    # ------------------------------------------------------------------ steps that are linear in x

    def predict(self, filter_: Any, A: np.ndarray, d: np.ndarray) -> None:
        """x <- x + d, P <- A P A' + Q"""
        process = self.noise.process
        self._change(self._A, A, "states", "A", f"process_change_{'jacobian' if self.arithmetic.is_fixed else 'transition'}", process)
        require(self._function("predict_extended")(filter_, process, self._pointer(self._states(d))), "predict")

    def measure(self, H: np.ndarray) -> Any:
        self._change(self._H, H, "measurements", "H", "sensor_change_measurement", self.noise.sensor)
        return self.noise.sensor

    def _change(self, table: Any, given: np.ndarray, rows: str, what: str, call: str, of: Any) -> None:
        """Coefficients of a process or a sensor"""
        if self.arithmetic.is_fixed:
            return self._fixed_table(table, given, rows, what, self._function(call), of)
        self._fill(table, given, what)
        require(self._function(call)(of, self._pointer(table)), what)

    def update(self, filter_: Any, made: Any, z: np.ndarray) -> np.ndarray:
        """By a prepared update, of the components that are there in z.  Answers the words of its innovation."""
        words, present = self._innovation(made.e), int(present_of(z[None])[0])
        if self.loss is None and made.by_points and np.all(~np.isnan(z)):
            made.by_points()
            return words
        name, given = ("update_subset", ()) if self.loss is None else ("update_robust", (self.loss,))
        require(self._function(name)(filter_, made.sensor, self._pointer(words), present, *given), "update")
        return words

    def try_update(self, filter_: Any, made: Any, z: np.ndarray) -> None:
        """As `update`, of a filter that goes ahead: a gate does not count what it rejects there"""
        loss = self.loss
        if loss is not None:
            self.loss = self.arithmetic.struct("loss")
            self.loss[0] = loss[0]
        self.update(filter_, made, z)
        self.loss = loss

    # ------------------------------------------------------------------ sigma points (f32, f64)

    def predict_points(self, filter_: Any, increment: Callable[[np.ndarray], np.ndarray], rule: str) -> None:
        answer = Answer(self.arithmetic, self.model.n, self.model.n, increment)
        answer.require(self._function("predict_sigma_points")(
            filter_, self.noise.process, answer.function, answer.context, RULES[rule], self._pointer(self._work)),
            "predict")

    def update_points(self, filter_: Any, innovation: Callable[[np.ndarray], np.ndarray], rule: str) -> None:
        answer = Answer(self.arithmetic, self.model.n, self.model.m, innovation)
        answer.require(self._function("update_sigma_points")(
            filter_, self.noise.sensor, answer.function, answer.context, RULES[rule], self._pointer(self._work)),
            "update")

    def linearise(self, at: Any, g: Callable[[np.ndarray], np.ndarray], rows: int,
                  rule: str) -> tuple[np.ndarray, np.ndarray]:
        """y (rows) and J (rows x n) as float64; E stays here for process_at or sensor_at."""
        answer = Answer(self.arithmetic, self.model.n, rows, g)
        answer.require(self._function("linearise")(
            at, answer.function, answer.context, rows, RULES[rule], *map(self._pointer, (self._y, self._J, self._E))),
            "linearise")
        J = self._J[: rows * self.model.n].reshape(rows, self.model.n)
        return self._y[:rows].astype(np.float64), J.astype(np.float64)

    def predict_at(self, filter_: Any, A: np.ndarray, d: np.ndarray) -> None:
        """As predict, with the noise that the last linearise has left, too."""
        self._fill(self._A, A, "A")
        require(self._function("process_linearise")(self.process, self.noise.process, self._pointer(self._A),
                                                    self._pointer(self._E)), "A")
        require(self._function("predict_extended")(filter_, self.process, self._pointer(self._states(d))), "predict")

    def measure_at(self, H: np.ndarray) -> Any:
        """As measure, with the noise that the last linearise has left, too."""
        self._fill(self._H, H, "H")
        require(self._function("sensor_linearise")(
            self.sensor, self.noise.sensor, *map(self._pointer, (self._H, self._E, self._R))), "H")
        return self.sensor

    # ------------------------------------------------------------------ numbers

    def _function(self, stem: str) -> Any:
        return self.arithmetic.function(stem)

    def _pointer(self, array: np.ndarray) -> Any:
        return self.arithmetic.pointer(array)

    def _fill(self, to: np.ndarray, given: np.ndarray, what: str) -> None:
        with np.errstate(over="ignore"):
            to[:] = np.ravel(given)
        if not np.all(np.isfinite(to)):
            raise KalmanqError(f"{what}: a number is beyond {self.arithmetic.name}: take other units")

    def _fixed_table(self, table: Any, given: np.ndarray, rows: str, what: str, change: Any, of: Any) -> None:
        """The coefficients in words of their formats; what does not fit is refused by name."""
        r, n = given.shape
        formats = self.parts.formats
        range_error = ffi.new("kq_range_error_q31 *")
        status = lib.kq_matrix_prepare_q31(table, doubles(given), r, n, formats[rows], formats["states"])
        if status == lib.KQ_OK:
            status = change(of, table, range_error)
        if status == lib.KQ_ERR_RANGE and range_error.quantity == lib.KQ_MEASUREMENT and range_error.bits:
            one = self.model.measurements[range_error.component]
            raise KalmanqError(f"{what}: {one.name} needs {counted(range_error.bits, 'more integer bit')}: a range of "
                               f"{one.range * 2.0**range_error.bits:g} has room", status)
        if status == lib.KQ_ERR_COEFFICIENT:
            with np.errstate(divide="ignore"):
                bits = np.log2(np.abs(given)) + np.subtract.outer(*map(self.parts.fractions, (rows, "states")))
            row, column = map(int, np.unravel_index(np.argmax(bits), bits.shape))
            raise KalmanqError(f"{what}[{getattr(self.model, rows)[row].name}, {self.model.states[column].name}] = "
                               f"{given[row, column]:g}: beyond the coefficients of q31", status)
        require(status, what)

    def _states(self, d: np.ndarray) -> np.ndarray:
        """An increment in the states' words"""
        if not self.arithmetic.is_fixed:
            words = self.arithmetic.empty(self.model.n)
            self._fill(words, d, "the increment")
            return words
        words = nearest(np.ldexp(d, self.parts.fractions("states")))
        wrong = np.abs(words) >= 2.0**31
        if np.any(wrong):
            i = int(np.argmax(wrong))
            raise KalmanqError(f"the increment of {self.model.states[i].name} is {d[i]:g}: beyond its word",
                               lib.KQ_ERR_RANGE)
        return words.astype(np.int32)

    def _innovation(self, e: np.ndarray) -> np.ndarray:
        try:
            return self.parts.words(e[None], "measurements")[0]
        except KalmanqError as problem:
            raise KalmanqError(f"innovation of {str(problem).split(': ', 1)[1]}", problem.status) from None
