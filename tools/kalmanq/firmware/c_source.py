"""A filter as a C file: its numbers as constants, its objects, and functions that call the library."""

from __future__ import annotations

import re
from dataclasses import dataclass
from string import Template
from typing import Any, Iterable, Iterator, Optional, Sequence

import numpy as np

from kalmanq.core import arithmetic_of, lib, nearest
from kalmanq.errors import KalmanqError
from kalmanq.firmware.conversions import to_raw
from kalmanq.firmware.replay import Replay
from kalmanq.firmware.steps_kept import latest_of, steps_late
from kalmanq.model import Model, Quantity
from kalmanq.run.filters import Filter
from kalmanq.run.parts import CONSTANT, Parts, is_diagonal, known_prior, not_lean, ways_of
from kalmanq.run.robust import Robust

WORDS = frozenset("""auto break case char const continue default do double else enum extern float for goto if inline int
    long register restrict return short signed sizeof static struct switch typedef union unsigned void volatile while
    bool class delete new template this namespace main kalmanq assert complex ctype errno fenv float inttypes iso646
    limits locale math setjmp signal stdalign stdarg stdatomic stdbool stddef stdint stdio stdlib stdnoreturn string
    tgmath threads time uchar wchar wctype""".split())
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
        self.word = WORD[self.T]
        moved = [(f"const {self.word} u[{len(self.model.inputs)}]", "u")] if self.model.inputs else []
        moved += [("float dt", "dt")] if any_dt else [("uint32_t steps", "steps")] if self.longer else []
        self.u, self.given = (", ".join(texts) for texts in zip(*moved)) if moved else ("", "")
        self.z = f"const {self.word} z[{self.model.m}], uint32_t present"
        self.names = self._names()
        self.sensors = self._sensors()
        self.latest = latest_of(self.model)
        self.replay = None if any_dt or not self.latest else replay_of(self.model, self.T, self.longer, self.name)

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


def replay_of(model: Model, arithmetic: str, longer: Sequence[Parts] = (), name: str = "") -> Replay:
    return Replay(name, arithmetic, model.n, model.m, len(model.inputs), bool(longer), latest_of(model) + 1)


def bytes_of_delays(model: Model, arithmetic: str, any_dt: bool = False) -> int:
    """RAM for what is late"""
    latest = latest_of(model)
    if not latest:
        return 0
    return 4 * arithmetic_of(arithmetic).length("lag", model.n, model.m, latest) if any_dt else replay_of(model, arithmetic).ram


def identifier(text: str) -> str:
    """For files and functions: no word of C, no header of C or of the library, nothing that begins as its names do."""
    made = re.sub(r"\W+", "_", text, flags=re.ASCII).strip("_").lower() or "filter"
    return f"filter_{made}" if made[0].isdigit() or made in WORDS or made.startswith("kq") else made


def plain(text: str) -> str:
    """For a comment: what would end it, or be read as something else, is taken apart."""
    printable = "".join(c if c.isprintable() else " " for c in text)
    return re.sub(r"([*?/])(?=[/*?])", r"\1 ", printable)


def source(parts: Parts, way: str, name: str = "", remarks: Sequence[str] = (), any_dt: bool = False, steps: int = 1,
           robust: Optional[Robust] = None) -> Source:
    """The filter of a model; remarks go to the top of the header.

    any_dt   of a model in continuous time, in f32 as init: a predict is told the length of its step
    steps    of a model in continuous time, in q31: a predict is told how many dt it goes, so many at most
    """
    if steps > 1 and (parts.model.continuous is None or parts.arithmetic.name != "q31" or way == "sizes"):
        raise KalmanqError("--steps: of a model with F, Qc and dt, in q31, and not as sizes; f32 has --any-dt")
    if any_dt and (parts.model.continuous is None or parts.arithmetic.name != "f32" or way != "init"):
        raise KalmanqError("steps of any length are of a model with F, Qc and dt, in f32 and prepared at the start (init)")
    if robust and latest_of(parts.model):
        raise KalmanqError("--robust: and a sensor with a delay, whose steps are worked out again: leave --robust out")
    if any(one.delay for one in parts.model.sensors) and np.any(parts.model.unknown):
        raise KalmanqError("sensors: a delay, and a start that is unknown: give P0")
    if way not in ways_of(parts.model):
        raise KalmanqError(f"{parts.model.name} cannot be written as {way}: {not_lean(parts.model)}")
    writer = Writer(parts, way, identifier(name or parts.model.name), any_dt, steps, robust)
    return Source(writer.name, _header(writer, remarks), _text(writer))


