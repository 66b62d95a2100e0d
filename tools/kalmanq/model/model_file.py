"""Model files: TOML, one model a file.

    [model]         A, B, H, Q (or G), R, x0, P0 as nested arrays, a vector flat; or builder = "..." with its
                    parameters; or in the place of A and Q: F, Qc and dt of x' = F x + B u + c + noise (or L w, Qc of w),
                    and jitter, a share of dt.  Offsets: c (n) of the states, d (m) of the measurements; D (m x l): z = H x + D u.
                    A text in A, B, Q, H, R, D or d is an expression of columns of the data (columns.py).
                    P0 = "unknown", or "unknown" in the place of a state's variance.
    [states], [measurements], [controls], [columns]   names, units, ranges, fractions: a list each, one for each of them; of what data
                    files have, also columns, factors, offsets, missing, plausible
    [[sensors]]     in the place of H, R and [measurements], one for each: name, measurements (names), H, R, units, ranges,
                    fractions, d, D, delay, measured (a column: when, at most `delay` ago)
    [recording]     how data files are written: time, time_format, separator, decimal, sort, skip_untimed, pause; database, origin
    [gaps]          max_gap, min_run
"""

from __future__ import annotations

import difflib
import re
import sys
from pathlib import Path
from typing import Any, Mapping, Optional, Sequence

import numpy as np

from kalmanq.errors import KalmanqError, ModelError, counted
from kalmanq.model import builders, columns
from kalmanq.model.arrays import block_diagonal
from kalmanq.model.column_file import controls_of, through, with_columns, within
from kalmanq.model.model import AS_IT_IS, Gaps, Model, Quantity, Sensor, not_finite
from kalmanq.model.quantities import READ, RECORDING, SHOWN, is_numbers, quantities, recording

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

MATRICES = ("A", "B", "c", "d", "D", "H", "Q", "G", "R", "x0", "P0", "F", "L", "Qc", "dt", "jitter")
ROWS_MAX = 100_000_000  # of a gap, or of a run
SUFFIXES, NO_MODEL = (".toml", ""), "a model file is TOML, or Python with .py"
TABLES = (".csv", ".tsv", ".txt", ".log")
SECTIONS = {
    "model": (*MATRICES, "name", "builder", "time_unit"),
    "states": ("names", "units", "ranges", "fractions"),
    "measurements": ("names", "units", "ranges", "fractions", *READ),
    "controls": ("names", "units", "ranges", "fractions", *READ),
    "columns": ("names", "units", "ranges", "fractions", *READ),
    "recording": tuple(RECORDING),
    "gaps": ("max_gap", "min_run"),
    "sensors": ("name", "measurements", "H", "R", "d", "D", "delay", "measured", "units", "ranges", "fractions", *READ),
}


class ModelFileError(KalmanqError):
    """PATH: line N: KEY: what was expected."""


class SensorError(ModelError):
    """Of sensor `number`, counted from 0"""

    def __init__(self, number: int, problem: ModelError):
        super().__init__(problem.key, problem.reason)
        self.number = number


def read(path: Path) -> Model:
    if Path(path).suffix == ".py":
        raise ModelFileError(f"{path}: is a nonlinear model, which run, compare, check, compile, simulate and report take; "
                             "this takes a linear one (TOML)")
    text = _text(path)
    try:
        given = tomllib.loads(text)
    except tomllib.TOMLDecodeError as problem:
        said = re.sub(r" \(at line (\d+), column \d+\)", "", str(problem))
        line = re.search(r"at line (\d+)", str(problem))
        number = line.group(1) if line else len(text.splitlines())  # "at end of document"
        shown = text.splitlines()[int(number) - 1].strip()[:SHOWN] if text.strip() else ""
        hint = "; the model file comes first, then the data" if Path(path).suffix in TABLES else \
            f"; {NO_MODEL}" if Path(path).suffix.lower() not in SUFFIXES else ""
        raise ModelFileError(f"{path}: line {number}: {said}: {shown}{hint}") from None
    except RecursionError:
        raise ModelFileError(f"{path}: arrays are nested too deeply") from None
    except ValueError:  # Python's own limit
        raise ModelFileError(f"{path}: a number has too many digits") from None
    section = "model"
    try:
        for section, content in given.items():
            known(section, content)
        section = "model"
        return _model(path, given)
    except ModelError as problem:
        number = problem.number if isinstance(problem, SensorError) else 0
        section = "sensors" if isinstance(problem, SensorError) else problem.key if problem.key in SECTIONS else section
        line_number = line_of(text, section, problem.key, number)
        where = f"line {line_number}: " if line_number else ""
        raise ModelFileError(f"{path}: {where}{problem}") from None
    except KalmanqError as problem:
        raise ModelFileError(f"{path}: {problem}") from problem
    except RecursionError:
        raise ModelFileError(f"{path}: arrays are nested too deeply") from None


