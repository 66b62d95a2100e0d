"""Parameters and single entries of them by name, as a command line has them: "Q,R,A[0,0],A[1,*]"."""

from __future__ import annotations

import re
from typing import Optional, Sequence, Union

import numpy as np

from kalmanq.errors import KalmanqError
from kalmanq.model import Model
from kalmanq.model.builders import searched
from kalmanq.nonlinear import NonlinearModel

WORD = re.compile(r"\s*([A-Za-z]\w*)\s*(?:\[([^\]]*)\])?\s*(,|$)")
OF_ENTRIES = ("A", "H", "Q", "R")
ARRAYS = (*OF_ENTRIES, "x0", "P0")


def free_and_held(free: str, hold: str, model: Union[Model, NonlinearModel]) -> tuple[list[str], dict[str, np.ndarray]]:
    """Names of what is free, and masks of what of it is held.  An entry in `free` frees it alone of its matrix."""
    names: list[str] = []
    held: dict[str, np.ndarray] = {}
    for name, entry in _words("--free", free):
        if entry is not None and entry.strip().isdigit() and name in searched(getattr(model, "builder", None)):
            names.append(f"{name}[{entry.strip()}]")
        elif entry is None:
            held.pop(name, None)
        elif name not in names or name in held:
            mask = held.setdefault(name, np.ones_like(_matrix("--free", name, model), bool))
            _set(mask, "--free", name, entry, False)
        names += [name] * (entry is None and name not in names or name in held and name not in names)
    for name, entry in _words("--hold", hold):
        if entry is None or name not in names:
            raise KalmanqError(f"--hold: {name} is not free" if name not in names else
                               f"--hold: name entries, such as {name}[0,0]; or leave {name} out of --free")
        mask = held.setdefault(name, np.zeros_like(_matrix("--hold", name, model), bool))
        _set(mask, "--hold", name, entry, True)
    return names, held


def label_of(name: str, at: Sequence[int]) -> str:
    """Q[0,1]; a constant is one number, and has its name"""
    return f"{name}[{','.join(map(str, at))}]" if name in (*ARRAYS, "Qc", "F") else name


def _words(option: str, given: str) -> list[tuple[str, Optional[str]]]:
    made, at = [], 0
    while at < len(given):
        found = WORD.match(given, at)
        if not found:
            raise KalmanqError(f"{option}: {given[at:].strip()!r} is not NAME or NAME[ROW,COLUMN]")
        made.append((found.group(1), found.group(2)))
        at = found.end()
    return made


def _matrix(option: str, name: str, model: Union[Model, NonlinearModel]) -> np.ndarray:
    of = getattr(model, "continuous", None)
    there = {one: getattr(model, one) for one in OF_ENTRIES if hasattr(model, one)} | ({"F": of.F, "Qc": of.Qc} if of else {})
    if name not in there:
        raise KalmanqError(f"{option}: there are entries of {', '.join(there)}, not of {name}")
    return there[name]


def _set(mask: np.ndarray, option: str, name: str, entry: str, value: bool) -> None:
    """Of [row,column], each a number from 0 or *; of a covariance both entries."""
    parts = [part.strip() for part in entry.split(",")]
    if len(parts) != 2 or not all(part == "*" or part.isdigit() for part in parts):
        raise KalmanqError(f"{option}: {name}[{entry}] is not {name}[ROW,COLUMN]; numbers from 0, or *")
    at = tuple(slice(None) if part == "*" else int(part) for part in parts)
    if any(isinstance(i, int) and i >= size for i, size in zip(at, mask.shape)):
        raise KalmanqError(f"{option}: {name}[{entry}] is not there: {name} is {mask.shape[0]} x {mask.shape[1]}")
    mask[at] = value
    if name in ("Q", "Qc", "R"):
        mask.T[at] = value
