"""The picture of an example: what its board has printed, beside what was measured and what is true."""
from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Callable, Optional

import numpy as np

COLOURS = {"measured": "#9a9a9a", "true": "#000000", "board": "#c2551c", "other": "#1f6fb4"}
Columns = dict[str, np.ndarray]


@dataclass(frozen=True)
class Panel:
    """shown: of the board, of which the sum is drawn; error: less what is true; other: a column of the host, and its name;
    sigma: of a band, if it is not of what is shown"""

    label: str
    shown: tuple[str, ...]
    true: str
    measured: str = ""
    error: bool = False
    other: tuple[str, str] = ("", "")
    sigma: str = ""


@dataclass(frozen=True)
class Picture:
    step: float
    unit: str
    panels: tuple[Panel, ...]
    derived: Optional[Callable[[Columns, str], Columns]] = None  # of the columns with this end


def angles(columns: Columns, end: str) -> Columns:
    """Degrees, of a quaternion's columns"""
    w, x, y, z = (columns[f"q_{one}{end}"] for one in "wxyz")
    made = {"roll": np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)), "pitch": np.arcsin(np.clip(2 * (w * y - z * x), -1, 1)),
            "heading": np.unwrap(np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))}
    return {f"{name}{end}": np.degrees(values) for name, values in made.items()}


PICTURES = {
    "adc": Picture(1, "sample", (Panel("level, counts", ("level",), "level_true", "count"),)),
    "altitude": Picture(0.02, "time, s", (Panel("altitude, m", ("altitude",), "altitude_true", "barometer"), Panel("climb, m/s", ("climb",), "climb_true"))),
    "wheel": Picture(0.02, "s", (Panel("speed, m/s", ("speed",), "speed_true", "wheel"),)),
    "battery": Picture(1 / 6, "min", (Panel("charge", ("charge",), "charge_true"), Panel("error of the charge", ("charge",), "charge_true", error=True))),
    "attitude": Picture(0.01, "s", tuple(Panel(f"{name}, degrees", (name,), f"{name}_true") for name in ("roll", "pitch", "heading")), angles),
    "rocket": Picture(0.1, "s", (Panel("altitude, m", ("altitude",), "altitude_true", "barometer"),
                                 Panel("error of the speed, m/s", ("speed",), "speed_true", error=True, other=("speed_mean", "in flight")))),
    "room": Picture(0.25, "h", (Panel("temperature, C", ("level", "day", "half_day"), "temperature_true", "thermometer", sigma="forecast_sigma"),)),
    "gps": Picture(0.02, "s", (Panel("error of the position, m", ("position",), "position_true", error=True,
                                     other=("position_in_time", "taken as if it came in time")),)),
}


def draw(name: str, shown: Columns, host: Columns, data: Columns, path: Path) -> None:
    """shown: what the board has printed, by state; host: `kalmanq run`'s columns; data: the recording"""
    import io

    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from PIL import Image

    picture = PICTURES[name]
    if picture.derived:
        shown, data = {**shown, **picture.derived(shown, "")}, {**data, **picture.derived(data, "_true")}
    figure, axes = plt.subplots(1, len(picture.panels), figsize=(7.4, 2.6), dpi=100, squeeze=False, layout="constrained")
    for axis, panel in zip(axes[0], picture.panels):
        _panel(axis, panel, picture.step, shown, host, data)
        axis.set(xlabel=picture.unit, ylabel=panel.label)
        axis.spines[["top", "right"]].set_visible(False)
        axis.margins(x=0.01)
        if panel.measured or panel.other[0] or axis is axes[0][0]:
            axis.legend(frameon=False, fontsize=8)
    buffer = io.BytesIO()
    figure.savefig(buffer)
    plt.close(figure)
    Image.open(buffer).convert("RGB").quantize(24).save(path, optimize=True)


def _panel(axis: Any, panel: Panel, step: float, shown: Columns, host: Columns, data: Columns) -> None:
    values = np.sum([shown[one] for one in panel.shown], axis=0)
    at, true = np.arange(len(values)) * step, data[panel.true]
    less = true if panel.error else np.zeros(len(values))
    if panel.measured:
        axis.plot(at, data[panel.measured], ".", color=COLOURS["measured"], markersize=2.5, label="measured")
    if panel.other[0]:
        axis.plot(at, host[panel.other[0]] - less, color=COLOURS["other"], linewidth=1, label=panel.other[1])
    axis.plot(at, true - less, color=COLOURS["true"], linewidth=0.8, label="true")
    name = panel.sigma or f"{panel.shown[0]}_sigma"  # of the board, if it prints it; otherwise the host's, whose means are the board's
    sigma = shown.get(name, host.get(name))
    if sigma is not None:
        axis.fill_between(at, values - less - 2 * sigma, values - less + 2 * sigma, color=COLOURS["board"], alpha=0.2, linewidth=0)
    axis.plot(at, values - less, color=COLOURS["board"], linewidth=1.1, label="board")