# ------------------------------------------------------------------------------ the header

HEADER = Template("""\
/*
 * $name: $n states, $m measurements, $l controls, in $T.
 *
$comment
 */
#ifndef KALMANQ_DESIGN_${upper}_H
#define KALMANQ_DESIGN_${upper}_H

$math#include <stdint.h>

#include <kalmanq/kalmanq.h>

#ifdef __cplusplus
extern "C" {
#endif

$definitions/** Before the first sample. */
kq_status ${name}_init(void);

/** To the next sample$after.$works */
kq_status ${name}_predict($u);

/** Takes what is present of a sample, a bit for each measurement. */
kq_status ${name}_update($z);

/** Predict and update.  Where the update is refused, the predict stands. */
kq_status ${name}_step($both);

$sensors/** For the library's readings: kq_mean_$T(${name}_filter(), ...), kq_sigma_$T, ... */
kq_filter_$T *${name}_filter(void);

#ifdef __cplusplus
}
#endif

#endif
""")


def _header(w: Writer, remarks: Sequence[str]) -> str:
    comment = [*_usage(w), "", *_table(w), *(["", *remarks] if remarks else [])]
    definitions = [*_enumerations(w), *_ranges(w), *(_conversions(w) if w.is_fixed else [])]
    return HEADER.substitute(
        name=w.name, upper=w.upper, n=w.model.n, m=w.model.m, l=len(w.model.inputs), T=w.T, u=w.u or "void", z=w.z,
        both=f"{w.u}, {w.z}" if w.u else w.z, sensors=_sensor_calls(w),
        after=f", dt ({w.model.continuous.unit}) later.  Another dt than the last one costs what kq_process_init_continuous does"
        if w.any_dt else f", 1 to {len(w.longer) + 1} dt later, otherwise KQ_ERR_SIZE" if w.longer else "",
        works=f"  For what comes late the oldest of {w.latest + 1} steps is worked out, too: it costs one step more." if w.replay else "", math="#include <math.h>\n" if w.is_fixed else "",
        comment="\n".join(f" * {line}".rstrip() for line in comment),
        definitions="".join(f"{line}\n" for line in definitions))


def _usage(w: Writer) -> list[str]:
    state, first, given = w.names["states"][0], w.names["measurements"][0], f"{w.given}, " if w.given else ""
    mean = f"kq_mean_{w.T}({w.name}_filter(), {state})"
    taken = [(f"z[{first}] = {first}_RAW(measured);", "from its unit")] if w.is_fixed else []
    calls = [(f"{w.name}_init();", "once"), *taken, (f"{w.name}_update(z, {w.upper}_ALL);", "the first sample"),
             (f"{w.name}_step({given}z, {w.upper}_ALL);", "each other one"),
             (f"{state}_VALUE({mean})" if w.is_fixed else mean, "what it says")]
    width = max(len(call) for call, _ in calls) + 4
    return [f"    {call:<{width}}{what}" for call, what in calls]


def _table(w: Writer) -> list[str]:
    rows = [("", "name", "unit", "format", "largest")]
    rows += [(what, plain(one.name), plain(one.unit), f"Q{31 - fraction}.{fraction}", f"{one.range or 0:g}")
             for what, one, _, fraction in w.quantities()]
    columns = 5 if w.is_fixed else 3
    widths = [max(len(row[k]) for row in rows) for k in range(columns)]
    return ["    " + "  ".join(f"{cell:<{width}}" for cell, width in zip(row, widths)) for row in rows]


