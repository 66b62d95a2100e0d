"""The text of a model file with other numbers: its comments, its builder, its layout and all else stay."""

from __future__ import annotations

import json
import re
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Iterator, Mapping

import numpy as np

from kalmanq.errors import KalmanqError
from kalmanq.model.model import Model
from kalmanq.model.model_file import read, rebuilt, text_of, tomllib

NUMBER = re.compile(r"#[^\n]*|[-+]?(?:\d[\d_]*(?:\.\d*)?(?:[eE][-+]?\d+)?|inf|nan)")
HEADER = re.compile(r"\s*(\[\[?)\s*([\w.-]+)\s*\]\]?\s*(#.*)?$")
ARRAYS = ("A", "Q", "H", "R", "x0", "P0")
SAME = 1e-12  # share of an array's largest entry, between what was fitted and what the text says


def fitted_text(path: Path, found: Model) -> str:
    """Of the file that `found` was fitted from; a file of its own where that one cannot say the numbers"""
    text, given = path.read_text(encoding="utf-8-sig"), read(path)
    table = tomllib.loads(text)
    if "name" not in table["model"]:  # that of the file
        text = re.sub(r"(?m)^(\s*\[\s*model\s*\].*\n)", lambda one: f"{one.group()}name = {json.dumps(given.name)}\n", text, count=1)
    places = dict(_places(text))
    for changes in (*(_of_builder(given, found, power) for power in (1, 2)), _of_arrays(given, found, table)):
        if changes.keys() <= places.keys() and not any(np.any(np.isnan(one)) for one in changes.values()):  # NaN: an expression
            made = _written(text, places, changes)
            if _is_same(made, found):
                return made
    return text_of(found)


def _is_same(text: str, found: Model) -> bool:
    with TemporaryDirectory() as folder:
        path = Path(folder) / "fitted.toml"
        path.write_text(text, encoding="utf-8")
        try:
            again = read(path)
        except KalmanqError:
            return False
    pairs = [(getattr(again, name), getattr(found, name)) for name in ARRAYS]
    if found.continuous:
        pairs += [(again.continuous.F, found.continuous.F), (again.continuous.Qc, found.continuous.Qc)]
    return all(np.all((np.abs(a - b) <= SAME * np.nanmax(np.abs(b), initial=0.0)) | np.isnan(a) & np.isnan(b)) for a, b in pairs)


def _places(text: str) -> Iterator[tuple[tuple[str, int, str], tuple[int, int]]]:
    """Of each value of a section: from behind the = to the end of its last line"""
    lines, section, counts, at, k = text.splitlines(keepends=True), "", {}, 0, 0
    while k < len(lines):
        header = HEADER.match(lines[k])
        assigned = None if header else re.match(r"\s*([A-Za-z_]\w*)\s*=", lines[k])
        if header:
            section = header.group(2)
            counts[section] = counts.get(section, -1) + 1
        count = 1
        while assigned and count < len(lines) - k and not _is_whole("".join(lines[k : k + count])):
            count += 1
        length = sum(map(len, lines[k : k + count]))
        if assigned:
            yield (section, counts.get(section, 0), assigned.group(1)), (at + assigned.end(), at + length)
        at, k = at + length, k + count


def _is_whole(text: str) -> bool:
    try:
        tomllib.loads(text)
        return True
    except tomllib.TOMLDecodeError:
        return False


def _written(text: str, places: Mapping[tuple[str, int, str], tuple[int, int]], changes: Mapping[tuple[str, int, str], np.ndarray]) -> str:
    for key, (begin, end) in sorted(places.items(), key=lambda one: -one[1][0]):
        if key in changes:
            text = text[:begin] + _value(text[begin:end], np.asarray(changes[key], float)) + text[end:]
    return text


def _value(old: str, array: np.ndarray) -> str:
    """Number for number where it has as many, or the diagonal; otherwise anew"""
    there = [one for one in NUMBER.finditer(old) if not one.group().startswith("#")]
    numbers = np.ravel(array)
    if array.ndim == 2 and len(there) == len(array) != array.size and not np.any(array - np.diag(np.diag(array))):
        numbers = np.diag(array)
    if len(there) != len(numbers):
        comment = re.search(r"[ \t]*(#[^\n]*)?\n?$", old)
        return f" {array.tolist()}{comment.group() if comment else ''}"
    for one, number in reversed(list(zip(there, numbers.tolist()))):
        is_kept = float(one.group().replace("_", "")) == number
        old = old if is_kept else old[: one.start()] + repr(number) + old[one.end() :]
    return old


