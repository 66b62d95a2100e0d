"""Process, sensor and prior of a model, as the C core has them."""

from __future__ import annotations

from copy import copy
from dataclasses import replace
from functools import cached_property
from typing import Any, Callable, Optional, Sequence

import numpy as np

from kalmanq.core import Arithmetic, arithmetic_of, ffi, lib, require
from kalmanq.data.rows import controls_of, row_of
from kalmanq.errors import KalmanqError, ModelError, counted
from kalmanq.model import Model, Quantity
from kalmanq.model.column_model import refuse_rows
from kalmanq.model.spellings import require_model


WAYS = {
    "lean": "process and sensor are constants in flash, the sensor is lean: the least code",
    "tables": "process and sensor are constants in flash, with the full sensor",
    "init": "process and sensor are prepared and checked at the start",
    "sizes": "as init, compiled for these sizes: the fewest instructions, the most code",
}
CONSTANT = ("lean", "tables")  # the ways in which process and sensor are constants
LEAST_VARIANCE = 2.0**-120  # of a measurement in a constant sensor, kq_sensor_f32


class Parts:
    """What filters of one model share.  They keep it: the C structs refer to its arrays.

    way   "": as init makes them.  "lean", "tables", "init", "sizes": as the C file of `design` has them, so that a
          filter of them comes to the chip's very numbers
    """

    def __init__(self, model: Model, arithmetic: str, way: str = ""):
        require_model(model, Model, "NonlinearFilter and NonlinearSmoother take it")
        refuse_rows(model, "a constant filter", "give its rows to Filter.run or Smoother.run")
        self.model = model
        self.arithmetic = arithmetic_of(arithmetic)
        self.kept: list[Any] = []  # what C refers to, but for what process and sensor do
        self.takes_innovations = False
        if self.arithmetic.is_fixed:
            _take_formats(self)
        self._make_process()
        self._make_sensor()
        if self.arithmetic.is_fixed:
            _take_prior(self)
        if way:
            self._take_as(way)

    def _take_as(self, way: str) -> None:
        model, a = self.model, self.arithmetic
        if way not in WAYS or way not in ways_of(model):
            said = f"{model.name} cannot run as {way}, but as {', '.join(ways_of(model))}"
            raise KalmanqError(": ".join(filter(None, (said, not_lean(model)))))
        if way == "lean":
            given = (self.sensor_table, ffi.NULL) if a.is_fixed else (self.array(model.H), self.array(np.diag(model.R)))
            require(a.function("sensor_init_lean")(self.sensor, *given), "H, R")
        if way in CONSTANT:  # what the macros leave out
            a.function("process_as_table")(self.process)
            a.function("sensor_as_table")(self.sensor, way == "lean")

    def _make_process(self) -> None:
        self.process = self.arithmetic.struct("process")
        self._of_process = self._keeping(_fixed_process if self.arithmetic.is_fixed else _process)

    def _make_sensor(self) -> None:
        self.sensor = self.arithmetic.struct("sensor")
        self._of_sensor = self._keeping(_fixed_sensor if self.arithmetic.is_fixed else _sensor)

    def _keeping(self, make: Callable[[Parts], None]) -> list[Any]:
        """What C refers to in what it makes"""
        others, self.kept = self.kept, []
        make(self)
        made, self.kept = self.kept, others
        return made

    def take_innovations(self) -> None:
        """The sensor is to take innovations, not measurements."""
        self.takes_innovations = True
        self._make_sensor()

    def with_noise(self, name: str, given: np.ndarray) -> Parts:
        """With another Q, G or R; the rest is shared"""
        made = copy(self)
        made.model = self.model.with_noise(name, given)
        if name == "R":
            made._make_sensor()
        else:
            made._make_process()
        return made

    @property
    def zeros(self) -> tuple[list[int], list[int]]:
        """Where A is 0 and which components measure one state, as KQ_PROCESS_TABLE and KQ_SENSOR_TABLE take it."""
        return list(self.process.first)[: self.model.n], list(self.sensor.selects)[: self.model.m]

    def fractions(self, which: str) -> list[int]:
        """Fraction bits of the states, measurements or controls; 0 in floating point."""
        quantities = getattr(self.model, which)
        if not self.arithmetic.is_fixed:
            return [0] * len(quantities)
        return [self.formats[which][k].fraction for k in range(len(quantities))]

    def words(self, given: np.ndarray, which: str) -> np.ndarray:
        quantities = getattr(self.model, which)
        if which == "controls" and np.any(np.isnan(given)):
            row, column = map(int, np.argwhere(np.isnan(given))[0])
            raise KalmanqError(f"{quantities[column].name}: a control is missing", lib.KQ_ERR_NOT_FINITE, row)
        formats = self.formats[which] if self.arithmetic.is_fixed else None
        less = self.model.d if which == "measurements" and self.model.d is not None else 0.0
        return self.arithmetic.words(given, quantities, formats, which, less)

    def pushes(self, u: Any) -> Optional[np.ndarray]:
        """Words of a row of controls, 1 x l, or None; an offset's 1 is among them"""
        made = controls_of(None if u is None else row_of(u, len(self.model.inputs), "u"), self.model, 1)
        return None if made is None else self.words(made, "controls")

    def carried(self, controls: Optional[np.ndarray], left: Optional[np.ndarray], rows: int) -> Optional[np.ndarray]:
        """Words of controls as C reads them: at row t what moves the state from row t - 1, `left` at the first."""
        left = self.pushes(None) if left is None else left
        if rows == 0 or (controls is None and left is None):
            return None
        made = self.arithmetic.empty(rows, self.model.l)
        if controls is not None:
            made[1:] = controls[:-1]
        if left is not None:
            made[0] = left
        return made

    @property
    def covariance_scale(self) -> np.ndarray:
        fractions = np.array(self.fractions("states"))
        return fractions[:, None] + fractions[None, :]

    def array(self, given: np.ndarray) -> Any:
        """A pointer to numbers of floating point that stay."""
        a = self.arithmetic
        with np.errstate(over="ignore"):
            made = np.ascontiguousarray(given, a.number)
        if not np.all(np.isfinite(made)):
            raise KalmanqError(f"{self.model.name}: a number is beyond {a.name}: take other units")
        self.kept.append(made)
        return a.pointer(made)

    def memory(self, length: int) -> tuple[Any, int]:
        made = self.arithmetic.empty(int(length))
        self.kept.append(made)
        return self.arithmetic.pointer(made), int(length)

    def init_filter(self, filter_: Any, start: Any = None) -> None:
        """The state before the first measurement; start: of what is in part unknown, its kq_diffuse"""
        init, objects, unknown = self.arithmetic.function("filter_init" if start is None else "diffuse_init"), [filter_], []
        if start is not None:
            objects, unknown = [start, filter_], [sum(1 << int(i) for i in np.flatnonzero(self.model.unknown))]
        if self.arithmetic.is_fixed:
            require_fit(init, "the start", self.model, *objects, self.prior, *unknown)
        else:
            _require_held(init(*objects, *self._known, *unknown), "x0, P0", self.arithmetic)

    @cached_property
    def _known(self) -> tuple[Any, Any]:
        """x0 and P0, of floating point"""
        return self.array(self.model.x0), self.array(self.model.P0)


