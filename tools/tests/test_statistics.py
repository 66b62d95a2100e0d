"""Consistency of a filter and least squares, beside their formulas."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

import models
from kalmanq import Consistency, Filter, KalmanqError, LeastSquares, Quantity, Robust
from test_twin import ARITHMETICS, LIMITS, SEEDS

QUANTILE = 1.96


def innovations(model, z, u) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of each row by the textbook: e / sqrt(S_cc), NIS, components"""
    _, _, means, covariances, _ = models.filtered(model, z, u)
    nu, nis, there = np.full(z.shape, np.nan), np.zeros(len(z)), ~np.isnan(z)
    for t, (x, P) in enumerate(zip(means, covariances)):
        if np.any(there[t]):
            e, S, _ = models.innovation(model, x, P, z[t])
            nu[t, there[t]], nis[t] = e / np.sqrt(np.diag(S)), e @ np.linalg.solve(S, e)
    return nu, nis, there.sum(axis=1)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("make", [models.cart, models.pair])
@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_a_window_has_the_statistics_of_its_updates(make, arithmetic, seed):
    model, window = make(), 50
    z, u = models.data(model, 120, seed)
    nu, nis, count = innovations(model, z, u)
    last = np.flatnonzero(count)[-window:]
    watch = Consistency(model, window, arithmetic)
    run = Filter(model, arithmetic).run(z, u, watch=watch)
    assert np.array_equal(run.mean, Filter(model, arithmetic).run(z, u).mean)
    assert len(watch) == window
    limit, degrees = 50 * LIMITS[arithmetic], np.sum(count[last])
    mean, low, high = watch.nis(QUANTILE)
    assert abs(mean - np.sum(nis[last]) / degrees) < limit
    exact = stats.chi2.ppf([stats.norm.cdf(-QUANTILE), stats.norm.cdf(QUANTILE)], degrees) / degrees
    assert np.allclose((low, high), exact, rtol=1e-3)
    for c in range(model.m):
        values = nu[last, c]
        known = values[~np.isnan(values)]
        pairs = values[1:] * values[:-1]
        mean, mean_bound, correlation, bound = watch.innovation(c, QUANTILE)
        assert abs(mean - np.mean(known)) < limit and abs(mean_bound - QUANTILE / np.sqrt(len(known))) < 1e-6
        assert abs(correlation - np.nansum(pairs) / np.sum(known**2)) < limit
        assert abs(bound - QUANTILE * np.sqrt(np.sum(~np.isnan(pairs))) / len(known)) < 1e-6


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_a_wrong_model_is_found_and_calls_are_the_sequence(arithmetic):
    model = models.pair()
    z, _ = models.data(model, 200, 9)
    right, wrong, rows = (Consistency(model, 200, arithmetic) for _ in range(3))
    Filter(model, arithmetic).run(z, watch=right)
    Filter(model.changed(R=model.R / 4, Q=model.Q / 4), arithmetic).run(z, watch=wrong)
    mean, low, high = right.nis(2.576)
    assert low < mean < high
    mean, low, high = wrong.nis(2.576)
    assert mean > high
    f = Filter(model, arithmetic)
    for t in range(200):
        if t:
            f.predict()
        f.update(z[t], watch=rows)
    assert rows.nis() == right.nis() and rows.innovation(1) == right.innovation(1) and len(rows) == len(right)
    rows.clear()
    assert len(rows) == 0
    with pytest.raises(KalmanqError):
        rows.nis()


def test_what_cannot_be_watched_is_refused():
    model = models.cart()
    for said, call in (("window .*f32", lambda: Filter(model).run([1.0], watch=Consistency(model, 10, "f32"))),
                       ("window .*2 components", lambda: Filter(model).run([1.0], watch=Consistency(models.pair()))),
                       ("", lambda: Consistency(model, 0))):
        with pytest.raises(KalmanqError, match=said):
            call()
    watch = Consistency(model, 10)
    # what is unknown is not watched; what a gate rejects does not count
    Filter(model.changed(P0=None, unknown="all")).run([1.0, 2.0, 3.0, 2.0], watch=watch)
    assert len(watch) == 2
    Filter(model).run([1.0, 1.0, 4000.0], robust=Robust("gate"), watch=watch)
    assert len(watch) == 4