# ------------------------------------------------------------------------------ which numbers


def _of_arrays(given: Model, found: Model, table: Mapping[str, Any]) -> dict[tuple[str, int, str], np.ndarray]:
    """Matrices that have changed, as the sections have them"""
    made: dict[tuple[str, int, str], np.ndarray] = {}
    pairs = {name: (getattr(given, name), getattr(found, name)) for name in ("A", "G", "Q", "H", "R", "x0", "P0")}
    if given.continuous and found.continuous:
        pairs.update({name: (getattr(given.continuous, name), getattr(found.continuous, name)) for name in ("F", "Qc")})
        del pairs["A"], pairs["G"], pairs["Q"]
    elif given.G is not None and found.G is not None:
        del pairs["Q"]
    for name, (old, new) in pairs.items():
        if old is None or new is None or np.array_equal(old, new, equal_nan=True):
            continue
        if name == "Qc" and "L" in table["model"]:
            inverse = np.linalg.pinv(np.atleast_2d(np.array(table["model"]["L"], float)))
            new = inverse @ new @ inverse.T
        if name in ("H", "R") and given.sensors:
            made.update(_of_sensors(given, name, old, new))
        else:
            made["model", 0, name] = new
    return made


def _of_sensors(given: Model, name: str, old: np.ndarray, new: np.ndarray) -> dict[tuple[str, int, str], np.ndarray]:
    ends = np.cumsum([0, *(len(one.measurements) for one in given.sensors)]).tolist()
    parts = {("sensors", k, name): (slice(a, b), slice(a, b) if name == "R" else slice(None)) for k, (a, b) in enumerate(zip(ends, ends[1:]))}
    return {key: new[at] for key, at in parts.items() if not np.array_equal(old[at], new[at], equal_nan=True)}


def _of_builder(given: Model, found: Model, power: int) -> dict[tuple[str, int, str], np.ndarray]:
    """Parameters that have changed: those that were free, or those of which the fitted Q and R are made"""
    builder = found.builder or _searched(given, found, power) if given.builder else {}
    return {("model", 0, name): np.array(value) for name, value in builder.items() if not isinstance(value, str) and value != given.builder.get(name)}


def _searched(given: Model, found: Model, power: int) -> dict[str, Any]:
    """Parameters of a builder on which Q and R, and nothing else, depend, each entry on one, by this power of it"""
    made: dict[str, Any] = {}
    for name, value in given.builder.items():
        if isinstance(value, (str, bool)) or np.ndim(value) > 1:
            continue
        values = np.atleast_1d(np.array(value, float))
        for k in np.flatnonzero(values):
            twice = values.copy()
            twice[k] *= 2
            values[k] = _solved(given, found, {name: _like(value, twice)}, float(values[k]), power)
        made[name] = _like(value, values)
    return made


def _like(value: Any, values: np.ndarray) -> Any:
    return values.tolist() if isinstance(value, list) else float(values[0])


def _solved(given: Model, found: Model, twice: dict[str, Any], value: float, power: int) -> float:
    """What the fitted Q and R say of a parameter, of which `twice` makes another model"""
    try:
        there = rebuilt(given, twice)
    except KalmanqError:
        return value
    if not all(np.array_equal(getattr(there, one), getattr(given, one)) for one in ("A", "H", "x0", "P0")):
        return value
    base, target, change = (np.concatenate([np.ravel(one.Q), np.ravel(one.R)]) for one in (given, found, there))
    change = change - base
    if not np.any(change):
        return value
    if value in change and power == 1:  # it is an entry
        return float(target[np.flatnonzero(change == value)[0]])
    at = int(np.argmax(np.abs(change)))
    return value * float(np.maximum(1 + (2**power - 1) * (target[at] - base[at]) / change[at], 0.0)) ** (1 / power)
