"""f32 and f64 of a nonlinear model: its functions and their derivatives as formulas, in the form of FloatFilter.

All formulas of a predict or of a sensor are worked out at the mean before it; the components of a sensor then correct it
one after the other.  A call whose formulas are not finite changes nothing.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Callable, Mapping, Optional, Sequence

import numpy as np

from kalmanq.compiler.algorithm import back, equation_rounding, ud
from kalmanq.compiler.algorithm.coefficients import Constant
from kalmanq.compiler.algorithm.floats import MOST, FloatFilter, Mean, entry
from kalmanq.compiler.algorithm.ud import carried
from kalmanq.compiler.given import growth
from kalmanq.compiler.given.names import named
from kalmanq.compiler.given.request import FLOATS, Options, Request, groups, no_noise, request
from kalmanq.errors import KalmanqError
from kalmanq.formulas.calculus import substituted, without
from kalmanq.formulas.graph import Node, add, constant, dot, make, mul, needed, negated, node, select, sub, symbol
from kalmanq.formulas.printing import Body, Target, indented
from kalmanq.model import Model
from kalmanq.nonlinear import NonlinearModel
from kalmanq.nonlinear.model import Sensor

LARGEST = {"float": 1e37, "double": 1e300}  # of a sum of variances: beyond it they count as infinite
BEYOND = {"float": 1e24, "double": 1e40}  # of a variance, without a wider range or P0
NO_VARIANCE = {"float": (1e-6, 1e-3), "double": (1e-14, 1e-9)}  # shares of a variance of Q: of a D that is 0, and that is negative

FEW = 16  # entries of a factor that registers hold from one component to the next
POLES = ("inverse", "sqrt", "tan", "exp", "log", "asin", "acos", "sinh", "cosh", "pow", "fmod", "log1p", "expm1", "acosh", "atanh")  # not finite for some numbers
PRECISION = ("PRECISION", "precision lost: float rounds the function of a measurement by more than its sigma: use --arith f64")


@dataclass(frozen=True)
class Equations:
    """A nonlinear model and its request, which has the numbers that are constant

    looked_at   as equation_rounding chose it for the model with other noises; None: chosen for these"""

    model: NonlinearModel
    given: Request
    sensors: Sequence[Sensor]
    looked_at: Optional[dict[int, list[int]]] = None


def equations(model: NonlinearModel, name: str, options: Options) -> Equations:
    _refuse(options)
    _refuse_names(model.sensors)
    frame = model.frame
    controls = {"B": np.zeros((model.n, model.l)), "controls": model.controls} if model.l else {}
    _refuse_numbers(model, options)
    _refuse_no_noise(model, options)
    R = np.eye(model.m) if model.R is None else frame.R  # in the place of what is worked out in each call
    whole = Model(frame.A, H=frame.H, R=R, Q=frame.Q, x0=frame.x0, P0=frame.P0, states=frame.states,
                  measurements=frame.measurements, name=model.name, **controls)
    given = request(whole, name, options)
    if model.R is None:
        given = replace(given, together=groups(np.array([[not one.equals(0) for one in row] for row in model.formulas.noise_of_sensors])))
    if not model.has_errors:
        return Equations(model, given, model.sensors)
    if options.iterate > 1:
        raise KalmanqError("--iterate: is of models without nominal numbers: leave --iterate out")
    names, _, _ = named(model.carried, (), ())
    return Equations(model, replace(given, nominal=names), model.sensors)


def _refuse(options: Options) -> None:
    if options.arithmetic == "q31":
        raise KalmanqError("--arith q31: without the library a nonlinear model is compiled in f32 and f64: add --library, or leave --arith q31 out")
    for name, value in (("--lag", options.lag), ("--every", options.every), ("--tunable", options.tunable),
                        ("--loops", options.loops and not options.smooth)):
        if value:
            raise KalmanqError(f"{name}: is of models with constant matrices: leave {name} out")


def _refuse_names(sensors: Sequence[Sensor]) -> None:
    """A sensor's name is a part of names of C."""
    for one in sensors:
        if not one.name.isascii():
            raise KalmanqError(f"sensors: {one.name} is a part of functions' names: write it in letters without accents, digits and _")
        for other in sensors:
            if other.m > 1 and one.name == f"{other.name}_some":
                raise KalmanqError(f"sensors: {one.name} has the name of a function of {other.name}: give it another one")