def _sensor_calls(w: Writer) -> str:
    lines = []
    for one in w.sensors:
        lines += [f"/** Takes what is present of {plain(one.title)}, a bit for each of its measurements."]
        if one.late:
            limit = [f"    Costs {w.latest + 1} steps where `ago` is not 0.  One value of each measurement in a step, otherwise",
                     "    KQ_ERR_HISTORY_FULL. */"] if w.replay else \
                [f"    After more than {w.model.m} numbers in one step it is at an end: KQ_ERR_HISTORY_FULL. */"]
            lines[-1:] = [f"/** The same of {plain(one.title)}, measured `ago` predicts before now: 0 to {w.latest}, otherwise KQ_ERR_SIZE.",
                          f"    Its delay is {'at most ' if one.varies else ''}{one.late} steps of dt.  As if it had come in time where a predict ended at the instant that it",
                          "    was measured at; otherwise take the nearest one.", *limit]
        else:
            lines[-1] += " */"
        lines += [f"kq_status {_sensor_signature(w, one)};", ""]
    return "".join(f"{line}\n" for line in lines)


def _sensor_signature(w: Writer, one: SensorCall) -> str:
    return f"{w.name}_update_{one.name}(const {w.word} z[{one.count}], uint32_t present{', size_t ago' if one.late else ''})"


def _sensor_functions(w: Writer) -> str:
    """Each by the sensor of all, of which only its own measurements are present"""
    lines = []
    for one in w.sensors:
        cells = [f"z[{k - one.first}]" if one.first <= k < one.first + one.count else "0" for k in range(w.model.m)]
        own = f"(present & {(1 << one.count) - 1}u) << {one.first}" if one.first else f"present & {(1 << one.count) - 1}u"
        lines += [f"kq_status {_sensor_signature(w, one)}", "{",
                  f"    const {w.word} all[{w.model.m}] = {{{', '.join(cells)}}};"]
        if one.late and w.replay:
            lines += [f"    return take(all, {own}, ago);"]
        elif one.late:
            lines += [line.rstrip("\n") for line in [_rest(w, "all")] if line]
            lines += [f"    return kq_update_delayed_{w.T}(&model_past, ago, &model_sensor, {'all' if w.model.d is None else 'rest'}, {own});"]
        else:
            lines += [f"    return {w.name}_update(all, {own});"]
        lines += ["}", ""]
    return "".join(f"{line}\n" for line in lines)


def _enumerations(w: Writer) -> list[str]:
    lines = []
    for kind, names in w.names.items():
        if names:
            lines += ["enum {", *(f"    {name}," for name in names), f"    {w.upper}_{kind.upper()}", "};", ""]
    if w.is_fixed:
        fractions = ",\n".join(f"    {name}_FRACTION = {fraction}" for _, _, name, fraction in w.quantities())
        lines += ["/* value = word * 2^-fraction */", "enum {", fractions, "};", ""]
    every = f"#define {w.upper}_ALL UINT32_C(0x{(1 << w.model.m) - 1:x})"
    return [*lines, "/* present: all measurements */", every, ""]


def _ranges(w: Writer) -> list[str]:
    lines = [f"#define {name}_RANGE {repr(float(one.range)) if w.is_fixed else _float(w, one.range)}"
             for _, one, name, _ in w.quantities() if one.range]
    return ["/* The declared ranges, in units: |value| <= range */", *lines, ""] if lines else []


TO_VALUE = """\
/* And back: of means, sigmas and measurements; KQ_NOT_A_VALUE_Q31 becomes NaN. */
static inline double {name}_to_value(int32_t raw, double last_bit)
{{
    return raw == KQ_NOT_A_VALUE_Q31 ? (double)NAN : (double)raw * last_bit;
}}
"""


