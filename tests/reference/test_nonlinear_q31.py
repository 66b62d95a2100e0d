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

from nonlinear_models import (Battery, CoordinatedTurn, FallingBody, GpsImu, RangeBearing, jacobian,
                              linearise_extended, run, wrapped)
from test_nonlinear import off

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


class Words:
    """A run of a model in q31: the ranges of the states and of the innovations are given."""

    def __init__(self, path, model, state_range, innovation_range):
        self.all, self.model, self.n, self.m = ctypes.CDLL(path), model, len(model.x0), len(model.R)
        self.state, self.seen = self.formats(state_range), self.formats(innovation_range)
        n, m = self.n, self.m
        noise, root = self.words(2 * m * (m + 1)), self.words(n * (n + 3))
        self.call("root_prepare", root, self.doubles(model.Q), n, self.state)
        self.call("noise_prepare", noise, self.doubles(model.R), m, self.seen)
        self.A, self.H = self.matrix(np.eye(n), self.state, self.state), self.words(2 * m * n)
        self.kept = [root, noise, ProcessTable(n, 0, *map(self.at, (self.state, None, self.A, None, root))),
                     SensorTable(n, m, 1, *map(self.at, (self.state, self.seen, self.H, noise)))]
        self.process, self.sensor, self.filter = (np.zeros(512, dtype=np.uint8) for _ in range(3))
        self.call("process_init", self.process, ctypes.byref(self.kept[2]), None)
        self.call("sensor_init_extended", self.sensor, ctypes.byref(self.kept[3]), None)
        self.begin()

    def begin(self):
        n, steps = self.n, self.model.steps
        mean, root = self.words(n), self.words(n * (n + 3))
        self.call("vector_prepare", mean, self.doubles(self.model.x0), n, self.state, None)
        self.call("root_prepare", root, self.doubles(self.model.P0), n, self.state)
        prior, memory = PriorTable(n, *map(self.at, (self.state, mean, root))), self.words(1000)
        self.call("filter_assign", self.filter, n, memory, 1000)
        self.call("filter_init", self.filter, ctypes.byref(prior), None)
        self.tape, tape = np.zeros(256, dtype=np.uint8), self.words(600 * steps + 9000)
        self.call("history_assign", self.tape, n, tape, len(tape))
        self.jacobians, processes = np.zeros(256, dtype=np.uint8), np.zeros(256 * steps, dtype=np.uint8)
        room = self.words(2 * n * n * steps + 1000)
        self.call("jacobians_assign", self.jacobians, self.tape, n, processes, steps, room, len(room))
        self.call("attach", self.filter, self.jacobians)  # `attached` comes first
        self.kept += [memory, tape, processes, room]

    def call(self, name, *arguments):
        arguments = [self.at(a) if isinstance(a, np.ndarray) else ctypes.c_size_t(a) if isinstance(a, int) else a
                     for a in arguments]
        status = getattr(self.all, f"kq_{name}_q31")(*arguments)
        if status:
            raise SystemExit(f"kq_{name}_q31 answers {status}")

    def at(self, a):
        return None if a is None else a.ctypes.data_as(POINTER)

    def words(self, count):
        return np.zeros(count, dtype=np.int32)

    def doubles(self, a):
        self.last = np.ascontiguousarray(np.real(a), dtype=np.float64)
        return self.last

    def formats(self, ranges):
        formats = self.words(2 * len(ranges))
        for k, most in enumerate(ranges):
            self.call("format_prepare", formats[2 * k:], FRACTION_BEST, ctypes.c_double(most), None)
        return formats

    def matrix(self, M, rows, columns):
        table = self.words(2 * M.size)
        self.call("matrix_prepare", table, self.doubles(M), M.shape[0], M.shape[1], rows, columns)
        return table

    def vector(self, x, formats):
        """Words, rounded; an increment has no declared range"""
        return np.round(np.ldexp(np.real(x), formats[1::2])).astype(np.int32)

    def values(self, name, *at):
        function = getattr(self.all, f"kq_{name}_q31")
        return np.array([function(*at, i) for i in range(self.n)])

    def mean(self, name, item, *at):
        words = self.values(name, self.at(item), *at) + np.ldexp(self.values(name + "_low", self.at(item), *at), -24)
        return np.ldexp(words, -self.state[1::2])

    def step(self, z, t):
        model, x = self.model, self.mean("mean", self.filter)
        if t:
            A = jacobian(lambda y: model.increment(y, t - 1), x) + np.eye(self.n)
            self.A = self.matrix(A, self.state, self.state)
            self.call("process_change_jacobian", self.process, self.A, None)
            self.call("predict_extended", self.filter, self.process, self.vector(model.increment(x, t - 1), self.state))
            x = self.mean("mean", self.filter)
        if model.measures(t):
            self.H = self.matrix(jacobian(lambda y: model.h(y, t), x), self.seen, self.state)
            self.call("sensor_change_measurement", self.sensor, self.H, None)
            e = self.vector(wrapped(model, z - np.real(model.h(x, t))), self.seen)
            self.call("update", self.filter, self.sensor, e)

    def run(self, z):
        filtered = []
        for t in range(self.model.steps):
            self.step(z[t], t)
            filtered.append((self.mean("mean", self.filter), None))
        self.call("smooth", self.tape)
        return filtered, [(self.smoothed_mean(t), None) for t in range(self.model.steps)]

    def smoothed_mean(self, t):
        view = np.zeros(256, dtype=np.uint8)
        self.call("smoothed", self.tape, t, view)
        return self.mean("mean", view)


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
            ours, reference = Words(sys.argv[1], model, states, innovations).run(z), run(model, z, linearise_extended)
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
