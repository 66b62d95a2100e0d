#!/usr/bin/env python3
"""drift.py LOG PICTURE: draws the "drift" lines of a soak (tests/campaign/soak.cpp): largest errors between steps 2^k and 2^(k+1)."""

import sys

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt

lines = [line.split()[1:] for line in open(sys.argv[1]) if line.startswith("drift ")]
figure, axes = plt.subplots(1, 2, figsize=(9, 3.4), sharex=True, layout="constrained")
for at, (axis, title) in enumerate(zip(axes, ("mean, sigmas", "P, shares of variances"))):
    for name in ("f64", "f32", "q31"):
        points = [(2 ** int(k), float(errors[at])) for of, k, *errors in lines if of == name and float(errors[at]) > 0]
        if points:
            axis.loglog(*zip(*points), marker=".", base=10, label=name)
    axis.set(title=f"largest error of the {title}", xlabel="step")
    axis.legend()
figure.savefig(sys.argv[2])