def _conversions(w: Writer) -> list[str]:
    lines = [*to_raw(w.name, "KQ_NOT_A_VALUE_Q31", "refuses such a control"), "", *TO_VALUE.format(name=w.name).split("\n")]
    for _, _, name, fraction in w.quantities():
        lines += [f"#define {name}_RAW(value) {w.name}_to_raw((double)(value), {2.0**fraction!r})",
                  f"#define {name}_VALUE(raw) {w.name}_to_value((raw), {2.0**-fraction!r})"]
    return [*lines, ""]


# ------------------------------------------------------------------------------ the source

TEXT = Template("""\
/* See $name.h. */
#include "$name.h"

$fixed_sizes$tables

KQ_FILTER_$upper_T(model_filter, $n);
$objects

kq_status ${name}_init(void)
{
$init
}

$moving$predict_head
{
$moved$pushes    return $predict;
}

$less$update_head
{
$rest$update    return $taking
}
$replay
kq_status ${name}_step($both)
{
    const kq_status status = ${name}_predict($given);
    return status ? status : ${name}_update(z, present);
}

${sensors}kq_filter_$T *${name}_filter(void) { return &model_filter; }
""")


LESS = """\
/* z - d, saturated; what is no value stays so */
static int32_t less(int32_t z, int32_t d)
{
    const int64_t rest = (int64_t)z - d;
    if (z == KQ_NOT_A_VALUE_Q31 || rest < -INT32_MAX) return z == KQ_NOT_A_VALUE_Q31 ? z : -INT32_MAX;
    return rest > INT32_MAX ? INT32_MAX : (int32_t)rest;
}

"""
MOVING = """\
/* A, B and Q of a step of dt; nothing to do where it is as long as the last one */
static kq_status move(float dt)
{
    if (dt == model_dt) return KQ_OK;
    const kq_status status = kq_process_init_continuous_f32(
        &model_process, rates, $control, density, dt, model_memory, sizeof model_memory / sizeof *model_memory);
    if (!status) model_dt = dt;
    return status;
}

"""
MOVED = """\
    const kq_status status = move(dt);
    if (status) return status;
"""


def _text(w: Writer) -> str:
    n, m, l, T = w.model.n, w.model.m, w.model.l, w.T
    u, at_once, fixed_sizes = "NULL" if not l else "all" if w.model.c is not None else "u", "", ""
    taken = "z" if w.model.d is None else "rest"
    filter_ = "f" if w.replay else "&model_filter"
    predict = f"kq_predict_{T}({filter_}, {'model_processes[steps - 1]' if w.longer else '&model_process'}, {u})"
    taking = f"kq_update_subset_{T}({filter_}, &model_sensor, {taken}, present);"
    if w.way == "sizes":
        fixed_sizes = f'#include "kq_fixed_{T}.h" /* in src/fixed_size of the library */\n\n'
        upper = "0" if np.any(np.tril(w.model.A, -1)) else "KQ_FIXED_UPPER"
        predict = f"kq_fixed_predict_{T}({filter_}, &model_process, {u}, {n}, {l}, {upper})"
        at_once = f"    if (present == {w.upper}_ALL)\n" \
                  f"        return kq_fixed_update_{T}({filter_}, &model_sensor, {taken}, {n}, {m}, 0);\n"
    if w.robust:
        at_once, taking = _robust(w, f"kq_update_robust_{T}({filter_}, &model_sensor, {taken}, present, &model_loss);", taking)
    start = [f"KQ_DIFFUSE_{T.upper()}(model_start, {n}, 0);"] if w.unknown else []
    start += w.replay.objects() if w.replay else \
        [f"KQ_DELAY_{T.upper()}(model_past, {n}, {m}, {w.latest});"] if w.latest else []
    return TEXT.substitute(
        name=w.name, T=T, upper_T=T.upper(), n=n, u=w.u or "void", z=w.z, both=f"{w.u}, {w.z}" if w.u else w.z,
        given=w.given, fixed_sizes=fixed_sizes, predict=predict, update=at_once, taking=taking, filter=filter_, predict_head=_head(w, "predict", w.u), update_head=_head(w, "update", w.z),
        replay=_replay(w), init=_init(w), sensors=_sensor_functions(w),
        pushes=_pushes(w), rest=_rest(w), less=LESS if w.is_fixed and w.model.d is not None else "",
        moving=MOVING.replace("$control", "rates_of_control" if l else "NULL") if w.any_dt else "", moved=MOVED if w.any_dt else f"    if (steps < 1 || steps > {len(w.longer) + 1}) return KQ_ERR_SIZE;\n" if w.longer else "",
        tables="\n".join((_tables_fixed if w.is_fixed else _tables_float)(w)),
        objects="\n".join([*start, *_loss(w), *(_objects_constant if w.is_constant else _objects)(w)]))


