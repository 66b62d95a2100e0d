"""One measurement for two tests: the cost table, and the goals of goals.py.

    table_and_goals.py    of the M4F the table in f32 and q31 at 2 and 4 states, and the goals up to 4 states

A program has all sizes that the table or a goal asks for: each is compiled and emulated once.
"""

from __future__ import annotations

import sys
from dataclasses import replace

from goals import GOALS, ROOT, missed, unlike_the_table, wanted

import command_line
from cases import GCC, Choice, Program, programs
from errors import told_in_one_line
from measure import measure_all

TABLE = Choice(core=("m4f",), arithmetic=("f32", "q31"), profile=(GCC,), n=(2, 4))
CORES, MOST = ("m4f",), 4


def merged(every: list[Program]) -> list[Program]:
    """Programs that differ in their sizes alone become one."""
    sizes: dict[Program, set[tuple[int, int]]] = {}
    for program in every:
        sizes.setdefault(replace(program, dimensions=()), set()).update(program.dimensions)
    return [replace(program, dimensions=tuple(sorted(dimensions))) for program, dimensions in sizes.items()]


def main() -> int:
    if reason := unlike_the_table(CORES):
        print(reason)
        return 0
    goals = [goal for goal in GOALS if goal.n <= MOST and goal.core in CORES]
    found = measure_all(ROOT, merged([*wanted(goals), *command_line.of_kept(programs(TABLE))]))
    few = missed(goals, [row for measured in found for row in measured.rows])
    is_as_in_the_table = command_line.are_as_in_the_table(found, TABLE)
    return 0 if goals and not few and is_as_in_the_table else 1


if __name__ == "__main__":
    with told_in_one_line("table_and_goals"):
        sys.exit(main())
