"""Matrices that are others at each row: beside the joint normal of all rows in long double."""

from __future__ import annotations

import numpy as np
import pytest
from dense import Steps, conditioned

from kalmanq import (
    AdaptiveFilter, Filter, FrozenGainFilter, InstantSmoother, KalmanqError, LagSmoother, Model, Quantity, Smoother, Varying,
    likelihood)

ROWS = 30


def random_record(seed: int, rounded: bool = False, rows: int = ROWS):
    """Another model at each row, n = 1 to 4, m = 1 to 3, with controls and gaps; rounded: of floats"""
    draw = np.random.default_rng(seed)
    n, m, l = 1 + seed % 4, 1 + seed % 3, 1 + seed % 2
    A = np.linalg.qr(draw.normal(size=(rows, n, n)))[0] * draw.uniform(0.5, 1.05, (rows, 1, 1))
    roots = [draw.normal(size=(rows, k, k)) * 10.0 ** draw.uniform(-1, 0, (rows, 1, 1)) for k in (n, m)]
    Q, R = (root @ root.swapaxes(1, 2) + 0.01 * np.eye(root.shape[1]) for root in roots)
    made = Steps(A, draw.normal(size=(rows, n, l)), Q, draw.normal(size=(rows, m, n)), R)
    u, x, z = draw.normal(size=(rows, l)), draw.normal(0, 2, n), np.empty((rows, m))
    for t in range(rows):
        z[t] = made.H[t] @ x + np.linalg.cholesky(made.R[t]) @ draw.normal(size=m)
        x = made.A[t] @ x + made.B[t] @ u[t] + np.linalg.cholesky(made.Q[t]) @ draw.normal(size=n)
    z[draw.random(z.shape) < 0.2] = np.nan
    z[5] = np.nan
    if rounded:
        made = Steps(*(one.astype(np.float32).astype(float) for one in made))
        z, u = (one.astype(np.float32).astype(float) for one in (z, u))
    names = [[Quantity(f"{letter}{k}", "", span) for k in range(size)] for letter, size, span in
             (("x", n, 200), ("z", m, 400), ("u", l, 40))]
    model = Model(np.eye(n), H=np.eye(m, n), R=np.eye(m), Q=np.eye(n), B=np.zeros((n, l)), P0=np.full(n, 4.0), states=names[0],
                  measurements=names[1], controls=names[2])
    return model, made, z, u


def varying(made: Steps, rows: slice = slice(None)) -> Varying:
    return Varying(**{name: one[rows] for name, one in made._asdict().items()})


def errors(run, right) -> float:
    """In sigma, and of sigma and of covariances"""
    def off(mean, sigma, covariance, of_mean, of_covariance):
        exact = np.sqrt(np.diagonal(of_covariance, axis1=1, axis2=2))
        both = exact[:, :, None] * exact[:, None, :]
        return [np.abs((mean - of_mean) / exact).max(), np.abs(sigma / exact - 1).max(),
                np.abs((covariance - of_covariance) / both).max()]

    return float(max(*off(run.mean, run.sigma, run.covariance, right.mean, right.covariance),
                     *off(run.smoothed, run.smoothed_sigma, run.smoothed_covariance, right.smoothed, right.smoothed_covariance)))


@pytest.mark.parametrize("arithmetic, most", [("f64", 1e-10), ("f32", 1e-5), ("q31", 1e-5)])
@pytest.mark.parametrize("seed", range(8))
def test_all_matrices_beside_the_joint_normal(seed, arithmetic, most):
    model, made, z, u = random_record(seed, arithmetic == "f32")
    right = conditioned(model.x0, model.P0, made, z, u)
    run = Smoother(model, arithmetic).run(z, u, varying=varying(made), covariance=True)
    assert errors(run, right) < most
    assert abs(run.log_likelihood.sum() - right.log_likelihood) < most * (1 + abs(right.log_likelihood))


@pytest.mark.parametrize("name", ["A", "B", "Q", "H", "R", "AB", "HR", "AH"])
@pytest.mark.parametrize("arithmetic, most", [("f64", 1e-12), ("q31", 1e-6)])
def test_some_matrices_beside_the_joint_normal(name, arithmetic, most):
    """What does not vary is the model's"""
    for seed in (2, 6, 7):
        model, made, z, u = random_record(seed)
        model = model.changed(**{key: one[0] for key, one in made._asdict().items()})
        made = Steps(*(one if key in name else np.tile(one[0], (ROWS, 1, 1)) for key, one in made._asdict().items()))
        given = Varying(**{key: getattr(made, key) for key in name})
        run = Smoother(model, arithmetic).run(z, u, varying=given, covariance=True)
        assert errors(run, conditioned(model.x0, model.P0, made, z, u)) < most


