"""Extended filters and smoothers in q31 beside those in double.

    test_nonlinear_q31.py LIBRARY [RUNS]

LIBRARY: kalmanq as a shared library.  RUNS: of each model (5).  Jacobians, increments and innovations are
made in double at the mean of the words, and rounded to words.  Answers 0 where the median of the worst step of each
run is within its limit, in sigma.
"""
from __future__ import annotations

import ctypes
import sys

import numpy as np

from nonlinear_models import (Battery, CoordinatedTurn, FallingBody, GpsImu, RangeBearing,
                              linearise_extended, run)
from shared_library import Library
from test_nonlinear import Run, off

POINTER, INT = ctypes.c_void_p, ctypes.c_int32
FRACTION_BEST = 1000  # KQ_FRACTION_BEST_Q31


class ProcessTable(ctypes.Structure):
    _fields_ = [("states", INT), ("controls", INT), ("state_format", POINTER), ("control_format", POINTER),
                ("transition", POINTER), ("control", POINTER), ("noise_root", POINTER)]


class SensorTable(ctypes.Structure):
    _fields_ = [("states", INT), ("components", INT), ("correlated", INT), ("state_format", POINTER),
                ("measurement_format", POINTER), ("measurement", POINTER), ("noise", POINTER)]


class PriorTable(ctypes.Structure):
    _fields_ = [("states", INT), ("state_format", POINTER), ("mean", POINTER), ("root", POINTER)]


def doubles(a):
    return np.ascontiguousarray(a, dtype=np.float64)


def formats(library, ranges):
    made = library.words(2 * len(ranges))
    for k, most in enumerate(ranges):
        library.call("format_prepare", made[2 * k:], FRACTION_BEST, ctypes.c_double(most), None)
    return made


def rounded(x, formats):
    """Words; an increment has no declared range."""
    return np.round(np.ldexp(np.real(x), formats[1::2])).astype(np.int32)


class Words(Run):
    """A run of a model in q31: the ranges of the states and of the innovations are given."""

    def __init__(self, path, model, state_range, innovation_range):
        library = Library(path, "q31")
        self.state, self.seen = (formats(library, ranges) for ranges in (state_range, innovation_range))
        super().__init__(library, model)

    def make_model(self):
        k, n, m, model = self.k, self.n, self.m, self.model
        root, noise, start = k.words(n * (n + 3)), k.words(2 * m * (m + 1)), k.words(n * (n + 3))
        k.call("root_prepare", root, doubles(model.Q), n, self.state)
        k.call("noise_prepare", noise, doubles(model.R), m, self.seen)
        k.call("root_prepare", start, doubles(model.P0), n, self.state)
        self.A, self.H, mean = self.matrix(np.eye(n), self.state), k.words(2 * m * n), self.increment(model.x0)
        tables = (ProcessTable(n, 0, *map(k.argument, (self.state, None, self.A, None, root))),
                  SensorTable(n, m, 1, *map(k.argument, (self.state, self.seen, self.H, noise))),
                  PriorTable(n, *map(k.argument, (self.state, mean, start))))
        self.process, self.sensor = (np.zeros(512, dtype=np.uint8) for _ in range(2))
        names = ("process_init", "sensor_init_extended", "filter_init")
        for name, item, table in zip(names, (self.process, self.sensor, self.filter), tables):
            k.call(name, item, ctypes.byref(table), None)
        k.kept += tables

    def matrix(self, M, rows):
        """The table of what makes `rows` of states"""
        table = self.k.words(2 * M.size)
        self.k.call("matrix_prepare", table, doubles(M), M.shape[0], M.shape[1], rows, self.state)
        return table

    def change_process(self, A):
        self.A = self.matrix(A, self.state)
        self.k.call("process_change_jacobian", self.process, self.A, None)

    def change_sensor(self, H):
        self.H = self.matrix(H, self.seen)
        self.k.call("sensor_change_measurement", self.sensor, self.H, None)

    def increment(self, d):
        return rounded(d, self.state)

    def innovation(self, e):
        return rounded(e, self.seen)

    def mean(self, of=None):
        of = self.filter if of is None else of
        words = [self.k.read("mean", of, i) + np.ldexp(self.k.read("mean_low", of, i), -24) for i in range(self.n)]
        return np.ldexp(words, -self.state[1::2])

    def covariance(self, name, *at):
        """Not compared"""


# model; ranges of states and of innovations; limit in sigma
CASES = [
    (RangeBearing, [1000, 1000, 50, 50], [1000, 500], 2e-5),
    (Battery, [2, 1], [8], 2e-5),
    (GpsImu, [4000, 4000, 60, 40, 1, 0.1], [4000, 4000], 5e-5),
    (FallingBody, [4e5, 3e4, 0.1], [4e5], 4e-4),
    (CoordinatedTurn, [60000, 2000, 60000, 2000, 1], [60000, 500], 3e-4),
]


def main():
    runs, faults = int(sys.argv[2]) if len(sys.argv) > 2 else 5, 0
    for make, states, innovations, limit in CASES:
        model, worst = make(), []
        for seed in range(runs):
            _, z = model.simulate(np.random.default_rng(seed))
            ours = Words(sys.argv[1], model, states, innovations).run(z, "step_extended")
            reference = run(model, z, linearise_extended)
            worst.append([off(a, b) for a, b in zip(ours, reference)])
        median, most = np.median(worst, axis=0), np.max(worst, axis=0)
        good = bool(np.all(median <= limit))
        print(f"{make.__name__:16}q31  filter: {median[0]:.1e} sigma (worst {most[0]:.1e}), smoother: {median[1]:.1e} "
              f"(worst {most[1]:.1e})" + ("" if good else "  BEYOND ITS LIMIT"), flush=True)
        faults += not good
    print("FAIL" if faults else "OK")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
