"""A filter as a C file: its numbers as constants, its objects, and functions that call the library."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any, Iterable, Sequence

import numpy as np

from kalmanq.core import lib
from kalmanq.errors import KalmanqError
from kalmanq.model import Model
from kalmanq.run.filters import Filter
from kalmanq.run.parts import CONSTANT, Parts, is_diagonal, known_prior, ways_of

WORDS = frozenset("""auto break case char const continue default do double else enum extern float for goto if inline int
    long register restrict return short signed sizeof static struct switch typedef union unsigned void volatile while
    bool class delete new template this namespace main kalmanq assert complex ctype errno fenv float inttypes iso646
    limits locale math setjmp signal stdalign stdarg stdatomic stdbool stddef stdint stdio stdlib stdnoreturn string
    tgmath threads time uchar wchar wctype""".split())
SUFFIXES = ("", "_FRACTION", "_RANGE", "_RAW", "_VALUE")  # of what the header defines of a quantity


@dataclass(frozen=True)
class Source:
    """name.h and name.c"""

    name: str
    header: str
    text: str


@dataclass
class Writer:
    """What both texts are made from."""

    parts: Parts
    way: str
    name: str
    @property
    def model(self) -> Model:
        return self.parts.model

    @property
    def T(self) -> str:
        return self.parts.arithmetic.name

    @property
    def word(self) -> str:
        return "int32_t" if self.is_fixed else "float"

    @property
    def is_fixed(self) -> bool:
        return self.parts.arithmetic.is_fixed

    @property
    def upper(self) -> str:
        return self.name.upper()

    @property
    def is_constant(self) -> bool:
        return self.way in CONSTANT

    @property
    def is_unknown(self) -> bool:
        return bool(np.any(self.model.unknown))


def identifier(text: str) -> str:
    """For files and functions: no word of C, no header of C or of the library, nothing that begins as its names do."""
    made = re.sub(r"\W+", "_", text, flags=re.ASCII).strip("_").lower() or "filter"
    return f"filter_{made}" if made[0].isdigit() or made in WORDS or made.startswith("kq") else made


def plain(text: str) -> str:
    """For a comment: what would end it, or be read as something else, is taken apart."""
    printable = "".join(c if c.isprintable() else " " for c in text)
    return re.sub(r"([*?/])(?=[/*?])", r"\1 ", printable)


def source(parts: Parts, way: str, name: str = "", remarks: Sequence[str] = ()) -> Source:
    """The filter of a model in f32 or q31; remarks go to the top of the header."""
    if parts.arithmetic.name == "f64":
        raise KalmanqError("a design is in f32 or q31")
    if way not in ways_of(parts):
        raise KalmanqError(f"{parts.model.name} cannot be written as {way}: R is correlated or too small, or the "
                           "start is unknown")
    writer = Writer(parts, way, identifier(name or parts.model.name))
    return Source(writer.name, _header(writer, remarks), _text(writer))


# ------------------------------------------------------------------------------ the header


def _header(w: Writer, remarks: Sequence[str]) -> str:
    arguments = _arguments(w)
    lines = ["/*", f" * {w.name}: {w.model.n} states, {w.model.m} measurements, {w.model.l} controls, in {w.T}.",
             " *", *_usage(w), " *", *(f" * {line}".rstrip() for line in _quantities(w))]
    lines += [" *"] + [f" * {line}".rstrip() for line in remarks] if remarks else []
    lines += [" */", f"#ifndef KALMANQ_DESIGN_{w.upper}_H", f"#define KALMANQ_DESIGN_{w.upper}_H", "",
              *(["#include <math.h>"] if w.is_fixed else []), "#include <stdint.h>", "", "#include <kalmanq/kalmanq.h>", "",
              "#ifdef __cplusplus", 'extern "C" {', "#endif", ""]
    lines += _enumerations(w) + _ranges(w) + (_conversions(w) if w.is_fixed else [])
    lines += ["/** Before the first sample. */", f"kq_status {w.name}_init(void);", "",
              "/** To the next sample. */", f"kq_status {w.name}_predict({arguments['u']});", "",
              "/** Takes what is present of a sample, a bit for each measurement. */",
              f"kq_status {w.name}_update({arguments['z']});", "",
              "/** Predict and update.  Where the update is refused, the predict stands. */",
              f"kq_status {w.name}_step({arguments['both']});", "",
              f"/** For the library's readings: kq_mean_{w.T}({w.name}_filter(), ...), kq_sigma_{w.T}, ... */",
              f"kq_filter_{w.T} *{w.name}_filter(void);", "", "#ifdef __cplusplus", "}", "#endif", "", "#endif", ""]
    return "\n".join(lines)


def _arguments(w: Writer) -> dict[str, str]:
    u = f"const {w.word} u[{w.model.l}]" if w.model.l else ""
    z = f"const {w.word} z[{w.model.m}], uint32_t present"
    return {"u": u or "void", "z": z, "both": f"{u}, {z}" if u else z}


def _usage(w: Writer) -> list[str]:
    given = "u, " if w.model.l else ""
    mean, first = f"kq_mean_{w.T}({w.name}_filter(), {_names(w, 'states')[0]})", _names(w, "measurements")[0]
    taken = [(f"z[{first}] = {first}_RAW(measured);", "from its unit")] if w.is_fixed else []
    calls = [(f"{w.name}_init();", "once"), *taken, (f"{w.name}_update(z, {w.upper}_ALL);", "the first sample"),
             (f"{w.name}_step({given}z, {w.upper}_ALL);", "each other one"),
             (f"{_names(w, 'states')[0]}_VALUE({mean})" if w.is_fixed else mean, "what it says")]
    width = max(len(call) for call, _ in calls) + 4
    return [f" *     {call:<{width}}{what}" for call, what in calls]


def _quantities(w: Writer) -> list[str]:
    rows = [("", "name", "unit", "format", "largest")] if w.is_fixed else [("", "name", "unit")]
    for which in ("states", "measurements", "controls"):
        for k, one in enumerate(getattr(w.model, which)):
            row = (f"{which[:-1]} {k}", plain(one.name), plain(one.unit))
            rows.append(row + (_format(w, which, k), f"{one.range:g}") if w.is_fixed else row)
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    return ["    " + "  ".join(f"{cell:<{width}}" for cell, width in zip(row, widths)) for row in rows]


def _format(w: Writer, which: str, k: int) -> str:
    fraction = w.parts.formats[which][k].fraction
    return f"Q{31 - fraction}.{fraction}"


def _names(w: Writer, which: str) -> list[str]:
    """Of enumerators, each another one than all that the header has beside it."""
    known = {f"{w.upper}_{word}" for word in ("STATES", "MEASUREMENTS", "CONTROLS", "ALL")}
    made: dict[str, list[str]] = {}
    for kind, letter in (("states", ""), ("measurements", "Z_"), ("controls", "U_")):
        made[kind] = []
        for one in getattr(w.model, kind):
            name = f"{w.upper}_{letter}{re.sub(r'[^A-Z0-9]+', '_', one.name.upper()).strip('_') or 'X'}"
            while known & {name + suffix for suffix in SUFFIXES}:
                name += "_"
            known |= {name + suffix for suffix in SUFFIXES}
            made[kind].append(name)
    return made[which]


def _enumerations(w: Writer) -> list[str]:
    lines = []
    for which in ("states", "measurements", "controls"):
        names = _names(w, which)
        if names:
            lines += ["enum {", *(f"    {name}," for name in names),
                      f"    {w.upper}_{which.upper()}", "};", ""]
    if w.is_fixed:
        lines += ["/* value = word * 2^-fraction */", "enum {"]
        for which in ("states", "measurements", "controls"):
            fractions = w.parts.fractions(which)
            lines += [f"    {name}_FRACTION = {fraction}," for name, fraction in zip(_names(w, which), fractions)]
        lines[-1] = lines[-1].rstrip(",")
        lines += ["};", ""]
    return [*lines, "/* present: all measurements */", f"#define {w.upper}_ALL UINT32_C(0x{(1 << w.model.m) - 1:x})",
            ""]


def _ranges(w: Writer) -> list[str]:
    lines = []
    for which in ("states", "measurements", "controls"):
        for one, name in zip(getattr(w.model, which), _names(w, which)):
            if one.range:
                lines.append(f"#define {name}_RANGE {float(one.range)!r}" if w.is_fixed else
                             f"#define {name}_RANGE {_float(one.range)}")
    return ["/* The declared ranges, in units: |value| <= range */", *lines, ""] if lines else []


CONVERSIONS = """\
/* A value in its unit as a raw value: rounded to the nearest one, saturated at +-(2^31 - 1).  NaN becomes
   KQ_NOT_A_VALUE_Q31, which an update refuses, as it does what is beyond the declared range. */
