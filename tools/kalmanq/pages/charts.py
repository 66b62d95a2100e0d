"""Pictures of a page: SVG in the colours of the page, drawn twice, for wide and for narrow screens."""

from __future__ import annotations

import html
import io
import re
from dataclasses import dataclass
from typing import Any, Callable, Optional

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

from kalmanq.pages.across import Across
from kalmanq.pages.pictures import STYLE, limit
from kalmanq.pages.verdict import Whiteness
from kalmanq.run.diagnostics import chi_square_limit

# What Matplotlib draws with, and the page's variables in their place: they change with the colour scheme.
COLOURS = {"#000000": "--ink", "#57606a": "--muted", "#d8dee4": "--grid", "#1f6fb4": "--filtered",
           "#c4501b": "--smoothed", "#6e7781": "--data"}
INK, MUTED, GRID, FILTERED, SMOOTHED, DATA = COLOURS
SVG_STYLE: dict[str, Any] = {
    **STYLE, "svg.fonttype": "none", "font.size": 9.5, "font.family": "DejaVu Sans", "text.color": INK,
    "axes.edgecolor": MUTED, "axes.labelcolor": INK, "xtick.color": MUTED, "ytick.color": MUTED, "grid.color": GRID,
    "xtick.labelcolor": INK, "ytick.labelcolor": INK, "axes.xmargin": 0.01,
}
POINTS_TO_INCH = 1 / 72
LEFT, RIGHT, ABOVE, BELOW = 46, 16, 13, 32  # margins in points: the same for all, so that rows are in line
FAR = 8  # times the upper bound, from where an outlier would hide the other rows
CLOUD = 8  # rows of a bucket, from where their range is drawn in the place of dots
SIZE_WANTED = 2.2e6  # bytes of all pictures
BYTES_A_BUCKET = 76  # of one series in both sizes, measured


@dataclass(frozen=True)
class Size:
    """name: the class of the picture on the page; width in points; share: of the buckets of a wide one."""

    name: str
    width: float
    share: float


WIDE, NARROW = Size("wide", 760, 1.0), Size("narrow", 340, 0.45)


@dataclass(frozen=True)
class Canvas:
    """Where a picture is drawn: so many buckets of rows have a place side by side."""

    axis: Any
    buckets: int
    across: Across

    def line(self, values: np.ndarray, colour: str, **options: Any) -> None:
        at, low, high, _ = envelope(values, self.across, self.buckets)
        at, values = (at, low) if low is high else (np.repeat(at, 2), np.column_stack([low, high]).ravel())
        if len(at) == 1:  # a dash, as a line has no width
            at, values = at + self._dash, np.repeat(values, 2)
        self.axis.plot(at, values, color=colour, **{"lw": 1.3, **options})

    @property
    def _dash(self) -> np.ndarray:
        return 0.3 * self.across.step * np.array([-1, 1])

    def band(self, low: np.ndarray, high: np.ndarray, colour: str) -> None:
        at, lowest, _, _ = envelope(low, self.across, self.buckets)
        _, _, highest, _ = envelope(high, self.across, self.buckets)
        if len(at) == 1:
            at, lowest, highest = at + self._dash, np.repeat(lowest, 2), np.repeat(highest, 2)
        known = np.isfinite(lowest) & np.isfinite(highest)
        self.axis.fill_between(at, lowest, highest, where=known, color=colour, alpha=0.2, lw=0)

    def dots(self, values: np.ndarray, colour: str, size: float = 3.6) -> None:
        """Round ends of dashes of no length: a path of them is smaller than as many markers.  Too many are a cloud."""
        at, low, high, middle = envelope(values, self.across, self.buckets)
        if len(values) > CLOUD * self.buckets:
            self.axis.fill_between(at, low, high, where=np.isfinite(low), color=colour, alpha=0.4, lw=0)
            return
        if low is not high:  # with one between them, lest there seem to be two clouds
            at, low = np.repeat(at, 3), np.column_stack([low, values[middle], high]).ravel()
        known = np.isfinite(low)
        at, low = at[known], low[known]
        dash = 1e-6 * np.ptp(self.across.at) or 1e-6
        path = np.column_stack([at - dash, at + dash, np.full(len(at), np.nan)]).ravel()
        self.axis.plot(path, np.repeat(low, 3), color=colour, lw=size, alpha=0.85, solid_capstyle="round")


