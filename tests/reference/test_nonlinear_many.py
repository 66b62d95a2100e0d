"""Campaigns of the nonlinear models: the figures of a few runs are noise.

    test_nonlinear_many.py LIBRARY [RUNS]

RUNS of each (200).  The library in f64 and f32 beside nonlinear_models.py: the same RMS and NEES, and no run is lost
that the reference keeps.  The RMS beside those of another program over 200 runs of its own.  A very sharp sensor, with
and without iteration.  Answers 0 where all is within its limits; prints what it has measured.
"""
from __future__ import annotations

import sys

import numpy as np

from nonlinear_models import CoordinatedTurn, FallingBody, UnivariateGrowth, linearise_cubature, linearise_extended, run
from test_nonlinear import Library, Run, compare_sharp, nees, squares

EXTENDED, POINTS = ("step_extended", linearise_extended), ("step_points", linearise_cubature)
# A run is lost where its error of position in the second half is larger; the other program's RMS of filter and smoother
CASES = [
    (CoordinatedTurn, EXTENDED, 1000, (32.7, 20.3)),
    (CoordinatedTurn, POINTS, 1000, (18.63, 10.54)),
    (FallingBody, EXTENDED, 10000, (359, 459)),
    (FallingBody, POINTS, 10000, (202.5, 73.0)),
    (UnivariateGrowth, EXTENDED, np.inf, (22.4, 18.9)),
    (UnivariateGrowth, POINTS, np.inf, (13.65, 13.9)),
]
SAME_RMS, SAME_NEES = 0.005, 0.05
# Rounding leads a run of two minds to the other one: only the RMS is that of the reference, but for its standard error.
OF_TWO_MINDS = UnivariateGrowth


def summary(values) -> tuple[float, float]:
    """The root of the mean of a run's squares, and its standard error"""
    root = np.sqrt(np.mean(values))
    return root, np.std(values) / np.sqrt(len(values)) / (2 * root)


class Campaign:
    """What a program has found: [filter, smoother] of each run"""

    def __init__(self, model, truth, results, limit):
        half = model.steps // 2
        self.squares = np.array([[squares(states, s, model.position) for states in both]
                                 for both, s in zip(results, truth)])
        self.nees = np.array([[nees(states, s) for states in both] for both, s in zip(results, truth)])
        second = [squares(both[0][half:], s[half:], model.position) for both, s in zip(results, truth)]
        self.lost = {k for k, value in enumerate(second) if not value < limit ** 2}


def beside_reference(ours, reference, kind, is_of_two_minds) -> tuple[str, bool]:
    kept = [k for k in range(len(ours.squares)) if k not in reference.lost]
    (mine, error), (theirs, _) = (summary(c.squares[kept, kind]) for c in (ours, reference))
    scores = [c.nees[kept, kind].mean() for c in (ours, reference)]
    if is_of_two_minds:
        good = abs(mine - theirs) <= 2 * error
    else:
        good = abs(mine / theirs - 1) <= SAME_RMS and abs(scores[0] / scores[1] - 1) <= SAME_NEES
    return f"RMS {mine:.5g} ({theirs:.5g}), NEES/n {scores[0]:.4g} ({scores[1]:.4g})", bool(good)


def beside_published(campaign, kind, figure) -> tuple[str, bool]:
    """Both are of as many runs: the difference has root 2 times the standard error."""
    mine, error = summary(campaign.squares[:, kind])
    distance = (mine - figure) / (np.sqrt(2) * error)
    return f"RMS {mine:.5g} +- {error:.2g}, published {figure}: {distance:+.1f} standard errors", abs(distance) <= 2


def told(title, line, good) -> int:
    print(f"{title:42} {line}" + ("" if good else "  BEYOND ITS LIMIT"), flush=True)
    return not good


def compare(path, case, runs) -> int:
    make, (step, linearise), limit, figures = case
    model, title = make(), f"{make.__name__} {step[5:]}"
    given = [model.simulate(np.random.default_rng(seed)) for seed in range(runs)]
    truth = [states for states, _ in given]
    reference = Campaign(model, truth, [run(model, z, linearise) for _, z in given], limit)
    faults = 0
    for arithmetic in ("f64", "f32"):
        library = Library(path, arithmetic)
        ours = Campaign(model, truth, [Run(library, model).run(z, step) for _, z in given], limit)
        for kind, name in enumerate(("filter", "smoother")):
            faults += told(f"{title} {arithmetic} {name}", *beside_reference(ours, reference, kind, make is OF_TWO_MINDS))
        faults += told(f"{title} {arithmetic}", f"lost {len(ours.lost)} of {runs}, reference {len(reference.lost)}",
                       ours.lost <= reference.lost)
    for kind, name in enumerate(("filter", "smoother")):
        faults += told(f"{title} {name}", *beside_published(reference, kind, figures[kind]))
    return faults


def main():
    runs = int(sys.argv[2]) if len(sys.argv) > 2 else 200
    faults = sum(compare(sys.argv[1], case, runs) for case in CASES)
    faults += compare_sharp(sys.argv[1], runs)
    print("FAIL" if faults else "OK")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
