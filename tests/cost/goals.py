"""Holds what the library promises to cost against the counter of tools/cost.py.

Prints each figure beside its goal; fails where one is missed.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools" / "cost"))

from cases import FIXED, RUNTIME, Choice, programs
from errors import CostError
from row import Row
from run_all import run_all


@dataclass(frozen=True)
class Goal:
    core: str
    arithmetic: str
    n: int
    sizes: str
    what: str
    most: float  # instructions, or times `of`
    of: str = ""

    @property
    def choice(self) -> Choice:
        what = (self.what, self.of) if self.of else (self.what,)
        return Choice(
            (self.core,), (self.arithmetic,), (self.sizes,), ("O2",), (self.n,), what
        )  # fmt: skip

    def value(self, rows: list[Row]) -> float:
        found = {row.what: row.instructions for row in rows if self.choice.takes_row(row)}
        return found[self.what] / (found[self.of] if self.of else 1)


GOALS = (
    Goal("m4f", "f32", 4, FIXED, "steady", 90),
    Goal("m3", "q31", 4, FIXED, "steady", 500),
    # a sample of 10 steps' lag, the step of the filter in it: the most of all phases of its work
    Goal("m3", "q31", 2, RUNTIME, "lag", 3, of="step"),
    Goal("m3", "q31", 2, RUNTIME, "lag_states", 3, of="step"),
)


def reached(goal: Goal, rows: list[Row]) -> bool:
    value = goal.value(rows)
    unit = f"times {goal.of}" if goal.of else "instructions"
    where = f"{goal.core} {goal.arithmetic} n {goal.n} {goal.sizes} {goal.what}"
    verdict = "" if value <= goal.most else "  MISSED"
    print(f"{where:32} {value:8.6g} {unit}, goal {goal.most}{verdict}")
    return value <= goal.most


def main() -> int:
    wanted = list(dict.fromkeys(each for goal in GOALS for each in programs(goal.choice)))
    rows = [row for measured in run_all(ROOT, wanted) for row in measured.rows]
    return 0 if all([reached(goal, rows) for goal in GOALS]) else 1


if __name__ == "__main__":
    try:
        sys.exit(main())
    except CostError as problem:
        sys.exit(f"goals: {problem}")