def _text(path: Path) -> str:
    try:
        return Path(path).read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise ModelFileError(f"{path}: no such file") from None
    except IsADirectoryError:
        raise ModelFileError(f"{path}: is a folder: give the model file in it") from None
    except UnicodeDecodeError:
        raise ModelFileError(f"{path}: {NO_MODEL if Path(path).suffix.lower() not in SUFFIXES else 'is not UTF-8 text: save it as UTF-8'}") from None


def line_of(text: str, section: str, key: str, which: int = 0) -> Optional[int]:
    """The line of [section], key = ...; that of the section where the key is not there.  which: of several [[section]]"""
    inside, found, seen = section not in SECTIONS, None, -1  # a key before all sections
    for number, line in enumerate(text.splitlines(), 1):
        header = re.match(r"\s*\[{1,2}\s*([\w-]+)\s*\]", line)
        if header:
            seen += header.group(1) == section
            inside = header.group(1) == section and seen == which
            found = number if inside and found is None else found
        if inside and re.match(rf"\s*[\"']?{re.escape(key)}[\"']?\s*=", line):
            return number
    return found


def known(section: str, content: Any) -> None:
    if section in SECTIONS["model"]:
        raise ModelError(section, "is a key of [model]: put a line [model] before it")
    if section not in SECTIONS:
        raise ModelError(section, "no such section" + _near(section, SECTIONS))
    if section == "sensors" and isinstance(content, list) and all(isinstance(one, dict) for one in content):
        for number, one in enumerate(content):
            _known_of_sensor(number, one)
        return
    if not isinstance(content, dict) or section == "sensors":
        raise ModelError(section, f"is a section: [[{section}]]" if section == "sensors" else f"is a section: [{section}]")
    if section == "model" and "builder" in content:
        return
    for key in content:
        if section == "model" and key in SECTIONS["sensors"] and key not in SECTIONS["model"]:
            raise ModelError(key, "is of a sensor: put it below [[sensors]], with the H and R of that sensor")
        if key not in SECTIONS[section]:
            raise ModelError(key, f"no such key in [{section}]" + _near(key, SECTIONS[section]))


def _known_of_sensor(number: int, content: Mapping[str, Any]) -> None:
    for key in content:
        if key not in SECTIONS["sensors"]:
            raise SensorError(number, ModelError(key, "no such key in [[sensors]]" + _near(key, SECTIONS["sensors"])))


def _near(name: str, known: Any) -> str:
    near = [one for one in known if one.lower() == name.lower()] or difflib.get_close_matches(name, list(known), 1, 0.5)
    return f"; {near[0]}?" if near else f": {', '.join(known)}"


def _model(path: Path, given: Mapping[str, Any]) -> Model:
    given, texts = _numbers_apart(given)
    model = dict(given.get("model", {}))
    if not model:
        raise ModelError("model", "there is no section [model]" if given else "there is no section [model]: the file has no line of a model")
    name = _typed(model.pop("name", Path(path).stem), str, "name", "a text")
    unit = _typed(model.pop("time_unit", ""), str, "time_unit", "a text")
    given_to_builder = dict(model) if "builder" in model else None
    if "builder" in model:
        made = _built(model)
    else:
        made = {key: _array(key, value) for key, value in model.items() if key != "P0"}
        has_sensors = "sensors" in given
        for key in _needed(made):
            if key in ("H", "R") and has_sensors:
                continue
            if key not in made:
                raise ModelError(key, "is missing from [model]")
        if "P0" not in model:
            raise ModelError("P0", 'is missing from [model]: a matrix, variances, or "unknown"')
        made.update(_prior(model["P0"]))
    count = _count_of_states(made)
    sensors = _sensors(given, made, count) if "sensors" in given else ()
    sizes = {"states": count, "measurements": _height(made["H"]), "controls": controls_of(made)}
    for which, size in sizes.items():
        if which != "measurements" or not sensors:
            default = made.pop(which, None)
            made[which] = quantities(which, given.get(which, {}), size, default)
    if unit and "F" not in made:
        raise ModelError("time_unit", "is of a model with F, Qc and dt, or of a builder in continuous time")
    made.update({"time_unit": unit} if unit else {})
    model = Model.of(**made, gaps=_gaps(given.get("gaps", {})), name=name)
    model.sensors, model.builder, model.recording = tuple(sensors), given_to_builder, recording(given.get("recording", {}))
    return with_columns(model, texts, given.get("columns", {}), quantities)


