"""What a compiled filter costs on a core: sums over the operations of its C, with factors that were measured.

costs.csv has a row for each core, arithmetic, level and measure: the factors of operations.KINDS, which
tools/cost/compiled_fit.py fits to filters on emulated cores, and how far off the sums were at most (`off`, a share),
for those and for others.  A measure that has no row there is not estimated.
"""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass
from typing import Mapping, Optional

from kalmanq.compiler.operations import counted, factors, sums, table_of
from kalmanq.compiler.proven.plan import Plan
from kalmanq.compiler.proven.text import code

MEASURES = ("two_calls", "step_settled", "flash")
NOT_ESTIMATED = "not estimated"
FUNCTION = re.compile(r"^(?:NEVER_INLINE )?(?:static )?(?:void|unsigned) (\w+)\([^\n]*\)\n\{\n(.*?)^\}", re.S | re.M)
SETTLED = re.compile(r"^    if \(rows >= \d+\) \{ /\* settled \*/\n(.*?)\n    \}\n", re.S | re.M)
ROUTINES = ("product", "wide", "inverse")
INLINED = 10  # calls of wide(): of more, gcc -Os makes a function


@dataclass(frozen=True)
class Cost:
    """Instructions of a row in two calls before it has settled, of one step after; bytes of the file; None: not
    estimated.  off: how far off an estimate of each was at most, a share"""

    two_calls: Optional[int]
    step_settled: Optional[int]
    flash: Optional[int]
    off: Mapping[str, float]

    @property
    def cells(self) -> list[str]:
        return [f"{getattr(self, measure)} ±{100 * self.off[measure]:.0f} %" if measure in self.off else NOT_ESTIMATED
                for measure in MEASURES]


def operations_of(plan: Plan) -> dict[str, dict[str, int]]:
    return operations(code(plan), plan.name, plan.subject.words.is_fixed)


def operations(text: str, name: str, is_fixed: bool) -> dict[str, dict[str, int]]:
    """Of a row in two calls before it has settled, of a step after, of the whole file: how many of each kind"""
    functions = {called.removeprefix(f"{name}_"): body for called, body in FUNCTION.findall(text)}
    bodies = {called: SETTLED.sub("", body) for called, body in functions.items()}
    apart = [found.group(1) for found in map(SETTLED.search, functions.values()) if found]
    of = {called: counted(body, is_fixed) for called, body in bodies.items()}
    whole = sum((counted(body, is_fixed) for body in apart), sum(of.values(), Counter()))
    whole["functions"] = len(functions)
    whole["stays"] = len(re.findall(r"^    f->x_", functions["start"], re.M)) // (1 if is_fixed else 2)  # means, in a gap
    whole.update({f"has_{routine}": bool(re.search(rf"\b{routine}\(", text)) for routine in ROUTINES})
    made = {"two_calls": of.get("predict", Counter()) + of.get("update", Counter()),
            "step_settled": of["step"], "flash": whole}
    for one in made.values():
        one["called_wide"] = one["wide"] * (whole["wide"] > INLINED)
    return {measure: table_of(one) for measure, one in made.items()}


def estimates(plan: Plan) -> dict[tuple[str, str], Cost]:
    """On the cores that were measured in its arithmetic, by core and level; of no filter with options, since none was
    measured"""
    if plan.nis or plan.lag or plan.partial or not plan.carries_covariance:
        return {}
    counted, arithmetic = operations_of(plan), "q31" if plan.subject.words.is_fixed else "f32"
    places = dict.fromkeys((core, level) for core, of, level, _ in factors(__package__) if of == arithmetic)
    return {(core, level): Cost(**sums(__package__, core, arithmetic, level, MEASURES, counted)) for core, level in places}
