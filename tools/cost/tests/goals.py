"""Holds what the library promises to cost against the counter of tools/cost.py.

Prints each figure beside its goal; fails where one is missed.  Goals are of the compilers of tools/cost.csv, gcc 12 for Arm and RISC-V and
5 for AVR: with another one they are skipped, with a line.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Iterable

ROOT = Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT / "tools" / "cost"), str(ROOT / "tools")]

import table
from cases import FIXED, GCC, RUNTIME, SMALL, WHAT, Choice, Program, programs
from cores import BY_NAME, incomparable
from measure import measure_all
from errors import told_in_one_line
from table import Row


@dataclass(frozen=True)
class Goal:
    core: str
    arithmetic: str
    n: int
    sizes: str
    what: str
    most: float  # of the column; or times `of`, another function or another column
    column: str = "instructions"
    of: str = ""
    plus: str = ""  # and another function
    less: str = ""  # beside another program
    profile: str = GCC

    @property
    def choice(self) -> Choice:
        what = (self.what, self.of if self.of in WHAT else "", self.plus, self.less)
        names = ((self.core,), (self.arithmetic,), (self.sizes,), (self.profile,), (self.n,))
        return Choice(*names, tuple(filter(None, what)))

    def value(self, rows: list[Row]) -> float:
        found = {row.what: row for row in rows if self.choice.takes_row(row)}
        value = getattr(found[self.what], self.column)
        if self.plus:
            value += getattr(found[self.plus], self.column)
        if self.less:
            value -= getattr(found[self.less], self.column)
        if not self.of:
            return value
        if self.of in WHAT:
            return value / found[self.of].instructions
        return value / getattr(found[self.what], self.of)


# A real program at n = 2: its deepest stack
STACKS = (("m4f", "f32", 480), ("m3", "q31", 850), ("m0", "q31", 900), ("avr", "f32", 400), ("avr", "q31", 900))
# The same with lean sensors and constant tables: bytes of flash
LEAN = (("m4f", "f32", 6700), ("m3", "q31", 10000), ("m0", "q31", 11700), ("avr", "f32", 15200),
        ("avr", "q31", 31500))  # fmt: skip
# The dearest step of a lean filter, times the settled one
LEAN_WORST = (("m4f", "f32", 3.6), ("m3", "q31", 3.6), ("m0", "q31", 3.6))
# Instructions of a step at n states
STEPS = (
    ("m4f", "f32", RUNTIME, {2: 870, 4: 1989, 9: 7120}),
    ("m3", "q31", RUNTIME, {2: 2750, 4: 6754, 9: 21894}),
    ("m0", "q31", RUNTIME, {4: 16635, 9: 58631}),
    ("m4f", "f32", FIXED, {3: 230, 4: 500}),
    ("m3", "q31", FIXED, {2: 1300, 4: 3900, 9: 14000}),
)
# The dearest of 500 settled steps, times one of them
DEAREST = 1.1
# The dearest update, times the settled one
WORST = (("m4f", "f32", 7), ("m3", "q31", 9.5), ("m0", "q31", 8.3))


# Of nonlinear models, in f32 on an M4F: instructions of a whole step at n states, f and h in them, extended and
# by sigma points; bytes of stack of the latter; and bytes of flash at -Os, beside the linear program
NONLINEAR = ((6, 5900, 18000), (9, 10690, 38000))
NONLINEAR_STACK = 700
NONLINEAR_FLASH = (("extended", 980), ("points", 3170))


def of_nonlinear() -> list[Goal]:
    on = ("m4f", "f32")
    goals = [
        Goal(*on, n, RUNTIME, "extended_predict", 1.1, of="step", plus="extended_update")
        for n in (4, 6, 9)
    ]
    for n, extended, points in NONLINEAR:
        goals.append(Goal(*on, n, RUNTIME, "extended", extended))
        goals.append(Goal(*on, n, RUNTIME, "points", points))
        goals.append(Goal(*on, n, RUNTIME, "points", NONLINEAR_STACK, "stack_bytes"))
    for what, most in NONLINEAR_FLASH:
        goals.append(Goal(*on, 6, RUNTIME, what, most, "flash_program", less="changed", profile=SMALL))
    return goals


GOALS = (
    *(
        Goal(core, kind, n, sizes, "step", most)
        for core, kind, sizes, all_most in STEPS
        for n, most in all_most.items()
    ),
    *(Goal(core, kind, 2, RUNTIME, "step", stack, "stack_worst") for core, kind, stack in STACKS),
    *(Goal(core, kind, 2, RUNTIME, "lean", most, "flash_program") for core, kind, most in LEAN),
    *(
        Goal(core, kind, n, RUNTIME, "update", most, "instructions_worst", of="instructions")
        for core, kind, most in WORST
        for n in (1, 2, 3)
    ),
    *(
        Goal(core, kind, n, RUNTIME, "lean", most, "instructions_worst", of="instructions")
        for core, kind, most in LEAN_WORST
        for n in (2, 4, 9)
    ),
    *(Goal(core, kind, n, RUNTIME, "dearest", DEAREST, of="step") for core, kind in (("m4f", "f32"), ("m3", "q31")) for n in (2, 4, 9)),
    *of_nonlinear(),
    Goal("m4f", "f32", 4, FIXED, "steady", 90),
    Goal("m3", "q31", 4, FIXED, "steady", 500),
    # a sample of 10 steps' lag, the step of the filter in it: the most of all phases of its work.  With the root of
    # its covariance, which was left in up to 5 n columns, for each reading to sum, when this was 3
    Goal("m3", "q31", 2, RUNTIME, "lag", 9500),
    Goal("m3", "q31", 2, RUNTIME, "lag_states", 3, of="step"),
)


def reached(goal: Goal, rows: list[Row]) -> bool:
    value = goal.value(rows)
    unit = f"times {goal.of}" if goal.of else f"beside {goal.less}" if goal.less else ""
    what = goal.what + (f" + {goal.plus}" if goal.plus else "")
    where = f"{goal.core} {goal.arithmetic} n {goal.n} {goal.sizes} {what} {goal.column}"
    verdict = "" if value <= goal.most else "  MISSED"
    print(f"{where:48} {value:8.6g}, goal {goal.most} {unit}{verdict}")
    return value <= goal.most


def missed(goals: Iterable[Goal], rows: list[Row]) -> list[Goal]:
    return [goal for goal in goals if not reached(goal, rows)]


def wanted(goals: Iterable[Goal]) -> list[Program]:
    return list(dict.fromkeys(each for goal in goals for each in programs(goal.choice)))


def unlike_the_table(cores: Iterable[str]) -> str:
    """Why figures of these cores are not compared here, if they are not"""
    return incomparable(table.read(ROOT / "tools" / "cost.csv").versions, [BY_NAME[core] for core in cores], with_clang=False)


def main() -> int:
    if reason := unlike_the_table({goal.core for goal in GOALS}):
        print(reason)
        return 0
    rows = [row for measured in measure_all(ROOT, wanted(GOALS)) for row in measured.rows]
    return 1 if missed(GOALS, rows) else 0


if __name__ == "__main__":
    with told_in_one_line("goals"):
        sys.exit(main())
