"""NAME.c, NAME.h and NAME_test.c of a device over the library."""

from __future__ import annotations

from typing import Any, Sequence

import numpy as np

from kalmanq.compiler.algorithm.equation_device import Device, device, field, varies
from kalmanq.compiler.algorithm.equation_rounding import PER_SIGMA
from kalmanq.compiler.algorithm.floats import MOST
from kalmanq.compiler.given.cells import array
from kalmanq.compiler.given.request import Options
from kalmanq.compiler.text.emit import PREDICTS, UPDATES, Row, within
from kalmanq.compiler.text.equation_text import EquationText
from kalmanq.compiler.text.product import Product, written
from kalmanq.formulas.graph import Node, constant, dot, make, mul, using
from kalmanq.formulas.printing import Body
from kalmanq.nonlinear import NonlinearModel
from kalmanq.nonlinear.model import Sensor


def compiled_device(model: NonlinearModel, name: str, options: Options = Options(), source: str = "") -> Product:
    model = model.traced_anew()
    with using(model.formulas.graph):
        text = DeviceText(device(model, name, options))
        return written(text, [f"{name}: written by kalmanq compile --library.", *([source] if source else [])])


class DeviceText(EquationText):
    of: Device

    template, header = "device.c.j2", "device.h.j2"
    is_fixed = False

    def names(self) -> dict[str, Any]:
        a, G = self.of, self.of.nonlinear.G
        points = [("predict", "process", "increment")] if a.moves_points else []
        points += [("update", field(one), f"innovation{one.suffix}") for one in a.measures_points]
        columns = (len(a.Q[0]) if a.is_root else 0) if a.Q else 0 if G is None else np.atleast_2d(G).shape[1]
        return {**super().names(), "t": a.T, "is_fixed": self.is_fixed, "has_errors": a.has_errors, "is_plain": a.B is not None, "l": self._l,
                "noises": bool(a.Q), "root_columns": columns, "iterates": self.given.options.iterate if a.iterates else 0, "points": points,
                "moves_points": a.moves_points, "row_fields": a.row_fields(), "varies": self._varies()}

    def names_of_sensors(self) -> list[dict[str, Any]]:
        a = self.of
        return [{**names, "is_plain": one in a.plain, "measures_points": one in a.measures_points, "varies": self._varies_with(one),
                 "length": a.length(one), "spreads": len(a.spreads(one)) if a.has_spread(one) else 0}
                for names, one in zip(super().names_of_sensors(), a.sensors)]

    def bodies(self) -> dict[str, Any]:
        a = self.of
        sensors = [{**names, **self._sensor(one)} for names, one in zip(self.names_of_sensors(), a.sensors)]
        return {"code_includes": a.code_includes, "sensors": sensors, "array": array, **a.tables(), "A": "f->A" if self._varies() else "A",
                **({"predicted": []} if a.B is not None else self._predicted()), **(self._reset() if a.has_errors else {}),
                "increment": self._at_point("d", a.change) if a.moves_points else []}

    def _sensor(self, sensor: Sensor) -> dict[str, Any]:
        a = self.of
        made = {**a.tables_of(sensor), "is_diagonal": a.is_diagonal(sensor), "kind": self._kind(sensor), "H": self._H(sensor),
                "has_spread": a.has_spread(sensor), "unit": self._unit(sensor),
                "point": self._at_point("e", a.innovations(sensor), sensor.first) if sensor in a.measures_points else []}
        return made if sensor in a.plain else {**made, **self._innovations(sensor)}

    def _kind(self, sensor: Sensor) -> str:
        return ("_diagonal" if self.of.is_diagonal(sensor) else "") + ("" if sensor in self.of.plain else "_extended")

    def _varies(self) -> bool:
        return varies(self.of.transition)

    def _varies_with(self, sensor: Sensor) -> bool:
        return varies(self.of.rows_of(sensor))

    def row(self, of: Row) -> list[str]:
        """The same calls as of the straight-line filter, whose answer here is a status"""
        lines = super().row(of)
        made = [f"if ({of.what} & {PREDICTS} && {lines[0].split(') ', 1)[1].rstrip(';')}) {of.taken} |= UINT32_C(1) << 31;"]
        for sensor, line in zip(self.of.sensors, lines[1:]):
            called = line.split(" |= ")[1].split(" << ")[0]
            present = f"({of.present} >> {sensor.first} & {sensor.all}u)"
            made.append(f"if ({of.what} & {UPDATES} && {present} && !{called}) {of.taken} |= {present} << {sensor.first};")
        return made

    @property
    def _l(self) -> int:
        return self.of.B.shape[1] if self.of.B is not None else 0

    def _H(self, sensor: Sensor) -> str:
        return f"{'f->' if self._varies_with(sensor) else ''}H{sensor.suffix}"

    def _places(self, of: str = "filter") -> list[tuple[str, str, str]]:
        a = self.of
        x = [(a.type, f"x{i}", a.mean_text(i).replace("filter", of)) for i in range(len(self.given.carried))]
        d = [(a.type, f"d{i}", f"kq_mean_{a.T}(&f->filter, {i})") for i in range(a.n)]
        return [*x, *d, *((a.type, f"u{k}", f"u[{k}]") for k in range(self.given.of.l)),
                *((a.type, f"z{one.first + j}", f"z[{j}]") for one in a.sensors for j in range(one.m))]

    def _unless_finite(self, body: Body, values: Sequence[Node]) -> None:
        total = dot((one, 1.0) for one in values)
        square = mul(total, total)  # AVR has no fabsf
        body.name_shared([*values, square])
        body.lines.append(f"if (!({body.text(make('le', square, constant(MOST[self.of.type]**2)))})) return KQ_ERR_NOT_FINITE;")

    def _written(self, body: Body, target: str, entries: Sequence[Node]) -> None:
        """Those that are not constant"""
        body.assign([(f"f->{target}[{k}]", one) for k, one in enumerate(entries) if not one.is_constant])

    def _predicted(self) -> dict[str, Any]:
        a, body = self.of, Body(self.of.words)
        body.name_shared([*(a.moved if a.has_errors else a.change), *a.transition, *a.noises])
        if a.has_errors:
            self._unless_finite(body, a.moved)
            body.lines.append(f"static const {a.type} d[{a.n}] = {{0}};")
        else:
            body.lines.append(f"const {a.type} d[{a.n}] = {{{', '.join(body.text(one) for one in a.change)}}};")
        self._written(body, "A", a.transition)
        if a.Q:
            noises = ", ".join(body.text(one) for one in a.noises)
            body.lines.append(f"const {a.type} {'F' if a.is_root else 'Q'}[{len(a.noises)}] = {{{noises}}};")
        moved = self._replaced(body, a.moved) if a.has_errors else []
        return {"predicted": within(self._places(), body.lines), "moved": moved}

    def _reset(self) -> dict[str, Any]:
        a, body = self.of, Body(self.of.words)
        body.name_shared(a.corrected)
        self._unless_finite(body, a.corrected)
        body.lines.append(f"const {a.type} back[{a.n}] = {{{', '.join(f'-d{i}' for i in range(a.n))}}};")
        corrected = self._replaced(body, a.corrected)
        return {"resets": within(self._places(), body.lines), "corrected": corrected}

    @staticmethod
    def _replaced(body: Body, numbers: Sequence[Node]) -> list[str]:
        """Numbers that the states are errors of, once the filter has moved"""
        made = {i: body.text(one) for i, one in enumerate(numbers)}
        return [f"f->x[{i}] = {text};" for i, text in made.items() if text != f"x{i}"]

    def _innovations(self, sensor: Sensor) -> dict[str, Any]:
        """Where the filter is, and where an iterated update is tried"""
        a = self.of
        return {"measured": self._e_and_H(sensor) if a.has_spread(sensor) or not a.iterates else [],
                "tried": self._e_and_H(sensor, "trial") if a.iterates else []}

    def _e_and_H(self, sensor: Sensor, at: str = "filter") -> list[str]:
        a = self.of
        e, rows, body = a.innovations(sensor), a.rows_of(sensor), Body(a.words)
        spreads = a.spreads(sensor) if a.has_spread(sensor) and at == "filter" else []
        above = [a.variances[j] * PER_SIGMA < a.watched[j] for j in range(sensor.first, sensor.first + sensor.m) if j in a.watched]
        body.name_shared([*e, *rows, *spreads, *above])
        body.assign([(f"e[{j}]", one) for j, one in enumerate(e)])
        self._written(body, f"H{sensor.suffix}", rows)
        body.assign([(f"f->R{sensor.suffix}[{k}]", one) for k, one in enumerate(spreads)])
        body.lines += [f"if ({body.text(one)}) f->filter.events |= KQ_EVENT_PRECISION;" for one in above]
        return within(self._places(at), body.lines)

    def _unit(self, sensor: Sensor) -> str:
        """Of its R, the identity in the place of what is not known yet"""
        one, none = self.of.number(1), self.of.number(0)
        return one if self.of.is_diagonal(sensor) or sensor.m == 1 else f"i % {sensor.m + 1} ? {none} : {one}"

    def _at_point(self, target: str, rows: Sequence[Node], first: int = 0) -> list[str]:
        """Of x, with what else is read in the row"""
        a, body = self.of, Body(self.of.words)
        body.assign([(f"{target}[{k}]", one) for k, one in enumerate(rows)])
        places = [(a.type, f"x{i}", f"x[{i}]") for i in range(a.n)] + [(a.type, one, f"row->{one}") for one in ("t", "dt")]
        places += [(a.type, f"u{k}", f"row->u[{k}]") for k in range(self.given.of.l)]
        places += [(a.type, f"z{first + j}", f"row->z[{j}]") for j in range(len(rows))]
        lines = within(places, body.lines)
        row = [f"const {self.given.name}_row *row = (const {self.given.name}_row *)context;"] if any("row->" in one for one in lines) else []
        return [*row, *lines]