def envelope(values: np.ndarray, across: Across, buckets: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Where each bucket is, its lowest and highest value, and the row in its middle; few rows are what they are, low is high."""
    at, rows = across.at, np.arange(len(values))
    if len(values) <= 2 * buckets:
        return at, values, values, rows
    edges = np.unique(np.searchsorted(at, np.linspace(at[0], at[-1], buckets, endpoint=False)))
    last = np.append(edges[1:], len(values)) - 1
    return (at[edges] + at[last]) / 2, np.fmin.reduceat(values, edges), np.fmax.reduceat(values, edges), (edges + last) // 2


def buckets_for(series: int) -> int:
    return int(np.clip(SIZE_WANTED / (BYTES_A_BUCKET * max(series, 1)), 120, 700))


# ------------------------------------------------------------------------------ the pictures


def draw_state(canvas: Canvas, measured: list[np.ndarray], filtered: tuple[np.ndarray, np.ndarray],
               smoothed: Optional[tuple[np.ndarray, np.ndarray]]) -> None:
    """Data, mean and band of 95 % of a state, filtered and smoothed."""
    for values in measured:
        canvas.dots(values, DATA)
    for given, colour in ((filtered, FILTERED), (smoothed, SMOOTHED)):
        if given is not None:
            mean, sigma = given
            canvas.band(mean - 1.96 * sigma, mean + 1.96 * sigma, colour)
            canvas.line(mean, colour)
    limit(canvas.axis, np.concatenate([filtered[0], *measured]))


def draw_residuals(canvas: Canvas, series: np.ndarray) -> None:
    canvas.axis.axhline(0, color=MUTED, lw=0.8)
    for bound in (-2, 2):
        canvas.axis.axhline(bound, color=SMOOTHED, lw=1, ls=(0, (4, 3)))
    canvas.dots(series, FILTERED, 3.2)
    largest = np.nanmax(np.abs(series)) if np.any(np.isfinite(series)) else 0
    canvas.axis.set_ylim(-max(3.0, 1.1 * largest), max(3.0, 1.1 * largest))


def draw_nis(canvas: Canvas, nis: np.ndarray, taken: np.ndarray) -> None:
    """NIS a row with the bounds of 95 % of its chi-square, and the mean over neighbouring rows.

    Logarithmic where outliers would hide the others.
    """
    low, high = (np.where(taken > 0, chi_square_limit(p, np.maximum(taken, 1)), np.nan) for p in (0.025, 0.975))
    canvas.band(low, high, SMOOTHED)
    canvas.dots(nis, DATA, 3.2)
    canvas.line(running_mean(nis, max(10, len(nis) // 20)), FILTERED)
    if np.any(nis > FAR * high):
        _logarithmic(canvas.axis, np.inf)
        canvas.axis.set_ylim(bottom=np.nanmin(low) / 10)
    else:
        canvas.axis.set_ylim(bottom=0)


def running_mean(values: np.ndarray, width: int) -> np.ndarray:
    """Over so many rows around each, fewer at the ends; NaN: missing."""
    known = np.isfinite(values)
    first = np.arange(len(values)) - width // 2
    low, high = np.clip(first, 0, len(values)), np.clip(first + width, 0, len(values))
    total, count = (np.concatenate([[0.0], np.cumsum(of)]) for of in (np.where(known, values, 0.0), known))
    with np.errstate(invalid="ignore", divide="ignore"):
        return (total[high] - total[low]) / np.where(count[high] > count[low], count[high] - count[low], np.nan)


def draw_autocorrelation(canvas: Canvas, white: Whiteness) -> None:
    lags = np.arange(1, len(white.correlation) + 1)
    canvas.axis.fill_between(np.concatenate([[0.3], lags, [len(lags) + 0.7]]), *(
        sign * np.concatenate([white.bounds[:1], white.bounds, white.bounds[-1:]]) for sign in (-1, 1)),
        color=SMOOTHED, alpha=0.2, lw=0)
    canvas.axis.axhline(0, color=MUTED, lw=0.8)
    shown = np.nan_to_num(white.correlation)
    canvas.axis.vlines(lags, 0, shown, color=FILTERED, lw=2.2)
    largest = max(1.15 * float(np.max(np.abs(shown))), 2 * float(np.max(white.bounds)))
    canvas.axis.set_ylim(-min(1.05, largest), min(1.05, largest))


def draw_sigma(canvas: Canvas, filtered: np.ndarray, smoothed: Optional[np.ndarray]) -> None:
    """Logarithmic where the first rows would hide the others."""
    both = [(filtered, FILTERED)] + ([(smoothed, SMOOTHED)] if smoothed is not None else [])
    for sigma, colour in both:
        canvas.line(sigma, colour)
    values = np.concatenate([sigma for sigma, _ in both])
    values = values[np.isfinite(values)]
    if len(values) and np.min(values) > 0 and np.max(values) > 20 * np.min(values):
        _logarithmic(canvas.axis, np.log10(np.max(values) / np.min(values)))
    else:
        canvas.axis.set_ylim(bottom=0)


def _logarithmic(axis: Any, decades: float) -> None:
    axis.set_yscale("log")
    axis.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5) if decades < 1.5 else (1, 3) if decades < 3 else (1,)))
    axis.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.yaxis.set_minor_locator(NullLocator())


# ------------------------------------------------------------------------------ SVG


def chart(identity: str, said: str, draw: Callable[..., None], *given: Any, height: float, buckets: int,
          across: Across, label: str = "", sizes: tuple[Size, ...] = (WIDE, NARROW)) -> str:
    """What `draw` makes of a canvas and `given`, in each size; `said` is what it shows, for those who do not see it;
    label: of an axis that has neither rows nor times."""
    made = []
    for size in sizes:
        with plt.rc_context({**SVG_STYLE, "svg.hashsalt": identity}):
            figure, axis = plt.subplots(figsize=(size.width * POINTS_TO_INCH, height * POINTS_TO_INCH))
            figure.subplots_adjust(LEFT / size.width, BELOW / height, 1 - RIGHT / size.width, 1 - ABOVE / height)
            figure.patch.set_visible(False)
            axis.patch.set_visible(False)
            with np.errstate(all="ignore"):
                draw(Canvas(axis, max(60, int(buckets * size.share)), across), *given)
            _finish(axis, across, label)
            text = io.StringIO()
            figure.savefig(text, format="svg", metadata={"Date": None})
            plt.close(figure)
        made.append(inline(text.getvalue(), f"{identity}-{size.name}", size.name, said))
    return "\n".join(made)


def _finish(axis: Any, across: Across, label: str) -> None:
    axis.set_xlabel(label or across.label)
    axis.xaxis.get_major_locator().set_params(integer=not across.unit or bool(label))
    axis.ticklabel_format(axis="y", style="sci", scilimits=(-4, 5)) if axis.get_yscale() == "linear" else None
    if not label and len(across.at):
        room = 0.5 * across.step + 0.005 * (np.ptp(across.at) + across.step)
        axis.set_xlim(across.at[0] - room, across.at[-1] + room)
        if len(across.at) < 4 and not across.unit:
            axis.set_xticks(range(len(across.at)))
    if not axis.has_data():
        axis.text(0.5, 0.5, "nothing to show", transform=axis.transAxes, ha="center", va="center")


def inline(svg: str, identity: str, name: str, said: str) -> str:
    """An element of a page: colours and font of the page, names of its own, coordinates of two decimals."""
    size = re.search(r'viewBox="([^"]*)"', svg)
    assert size
    body = svg[svg.index(">", svg.index("<svg")) + 1 : svg.rindex("</svg>")]
    body = re.sub(r"<metadata>.*?</metadata>|<style.*?</style>|<!--.*?-->", "", body, flags=re.S)
    body = body.replace("xlink:href", "href")
    body = re.sub(r'\bid="([^"]*)"', rf'id="{identity}-\1"', body)
    body = re.sub(r'href="#([^"]*)"', rf'href="#{identity}-\1"', body)
    body = re.sub(r"url\(#([^)]*)\)", rf"url(#{identity}-\1)", body)
    body = re.sub(r' d="([^"]*)"', lambda found: f' d="{_shortened(found.group(1))}"', body)
    body = re.sub(r"font: [^;\"]*px [^;\"]*", lambda found: _font(found.group(0)), body)
    for colour, variable in COLOURS.items():
        body = body.replace(colour, f"var({variable})")
    body = re.sub(r"\n\s*", "\n", body).strip()
    return (f'<svg class="{name}" viewBox="{size.group(1)}" role="img" '
            f'aria-label="{html.escape(said, quote=True)}">\n{body}\n</svg>')


def _shortened(path: str) -> str:
    return re.sub(r"\s+", " ", re.sub(r"(\.\d\d)\d+", r"\1", path)).strip()


def _font(given: str) -> str:
    size = re.search(r"([\d.]+)px", given)
    return f"font-size: {size.group(1)}px" if size else ""