def ways_of(model: Model) -> list[str]:
    """The least code first"""
    return [*(["lean"] if not not_lean(model) else []), *(["tables"] if not _not_constant(model) else []), "init",
            *(["sizes"] if is_diagonal(model.R) else [])]


def not_lean(model: Model) -> str:
    """Why it does not run as lean; empty: it does"""
    repeating = [one.name for c, one in enumerate(model.measurements) if _rank(model.H[: c + 1]) <= c]
    return _not_constant(model) or (f"the row of H of {repeating[0]} repeats others: the full sensor finds what is redundant"
                                    if repeating else "")


def _not_constant(model: Model) -> str:
    """Why the sensor cannot be a constant; empty: it can"""
    if not is_diagonal(model.R):
        return "R is correlated, which init takes"
    zero = np.flatnonzero(np.diag(model.R) <= LEAST_VARIANCE)
    if len(zero):
        return f"R of {model.measurements[zero[0]].name} is 0 (2^-120 or less), which init and sizes take"
    return "the start is unknown, which init and sizes take" if np.any(model.unknown) else ""


def _rank(rows: np.ndarray) -> int:
    """As far as a float tells, in any units"""
    for axis in (0, 1):
        largest = np.abs(rows).max(axis=axis, keepdims=True)
        rows = rows / np.where(largest > 0, largest, 1)
    return int(np.linalg.matrix_rank(rows.astype(np.float32)))


