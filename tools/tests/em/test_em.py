"""EM against the textbook's in NumPy (reference.py), against pykalman, and against itself: its
likelihood never falls, its gradient is that of its likelihood.

    test_em.py --library FILE [--seed N] [--every K]      kalmanq as a shared library; of problems one in K
"""

from __future__ import annotations

import argparse
import ctypes
import functools
import sys
import unittest
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path

import numpy as np
from pykalman import KalmanFilter

import reference
from reference import DIAGONAL, FULL, MULTIPLE, NAMES, Choice, Parameters, Problem, Recording

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "tests" / "reference"))
from shared_library import Library  # noqa: E402

SHARED, ROOM = "", 1_000_000  # numbers of memory
NO_MAXIMUM = -20  # KQ_ERR_LIKELIHOOD
SEED = 1
EVERY = 1
GAP = np.nan
BITS = {"A": 1, "H": 2, "Q": 4, "R": 8, "x0": 16, "P0": 32}
COVARIANCES = ("Q", "R", "P0")
ITERATIONS = (1, 5, 50)
EPS = {"f64": 2.0**-53, "f32": 2.0**-24}


# ---------------------------------------------------------------- the library

class Model(ctypes.Structure):
    """kq_parameters_<T>"""
    _fields_ = [(name, ctypes.c_int32) for name in ("controls", "noises")] + [
        (name, ctypes.c_void_p) for name in ("A", "B", "F", "Q", "H", "R", "x0", "P0")]


class Recorded(ctypes.Structure):
    """kq_recording_<T>"""
    _fields_ = [("steps", ctypes.c_size_t)] + [(name, ctypes.c_void_p) for name in ("z", "present", "u")]


class Chosen(ctypes.Structure):
    """kq_em_choice"""
    _fields_ = [(name, ctypes.c_uint) for name in ("free", "Q_form", "R_form")] + [
        (name, ctypes.c_void_p) for name in ("A_held", "H_held")]


class Gradient(ctypes.Structure):
    """kq_gradient_<T>"""
    _fields_ = [(name, ctypes.c_void_p) for name in NAMES]


@dataclass
class Run:
    status: int
    likelihoods: np.ndarray
    changes: np.ndarray
    distances: np.ndarray
    path: dict[int, Parameters]
    final: float = np.nan
    gradient: dict[str, np.ndarray] = field(default_factory=dict)


class Em:
    """A problem with the library, before its first iteration"""

    def __init__(self, problem: Problem, arithmetic: str):
        self.k, self.problem = Library(SHARED, arithmetic), problem
        p, choice = problem.start, problem.choice
        self.arrays = {name: self.k.numbers(np.array(getattr(p, name))) for name in NAMES}
        sizes = [0 if M is None else M.shape[1] for M in (problem.B, problem.F)]
        model = Model(*sizes, **{name: self.address(array) for name, array in (
            *self.arrays.items(), ("B", problem.B), ("F", problem.F))})
        recordings = (Recorded * len(problem.recordings))(*map(self.recorded, problem.recordings))
        chosen = Chosen(sum(BITS[name] for name in choice.free), choice.Q_form, choice.R_form,
                        *(self.address(held, np.uint8) for held in (choice.A_held, choice.H_held)))
        self.k.kept += [model, recordings, chosen]
        self.em = ctypes.c_void_p(self.k.made("em", problem.n, problem.m, words=ROOM).ctypes.data)
        self.status = self.k.answer("em_init", self.em, ctypes.byref(model), None if choice.is_default else
                                    ctypes.byref(chosen), recordings, len(recordings))
        if self.status < 0:
            raise RuntimeError(f"em_init answers {self.status}")

    def address(self, array, number=None):
        if array is None:
            return None
        self.k.kept.append(np.ascontiguousarray(array, number or self.k.type))
        return self.k.kept[-1].ctypes.data

    def recorded(self, of: Recording) -> Recorded:
        there = ~np.isnan(of.z)
        present = None if there.all() else there @ (1 << np.arange(self.problem.m))
        return Recorded(len(of.z), self.address(of.z), self.address(present, np.uint16), self.address(of.u))

    def parameters(self) -> Parameters:
        return Parameters(**self.arrays)

    def expect(self) -> None:
        self.k.call("em_advance", self.em)
        while self.k.answer("em_remaining", self.em) > 0:
            self.k.call("em_advance", self.em)

    def iterate(self, slices: bool) -> bool:
        """False where the likelihood has no maximum that the arithmetic can go to"""
        if not slices:
            status = self.k.answer("em_iterate", self.em)
            if status not in (0, NO_MAXIMUM):
                raise RuntimeError(f"em_iterate answers {status}")
            return not status
        self.expect()
        self.k.call("em_maximise", self.em)
        return True

    def gradient(self) -> dict[str, np.ndarray]:
        asked = [name for name in NAMES if name in self.problem.choice.free or name in COVARIANCES]
        slopes = {name: np.zeros_like(self.arrays[name]) for name in asked}
        given = Gradient(**{name: array.ctypes.data for name, array in slopes.items()})
        self.k.call("em_gradient", self.em, ctypes.byref(given))
        return {name: array.astype(float) for name, array in slopes.items()}


