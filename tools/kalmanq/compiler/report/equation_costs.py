"""What a call of a nonlinear model's C costs on a core: a sum over the operations of its text, with factors that were measured.

equation_costs.csv has a row for each core: the factors of KINDS, which tools/cost/equation_fit.py fits to filters in f32 on
emulated cores, and how far off a sum was (a share): of others in the root mean square (`rms`), and of all at most (`off`).  What
a function of the compiler's library takes depends on its argument; the factor is of those that the filters met.
"""

from __future__ import annotations

import re
from collections import Counter
from functools import lru_cache
from typing import Any, Mapping, Optional

from kalmanq.compiler.given.request import Options
from kalmanq.compiler.text.product import Product
from kalmanq.firmware.costs import table

OPERATORS = {"sums": r" [+-] ", "products": r" \* ", "divisions": r" / ", "selects": r" \? ", "branches": r"^\s*if \(",
             "comparisons": r" [<>]=? ", "loads": r"^\s*(?:const )?float \w+ = (?:f->|z\[)", "stores": r"^\s*f->.* = ",
             "values": r"^\s*const float \w+ = "}
LIBRARY = {"roots": "sqrtf", "sines": "sinf|cosf", "tangents": "tanf", "arcs": "atanf|asinf|acosf", "angles": "atan2f",
           "exponentials": "expf|expm1f", "logarithms": "logf|log1pf", "hyperbolic": "tanhf|sinhf|coshf", "powers": "powf|cbrtf",
           "others": "fmodf|floorf|ceilf|roundf|hypotf|copysignf|remainderf"}
KINDS = ("calls", *OPERATORS, *LIBRARY, "waits")
HELD = 24  # values that registers hold
FUNCTION = re.compile(r"^(?:static )?(?:inline )?\w+ (\w+)\([^\n]*\)\n\{\n(.*?)^\}", re.S | re.M)
NAME = re.compile(r"\b[a-z_]\w*\b")


def calls_of(text: str, name: str) -> dict[str, dict[str, int]]:
    """Of the C of a filter, by predict and update: what it and the functions of the file that it calls are made of"""
    bodies = dict(FUNCTION.findall(text))
    return {called.removeprefix(f"{name}_"): table_of(counted(called, bodies)) for called in bodies
            if re.fullmatch(rf"{name}_(?:predict|update(?!\w*_some$)\w*)", called)}


def counted(called: str, bodies: Mapping[str, str]) -> Counter[str]:
    body = bodies[called]
    made = Counter({kind: len(re.findall(of, body, re.M)) for kind, of in OPERATORS.items()})
    made.update({kind: len(re.findall(rf"\b(?:{of})\(", body)) for kind, of in LIBRARY.items()})
    made.update(calls=1, waits=waits(body))
    inner = [one for one in NAME.findall(body) if one in bodies and one != called]
    return sum((counted(one, bodies) for one in inner), made)


def waits(body: str) -> int:
    """Values that are read again when many others have been made meanwhile: they come from memory"""
    last: dict[str, int] = {}
    found = 0
    for at, line in enumerate(body.splitlines()):
        for one in set(NAME.findall(line)):
            found += at - last.get(one, at) > HELD
            last[one] = at
    return found


def table_of(made: Counter[str]) -> dict[str, int]:
    return {kind: made[kind] for kind in KINDS}


@lru_cache(maxsize=None)
def factors() -> dict[str, dict[str, float]]:
    """By core; `off` among them"""
    rows = table("equation_costs.csv", __package__)
    return {row.pop("core"): {kind: float(one) for kind, one in row.items() if one} for row in rows}


def estimates(product: Product) -> Optional[dict[str, dict[str, Any]]]:
    """By core: instructions of each call, and how far off such sums were, shares.  Of f32 without options alone, since
    nothing else was measured"""
    given = product.given
    if given.options != Options("f32"):
        return None
    made = calls_of(product.code, given.name)
    return {core: {**{call: round(sum(factor.get(kind, 0) * one for kind, one in of.items())) for call, of in made.items()},
                   "rms": factor["rms"], "off": factor["off"]} for core, factor in factors().items()}


def told(product: Product) -> list[tuple[str, dict[str, Any]]]:
    """For the report"""
    return [(core, {"calls": ", ".join(f"{call} {count}" for call, count in of.items() if call not in ("rms", "off")), **of})
            for core, of in (estimates(product) or {}).items()]