def _numbers_apart(given: Mapping[str, Any]) -> tuple[dict[str, Any], list[dict[str, Any]]]:
    """The file with 0 in the place of expressions; those of [model], then of each sensor"""
    made, sensors = dict(given), given.get("sensors", [])
    own, texts, parts = given.get("model", {}), {}, []
    if own and "builder" not in own:
        made["model"], texts = columns.taken(own)
    for number, one in enumerate(sensors):
        try:
            parts.append(columns.taken(one))
        except ModelError as problem:
            raise SensorError(number, problem) from None
    if sensors:
        made["sensors"] = [numbers for numbers, _ in parts]
    return made, [texts, *(own for _, own in parts)]


def _count_of_states(made: Mapping[str, Any]) -> int:
    """Of matrices that fit together, before names are counted"""
    key = "F" if "F" in made else "A"
    transition = np.atleast_2d(made[key])
    if transition.ndim != 2 or len(transition) != transition.shape[1]:
        raise ModelError(key, f"is {' x '.join(map(str, transition.shape))}, not square: a row and a column for each state")
    _require_side("B", made.get("B"), 0, len(transition))
    _require_side("H", made.get("H"), 1, len(transition))
    return len(transition)


def _require_side(key: str, matrix: Optional[np.ndarray], axis: int, states: int) -> None:
    """A flat row or column is looked at with the others."""
    if matrix is not None and matrix.ndim == 2 and matrix.shape[axis] != states:
        raise ModelError(key, f"is {' x '.join(map(str, matrix.shape))}: it has a {('row', 'column')[axis]} for each of {counted(states, 'state')}")


def rebuilt(model: Model, given: Mapping[str, Any]) -> Model:
    """A model of its builder with other parameters"""
    builder, of = {**model.builder, **given}, model.continuous
    made = {**_built(dict(builder)), **{which: getattr(model, which) for which in ("states", "measurements", "gaps", "name")}}
    again = Model.of(**made, **({"time_unit": of.unit, "jitter": of.jitter} if of else {}))
    again.builder, again.recording = builder, model.recording
    return again


def _sensors(given: Mapping[str, Any], made: dict[str, Any], states: int) -> list[Sensor]:
    """What sensors there are; `made` gets their H and R, one below the other, and their measurements"""
    for section, key in (("model", "H"), ("model", "R"), ("model", "d"), ("model", "D"), ("measurements", "measurements")):
        if key in made or section == key and section in given:
            raise ModelError(key, "is each sensor's own, where there are [[sensors]]")
    parts = [_sensor(number, one, states) for number, one in enumerate(given["sensors"])]
    if not parts:
        raise ModelError("sensors", "there are no sensors: give at least one")
    names = [name for name, _ in parts]
    for number, name in enumerate(names):
        if name in names[:number]:
            raise SensorError(number, ModelError("name", f"{name} is there twice: each sensor needs its own"))
    made["H"], made["R"] = np.vstack([one.H for _, one in parts]), block_diagonal([one.R for _, one in parts])
    if any(one.d is not None for _, one in parts):
        made["d"] = np.concatenate([np.zeros(one.m) if one.d is None else one.d for _, one in parts])
    made.update(_through(given["sensors"], [one for _, one in parts], made))
    made["measurements"] = [quantity for _, one in parts for quantity in one.measurements]
    return [Sensor(name, tuple(quantity.name for quantity in one.measurements), _delay(number, given["sensors"][number], made),
                   given["sensors"][number].get("measured", ""))
            for number, (name, one) in enumerate(parts)]


