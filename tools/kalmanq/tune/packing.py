"""How the content of a page is written: arrays of doubles, quantities and noises."""

from __future__ import annotations

import base64
from typing import Any, Optional, Sequence

import numpy as np

from kalmanq.model.model import Quantity
from kalmanq.tune.noises import MATRICES, Noise


def packed(array: Optional[np.ndarray]) -> Optional[str]:
    return None if array is None else base64.b64encode(np.ascontiguousarray(array, "<f8").tobytes()).decode()


def quantities(given: Sequence[Quantity]) -> list[dict[str, Any]]:
    return [{"name": one.name, "unit": one.unit, "range": one.range, "fraction": one.fraction} for one in given]


def noise_content(one: Noise) -> dict[str, Any]:
    parts = {name: packed(one.parts.get(name)) for name in MATRICES}
    return {"key": one.key, "value": one.value, "kind": one.kind, "unit": one.unit, "hint": one.hint, "power": one.power,
            "columns": one.columns, "fit": one.fit, **parts}
