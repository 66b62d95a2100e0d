"""Campaigns of the nonlinear models: the figures of a few runs are noise.

    test_nonlinear_many.py LIBRARY CoordinatedTurn|FallingBody|UnivariateGrowth|sharp [RUNS]

RUNS (200).  The library in f64 and f32 beside nonlinear_models.py: the same RMS and NEES, and no run is lost that the
reference keeps.  The reference's RMS, and that of an iterated smoother, beside those of another program.  sharp: a very
sharp sensor, with and without iteration.  Answers 0 where all is within its limits; prints what it has measured.
"""
from __future__ import annotations

import collections
import sys

import numpy as np

from nonlinear_models import (CoordinatedTurn, FallingBody, UnivariateGrowth, chance_band, linearise_cubature,
                              linearise_extended, run)
from test_nonlinear import Iterated, Library, Run, compare_sharp, nees, squares

EXTENDED, POINTS = ("step_extended", linearise_extended), ("step_points", linearise_cubature)
# The other program's RMS over 200 runs of its own: filter and smoother; six passes of the posterior linearisation
# smoother, and the cubature smoother's that it is divided by, where the same runs are good and bad for both (of the
# falling body that is not so).  A run is lost where its error of position in the second half is beyond the limit.
Case = collections.namedtuple("Case", "make limit extended points passes")
CASES = [
    Case(CoordinatedTurn, 1000, (32.7, 20.3), (18.63, 10.54), (9.78, 10.54)),
    Case(FallingBody, 10000, (359, 459), (202.5, 73.0), (46.5, None)),
    Case(UnivariateGrowth, np.inf, (22.4, 18.9), (13.65, 13.9), None),
]
PUBLISHED_RUNS = 200
SAME_RMS, SAME_NEES, MAY_BE_LOST = 0.005, 0.05, 0.005


def summary(values) -> tuple[float, float]:
    """The root of the mean of a run's squares, and its standard error"""
    root = np.sqrt(np.mean(values))
    return root, np.std(values) / np.sqrt(len(values)) / (2 * root)


def given(model, runs):
    """Truth and measurements of each run"""
    return [model.simulate(np.random.default_rng(seed)) for seed in range(runs)]


class Campaign:
    """What a program has found: squares and NEES of filter and smoother, a row for each run that is not lost"""

    def __init__(self, case, data, find):
        model, half = case.make(), case.make().steps // 2
        rows = {}
        for k, (truth, z) in enumerate(data):
            both = find(z)
            second = squares(both[0][half:], truth[half:], model.position) if both else np.nan
            if second < case.limit ** 2:
                rows[k] = [[squares(states, truth, model.position), nees(states, truth)] for states in both]
        self.kept, self.lost = list(rows), len(data) - len(rows)
        self.squares, self.nees = np.transpose(list(rows.values()), (2, 1, 0))


def of_reference(model, linearise):
    """None where a state has left the numbers"""
    def find(z):
        try:
            with np.errstate(all="ignore"):
                return run(model, z, linearise)
        except np.linalg.LinAlgError:
            return None
    return find


def beside_reference(ours, reference, kind) -> tuple[str, bool]:
    mine, theirs = (np.sqrt(np.mean(c.squares[kind])) for c in (ours, reference))
    scores = [c.nees[kind].mean() for c in (ours, reference)]
    good = abs(mine / theirs - 1) <= SAME_RMS and abs(scores[0] / scores[1] - 1) <= SAME_NEES
    return f"RMS {mine:.5g} ({theirs:.5g}), NEES/n {scores[0]:.4g} ({scores[1]:.4g})", bool(good)


def beside_published(found, runs, figure) -> tuple[str, bool]:
    """`found` and its standard error are of `runs`, the other program's figure has that of its own."""
    mine, error = found
    distance = (mine - figure) / (error * np.sqrt(1 + runs / PUBLISHED_RUNS))
    line = f"{mine:.5g} +- {error:.2g} in {runs} runs, published {figure:.5g}: {distance:+.1f} standard errors"
    return "RMS " + line, bool(abs(distance) <= 2)


def told(title, line, good) -> int:
    print(f"{title:42} {line}" + ("" if good else "  BEYOND ITS LIMIT"), flush=True)
    return not good


def compare_library(path, case, method, runs) -> int:
    """The library beside the reference, in the runs that the reference keeps"""
    step, linearise = method
    model, faults = case.make(), 0
    data = given(model, runs)
    reference = Campaign(case, data, of_reference(model, linearise))
    data = [data[k] for k in reference.kept]
    for arithmetic in ("f64", "f32"):
        library, title = Library(path, arithmetic), f"{case.make.__name__} {step[5:]} {arithmetic}"
        ours = Campaign(case, data, lambda z: Run(library, model).run(z, step))
        faults += told(title, f"lost {ours.lost} of the {len(data)} that the reference keeps of {runs}", not ours.lost)
        for kind, name in enumerate(("filter", "smoother")):
            faults += told(f"{title} {name}", *beside_reference(ours, reference, kind))
    return faults


def compare_published(case, method, figures, runs) -> int:
    """The reference beside the other program, which has lost no run"""
    step, linearise = method
    model = case.make()
    found = Campaign(case, given(model, runs), of_reference(model, linearise))
    title = f"{case.make.__name__} {step[5:]}"
    faults = told(title, f"lost {found.lost} of {runs}", found.lost <= MAY_BE_LOST * runs)
    for kind, name in enumerate(("filter", "smoother")):
        ours = summary(found.squares[kind])
        faults += told(f"{title} {name}", *beside_published(ours, len(found.kept), figures[kind]))
    return faults


def ratio_of(values, divisors) -> tuple[float, float]:
    """The RMS of values by that of divisors, of the same runs, and its standard error"""
    ratio = np.sqrt(np.mean(values) / np.mean(divisors))
    parts = np.divide(values, np.mean(values)) - np.divide(divisors, np.mean(divisors))
    return ratio, ratio / 2 * np.std(parts) / np.sqrt(len(parts))


def compare_passes(path, case, runs) -> int:
    model, library, after, scores = case.make(), Library(path, "f64"), [], []
    data, (figure, divisor) = given(model, runs), case.passes
    reference = Campaign(case, data, of_reference(model, linearise_cubature))
    for states, z in (data[k] for k in reference.kept):
        smoothed = Iterated(library, model).passes(z, 6)
        after.append(squares(smoothed, states, model.position))
        scores.append(nees(smoothed, states))
    line, good = beside_published(summary(after), len(after), figure)
    if divisor:
        ratio, good = beside_published(ratio_of(after, reference.squares[1]), len(after), figure / divisor)
        line += "; of the cubature smoother's: " + ratio
    low, high = chance_band(len(model.x0) * len(after))
    return told(f"{case.make.__name__} six passes f64", f"{line}, NEES/n {np.mean(scores):.3f}",
                good and low < np.mean(scores) < high)


def compare(path, case, runs) -> int:
    faults = 0
    for method, figures in ((EXTENDED, case.extended), (POINTS, case.points)):
        faults += compare_library(path, case, method, runs) + compare_published(case, method, figures, 5 * runs)
    return faults + (compare_passes(path, case, runs) if case.passes else 0)


def main():
    path, what = sys.argv[1:3]
    runs = int(sys.argv[3]) if len(sys.argv) > 3 else 200
    if what == "sharp":
        faults = compare_sharp(path, runs, near=0.05)
    else:
        faults = sum(compare(path, case, runs) for case in CASES if case.make.__name__ == what)
    print("FAIL" if faults else "OK")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
