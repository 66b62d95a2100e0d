"""The six figures of the findings: each has one message, its title says which."""

from __future__ import annotations

from typing import Any, Callable, Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure as Picture
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

from kalmanq.pages.pictures import STYLE
from kalmanq_studies.heavy_tails import claims, population, scores
from kalmanq_studies.heavy_tails.claims import EVEN, METRICS, QUIET
from kalmanq_studies.heavy_tails.collected import Collected
from kalmanq_studies.heavy_tails.settings import SETTINGS

# Okabe and Ito's colours, which the colour-blind tell apart
BLUE, ORANGE, GREEN, VERMILION, PURPLE, SKY, BLACK, GREY = (
    "#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7", "#56B4E9", "#222222", "#8A8A8A")
MARKS = "osD^vPXh"
APART = 0.009  # of alpha: curves that lie on each other stand side by side
WIDTH = 8.2  # inches
LOOK = {**STYLE, "figure.dpi": 110, "font.size": 9, "legend.fontsize": 8, "lines.markersize": 4, "lines.linewidth": 1.2}


def figures() -> dict[str, Callable[[Collected], Picture]]:
    return {"known": draw_known, "runs": draw_runs, "skewness": draw_skewness, "fitted": draw_fitted,
            "estimates": draw_estimates, "robust": draw_robust}


def _panels(count: int, height: float, **options: Any) -> tuple[Picture, np.ndarray]:
    return plt.subplots(1, count, figsize=(WIDTH, height), layout="constrained", **options)


def _plain_logarithm(axis: Any, ticks: Sequence[float]) -> None:
    axis.set_yscale("log")
    axis.yaxis.set_major_locator(FixedLocator(ticks))
    axis.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.yaxis.set_minor_locator(NullLocator())


def _points(axis: Any, x: np.ndarray, made: Sequence[scores.Figure], **options: Any) -> None:
    """With bars of two standard errors"""
    values, errors = np.array([one.value for one in made]), np.array([one.error for one in made])
    low = np.minimum(2 * errors, 0.95 * values)  # a logarithmic axis has no 0
    axis.errorbar(x, values, (low, 2 * errors), capsize=1.5, elinewidth=0.8, **options)


# ------------------------------------------------------------------------------ known parameters


METRIC_LOOKS = {("RMSE", EVEN): (VERMILION, "s", "-"), ("MAE", EVEN): (BLUE, "o", "-"),
                ("RMSE", QUIET): (ORANGE, "D", "--"), ("MAE", QUIET): (SKY, "^", "--")}


def draw_known(c: Collected) -> Picture:
    with plt.rc_context(LOOK):
        picture, (grown, compared) = _panels(2, 3.8)
        alphas = c.alphas("known")
        for (metric, ratio), (colour, mark, style) in METRIC_LOOKS.items():
            look = {"color": colour, "marker": mark, "ls": style, "label": f"{metric}, Q/R = {ratio:g}"}
            of = [c.of("known", ratio, alpha) for alpha in alphas]
            _points(grown, alphas, [scores.relative(one, of[-1], "filter", metric) for one in of], **look)
            _points(compared, alphas, [scores.relative(one, one, "smoother", metric, "filter") for one in of], **look)
        _draw_population(grown, compared)
        _plain_logarithm(grown, (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000))
        grown.set_ylim(0.8, 5000)
        grown.set(title="The filter's error / that at alpha = 2", xlabel="alpha (2: Gaussian)", ylabel="ratio")
        compared.axhline(1, color=BLACK, lw=0.6)
        compared.set(title="The smoother's error / the filter's: below 1, it gains", xlabel="alpha (2: Gaussian)")
        picture.legend(*grown.get_legend_handles_labels(), loc="outside lower center", ncols=3)
        return picture


def _draw_population(grown: Any, compared: Any) -> None:
    at = np.linspace(1.1, 2, 46)
    for setting, colour, style in zip(SETTINGS, (BLACK, GREY), (":", "-.")):
        filter_, smoother = (np.array([population.mean_size(setting, kind, alpha) for alpha in at])
                             for kind in ("filter", "smoother"))
        for axis, values in ((grown, filter_ / filter_[-1]), (compared, smoother / filter_)):
            axis.plot(at, values, color=colour, lw=1.1, ls=style, zorder=5,
                      label=f"MAE of the population, Q/R = {setting.ratio:g}")


