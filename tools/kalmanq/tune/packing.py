"""How the content of a page is written: arrays of doubles, quantities and noises."""

from __future__ import annotations

import base64
from typing import Any, Iterable, Optional, Sequence

import numpy as np

from kalmanq.model.model import Quantity
from kalmanq.run.robust import LEVELS, LOSSES, Robust
from kalmanq.tune.noises import MATRICES, Noise


def packed(array: Optional[np.ndarray]) -> Optional[str]:
    return None if array is None else base64.b64encode(np.ascontiguousarray(array, "<f8").tobytes()).decode()


def quantities(given: Sequence[Quantity]) -> list[dict[str, Any]]:
    return [{"name": one.name, "unit": one.unit, "range": one.range, "fraction": one.fraction} for one in given]


def losses(names: Iterable[str], in_sigma: bool) -> dict[str, dict[str, Any]]:
    """in_sigma: so is a gate's parameter; otherwise it is one of its levels, which are kq_levels, too"""
    made: dict[str, dict[str, Any]] = {name: {"title": LOSSES[name].title, "note": LOSSES[name].note, "least": LOSSES[name].least,
                   "usual": LOSSES[name].shown if in_sigma else LOSSES[name].usual, "levels": None} for name in names}
    if not in_sigma:
        made["gate"]["levels"] = [[share, level, Robust("gate", share).sigmas] for share, level in LEVELS.items()]
    return made


def noise_content(one: Noise) -> dict[str, Any]:
    parts = {name: packed(one.parts.get(name)) for name in MATRICES}
    return {"key": one.key, "value": one.value, "kind": one.kind, "unit": one.unit, "hint": one.hint, "power": one.power,
            "columns": one.columns, "fit": one.fit, **parts}
