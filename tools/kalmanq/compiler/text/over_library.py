"""A constant model as C over the library: what its templates (library.h.j2, library.c.j2) are given."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any, Iterable, Iterator, Optional, Sequence

import numpy as np

from kalmanq.compiler.given.cells import array, formats, scaled, words
from kalmanq.compiler.given.names import identifier, plain
from kalmanq.compiler.templates.engine import rendered
from kalmanq.core import arithmetic_of, ffi, lib, nearest
from kalmanq.errors import KalmanqError
from kalmanq.firmware.steps_kept import latest_of, steps_late
from kalmanq.model import Model, Quantity
from kalmanq.run.filters import Filter
from kalmanq.run.parts import CONSTANT, Parts, is_diagonal, known_prior, not_lean, ways_of
from kalmanq.run.robust import Robust, bits_of

WORD = {"f32": "float", "f64": "double", "q31": "int32_t"}
KINDS = ("states", "measurements", "controls")
SUFFIXES = ("", "_FRACTION", "_RANGE", "_RAW", "_VALUE")  # of what the header defines of a quantity


@dataclass(frozen=True)
class Source:
    """name.h and name.c"""

    name: str
    header: str
    text: str


@dataclass(frozen=True)
class SensorCall:
    """A sensor's measurements first, first + 1, ...; late: its delay in steps of dt, at most where it varies"""

    name: str
    title: str
    first: int
    count: int
    late: int
    varies: bool


class Writer:
    """What both texts are made from.  names: of enumerators, by kind; u, z: arguments of functions."""

    def __init__(self, parts: Parts, way: str, name: str, any_dt: bool, steps: int = 1, robust: Optional[Robust] = None):
        self.parts, self.way, self.name, self.any_dt, self.robust = parts, way, name, any_dt, robust
        self.longer = _longer(parts, steps)
        self.model, self.T, self.is_fixed = parts.model, parts.arithmetic.name, parts.arithmetic.is_fixed
        self.upper, self.is_constant = name.upper(), way in CONSTANT
        self.unknown = sum(1 << int(i) for i in np.flatnonzero(self.model.unknown))
        self.is_diagonal = is_diagonal(self.model.R)
        word = self.word = WORD[self.T]
        moved = [(f"const {word} u[{len(self.model.inputs)}]", "u")] if self.model.inputs else []
        moved += [("float dt", "dt")] if any_dt else [("uint32_t steps", "steps")] if self.longer else []
        self.u, self.given = (", ".join(texts) for texts in zip(*moved)) if moved else ("", "")
        self.z = f"const {word} z[{self.model.m}], uint32_t present"
        self.names = self._names()
        self.sensors = self._sensors()
        self.latest = latest_of(self.model)
        self.replays = bool(self.latest) and not any_dt

    def number(self, value: float) -> str:
        """The shortest decimal that is this number"""
        return f"{np.float32(value)!s}f" if self.T == "f32" else repr(float(value))

    def numbers(self, values: Iterable[float]) -> list[str]:
        return [self.number(value) for value in np.ravel(values)]

    def _sensors(self) -> list[SensorCall]:
        """Of a model file that names them"""
        made, first = [], 0
        for one, late in zip(self.model.sensors, steps_late(self.model, self.any_dt)):
            count = len(one.measurements)
            name = identifier(one.name).removeprefix("filter_")
            while name in (*(other.name for other in made), "some"):
                name += "_"
            made.append(SensorCall(name, one.name, first, count, late, bool(one.measured)))
            first += count
        return made

    def _names(self) -> dict[str, list[str]]:
        """Each another one than all that the header has beside it"""
        known = {f"{self.upper}_{word}" for word in ("STATES", "MEASUREMENTS", "CONTROLS", "ALL")}
        made: dict[str, list[str]] = {kind: [] for kind in KINDS}
        for kind, letter in zip(KINDS, ("", "Z_", "U_")):
            for one in self.of(kind):
                name = f"{self.upper}_{letter}{re.sub(r'[^A-Z0-9]+', '_', one.name.upper()).strip('_') or 'X'}"
                while known & {name + suffix for suffix in SUFFIXES}:
                    name += "_"
                known |= {name + suffix for suffix in SUFFIXES}
                made[kind].append(name)
        return made

    def of(self, kind: str) -> Sequence[Quantity]:
        """What the user reads and gives"""
        return self.model.inputs if kind == "controls" else getattr(self.model, kind)

    def quantities(self) -> Iterator[tuple[str, Quantity, str, int]]:
        """What each is ("state 0"), its enumerator and its fraction bits"""
        for kind in KINDS:
            rows = zip(self.of(kind), self.names[kind], self.parts.fractions(kind))
            for k, (one, name, fraction) in enumerate(rows):
                yield f"{kind[:-1]} {k}", one, name, fraction


