"""Measurements that are angles: how large a turn is in their units, and what is within half of one."""

from __future__ import annotations

import math
from typing import Iterable, Mapping, Optional, Sequence, Union

import numpy as np

from kalmanq.errors import ModelError
from kalmanq.model import Quantity

_SIZES = {  # of a turn, by the unit's names
    2 * math.pi: "rad rads radian radians", 360.0: "deg degs degree degrees °", 400.0: "grad grads gon gons gradian gradians",
    1.0: "turn turns rev revs revolution revolutions cycle cycles", 21600.0: "arcmin arcmins arcminute arcminutes ′",
    1296000.0: "arcsec arcsecs arcsecond arcseconds ″"}
_TURNS = {name: size for size, names in _SIZES.items() for name in names.split()}
_PARTS = {"m": 1e3, "milli": 1e3, "u": 1e6, "µ": 1e6, "μ": 1e6, "micro": 1e6, "n": 1e9, "nano": 1e9}  # both letters that look like mu


def turn_of(unit: str) -> Optional[float]:
    """In this unit; None: it is no unit of an angle"""
    name = unit.strip().lower()
    parts = (prefix for prefix in _PARTS if name.removeprefix(prefix) in _TURNS)
    return _TURNS.get(name) or next((_PARTS[prefix] * _TURNS[name.removeprefix(prefix)] for prefix in parts), None)


def turns_of(angles: Union[int, str, Iterable[Union[int, str]]], measurements: Sequence[Quantity]) -> dict[int, float]:
    """The turn of each measurement that is an angle, by its number; angles: numbers or names.  Without a unit it is in rad"""
    names, made = [one.name for one in measurements], {}
    for which in [angles] if isinstance(angles, (str, int)) else angles:
        is_number = isinstance(which, (int, np.integer)) and not isinstance(which, bool) and 0 <= which < len(names)
        if not is_number and which not in names:
            raise ModelError("angles", f"there is no measurement {which!r}")
        c = int(which) if is_number else names.index(which)
        turn = turn_of(measurements[c].unit or "rad")
        if turn is None:
            raise ModelError("angles", f"{names[c]} is in {measurements[c].unit}, of which no turn is known: give its unit as rad, deg, grad, turn, "
                             "arcmin or arcsec (mdeg, mrad, ... too), or wrap it in innovation(z, x)")
        made[c] = turn
    return made


def wrapped(values: np.ndarray, turns: Mapping[int, float]) -> np.ndarray:
    """Columns that are angles within half a turn"""
    made = values.copy()
    for c, turn in turns.items():
        made[..., c] -= turn * np.round(made[..., c] / turn)
    return made