def draw_runs(c: Collected) -> Picture:
    """RMSE and MAE of the first so many runs"""
    with plt.rc_context(LOOK):
        picture, axes = _panels(2, 3.1, sharey=True)
        wanted = [claims.nearest(c.alphas("known"), alpha) for alpha in (1.3, 1.5, 1.7, 2.0)]
        for axis, metric, column in zip(axes, METRICS, ("square", "size")):
            for alpha, colour, style in zip(wanted, (VERMILION, ORANGE, GREEN, BLUE), ("-", "--", "-.", ":")):
                values = c.of("known", EVEN, alpha)[f"filter_{column}"]
                count = np.arange(1, len(values) + 1)
                running = np.cumsum(values) / count
                shown = count >= 10
                axis.plot(count[shown], (np.sqrt(running) if metric == "RMSE" else running)[shown], color=colour,
                          ls=style, label=f"alpha = {alpha:g}")
                if metric == "MAE" and alpha > 1:
                    axis.axhline(population.mean_size(SETTINGS[0], "filter", alpha), color=colour, lw=0.6, alpha=0.7)
            axis.set(xlabel="runs", xscale="log", title=metric + (
                ": jumps up at each larger jump" if metric == "RMSE" else ": goes to the population's (thin lines)"))
        _plain_logarithm(axes[0], (0.5, 1, 2, 5, 10, 20, 50))
        axes[0].set_ylabel("filter's error, Q/R = 2")
        axes[0].legend()
        return picture


def draw_skewness(c: Collected) -> Picture:
    with plt.rc_context(LOOK):
        picture, axes = _panels(2, 3.2, sharey=True)
        alpha = claims.SKEWED
        sizes = c.betas()[c.betas() > 0]
        for axis, setting in zip(axes, SETTINGS):
            for kind, colour, mark in zip(("filter", "smoother"), (BLUE, VERMILION), "os"):
                at = np.linspace(0, 1, 21)
                exact = [population.mean_size(setting, kind, alpha, beta) for beta in at]
                axis.plot(at, np.array(exact) / exact[0], color=colour, lw=1, label=f"{kind}, population")
                made = [claims.skewed(c, setting.ratio, alpha, beta, kind) for beta in sizes]
                _points(axis, sizes + (0.008 if kind == "smoother" else -0.008), made, color=colour, marker=mark, ls="",
                        label=f"{kind}, drawn, ± 2 standard errors")
            axis.set(xlabel="|beta|", title=f"Q/R = {setting.ratio:g}, alpha = {alpha:g}")
        axes[0].set_ylabel("MAE / that at beta = 0")
        axes[0].legend(loc="upper left")
        return picture


# ------------------------------------------------------------------------------ fitted parameters

FITTED = {"known": (BLACK, "-"), "EM of Q": (BLUE, "-"), "EM of Q, R": (SKY, "--"), "ML of Q, R": (GREEN, "-."),
          "EM of all six": (VERMILION, "-"), "ML of all six": (PURPLE, "-."),
          "ML of all six from c = 2": (GREY, ":"), "ML of H, Q, R": (ORANGE, "--")}


def draw_fitted(c: Collected) -> Picture:
    with plt.rc_context(LOOK):
        picture, axes = _panels(2, 5.2)
        alphas = c.alphas("fitted")[c.alphas("fitted") > 1.05]
        for axis, kind, title in zip(axes, ("filter", "measured"), (
                "of x: whoever frees c has no unit", "of c x: what the data determine")):
            for k, ((name, (colour, style)), mark) in enumerate(zip(FITTED.items(), MARKS)):
                made = [c.beside_gaussian("fitted", EVEN, alpha, name, "MAE", kind) for alpha in alphas]
                _points(axis, alphas + APART * (k - (len(FITTED) - 1) / 2), made, color=colour, marker=mark, ls=style,
                        lw=0.8, mfc="white" if k % 2 else colour, label=name)
            axis.set(xlabel="alpha (2: Gaussian), side by side", title=f"Error {title}")
        _plain_logarithm(axes[0], (1, 2, 5, 10, 30, 100, 300, 1000, 3000, 10_000, 30_000))
        _plain_logarithm(axes[1], (1, 1.2, 1.5, 2, 3, 4, 5))
        axes[0].set_ylabel("filter's MAE / Gaussian case, Q/R = 2")
        picture.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
        return picture


