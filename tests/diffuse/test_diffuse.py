"""The unknown start against the exact diffuse filter and smoother of statsmodels, and against batch
least squares.

    test_diffuse.py --library FILE      kalmanq as a shared library
"""

from __future__ import annotations

import argparse
import sys
import unittest
import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from statsmodels.tsa.statespace.initialization import Initialization
from statsmodels.tsa.statespace.kalman_smoother import KalmanSmoother

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "reference"))
from shared_library import Library  # noqa: E402

SHARED, ROOM = "", 400_000  # numbers of memory
GAP = np.nan


@dataclass
class Model:
    A: np.ndarray
    Q: np.ndarray
    H: np.ndarray  # m x n, or steps x m x n
    R: np.ndarray
    z: np.ndarray  # steps x m
    unknown: int
    x0: np.ndarray | None = None
    P0: np.ndarray | None = None

    def __post_init__(self) -> None:
        self.A, self.Q, self.R = (np.atleast_2d(M).astype(float) for M in (self.A, self.Q, self.R))
        self.z = np.asarray(self.z, float).reshape(len(self.z), -1)
        self.H = np.asarray(self.H, float)
        if self.H.ndim < 3:
            self.H = np.repeat(np.atleast_2d(self.H)[None], len(self.z), axis=0)
        self.x0 = np.zeros(self.n) if self.x0 is None else np.asarray(self.x0, float)
        self.P0 = np.eye(self.n) if self.P0 is None else np.asarray(self.P0, float)

    @property
    def n(self) -> int:
        return len(self.A)

    @property
    def bits(self) -> np.ndarray:
        return np.array([self.unknown >> i & 1 for i in range(self.n)], bool)


@dataclass
class Run:
    count: np.ndarray
    llf: np.ndarray
    mean: np.ndarray
    sigma: np.ndarray
    smoothed: np.ndarray
    smoothed_sigma: np.ndarray
    P: np.ndarray

    @property
    def determined(self) -> int:
        return int(np.argmax(self.count == 0)) if (self.count == 0).any() else len(self.count)


def library(model: Model, early: int = 60, arithmetic: str = "f64") -> Run:
    k, n, (steps, m) = Library(SHARED, arithmetic), model.n, model.z.shape
    process, sensor, filter_ = k.made("process", n, 0), k.made("sensor", n, m), k.made("filter", n)
    tape, start = k.made("history", n, words=ROOM), k.made("diffuse", n, early, words=ROOM)
    k.call("process_init", process, k.numbers(model.A), None, k.numbers(model.Q))
    k.call("sensor_init", sensor, k.numbers(model.H[0]), k.numbers(model.R))
    k.call("diffuse_init", start, filter_, k.numbers(model.x0), k.numbers(model.P0), model.unknown)
    k.call("attach", filter_, tape)  # `attached` comes first

    def states(name, of):
        return [k.read(name, of, i) for i in range(n)]

    filtered, smoothed = [], []
    for t, z in enumerate(model.z):
        if t:
            k.call("predict", filter_, process, None)
        k.call("sensor_change_measurement", sensor, k.numbers(model.H[t]))
        k.call("update_subset", filter_, sensor, k.numbers(z), sum(1 << c for c in range(m) if not np.isnan(z[c])))
        filtered.append((k.answer("diffuse_count", start), k.read("log_likelihood_last", filter_), states("mean", filter_),
                         states("sigma", filter_)))
    k.call("diffuse_smooth", start)
    for t in range(steps):
        view, P = np.zeros(512, dtype=np.uint8), np.zeros((n, n), dtype=k.type)
        k.answer("diffuse_smoothed", start, t, view)  # refused: it reads NaN
        if k.answer("covariance", view, P):
            P[:] = np.nan
        smoothed.append((states("mean", view), states("sigma", view), P.astype(float)))
    return Run(*map(np.array, zip(*filtered)), *map(np.array, zip(*smoothed)))


def exact_diffuse(model: Model):
    steps, m = model.z.shape
    smoother = KalmanSmoother(m, model.n, k_posdef=model.n)
    smoother.bind(np.asfortranarray(model.z.T))
    smoother["transition"], smoother["selection"] = model.A, np.eye(model.n)
    smoother["state_cov"], smoother["obs_cov"] = model.Q, model.R
    smoother["design"] = np.asfortranarray(np.moveaxis(model.H, 0, 2))
    known = np.where(np.outer(~model.bits, ~model.bits), model.P0, 0)
    smoother.initialization = Initialization.from_components(
        model.n, a=np.where(model.bits, 0, model.x0), Pstar=known, Pinf=np.diag(model.bits * 1.0))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return smoother.smooth()


def least_squares(regressors, z, r):
    """Mean and covariance by QR of the whitened rows"""
    white = regressors / np.sqrt(r)
    Q, R = np.linalg.qr(white)
    inverse = np.linalg.inv(R)
    return inverse @ (Q.T @ (z / np.sqrt(r))), inverse @ inverse.T