static inline int32_t {name}_to_raw(double value, double scale)
{{
    const double raw = value * scale;
    if (raw >= 2147483647.0) return INT32_MAX;
    if (raw > -2147483647.0) {{
        const int32_t whole = (int32_t)raw;
        const double rest = raw - (double)whole;
        return rest >= 0.5 ? whole + 1 : rest <= -0.5 ? whole - 1 : whole;
    }}
    return raw <= -2147483647.0 ? -INT32_MAX : KQ_NOT_A_VALUE_Q31;
}}

/* And back: of means, sigmas and measurements; KQ_NOT_A_VALUE_Q31 becomes NaN. */
static inline double {name}_to_value(int32_t raw, double last_bit)
{{
    return raw == KQ_NOT_A_VALUE_Q31 ? (double)NAN : (double)raw * last_bit;
}}
"""


def _conversions(w: Writer) -> list[str]:
    lines = CONVERSIONS.format(name=w.name).split("\n")
    for which in ("states", "measurements", "controls"):
        for name, fraction in zip(_names(w, which), w.parts.fractions(which)):
            lines += [f"#define {name}_RAW(value) {w.name}_to_raw((double)(value), {2.0**fraction!r})",
                      f"#define {name}_VALUE(raw) {w.name}_to_value((raw), {2.0**-fraction!r})"]
    return [*lines, ""]


# ------------------------------------------------------------------------------ the source


def _text(w: Writer) -> str:
    lines = [f"/* See {w.name}.h. */", f'#include "{w.name}.h"', ""]
    if w.way == "sizes":
        lines += [f'#include "kq_fixed_{w.T}.h" /* in src/fixed_size of the library */', ""]
    lines += (_tables_fixed if w.is_fixed else _tables_float)(w)
    lines += ["", f"KQ_FILTER_{w.T.upper()}(model_filter, {w.model.n});"]
    if w.is_unknown:
        lines.append(f"KQ_DIFFUSE_{w.T.upper()}(model_start, {w.model.n}, 0);")
    lines += [*(_objects_constant if w.is_constant else _objects)(w), ""]
    lines += [*_init(w), "", *_predict(w), "", *_update(w), "", *_step(w), "",
              f"kq_filter_{w.T} *{w.name}_filter(void) {{ return &model_filter; }}", ""]
    return "\n".join(lines)


def _array(kind: str, name: str, cells: Sequence[str], columns: int, remark: str = "") -> list[str]:
    """columns: of a matrix, a row of it a line; otherwise as many as fit."""
    head = [f"/* {remark} */"] if remark else []
    flat = f"static const {kind} {name}[{len(cells)}] = {{{', '.join(cells)}}};"
    if len(flat) <= 100:
        return [*head, flat]
    rows = [", ".join(cells[k : k + columns]) for k in range(0, len(cells), columns)]
    return [*head, f"static const {kind} {name}[{len(cells)}] = {{", *(f"    {row}," for row in rows), "};"]


# ------ f32


def _float(value: float) -> str:
    return f"{np.float32(value)!s}f"  # the shortest decimal that is this float


def _floats(values: Iterable[float]) -> list[str]:
    return [_float(value) for value in values]


def _words_of(pointer: Any, length: int) -> list[float]:
    return [float(pointer[k]) for k in range(length)]


def _tables_float(w: Writer) -> list[str]:
    model, n = w.model, w.model.n
    lines = _array("float", "transition", _floats(model.A.ravel()), n, "A, n x n")
    if model.B is not None:
        lines += _array("float", "control", _floats(model.B.ravel()), model.l, "B, n x l")
    lines += _process_noise_float(w)
    lines += _array("float", "measurement", _floats(model.H.ravel()), n, "H, m x n")
    if is_diagonal(model.R):
        lines += _array("float", "variance", _floats(np.diag(model.R)), 6, "R: the noises are independent")
    else:
        lines += _array("float", "covariance", _floats(model.R.ravel()), model.m, "R, m x m")
    lines += _array("float", "first_mean", _floats(model.x0), 6, "x0 and P0: before the first sample")
    if w.is_unknown or not w.is_constant:
        return lines + _array("float", "first_covariance", _floats(known_prior(model).ravel()), n)
    made = Filter(model, w.T, parts=w.parts)
    root = made.memory[-(n * (n + 1) // 2):]
    return lines + _array("float", "first_root", _floats(root), 6)


def _process_noise_float(w: Writer) -> list[str]:
    model, n = w.model, w.model.n
    if w.is_constant:
        root = _words_of(w.parts.process.noise_root, n * (n + 1) // 2)
        return _array("float", "noise_root", _floats(root), 6, "G, upper triangle by columns: Q = G G'")
    if model.G is not None:
        return _array("float", "noise_factor", _floats(model.G.ravel()), model.G.shape[1], "G: Q = G G'")
    return _array("float", "noise_covariance", _floats(model.Q.ravel()), n, "Q, n x n")


# ------ q31


def _scaled(numbers: Any, count: int) -> list[str]:
    return [f"{{{numbers[k].mantissa}, {numbers[k].exponent}}}" for k in range(count)]


def _formats(w: Writer, which: str, name: str) -> list[str]:
    formats = w.parts.formats[which]
    cells = [f"{{{formats[k].range}, {formats[k].fraction}}}" for k in range(len(getattr(w.model, which)))]
    return _array("kq_format_q31", name, cells, 4)


def _tables_fixed(w: Writer) -> list[str]:
    model, process, sensor = w.model, w.parts.process_table, w.parts.sensor_table
    n, m, l = model.n, model.m, model.l
    root = int(lib.kq_length_q31(lib.KQ_OBJECT_ROOT, n, 0, 0, 0))
    lines = ["/* {range in words, fraction} */", *_formats(w, "states", "state_format"),
             *_formats(w, "measurements", "measurement_format")]
    lines += _formats(w, "controls", "control_format") if l else []
    lines += ["/* {mantissa, exponent}, in words of the states */"]
    lines += _array("kq_scaled_q31", "transition", _scaled(process.transition, n * n), min(n, 4), "A, n x n")
    if l:
        lines += _array("kq_scaled_q31", "control", _scaled(process.control, n * l), min(l, 4), "B, n x l")
    lines += _array("int32_t", "noise_root", [str(process.noise_root[k]) for k in range(root)], 6,
                    "G, upper triangle by columns and exponents: Q = G G'")
    lines += _array("kq_scaled_q31", "measurement", _scaled(sensor.measurement, m * n), min(n, 4), "H, m x n")
    noises = m if is_diagonal(model.R) else m * (m + 1) // 2
    lines += _array("kq_scaled_q31", "variance", _scaled(sensor.noise, noises), 4, "R")
    lines += _array("int32_t", "first_mean", [str(w.parts.prior.mean[k]) for k in range(n)], 6,
                    "x0 and the root of P0: before the first sample")
    lines += _array("int32_t", "first_root", [str(w.parts.prior.root[k]) for k in range(root)], 6)
    lines += [f"static const kq_prior_table_q31 prior = {{{n}, state_format, first_mean, first_root}};"]
    return lines if w.is_constant else lines + _tables_to_init(w)


def _tables_to_init(w: Writer) -> list[str]:
    model = w.model
    control = f".controls = {model.l}, .control_format = control_format, .control = control," if model.l else ""
    return ["static const kq_process_table_q31 process_table = {",
            f"    .states = {model.n}, .state_format = state_format, .transition = transition,",
            *([f"    {control}"] if control else []), "    .noise_root = noise_root};",
            "static const kq_sensor_table_q31 sensor_table = {",
            f"    .states = {model.n}, .components = {model.m}, .correlated = {int(not is_diagonal(model.R))},",
            "    .state_format = state_format, .measurement_format = measurement_format,",
            "    .measurement = measurement, .noise = variance};"]


# ------ objects


def _objects_constant(w: Writer) -> list[str]:
    n, m, l = w.model.n, w.model.m, w.model.l
    control, kind = ("control" if l else "NULL"), ("SENSOR_LEAN_TABLE" if w.way == "lean" else "SENSOR_TABLE")
    of_A, of_H = (f"({', '.join(map(str, numbers))})" for numbers in w.parts.zeros)
    if w.is_fixed:
        controls = "control_format" if l else "NULL"
        return [f"static const kq_process_q31 model_process = KQ_PROCESS_TABLE_Q31(\n    {n}, {l}, state_format, {controls}, "
                f"transition, {control}, noise_root, {of_A});",
                f"static const kq_sensor_q31 model_sensor = KQ_{kind}_Q31(\n    {n}, {m}, state_format, measurement_format, "
                f"measurement, variance, {of_H});"]
    return [f"static const kq_process_f32 model_process = KQ_PROCESS_TABLE({n}, {l}, transition, {control}, "
            f"noise_root,\n    {of_A});",
            f"static const kq_sensor_f32 model_sensor = KQ_{kind}_F32({n}, {m}, measurement, variance, {of_H});"]


def _objects(w: Writer) -> list[str]:
    if w.is_fixed:
        return ["static kq_process_q31 model_process;", "static kq_sensor_q31 model_sensor;"]
    kind = "KQ_SENSOR_DIAGONAL_F32" if is_diagonal(w.model.R) else "KQ_SENSOR_F32"
    return [f"KQ_PROCESS_F32(model_process, {w.model.n}, {w.model.l});",
            f"{kind}(model_sensor, {w.model.n}, {w.model.m});"]


# ------ functions


def _init(w: Writer) -> list[str]:
    calls = [] if w.is_constant else (_init_fixed if w.is_fixed else _init_float)(w)
    calls.append(_init_filter(w))
    lines = [f"kq_status {w.name}_init(void)", "{"]
    if len(calls) == 1:
        return [*lines, f"    return {calls[0]};", "}"]
    lines.append(f"    kq_status status = {calls[0]};")
    lines += [f"    if (!status) status = {call};" for call in calls[1:]]
    return [*lines, "    return status;", "}"]


def _init_float(w: Writer) -> list[str]:
    control = "control" if w.model.l else "NULL"
    process = (f"kq_process_init_factor_f32(&model_process, transition, {control}, noise_factor, {w.model.G.shape[1]})"
               if w.model.G is not None else
               f"kq_process_init_f32(&model_process, transition, {control}, noise_covariance)")
    sensor = ("kq_sensor_init_diagonal_f32(&model_sensor, measurement, variance)" if is_diagonal(w.model.R) else
              "kq_sensor_init_f32(&model_sensor, measurement, covariance)")
    return [process, sensor]


def _init_fixed(w: Writer) -> list[str]:
    diagonal = "_diagonal" if is_diagonal(w.model.R) else ""
    return ["kq_process_init_q31(&model_process, &process_table, NULL)",
            f"kq_sensor_init{diagonal}_q31(&model_sensor, &sensor_table, NULL)"]


def _init_filter(w: Writer) -> str:
    unknown = sum(1 << int(i) for i in np.flatnonzero(w.model.unknown))
    if w.is_fixed:
        return (f"kq_diffuse_init_q31(&model_start, &model_filter, &prior, UINT32_C(0x{unknown:x}), NULL)" if unknown else
                "kq_filter_init_q31(&model_filter, &prior, NULL)")
    if unknown:
        return f"kq_diffuse_init_f32(&model_start, &model_filter, first_mean, first_covariance, UINT32_C(0x{unknown:x}))"
    if w.is_constant:
        return "kq_filter_init_root_f32(&model_filter, first_mean, first_root)"
    return "kq_filter_init_f32(&model_filter, first_mean, first_covariance)"


def _predict(w: Writer) -> list[str]:
    u = "u" if w.model.l else "NULL"
    call = f"kq_predict_{w.T}(&model_filter, &model_process, {u})"
    if w.way == "sizes":
        upper = "0" if np.any(np.tril(w.model.A, -1)) else "KQ_FIXED_UPPER"
        call = f"kq_fixed_predict_{w.T}(&model_filter, &model_process, {u}, {w.model.n}, {w.model.l}, {upper})"
    return [f"kq_status {w.name}_predict({_arguments(w)['u']})", "{", f"    return {call};", "}"]


def _update(w: Writer) -> list[str]:
    lines = [f"kq_status {w.name}_update({_arguments(w)['z']})", "{"]
    if w.way == "sizes":
        lines += [f"    if (present == {w.upper}_ALL)",
                  f"        return kq_fixed_update_{w.T}(&model_filter, &model_sensor, z, {w.model.n}, {w.model.m}, 0);"]
    return [*lines, f"    return kq_update_subset_{w.T}(&model_filter, &model_sensor, z, present);", "}"]


def _step(w: Writer) -> list[str]:
    return [f"kq_status {w.name}_step({_arguments(w)['both']})", "{",
            f"    const kq_status status = {w.name}_predict({'u' if w.model.l else ''});",
            f"    return status ? status : {w.name}_update(z, present);", "}"]