def _through(given: Sequence[Mapping[str, Any]], parts: Sequence[Model], made: Mapping[str, Any]) -> dict[str, np.ndarray]:
    """D of all sensors, if one has it"""
    controls, rows = None if made.get("B") is None else _width(made["B"]), []
    for number, (one, part) in enumerate(zip(given, parts)):
        try:
            rows.append(through(_array("D", one["D"]), part.m, controls) if "D" in one else None)
        except ModelError as problem:
            raise SensorError(number, problem) from None
        controls = controls if rows[-1] is None else rows[-1].shape[1]
    return {} if all(one is None for one in rows) else {
        "D": np.vstack([np.zeros((part.m, controls or 0)) if one is None else one for one, part in zip(rows, parts)])}


def _delay(number: int, given: Mapping[str, Any], made: Mapping[str, Any]) -> float:
    delay = given.get("delay", 0)
    try:
        if isinstance(delay, bool) or not isinstance(delay, (int, float)) or not 0 <= delay < np.inf:
            raise ModelError("delay", "is a number, 0 or more: seconds, or rows of a model of steps")
        if "dt" not in made and delay != int(delay):
            raise ModelError("delay", f"is in rows, as the model is of steps: {delay} is no whole number of them; or give F, Qc and dt")
        measured = given.get("measured")
        if measured is not None and (not isinstance(measured, str) or not measured or "dt" not in made or not delay):
            raise ModelError("measured", "is the name of a column of times, beside `delay`, the most that they are before the row's, of a "
                             "model with F, Qc and dt")
    except ModelError as problem:
        raise SensorError(number, problem) from None
    return float(delay)


def _sensor(number: int, given: Mapping[str, Any], states: int) -> tuple[str, Model]:
    """Its name, and a model that has its H, R and measurements"""
    try:
        for key in ("name", "H", "R"):
            if key not in given:
                raise ModelError(key, "is missing from [[sensors]]")
        name = _typed(given["name"], str, "name", "a text")
        H, R = (_array(key, given[key]) for key in ("H", "R"))
        _require_side("H", H, 1, states)
        size = _height(H)
        default = [name] if size == 1 else [f"{name}{k + 1}" for k in range(size)]
        said = {"names" if key == "measurements" else key: given[key] for key in ("measurements", "units", "ranges", "fractions", *READ)
                if key in given}
        return name, Model(np.eye(states), H=H, R=R, Q=np.zeros(states), P0=np.ones(states), d=_array("d", given["d"]) if "d" in given else None,
                           measurements=quantities("measurements", said, size, default))
    except ModelError as problem:
        raise SensorError(number, problem) from None


def _needed(made: dict[str, Any]) -> tuple[str, ...]:
    """Keys that there have to be; dt and jitter become numbers"""
    if not made.keys() & {"F", "L", "Qc", "dt", "jitter"}:
        return "A", "H", "R"
    for key in ("A", "Q", "G"):
        if key in made:
            raise ModelError(key, "is of steps, F, L, Qc and dt are of continuous time: give the one or the others")
    for key, what in (("dt", "the time of a row"), ("jitter", "a share of dt")):
        if key in made:
            if made[key].ndim:
                raise ModelError(key, f"is a number: {what}")
            made[key] = float(made[key])
    return "F", "Qc", "dt", "H", "R"


def _built(model: dict[str, Any]) -> dict[str, Any]:
    builder = _typed(model.pop("builder"), str, "builder", "a text")
    own = [one.name for one in builders.BUILDERS[builder].parameters] if builder in builders.BUILDERS else []
    replaced = {key: model.pop(key) for key in ("x0", "P0", "c", "d") if key in model and key not in own}
    made = builders.build(builder, model, has_prior="P0" in replaced)
    made.update({key: _array(key, value) for key, value in replaced.items() if key != "P0"})
    if "P0" in replaced:
        made.update(_prior(replaced["P0"]))
    return made


def _prior(given: Any) -> dict[str, Any]:
    """P0, and the states of which nothing is known"""
    if given == "unknown":
        return {"P0": None}
    if isinstance(given, list) and any(isinstance(one, str) for one in given):
        unknown = [i for i, one in enumerate(given) if one == "unknown"]
        if any(isinstance(one, str) and one != "unknown" for one in given):
            raise ModelError("P0", 'a state\'s variance is a number or "unknown"')
        known = [0.0 if isinstance(one, str) else one for one in given]
        return {"P0": _array("P0", known), "unknown": unknown}
    return {"P0": _array("P0", given)}


