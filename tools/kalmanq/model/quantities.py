"""What a model file says of states, measurements and controls, and of the data files that have them."""

from __future__ import annotations

import sys
from typing import Any, Mapping, Optional

from kalmanq.errors import ModelError, counted
from kalmanq.model.model import Quantity, Reading

FRACTION_MAX = 1000
LARGEST, SHOWN = sys.float_info.max, 40
READ = ("columns", "factors", "offsets", "missing", "plausible")  # how data files say a quantity
RECORDING = {"time": (str, "a text"), "time_format": (str, "a text"), "separator": (str, "a text"), "decimal": (str, "a text"),
             "sort": (bool, "true or false"), "skip_untimed": (bool, "true or false"), "pause": ((int, float), "a number of seconds"),
             "database": (str, "a text"), "origin": (list, "[latitude, longitude] or [latitude, longitude, height]")}


def quantities(which: str, given: Mapping[str, Any], size: int, default: Optional[list[str]]) -> list[Quantity]:
    letter = {"states": "x", "measurements": "z", "controls": "u", "columns": "c"}[which]
    names = default or [f"{letter}{k + 1}" for k in range(size)]
    columns: dict[str, list[Any]] = {"names": names, "units": [""] * size, "ranges": [None] * size, "fractions": [None] * size,
                                     "columns": [""] * size, "factors": [1.0] * size, "offsets": [0.0] * size, "missing": [[]] * size,
                                     "plausible": [[]] * size}
    kinds: dict[str, tuple[Any, str]] = {"names": (str, "texts"), "units": (str, "texts"), "columns": (str, "texts"),
                                         "ranges": ((int, float, list), "numbers"), "fractions": (int, "whole numbers"),
                                         "factors": ((int, float), "numbers"), "offsets": ((int, float), "numbers"),
                                         "missing": (list, "lists: [[-127, 9999], []]"), "plausible": (list, "pairs: [[-40, 85], []]")}
    for key, values in given.items():
        kind, expected = kinds[key]
        if not isinstance(values, list) or any(not isinstance(one, kind) or isinstance(one, bool) for one in values):
            raise ModelError(which, f"{key} is not a list of {expected}")
        if len(values) != size:
            raise ModelError(which, f"{key} has {counted(len(values), key[:-1])}; there {'is' if size == 1 else 'are'} {counted(size, which[:-1])}")
        columns[key] = values
    for one in columns["ranges"]:
        _look_at_range(which, one)
    for one in columns["fractions"]:
        if one is not None and abs(one) > FRACTION_MAX:
            raise ModelError(which, f"fractions: {str(one)[:SHOWN]} is beyond {FRACTION_MAX} bits")
    return [Quantity(name, unit, span if span is None or isinstance(span, list) else float(span), fraction, reading=_reading(which, *read))
            for name, unit, span, fraction, *read in zip(*columns.values())]


def _reading(which: str, column: str, factor: float, offset: float, missing: list[Any], plausible: list[Any]) -> Reading:
    if not (0 < abs(factor) <= LARGEST and abs(offset) <= LARGEST):
        raise ModelError(which, f"factors, offsets: {factor:g} and {offset:g} are not a factor other than 0, and a number")
    if any(isinstance(one, bool) or not isinstance(one, (int, float, str)) for one in missing):
        raise ModelError(which, "missing: a cell is a number or a text")
    if plausible:
        _look_at_range(which, plausible, "plausible")
    return Reading(column, float(factor), float(offset), tuple(missing), (float(plausible[0]), float(plausible[1])) if plausible else None)


def recording(given: Mapping[str, Any]) -> Mapping[str, Any]:
    """What a model file says of the data files"""
    for key, value in given.items():
        kind, expected = RECORDING[key]
        if not isinstance(value, kind) or isinstance(value, bool) != (kind is bool):
            raise ModelError("recording", f"{key} is not {expected}")
    if given.get("pause", 1) <= 0 or given.get("decimal", ".") not in (".", ",") or given.get("separator", ",") not in (",", ";", "tab", " ", "|"):
        raise ModelError("recording", "pause is above 0, decimal is '.' or ',', separator one of ',', ';', '|', ' ', 'tab'")
    if not is_numbers(place := given.get("origin", [0, 0])) or len(place) not in (2, 3) or abs(place[0]) > 90 or abs(place[1]) > 360:
        raise ModelError("recording", "origin is [latitude, longitude] or [latitude, longitude, height], in degrees and m")
    return dict(given)


def _look_at_range(which: str, one: Any, key: str = "ranges") -> None:
    """The largest |value|, or the least and the largest value"""
    if isinstance(one, list):
        if len(one) != 2 or any(not isinstance(end, (int, float)) or isinstance(end, bool) for end in one) \
                or not -LARGEST <= one[0] < one[1] <= LARGEST:
            raise ModelError(which, f"{key}: {str(one)[:SHOWN]} is not a least and a larger number")
    elif one is not None and not 0 < one <= LARGEST:
        raise ModelError(which, f"ranges: {str(one)[:SHOWN]} is not above 0" if not one > LARGEST else
                         "ranges: one is not representable")


def is_numbers(given: Any) -> bool:
    """A text that reads as a number is none, nor is true."""
    if isinstance(given, list):
        return all(map(is_numbers, given))
    return isinstance(given, (int, float)) and not isinstance(given, bool)
