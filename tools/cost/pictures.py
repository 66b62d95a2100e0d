"""How the tools' plots look, and how they become files."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Callable, Mapping

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
from matplotlib.figure import Figure

STYLE: dict[str, Any] = {
    "figure.dpi": 160,
    "font.size": 9.5,
    "axes.titlesize": 10,
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#DDDDDD",
    "grid.linewidth": 0.5,
    "axes.axisbelow": True,
    "legend.frameon": False,
    "lines.solid_capstyle": "round",
}


def save(draw: Callable[[], Figure], path: Path, changed: Mapping[str, Any] | None = None) -> None:
    """Draws a figure, in the common style but for what is changed, into a PNG."""
    with plt.rc_context({**STYLE, **(changed or {})}):
        figure = draw()
        figure.savefig(path, format="png")
        plt.close(figure)