def library(problem: Problem, iterations: int, arithmetic: str = "f64", *, tolerance: float = -1.0,
            slices: bool = False, final: bool = False, snapshots=()) -> Run:
    """snapshots: the iterations whose parameters are kept, None: all"""
    em, steps, path = Em(problem, arithmetic), [], {}

    def read(name: str) -> float:
        return em.k.read(name, em.em)

    for k in range(1, iterations + 1):
        if read("em_change") <= tolerance or not em.iterate(slices):
            break
        steps.append([read(name) for name in ("em_log_likelihood", "em_change", "em_distance")])
        if snapshots is None or k in snapshots:
            path[k] = em.parameters()
    run = Run(em.status, *np.array(steps).reshape(-1, 3).T, path)
    if final:
        em.expect()
        run.final, run.gradient = read("em_log_likelihood"), em.gradient()
    return run


# ---------------------------------------------------------------- problems

def some(problems) -> list:
    """The first of each EVERY"""
    return list(problems)[::EVERY]


def single(problem: Problem) -> Problem:
    """The nearest problem whose numbers are floats, so that f32 has the same one"""
    def rounded(array):
        return None if array is None else np.float32(array).astype(float)

    p = Parameters(*(rounded(getattr(problem.start, name)) for name in
                     Parameters.__dataclass_fields__))
    recordings = [Recording(rounded(recording.z), rounded(recording.u))
                  for recording in problem.recordings]
    return Problem(p, recordings, problem.choice, rounded(problem.B), rounded(problem.F))


def simulate(rng, truth: Parameters, steps: int, B=None, F=None) -> Recording:
    n, m = len(truth.A), len(truth.H)
    F = np.eye(n) if F is None else F
    u = None if B is None else rng.normal(size=(steps - 1, B.shape[1]))
    x, z = rng.multivariate_normal(truth.x0, truth.P0), np.empty((steps, m))
    for t in range(steps):
        z[t] = truth.H @ x + rng.multivariate_normal(np.zeros(m), truth.R)
        x = truth.A @ x + F @ rng.multivariate_normal(np.zeros(len(truth.Q)), truth.Q)
        if u is not None and t < steps - 1:
            x += B @ u[t]
    return Recording(z, u)


def with_gaps(recording: Recording) -> Recording:
    """Whole and, of two components, partial: at the start, at the end, in a row"""
    z = recording.z.copy()
    z[7:12] = z[30] = z[-1] = GAP
    if z.shape[1] > 1:
        z[0, 1] = z[15:20, 0] = z[25:45:2, 1] = z[50, 0] = GAP
    return replace(recording, z=z)


def rotation(angle: float, damping: float) -> np.ndarray:
    return damping * np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


AR1 = Parameters(0.8, 1, 0.5, 1, 2, 1)
OSCILLATOR = Parameters(rotation(0.5, 0.95), [[1, 0.3]], [[0.4, 0.1], [0.1, 0.2]], 0.8, [2, -1],
                        [[1, 0.2], [0.2, 2]])
SENSORS = Parameters([[0.9, 0.3], [-0.2, 0.7]], [[1, 0.2], [0.4, 1]], [[0.5, 0.1], [0.1, 0.3]],
                     [[1, 0.5], [0.5, 0.8]], [1, -1], [[1, 0.3], [0.3, 2]])
COMPANION = Parameters([[1.2, -0.5], [1, 0]], [[1, 0]], 0.6, 0.5, [1, 1], np.eye(2))
COLUMN = np.array([[1.0], [0.0]])


def away_from(p: Parameters) -> Parameters:
    """Where EM is to begin: not at the truth"""
    return replace(p, A=0.8 * p.A, H=p.H + 0.1, Q=2 * p.Q, R=1.5 * p.R, x0=p.x0 - 0.5, P0=3 * p.P0)


def make(truth: Parameters, steps: int, seed: int = 1, gaps=False, more=(), B=None, F=None,
         **choice) -> Problem:
    """`more`: lengths of the other recordings"""
    rng = np.random.default_rng(seed)
    recordings = [simulate(rng, truth, length, B, F) for length in (steps, *more)]
    if gaps:
        recordings[0] = with_gaps(recordings[0])
    start = away_from(truth)
    if choice.get("Q_form") == DIAGONAL:
        start.Q = np.diag(np.diag(start.Q))
    if choice.get("R_form") == DIAGONAL:
        start.R = np.diag(np.diag(start.R))
    if F is not None:
        start.A[1] = truth.A[1]
    return single(Problem(start, recordings, Choice(**choice), B, F))


