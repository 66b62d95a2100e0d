"""The table of the estimate: noise and log-likelihood at the guess, on the way and at the end."""

from __future__ import annotations

import numpy as np
from rich.console import Console
from rich.table import Table
from rich.text import Text

from learning import TAKEN, Course, Learning
from report import Row


def show(console: Console, learning: Learning) -> None:
    """Prints the iterations, a column each, of every arithmetic."""
    guess, milestones = learning.guess, learning.milestones
    title = Text(f"{guess.title}, Q and R by EM", style="bold")
    table = Table(title=title, title_justify="left", show_edge=False)
    table.add_column(no_wrap=True)
    for heading in headings(learning):
        table.add_column(heading, justify="right")
    for name, course in learning.courses.items():
        rows = course_rows(name, course, learning, [*milestones, course.last])
        for k, (label, cells) in enumerate(rows):
            table.add_row(Text(label), *cells, end_section=k == len(rows) - 1)
    console.print()
    console.print(table)
    taken = learning.courses[TAKEN]
    for line in [rise_text(taken), *distance_text(taken), *remarks(learning)]:
        console.print(line, style="dim", markup=False, soft_wrap=True)


def headings(learning: Learning) -> list[str]:
    between = [""] * (len(learning.milestones) - 1)
    published = ["published"] if learning.guess.published else []
    return ["guess", *between, "last", *published]


def course_rows(name: str, course: Course, learning: Learning, shown: list[int]) -> list[Row]:
    published = learning.guess.published
    rows: list[Row] = [(f"{name}: iteration", [str(k) for k in shown])]
    for noise in ("q", "r"):
        known = [f"{getattr(published, noise):.6g}"] if published else []
        for c, component in enumerate(names(learning)):
            cells = [f"{getattr(course.models[k], noise)[c]:.6g}" for k in shown]
            rows.append((f"  {noise}{component}", cells + known))
    rows.append(("  log-likelihood", [f"{course.log_likelihood[k]:.4f}" for k in shown]))
    return rows


def names(learning: Learning) -> list[str]:
    """What tells the components apart, where there are several."""
    measured = learning.guess.model.measured
    return [f" of {name}" for name in measured] if len(measured) > 1 else [""]


def rise_text(course: Course) -> str:
    first, last = course.log_likelihood[[0, -1]]
    return f"{TAKEN}: the log-likelihood rose by {course.rise:.4f}, from {first:.4f} to {last:.4f}"


def distance_text(course: Course) -> list[str]:
    """What more iterations would add, where the last ones tell it."""
    if np.isnan(course.distance):
        return []
    return [f"{TAKEN}: up to {course.distance:.1g} below the maximum, extrapolated"]


def remarks(learning: Learning) -> list[str]:
    published = learning.guess.published
    lines = [
        f"{name}: not settled after {course.last} iterations"
        for name, course in learning.courses.items()
        if not course.settled
    ]
    return lines + ([f"published: {published.source}"] if published else [])
