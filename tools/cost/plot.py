"""Instructions of one step against the number of states, a panel for each core."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cases import FIXED, GCC, RUNTIME, SIZES
from cores import CORES, Core
import pictures
from table import Row

COLUMNS = 4
LABEL_ROOM = 4.6  # on the axis of n, for the names behind the curves
LABEL_HEIGHT = 0.135  # decades
TITLE = "Instructions of one predict and one full update (gcc -O2)"
NOTES = """n states, m measured components:
(1, 1) (2, 1) (3, 1) (4, 2) (6, 3) (9, 3).

Counted in an emulator at the 20th step:
m axes of position, velocity and acceleration,
a dense Q, sizes known at run time where
nothing else is said.

textbook: the covariance itself, in float or in
Q16.16. It does not keep P semi-definite."""

# Okabe and Ito's palette, darker than in the demo's plots: names are written in it, too
F32, Q31, F64, OTHERS = "#B0407F", "#B57900", "#2F7FB8", "#777777"
STYLE = {"font.size": 9, "grid.color": "#E2E2E2"}


@dataclass(frozen=True)
class Curve:
    label: str
    arithmetic: str
    sizes: str
    colour: str
    dashes: Any = "-"
    width: float = 1.8


CURVES = (
    Curve("textbook, float", "textbook-f32", RUNTIME, OTHERS, (0, (4, 2)), 1.3),
    Curve("textbook, Q16.16", "textbook-q16", RUNTIME, OTHERS, (0, (1, 1.5)), 1.5),
    Curve("f32", "f32", RUNTIME, F32),
    Curve("f32, fixed sizes", "f32", FIXED, F32, (0, (6, 1.5)), 1.1),
    Curve("q31", "q31", RUNTIME, Q31),
    Curve("q31, fixed sizes", "q31", FIXED, Q31, (0, (6, 1.5)), 1.1),
    Curve("f64", "f64", RUNTIME, F64),
)
DOUBLE_ON = "m7"  # elsewhere a double is emulated


def save(rows: tuple[Row, ...], path: Path) -> None:
    pictures.save(lambda: draw(rows), path, STYLE)


def draw(rows: tuple[Row, ...]) -> Figure:
    lines = -(-len(CORES) // COLUMNS)
    figure, grid = plt.subplots(lines, COLUMNS, figsize=(13, 7.6), sharey=True)
    panels = list(grid.flat)
    for axes, core in zip(panels, CORES):
        draw_core(axes, core, rows)
    for axes in grid[:, 0]:
        axes.set_ylabel("instructions")
    explain(panels[len(CORES)])
    for axes in panels[len(CORES) + 1 :]:
        axes.set_visible(False)
    figure.suptitle(TITLE, x=0.012, ha="left", fontsize=12, weight="bold")
    figure.tight_layout(rect=(0, 0, 1, 0.99))
    return figure


def draw_core(axes: Axes, core: Core, rows: tuple[Row, ...]) -> None:
    axes.set_title(core.description)
    axes.set_yscale("log")
    axes.set_xlim(0.6, 9 + LABEL_ROOM)
    axes.set_xticks([n for n, _ in SIZES])
    axes.set_xlabel("states", x=4.7 / (9 + LABEL_ROOM))
    axes.spines["bottom"].set_bounds(0.6, 9)
    ends = []
    for curve in CURVES:
        steps = steps_of(rows, core, curve)
        if not steps or (curve.arithmetic == "f64" and core.name != DOUBLE_ON):
            continue
        axes.plot(
            [row.n for row in steps], [row.instructions for row in steps], color=curve.colour,
            ls=curve.dashes, lw=curve.width, marker="o", ms=2.5, mew=0,
        )  # fmt: skip
        ends.append((steps[-1].instructions, curve))
    label_ends(axes, ends)


def steps_of(rows: tuple[Row, ...], core: Core, curve: Curve) -> list[Row]:
    wanted = (core.name, curve.arithmetic, curve.sizes, GCC, "step")
    found = [
        row
        for row in rows
        if (row.core, row.arithmetic, row.sizes, row.profile, row.what) == wanted
    ]
    return sorted(found, key=lambda row: row.n)


def label_ends(axes: Axes, ends: list[tuple[int, Curve]]) -> None:
    """Each curve's name behind its end, moved where it would cover another one."""
    ends = sorted(ends, key=lambda end: end[0])
    heights = spread([math.log10(value) for value, _ in ends], LABEL_HEIGHT)
    for height, (_, curve) in zip(heights, ends):
        axes.text(9.3, 10**height, curve.label, color=curve.colour, fontsize=8, va="center")


def spread(heights: list[float], least: float) -> list[float]:
    """Rising heights, moved apart by as little as makes neighbours differ by `least`."""
    groups: list[list[float]] = []  # each is spread around its mean
    for height in heights:
        groups.append([height])
        while len(groups) > 1 and bottom(groups[-1], least) < top(groups[-2], least) + least:
            groups[-2:] = [groups[-2] + groups[-1]]
    return [bottom(group, least) + least * k for group in groups for k in range(len(group))]


def bottom(group: list[float], least: float) -> float:
    return sum(group) / len(group) - least * (len(group) - 1) / 2


def top(group: list[float], least: float) -> float:
    return bottom(group, least) + least * (len(group) - 1)


def explain(axes: Axes) -> None:
    axes.axis("off")
    axes.text(0.02, 0.97, NOTES, transform=axes.transAxes, va="top", fontsize=8.5, linespacing=1.5)
