"""Names in C: of states, measurements and controls, as identifiers, cut, none twice; of files and functions."""

from __future__ import annotations

import re
from typing import Sequence

from kalmanq.model import Quantity

LONGEST = 20
WORDS = frozenset("""auto break case char const continue default do double else enum extern float for goto if inline int
    long register restrict return short signed sizeof static struct switch typedef union unsigned void volatile while
    bool class delete new template this namespace main kalmanq assert complex ctype errno fenv float inttypes iso646
    limits locale math setjmp signal stdalign stdarg stdatomic stdbool stddef stdint stdio stdlib stdnoreturn string
    tgmath threads time uchar wchar wctype""".split())


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


def identifier(text: str) -> str:
    """For files and functions: no word of C, no header of C or of the library, nothing that begins as its names do."""
    made = re.sub(r"\W+", "_", text, flags=re.ASCII).strip("_").lower() or "filter"
    return f"filter_{made}" if made[0].isdigit() or made in WORDS or made.startswith("kq") else made


def plain(text: str) -> str:
    """For a comment: what would end it, or be read as something else, is taken apart."""
    printable = "".join(c if c.isprintable() else " " for c in text)
    return re.sub(r"([*?/])(?=[/*?])", r"\1 ", printable)