def nile() -> np.ndarray:
    rows = np.genfromtxt(ROOT / "tools" / "kalmanq" / "examples" / "nile.csv", delimiter=",", comments="#")
    flow = rows[~np.isnan(rows[:, -1]), -1]
    assert len(flow) == 100
    return flow


def local_trend(z, q_level, q_slope, r, unknown=3, **more) -> Model:
    return Model([[1, 1], [0, 1]], np.diag([q_level, q_slope]), [1, 0], r, z, unknown, **more)


def seasonal(z, period, q, r) -> Model:
    n = period
    A = np.zeros((n, n))
    A[0, 0] = 1
    A[1, 1:] = -1
    A[range(2, n), range(1, n - 1)] = 1
    Q, H = np.zeros((n, n)), np.zeros(n)
    Q[0, 0], Q[1, 1], H[0], H[1] = q[0], q[1], 1, 1
    return Model(A, Q, H, r, z, 2**n - 1)


def plane(unknown: int, gaps: bool) -> Model:
    """Position and velocity in two axes, both positions measured with correlated noise"""
    rng = np.random.default_rng(1)
    dt = 0.5
    A = np.kron(np.array([[1, dt], [0, 1]]), np.eye(2))
    Q = np.kron(np.array([[dt**3 / 3, dt**2 / 2], [dt**2 / 2, dt]]), np.array([[1, 0.2], [0.2, 2]]))
    z = np.cumsum(rng.normal(size=(40, 2)), axis=0) + [50, -30]
    if gaps:
        z[0], z[1, 1], z[2, 0], z[3] = GAP, GAP, GAP, GAP
    return Model(A, Q, np.eye(2, 4), [[0.5, 0.2], [0.2, 0.4]], z, unknown,
                 x0=[40, -20, 0.5, 1], P0=np.diag([9, 16, 4, 1]))


