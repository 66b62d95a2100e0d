"""What states, measurements and controls are called in C: their names as identifiers, cut, none twice."""

from __future__ import annotations

import re
from typing import Sequence

from kalmanq.model import Quantity

LONGEST = 20


def identifiers(quantities: Sequence[Quantity]) -> list[str]:
    made: list[str] = []
    for one in quantities:
        name = re.sub(r"[^a-z0-9]+", "_", one.name.lower()).strip("_")[:LONGEST].strip("_") or "x"
        while name in made:
            name = f"{name[:LONGEST - 3]}_{len(made)}"
        made.append(name)
    return made if _pairs_differ(made) else [f"s{k}" for k in range(len(made))]


def named(states: Sequence[Quantity], measurements: Sequence[Quantity],
          controls: Sequence[Quantity]) -> tuple[list[str], list[str], list[str]]:
    """Of all three; states are s0, s1, ... where a fraction of fixed point would have the name of another one."""
    x, z, u = identifiers(states), identifiers(measurements), identifiers(controls)
    fractions = [*x, *(f"variance_{one}" for one in x), *(f"{letter}_{one}" for letter in "zs" for one in z),
                 *(f"u_{one}" for one in u), "nis"]
    return (x if len(set(fractions)) == len(fractions) else [f"s{k}" for k in range(len(x))]), z, u


def _pairs_differ(names: Sequence[str]) -> bool:
    """p_a_b_c may be of a and b_c, and of a_b and c; x_a_low of a state called a_low"""
    pairs = [f"{a}_{b}" for a in names for b in names]
    return len(set(pairs)) == len(pairs) and not {f"{name}_low" for name in names} & set(names)
