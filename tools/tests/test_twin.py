"""The Python twin beside the textbook, beside itself row by row, and beside the README's C program."""

from __future__ import annotations

import re
import warnings

import numpy as np
import pytest

import kalmanq
import models
from fit_cases import nile
from library import EXAMPLES, ROOT
from kalmanq import Filter, KalmanqError, KalmanqWarning, LagSmoother, InstantSmoother, Quantity, Robust, Smoother
from kalmanq.data.rows import Rows
from kalmanq.run.checks import findings
from kalmanq.run.streamed import StreamedSmoother

# of sigma, and of a covariance in sigma_i sigma_j
LIMITS = {"f64": 1e-11, "f32": 2e-4, "q31": 2e-6}
ARITHMETICS = list(LIMITS)
SEEDS = [1, 2, 3]


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("make", [models.cart, models.pair])
@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_is_the_textbook(make, arithmetic, seed):
    model = make()
    z, u = models.data(model, 200, seed)
    exact = models.textbook(model, z, u)
    run, plain, means = (Smoother(model, arithmetic).run(z, u, **more) for more in ({"covariance": True}, {}, {"covariance": True, "means_only": True}))
    sigma = np.sqrt(np.einsum("tii->ti", exact["covariance"]))
    scale = sigma[:, :, None] * sigma[:, None, :]
    limit = LIMITS[arithmetic]
    assert np.max(np.abs(run.mean - exact["mean"]) / sigma) < limit
    assert np.max(np.abs(run.covariance - exact["covariance"]) / scale) < limit
    assert all(np.max(np.abs(one.smoothed - exact["smoothed"]) / sigma) < limit for one in (run, plain, means))
    assert plain.covariance is plain.smoothed_covariance is means.smoothed_covariance is means.smoothed_sigma is None
    assert np.max(np.abs(run.smoothed_covariance - exact["smoothed_covariance"]) / scale) < limit
    assert np.max(np.abs(run.log_likelihood - exact["log_likelihood"])) < 50 * limit + 2e-6 * (arithmetic == "q31")


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_rows_blocks_and_sequences_are_the_same_bits(arithmetic):
    model = models.cart()
    z, u = models.data(model, 60, 4)
    whole, blocks, rows = (Filter(model, arithmetic) for _ in range(3))
    run = whole.run(z, u)
    parts = [blocks.run(z[a:b], u[a:b]) for a, b in ((0, 1), (1, 17), (17, 60))]
    for t in range(60):
        if t:
            rows.predict(u[t - 1])
        rows.update(z[t])
        assert np.array_equal(rows.mean, run.mean[t])
    assert np.array_equal(np.vstack([part.mean for part in parts]), run.mean)
    assert np.array_equal(whole.memory, blocks.memory) and np.array_equal(whole.memory, rows.memory)
    assert whole.log_likelihood == rows.log_likelihood
    assert np.array_equal(Smoother(model, arithmetic).run(z, u).mean, run.mean)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("arithmetic", ["f32", "f64"])
