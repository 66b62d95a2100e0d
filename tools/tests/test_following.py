"""A fixed point and a filter that settles, beside the textbook."""

from __future__ import annotations

import numpy as np
import pytest

import kalmanq
import models
from kalmanq import Filter, KalmanqError, InstantSmoother, Robust, FrozenGainFilter, Smoother
from test_twin import ARITHMETICS, LIMITS, SEEDS

MODELS = [models.cart, models.pair]


def full(z: np.ndarray) -> np.ndarray:
    """Without gaps but one, at row 150"""
    made = np.where(np.isnan(z), 0.0, z)
    made[150:153] = np.nan
    return made


# ------------------------------------------------------------------------------ fixed point


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("make", MODELS)
@pytest.mark.parametrize("arithmetic", ARITHMETICS)
@pytest.mark.parametrize("row", [0, 7])
def test_a_point_is_the_textbook_s_smoother_of_what_is_there(make, arithmetic, seed, row):
    model = make()
    z, u = models.data(model, 40, seed)
    run = InstantSmoother(model, row, arithmetic).run(z, u, covariance=True)
    assert run.instant_row == row
    assert np.all(np.isnan(run.instant[:row])) and np.all(np.isnan(run.instant_covariance[:row]))
    for t in range(row, 40, 3):
        exact = models.textbook(model, z[: t + 1], u)
        P = exact["smoothed_covariance"][row]
        sigma = np.sqrt(np.diag(P))
        assert np.max(np.abs(run.instant[t] - exact["smoothed"][row]) / sigma) < LIMITS[arithmetic]
        assert np.max(np.abs(run.instant_covariance[t] - P) / np.outer(sigma, sigma)) < 2 * LIMITS[arithmetic]
        assert np.allclose(run.instant_sigma[t], sigma, rtol=2 * LIMITS[arithmetic])


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_a_point_leaves_the_filter_and_its_rows_as_they_are(arithmetic):
    model = models.cart()
    z, u = models.data(model, 30, 4)
    point, plain = InstantSmoother(model, 4, arithmetic), Filter(model, arithmetic)
    run = point.run(z, u)
    assert np.array_equal(run.mean, plain.run(z, u).mean) and np.array_equal(point.memory, plain.memory)
    blocks = InstantSmoother(model, 4, arithmetic)
    parts = [blocks.run(z[a:b], u[a:b]).instant for a, b in ((0, 3), (3, 11), (11, 30))]
    assert np.array_equal(np.vstack(parts), run.instant, equal_nan=True)
    assert set(run.columns()) >= {"position_instant", "velocity_instant_sigma"}
    last = Smoother(model, arithmetic).run(z, u).smoothed[4]
    assert np.max(np.abs(run.instant[-1] - last)) < 100 * LIMITS[arithmetic]


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_a_point_by_calls_is_that_of_a_sequence(arithmetic):
    model = models.cart()
    z, u = models.data(model, 20, 5)
    run, rows = InstantSmoother(model, 3, arithmetic).run(z, u), InstantSmoother(model, 3, arithmetic)
    for t in range(20):
        if t:
            rows.predict(u[t - 1])
        rows.update(z[t])
        if t < 3:
            with pytest.raises(KalmanqError, match="instant"):
                rows.instant
        else:
            assert np.array_equal(rows.instant, run.instant[t]) and np.array_equal(rows.instant_sigma, run.instant_sigma[t])


def test_a_point_that_is_unknown_or_none_is_refused():
    model = models.cart().changed(P0=None, unknown="all")
    with pytest.raises(KalmanqError, match="row 0"):
        InstantSmoother(model, 0).run([1.0, 2.0, 3.0])
    run = InstantSmoother(model, 1).run([1.0, 2.0, 3.0, 2.5])
    assert np.all(np.isfinite(run.instant[1:]))
    with pytest.raises(KalmanqError, match="^row: "):
        InstantSmoother(models.cart(), -1)


# ------------------------------------------------------------------------------ settling


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("make", MODELS)
@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_a_filter_that_has_settled_moves_its_mean_by_the_last_gain(make, arithmetic, seed):
    model = make()
    z, u = models.data(model, 300, seed)
    z = full(z)
    run = FrozenGainFilter(model, arithmetic, bits=10).run(z, u)
    assert np.any(run.settled[:150]) and not np.any(run.settled[[0, 1, *range(150, 155)]]) and run.settled[-1]
    exact = models.settling(model, z, u, run.settled)
    limit = 10 * LIMITS[arithmetic]
    assert np.max(np.abs(run.mean - exact["mean"]) / exact["sigma"]) < limit
    assert np.max(np.abs(run.sigma / exact["sigma"] - 1)) < limit
    there = ~np.isnan(z)
    assert np.array_equal(np.isnan(run.innovation), ~there)
    spread = exact["innovation_sigma"]
    assert np.max(np.abs(run.innovation - exact["innovation"])[there] / spread[there]) < limit
    assert np.max(np.abs(run.innovation_sigma / spread - 1)) < limit


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_settling_is_the_full_filter_until_it_has_settled(arithmetic):
    model = models.cart()
    z, u = models.data(model, 200, 3)
    z = full(z)
    settling, plain = FrozenGainFilter(model, arithmetic, bits=12), Filter(model, arithmetic)
    run, other = settling.run(z, u), plain.run(z, u)
    first = int(np.argmax(run.settled))
    assert first > 5 and np.array_equal(run.mean[:first], other.mean[:first])
    assert np.max(np.abs(run.mean - other.mean) / other.sigma) < 5e-2
    assert np.all(run.settled[first:150]) and np.all(run.sigma[first:150] == run.sigma[first - 1])
    blocks = FrozenGainFilter(model, arithmetic, bits=12)
    parts = [blocks.run(z[a:b], u[a:b]) for a, b in ((0, 40), (40, 140), (140, 200))]
    assert np.array_equal(np.vstack([part.mean for part in parts]), run.mean)
    assert np.array_equal(np.concatenate([part.settled for part in parts]), run.settled)


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_settling_step_by_step_and_release(arithmetic):
    model = models.cart()
    z, u = models.data(model, 120, 6)
    z = np.where(np.isnan(z), 0.0, z)
    whole, rows = FrozenGainFilter(model, arithmetic), FrozenGainFilter(model, arithmetic)
    run = whole.run(z, u)
    rows.update(z[0])
    for t in range(1, 120):
        rows.step(z[t], u[t - 1])
        assert np.array_equal(rows.mean, run.mean[t]) and rows.is_settled == run.settled[t]
    assert rows.is_settled and rows.row == whole.row == 119
    rows.release()
    rows.step(z[0], u[0])
    assert not rows.is_settled


def test_what_settling_cannot_do_is_refused():
    model = models.cart()
    with pytest.raises(KalmanqError, match="as it is"):
        FrozenGainFilter(model).run([1.0], robust=Robust("huber"))
    with pytest.raises(KalmanqError):
        FrozenGainFilter(model, bits=0)
    with pytest.raises(KalmanqError, match="range"):
        FrozenGainFilter(model, "q31").step([1e9])
    unknown = FrozenGainFilter(kalmanq.Model([[1]], H=[1], R=1.0, Q=0.5))
    run = unknown.run(np.zeros(60))
    assert run.settled[-1] and not run.settled[0]