def _array(key: str, given: Any) -> np.ndarray:
    if not is_numbers(given):
        raise ModelError(key, "is not an array of numbers" if key not in ("dt", "jitter") else "is not a number; time_unit has the unit of dt")
    try:
        array = np.array(given, np.float64)
    except OverflowError:
        raise ModelError(key, "has a number with too many digits") from None
    except (TypeError, ValueError):
        raise ModelError(key, "is not an array of numbers with rows of one length") from None
    if not np.all(np.isfinite(array)):
        raise not_finite(key, array)
    return array


def _height(H: np.ndarray) -> int:
    return len(H) if H.ndim == 2 else 1


def _width(B: np.ndarray) -> int:
    return B.shape[1] if B.ndim == 2 else 1


def _typed(given: Any, kind: type, key: str, expected: str) -> Any:
    if not isinstance(given, kind) or isinstance(given, bool):
        raise ModelError(key, f"is not {expected}")
    return given


def _gaps(given: Mapping[str, Any]) -> Gaps:
    for key, least in (("max_gap", 0), ("min_run", 1)):
        if key in given and _typed(given[key], int, "gaps", f"right: {key} is a whole number") < least:
            raise ModelError("gaps", f"{key} is at least {least}")
        if given.get(key, least) > ROWS_MAX:
            raise ModelError("gaps", f"{key} is at most {ROWS_MAX}")
    return Gaps(**given)


# ------------------------------------------------------------------------------ writing


def text_of(model: Model) -> str:
    """A model file that reads back to the same bits."""
    lines, parts = ["[model]", f"name = {_quoted(model.name)}"], _sensor_parts(model)
    texts = getattr(model, "cells", {})
    if model.builder and not (model.continuous and model.continuous.jitter):
        unit = {"time_unit": model.continuous.unit} if model.continuous and model.continuous.unit != "s" else {}
        lines += [f"{key} = {_value(value)}" for key, value in {**unit, **model.builder}.items()]
    else:
        for key, value in _matrices(model).items():
            if value is not None and not (parts and key in ("H", "R", "D", "d")):
                lines.append(f"{key} = {_numbers(value, texts.get(key)) if isinstance(value, np.ndarray) else _value(value)}")
        lines += [f"x0 = {_list(model.x0)}", f"P0 = {_prior_text(model)}"]
    columns_ = getattr(model, "columns", ())
    for which in ("states", "inputs") if parts else ("states", "measurements", "inputs"):
        own = getattr(model, which)
        lines += _section("controls" if which == "inputs" else which, own[: len(own) - len(columns_)] if which == "inputs" else own)
    lines += _section("columns", [one for one in columns_ if one.range is not None or one.unit or one.reading != AS_IT_IS])
    first = 0
    for (name, H, R, measured), sensor in zip(parts, model.sensors):
        own = slice(first, first := first + len(H))
        _, _, names, *more = _section("measurements", measured)
        lines += ["", "[[sensors]]", f"name = {_quoted(name)}", f"measurements{names[5:]}"]
        lines += [f"{key} = {_numbers(one, within(texts.get(key), own, key))}" for key, one in (
            ("H", H), ("R", R), ("D", None if model.D is None else model.D[own]), ("d", None if model.d is None else model.d[own])) if one is not None]
        lines += [f"delay = {sensor.delay!r}"] if sensor.delay else []
        lines += [f"measured = {_quoted(sensor.measured)}"] if sensor.measured else []
        lines += more
    if model.recording:
        lines += ["", "[recording]", *(f"{key} = {_value(value)}" for key, value in model.recording.items())]
    if model.gaps != Gaps():
        lines += ["", "[gaps]", f"max_gap = {model.gaps.max_gap}"]
        lines += [] if model.gaps.min_run is None else [f"min_run = {model.gaps.min_run}"]
    return "\n".join(lines) + "\n"


def _sensor_parts(model: Model) -> list[tuple[str, np.ndarray, np.ndarray, tuple[Quantity, ...]]]:
    """Name, H, R and measurements of each sensor; empty where there are none, or the noise of one is that of another, too"""
    ends = np.cumsum([0, *(len(one.measurements) for one in model.sensors)]).tolist()
    parts = [(one.name, model.H[a:b], model.R[a:b, a:b], model.measurements[a:b])
             for one, a, b in zip(model.sensors, ends, ends[1:])]
    return parts if parts and np.array_equal(block_diagonal([R for _, _, R, _ in parts]), model.R, equal_nan=True) else []