def _process(parts: Parts) -> None:
    model, a, process = parts.model, parts.arithmetic, parts.process
    require(a.function("process_assign")(process, model.n, model.l, *parts.memory(
        a.length("process", model.n))), "process")
    A = parts.array(model.A)
    B = ffi.NULL if model.B is None else parts.array(model.B)
    if model.G is not None:
        F = parts.array(model.G)
        _require_held(a.function("process_init_factor")(process, A, B, F, model.G.shape[1]), "A, B, G", a)
    else:
        _require_held(a.function("process_init")(process, A, B, parts.array(model.Q)), "A, B, Q", a)


def _sensor(parts: Parts) -> None:
    model, a, sensor = parts.model, parts.arithmetic, parts.sensor
    require(a.function("sensor_assign")(sensor, model.n, model.m, *parts.memory(
        a.length("sensor", model.m))), "sensor")
    is_short = is_diagonal(model.R) and not parts.takes_innovations
    init = "sensor_init_diagonal" if is_short else "sensor_init_extended" if parts.takes_innovations else "sensor_init"
    _require_held(a.function(init)(sensor, parts.array(model.H), parts.array(np.diag(model.R) if is_short else model.R)), "H, R", a)


MOST = {"f32": "2^120", "f64": "2^1000"}  # a variance (process.h)


def _require_held(status: int, what: str, arithmetic: Arithmetic) -> None:
    """Of floating point, which has no formats that a value could be beyond"""
    if status == lib.KQ_ERR_RANGE:
        raise KalmanqError(f"{what}: a number is too large: in {arithmetic} a variance of a state, or a mean, is at most {MOST[arithmetic.name]}; take other units", status)
    require(status, what)


# ------------------------------------------------------------------------------ tables of q31


def _take_formats(parts: Parts) -> None:
    parts.formats = {which: prepare_formats(parts.model, which) for which in ("states", "measurements", "controls")}


def _fixed_process(parts: Parts) -> None:
    model, (states, _, controls) = parts.model, parts.formats.values()
    parts.process_table = ffi.new("kq_process_table_q31 *", {
        "states": model.n, "controls": model.l, "state_format": states, "control_format": controls if model.l else ffi.NULL,
        "transition": matrix(parts, "A", model.A, states, states),
        "control": matrix(parts, "B", model.B, states, controls) if model.l else ffi.NULL,
        "noise_root": noise_root(parts, states)})
    require_fit(lib.kq_process_init_q31, "A, B, Q", model, parts.process, parts.process_table)


def _fixed_sensor(parts: Parts) -> None:
    model, (states, measurements, _) = parts.model, parts.formats.values()
    parts.sensor_table = ffi.new("kq_sensor_table_q31 *", {
        "states": model.n, "components": model.m, "correlated": not is_diagonal(model.R), "state_format": states,
        "measurement_format": measurements,
        "measurement": matrix(parts, "H", model.H, measurements, states),
        "noise": sensor_noise(parts, measurements)})
    if parts.takes_innovations:
        require(lib.kq_sensor_init_extended_q31(parts.sensor, parts.sensor_table, ffi.NULL), "H, R")
    else:
        require_fit(lib.kq_sensor_init_q31, "H, R", model, parts.sensor, parts.sensor_table)


def _take_prior(parts: Parts) -> None:
    model, states = parts.model, parts.formats["states"]
    mean = prior_mean(parts, states)
    root = prepared(parts, "int32_t[]", lib.kq_length_q31(lib.KQ_OBJECT_ROOT, model.n, 0, 0, 0), "P0",
                    lambda out: lib.kq_root_prepare_q31(out, doubles(known_prior(model)), model.n, states))
    parts.prior = ffi.new("kq_prior_table_q31 *", {
        "states": model.n, "state_format": states, "mean": mean, "root": root})


def doubles(array: np.ndarray) -> Any:
    """float64 that C reads during a call; ffi keeps the copy for as long as it is referred to."""
    return ffi.new("double[]", np.ravel(array).tolist())


def prepared(parts: Parts, kind: str, length: int, what: str, prepare: Callable[[Any], int]) -> Any:
    made = ffi.new(kind, int(length))
    require(prepare(made), what)
    parts.kept.append(made)
    return made