def _refuse_numbers(model: NonlinearModel, options: Options) -> None:
    """Numbers in formulas that the arithmetic does not have, and what has no value, as 1 / 0"""
    most, f = float(np.finfo(FLOATS[options.arithmetic]).max), model.formulas
    names = {"f": (model.carried, [[one] for one in f.change]), "A": (model.states, f.transition),
             "h": (model.measurements, [[one, *row] for one, row in zip(f.innovation, f.measurement)]),
             "plus": (model.carried, [[one] for one in f.corrected])}
    names.update({} if f.noise_of_step is None else {"G" if "G" in model.given else "Q": (model.states, f.noise_of_step)})
    names.update({} if f.noise_of_sensors is None else {"R": (model.measurements, f.noise_of_sensors)})
    if all(abs(one.value) <= most for one in needed(one for _, rows in names.values() for row in rows for one in row)[0] if one.is_constant):
        return
    for which, (of, rows) in names.items():
        for quantity, formulas in zip(of, rows):
            for one in needed(formulas)[0]:
                if one.is_constant and not abs(one.value) <= most:
                    raise KalmanqError(f"{which}({quantity.name}): has the number {one.value:g}, which {options.arithmetic} does "
                                       f"not have: {_cure(one.value, most, model.has_errors and which in 'Ah')}")


def _refuse_no_noise(model: NonlinearModel, options: Options) -> None:
    """R that is a function, of a variance that is a number"""
    least = float(np.finfo(FLOATS[options.arithmetic]).tiny)
    for j, row in enumerate(model.formulas.noise_of_sensors or []):
        if row[j].is_constant and not row[j].value >= least:
            raise no_noise(model.measurements[j].name)


def _cure(value: float, most: float, is_by_errors: bool) -> str:
    if is_by_errors and not np.isfinite(value):
        return "a root or a quotient of errors has no derivative where they are 0; take all that needs it in one branch, as " \
            "(cos(a), sin(a) / a) if a > 1e-4 else (1, 1)"
    return "use other units" + (", or --arith f64" if most < abs(value) < np.inf else "")


class Formulas(Constant):
    """A, h, H, and what varies of Q or G and R, of the model where the C has its mean, x0 + l0, ...

    single  nominal numbers that are one number: their low parts stay 0
    step    formulas of Q or G; None: constant.  improper: what is very large where Q is no covariance
    spread  variances of R where they vary: r0, r1, ... are named so
    """

    def __init__(self, of: Equations):
        super().__init__(of.given)
        formulas, count, memo = of.model.formulas, range(len(of.model.carried)), {}
        self.single = _single(of.model) if of.model.has_errors else set()
        mean = {f"x{i}": symbol(f"x{i}") if i in self.single else add(symbol(f"x{i}"), symbol(f"l{i}")) for i in count}
        self.change = [substituted(one, mean, memo) for one in formulas.change]
        self.moved = [substituted(one, mean, memo) for one in formulas.moved]
        self.A = [[substituted(one, mean, memo) for one in row] for row in formulas.transition]
        self.step, own = ([[substituted(one, mean, memo) for one in row] for row in rows] if rows else None
                          for rows in (formulas.noise_of_step, formulas.noise_of_sensors))
        self.is_root, self.type = "G" in of.model.given, FLOATS[of.given.options.arithmetic]
        self.mixing, self.spread = (of.given.mixing.tolist(), None) if own is None else ud.lower(own)
        if self.spread:
            self.R = [one if one.is_constant else symbol(f"r{j}") for j, one in enumerate(self.spread)]
        errors = {f"d{k}": symbol(f"c{k}") for k in range(of.model.n)}
        self.corrected = [substituted(one, {**mean, **errors}, {}) for one in formulas.corrected] if of.model.has_errors else []
        if of.given.options.iterate > 1:
            mean, memo = {f"x{i}": symbol(f"a{i}") for i in count}, {}
        else:
            memo.update(_apart(formulas.innovation, mean))
        self.e = self._mixed([[substituted(one, mean, memo)] for one in formulas.innovation])
        self.H = self._mixed([[substituted(one, mean, memo) for one in row] for row in formulas.measurement])

    def _mixed(self, made: Sequence[Sequence[Node]]) -> list[list[Node]]:
        """Of what has independent noises"""
        return [[dot((w, made[k][c]) for k, w in enumerate(mixing) if not node(w).equals(0)) for c in range(len(made[0]))]
                for mixing in self.mixing]

    def noise(self, order: Optional[Sequence[int]] = None) -> list[ud.Column]:
        if self.step is None:
            return super().noise(order)
        if self.is_root:
            return [ud.Column(node(1.0), list(column)) for column in zip(*self.step)]
        return self._factored()[0]

    def improper(self) -> list[Node]:
        return [] if self.step is None or self.is_root else self._factored()[1]

    def _factored(self) -> tuple[list[ud.Column], list[Node]]:
        name = "float" if self.type is np.float32 else "double"
        return ud.factored(self.step, *NO_VARIANCE[name], 10 * MOST[name])