@functools.cache
def cases() -> dict[str, Problem]:
    lower, corner = np.array([[0, 1], [0, 0]]), np.array([[1, 0]])
    push = np.array([[0.5, 0], [1, -0.7]])
    made = {"AR(1), Q and R": make(AR1, 120),
            "AR(1), all": make(AR1, 120, free=NAMES),
            "AR(1), all but H": make(AR1, 120, free=("A", "Q", "R", "x0", "P0")),
            "AR(1), gaps, all": make(AR1, 120, gaps=True, free=NAMES),
            "AR(1), control, all": make(AR1, 120, B=np.array([[0.7]]), free=NAMES),
            "AR(1), 3 recordings, all": make(AR1, 60, more=(30, 1), free=NAMES),
            "AR(1), one step each": make(AR1, 1, more=11 * (1,), free=("A", "Q", "R", "x0", "P0"))}
    for name, truth, gaps in (("oscillator", OSCILLATOR, False),
                              ("2 sensors, gaps", SENSORS, True)):
        held = {"A_held": lower, "H_held": np.eye(2) if gaps else corner}
        for title, given in {
                "Q and R": {},
                "all": {"free": NAMES},
                "A": {"free": ("A",)},
                "H and R": {"free": ("H", "R")},
                "x0 and P0": {"free": ("x0", "P0")},
                "all but A and H": {"free": ("Q", "R", "x0", "P0")},
                "P0, x0 known": {"free": ("Q", "P0")},
                "diagonal": {"Q_form": DIAGONAL, "R_form": DIAGONAL},
                "diagonal, all": {"free": NAMES, "Q_form": DIAGONAL, "R_form": DIAGONAL},
                "multiples": {"Q_form": MULTIPLE, "R_form": MULTIPLE},
                "multiples, all": {"free": NAMES, "Q_form": MULTIPLE, "R_form": MULTIPLE},
                "held, all": {"free": NAMES, **held},
                "held, A and H": {"free": ("A", "H"), **held},
                "held, diagonal, all": {"free": NAMES, "Q_form": DIAGONAL, "R_form": FULL, **held},
                "controls, all": {"free": NAMES, "B": push},
                "4 recordings, all": {"free": NAMES, "more": (30, 40, 1)},
                "4 recordings, controls, held, all": {"free": NAMES, "more": (30, 40, 1), "B": push,
                                                      **held}}.items():
            made[f"{name}, {title}"] = make(truth, 80, gaps=gaps, **given)
    made["2 sensors, gaps, long, all"] = make(SENSORS, 257, gaps=True, more=(128, 129), free=NAMES)
    upper = np.array([[0, 0], [1, 1]])
    for title, given in {"Q and R": {}, "all": {"free": NAMES}, "gaps, all": {"free": NAMES,
                                                                              "gaps": True},
                         "held, all": {"free": NAMES, "A_held": upper, "H_held": corner}}.items():
        made[f"F, {title}"] = make(COMPANION, 80, F=COLUMN, **given)
    slanted = np.array([[1.0], [0.5]])
    made["F slanted, all"] = make(COMPANION, 80, F=slanted, free=NAMES)
    made["F slanted, held, all"] = make(COMPANION, 80, F=slanted, free=NAMES, A_held=upper)
    square = np.array([[1.0, 0.5], [0.0, 2.0]])
    made["F square, diagonal, all"] = make(SENSORS, 80, F=square, free=NAMES, Q_form=DIAGONAL)
    return made


@functools.cache
def singular_cases() -> dict[str, Problem]:
    """Covariances of rank 1 and 2 of 3, in every position: rows equal, 0, or combined"""
    A = np.array([[0.5, 0.2, -0.3], [0.1, 0.6, 0.2], [-0.2, 0.1, 0.4]])
    H = np.array([[1, 0.2, 0.1], [0.3, 1, 0], [0, 0.3, 1]])
    held = np.array([[0, 0, 1], [1, 0, 0], [1, 0, 0]])
    factors = {"rows 1, 2 equal": [[1, 0], [0.5, 1], [0.5, 1]],
               "rows 0, 1 equal": [[0.5, 1], [0.5, 1], [1, 0]],
               "rows 0, 2 equal": [[0.5, 1], [1, 0], [0.5, 1]],
               "row 1 is 0": [[1, 0], [0, 0], [0.5, 1]],
               "combined": [[1, 0.25], [0.25, 1], [0.5, 0.75]],
               "rank 1": [[1], [0.75], [0.25]]}
    made = {}
    for name, factor in factors.items():
        F = np.array(factor)
        truth = Parameters(A, H, np.diag([0.5, 1, 0])[:F.shape[1], :F.shape[1]], np.eye(3),
                           [1, 0, -1], np.eye(3))
        for title, given in {"all": {"free": NAMES},
                             "held": {"free": ("A",), "A_held": held},
                             "held, all": {"free": NAMES, "A_held": held},
                             "multiple": {"Q_form": MULTIPLE}}.items():
            narrow = make(truth, 60, F=F, **given)
            wide = replace(narrow, F=None,
                           start=replace(narrow.start, Q=narrow.state_noise(narrow.start)))
            made[f"F, {name}, {title}"] = narrow
            made[f"Q, {name}, {title}"] = single(wide)
        for title, given in {"R": {"free": ("R",)},
                             "held": {"free": ("H",), "H_held": held},
                             "held, all": {"free": ("A", "H", "Q", "R", "x0"), "H_held": held},
                             "multiple": {"free": ("Q", "R"), "R_form": MULTIPLE}}.items():
            noisy = replace(truth, Q=np.eye(3), R=F @ truth.Q @ F.T)
            for gaps in (False, True):
                made[f"R, {name}, {title}{gaps * ', gaps'}"] = make(noisy, 60, gaps=gaps, **given)
    return made


