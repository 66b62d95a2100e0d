"""What a compiled filter costs on a core: sums over the operations of its C, with factors that were measured.

costs.csv has a row for each core, arithmetic, level and measure: the factors of operations.KINDS, which
tools/cost/compiled_fit.py fits to filters on emulated cores, and how far off the sums were at most (`off`, a share), for
those and for others.  A measure that has no row there is not estimated.  The stack's sum is not less than any that was
measured.
"""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass
from typing import Mapping, Optional

from kalmanq.compiler.algorithm.fixed.loops import LoopedWords
from kalmanq.compiler.algorithm.fixed.rescaled import RescaledWords
from kalmanq.compiler.algorithm.loops import LoopedFilter
from kalmanq.compiler.given.request import Options
from kalmanq.compiler.report.operations import counted, factors, sums, table_of
from kalmanq.compiler.text.product import Product

ARITHMETICS = ("f32", "q31")  # that are estimated
MEASURES = ("two_calls", "two_calls_settled", "step_settled", "flash", "stack")
SOFT_FLOAT = {"m0": 3500, "m3": 1448, "rv32": 3404}  # bytes of the compiler's functions for float, which flash is without
NOT_ESTIMATED, NEVER = "not estimated", "never"
FUNCTION = re.compile(r"^(?:static )?(?:inline )?\w+ (\w+)\([^\n]*\)\n\{\n(.*?)^\}", re.S | re.M)
SETTLED = re.compile(r"^    if \((.*\bSETTLED\b.*)\) \{\n(.*?)^    \}\n", re.S | re.M)
TABLE = re.compile(r"^ *static const (\w+) \w+((?:\[\d+\])+) =", re.M)
LOOPS = ("covariance", "start_at")  # of the same length in each filter
ROUTINES = (("product", "product"), ("wide", "wide"), ("inverse", "inverse_root"))
BYTES = {"uint8_t": 1, "uint16_t": 2, "int32_t": 4, "uint32_t": 4, "float": 4, "double": 8}


@dataclass(frozen=True)
class Cost:
    """Instructions of a row in two calls before it has settled and after, of one step after; bytes of the file, and of the
    stack at most; None: not estimated.  off: how far off an estimate of each was at most, a share"""

    two_calls: Optional[int]
    two_calls_settled: Optional[int]
    step_settled: Optional[int]
    flash: Optional[int]
    stack: Optional[int]
    off: Mapping[str, float]
    settles: bool = True

    def cell(self, measure: str) -> str:
        if not self.settles and measure.endswith("_settled"):
            return NEVER
        value = getattr(self, measure)
        off = self.off.get(measure)
        return NOT_ESTIMATED if value is None else f"{value} ±{100 * off:.0f} %" if off else str(value)


# ------------------------------------------------------------------------------ operations


def operations_of(product: Product) -> dict[str, dict[str, int]]:
    """By measure; what never happens is left out; nothing of loops, nor of words with a scale, of which none was measured"""
    if isinstance(product.arithmetic, (LoopedFilter, LoopedWords, RescaledWords)):
        return {}
    return operations(product.code, product.given.name, product.given.options.arithmetic == "q31")


def operations(text: str, name: str, is_fixed: bool) -> dict[str, dict[str, int]]:
    functions = {called.removeprefix(f"{name}_"): body for called, body in FUNCTION.findall(text)
                 if called == "take" or called.startswith(f"{name}_") and called.removeprefix(f"{name}_") not in LOOPS}
    settled = {called: found for called, found in ((one, _settled(body)) for one, body in functions.items()) if found}
    bodies = {called: SETTLED.sub("", body) if called in settled else body for called, body in functions.items()}
    of = {called: counted(body, is_fixed) for called, body in bodies.items()}
    apart = {called: _counted_apart(*found, is_fixed) for called, found in settled.items()}
    unsettled = of["predict"] + of["update"] + of["take"]
    whole = sum(apart.values(), sum(of.values(), Counter()))
    whole.update(functions=len(functions), tables=_bytes_of_tables(text) // 4)
    whole.update({f"has_{kind}": bool(re.search(rf"\b{called}\(", text)) for kind, called in ROUTINES})
    made = {"two_calls": unsettled, "flash": whole, "stack": unsettled + Counter()}
    if "step" in settled:
        mean = functions["predict"].split("    if (f->calls == SETTLED)")[0]
        made["two_calls_settled"] = counted(mean, is_fixed) + apart["update"]
        made["two_calls_settled"]["doors"] = of["update"]["doors"]
        made["step_settled"] = apart["step"]
    for one in made.values():
        one["settles"] = int("step" in settled)
        one["components"] = len(re.findall(r"^    if \(taken & \d+u\)", bodies["take"], re.M))
    return {measure: table_of(one) for measure, one in made.items()}


def _settled(body: str) -> Optional[tuple[str, str]]:
    """The condition and the lines of a full sample, once settled"""
    return next((one for one in SETTLED.findall(body) if re.search(r"return \d+u;", one[1])), None)


def _counted_apart(condition: str, body: str, is_fixed: bool) -> Counter[str]:
    return counted(f"if ({condition})\n{body}", is_fixed)


def _bytes_of_tables(text: str) -> int:
    total = 0
    for type_, sizes in TABLE.findall(text):
        size = BYTES[type_]
        for one in re.findall(r"\d+", sizes):
            size *= int(one)
        total += size
    return total


# ------------------------------------------------------------------------------ their sums


def estimates(product: Product) -> dict[str, Cost]:
    """On the cores that were measured in its arithmetic, at -O2; of no filter with options, since none was measured"""
    options = product.given.options
    if options != Options(options.arithmetic, options.settle):
        return {}
    made, arithmetic = operations_of(product), options.arithmetic
    cores = dict.fromkeys(core for core, of, _, _ in factors() if of == arithmetic)
    return {core: Cost(**sums(core, arithmetic, MEASURES, made), settles="step_settled" in made)
            for core in cores} if made else {}
