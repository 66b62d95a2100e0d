"""The reweighted smoother: the loop of robust.h, in every arithmetic, and what it is for."""

from __future__ import annotations

import ctypes
import sys
from pathlib import Path

import numpy as np
import pytest

from kalmanq import KalmanqError, Model, Quantity, ReweightedSmoother, Smoother, _core

sys.path.insert(0, str(Path(__file__).parents[2] / "tests/reference"))
from shared_library import Library  # noqa: E402

ARITHMETICS = ["f32", "f64", "q31"]


def walk_model(**changed):
    given = {"Q": 0.02, "R": 1.0, "P0": 0.02, "states": [Quantity("level", "", 2000)],
             "measurements": [Quantity("gauge", "", 2000)], **changed}
    return Model(A=1.0, H=1.0, **given)


def walk_with_a_jump(seed, rows=120, at=60, size=30.0):
    random = np.random.default_rng(seed)
    x = np.cumsum(np.sqrt(0.02) * random.standard_normal(rows)) + size * (np.arange(rows) >= at)
    return x, x + random.standard_normal(rows)


def by_hand(model, z, nu, passes, first):
    """The comment of kq_smooth_reweighted, call by call."""
    k = Library(_core.__file__, "f64")
    process, target, sensor = k.made("process", 1, 0), k.made("process", 1, 0), k.made("sensor", 1, 1)
    filter_, history, view = k.made("filter", 1), k.made("history", 1), k.made("filter", 1)
    k.call("process_init", process, k.numbers(model.A), None, k.numbers(model.Q))
    k.call("sensor_init", sensor, k.numbers(model.H), k.numbers(model.R))
    q = k.numbers(np.full(len(z) - 1, float(first)))
    for _ in range(passes):
        k.call("filter_init", filter_, k.numbers(model.x0), k.numbers(model.P0))
        k.call("attach", filter_, history)  # `attached` comes first
        for t in range(len(z)):
            if t:
                k.call("process_scale_noise", target, process, ctypes.c_double(q[t - 1]))
                k.call("predict", filter_, target, None)
            k.call("update", filter_, sensor, k.numbers(z[t:t + 1]))
        k.call("smooth_reweighted", history, target, process, ctypes.c_double(nu), q)
    means = []
    for t in range(len(z)):
        k.call("smoothed", history, t, view)
        means.append(k.read("mean", view, 0))
    return np.array(means)


@pytest.mark.parametrize("passes", [1, 2, 12])
def test_it_is_the_loop_of_the_header(passes):
    _, z = walk_with_a_jump(1)
    run = ReweightedSmoother(walk_model(), nu=2, passes=passes, first=16).run(z)
    assert np.array_equal(run.smoothed[:, 0], by_hand(walk_model(), z, 2, passes, 16))


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_one_pass_of_weight_1_is_the_plain_smoother(arithmetic):
    _, z = walk_with_a_jump(2)
    plain = Smoother(walk_model(), arithmetic).run(z)
    run = ReweightedSmoother(walk_model(), arithmetic, passes=1, first=1).run(z)
    assert np.array_equal(run.smoothed, plain.smoothed) and np.array_equal(run.smoothed_sigma, plain.smoothed_sigma)
    assert np.isnan(run.weights[0]) and np.all(run.weights[1:] == 1)


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
@pytest.mark.parametrize("seed", range(3))
def test_a_jump_is_found_and_the_filter_stays_the_plain_one(arithmetic, seed):
    x, z = walk_with_a_jump(seed)
    plain = Smoother(walk_model(), arithmetic).run(z)
    run = ReweightedSmoother(walk_model(), arithmetic).run(z)
    assert int(np.nanargmax(run.weights)) == 60
    near = slice(50, 70)
    assert np.abs(run.smoothed[near, 0] - x[near]).mean() < 0.1 * np.abs(plain.smoothed[near, 0] - x[near]).mean()
    assert np.array_equal(run.mean, plain.mean) and np.array_equal(run.log_likelihood, plain.log_likelihood)


@pytest.mark.parametrize("arithmetic", ["f32", "q31"])
def test_the_arithmetics_agree(arithmetic):
    _, z = walk_with_a_jump(4)
    z[20:25] = np.nan
    double, other = (ReweightedSmoother(walk_model(), one).run(z, covariance=True) for one in ("f64", arithmetic))
    assert np.abs(other.smoothed - double.smoothed).max() < 1e-3 * double.smoothed_sigma.min()
    assert np.allclose(other.weights[1:], double.weights[1:], rtol=1e-3)
    assert np.allclose(other.smoothed_covariance[:, 0, 0], other.smoothed_sigma[:, 0] ** 2, rtol=1e-5)


def test_two_states_and_a_control():
    model = Model(A=[[1, 1], [0, 1]], B=[0, 1], H=[1, 0], G=[0.5, 1], R=1.0, P0=[1, 1])
    random = np.random.default_rng(5)
    u = random.standard_normal(50)
    z = np.cumsum(np.cumsum(np.concatenate([[0], u[:-1]]))) + random.standard_normal(50)
    run = ReweightedSmoother(model, passes=1, first=1).run(z, u)
    assert np.array_equal(run.smoothed, Smoother(model).run(z, u).smoothed)
    assert np.abs(ReweightedSmoother(model).run(z, u).smoothed - run.smoothed).max() > 0.01


def test_what_cannot_be():
    with pytest.raises(KalmanqError, match="start"):
        ReweightedSmoother(walk_model(P0=None))
    with pytest.raises(KalmanqError, match="^passes: "):
        ReweightedSmoother(walk_model(), passes=0)
    with pytest.raises(KalmanqError, match="nu|range|reweighting"):
        ReweightedSmoother(walk_model(), nu=0).run([1.0, 2.0])
    assert len(ReweightedSmoother(walk_model()).run([])) == 0