def test_rows_of_the_mean_alone_have_the_bits_of_full_steps(arithmetic, seed):
    """A sequence leaves a root that stands still alone; in a sequence of one row every step is a full one."""
    turning = kalmanq.Model([[0.27, -0.63, 0], [0.72, 0.18, 0.09], [0, -0.36, 0.45]], H=[[1, 0, 0.5], [0, 2, 0]],
                            R=[0.3, 2.0], Q=[0.1, 0.2, 0.05], P0=np.eye(3))
    stood = []
    for model in (models.cart(), turning):
        z, u = models.data(model, 900, seed)
        z[np.isnan(z)] = 0.5
        z[500, 0], z[600], z[700, -1] = np.nan, np.nan, 2000  # the root settles again, or never left
        whole, rows, roots = Filter(model, arithmetic), Filter(model, arithmetic), []
        run = whole.run(z, u)
        for t in range(len(z)):
            row = rows.run(z[t:t + 1], None if u is None else u[t:t + 1])
            for name in ("mean", "sigma", "innovation", "innovation_sigma", "nis", "taken", "log_likelihood"):
                assert np.array_equal(getattr(row, name)[0], getattr(run, name)[t], equal_nan=True), (name, t)
            roots.append(rows.memory[-model.n * (model.n + 1) // 2:])
        assert np.array_equal(whole.memory, rows.memory) and whole.log_likelihood == rows.log_likelihood
        stood.append(all(np.array_equal(roots[t], roots[t - 1]) for t in (499, 850, 899)))
    assert stood == [arithmetic == "f64", True]  # the cart's goes round in its last bits in f32


def test_the_readme_s_program_is_this():
    """What the C program of include/README.md prints, to the last digit."""
    page = (ROOT / "include" / "README.md").read_text(encoding="utf-8")
    said = re.findall(r"^(\d)  filtered ([\d.]+) \+- ([\d.]+) m, (-?[\d.]+) m/s$", page, re.M)
    ahead = re.search(r"^in 1 s +([\d.]+) \+- ([\d.]+) m$", page, re.M)
    past = re.search(r"^4  smoothed ([\d.]+) \+- ([\d.]+) m, ([\d.]+) m/s$", page, re.M)
    assert len(said) == 8 and ahead and past
    model = kalmanq.Model([[1, 0.1], [0, 1]], H=[1, 0], R=0.04, Q=[[3.3e-5, 5e-4], [5e-4, 1e-2]], P0=[100, 10])
    z = np.array([1.14, 1.02, 1.37, 1.58, np.nan, 1.79, 1.86, 2.31])
    smoother = Smoother(model, "f32")
    run = smoother.run(z)
    for t, mean, sigma, velocity in said:
        row = int(t)
        assert (mean, sigma) == (f"{run.mean[row, 0]:.3f}", f"{run.sigma[row, 0]:.3f}")
        assert velocity == f"{run.mean[row, 1]:.2f}"
    f = smoother.last.forecast(10)
    assert ahead.groups() == (f"{f.mean[0]:.3f}", f"{f.sigma[0]:.3f}")
    assert past.groups() == (f"{run.smoothed[4, 0]:.3f}", f"{run.smoothed_sigma[4, 0]:.3f}", f"{run.smoothed[4, 1]:.2f}")


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_lag_is_the_smoother_of_what_is_there(arithmetic):
    model = models.pair()
    z, _ = models.data(model, 40, 5)
    run = LagSmoother(model, 5, arithmetic).run(z)
    assert np.all(np.isnan(run.lagged[:5])) and np.all(np.isfinite(run.lagged[5:]))
    for t in (5, 11, 39):
        smoothed = Smoother(model, arithmetic).run(z[: t + 1])
        assert np.max(np.abs(run.lagged[t] - smoothed.smoothed[t - 5])) < 10 * LIMITS[arithmetic]
        assert np.max(np.abs(run.lagged_sigma[t] - smoothed.smoothed_sigma[t - 5])) < 10 * LIMITS[arithmetic]


def test_nile_with_an_unknown_start():
    model = kalmanq.Model([[1]], H=[1], R=15098.52, Q=1469.18, states=[Quantity("level", "", 4000)],
                          measurements=[Quantity("flow", "", 4000)])
    for arithmetic, limit in (("f64", 1e-5), ("f32", 1e-3), ("q31", 1e-4)):
        run = Smoother(model, arithmetic).run(nile(EXAMPLES))
        total = np.sum(run.log_likelihood[1:])
        # the first row determines the level: what its density is said to be is a matter of convention
        assert abs(np.sum(run.log_likelihood) - -633.46456) < 10 * limit
        assert np.isfinite(total) and np.all(np.isfinite(run.smoothed))
    assert abs(run.smoothed[0, 0] - 1111.7) < 0.1
    published = Smoother(model.changed(Q=1469.1, R=15099), "f64").run(nile(EXAMPLES))
    assert abs(np.sum(published.log_likelihood) + np.log(2 * np.pi) / 2 + 632.5456) < 1e-4  # Durbin and Koopman count no first row


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_robust_ways_take_an_outlier_for_one(arithmetic):
    model = models.cart()
    z, u = models.data(model, 120, 6)
    wild = z.copy()
    wild[100] = z[99] + 500 if np.isfinite(z[99, 0]) else 500
    harm = {}
    for way in (None, "gate", "huber", "student"):
        robust = Robust(way) if way else None
        runs = [Filter(model, arithmetic).run(rows, u, robust=robust) for rows in (z, wild)]
        harm[way] = np.max(np.abs(runs[0].mean[100] - runs[1].mean[100]))
    assert harm[None] > 20 * max(harm["gate"], harm["student"])
    assert harm[None] > 5 * harm["huber"]
    jumped = Filter(model, arithmetic).run(wild, u, robust=Robust("jump"))
    assert "jump" in jumped.event_names


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_an_adaptation_learns_the_noise(arithmetic):
    model = models.pair()
    z, _ = models.data(model, 4000, 7)
    adaptive = kalmanq.AdaptiveFilter(model.changed(R=model.R * 9), arithmetic, scales="sensor")
    assert abs(adaptive.run(z).scales[-1, 1] * 9 - 1) < 0.25


def test_steady_filter_is_where_the_filter_goes():
    model = models.cart()
    z, u = models.data(model, 400, 8)
    z = np.where(np.isnan(z), 0.0, z)
    for arithmetic in ARITHMETICS:
        full, steady = Filter(model, arithmetic).run(z, u), kalmanq.SteadyFilter(model, arithmetic).run(z, u)
        assert np.max(np.abs(full.mean[-1] - steady.mean[-1])) < 1e-3
    state = kalmanq.steady_state(model)
    P = state.predicted
    assert np.allclose(P, model.A @ state.filtered @ model.A.T + model.Q, rtol=1e-10)


def test_sequences_on_several_cores_are_those_on_one():
    model = models.pair()
    sequences = [models.data(model, 300, seed)[0] for seed in range(6)]
    many = kalmanq.run_many(sequences, lambda z: Smoother(model, "q31").run(z))
    for z, run in zip(sequences, many):
        assert np.array_equal(run.smoothed, Smoother(model, "q31").run(z).smoothed)


def test_what_saturates_warns_and_what_is_out_of_range_is_refused():
    model = kalmanq.Model([[1.5]], H=[1], R=1.0, Q=1.0, P0=[1], states=[Quantity("x", "", 8)],
                          measurements=[Quantity("z", "", 8)])
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        run = Filter(model, "q31").run(np.r_[8.0, np.full(20, np.nan)])
    assert run.event_names == ["saturated"] and any(one.category is KalmanqWarning for one in caught)
    with pytest.raises(KalmanqError, match="row 1: z = 9: .*range") as refused:
        Filter(model, "q31").run([1.0, 9.0])
    assert refused.value.row == 1


@pytest.mark.parametrize("wrong, said", [
    (dict(A=[[1, 2]]), "A: is 1 x 2, not square"),
    (dict(H=[1]), "H: is 1 x 1"),
    (dict(R=-1.0), "R: has a negative variance"),
    (dict(R=[[1, 2], [3, 4]]), "R: is 2 x 2"),
    (dict(Q=[[1, 0.5], [0, 1]]), "Q: is not symmetric"),
    (dict(Q=None), "Q: give either"),
    (dict(x0=[1]), "x0: is 1, not 2"),
    (dict(x0=[1, float("nan")]), "x0: has an entry"),
    (dict(A=[["a", 1], [0, 1]]), "A: not an array"),
    (dict(states=["a"]), "states: are 1, not 2"),
    (dict(states=["a", "a"]), "states: have one name twice"),
    (dict(unknown=["c"]), "unknown: there is no state 'c'"),
])
def test_a_model_that_is_none_says_why(wrong, said):
    right = dict(A=[[1, 1], [0, 1]], H=[1, 0], R=1.0, Q=[1, 1], P0=[1, 1])
    with pytest.raises(kalmanq.ModelError, match="^" + re.escape(said)):
        kalmanq.Model(**{**right, **wrong})


def test_shapes_of_data_are_checked():
    f = Filter(models.cart())
    for z, u in (([[1, 2]], None), ([1, 2], [1]), (["a"], None), ([1.0], [[1, 2]])):
        with pytest.raises(KalmanqError):
            f.run(z, u)
    with pytest.raises(KalmanqError, match="fixed point"):
        Filter(kalmanq.Model([[1]], H=[1], R=1, Q=1, P0=[1]), "q31")
    with pytest.raises(KalmanqError):
        f.forecast(-1)


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_a_start_that_is_never_known_has_no_covariance(arithmetic):
    model = kalmanq.Model(np.eye(2), H=[1, 0], R=1, Q=np.eye(2), P0=None, states=[Quantity("a", range=50), Quantity("b", range=50)],
                          measurements=[Quantity("z", range=50)])
    run = Smoother(model, arithmetic).run([1.0, 2.0, 3.0], covariance=True)
    assert np.all(np.isnan(run.smoothed_covariance)) and np.all(np.isnan(run.smoothed[:, 1]))


# ------------------------------------------------------------------------------ sigmas of q31


def wide() -> kalmanq.Model:
    """Its prior is twice as wide as the range that the velocity declares, and it settles at 1e-4 of a range."""
    return kalmanq.Model(
        [[1, 1], [0, 1]], H=[1, 0], R=1.0, Q=[1e-10, 1e-13], P0=[100, 100],
        states=[kalmanq.Quantity("position", range=1e5), kalmanq.Quantity("velocity", range=5)],
        measurements=[kalmanq.Quantity("z", range=1e5)])


@pytest.mark.parametrize("seed", SEEDS)
def test_a_sigma_of_q31_is_that_of_its_covariance(seed):
    """A word of sigma ends at the range, and near 0 it has few bits."""
    model = wide()
    z = np.random.default_rng(seed).normal(size=(400, 1))
    z[50:60] = np.nan
    exact, limit = models.textbook(model, z, None), 1e-6
    sigma, smoothed = (np.sqrt(np.einsum("tii->ti", exact[name])) for name in ("covariance", "smoothed_covariance"))
    with pytest.warns(KalmanqWarning, match="sigma of velocity is 10, .* 5: raise"):
        f = Filter(model, "q31")
        run = f.run(z)
    assert np.max(np.abs(run.sigma / sigma - 1)) < limit and np.max(np.abs(f.sigma / sigma[-1] - 1)) < limit
    with pytest.warns(KalmanqWarning, match="velocity"):
        run = Smoother(model, "q31").run(z)
    assert np.max(np.abs(run.smoothed_sigma / smoothed - 1)) < 10 * limit
    with pytest.warns(KalmanqWarning, match="velocity"):
        run = LagSmoother(model, 3, "q31").run(z)
    assert np.max(np.abs(run.lagged_sigma[-1] / LagSmoother(model, 3).run(z).lagged_sigma[-1] - 1)) < 10 * limit
    with pytest.warns(KalmanqWarning, match="velocity"):
        run = InstantSmoother(model, 0, "q31").run(z, covariance=True)
    assert np.array_equal(run.instant_sigma, np.sqrt(np.einsum("tii->ti", run.instant_covariance)))


def test_a_sigma_within_its_range_is_not_warned_of():
    model = wide().changed(P0=[100, 24])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        Filter(model, "q31").run(np.zeros((5, 1)))
        Filter(wide(), "f32").run(np.zeros((5, 1)))
    lost = np.full((3000, 1), np.nan)  # it grows beyond its range without a measurement
    with pytest.warns(KalmanqWarning, match="the sigma of position"):
        Filter(model.changed(states=[Quantity("position", range=1e3), model.states[1]],
                                     P0=[100, 20]), "q31").run(lost)


# ------------------------------------------------------------------------------ smoothed in blocks


def unknown(model):
    return model.changed(P0=None, unknown="all")


@pytest.mark.parametrize("block", [64, 700, 65536])
@pytest.mark.parametrize("make", [models.cart, models.pair, lambda: unknown(models.pair()), lambda: unknown(models.cart())])
@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_a_streamed_smoother_is_the_smoother_to_the_bit(arithmetic, make, block, tmp_path):
    model = make()
    z, u = models.data(model, 1500, 6)
    z[:3] = np.nan
    whole = Smoother(model, arithmetic)
    exact, made = whole.run(z, u), []
    with StreamedSmoother(model, arithmetic, tmp_path, block) as smoother:
        for first in range(0, 1500, 97):
            smoother.add(Rows(z, u)[first : first + 97])
        for _, rows in smoother.rows():
            smoother.take(rows)
        for first, given, run in smoother.smoothed():
            assert np.array_equal(given.z, z[first : first + block], equal_nan=True)
            made.append(run)
        assert np.array_equal(smoother.filter.memory, whole.last.memory)
        assert list(tmp_path.iterdir()) == []  # nothing is left by one that is killed
    columns = [run.columns() for run in made]
    for name, column in exact.columns().items():
        assert np.array_equal(np.concatenate([one[name] for one in columns]), column, equal_nan=True), name
    assert made[-1].events == exact.events


def test_ranges_that_are_there_in_part_may_be_left_out():
    for ranges, said in (((4.0, None), True), ((4.0, 8.0), False), ((None, None), False)):
        model = kalmanq.Model([1], H=[1], R=1, Q=1, P0=[1], states=[Quantity("a", range=ranges[0])], measurements=[Quantity("b", range=ranges[1])])
        found = [one for one in findings(model) if one.subject == "ranges"]
        assert any(not one.is_good and "or leave all ranges out" in one.said for one in found) == said