def _head(w: Writer, which: str, arguments: str) -> str:
    """Of a predict or an update: of the filter, or of any"""
    if w.replay is None:
        return f"kq_status {w.name}_{which}({arguments or 'void'})"
    return f"static kq_status {which}(kq_filter_{w.T} *f{', ' if arguments else ''}{arguments})"


def _replay(w: Writer) -> str:
    """What works out steps again, and the calls that keep them"""
    if w.replay is None:
        return ""
    predict = [f"kq_status {w.name}_predict({w.u or 'void'})", "{", *w.replay.predict(), "}"]
    update = [f"kq_status {w.name}_update({w.z})", "{", "    return take(z, present, 0);", "}"]
    return "\n".join(["", *w.replay.functions(), *predict, "", *update, ""])


def _pushes(w: Writer) -> str:
    """The controls, and the 1 of the offset"""
    if w.model.c is None:
        return ""
    one = f"INT32_C({1 << w.parts.fractions('controls')[-1]})" if w.is_fixed else _float(w, 1)
    given = [*(f"u[{k}]" for k in range(len(w.model.inputs))), one]
    return f"    const {w.word} all[{w.model.l}] = {{{', '.join(given)}}};\n"


def _rest(w: Writer, z: str = "z") -> str:
    """z without its offsets"""
    if w.model.d is None:
        return ""
    if w.is_fixed:
        words = nearest(np.ldexp(w.model.d, w.parts.fractions("measurements")))
        cells = [f"less({z}[{k}], INT32_C({int(one)}))" for k, one in enumerate(words)]
    else:
        cells = [f"{z}[{k}] - {_float(w, one)}" if one >= 0 else f"{z}[{k}] + {_float(w, -one)}" for k, one in enumerate(w.model.d)]
    return f"    const {w.word} rest[{w.model.m}] = {{{', '.join(cells)}}};\n"


def _array(kind: str, name: str, cells: Sequence[str], columns: int, remark: str = "") -> list[str]:
    """columns: of a matrix, a row of it a line; otherwise as many as fit."""
    head = [f"/* {remark} */"] if remark else []
    flat = f"static const {kind} {name}[{len(cells)}] = {{{', '.join(cells)}}};"
    if len(flat) <= 100:
        return [*head, flat]
    rows = [", ".join(cells[k : k + columns]) for k in range(0, len(cells), columns)]
    return [*head, f"static const {kind} {name}[{len(cells)}] = {{", *(f"    {row}," for row in rows), "};"]


# ------ f32, f64


def _float(w: Writer, value: float) -> str:
    return f"{np.float32(value)!s}f" if w.T == "f32" else repr(float(value))  # the shortest decimal that is this number


def _floats(w: Writer, name: str, values: Iterable[float], columns: int, remark: str = "") -> list[str]:
    return _array(w.word, name, [_float(w, value) for value in np.ravel(values)], columns, remark)


