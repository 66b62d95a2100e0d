#!/usr/bin/env python3
"""Draws a run of an example: filter and smoother against the truth, and their errors with 3 sigma.

    PROGRAM SEED | plot.py PICTURE.png [TITLE]
"""
from __future__ import annotations

import sys

import numpy as np

KINDS = {"filtered": "tab:orange", "smoothed": "tab:blue"}


def read_run(lines) -> dict[str, np.ndarray]:
    """The columns of the CSV by their names"""
    names, *rows = [line.strip() for line in lines]
    table = np.loadtxt(rows, delimiter=",", ndmin=2)
    if table.shape[1] != len(names.split(",")):
        raise ValueError("the rows have not as many columns as the titles")
    return dict(zip(names.split(","), table.T))


def quantities(run: dict[str, np.ndarray]) -> list[str]:
    return [name.removesuffix("_truth") for name in run if name.endswith("_truth")]


def draw_estimates(axes, run, name):
    for kind, colour in KINDS.items():
        mean, sigma = run[f"{name}_{kind}"], run[f"{name}_{kind}_sigma"]
        axes.fill_between(run["time"], mean - 3 * sigma, mean + 3 * sigma, color=colour, alpha=0.25, lw=0)
        axes.plot(run["time"], mean, color=colour, lw=1, label=kind)
    axes.plot(run["time"], run[f"{name}_truth"], color="black", lw=0.8, label="truth")
    show_after_start(axes, run, run[f"{name}_truth"], run[f"{name}_filtered_sigma"])
    axes.set_ylabel(name)


def draw_errors(axes, run, name):
    for kind, colour in KINDS.items():
        sigma = run[f"{name}_{kind}_sigma"]
        axes.fill_between(run["time"], -3 * sigma, 3 * sigma, color=colour, alpha=0.25, lw=0)
        axes.plot(run["time"], run[f"{name}_{kind}"] - run[f"{name}_truth"], color=colour, lw=1)
    show_after_start(axes, run, np.zeros(len(run["time"])), run[f"{name}_filtered_sigma"])


def show_after_start(axes, run, centre, sigma):
    """The scale is that of the run: a start of which little is known may leave the picture."""
    settled = 5 * np.median(sigma)
    axes.set_ylim(min(centre) - settled, max(centre) + settled)
    axes.set_xlim(run["time"][0], run["time"][-1])
    axes.grid(alpha=0.3)


def draw(run, path, title=""):
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    names = quantities(run)
    figure, axes = plt.subplots(len(names), 2, figsize=(11, 1 + 1.9 * len(names)), sharex=True, squeeze=False)
    for name, (left, right) in zip(names, axes):
        draw_estimates(left, run, name)
        draw_errors(right, run, name)
    axes[0, 0].set_title("estimate, 3 sigma, and truth")
    axes[0, 1].set_title("error and 3 sigma")
    axes[0, 0].legend(loc="best", fontsize="small", ncol=3)
    for bottom in axes[-1]:
        bottom.set_xlabel("time, s")
    figure.suptitle(title)
    figure.tight_layout()
    figure.savefig(path, dpi=90)


def main():
    if not 2 <= len(sys.argv) <= 3:
        sys.exit(__doc__.strip())
    lines = sys.stdin.readlines()
    if len(lines) < 2:
        sys.exit("plot.py: the input has no rows")
    try:
        draw(read_run(lines), sys.argv[1], *sys.argv[2:])
    except KeyError as missing:
        sys.exit(f"plot.py: the input has no column {missing}")
    except (OSError, ValueError) as error:
        sys.exit(f"plot.py: {error}")


if __name__ == "__main__":
    main()