def random_covariance(rng, n: int, form: int) -> np.ndarray:
    G = rng.normal(size=(n, n))
    C = G @ G.T + 0.1 * np.eye(n)
    return np.diag(np.diag(C)) if form == DIAGONAL else C


def random_problem(rng) -> Problem:
    n, m = int(rng.integers(1, 5)), int(rng.integers(1, 4))
    A = rng.normal(size=(n, n))
    A *= rng.uniform(0.5, 1) / np.abs(np.linalg.eigvals(A)).max()
    Q_form, R_form = (int(form) for form in rng.integers(0, 3, 2))
    truth = Parameters(A, rng.normal(size=(m, n)), random_covariance(rng, n, Q_form),
                       10.0**rng.uniform(-2, 1) * random_covariance(rng, m, R_form),
                       rng.normal(size=n), random_covariance(rng, n, FULL))
    B = rng.normal(size=(n, 1)) if rng.random() < 0.3 else None
    recordings = [simulate(rng, truth, int(rng.integers(70, 110)), B)
                  for _ in range(rng.integers(1, 3))]
    if rng.random() < 0.5:
        for recording in recordings:
            recording.z[rng.random(recording.z.shape) < 0.15] = GAP
            recording.z[20:20 + rng.integers(0, 6)] = GAP
    free = tuple(name for name in NAMES if rng.random() < 0.6) or NAMES
    held = {f"{name}_held": (rng.random(getattr(truth, name).shape) < 0.3).astype(int)
            for name in ("A", "H") if rng.random() < 0.4}
    start = replace(truth, A=truth.A * rng.uniform(0.5, 1),
                    H=truth.H + 0.3 * rng.normal(size=(m, n)),
                    Q=truth.Q * 10.0**rng.uniform(-1, 1), R=truth.R * 10.0**rng.uniform(-1, 1))
    return single(Problem(start, recordings, Choice(free, Q_form, R_form, **held), B))


def nile() -> np.ndarray:
    rows = np.genfromtxt(ROOT / "tools" / "kalmanq" / "examples" / "nile.csv", delimiter=",", comments="#")
    flow = rows[~np.isnan(rows[:, -1]), -1]
    assert len(flow) == 100
    return flow


def nile_level() -> Problem:
    return Problem(Parameters(1, 1, 1e4, 1e4, 0, 1e7), [Recording(nile())])


# ---------------------------------------------------------------- figures

def error(name: str, actual: np.ndarray, expected: np.ndarray) -> float:
    """Of a covariance in sigma_i sigma_j, where there is one, of all else in the largest entry"""
    if name in COVARIANCES:
        variance = np.diag(expected)
        sigma = np.sqrt(np.where(variance > 1e-12 * variance.max(), variance, variance.max()))
        return float(np.abs((actual - expected) / np.outer(sigma, sigma)).max())
    return float(np.abs(actual - expected).max() / np.abs(expected).max())


def is_identified(problem: Problem) -> bool:
    choice = problem.choice
    if not {"H", "Q"} <= set(choice.free):
        return True
    return choice.H_held is not None and bool((problem.start.H * choice.H_held).any())


def smallest_eigenvalue(C: np.ndarray) -> float:
    """Of the correlations"""
    sigma = np.sqrt(np.diag(C))
    sigma[sigma == 0] = 1
    return float(np.linalg.eigvalsh(C / np.outer(sigma, sigma))[0])


def differences(problem: Problem, name: str, entries=None) -> np.ndarray:
    """The gradient of the library's f64 likelihood by central differences of fourth order, all of
    it or the entries named; along a symmetric change of a covariance, spread over both entries"""
    value = getattr(problem.start, name)
    step = np.abs(value).max() * 2.0**-9
    slopes = np.zeros(value.shape)

    def likelihood(change) -> float:
        start = replace(problem.start, **{name: value + change})
        return library(replace(problem, start=start), 0, final=True).final

    for index in entries or np.ndindex(value.shape):
        if name in COVARIANCES and index[0] < index[1]:
            continue
        change = np.zeros(value.shape)
        change[index] = step
        if name in COVARIANCES:
            change = np.maximum(change, change.T)
        near = likelihood(change) - likelihood(-change)
        far = likelihood(2 * change) - likelihood(-2 * change)
        slopes[index] = (8 * near - far) / (12 * step) / np.count_nonzero(change)
    return slopes + np.tril(slopes, -1).T if name in COVARIANCES else slopes


# ---------------------------------------------------------------- tests

