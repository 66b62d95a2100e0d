"""What a compiled filter costs on cores, as it was measured there (firmware/measured.py); nothing is estimated."""

from __future__ import annotations

import textwrap
from dataclasses import dataclass
from typing import Any, Mapping, Optional, Sequence

from kalmanq.compiler.report.described import described
from kalmanq.compiler.text.product import Product
from kalmanq.firmware import measured
from kalmanq.firmware.cores import BY_NAME

USUAL = ("m0", "m3", "m4f", "rv32")
UNKNOWN, NEVER = "-", "never"
COLUMNS = {"two_calls": "two calls", "two_calls_settled": "settled", "step_settled": "settled step"}
WIDTH = 112


@dataclass(frozen=True)
class Cost:
    """of: by measure (measured.measured), None of what never happens; why_not: there is none of it"""

    of: Mapping[str, Optional[int]]
    why_not: str = ""

    def cell(self, measure: str) -> str:
        value = self.of.get(measure)
        return str(value) if value is not None else NEVER if measure in self.of else UNKNOWN


def costs_of(product: Product, cores: Sequence[str] = USUAL, test: str = "") -> dict[str, Cost]:
    """By core.  test: of a nonlinear model NAME_test.c, whose rows it takes"""
    what, texts = described(product), {**product.sources(), **({f"{product.given.name}_test.c": test} if test else {})}
    return {core: Cost(*measured.told(core, what, texts)) for core in cores}


def told(product: Product, test: str = "") -> dict[str, Any]:
    """For machines"""
    made = costs_of(product, test=test)
    return {"costs": {f"{core} O2": one.of for core, one in made.items() if one.of},
            "not_measured": {core: one.why_not for core, one in made.items() if one.why_not}}


def lines(product: Product, test: str = "") -> list[str]:
    """For the report"""
    made = costs_of(product, test=test)
    found = {core: one for core, one in made.items() if one.of}
    return [*(_table(found, product.cycle is not None) if found else []), *(line for one in reasons(made) for line in _wrapped(one))]


def reasons(made: Mapping[str, Cost]) -> list[str]:
    """Why there are no figures, a sentence for each reason"""
    return [f"Costs on {', '.join(core for core, one in made.items() if one.why_not == why)}: {UNKNOWN}. {why}."
            for why in dict.fromkeys(one.why_not for one in made.values() if one.why_not)]


def built(cores: Sequence[str]) -> str:
    """By which compilers, with which flags"""
    compilers = dict.fromkeys(measured.compiler(BY_NAME[core]) for core in cores)
    flags = dict.fromkeys(" ".join(measured.flags(BY_NAME[core])) for core in cores)
    by = (f"{one} ({', '.join(core for core in cores if ' '.join(measured.flags(BY_NAME[core])) == one)})" if len(flags) > 1 else one for one in flags)
    return f"{' and '.join(compilers)}, {'; '.join(by)}"


def _table(found: Mapping[str, Cost], has_cycle: bool) -> list[str]:
    measures = [one for one in next(iter(found.values())).of if one not in ("step", "program")]
    measures = [one for one in measures if not (has_cycle and one.endswith("_settled"))]  # of a cycle that was not measured
    rows = [["core", *(COLUMNS.get(one, one) for one in measures)], *([core, *(one.cell(of) for of in measures)] for core, one in found.items())]
    widths = [max(map(len, column)) for column in zip(*rows)]
    told = "Instructions and bytes, counted on emulated cores" + ("; a row in two calls before the gain is constant and after, a step then"
                                                                  if "two_calls_settled" in measures else "")
    return [*_wrapped(f"{told}:"), *(f"    {'  '.join(map(str.ljust, row, widths)).rstrip()}" for row in rows), *_wrapped(f"By {built([*found])}.")]


def _wrapped(text: str) -> list[str]:
    return textwrap.wrap(text, WIDTH, initial_indent="  ", subsequent_indent="  ", break_on_hyphens=False, break_long_words=False)