def _matrices(model: Model) -> dict[str, Any]:
    of = model.continuous
    if of is not None:
        pushes = of.B if of.B is None or model.c is None else of.B[:, :-1] if of.B.shape[1] > 1 else None
        return {"F": of.F, "Qc": of.Qc, "dt": of.dt, "time_unit": None if of.unit == "s" else of.unit, "jitter": of.jitter or None,
                "B": pushes, "c": None if model.c is None else of.B[:, -1], "H": model.H, "R": model.R, "D": model.D, "d": model.d}
    pushes = model.B if model.c is None else model.B[:, :-1] if model.l > 1 else None
    return {"A": model.A, "B": pushes, "c": model.c, "H": model.H, "D": model.D, "d": model.d,
            **{key: getattr(model, key) for key in ("G" if model.G is not None else "Q", "R")}}


def text_of_builder(builder: str, parameters: Mapping[str, Any], model: Model) -> str:
    """As text_of, of the builder and the parameters that `model` was made by."""
    is_unknown, other = bool(np.all(model.unknown)), model.changed()
    priors = [one.name for one in builders.BUILDERS[builder].parameters if is_unknown and one.is_prior]
    other.builder = {"builder": builder, **{name: value for name, value in parameters.items() if name not in priors},
                     **({"P0": "unknown"} if is_unknown else {})}
    return text_of(other)


def _prior_text(model: Model) -> str:
    if np.all(model.unknown):
        return '"unknown"'
    if np.any(model.unknown):
        if np.any(model.P0 - np.diag(np.diag(model.P0))):
            raise KalmanqError("P0: correlated and in part unknown, which a model file cannot say")
        cells = ['"unknown"' if unknown else repr(float(value))
                 for unknown, value in zip(model.unknown, np.diag(model.P0))]
        return f"[{', '.join(cells)}]"
    return _rows(model.P0)


def _section(which: str, quantities: tuple[Quantity, ...]) -> list[str]:
    if not quantities:
        return []
    lines = ["", f"[{which}]", f"names = [{', '.join(_quoted(one.name) for one in quantities)}]"]
    if any(one.unit for one in quantities):
        lines.append(f"units = [{', '.join(_quoted(one.unit) for one in quantities)}]")
    if all(one.range is not None for one in quantities):
        lines.append(f"ranges = [{', '.join(map(_range, quantities))}]")
    if all(one.fraction is not None for one in quantities):
        lines.append(f"fractions = [{', '.join(str(one.fraction) for one in quantities)}]")
    for key, name in zip(READ, ("column", "factor", "offset", "missing", "plausible")):
        values = [getattr(one.reading, name) for one in quantities]
        if any(value != getattr(AS_IT_IS, name) for value in values):
            lines.append(f"{key} = {_value([list(value or ()) if key in ('missing', 'plausible') else value for value in values])}")
    return lines


def _range(one: Quantity) -> str:
    return repr(list(one.ends) if one.ends else float(one.range or 0))


def _quoted(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return '"' + "".join(c if c.isprintable() else f"\\u{ord(c):04x}" for c in escaped) + '"'


def _value(given: Any) -> str:
    if isinstance(given, list):
        return f"[{', '.join(map(_value, given))}]"
    return _quoted(given) if isinstance(given, str) else str(given).lower() if isinstance(given, bool) else repr(given)


def _list(row: np.ndarray, cells: Optional[columns.Cells] = None, at: tuple[int, ...] = ()) -> str:
    """cells: expressions, by their places; at: of the row"""
    made = ((cells or {}).get((*at, k)) for k in range(len(row)))
    return "[" + ", ".join(_quoted(one.text) if one else repr(float(value)) for one, value in zip(made, row)) + "]"


def _numbers(array: np.ndarray, cells: Optional[columns.Cells] = None) -> str:
    return _rows(array, cells) if array.ndim == 2 else _list(array, cells)


def _rows(matrix: np.ndarray, cells: Optional[columns.Cells] = None) -> str:
    return "[" + ", ".join(_list(row, cells, (i,)) for i, row in enumerate(matrix)) + "]"