class EmTest(unittest.TestCase):
    def assert_at_most(self, limit: float, figure: float, what: str) -> None:
        print(f"{self._testMethodName[5:]:24} {what:48} {figure:8.1e}  limit {limit:.0e}  "
              f"{'pass' if figure <= limit else 'FAIL'}")
        self.assertLessEqual(figure, limit, what)

    def assert_held(self, problem: Problem, p: Parameters) -> None:
        """What is not free is as it was, bit for bit"""
        for name in NAMES:
            actual, start = getattr(p, name), getattr(problem.start, name)
            held = getattr(problem.choice, f"{name}_held", None)
            if name not in problem.choice.free:
                np.testing.assert_array_equal(start, actual, name)
            elif held is not None:
                np.testing.assert_array_equal(start[held != 0], actual[held != 0], name)

    def assert_still(self, problem: Problem, p: Parameters) -> None:
        """What has no noise is exactly as it was: a covariance's rows, and the coefficients of a
        state (a component) that is not moved"""
        start = problem.start
        for name in COVARIANCES:
            without = np.diag(getattr(start, name)) == 0
            self.assertFalse(getattr(p, name)[without].any(), name)
        without = np.diag(problem.state_noise(start)) == 0
        np.testing.assert_array_equal(start.A[without], p.A[without])
        without = np.diag(start.R) == 0
        np.testing.assert_array_equal(start.H[without], p.H[without])

    def assert_form(self, problem: Problem, p: Parameters, rounding: float) -> None:
        """A multiple is rounded once an iteration"""
        for name in ("Q", "R"):
            actual, start = getattr(p, name), getattr(problem.start, name)
            form = getattr(problem.choice, f"{name}_form")
            if form == DIAGONAL:
                np.testing.assert_array_equal(np.diag(np.diag(actual)), actual, name)
            elif form == MULTIPLE:
                np.testing.assert_array_equal(start == 0, actual == 0, name)
                ratio = actual[start != 0] / start[start != 0]
                self.assertLessEqual(np.ptp(ratio), 4 * rounding * ratio.max(), name)

    def assert_covariance(self, C: np.ndarray, eps: float) -> None:
        np.testing.assert_array_equal(C, C.T)
        self.assertGreaterEqual(smallest_eigenvalue(C), -8 * len(C) * eps)

    def assert_as_reference(self, title: str, problem: Problem, iterations) -> None:
        likelihoods, path = reference.iterate(problem, max(iterations))
        for arithmetic in EPS:
            with self.subTest(case=title, arithmetic=arithmetic):
                run = library(problem, max(iterations), arithmetic, snapshots=iterations)
                self.assertEqual(0 if is_identified(problem) else 1, run.status)
                fall = np.abs(run.likelihoods / likelihoods - 1)
                self.assert_at_most(1e-10 if arithmetic == "f64" else 1e-3, fall.max(),
                                    f"{title}: likelihood, {arithmetic}")
                for k in iterations:
                    self.assert_held(problem, run.path[k])
                    self.assert_still(problem, run.path[k])
                    self.assert_form(problem, run.path[k], k * EPS[arithmetic])
                    figures = {name: error(name, getattr(run.path[k], name),
                                           getattr(path[k - 1], name))
                               for name in problem.choice.free}
                    worst = max(figures, key=figures.get)
                    self.assert_at_most(1e-8 if arithmetic == "f64" else 1e-3, figures[worst],
                                        f"{title}: {worst} after {k}, {arithmetic}")

    def test_reference(self) -> None:
        for title, problem in some(cases().items()):
            self.assert_as_reference(title, problem, ITERATIONS)

    def test_singular(self) -> None:
        for title, problem in some(singular_cases().items()):
            self.assert_as_reference(title, problem, (1, 5))

    def test_state_in_a_plane(self) -> None:
        """x moves along (1, 1) only: what A and H do to other directions is nobody's, and nothing
        else depends on it.  For a component that is always 0 they stay exactly as they were."""
        one = np.ones((2, 2))
        p = Parameters([[0.5, 0.25], [0.25, 0.5]], [[1, 0.5]], one, 1, [1, 1], one)
        recording = simulate(np.random.default_rng(5), p, 60)
        problem = Problem(p, [recording], Choice(("A", "H", "Q", "R")))
        likelihoods, path = reference.iterate(problem, 5)
        run = library(problem, 5, snapshots=[5])
        along = np.ones(2)
        for what, actual, expected in (("likelihood", run.likelihoods, likelihoods),
                                       ("A x", run.path[5].A @ along, path[4].A @ along),
                                       ("H x", run.path[5].H @ along, path[4].H @ along),
                                       ("Q", run.path[5].Q, path[4].Q),
                                       ("R", run.path[5].R, path[4].R)):
            self.assert_at_most(1e-8, np.abs(actual / expected - 1).max(), what)
        for zero in (0, 1):
            A, moving = np.array([[0.5, 0.25], [0.25, 0.5]]), 1.0 - np.eye(2)[zero]
            A[zero, 1 - zero] = 0
            start = Parameters(A, p.H, np.diag(moving), 1, moving, np.diag(moving))
            problem = Problem(start, [recording], Choice(("A", "H", "Q", "R")))
            for arithmetic in EPS:
                moved = library(problem, 20, arithmetic, snapshots=[20]).path[20]
                np.testing.assert_array_equal(start.A[:, zero], moved.A[:, zero])
                np.testing.assert_array_equal(start.H[:, zero], moved.H[:, zero])

    def test_random(self) -> None:
        rng = np.random.default_rng(SEED)
        for index, problem in some(enumerate([random_problem(rng) for _ in range(40)])):
            self.assert_as_reference(f"{index}, seed {SEED}", problem, (1, 5))

    def pykalman(self, problem: Problem, iterations: int) -> tuple[Parameters, float]:
        names = {"A": "transition_matrices", "H": "observation_matrices",
                 "Q": "transition_covariance", "R": "observation_covariance",
                 "x0": "initial_state_mean", "P0": "initial_state_covariance"}
        recording, = problem.recordings
        model = KalmanFilter(transition_offsets=problem.drive(recording),
                             observation_offsets=np.zeros(problem.m),
                             **{names[name]: getattr(problem.start, name) for name in NAMES})
        z = np.ma.masked_invalid(recording.z)
        likelihood = model.loglikelihood(z)
        model.em(z, n_iter=iterations, em_vars=[names[name] for name in problem.choice.free])
        return Parameters(**{name: getattr(model, names[name]) for name in NAMES}), likelihood

    def assert_as_pykalman(self, title: str, problem: Problem, iterations: int = 20) -> None:
        expected, likelihood = self.pykalman(problem, iterations)
        run = library(problem, iterations, snapshots=[iterations])
        for name in problem.choice.free:
            self.assert_at_most(1e-8, error(name, getattr(run.path[iterations], name),
                                            getattr(expected, name)), f"{title}: {name}")
        self.assert_at_most(1e-10, abs(run.likelihoods[0] / likelihood - 1), f"{title}: likelihood")

    def test_pykalman(self) -> None:
        push = np.array([[0.5, 0], [1, -0.7]])
        for title, truth, B in (("AR(1)", AR1, None), ("oscillator", OSCILLATOR, push),
                                ("2 sensors", SENSORS, None)):
            self.assert_as_pykalman(title, make(truth, 80, B=B, free=NAMES))
        self.assert_as_pykalman("2 sensors, Q and R", make(SENSORS, 80))

    def test_pykalman_gaps(self) -> None:
        """It knows whole gaps only, and leaves them out of H and R, too"""
        for free in (NAMES, ("R",), ("H", "R")):
            problem = make(SENSORS, 80, free=free)
            problem.recordings[0].z[[0, 10, 11, 12, 13, 40, 79]] = GAP
            self.assert_as_pykalman(f"2 sensors, gaps, {len(free)} free", problem)

    def test_empty_steps(self) -> None:
        """Whether steps without a measurement are complete data or not: both ways the likelihood
        never falls, and what is settled for one is for the other; but the library's is faster"""
        for title, truth, free, share in some((("AR(1)", AR1, ("R",), 0.3), ("AR(1)", AR1, ("R",), 0.6),
                                               ("AR(1)", AR1, ("H", "R"), 0.6),
                                               ("2 sensors", SENSORS, ("R",), 0.3))):
            problem = make(truth, 60, free=free)
            rng = np.random.default_rng(SEED)
            problem.recordings[0].z[rng.random(60) < share] = GAP
            settled = library(problem, 20000, tolerance=1e-11, snapshots=None)
            p, top = settled.path[len(settled.changes)], settled.likelihoods.max()
            needed = []
            for given in (problem, replace(problem, empty_steps=True)):
                likelihoods, _ = reference.iterate(given, 120)
                self.assertGreaterEqual(np.diff(likelihoods).min(), -1e-12 * abs(top))
                needed.append(np.count_nonzero(likelihoods < top - 0.01))
                new = reference.m_step(given, p, reference.e_step(given, p))
                for name in free:
                    self.assert_at_most(1e-9, error(name, getattr(new, name), getattr(p, name)),
                                        f"{title}, {share:.0%} empty: {name} stays")
            print(f"empty steps: {title}, {' and '.join(free)}, {share:.0%}: {needed[0]} "
                  f"iterations to 0.01, with them {needed[1]}")
            self.assertLess(needed[0], (1 - share / 2) * needed[1])

    def test_likelihood_never_falls(self) -> None:
        rng = np.random.default_rng(SEED)
        worst = {"f64": 0.0, "f32": 0.0}
        smallest = {"f64": np.inf, "f32": np.inf}
        for index, problem in some(enumerate([random_problem(rng) for _ in range(50)])):
            for arithmetic in worst:
                with self.subTest(problem=index, arithmetic=arithmetic):
                    run = library(problem, 100, arithmetic, final=True, snapshots=None)
                    likelihoods = np.append(run.likelihoods, run.final)
                    fall = (np.maximum(-np.diff(likelihoods), 0) / np.abs(likelihoods[1:])).max()
                    worst[arithmetic] = max(worst[arithmetic], fall)
                    self.assertEqual(100, len(run.path))
                    for p in run.path.values():
                        self.assert_held(problem, p)
                        for name in COVARIANCES:
                            C = getattr(p, name)
                            self.assert_covariance(C, EPS[arithmetic])
                            smallest[arithmetic] = min(smallest[arithmetic], smallest_eigenvalue(C))
                    self.assert_form(problem, run.path[100], 100 * EPS[arithmetic])
        for arithmetic, figure in smallest.items():
            self.assert_at_most(8 * 4 * EPS[arithmetic], -figure,
                                f"-smallest eigenvalue, {arithmetic}, seed {SEED}")
        self.assert_at_most(1e-10, worst["f64"], f"largest fall, f64, seed {SEED}")
        self.assert_at_most(1e-4, worst["f32"], f"largest fall, f32, seed {SEED}")

    def levels(self) -> dict[str, Problem]:
        """Local levels whose maximum is inside, and those where it is at Q = 0"""
        rng = np.random.default_rng(5)
        start = Parameters(1, 1, 1, 1, 0, 10)
        made = {"Nile": nile_level(), "2 sensors": make(SENSORS, 80, gaps=True)}
        for k in range(3):
            made[f"white {k}"] = Problem(start, [Recording(rng.normal(size=100))])
            made[f"level {k}"] = Problem(start, [Recording(rng.normal(size=100) +
                                                           rng.normal(size=100).cumsum() / 3)])
        return made

    def test_distance(self) -> None:
        """What is left of the likelihood once a small distance is told: at most that, and no less
        than half of it; f32 does not promise more than it sees"""
        for title, problem in some(self.levels().items()):
            top = library(problem, 40000).likelihoods.max()
            for arithmetic in EPS:
                run = library(problem, 8000, arithmetic)
                near = np.flatnonzero((run.distances <= 0.02) & (run.changes <= 1e-2))
                if near.size:
                    left, told = top - run.likelihoods[near[0]], run.distances[near[0]]
                    print(f"distance: {title}, {arithmetic}: {told:.4f} after {near[0]} "
                          f"iterations, {left:.4f} is left")
                    self.assertLess(left, 1.1 * told)
                    self.assertGreater(left, 0.4 * told)
                else:
                    self.assertEqual("f32", arithmetic, title)
                settled = np.flatnonzero(run.changes <= 1e-4)
                if settled.size:
                    print(f"distance: {title}, {arithmetic}: settled to 1e-4 after {settled[0]}, "
                          f"{top - run.likelihoods[settled[0]]:.1e} is left")

    def test_too_few_measurements(self) -> None:
        """A full R of many components from few steps: refused before the likelihood falls"""
        rng = np.random.default_rng(SEED)
        ended = {arithmetic: 0 for arithmetic in EPS}
        for index in range(40):
            n, m = int(rng.integers(1, 5)), int(rng.integers(3, 17))
            steps = m // 2 + 2 + int(rng.integers(0, m))
            steps += max(0, -((steps * m - m * (m + 1) // 2 - n * (n + 1) // 2) // m))
            truth = Parameters(0.9 * np.eye(n), rng.normal(size=(m, n)), np.eye(n), np.eye(m),
                               np.zeros(n), np.eye(n))
            problem = single(Problem(truth, [simulate(rng, truth, steps)]))
            for arithmetic in EPS:
                run = library(problem, 200, arithmetic, final=True, snapshots=[])
                likelihoods = np.append(run.likelihoods, run.final)
                rounding = 128 * EPS[arithmetic] * (steps * m + np.abs(likelihoods[1:]))
                self.assertTrue((np.diff(likelihoods) >= -rounding).all(), f"{index}, {arithmetic}")
                ended[arithmetic] += len(run.likelihoods) < 200
        print(f"too few measurements: refused {ended} of 40")
        self.assertGreater(min(ended.values()), 4)

    def gradients(self) -> dict[str, Problem]:
        return {"AR(1)": make(AR1, 120, free=NAMES),
                "oscillator, controls": make(OSCILLATOR, 80, B=np.array([[0.5], [1]]), free=NAMES),
                "2 sensors, gaps": make(SENSORS, 80, gaps=True, free=NAMES),
                "2 sensors, 4 recordings": make(SENSORS, 60, gaps=True, more=(30, 40, 1),
                                                free=NAMES),
                "F": make(COMPANION, 80, F=COLUMN, free=("H", "Q", "R", "x0", "P0"))}

    def test_gradient(self) -> None:
        for title, problem in self.gradients().items():
            p, free = problem.start, problem.choice.free
            expected = reference.gradient(problem, p, reference.e_step(problem, p))
            for arithmetic, limit in (("f64", 1e-9), ("f32", 1e-3)):
                gradient = library(problem, 0, arithmetic, final=True).gradient
                for name in free:
                    self.assert_at_most(limit, error("gradient", gradient[name], expected[name]),
                                        f"{title}: {name}, {arithmetic}")

    def test_differences(self) -> None:
        for title, problem in self.gradients().items():
            gradient = library(problem, 0, final=True).gradient
            for name in problem.choice.free:
                self.assert_at_most(1e-6, error("gradient", gradient[name],
                                                differences(problem, name)), f"{title}: {name}")

    def test_gradient_without_noise(self) -> None:
        """Of a direction that is not moved the identity says nothing, of the others all"""
        problem = make(COMPANION, 80, F=COLUMN, free=("A", "Q", "R", "x0"))
        wide = replace(problem, F=None,
                       start=replace(problem.start, Q=np.diag([problem.start.Q[0, 0], 0])))
        narrow = library(problem, 0, final=True).gradient
        gradient = library(wide, 0, final=True).gradient
        self.assert_at_most(1e-12, abs(gradient["Q"][0, 0] / narrow["Q"][0, 0] - 1), "Q[0][0]")
        np.testing.assert_array_equal([[False, True], [True, True]], np.isnan(gradient["Q"]))
        np.testing.assert_array_equal([False, True], np.isnan(gradient["A"]).all(axis=1))
        self.assertTrue(np.isfinite(gradient["A"][0]).all())

    def test_gradient_of_singular_covariances(self) -> None:
        """An entry is NaN or right: that of a row of its own along that row alone"""
        found = 0
        for title, problem in singular_cases().items():
            name = title[0]
            if name not in "QR" or "held" in title or not title.endswith((", all", ", R")):
                continue
            C = getattr(problem.start, name)
            gradient = library(problem, 0, final=True).gradient[name]
            within = np.abs(C @ np.linalg.pinv(C) - np.eye(3)).max(0) < 1e-8
            for i in np.flatnonzero(~np.isnan(np.diag(gradient))):
                self.assertTrue(within[i], f"{title}: {name}[{i}][{i}] is nobody's")
                slope = differences(problem, name, [(i, i)])[i, i]
                self.assert_at_most(1e-6, abs(gradient[i, i] / slope - 1),
                                    f"{title}: {name}[{i}][{i}]")
                found += 1
        self.assertGreaterEqual(found, 4)

    def test_nile(self) -> None:
        """From 1e4, 1e4, with x0 = 0 and P0 = 1e7"""
        for arithmetic, tolerance, limit in (("f64", 1e-7, 5e-5), ("f32", 2e-6, 5e-4)):
            run = library(nile_level(), 5000, arithmetic, tolerance=tolerance, snapshots=None)
            count = len(run.likelihoods)
            p = run.path[count]
            print(f"nile, {arithmetic}: R = {p.R[0, 0]:.2f}, Q = {p.Q[0, 0]:.2f} after {count} "
                  f"iterations, settled to {tolerance:.0e}")
            self.assertLess(count, 5000)
            self.assert_at_most(limit, abs(p.R[0, 0] / 15099.7 - 1), f"R, {arithmetic}")
            self.assert_at_most(limit, abs(p.Q[0, 0] / 1468.5 - 1), f"Q, {arithmetic}")

    def test_fixed_point(self) -> None:
        """Once nothing changes the gradient is 0, in units of 1 / (sigma_i sigma_j); by Fisher's
        identity, and by differences of the likelihood"""
        for title, problem in (("Nile", nile_level()),
                               ("2 sensors, gaps", make(SENSORS, 80, gaps=True))):
            run = library(problem, 20000, tolerance=1e-12, final=True, snapshots=None)
            self.assertLessEqual(run.changes[-1], 1e-12)
            settled = replace(problem, start=run.path[len(run.changes)])
            for name in ("Q", "R"):
                sigma = np.sqrt(np.diag(getattr(settled.start, name)))
                size = np.outer(sigma, sigma)
                self.assert_at_most(1e-9, np.abs(run.gradient[name] * size).max(),
                                    f"{title}: {name}, Fisher")
                self.assert_at_most(1e-8, np.abs(differences(settled, name) * size).max(),
                                    f"{title}: {name}, differences")

    def test_long_recording(self) -> None:
        """Each step is rounded beside a block of them, not beside all: f32 keeps its digits"""
        problem = make(AR1, 20000, free=("A", "Q", "R"))
        narrow, wide = (library(problem, 5, arithmetic, snapshots=[5]).path[5]
                        for arithmetic in ("f32", "f64"))
        for name in problem.choice.free:
            self.assert_at_most(5e-6, error(name, getattr(narrow, name), getattr(wide, name)),
                                f"20000 steps: {name}, f32")

    def test_slices(self) -> None:
        """advance and maximise do what iterate does"""
        problems = cases()
        for title in ("AR(1), 3 recordings, all", "F, held, all",
                      "2 sensors, gaps, 4 recordings, controls, held, all"):
            for arithmetic in EPS:
                whole, sliced = (asdict(library(problems[title], 5, arithmetic, slices=slices, final=True, snapshots=None))
                                 for slices in (False, True))
                np.testing.assert_equal(sliced, whole)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--library", required=True)
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--every", type=int, default=EVERY)
    arguments, rest = parser.parse_known_args()
    SHARED, SEED, EVERY = arguments.library, arguments.seed, arguments.every
    unittest.main(argv=[sys.argv[0], *rest])