def _longer(parts: Parts, steps: int) -> list[Parts]:
    """Of two and more steps of dt at once"""
    made = []
    for count in range(2, steps + 1):
        A, Q, B = parts.model.continuous.step(count * parts.model.continuous.dt)
        made.append(Parts(parts.model.changed(A=A, Q=Q, **({} if B is None else {"B": B})), "q31"))
    return made


def bytes_of_delays(model: Model, arithmetic: str, any_dt: bool = False) -> int:
    """RAM for what is late: in f32 with any_dt what the library keeps, otherwise a filter and the steps after it, at most"""
    latest, n, m = latest_of(model), model.n, model.m
    if not latest:
        return 0
    if any_dt:
        return 4 * arithmetic_of(arithmetic).length("lag", n, m, latest)
    size = 8 if arithmetic == "f64" else 4
    step = size * (len(model.inputs) + m + 1)
    return size * arithmetic_of(arithmetic).length("filter", n) + ffi.sizeof(f"kq_filter_{arithmetic}") + (latest + 1) * step + 8


def source(parts: Parts, way: str, name: str = "", remarks: Sequence[str] = (), any_dt: bool = False, steps: int = 1,
           robust: Optional[Robust] = None) -> Source:
    """The filter of a model; remarks go to the top of the header.

    any_dt   of a model in continuous time, in f32 as init: a predict is told the length of its step
    steps    of a model in continuous time, in q31: a predict is told how many dt it goes, so many at most
    """
    if steps > 1 and (parts.model.continuous is None or parts.arithmetic.name != "q31" or way == "sizes"):
        raise KalmanqError("--steps: of a model with F, Qc and dt, in q31, and not as sizes: leave --steps out; f32 has --any-dt")
    if any_dt and (parts.model.continuous is None or parts.arithmetic.name != "f32" or way != "init"):
        raise KalmanqError("steps of any length are of a model with F, Qc and dt, in f32 and prepared at the start: take --way init in f32, or leave --any-dt out")
    if robust and latest_of(parts.model):
        raise KalmanqError("--robust: and a sensor with a delay, whose steps are worked out again: leave --robust out")
    if any(one.delay for one in parts.model.sensors) and np.any(parts.model.unknown):
        raise KalmanqError("sensors: a delay, and a start that is unknown: give P0")
    if way not in ways_of(parts.model):
        raise KalmanqError(f"{parts.model.name} cannot be written as {way}: {not_lean(parts.model)}")
    writer = Writer(parts, way, identifier(name or parts.model.name), any_dt, steps, robust)
    made = given(writer)
    return Source(writer.name, rendered("library.h.j2", {**made, **_of_header(writer, remarks)}), rendered("library.c.j2", {**made, **_of_code(writer)}))


# ------------------------------------------------------------------------------ for both templates


def given(w: Writer) -> dict[str, Any]:
    return {"name": w.name, "upper": w.upper, "t": w.T, "word": w.word, "is_fixed": w.is_fixed, "way": w.way, "is_constant": w.is_constant,
            "n": w.model.n, "m": w.model.m, "l": w.model.l, "inputs": len(w.model.inputs), "u": w.u, "z": w.z, "given": w.given, "any_dt": w.any_dt,
            "longest": len(w.longer) + 1 if w.longer else 0, "latest": w.latest, "replay": w.replays, "kept": w.latest + 1,
            "sensors": [_sensor(w, one) for one in w.sensors]}


def _sensor(w: Writer, one: SensorCall) -> dict[str, Any]:
    """A call that gives its measurements to the sensor of all, as if they alone were present"""
    cells = ", ".join(f"z[{k - one.first}]" if one.first <= k < one.first + one.count else "0" for k in range(w.model.m))
    own = f"present & {(1 << one.count) - 1}u"
    return {**vars(one), "title": plain(one.title), "cells": cells, "own": f"({own}) << {one.first}" if one.first else own}


def _of_header(w: Writer, remarks: Sequence[str]) -> dict[str, Any]:
    quantities = [{"name": name, "fraction": fraction, "range": (repr(float(one.range)) if w.is_fixed else w.number(one.range)) if one.range else ""}
                  for _, one, name, fraction in w.quantities()]
    return {"names": w.names, "quantities": quantities, "table": _table(w), "remarks": remarks, "missing": "KQ_NOT_A_VALUE_Q31",
            "control": "refuses such a control", "unit": w.model.continuous.unit if w.any_dt else ""}


def _table(w: Writer) -> list[str]:
    rows = [("", "name", "unit", "format", "largest")]
    rows += [(what, plain(one.name), plain(one.unit), f"Q{31 - fraction}.{fraction}", one.span or "0")
             for what, one, _, fraction in w.quantities()]
    columns = 5 if w.is_fixed else 3
    widths = [max(len(row[k]) for row in rows) for k in range(columns)]
    return ["  ".join(f"{cell:<{width}}" for cell, width in zip(row, widths)).rstrip() for row in rows]


