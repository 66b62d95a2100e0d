"""A nonlinear model as a device over the library: its functions and derivatives are emitted, the library filters.

A predict that is A x + B u is a plain kq_predict; others take the increment and A (kq_predict_extended).  A sensor that is H x
is a plain one; others take innovations.  Entries of A and H that are constant are written once, in NAME_start.  What is not
linear is a function of x for sigma points, too, but of error states.  Q, G and R that are functions are worked out in each
predict and innovation, and process or sensor are initialised with them; sigma points are left out there.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Optional, Sequence

import numpy as np

from kalmanq.compiler.algorithm import equation_rounding
from kalmanq.compiler.algorithm.arithmetic import Arithmetic
from kalmanq.compiler.algorithm.equations import Equations, equations, reads
from kalmanq.compiler.given.request import Options, Request, refuse_over_library
from kalmanq.formulas.calculus import jacobian, substituted
from kalmanq.formulas.graph import Node, needed, node
from kalmanq.formulas.printing import Floats
from kalmanq.nonlinear import NonlinearModel
from kalmanq.nonlinear.model import Sensor


@dataclass(frozen=True)
class DeviceRequest(Request):
    @property
    def type(self) -> str:
        return f"{self.name}_device"


def refuse_options(options: Options) -> None:
    refuse_over_library(options, ("gate", "student", "nis", "smooth"))


def device(model: NonlinearModel, name: str, options: Options) -> Device:
    refuse_options(options)
    of = equations(model, name, options)
    return Device(of, DeviceRequest(**vars(of.given)))


class Device(Arithmetic):
    """A kq_filter, a kq_process and a kq_sensor of each sensor, in a struct with their memory"""

    code_includes = ("#include <math.h>", "")
    arrays = ()
    fields: Sequence[str] = ()  # its template has them

    def __init__(self, of: Equations, given: DeviceRequest):
        self.given, self.sensors, self.steady, self.live = given, of.sensors, None, ()
        self.nonlinear, self.model, self.T = of.model, given.model, given.options.arithmetic
        self.type = self.covariance_type = "float" if self.T == "f32" else "double"
        self.zero, self.words, self.n = "0.0f" if self.T == "f32" else "0.0", Floats(self.type), of.model.n
        self.has_errors, f = of.model.has_errors, of.model.formulas
        self.A, self.H, self.e, self.change, self.moved = f.transition, list(f.measurement), f.innovation, f.change, f.moved
        self.corrected = f.corrected if self.has_errors else []
        self.Q, self.R, self.is_root = f.noise_of_step, f.noise_of_sensors, "G" in of.model.given  # None: constant
        self.B = None if self.Q else self._controlled()
        self.plain = [one for one in self.sensors if self._is_plain(one)]
        self.bent = [one for one in self.sensors if one not in self.plain]
        self.iterates = given.options.iterate > 1 and bool(self.bent)
        self.variances = [self._variance(one, j) for one in self.sensors for j in range(one.m)]
        single = " " if self.has_errors else "x"
        which = equation_rounding.chosen(of.model, self.e, self.H, self.variances, single) if self.T == "f32" else {}
        looked_at = equation_rounding.watched(self.e, which, single)
        self.watched = {j: square for one in self.bent for j, square in looked_at.items() if one.first <= j < one.first + one.m}
        self.moves_points = not self.has_errors and self.B is None and not self.Q
        self.measures_points = [] if self.has_errors else [one for one in self.bent if not self.has_spread(one)]
        has_points = self.moves_points or self.measures_points
        self.includes = [f"#include <kalmanq/{'sigma_points' if has_points else 'extended'}.h>"]

    # ---- what is linear

    def _controlled(self) -> Optional[np.ndarray]:
        """B, where f is A x + B u"""
        f = self.nonlinear.formulas
        slopes = None if self.has_errors else _linear(self.change, [*f.x, *f.u])
        if slopes is None:
            return None
        self.A = [[node(float(one)) for one in row] for row in slopes[:, :self.n] + np.eye(self.n)]
        return slopes[:, self.n:]

    def _is_plain(self, sensor: Sensor) -> bool:
        """Is it H x?"""
        f, own = self.nonlinear.formulas, range(sensor.first, sensor.first + sensor.m)
        if self.has_errors or self.has_spread(sensor) or "innovation" in f.given or any(j in own for j in f.angles):
            return False
        slopes = _linear([f.expected[j] for j in own], list(f.x))
        for j in own if slopes is not None else ():
            self.H[j] = [node(float(one)) for one in slopes[j - sensor.first]]
        return slopes is not None

    def has_spread(self, sensor: Sensor) -> bool:
        """Is R a function?"""
        return bool(self.spreads(sensor)) and not all(one.is_constant for one in self.spreads(sensor))

    def spreads(self, sensor: Sensor) -> list[Node]:
        """Formulas of R, or of its variances; empty: all sensors' are constant"""
        own = range(sensor.first, sensor.first + sensor.m) if self.R else ()
        if self.is_diagonal(sensor):
            return [self.R[j][j] for j in own]
        return [self.R[min(j, k)][max(j, k)] for j in own for k in own]

    def _variance(self, sensor: Sensor, j: int) -> Node:
        """Of component j, given the other ones where their noises are constant"""
        if self.R:
            return self.R[sensor.first + j][sensor.first + j]
        return node(float(1 / np.linalg.inv(self.noise(sensor))[j, j]))

    @property
    def noises(self) -> list[Node]:
        """Formulas of Q, or of G"""
        rows = self.Q or []
        return [one for row in rows for one in row] if self.is_root else \
            [rows[min(i, k)][max(i, k)] for i in range(len(rows)) for k in range(len(rows))]

    def rows_of(self, sensor: Sensor) -> list[Node]:
        """Of H"""
        return [one for row in self.H[sensor.first:sensor.first + sensor.m] for one in row]

    @property
    def transition(self) -> list[Node]:
        return [one for row in self.A for one in row]

    # ---- what the text of the straight-line filter asks for

    def predicts_by(self, which: str) -> bool:
        return reads(which, [*(self.moved if self.has_errors else self.change), *self.transition, *self.noises])

    def updates_by(self, sensor: Sensor, which: str) -> bool:
        return reads(which, [*self.innovations(sensor), *self.rows_of(sensor), *self.spreads(sensor)])

    def row_fields(self) -> list[tuple[str, str]]:
        """What the functions for sigma points read of a row: declarations and names"""
        rows = self.change if self.moves_points else []
        rows = [*rows, *(one for sensor in self.measures_points for one in self.innovations(sensor))]
        return [(f"{self.type} {name}" if "t" in name else f"const {self.type} *{name}", name) for name in ("z", "u", "t", "dt")
                if reads(name, rows)]

    def innovations(self, sensor: Sensor) -> list[Node]:
        return list(self.e[sensor.first:sensor.first + sensor.m])

    def number(self, value: float) -> str:
        return self.words.number(float(value))

    literal = number

    def raw(self, which: str, k: int, value: float) -> float:
        return value

    def mean_text(self, i: int) -> str:
        return f"f->x[{i}]" if self.has_errors else f"kq_mean_{self.T}(&f->filter, {i})"

    def length(self, sensor: Sensor) -> str:
        return f"KQ_SENSOR_{'DIAGONAL_' if self.is_diagonal(sensor) else ''}LEN({sensor.m})"

    def noise(self, sensor: Sensor) -> np.ndarray:
        own = slice(sensor.first, sensor.first + sensor.m)
        return np.asarray(self.nonlinear.frame.R)[own, own]

    def is_diagonal(self, sensor: Sensor) -> bool:
        own = range(sensor.first, sensor.first + sensor.m)
        if self.R:
            return all(self.R[j][k].equals(0) for j in own for k in own if j != k)
        R = self.noise(sensor)
        return bool(np.all(R == np.diag(np.diag(R))))

    def routines(self, text: str) -> str:
        return "\n"

    def tables(self) -> dict[str, Any]:
        """Numbers of its C"""
        model = self.nonlinear
        made = {"constant_A": self.transition, "B": self.B.ravel() if self.B is not None else [], "first": model.x0, "P0": np.ravel(model.P0),
                "noise": [] if self.Q else np.ravel(model.Q if model.G is None else model.G)}
        return {name: [self._entry(one) for one in values] for name, values in made.items()}

    def tables_of(self, sensor: Sensor) -> dict[str, Any]:
        R = self.noise(sensor)
        spread = [] if self.has_spread(sensor) else np.diag(R) if self.is_diagonal(sensor) else R.ravel()
        return {"constant_H": [self._entry(one) for one in self.rows_of(sensor)], "R": [self._entry(one) for one in spread]}

    def _entry(self, one: object) -> str:
        if isinstance(one, Node):
            return self.number(one.value) if one.is_constant else self.zero
        return self.number(float(one))  # type: ignore[arg-type]


def field(sensor: Sensor) -> str:
    return f"sensor{sensor.suffix}"


def _linear(rows: Sequence[Node], by: Sequence[Node]) -> Optional[np.ndarray]:
    """The matrix, where the rows are this matrix times `by`"""
    if any(part.op not in ("constant", "symbol", "add", "sub", "mul") for part in needed(rows)[0]):
        return None
    slopes = jacobian(rows, by)
    at_none = [substituted(one, {each.args[0]: 0.0 for each in by}, {}) for one in rows]
    if not all(one.is_constant for row in slopes for one in row) or not all(one.equals(0) for one in at_none):
        return None
    return np.array([[one.value for one in row] for row in slopes], float).reshape(len(rows), len(by))


def varies(entries: Sequence[Node]) -> bool:
    return not all(one.is_constant for one in entries)