class StartTest(unittest.TestCase):
    def assert_at_most(self, limit: float, figure: float, what: str) -> None:
        print(f"{self._testMethodName[5:]:42} {what:18} {figure:.1e}  limit {limit:.0e}")
        self.assertLessEqual(figure, limit, what)

    def assert_same(self, model: Model, early: int = 60) -> Run:
        """Log-likelihoods at every step, means in sigma, variances relative"""
        run, exact = library(model, early), exact_diffuse(model)
        since = run.determined
        self.assertLess(since, len(model.z))
        self.assert_at_most(1e-8, np.abs(run.llf - exact.llf_obs).max(), "log-likelihoods")
        self.assert_at_most(1e-8, abs(run.llf.sum() - exact.llf), "llf")
        sigma = np.sqrt(np.einsum("iit->ti", exact.filtered_state_cov))[since:]
        self.assert_at_most(1e-8, (np.abs(run.mean - exact.filtered_state.T)[since:] / sigma).max(),
                            "filtered mean")
        self.assert_at_most(1e-8, np.abs(run.sigma[since:] / sigma - 1).max(), "filtered sigma")
        P = np.moveaxis(exact.smoothed_state_cov, 2, 0)
        sigma = np.sqrt(np.einsum("tii->ti", P))
        self.assert_at_most(1e-8, (np.abs(run.smoothed - exact.smoothed_state.T) / sigma).max(),
                            "smoothed mean")
        self.assert_at_most(1e-8, np.abs(run.smoothed_sigma / sigma - 1).max(), "smoothed sigma")
        size = sigma[:, :, None] * sigma[:, None, :]
        self.assert_at_most(1e-8, np.abs((run.P - P) / size).max(), "smoothed P")
        return run

    def test_nile_local_level(self) -> None:
        for r, q in ((15099, 1469.1), (15099, 0), (1, 1e4), (1e6, 1)):
            run = self.assert_same(Model(1, q, 1, r, nile(), 1))
            self.assertEqual(0, run.determined)
        # as Durbin and Koopman have it, who leave log 2 pi out of the diffuse step
        known = library(Model(1, 1469.1, 1, 15099, nile(), 1)).llf.sum() + np.log(2 * np.pi) / 2
        self.assertAlmostEqual(-632.5456, known, places=4)

    def test_nile_local_linear_trend(self) -> None:
        for q_level, q_slope in ((1469.1, 10), (0, 25), (1500, 0)):
            run = self.assert_same(local_trend(nile(), q_level, q_slope, 15099))
            np.testing.assert_array_equal([1, 0], run.count[:2])
            np.testing.assert_array_equal([False, True], np.isnan(run.mean[0]))

    def test_nile_with_gaps_at_the_start(self) -> None:
        z = nile()
        z[[0, 1, 3, 4]] = GAP
        run = self.assert_same(local_trend(z, 1469.1, 10, 15099))
        self.assertEqual(5, run.determined)
        self.assertTrue(np.isnan(run.mean[:2]).all())

    def test_seasonal(self) -> None:
        rng = np.random.default_rng(2)
        season = np.tile([10, -4, 3, -9], 15) + np.cumsum(rng.normal(size=60)) + 100
        run = self.assert_same(seasonal(season, 4, (1, 0.1), 2))
        self.assertEqual(3, run.determined)

    def test_known_slope_unknown_level(self) -> None:
        self.assert_same(local_trend(nile(), 1469.1, 10, 15099, unknown=1, x0=[0, -3],
                                     P0=np.diag([7, 25])))

    def test_two_components(self) -> None:
        for unknown in (15, 3, 12, 5):
            for gaps in (False, True):
                self.assert_same(plane(unknown, gaps))

    def test_unobservable_component(self) -> None:
        """Two levels of which only the sum is measured, and one more that is measured alone"""
        rng = np.random.default_rng(3)
        model = Model(np.eye(3), np.diag([1, 2, 3]), [[1, 1, 0], [0, 0, 1]], np.diag([1, 2]),
                      rng.normal(size=(30, 2)) * 5 + [10, 20], 7)
        run, exact = library(model), exact_diffuse(model)
        np.testing.assert_array_equal(np.ones(30), run.count)
        self.assertTrue(np.isnan(run.mean[:, :2]).all() and np.isnan(run.smoothed[:, :2]).all())
        self.assert_at_most(1e-8, np.abs(run.llf - exact.llf_obs).max(), "log-likelihoods")
        alone = exact_diffuse(Model(1, 3, 1, 2, model.z[:, 1], 1))
        sigma = np.sqrt(alone.smoothed_state_cov[0, 0])
        self.assert_at_most(1e-8, np.abs(run.smoothed[:, 2] - alone.smoothed_state[0]).max(),
                            "smoothed mean")
        self.assert_at_most(1e-8, np.abs(run.smoothed_sigma[:, 2] / sigma - 1).max(),
                            "smoothed sigma")

    def test_too_little_room(self) -> None:
        z = nile()
        z[:5] = GAP
        model = local_trend(z, 1469.1, 10, 15099)
        all_steps, some = library(model, 60), library(model, 4)
        self.assertEqual(6, all_steps.determined)
        self.assertTrue(np.isnan(some.smoothed[:2]).all())
        np.testing.assert_array_equal(all_steps.smoothed[2:], some.smoothed[2:])
        np.testing.assert_array_equal(all_steps.P[2:], some.P[2:])

    def test_recursive_least_squares(self) -> None:
        rng = np.random.default_rng(4)
        for n, steps in ((1, 20), (3, 40), (6, 60), (10, 80)):
            rows = rng.normal(size=(steps, n))
            z = rows @ rng.normal(size=n) * 3 + rng.normal(size=steps)
            run = library(Model(np.eye(n), np.zeros((n, n)), rows[:, None, :], 0.25, z, 2**n - 1))
            self.assertEqual(n - 1, run.determined)
            for t in range(n - 1, steps):
                mean, P = least_squares(rows[:t + 1], z[:t + 1], 0.25)
                sigma = np.sqrt(np.diag(P))
                condition = np.linalg.cond(rows[:t + 1])
                if condition > 100:
                    continue  # a few rows that nearly coincide: the inverse is no reference
                last = max(np.abs((run.mean[t] - mean) / sigma).max(),
                           np.abs(run.sigma[t] / sigma - 1).max())
                self.assertLessEqual(last, 1e-11)
            self.assert_at_most(1e-12, np.abs((run.mean[-1] - mean) / sigma).max(),
                                f"mean, n = {n}")
            self.assert_at_most(1e-12, np.abs(run.sigma[-1] / sigma - 1).max(), f"sigma, n = {n}")
            self.assert_at_most(1e-12, np.abs((run.smoothed[0] - mean) / sigma).max(),
                                f"smoothed, n = {n}")

    def test_float(self) -> None:
        for model in (Model(1, 1469.1, 1, 15099, nile(), 1),
                      local_trend(nile(), 1469.1, 10, 15099), plane(15, True)):
            run, fine = library(model, arithmetic="f32"), library(model)
            np.testing.assert_array_equal(fine.count, run.count)
            error = np.abs(run.mean - fine.mean) / fine.sigma
            self.assert_at_most(1e-4, np.nanmax(error), "f32 filtered")
            error = np.abs(run.smoothed - fine.smoothed) / fine.smoothed_sigma
            self.assert_at_most(1e-4, np.nanmax(error), "f32 smoothed")
            self.assertLessEqual(abs(run.llf.sum() - fine.llf.sum()), 1e-4 * abs(fine.llf.sum()))


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--library", required=True)
    arguments, rest = parser.parse_known_args()
    SHARED = arguments.library
    unittest.main(argv=[sys.argv[0], *rest])