def prepare_format(which: str, quantity: Quantity, made: Any) -> int:
    """Its fraction bits; made: a kq_format_q31"""
    fraction = lib.KQ_FRACTION_BEST_Q31 if quantity.fraction is None else quantity.fraction
    range_error = ffi.new("kq_range_error_q31 *")
    status = lib.kq_format_prepare_q31(made, fraction, quantity.range, range_error)
    if status == lib.KQ_ERR_RANGE and range_error.bits:
        raise ModelError(which, f"{quantity.name} needs {counted(range_error.bits, 'more integer bit')} for its range: give it fewer fraction bits, "
                         "or leave 'fractions' out")
    require(status, f"the format of {quantity.name}")
    return int(made.fraction)


def prepare_formats(model: Model, which: str) -> Any:
    quantities: Sequence[Quantity] = getattr(model, which)
    if which == "measurements" and model.d is not None:  # what is left without d
        quantities = [replace(one, range=None if one.range is None else one.range + abs(d)) for one, d in zip(quantities, model.d)]
    made = ffi.new("kq_format_q31[]", max(len(quantities), 1))
    for k, quantity in enumerate(quantities):
        if quantity.range is None:
            raise ModelError(which, f"{quantity.name} has no range, which fixed point needs: give the states and measurements ranges")
        prepare_format(which, quantity, made + k)
    return made


def matrix(parts: Parts, name: str, M: np.ndarray, rows: Any, columns: Any) -> Any:
    r, c = M.shape
    return prepared(parts, "kq_scaled_q31[]", r * c, name,
                    lambda out: lib.kq_matrix_prepare_q31(out, doubles(M), r, c, rows, columns))


def noise_root(parts: Parts, states: Any) -> Any:
    model = parts.model
    length = lib.kq_length_q31(lib.KQ_OBJECT_ROOT, model.n, 0, 0, 0)
    if model.G is None:
        return prepared(parts, "int32_t[]", length, "Q",
                        lambda out: lib.kq_root_prepare_q31(out, doubles(model.Q), model.n, states))
    r = model.G.shape[1]
    return prepared(parts, "int32_t[]", length, "G", lambda out: lib.kq_root_prepare_factor_q31(
        out, doubles(model.G), model.n, r, states))


def sensor_noise(parts: Parts, measurements: Any) -> Any:
    R, m = parts.model.R, parts.model.m
    if is_diagonal(R):
        return prepared(parts, "kq_scaled_q31[]", m, "R", lambda out: lib.kq_noise_prepare_diagonal_q31(
            out, doubles(np.diag(R)), m, measurements))
    return prepared(parts, "kq_scaled_q31[]", m * (m + 1) // 2, "R",
                    lambda out: lib.kq_noise_prepare_q31(out, doubles(R), m, measurements))


def prior_mean(parts: Parts, states: Any) -> Any:
    model = parts.model
    words = ffi.new("int32_t[]", model.n)
    require_fit(lib.kq_vector_prepare_q31, "x0", model, words, doubles(model.x0), model.n, states)
    parts.kept.append(words)
    return words


def known_prior(model: Model) -> np.ndarray:
    """P0 without what is not looked at."""
    known = ~model.unknown
    return model.P0 * np.outer(known, known)


def require_fit(call: Callable[..., int], what: str, model: Model, *given: Any) -> None:
    """As `require` of a call of q31; a range that does not fit with the name of whose it is"""
    range_error = ffi.new("kq_range_error_q31 *")
    status = call(*given, range_error)
    if status == lib.KQ_ERR_RANGE and range_error.quantity != lib.KQ_NO_RANGE_ERROR:
        which = {lib.KQ_STATE: "states", lib.KQ_CONTROL: "controls", lib.KQ_MEASUREMENT: "measurements"}
        quantities = getattr(model, which[range_error.quantity])
        name = quantities[range_error.component].name
        needs = (f"needs {counted(range_error.bits, 'more integer bit')}: give it a wider range, or fewer fraction bits" if range_error.bits else
                 "is beyond its declared range: declare a wider one")
        raise KalmanqError(f"{what}: {name} {needs}", status)
    require(status, what)


def is_diagonal(R: np.ndarray) -> bool:
    return not np.any(R - np.diag(np.diag(R)))