@pytest.mark.parametrize("arithmetic", ["f32", "f64", "q31"])
def test_the_same_matrices_at_each_row_are_the_model(arithmetic):
    """Bit for bit, from a noise factor of lower rank and an unknown start, too"""
    for more in ({"Q": [0.01, 0.02]}, {"G": [0.1, 0.2]}, {"Q": [0.01, 0.02], "P0": None}):
        model = Model([[1, 0.1], [0, 0.9]], H=[[1, 0], [1, 1]], R=[0.1, 0.2], **{"P0": [1, 1], **more},
                      states=[Quantity("a", "", 100), Quantity("b", "", 100)],
                      measurements=[Quantity("y", "", 100), Quantity("z", "", 100)])
        z = np.cumsum(np.random.default_rng(3).normal(size=(60, 2)), axis=0)
        z[4, 1] = z[9] = np.nan
        plain = Smoother(model, arithmetic).run(z, covariance=True)
        for key in ("A", "H", "R", "Q", "AHR")[:5 if "Q" in more else 3]:
            given = Varying(**{one: np.tile(getattr(model, one), (60, 1, 1)) for one in key})
            run = Smoother(model, arithmetic).run(z, varying=given, covariance=True)
            for name in ("mean", "sigma", "innovation", "innovation_sigma", "nis", "log_likelihood", "smoothed",
                         "smoothed_sigma", "smoothed_covariance"):
                assert np.array_equal(getattr(plain, name), getattr(run, name), equal_nan=True), (key, name)


