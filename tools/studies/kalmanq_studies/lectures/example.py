"""What an example is, and what its figures have in common."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Callable, Iterator, Mapping, Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from kalmanq.firmware.ranges import with_ranges
from kalmanq.firmware.reach import Record
from kalmanq.model import Model
from kalmanq.pages.pictures import STYLE
from kalmanq.run.filters import Filter

# Colours that are told apart without red and green: M. Okabe and K. Ito, "Color Universal Design", 2008.
BLUE, ORANGE, GREEN, PURPLE, GREY = "#0072B2", "#D55E00", "#009E73", "#AA4499", "#777777"
ARITHMETIC_STYLES = {"f64": ("#000000", "-"), "f32": (ORANGE, "--"), "q31": (BLUE, ":")}


@dataclass(frozen=True)
class Example:
    """compute   (arithmetic, seed): the result in one arithmetic
    numbers   of a result, by name: what is printed
    distance  (result, exact): how far apart two results are at most, in sigma
    draw      of results by arithmetic
    """

    shows: str
    compute: Callable[[str, int], Any]
    numbers: Callable[[Any], Mapping[str, ArrayLike]]
    distance: Callable[[Any, Any], float]
    draw: Callable[[Mapping[str, Any]], Figure]

    def figure(self, results: Mapping[str, Any], said: str) -> Figure:
        """With what is said of it beneath"""
        with plt.rc_context({**STYLE, "figure.dpi": 110}):
            made = self.draw(results)
            made.supxlabel(said, fontsize=8.5, color=GREY)
            return made


def shown(results: Mapping[str, Any]) -> Any:
    """The result that a figure is drawn from where it shows one."""
    return results.get("f64", next(iter(results.values())))


def caption(example: Example, results: Mapping[str, Any]) -> str:
    """Which arithmetic one sees, and how far the others are from it."""
    if "f64" not in results:
        return f"drawn from {', '.join(results)}"
    others = [f"{name} {example.distance(of, results['f64']):.1g}" for name, of in results.items() if name != "f64"]
    return "drawn from f64" + (f"; at most so far from it, in sigma: {', '.join(others)}" if others else "")


def ranged(model: Model, records: Sequence[np.ndarray]) -> Model:
    """With the ranges that these records (T x m each) ask for: fixed point chooses its formats by them."""
    return with_ranges(model, [Record(z) for z in records], life=0)[0]


def predicted_covariances(model: Model, arithmetic: str, rows: int) -> np.ndarray:
    """rows x n x n: before the measurement of each row.  They are the same whatever is measured."""
    filter_ = Filter(model, arithmetic)

    def before() -> Iterator[np.ndarray]:
        for row in range(rows):
            if row:
                filter_.predict()
            yield filter_.covariance
            filter_.update(np.zeros(model.m))

    return np.array(list(before()))


def apart(mean: np.ndarray, exact: np.ndarray, sigma: np.ndarray) -> float:
    """The largest distance of means (... x n) in sigma (n, or as many)"""
    return float(np.max(np.abs(mean - exact) / sigma))


def covariances_apart(P: np.ndarray, exact: np.ndarray) -> float:
    """The largest distance of an entry of covariances (... x n x n) in sigma_i sigma_j"""
    sigma = np.sqrt(np.diagonal(exact, axis1=-2, axis2=-1))
    return float(np.max(np.abs(P - exact) / (sigma[..., :, None] * sigma[..., None, :])))
