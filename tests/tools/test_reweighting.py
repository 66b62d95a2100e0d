"""The reweighted smoother: the loop of robust.h, in every arithmetic, and what it is for."""

from __future__ import annotations

import numpy as np
import pytest

from kalmanq import KalmanqError, Model, Quantity, ReweightedSmoother, Smoother
from kalmanq.core import ffi, lib, require

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
    number = lambda value: ffi.new("double[]", list(np.ravel(value)))
    process, target, sensor = (ffi.new(f"kq_{name}_f64 *") for name in ("process", "process", "sensor"))
    filter_, history = ffi.new("kq_filter_f64 *"), ffi.new("kq_history_f64 *")
    length = int(lib.kq_length_f64(lib.KQ_OBJECT_HISTORY, 1, 1, len(z), 0))
    memory = [ffi.new("double[]", size) for size in (64, 64, 64, 64, length)]
    require(lib.kq_process_assign_f64(process, 1, 0, memory[0], 64), "process")
    require(lib.kq_process_assign_f64(target, 1, 0, memory[1], 64), "target")
    require(lib.kq_sensor_assign_f64(sensor, 1, 1, memory[2], 64), "sensor")
    require(lib.kq_filter_assign_f64(filter_, 1, memory[3], 64), "filter")
    require(lib.kq_history_assign_f64(history, 1, memory[4], length), "history")
    A, H = number(model.A), number(model.H)
    require(lib.kq_process_init_f64(process, A, ffi.NULL, number(model.Q)), "process")
    require(lib.kq_sensor_init_f64(sensor, H, number(model.R)), "sensor")
    q = number(np.full(len(z) - 1, first))
    for _ in range(passes):
        require(lib.kq_filter_init_f64(filter_, number(model.x0), number(model.P0)), "start")
        require(lib.kq_attach_f64(filter_, ffi.addressof(history[0], "attached")), "history")
        for t, value in enumerate(z):
            if t:
                require(lib.kq_process_scale_noise_f64(target, process, q[t - 1]), "scale")
                require(lib.kq_predict_f64(filter_, target, ffi.NULL), "predict")
            require(lib.kq_update_f64(filter_, sensor, number(value)), "update")
        require(lib.kq_smooth_reweighted_f64(history, target, process, nu, q), "smooth")
    view, means = ffi.new("kq_filter_f64 *"), []
    for t in range(len(z)):
        require(lib.kq_smoothed_f64(history, t, view), "smoothed")
        means.append(lib.kq_mean_f64(view, 0))
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
    with pytest.raises(KalmanqError, match="known start"):
        ReweightedSmoother(walk_model(P0=None))
    with pytest.raises(KalmanqError, match="passes: below 1"):
        ReweightedSmoother(walk_model(), passes=0)
    with pytest.raises(KalmanqError, match="nu|range|reweighting"):
        ReweightedSmoother(walk_model(), nu=0).run([1.0, 2.0])
    assert len(ReweightedSmoother(walk_model()).run([])) == 0
