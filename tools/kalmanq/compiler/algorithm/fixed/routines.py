"""The functions that the C of q31 calls, in the file that needs them: products, rounding, roots and inverses."""

from __future__ import annotations

import math
import re
from functools import lru_cache
from typing import Mapping

from kalmanq.compiler.templates.engine import rendered

DEFINED = re.compile(r"^(?:__attribute__\S+ )?static [^=;{]*?(\w+)\(", re.M)


def line() -> list[str]:
    """Of 96 parts of [1/4, 1]: 1 / sqrt at the part's begin and its fall within the part, the least error on both
    sides.  Square roots are exact everywhere."""
    made = []
    for k in range(96):
        low, high = (k + 32) / 128, (k + 33) / 128
        a, b = 1 / math.sqrt(low), 1 / math.sqrt(high)
        where = ((a - b) * 256)**(-2 / 3)  # where the curve is as steep as the chord
        sag = (a - (a - b) * (where - low) * 128 - 1 / math.sqrt(where)) / 2
        made.append(f"{min(round((a - sag) * 2**15), 65535) << 16 | round((a - b) * 2**20):#010x}u")
    return [", ".join(made[k:k + 8]) + ("," if k < 88 else "") for k in range(0, 96, 8)]


def called(text: str, routines: Mapping[str, str]) -> str:
    """Those that a text calls, and those that they call; routines: by name, none before what it calls"""
    made = ""
    for name, routine in reversed(routines.items()):
        if re.search(rf"\b{name}\(", text + made):
            made = f"{routine}\n{made}"
    return made


def parted(text: str) -> dict[str, str]:
    """Routines by name, with what is before each: an empty line ends one"""
    made, before = {}, ""
    for part in text.rstrip("\n").split("\n\n"):
        before += f"{part}\n"
        if names := DEFINED.findall(part):
            made[names[-1]], before = before, ""
        else:
            before += "\n"
    return made


@lru_cache(maxsize=None)
def _all() -> dict[str, str]:
    return parted(rendered("words.c.j2", {"line": line()}))


def routines(text: str) -> str:
    return called(text, _all())