def _tables_float(w: Writer) -> list[str]:
    model, n = w.model, w.model.n
    lines = _tables_continuous(w) if w.any_dt else _tables_of_steps(w)
    lines += _floats(w, "measurement", model.H, n, "H, m x n")
    lines += _floats(w, "variance", np.diag(model.R), 6, "R: the noises are independent") if w.is_diagonal else \
        _floats(w, "covariance", model.R, model.m, "R, m x m")
    lines += _floats(w, "first_mean", model.x0, 6, "x0 and P0: before the first sample")
    if w.unknown or not w.is_constant:
        return lines + _floats(w, "first_covariance", known_prior(model), n)
    return lines + _floats(w, "first_root", Filter(model, w.T, parts=w.parts).memory[-(n * (n + 1) // 2):], 6)


def _tables_continuous(w: Writer) -> list[str]:
    of, n = w.model.continuous, w.model.n
    lines = _floats(w, "rates", of.F, n, "F, n x n")
    lines += [] if of.B is None else _floats(w, "rates_of_control", of.B, w.model.l, "B of continuous time, n x l")
    return lines + _floats(w, "density", of.Qc, n, "Qc, n x n")


def _tables_of_steps(w: Writer) -> list[str]:
    model, n = w.model, w.model.n
    lines = _floats(w, "transition", model.A, n, "A, n x n")
    lines += [] if model.B is None else _floats(w, "control", model.B, model.l, "B, n x l")
    if w.is_constant:
        root = w.parts.process.noise_root
        lines += _floats(w, "noise_root", [float(root[k]) for k in range(n * (n + 1) // 2)], 6,
                         "G, upper triangle by columns: Q = G G'")
    elif model.G is not None:
        lines += _floats(w, "noise_factor", model.G, model.G.shape[1], "G: Q = G G'")
    else:
        lines += _floats(w, "noise_covariance", model.Q, n, "Q, n x n")
    return lines


# ------ q31


def _scaled(name: str, numbers: Any, count: int, columns: int, remark: str) -> list[str]:
    cells = [f"{{{numbers[k].mantissa}, {numbers[k].exponent}}}" for k in range(count)]
    return _array("kq_scaled_q31", name, cells, columns, remark)


def _words(name: str, words: Any, count: int, remark: str = "") -> list[str]:
    return _array("int32_t", name, [str(words[k]) for k in range(count)], 6, remark)


def _tables_fixed(w: Writer) -> list[str]:
    model, process, sensor, prior = w.model, w.parts.process_table, w.parts.sensor_table, w.parts.prior
    n, m, l = model.n, model.m, model.l
    root = int(lib.kq_length_q31(lib.KQ_OBJECT_ROOT, n, 0, 0, 0))
    lines = ["/* {range in words, fraction} */"]
    for kind in KINDS[: 3 if l else 2]:
        formats = w.parts.formats[kind]
        cells = [f"{{{formats[k].range}, {formats[k].fraction}}}" for k in range(len(getattr(model, kind)))]
        lines += _array("kq_format_q31", f"{kind[:-1]}_format", cells, 4)
    lines += ["/* {mantissa, exponent}, in words of the states */"]
    for count, table in enumerate([process, *(one.process_table for one in w.longer)], 1):
        end, of = ("", "") if count == 1 else (f"_{count}", f" of {count} dt")
        lines += _scaled(f"transition{end}", table.transition, n * n, min(n, 4), f"A, n x n{of}")
        lines += _scaled(f"control{end}", table.control, n * l, min(l, 4), f"B, n x l{of}") if l else []
        lines += _words(f"noise_root{end}", table.noise_root, root, f"G, upper triangle by columns and exponents: Q = G G'{of}")
    lines += _scaled("measurement", sensor.measurement, m * n, min(n, 4), "H, m x n")
    lines += _scaled("variance", sensor.noise, m if w.is_diagonal else m * (m + 1) // 2, 4, "R")
    lines += _words("first_mean", prior.mean, n, "x0 and the root of P0: before the first sample")
    lines += _words("first_root", prior.root, root)
    lines += [f"static const kq_prior_table_q31 prior = {{{n}, state_format, first_mean, first_root}};"]
    return lines if w.is_constant else lines + _tables_to_init(w)


def _ends(w: Writer) -> list[str]:
    """Of names of a step, of two, ..."""
    return ["", *(f"_{count}" for count in range(2, len(w.longer) + 2))]


def _processes(w: Writer, const: str) -> list[str]:
    names = ", ".join(f"&model_process{end}" for end in _ends(w))
    return [f"static {const}kq_process_q31 *const model_processes[{len(w.longer) + 1}] = {{{names}}};"] if w.longer else []


def _tables_to_init(w: Writer) -> list[str]:
    n, m, l = w.model.n, w.model.m, w.model.l
    control = [f"    .controls = {l}, .control_format = control_format, .control = control,"] if l else []
    tables = [line for end in _ends(w) for line in [
        f"static const kq_process_table_q31 process_table{end} = {{",
        f"    .states = {n}, .state_format = state_format, .transition = transition{end},", *(one.replace("= control,", f"= control{end},") for one in control),
        f"    .noise_root = noise_root{end}}};"]]
    return [*tables, "static const kq_sensor_table_q31 sensor_table = {",
            f"    .states = {n}, .components = {m}, .correlated = {int(not w.is_diagonal)},",
            "    .state_format = state_format, .measurement_format = measurement_format,",
            "    .measurement = measurement, .noise = variance};"]


# ------ objects and their init


def _loss(w: Writer) -> list[str]:
    """Of robust updates; a gate has the limit of as many measurements as are present"""
    if w.robust is None:
        return []
    declared = f"static kq_loss_{w.T} model_loss = {{.kind = &kq_loss_{w.robust.way}_{w.T}"
    if w.robust.way == "gate":
        limits = w.robust.limits(w.parts.arithmetic, w.model.m)
        cells = [f"INT64_C({one})" if w.is_fixed else _float(w, one) for one in limits]
        return [*_array("int64_t" if w.is_fixed else w.word, "gate_limit", cells, 4, "of NIS, of 1 measurement, of 2, ..."), f"{declared}}};"]
    value = w.parts.arithmetic.parameter(w.robust.value)
    return [f"{declared}, .parameter = {'{{{mantissa}, {exponent}}}'.format(**value) if w.is_fixed else _float(w, value)}}};"]


def _robust(w: Writer, call: str, plain: str) -> tuple[str, str]:
    """What comes before, and what an update returns"""
    assert w.robust
    before = "" if w.robust.way != "gate" else "    unsigned count = 0;\n" \
        f"    for (unsigned j = 0; j < {w.model.m}u; j++) count += present >> j & 1u;\n" \
        "    model_loss.limit = gate_limit[count ? count - 1u : 0];\n"
    if not w.unknown:
        return before, call
    return f"{before}    const kq_status status = {call}\n" \
           f"    if (status == KQ_ERR_NOT_READY) /* a state is not known so far */\n        return {plain}\n", "status;"


def _objects_constant(w: Writer) -> list[str]:
    n, m, l = w.model.n, w.model.m, w.model.l
    control, kind = ("control" if l else "NULL"), ("SENSOR_LEAN_TABLE" if w.way == "lean" else "SENSOR_TABLE")
    of_A, of_H = (f"({', '.join(map(str, numbers))})" for numbers in w.parts.zeros)
    if w.is_fixed:
        controls = "control_format" if l else "NULL"
        rows = [of_A, *(f"({', '.join(map(str, one.zeros[0]))})" for one in w.longer)]
        return [*(f"static const kq_process_q31 model_process{end} = KQ_PROCESS_TABLE_Q31(\n    {n}, {l}, state_format, {controls}, "
                  f"transition{end}, {control + end if l else control}, noise_root{end}, {row});" for end, row in zip(_ends(w), rows)),
                *_processes(w, "const "),
                f"static const kq_sensor_q31 model_sensor = KQ_{kind}_Q31(\n    {n}, {m}, state_format, measurement_format, "
                f"measurement, variance, {of_H});"]
    return [f"static const kq_process_{w.T} model_process = KQ_PROCESS_TABLE({n}, {l}, transition, {control}, "
            f"noise_root,\n    {of_A});",
            f"static const kq_sensor_{w.T} model_sensor = KQ_{kind}_{w.T.upper()}({n}, {m}, measurement, variance, {of_H});"]


def _objects(w: Writer) -> list[str]:
    if w.is_fixed:
        return [*(f"static kq_process_q31 model_process{end};" for end in _ends(w)), *_processes(w, ""), "static kq_sensor_q31 model_sensor;"]
    kind = f"KQ_SENSOR_{'DIAGONAL_' if w.is_diagonal else ''}{w.T.upper()}"
    moved = [f"static float model_memory[KQ_CONTINUOUS_LEN({w.model.n}, {w.model.l})], model_dt;"] if w.any_dt else []
    return [f"KQ_PROCESS_{w.T.upper()}(model_process, {w.model.n}, {w.model.l});", *moved,
            f"{kind}(model_sensor, {w.model.n}, {w.model.m});"]


def _init(w: Writer) -> str:
    calls = [] if w.is_constant else _init_fixed(w) if w.is_fixed else _init_float(w)
    calls.append(_init_filter(w))
    calls += w.replay.start() if w.replay else [f"kq_attach_{w.T}(&model_filter, &model_past.attached)"] if w.latest else []
    begin = ["    model_loss.rejected = 0;"] if w.robust and w.robust.way == "gate" else []
    begin += ["    model_steps[0].present = 0;", "    model_newest = 0;", "    model_count = 1;"] if w.replay else []
    if len(calls) == 1:
        return "\n".join([*begin, f"    return {calls[0]};"])
    others = [f"    if (!status) status = {call};" for call in calls[1:]]
    return "\n".join([*begin, f"    kq_status status = {calls[0]};", *others, "    return status;"])


def _init_float(w: Writer) -> list[str]:
    control = "control" if w.model.l else "NULL"
    process = (f"kq_process_init_factor_{w.T}(&model_process, transition, {control}, noise_factor, {w.model.G.shape[1]})"
               if w.model.G is not None else
               f"kq_process_init_{w.T}(&model_process, transition, {control}, noise_covariance)")
    sensor = (f"kq_sensor_init_diagonal_{w.T}(&model_sensor, measurement, variance)" if w.is_diagonal else
              f"kq_sensor_init_{w.T}(&model_sensor, measurement, covariance)")
    return [sensor] if w.any_dt else [process, sensor]  # the first predict makes the process


def _init_fixed(w: Writer) -> list[str]:
    return [*(f"kq_process_init_q31(&model_process{end}, &process_table{end}, NULL)" for end in _ends(w)),
            f"kq_sensor_init{'_diagonal' if w.is_diagonal else ''}_q31(&model_sensor, &sensor_table, NULL)"]


def _init_filter(w: Writer) -> str:
    start, unknown = f"kq_diffuse_init_{w.T}(&model_start, &model_filter, ", f"UINT32_C(0x{w.unknown:x})"
    if w.is_fixed:
        return f"{start}&prior, {unknown}, NULL)" if w.unknown else "kq_filter_init_q31(&model_filter, &prior, NULL)"
    if w.unknown:
        return f"{start}first_mean, first_covariance, {unknown})"
    if w.is_constant:
        return f"kq_filter_init_root_{w.T}(&model_filter, first_mean, first_root)"
    return f"kq_filter_init_{w.T}(&model_filter, first_mean, first_covariance)"