@pytest.mark.parametrize("arithmetic", ["f32", "f64", "q31"])
def test_blocks_of_rows_are_the_whole(arithmetic):
    """The last row's matrices move the state to the next call's first row"""
    model, made, z, u = random_record(5)
    whole = Filter(model, arithmetic).run(z, u, varying=varying(made))
    f, parts = Filter(model, arithmetic), []
    for rows in (slice(0, 1), slice(1, 9), slice(9, 30)):
        parts.append(f.run(z[rows], u[rows], varying=varying(made, rows)))
    for name in ("mean", "sigma", "nis", "log_likelihood", "innovation_sigma"):
        assert np.array_equal(np.concatenate([getattr(one, name) for one in parts]), getattr(whole, name), equal_nan=True)
    alone = Filter(model, arithmetic)
    alone.run(z[:9], u[:9], varying=varying(made, slice(0, 9)))
    left = alone.copy()
    left.predict(u[8])
    alone.predict(u[8])
    two = Filter(model, arithmetic)
    two.run(z[:9], u[:9], varying=varying(made, slice(0, 9)))
    several = [two.copy() for _ in range(3)]
    for _ in range(5):
        two.run(z[9:12], u[9:12], varying=varying(made, slice(9, 12)))
    ahead = made.A[8] @ whole.mean[8] + made.B[8] @ u[8]
    assert all(np.allclose(one.forecast(1, u[8:9]).mean, ahead, rtol=1e-5, atol=1e-5) for one in several)
    assert np.allclose(several[0].forecast(3, u[8:11]).mean, ahead, rtol=1e-5, atol=1e-5)  # the model's own A is I, its B is 0
    for one in (left, alone):
        assert np.allclose(one.mean, ahead, rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize("arithmetic, most", [("f64", 1e-9), ("f32", 1e-4), ("q31", 1e-4)])
def test_smoothers_on_line_are_the_smoother(arithmetic, most):
    for seed in (1, 2, 7):
        model, made, z, u = random_record(seed, True)
        lagged = LagSmoother(model, 6, arithmetic).run(z, u, varying=varying(made))
        instant = InstantSmoother(model, 4, arithmetic).run(z, u, varying=varying(made))
        for t in (12, 20, 29):
            right = conditioned(model.x0, model.P0, made, z[:t + 1], u)
            for row, run, mean, sigma in ((t - 6, lagged, "lagged", "lagged_sigma"), (4, instant, "instant", "instant_sigma")):
                exact = np.sqrt(np.diag(right.smoothed_covariance[row]))
                assert np.abs((getattr(run, mean)[t] - right.smoothed[row]) / exact).max() < most
                assert np.abs(getattr(run, sigma)[t] / exact - 1).max() < most


def test_a_frozen_gain_begins_again_where_the_matrices_change():
    model = Model(1, H=1, R=1, Q=0.1, P0=1)
    z = np.random.default_rng(1).normal(size=200)
    A = np.ones(200)
    A[120] = 0.5
    run = FrozenGainFilter(model).run(z, varying=Varying(A=A))
    assert run.settled[100] and not run.settled[121] and run.settled[-1]
    exact = Filter(model).run(z, varying=Varying(A=A))
    assert np.abs((run.mean - exact.mean) / exact.sigma).max() < 0.01


def test_rows_of_one_sensor_stay_fast_and_the_same():
    """A steady filter of n = 2 rests on what it found; another R in the middle of it is seen at once"""
    model = Model([[1, 0.1], [0, 1]], H=[1, 0], R=0.1, Q=[0.01, 0.02], P0=[1, 1])
    z = np.random.default_rng(1).normal(size=3000)
    R = np.full(3000, 0.1)
    R[1500] = 40.0
    run = Filter(model).run(z, varying=Varying(R=R))
    plain = Filter(model).run(z[:1500])
    assert np.array_equal(plain.mean, run.mean[:1500])
    assert run.innovation_sigma[1500, 0] ** 2 == pytest.approx(40 - 0.1 + run.innovation_sigma[1499, 0] ** 2, rel=1e-9)
    assert run.sigma[1500, 0] > 1.05 * run.sigma[1499, 0]
    assert abs(run.sigma[-1, 0] / run.sigma[1499, 0] - 1) < 1e-12


def test_the_likelihood_of_records():
    model, made, z, u = random_record(2)
    right = conditioned(model.x0, model.P0, made, z, u)
    found = likelihood(model, [z, z], [u, u], varying=[varying(made), varying(made)])
    assert abs(found / (2 * float(right.log_likelihood)) - 1) < 1e-12


def test_an_adaptation_refuses_what_varies():
    with pytest.raises(KalmanqError, match="one process"):
        AdaptiveFilter(Model(1, H=1, R=1, Q=0.1, P0=1)).run(np.zeros(9), varying=Varying(A=np.ones(9)))


@pytest.mark.parametrize("given, said", [
    ({"A": np.ones((29, 2, 2))}, "A is 29 x 2 x 2, not 30 x 2 x 2"), ({"H": np.ones((30, 3))}, "H is 30 x 3, not 30 x 1 x 2"),
    ({"H": np.ones((30, 1, 3))}, "H is 30 x 1 x 3, not 30 x 1 x 2"), ({"H": np.ones((29, 2))}, "H is 29 x 2, not 30 x 1 x 2"),
    ({"H": np.full((30, 2), np.nan)}, "row 0: H .*finite"),
    ({"Q": np.full((30, 2, 2), np.nan)}, "row 0: Q .*finite"),
    ({"B": np.ones((30, 2, 1))}, "^B: .*controls"),
    ({"Q": -np.ones((30, 2))}, "row 0: .*Q"), ({"R": np.full((30, 1, 1), -1.0)}, "row 0: .*R"),
    ({"A": "x"}, "^A: .*array")])
@pytest.mark.parametrize("arithmetic", ["f64", "f32", "q31"])
def test_what_does_not_fit_is_refused(given, said, arithmetic):
    model = Model(np.eye(2), H=[1, 1], R=1, Q=[1, 1], P0=[1, 1], states=[Quantity("a", "", 9), Quantity("b", "", 9)],
                  measurements=[Quantity("z", "", 9)])
    with pytest.raises(KalmanqError, match=said):
        Filter(model, arithmetic).run(np.zeros(30), varying=Varying(**given))


def test_a_value_beyond_its_range_names_the_row():
    model = Model(1, H=1, R=1, Q=1, P0=1, states=[Quantity("x", "", 9)], measurements=[Quantity("z", "", 64)])
    with pytest.raises(KalmanqError, match="row 17: z = 70: .*range"):
        Smoother(model, "q31").run(70.0 * (np.arange(30) == 17), varying=Varying(H=np.ones(30)))


def test_from_an_unknown_start_it_is_least_squares():
    """Constant coefficients: each row's smoothed state is the solution of all rows"""
    draw = np.random.default_rng(7)
    H = np.column_stack([np.ones(80), draw.normal(0, 2, 80)])
    z = H @ [1.5, 1.0] + draw.normal(0, 0.5, 80)
    z[[5, 6, 40]] = np.nan
    there = ~np.isnan(z)
    run = Smoother(Model(np.eye(2), H=[1, 1], R=0.25, Q=[0, 0])).run(z, varying=Varying(H=H))
    exact = np.linalg.lstsq(H[there], z[there], rcond=None)[0]
    assert np.allclose(run.smoothed, exact, rtol=0, atol=1e-12)
    spread = np.sqrt(np.diag(np.linalg.inv(H[there].T @ H[there])) * 0.25)
    assert np.allclose(run.smoothed_sigma, spread, rtol=1e-11)


@pytest.mark.parametrize("arithmetic", ["f32", "f64", "q31"])
def test_a_covariance_is_nan_until_the_start_is_known(arithmetic):
    """In a run as row by row; it was the finite part alone"""
    model = Model([[1, 1], [0, 1]], H=[1, 0], R=0.1, Q=[0.01, 0.02], unknown=["level"], P0=[0, 1],
                  states=[Quantity("level", "", 100), Quantity("slope", "", 10)], measurements=[Quantity("z", "", 100)])
    alone, z = Filter(model, arithmetic), np.array([np.nan, np.nan, 1.0, 2.0])
    for t, covariance in enumerate(Filter(model, arithmetic).run(z, covariance=True).covariance):
        alone.run(z[t:t + 1])
        assert np.array_equal(covariance, alone.covariance, equal_nan=True), t
        assert np.isnan(covariance).all() == (t < 2)
