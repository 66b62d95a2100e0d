"""A nonlinear model as a device over the library in q31: formulas in fixed point, formats from records."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, Callable, Mapping, Sequence

import numpy as np

from kalmanq.compiler.algorithm.equation_device import Device, DeviceRequest, refuse_options
from kalmanq.compiler.algorithm.equations import Equations, equations
from kalmanq.compiler.algorithm.fixed import functions as fixed_functions
from kalmanq.compiler.algorithm.fixed.formats import RawValues
from kalmanq.compiler.algorithm.fixed.formulas import FixedFormulas, Input, formulas_for
from kalmanq.compiler.algorithm.fixed.tables import constants, fraction_of
from kalmanq.compiler.algorithm.fixed.values import MARGIN, Seen, Values, fraction_for, largest, lowered
from kalmanq.compiler.given.cells import formats, scaled, words
from kalmanq.compiler.given.request import Options
from kalmanq.core import lib
from kalmanq.errors import KalmanqError
from kalmanq.formulas.graph import Node
from kalmanq.formulas.program import Program
from kalmanq.model import Model, Quantity
from kalmanq.nonlinear import NonlinearModel
from kalmanq.nonlinear.model import Sensor
from kalmanq.run.parts import Parts

ROWS = 300  # of the records, in which no word of a formula may be beyond its end
LEAST_FRACTION = -64  # KQ_FRACTION_MIN_Q31
ROOM = 16.0  # of a row of A or H in raw values, at most
EVENTS = (("SATURATED", "a value of a formula was beyond its format: the nearer end was taken"),
          ("NO_VALUE", "a division by 0, a root or a logarithm of a negative number, a nominal number beyond its format: "
                      "the call was refused"))


@dataclass(frozen=True)
class Evaluated:
    """Formulas of a call.  words: 32 bits each, with their fractions; table: entries of A or H by place, with 2^exponent"""

    formulas: FixedFormulas
    words: Sequence[str]
    table: Sequence[tuple[int, str]]
    run: Callable[..., list[Any]]


def fixed_device(model: NonlinearModel, name: str, options: Options, seen: Seen) -> FixedDevice:
    refuse_options(options)
    if options.iterate > 1:
        raise KalmanqError("--iterate: q31 linearises an update once: leave --iterate out, or take --arith f32")
    of = equations(model, name, replace(options, arithmetic="f64"))
    return FixedDevice(of, DeviceRequest(**{**vars(of.given), "options": options}), seen)


class FixedDevice(RawValues, Device):
    code_includes = ()

    def __init__(self, of: Equations, given: DeviceRequest, seen: Seen):
        super().__init__(of, given)
        self.type = self.covariance_type = "int32_t"
        self.zero, self.seen = "0", seen
        self.moves_points, self.measures_points, self.includes = False, [], ["#include <kalmanq/extended.h>"]
        model = self.nonlinear
        self.states, self.controls, self.carried = (self._all_ranged(*one) for one in (
            (model.states, "d" if self.has_errors else "x"), (model.controls, "u"), (model.carried, "x")))
        self.d, self.u, self.x = ([fraction_of(one) for one in which] for which in (self.states, self.controls, self.carried))
        if self.B is not None and not self._has_room():
            self.B = None
        self.plain = [one for one in self.plain if self._fits(one)]
        self.lacks: dict[int, int] = {}  # integer bits that a declared range lacks for H, by component
        self.taken = [self._measured(one, j) for one in self.sensors for j in range(one.first, one.first + one.m)]
        self.z = [fraction_of(one) if self.is_plain(j) else fraction_for(seen.largest("z", j), 31 - MARGIN)
                  for j, one in enumerate(self.taken)]
        self.e = list(self.e)
        self.model = given.model.changed(states=self.states, measurements=self.taken, controls=self.controls)
        self.process = self._process()
        self.parts = {one.name: self._sensor_parts(one) for one in self.sensors}
        rows = (self.moved, self.x) if self.has_errors else (self.change, self.d)
        table = self.transition, np.subtract.outer(self.d, self.d)
        self.predicted = None if self.B is not None else self._evaluated(*rows, seen.before, *table)
        self.resetting = self._evaluated(self.corrected, self.x, seen.before) if self.has_errors else None
        self.measured_by = {one.name: self._innovation(one) for one in self.sensors if one not in self.plain}

    # ---- formats

    def _all_ranged(self, which: Sequence[Quantity], stem: str) -> list[Quantity]:
        return [_ranged(one, self.seen.largest(stem, k)) for k, one in enumerate(which)]

    def is_plain(self, j: int) -> bool:
        return any(one.first <= j < one.first + one.m for one in self.plain)

    def _has_room(self) -> bool:
        """In A and B of a plain predict"""
        A, B = self._constants(self.transition).reshape(self.n, self.n), self.B
        rows = np.abs(A) * 2.0 ** np.subtract.outer(self.d, self.d), np.abs(B) * 2.0 ** np.subtract.outer(self.d, self.u)
        return bool(np.all(rows[0].sum(axis=1) + rows[1].sum(axis=1) <= ROOM))

    def _fits(self, sensor: Sensor) -> bool:
        """A plain sensor whose format has room for H x"""
        H = np.abs(self._constants(self.rows_of(sensor)).reshape(sensor.m, self.n)) * 2.0 ** -np.array(self.d, float)
        own = range(sensor.first, sensor.first + sensor.m)
        ranged = [_ranged(self.nonlinear.measurements[j], self.seen.largest("z", j)) for j in own]
        return all(one.sum() * 2.0 ** fraction_of(other) <= ROOM for one, other in zip(H, ranged))

    @staticmethod
    def _constants(entries: Sequence[Node]) -> np.ndarray:
        return np.array([one.value if one.is_constant else 0.0 for one in entries])

    def _measured(self, sensor: Sensor, j: int) -> Quantity:
        """With its range: of z, or of an innovation"""
        one = self.nonlinear.measurements[j]
        if sensor in self.plain:
            return _ranged(one, self.seen.largest("z", j))
        room = self._room(j)
        if one.range is not None:
            if fraction_of(one) > room:
                self.lacks[j] = fraction_of(one) - room
            return one
        roots = lowered([self.e[j]])
        fraction = min(fraction_for(largest(roots, self.seen.at)[id(roots[0])], 31 - MARGIN), room - 1, 94)
        return Quantity(one.name, one.unit, (2**31 - 1) * 2.0**-fraction, fraction)

    def _room(self, j: int) -> int:
        """The most fraction bits of component j with which its row of H has room, in the records"""
        values = Program(lowered(self.H[j])).values(self.seen.at)
        rows = sum(np.abs(np.asarray(value, float)) * 2.0**-n for value, n in zip(values, self.d))
        most = float(np.max(np.where(np.isfinite(rows), rows, 0.0)))
        return math.floor(math.log2(ROOM / most)) if most else 94

    def fraction(self, which: str, k: int) -> int:
        return {"states": self.d, "carried": self.x, "measurements": self.z, "controls": self.u}[which][k]

    def innovation_fraction(self, j: int) -> int:
        return fraction_of(self.taken[j])

    def enumerators(self) -> list[str]:
        given, upper = self.given, self.given.upper
        rows = [*zip(given.states, self.d), *zip(given.nominal, self.x)]
        rows += [(f"z_{name}", self.z[j]) for j, name in enumerate(given.measurements)]
        rows += [(f"e_{name}", self.innovation_fraction(j)) for j, name in enumerate(given.measurements) if not self.is_plain(j)]
        rows += [(f"u_{name}", self.u[k]) for k, name in enumerate(given.controls)]
        events = [f"{upper}_{name} = {1 << bit}, /* {what} */" for bit, (name, what) in enumerate(EVENTS)]
        fractions = [f"{upper}_{name.upper()}_FRACTION = {fraction}," for name, fraction in rows]
        return [*_enumeration("f->events: bits that stay set until you clear them", events),
                *_enumeration("value = raw value 2^-FRACTION; e: of innovations", fractions)]

    # ---- the library's tables

    def _process(self) -> Parts:
        model, n = self.given.model, self.n
        A = np.eye(n) if self.B is None else self._constants(self.transition).reshape(n, n)
        more = {"B": self.B, "controls": self.controls} if self.B is not None and self.B.size else {}
        more.update({"G": model.G} if model.G is not None else {"Q": model.Q})
        return Parts(Model(A, H=np.zeros((1, n)), R=1.0, x0=model.x0, P0=model.P0, states=self.states,
                           measurements=[Quantity("z", "", 1.0)], **more), "q31")

    def _sensor_parts(self, sensor: Sensor) -> Parts:
        n = self.n
        H = self._constants(self.rows_of(sensor)).reshape(sensor.m, n)
        made = Parts(Model(np.eye(n), H=H, R=self.noise(sensor), Q=np.zeros((n, n)), x0=self.given.model.x0, P0=self.given.model.P0,
                           states=self.states, measurements=self.taken[sensor.first:sensor.first + sensor.m]), "q31")
        if sensor not in self.plain:
            made.take_innovations()
        return made

    # ---- formulas

    def _rows(self, inputs: Mapping[str, Input], values: Values) -> list[dict[str, int]]:
        """Raw values of some of the records' rows"""
        names = [name for name in inputs if name in values]
        rows = np.array([np.ldexp(values[name], inputs[name].fraction) for name in names]).T
        rows = np.rint(rows[np.all(np.abs(rows) < 2.0**31, axis=1)])  # NaN: not measured
        some = rows[::max(1, len(rows) // ROWS)].astype(int).tolist()
        return [{**dict.fromkeys(inputs, 0), **dict(zip(names, row))} for row in some]

    def _inputs(self) -> dict[str, Input]:
        stems = {"x": self.x, "u": self.u, "z": self.z, "d": self.d if self.has_errors else ()}
        made = {f"{stem}{k}": Input(fraction) for stem, which in stems.items() for k, fraction in enumerate(which)}
        return {**made, "t": Input(0)}

    def _evaluated(self, words: Sequence[Node], fractions: Sequence[int], values: Values, table: Sequence[Node] = (),
                   exponents: np.ndarray = np.zeros(0)) -> Evaluated:
        places = [k for k, one in enumerate(table) if not one.is_constant]
        roots = lowered([*words, *(table[k] for k in places)])
        inputs = self._inputs()
        made = formulas_for(roots, inputs, largest(roots, values), self._rows(inputs, values))
        is_kept = words is self.moved or words is self.corrected
        given = [made.out(one, fraction, is_kept) for one, fraction in zip(roots, fractions)]
        scaled = [(k, made.out_scaled(one, int(exponents.ravel()[k]))) for k, one in zip(places, roots[len(words):])]
        return Evaluated(made, given, scaled, made.python([*given, *(text for _, text in scaled)]))

    def _innovation(self, sensor: Sensor) -> Evaluated:
        own = range(sensor.first, sensor.first + sensor.m)
        fractions = [self.innovation_fraction(j) for j in own]
        return self._evaluated([self.e[j] for j in own], fractions, self.seen.at, self.rows_of(sensor),
                               np.subtract.outer(fractions, self.d))

    # ---- the text

    def varies(self, sensor: Sensor) -> bool:
        return sensor not in self.plain and bool(self.measured_by[sensor.name].table)

    def raws(self, which: str, values: Sequence[float]) -> list[int]:
        return [self.raw(which, k, value) for k, value in enumerate(values)]

    @property
    def first(self) -> list[int]:
        """Nominal numbers at the start"""
        return [round(math.ldexp(value, n)) for value, n in zip(self.nonlinear.x0, self.x)]

    def routines(self, text: str) -> str:
        return fixed_functions.routines(text) + "\n"

    def tables(self) -> dict[str, Any]:
        n, l, table, prior = self.n, self.B.shape[1] if self.B is not None else 0, self.process.process_table, self.process.prior
        root = int(lib.kq_length_q31(lib.KQ_OBJECT_ROOT, n, 0, 0, 0))
        return {"state_format": formats(self.process.formats["states"], n), "transition": scaled(table.transition, n * n),
                "control_format": formats(self.process.formats["controls"], l) if l else [], "control": scaled(table.control, n * l) if l else [],
                "noise_root": words(table.noise_root, root), "first_mean": words(prior.mean, n), "first_root": words(prior.root, root),
                "constant_A": constants(self.transition, np.subtract.outer(self.d, self.d).ravel()) if self.predicted else [],
                "first": words(self.first, len(self.x)) if self.has_errors else []}

    def tables_of(self, sensor: Sensor) -> dict[str, Any]:
        n, m, parts = self.n, sensor.m, self.parts[sensor.name]
        table = parts.sensor_table
        return {"format": formats(parts.formats["measurements"], m), "constant_H": scaled(table.measurement, m * n),
                "R": scaled(table.noise, m if self.is_diagonal(sensor) else m * (m + 1) // 2)}


def _ranged(one: Quantity, most: float) -> Quantity:
    """Where none is declared, with MARGIN bits more than the records have used"""
    if one.range is not None:
        return one
    fraction = fraction_for(most, 31 - MARGIN) if one.fraction is None else one.fraction
    if fraction < LEAST_FRACTION:
        raise KalmanqError(f"{one.name}: the records reach {most:.3g}, which no format of q31 holds: use another unit, "
                           "or --arith f32")
    return Quantity(one.name, one.unit, (2**31 - 1) * 2.0**-fraction, fraction)


def _enumeration(remark: str, rows: Sequence[str]) -> list[str]:
    last = rows[-1].replace(",", "", 1)
    return [f"/* {remark} */", "enum {", *(f"    {one}" for one in [*rows[:-1], last]), "};", ""]