def draw_estimates(c: Collected) -> Picture:
    with plt.rc_context(LOOK):
        picture, axes = _panels(3, 3.2)
        alphas = c.alphas("fitted")
        for axis, (column, what) in zip(axes, (("Q", "estimate of Q"), ("P", "variance P after a measurement"),
                                                  ("K", "weight K of a measurement"))):
            for name, colour, mark, style, aside in (("EM of Q", BLUE, "o", "-", -APART),
                                                     ("EM of Q, R", VERMILION, "s", "--", APART)):
                quartiles = np.array([np.quantile(c.of("fitted", EVEN, alpha, name)[column], (0.25, 0.5, 0.75))
                                      for alpha in alphas]).T
                axis.fill_between(alphas, quartiles[0], quartiles[2], color=colour, alpha=0.15, lw=0)
                for edge in quartiles[[0, 2]]:
                    axis.plot(alphas, edge, color=colour, ls=style, lw=0.6)
                axis.plot(alphas + aside, quartiles[1], color=colour, marker=mark, ls=style, lw=0.9, label=name,
                          mfc=colour if aside < 0 else "white")
            axis.axhline(_given(column), color=BLACK, lw=0.9, ls=":", label="of the Gaussian given")
            axis.set(xlabel="alpha", title=what)
        _plain_logarithm(axes[0], (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000))
        _plain_logarithm(axes[1], (0.2, 0.5, 1, 2, 5, 10, 20, 50))
        picture.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
        return picture


def _given(column: str) -> float:
    weight = population.settled_weight(SETTINGS[0])
    return {"Q": SETTINGS[0].ratio, "P": weight, "K": weight}[column]  # R = 1: P = K R


# ------------------------------------------------------------------------------ robust steps

ROBUST = {"plain": (BLACK, "-"), "gate": (SKY, "--"), "Huber": (PURPLE, "--"), "Student-t update": (ORANGE, "--"),
          "jump": (GREEN, "-"), "reweighted": (BLUE, "-"), "reweighted, 12 passes": (VERMILION, "--")}
LEAST_SHOWN = 0.05  # per cent


def draw_robust(c: Collected) -> Picture:
    with plt.rc_context(LOOK):
        picture, axes = plt.subplots(2, 2, figsize=(WIDTH, 6.8), layout="constrained", sharex=True, sharey=True)
        for row, kind in zip(axes, ("filter", "smoother")):
            for axis, ratio in zip(row, (EVEN, QUIET)):
                _draw_above_exact(axis, c, kind, ratio)
            row[0].set_ylabel("MAE above the exact mean's, %")
        picture.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=4, title="filters")
        axes[1, 1].legend(loc="upper right", title="smoothers")
        for axis in axes[1]:
            axis.set_xlabel("alpha (2: Gaussian)")
        return picture


def _draw_above_exact(axis: Any, c: Collected, kind: str, ratio: float) -> None:
    alphas = c.alphas("robust")
    names = [name for name in c.estimators("robust", kind) if name != "exact"]
    for k, (name, mark) in enumerate(zip(names, MARKS)):
        above = np.array([100 * (c.beside_exact(ratio, alpha, name, "MAE", kind).value - 1) for alpha in alphas])
        colour, style = ROBUST[name]
        axis.plot(alphas, np.where(above > LEAST_SHOWN, above, np.nan), color=colour, ls=style, marker=mark, label=name,
                  mfc="white" if k % 2 else colour)
    axis.set_title(f"{kind}, Q/R = {ratio:g}")
    _plain_logarithm(axis, (0.1, 0.3, 1, 3, 10, 30, 100, 300, 1000, 3000))
    axis.set_ylim(LEAST_SHOWN, 10_000)