# ------------------------------------------------------------------------------ least squares


def line(rows: int, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A row of H, a measurement and its variance at each instant"""
    draw = np.random.default_rng(seed)
    t = np.linspace(-1, 1, rows)
    H = np.column_stack([np.ones(rows), t, draw.normal(size=rows) / 4])
    r = draw.uniform(0.01, 0.2, rows)
    return H, H @ [3, -2, 0.5] + np.sqrt(r) * draw.normal(size=rows), r


STATES = [Quantity(name, "", 16) for name in ("level", "slope", "effect")]
X0, P0 = np.array([1.0, 0, 0]), np.diag([9.0, 9, 4])


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("forgetting", [1.0, 0.97])
@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_least_squares_solves_the_normal_equations(arithmetic, forgetting, seed):
    H, z, r = line(150, seed)
    fit = LeastSquares(x0=X0, P0=P0, arithmetic=arithmetic, forgetting=forgetting, states=STATES, measurement=Quantity("y", "", 16))
    run = fit.run(H=H, z=z, r=r)
    limit = 20 * LIMITS[arithmetic]
    for t in (0, 1, 10, 149):
        x, P, residual, weight = models.least_squares(H[: t + 1], z[: t + 1], r[: t + 1], X0, P0, forgetting)
        sigma = np.sqrt(np.diag(P))
        assert np.max(np.abs(run.mean[t] - x) / sigma) < limit and np.max(np.abs(run.sigma[t] / sigma - 1)) < limit
    assert np.max(np.abs(fit.covariance - P) / np.outer(sigma, sigma)) < limit
    assert abs(fit.residual / residual - 1) < limit and abs(fit.weight / weight - 1) < limit
    assert np.array_equal(fit.mean, run.mean[-1]) and np.array_equal(fit.sigma, run.sigma[-1])


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_least_squares_in_blocks_are_the_same_bits(arithmetic):
    H, z, _ = line(40, 4)
    units = dict(states=STATES, measurement=Quantity("y", "", 16), forgetting=0.99)
    whole, blocks = (LeastSquares(x0=X0, P0=P0, arithmetic=arithmetic, **units) for _ in range(2))
    run = whole.run(H=H, z=z, r=0.1)
    parts = [blocks.run(H=H[a:b], z=z[a:b], r=0.1) for a, b in ((0, 1), (1, 20), (20, 40))]
    assert np.array_equal(np.vstack([part.mean for part in parts]), run.mean)
    assert np.array_equal(whole.filter.memory, blocks.filter.memory)
    assert (whole.residual, whole.weight) == (blocks.residual, blocks.weight)
    assert np.all(run.taken == 1) and abs(np.sum(run.nis[-1:])) < 20


def test_least_squares_that_cannot_be_say_why():
    with pytest.raises(KalmanqError, match="forgetting"):
        LeastSquares(x0=[0.0], P0=[1.0], forgetting=1.5)
    for said, given in {"H is 1 rows, z 2": dict(H=[[1.0]], z=[1.0, 2.0]), "finite": dict(H=[[1.0]], z=[np.nan]),
                        "H is 1 x 2, not T x 1": dict(H=[[1.0, 2.0]], z=[1.0]), "row 1": dict(H=[[1.0], [1.0]], z=[1.0, 2.0], r=[1.0, -1.0])}.items():
        with pytest.raises(KalmanqError, match=said):
            LeastSquares(x0=[0.0], P0=[1.0]).run(**given)


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_fading_memory_divides_the_covariance(arithmetic):
    f = Filter(models.pair(), arithmetic)
    before = f.covariance
    f.forget(0.9)
    assert np.allclose(f.covariance, before / 0.9, rtol=1e-6)
    with pytest.raises(KalmanqError):
        f.forget(0.0)