def _apart(innovations: Sequence[Node], mean: Mapping[str, Node]) -> dict[int, Node]:
    """z less a state, by id: (z - x) - l.  x + l would be rounded by a share of x, which can be above sigma"""
    made = {}
    for one in needed(innovations)[0]:
        if one.op == "sub" and all(part.op == "symbol" for part in one.args):
            z, x = one.args[0], mean.get(one.args[1].args[0])
            if z.args[0].startswith("z") and x is not None and x.op == "add":
                made[id(one)] = sub(sub(symbol(z.args[0]), x.args[0]), x.args[1])
    return made


def _single(model: NonlinearModel) -> set[int]:
    """No step and no update adds to them"""
    f = model.formulas
    return {i for i in range(len(model.carried))
            if all(without(made[i], symbol(f"x{i}")) is None for made in (f.moved, f.corrected))}


class EquationFilter(FloatFilter):
    """In float or double"""

    may_be_slow = False  # what its rows do is not known

    def __init__(self, of: Equations):
        self.equations, self.sensors = of, of.sensors
        super().__init__(of.given, None)
        bends = of.given.options.iterate > 1 or bool(of.given.nominal)
        self.linear = [] if bends else [one for one in of.sensors if self._is_linear_sensor(one)]
        innovations, c = [rows[0] for rows in self.coefficients.e], self.coefficients
        self.looked_at = {} if self.type == "double" else \
            equation_rounding.chosen(of.model, innovations, c.H, c.spread or c.R) if of.looked_at is None else of.looked_at
        self.watched = equation_rounding.watched(innovations, self.looked_at)
        self.events = (("NOT_FINITE", "a function of the model or a derivative was not finite, or Q or R no covariance: mean and covariance stay "
                        "as they were. If the variance of an innovation was not finite, only that component is not taken"),
                       growth.EVENT,
                       *([PRECISION] if self.watched else []))
        self.code_includes = ["#include <math.h>"]

    def _is_linear_sensor(self, sensor: Sensor) -> bool:
        c = self.coefficients
        return all(_is_linear(c.e[j][0], c.H[j]) and c.R[j].is_constant for j in range(sensor.first, sensor.first + sensor.m))

    def made_coefficients(self) -> Formulas:
        return Formulas(self.equations)

    def predicts_by(self, which: str) -> bool:
        """Does f read u, or t?"""
        c = self.coefficients
        return reads(which, [*c.change, *(one for rows in (c.A, c.step or []) for row in rows for one in row)])

    def updates_by(self, sensor: Sensor, which: str) -> bool:
        c, some = self.coefficients, range(sensor.first, sensor.first + sensor.m)
        return reads(which, [one for j in some for one in (*c.e[j], *c.H[j], *([c.spread[j]] if c.spread else []))])

    def sensor_of(self, j: int) -> Sensor:
        return next(one for one in self.sensors if one.first <= j < one.first + one.m)

    @property
    def slots(self) -> int:
        return max(one.m for one in self.sensors)

    # ---- hooks of FloatFilter

    def _transfers(self, form: ud.UD) -> list[Callable[[ud.Entries], ud.Entries]]:
        c = self.coefficients
        smooths = [back.transfer(form, c.A, c.noise())] if self.given.options.smooth else []
        return [*super()._transfers(form), *smooths]

    def slot(self, j: int) -> int:
        return j - self.sensor_of(j).first

    def row(self, j: int) -> ud.Row:
        """Of H: what is constant, and names of the rest, which `linearised` works out"""
        return [one if one.is_constant else symbol(f"h{j}_{i}") for i, one in enumerate(self.coefficients.H[j])]

    @property
    def first_mean(self) -> Sequence[float]:
        return [float(one) for one in self.equations.model.x0]

    @property
    def mean(self) -> Mean:
        return [(high, constant(0) if i in self.coefficients.single else low) for i, (high, low) in enumerate(super().mean)]

    @property
    def at(self) -> dict[str, str]:
        """The fields of all locals"""
        return {local: field for _, local, field in self.places()}

    def is_once(self, sensor: Sensor) -> bool:
        """Are its components' factors read and written where they are needed?  Few entries stay in registers meanwhile"""
        return self.given.options.iterate == 1 and (sensor.m == 1 or len(self.live) > FEW)

    def at_once(self, j: int) -> dict[str, str]:
        sensor = self.sensor_of(j)
        is_once = self.is_once(sensor)
        return {local: field if is_once else local for _, local, field in self.places(mean=sensor in self.linear)}

    def _change(self, x: Mean, i: int) -> Node:
        return x[i][1] + self.coefficients.change[i]

    def _moved(self, x: Mean) -> Mean:
        return super()._moved(x) if not self.given.nominal else [self._carried_to(one, i) for i, one in enumerate(self.coefficients.moved)]

    def _carried_to(self, value: Node, i: int) -> tuple[Node, Node]:
        """A nominal number: where its old value is added in the new one, in two numbers; otherwise in one"""
        high, low = self.mean[i]
        change = None if i in self.coefficients.single else without(value, add(high, low))
        return (value, constant(0)) if change is None else carried(high, low + change)

    def measured(self, j: int) -> Node:
        if self.sensor_of(j) in self.linear:
            return self.coefficients.e[j][0]
        return symbol(f"e{j}") - dot((h, self._correction(i, j)) for i, h in enumerate(self.row(j)))

    def _correction(self, i: int, j: int) -> Node:
        """Before component j"""
        is_first = self.given.options.iterate == 1 and j == self.sensor_of(j).first
        return constant(0) if is_first else symbol(f"c{i}")

    def corrected(self, corrections: Sequence[Node], j: int) -> list[Target]:
        if self.sensor_of(j) in self.linear:
            return super().corrected(corrections, j)
        return [(f"c{i}", self._correction(i, j) + one) for i, one in enumerate(corrections)]

    def accepts_of(self, sensor: Sensor) -> str:
        """A declared range is of the innovation: a measurement has to be a number."""
        return " | ".join(f"({self._within(f'z[{j}]', MOST[self.type])} ? {1 << j}u : 0u)" for j in range(sensor.m))

    # ---- what is done

    def predict(self, refused: Sequence[str]) -> list[str]:
        """Mean and factor, if the formulas are finite"""
        body, at = Body(self.words, fields=self.at), self.at
        after = self._predicted(self.form, self.entries)
        targets = [*self._written(self.moved_mean()), *((entry(key), self._above_zero(key, after[key])) for key in self.live)]
        body.expect([*self._doubtful_step(), *(one for _, one in targets)])
        body.lines += self.unless_finite_step(body, refused)
        return body.store([(at[name], one) for name, one in reversed(targets)])

    def _above_zero(self, key: ud.Key, value: Node) -> Node:
        """A D that may fall to 0 stays above: from 0 it could not grow again"""
        i, j = key
        return select(value < self.form.least, self.form.least, value) if i == j and self._shrinks(i) else value

    def _shrinks(self, i: int) -> bool:
        """Can D of a state without noise fall for ever?  Not where the state is only moved by others, or moves others only"""
        c, others = self.coefficients, [k for k in range(self.of.n) if k != i]
        is_free = all(one.equals(0) for one in c.step[i]) if c.step else not ud.factor(self.given.of.Q)[i, i]
        is_chain = all(c.A[i][k].equals(0) or c.A[k][i].equals(0) for k in others)
        keeps = c.A[i][i].is_constant and abs(c.A[i][i].value) >= 1
        return is_free and not (is_chain and keeps)

    def unless_finite_step(self, body: Body, refused: Sequence[str]) -> list[str]:
        """`refused` where f or A is not finite"""
        return self._unless_finite(body, self._doubtful_step(), refused)

    def _doubtful_step(self) -> list[Node]:
        c = self.coefficients
        noises = [one for row in c.step or [] for one in row if not one.is_constant]
        return [*(one for f, row in zip(c.change, c.A) for one in self._doubtful(f, row)), *noises, *c.improper()]

    def moved_mean(self) -> Mean:
        return self._moved(self.mean)

    def beside(self, x: Mean, other: Mean) -> list[Node]:
        """x less another mean: the errors of that one that make x of it"""
        if not self.given.nominal:
            return [(high - h) + (low - l) for (high, low), (h, l) in zip(x, other)]
        values = {f"{letter}{i}": high + low for letter, one in zip("ab", (x, other)) for i, (high, low) in enumerate(one)}
        memo: dict[int, Node] = {}
        return [substituted(one, values, memo) for one in self.equations.model.formulas.apart]

    def moved_by(self, errors: Sequence[Node]) -> Mean:
        """The mean with these errors"""
        if not self.given.nominal:
            return [carried(high, low + one) for (high, low), one in zip(self.mean, errors)]
        values, memo = {f"c{k}": one for k, one in enumerate(errors)}, {}
        return [self._carried_to(substituted(one, values, memo), i) for i, one in enumerate(self.coefficients.corrected)]

    def linearised(self, sensor: Sensor) -> list[str]:
        """Constants e0, h0_1, ... of a sensor, at the mean before it, and its corrections c0, c1, ...; those of a linear one
        are worked out as the components are taken"""
        c, body, made = self.coefficients, Body(self.words, stem="g"), []
        if sensor in self.linear:
            return []
        for j in range(sensor.first, sensor.first + sensor.m):
            made += [] if c.R[j].is_constant else [(f"r{j}", c.spread[j])]
            made += [(f"b{j}", self.watched[j])] if j in self.watched else []
            made += [(f"e{j}", c.e[j][0]), *((f"h{j}_{i}", one) for i, one in enumerate(c.H[j]) if not one.is_constant)]
        body.name_shared([one for _, one in made])
        return [*body.lines, *(f"const {self.type} {name} = {body.text(one)};" for name, one in made),
                f"{self.type} {', '.join(f'c{i} = {self._first(i)}' for i in range(self.of.n))};"]

    def unless_finite(self, sensor: Sensor, refused: Sequence[str]) -> list[str]:
        """Of a sensor, before its components: `refused` where what is taken is not finite"""
        made = {j: formulas for j in range(sensor.first, sensor.first + sensor.m) if (formulas := self._doubtful_component(j))}
        if not made:
            return []
        body = Body(self.words, stem="w", fields=self.at_once(sensor.first))
        fine = self._fine(body, [one for formulas in made.values() for one in formulas])
        parts = [f"((taken & {1 << self.slot(j)}u) != 0u && !({self._fine(body, formulas)}))" for j, formulas in made.items()]
        beside = f" && ({' || '.join(parts)})" if sensor.m > 1 else ""
        lines = [*body.lines, f"if (!({fine}){beside}) {{", *indented(refused), "}"]
        return ["{", *indented(lines), "}"] if body.fields and sensor in self.linear else lines

    def _first(self, i: int) -> str:
        """Of a correction: where an update is iterated, from the point to the mean before it"""
        return f"m{i} - a{i}" if self.given.options.iterate > 1 else self.zero

    def _doubtful_component(self, j: int) -> list[Node]:
        """A slope that is not finite makes the innovation's variance so, which is looked at before a single component is written"""
        c, sensor = self.coefficients, self.sensor_of(j)
        is_told = (sensor.m == 1 or not self.is_once(sensor)) and all(isinstance(self.facts[i, i], tuple) for i in range(self.of.n))
        names = {id(c.e[j][0]): symbol(f"e{j}"), **{id(one): name for one, name in zip(c.H[j], self.row(j))}}
        if sensor in self.linear:
            names[id(c.e[j][0])] = c.e[j][0]
        doubtful = [one for one in self._doubtful(c.e[j][0], c.H[j]) if one is c.e[j][0] or not is_told]
        spread = [] if c.R[j].is_constant else [select(node(0.0) < c.R[j], 0.0, 10 * MOST[self.type])]
        return [*(names[id(one)] for one in doubtful), *spread]

    def unless_rounded(self, j: int) -> list[str]:
        """An event where the rounding of component j is above its sigma"""
        if j not in self.watched:
            return []
        is_linear = self.sensor_of(j) in self.linear
        body = Body(self.words, stem="p", fields=self.at_once(j) if is_linear else {})
        is_above = self.coefficients.R[j] * equation_rounding.PER_SIGMA < (self.watched[j] if is_linear else symbol(f"b{j}"))
        body.name_shared([is_above])
        lines = [*body.lines, f"if ({body.text(is_above)}) f->events |= {self.given.upper}_PRECISION;"]
        return ["{", *indented(lines), "}"] if body.lines else lines

    def finished(self, sensor: Sensor) -> list[str]:
        """After all components: the corrections go over to the mean."""
        if sensor in self.linear:
            return []
        if self.given.nominal:
            mean = [self._carried_to(one, i) for i, one in enumerate(self.coefficients.corrected)]
            at = self.at
            return Body(self.words, stem="s").store([(at[name], one) for name, one in self._written(mean)])
        moved = "(c{0} + (a{0} - m{0}))" if self.given.options.iterate > 1 else "c{0}"
        return [f"l{i} = l{i} + {moved.format(i)};" for i in range(self.of.n)]

    def _unless_finite(self, body: Body, formulas: Sequence[Node], refused: Sequence[str]) -> list[str]:
        """`refused` where the sum of the formulas is NaN, infinite or very large"""
        if not formulas:
            return []
        return [f"if (!({self._fine(body, formulas)})) {{", *indented(refused), "}"]

    def _fine(self, body: Body, formulas: Sequence[Node]) -> str:
        formulas = list(map(_unsigned, formulas))
        total = dot([(one, 1.0) for one in {id(one): one for one in formulas}.values()])
        square = mul(total, total)  # AVR has no fabsf
        body.name_shared([*formulas, square])
        return body.text(make("le", square, constant(MOST[self.type]**2)))

    def overflow(self, names: Sequence[str]) -> list[str]:
        """names: of the entries of the factor"""
        return [f"if (!({self._variances(names)} <= {self.number(LARGEST[self.type])})) f->events |= {self.given.upper}_OVERFLOW;"]

    def _variances(self, names: Sequence[str]) -> str:
        """The sum of D"""
        return Body(self.words).text(dot([(symbol(one), 1.0) for one, (i, j) in zip(names, self.live) if i == j]))

    def _what_grows(self) -> growth.Growth:
        """What functions do is not known: all is looked at, for what no sigma can be"""
        ranges = np.array([one.range or 0.0 for one in self.given.model.states])
        least = np.maximum(np.diag(self.of.P0), ranges**2) * growth.ROOM
        return growth.Growth(np.clip(least, BEYOND[self.type], LARGEST[self.type] / growth.ROOM), {}, False)

    def within_numbers(self) -> list[str]:
        total = self._variances([self.at[entry(key)] for key in self.live])
        return [f"if (!({total} <= {self.number(growth.NEAR * self.growth.most.min())})) hold(f);"]

    def hold(self) -> dict[str, Any]:
        return self._hold(self.growth.most, self.first_mean)

    def _doubtful(self, value: Node, slopes: Sequence[Node]) -> list[Node]:
        """Of a function and its derivatives those that can be NaN, infinite or very large where the state is finite"""
        is_sure = _is_linear(value, slopes) and not self._reads_free_control(value)
        return ([] if is_sure else [value]) + [one for one in slopes if _has_poles(one) or self._reads_free_control(one)]

    def _reads_free_control(self, one: Node) -> bool:
        """A control without a declared range is not looked at otherwise"""
        free = {f"u{k}" for k, control in enumerate(self.given.model.controls) if not control.range}
        return any(part.op == "symbol" and part.args[0] in free for part in needed([one])[0])

    def looks_at(self, k: int) -> bool:
        """Is control k held within its range?"""
        return bool(self.given.model.controls[k].range)


def reads(which: str, rows: Sequence[Node]) -> bool:
    """u, t, ...: does a formula have such a symbol?"""
    return any(one.op == "symbol" and one.args[0].rstrip("0123456789") == which for one in needed(rows)[0])


def _unsigned(one: Node) -> Node:
    less = negated(one)
    return one if less is None else less


def _is_linear(value: Node, slopes: Sequence[Node]) -> bool:
    return all(one.is_constant for one in slopes) and not _has_poles(value)


def _has_poles(one: Node) -> bool:
    return any(part.op in POLES for part in needed([one])[0])
