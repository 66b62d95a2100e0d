"""Instructions of one step against the number of states, a panel for each core."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cases import FIXED, RUNTIME, SIZES
from cores import CORES, Core
from row import Row

LEVEL = "O2"
COLUMNS = 4

# Okabe and Ito's palette, as the demo's plots
F32, Q31, F64, OTHERS = "#B0407F", "#B57900", "#2F7FB8", "#777777"
STYLE: dict[str, Any] = {
    "figure.dpi": 160,
    "font.size": 9,
    "axes.titlesize": 10,
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#E2E2E2",
    "grid.linewidth": 0.5,
    "axes.axisbelow": True,
    "lines.solid_capstyle": "round",
}


@dataclass(frozen=True)
class Curve:
    label: str
    arithmetic: str
    sizes: str
    colour: str
    dashes: Any = "-"
    width: float = 1.8


CURVES = (
    Curve("textbook, float", "textbook-f32", RUNTIME, OTHERS, (0, (4, 2)), 1.2),
    Curve("textbook, Q16.16", "textbook-q16", RUNTIME, OTHERS, (0, (1, 1.5)), 1.2),
    Curve("f32", "f32", RUNTIME, F32),
    Curve("f32, fixed sizes", "f32", FIXED, F32, (0, (6, 1.5)), 1.2),
    Curve("q31", "q31", RUNTIME, Q31),
    Curve("q31, fixed sizes", "q31", FIXED, Q31, (0, (6, 1.5)), 1.2),
    Curve("f64", "f64", RUNTIME, F64),
)


def save(rows: tuple[Row, ...], path: Path) -> None:
    with plt.rc_context(STYLE):
        figure = draw(rows)
        figure.savefig(path, format="png")
        plt.close(figure)


def draw(rows: tuple[Row, ...]) -> Figure:
    lines = -(-len(CORES) // COLUMNS)
    figure, grid = plt.subplots(lines, COLUMNS, figsize=(12.5, 7.2), sharey=True)
    panels = list(grid.flat)
    for axes, core in zip(panels, CORES):
        draw_core(axes, core, rows)
    for axes in grid[:, 0]:
        axes.set_ylabel("instructions")
    for axes in panels[len(CORES) :]:
        axes.set_visible(False)
    figure.suptitle("Instructions of one predict and one update", x=0.012, ha="left", weight="bold")
    figure.tight_layout()
    return figure