# ------------------------------------------------------------------------------ for NAME.c


def _of_code(w: Writer) -> dict[str, Any]:
    model = w.model
    zeros = [", ".join(map(str, one)) for one in w.parts.zeros] if w.is_constant else ["", ""]
    made = {"array": array, "loss": _loss(w), "gates": _gates(w), "unknown": f"UINT32_C(0x{w.unknown:x})" if w.unknown else "", "is_diagonal": w.is_diagonal, "offsets": _offsets(w),
            "pushes": _pushes(w), "pushed": "NULL" if not model.l else "all" if model.c is not None else "u", "is_upper": not np.any(np.tril(model.A, -1)),
            "zeros_of_H": zeros[1], "processes": [{"end": "", "zeros": zeros[0]}]}
    return {**made, **(_words_of(w) if w.is_fixed else _floats_of(w))}


def _pushes(w: Writer) -> list[str]:
    """The controls, and the 1 of the offset"""
    if w.model.c is None:
        return []
    one = f"INT32_C({1 << w.parts.fractions('controls')[-1]})" if w.is_fixed else w.number(1)
    return [*(f"u[{k}]" for k in range(len(w.model.inputs))), one]


def _offsets(w: Writer) -> list[str]:
    """Measurements, $z[0], ..., without their offsets"""
    d = w.model.d
    if d is None:
        return []
    if w.is_fixed:
        words = nearest(np.ldexp(d, w.parts.fractions("measurements")))
        return [f"less($z[{k}], INT32_C({int(one)}))" for k, one in enumerate(words)]
    return [f"$z[{k}] - {w.number(one)}" if one >= 0 else f"$z[{k}] + {w.number(-one)}" for k, one in enumerate(d)]


def _loss(w: Writer) -> dict[str, Any]:
    """Of robust updates; a gate has the limit of as many of its sensor's measurements as are present"""
    if w.robust is None:
        return {"way": ""}
    made, of = {"way": w.robust.way}, w.parts.arithmetic
    if w.robust.way == "gate":
        limits = w.robust.limits(of, max(w.model.sensor_sizes))
        return {**made, "limits": [f"INT64_C({one})" if w.is_fixed else w.number(one) for one in limits]}
    value = of.parameter(w.robust.value)
    return {**made, "parameter": "{{{mantissa}, {exponent}}}".format(**value) if w.is_fixed else w.number(value)}


def _gates(w: Writer) -> list[str]:
    """The measurements of each, where there are several"""
    bits = bits_of(w.model.sensor_sizes) if w.robust is not None and w.robust.way == "gate" else []
    return [f"UINT32_C(0x{one:x})" for one in bits] if len(bits) > 1 else []


def _floats_of(w: Writer) -> dict[str, Any]:
    """Tables of f32 and f64"""
    model, of, size = w.model, w.model.continuous if w.any_dt else None, w.model.n * (w.model.n + 1) // 2
    made = {"A": model.A, "B": model.B, "G": model.G, "Q": model.Q, "H": model.H, "R": np.diag(model.R) if w.is_diagonal else model.R,
            "x0": model.x0, "P0": known_prior(model)}
    if of:
        made.update(F=of.F, continuous_B=of.B, Qc=of.Qc)
    if w.is_constant:
        root = w.parts.process.noise_root
        made.update(root=[float(root[k]) for k in range(size)], first_root=Filter(model, w.T, parts=w.parts).memory[-size:])
    return {"columns": 0 if model.G is None else model.G.shape[1], **{name: [] if one is None else w.numbers(one) for name, one in made.items()}}


def _words_of(w: Writer) -> dict[str, Any]:
    """Tables of q31: formats, mantissas with exponents, words"""
    model, sensor, prior = w.model, w.parts.sensor_table, w.parts.prior
    n, m, l = model.n, model.m, model.l
    root = int(lib.kq_length_q31(lib.KQ_OBJECT_ROOT, n, 0, 0, 0))
    ranges = [(kind[:-1], formats(w.parts.formats[kind], len(getattr(model, kind)))) for kind in KINDS[: 3 if l else 2]]
    processes = []
    for count, parts in enumerate([w.parts, *w.longer], 1):
        table, (end, of) = parts.process_table, ("", "") if count == 1 else (f"_{count}", f" of {count} dt")
        processes.append({"end": end, "of": of, "A": scaled(table.transition, n * n), "B": scaled(table.control, n * l) if l else [],
                          "root": words(table.noise_root, root), "zeros": ", ".join(map(str, parts.zeros[0])) if w.is_constant else ""})
    return {"formats": ranges, "processes": processes, "H": scaled(sensor.measurement, m * n),
            "R": scaled(sensor.noise, m if w.is_diagonal else m * (m + 1) // 2), "x0": words(prior.mean, n), "P0": words(prior.root, root)}
