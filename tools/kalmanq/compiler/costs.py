"""What a compiled filter costs on a core: sums over the operations of its C, with factors that were measured.

costs.csv has a row for each core, arithmetic, level and measure: the factors of OPERATIONS, which
tools/cost/compiled_fit.py fits to filters on emulated cores.
"""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass
from functools import lru_cache
from importlib import resources
from typing import Mapping

from kalmanq.compiler.plan import Plan
from kalmanq.compiler.text import code

LEVELS = ("O2", "Os")
MEASURES = ("two_calls", "step_settled", "flash")
OPERATIONS = {
    "calls": r"(?!)", "loads": r"= f->", "stores": r"^ *f->\w+ = ", "products": r"(?<!u) \* |\bproduct\(",
    "wide": r"\bwide\(",
    "sums": r" [+-] |\bwithin\(f", "shifts": r">>", "divisions": r"1\.0f / |\binverse\(", "roots": r"sqrtf\(",
    "constants": r"\b\d+\.\d+(?:e-?\d+)?f|\b\d{4,}\b",
}
SETTLED = re.compile(r"/\* settled \*/ \{\n(.*?)\n        return;\n    \}", re.S)


@dataclass(frozen=True)
class Cost:
    """Instructions of a row in two calls before it has settled, of one step after; bytes of the file"""

    two_calls: int
    step_settled: int
    flash: int


def operations(plan: Plan) -> dict[str, dict[str, int]]:
    """Of each measure: how many of which"""
    text = code(plan)
    functions = dict(re.findall(r"^void \w+?_(start|predict|update|step)\([^\n]*\n\{\n(.*?)^\}", text.replace(
        f"{plan.name}_", "x_"), re.S | re.M))
    update = SETTLED.sub("", functions["update"])
    return {"two_calls": _count(functions["predict"] + update), "step_settled": _count(functions["step"]),
            "flash": _count(text)}


def _count(text: str) -> dict[str, int]:
    made = {name: len(re.findall(pattern, text, re.M)) for name, pattern in OPERATIONS.items()}
    return {**made, "calls": 1}


@lru_cache(maxsize=None)
def factors() -> Mapping[tuple[str, str, str, str], dict[str, float]]:
    """By core, arithmetic, level and measure"""
    text = resources.files("kalmanq.compiler").joinpath("costs.csv").read_text(encoding="utf-8")
    rows = csv.DictReader(line for line in text.splitlines() if not line.startswith("#"))
    keys = ("core", "arithmetic", "level", "measure")
    return {tuple(row[key] for key in keys): {name: float(row[name]) for name in OPERATIONS}  # type: ignore[misc]
            for row in rows}


def estimate(plan: Plan, core: str, level: str) -> Cost:
    arithmetic, counted = "q31" if plan.subject.words.is_fixed else "f32", operations(plan)
    made = {}
    for measure in MEASURES:
        factor = factors()[core, arithmetic, level, measure]
        made[measure] = round(sum(factor[name] * count for name, count in counted[measure].items()))
    return Cost(**made)


def is_measured(core: str, arithmetic: str) -> bool:
    return (core, arithmetic, "O2", "flash") in factors()


def cores(plan: Plan) -> list[str]:
    """Those that were measured in this arithmetic"""
    arithmetic = "q31" if plan.subject.words.is_fixed else "f32"
    return list(dict.fromkeys(core for core, of, _, _ in factors() if of == arithmetic))
