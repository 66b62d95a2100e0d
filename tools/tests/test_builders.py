"""Textbook models by name: their matrices beside formulas, stationary covariances beside SciPy, and what is refused."""

import math

import numpy as np
import pytest
from kalmanq import Model, Smoother
from kalmanq.errors import ModelError
from kalmanq.model import builders
from scipy import integrate, linalg

EPS = np.finfo(float).eps


def built(name, **given):
    return builders.build(name, {key: value if isinstance(value, (int, float)) else np.array(value, float)
                                 for key, value in given.items()})


def assert_is(made, **expected):
    for name, value in expected.items():
        np.testing.assert_allclose(made[name], np.array(value, float).reshape(made[name].shape), rtol=16 * EPS, atol=0)


def noise_of(made):
    return made["G"] @ made["G"].T


def assert_stationary(made, tolerance):
    """P0 solves P = A P A' + Q, and is what SciPy finds."""
    A, P, Q = made["A"], made["P0"], noise_of(made)
    size = np.sqrt(np.outer(np.diag(P), np.diag(P)))
    assert np.all(np.abs(A @ P @ A.T + Q - P) <= tolerance * size)
    assert np.all(np.abs(linalg.solve_discrete_lyapunov(A, Q) - P) <= 100 * tolerance * size)
    assert np.linalg.eigvalsh(P).min() >= -tolerance * size.max()


# ------------------------------------------------------------------------------ ARMA


def test_an_autoregression_is_a_companion():
    gamma = 4 * 0.75 / (1.25 * (0.5625 - 0.25))  # (1 - b) / ((1 + b) ((1 - b)^2 - a^2))
    lag = gamma * 0.5 / 0.75
    assert_is(built("ar", phi=[0.5, 0.25], variance=4, noise=3), A=[[0.5, 0.25], [1, 0]], G=[2, 0], H=[1, 0], R=[3],
              P0=[[gamma, lag], [lag, gamma]], x0=[0, 0])


def test_a_moving_average_remembers_the_noises():
    assert_is(built("ma", theta=[0.5], variance=4), A=[[0, 1], [0, 0]], G=[0, 2], H=[0.5, 1], P0=[[4, 0], [0, 4]],
              R=[0])


def test_an_arma_is_both():
    assert_is(built("arma", phi=[0.5], theta=[-0.25], variance=1), A=[[0.5, 0], [1, 0]], G=[1, 0], H=[1, -0.25],
              P0=[[4 / 3, 2 / 3], [2 / 3, 4 / 3]])


@pytest.mark.parametrize("seed", range(8))
def test_the_covariance_is_stationary(seed):
    """Random autoregressions whose partial autocorrelations are below 1, and moving averages on top."""
    random = np.random.default_rng(seed)
    phi = np.zeros(0)
    for k in random.uniform(-0.9, 0.9, random.integers(1, 9)):
        phi = np.append(phi - k * phi[::-1], k)
    assert_stationary(built("ar", phi=phi, variance=2), 1e-10)
    made = built("arma", phi=phi, theta=random.uniform(-1, 1, random.integers(1, 5)), variance=2)
    assert_stationary(made, 1e-10)
    assert_stationary(built("ma", theta=random.uniform(-1, 1, 3), variance=3), 1e-15)


@pytest.mark.parametrize("phi", [[1.0, 0.0], [-1.0, 0.0], [0.5, 0.5], [1.1, 0.0], [0.0, 1.0], [0.0, -1.0], [2.0, -1.0]])
def test_what_is_not_stationary_is_refused(phi):
    for name, given in (("ar", {}), ("arma", {"theta": [0.5]})):
        with pytest.raises(ModelError, match="not stationary"):
            built(name, phi=phi, variance=1, **given)
    with pytest.raises(ModelError, match="not stationary"):
        built("factor", loadings=[[1, 1]], transition=[phi, [1, 0]], noise=[1])


# ------------------------------------------------------------------------------ structural models


def test_a_level_walks():
    assert_is(built("level", drift=9, noise=4, mean=5, variance=6), A=[1], G=[3], H=[1], R=[4], x0=[5], P0=[6])


def test_a_trend_has_a_slope():
    assert_is(built("trend", drift=[4, 9], noise=7, mean=[1, 2], variance=[3, 5]), A=[[1, 1], [0, 1]],
              G=[[2, 0], [0, 3]], H=[1, 0], R=[7], x0=[1, 2], P0=[[3, 0], [0, 5]])
    assert_is(built("trend", drift=[4, 9], noise=7, variance=[3, 5]), x0=[0, 0])


@pytest.mark.parametrize("seasons", [2, 3, 17])
def test_a_season_adds_up_to_its_noise(seasons):
    n = seasons - 1
    A = np.vstack([-np.ones(n), np.eye(n)[:-1]])
    assert_is(built("season", seasons=seasons, drift=4, noise=1, variance=np.ones(n)), A=A, G=2 * np.eye(n)[:, 0],
              H=np.eye(n)[0], P0=np.eye(n))


@pytest.mark.parametrize("seasons", [3, 15])
def test_a_trend_may_have_a_season(seasons):
    n = seasons - 1
    season = np.vstack([-np.ones(n), np.eye(n)[:-1]])
    G = np.zeros((n + 2, 3))
    G[range(3), range(3)] = 2, 3, 4
    assert_is(built("trend_season", seasons=seasons, drift=[4, 9, 16], noise=1, variance=np.ones(n + 2)),
              A=linalg.block_diag([[1, 1], [0, 1]], season), G=G, H=np.eye(n + 2)[0] + np.eye(n + 2)[2])


def test_coefficients_of_a_regression_walk():
    assert_is(built("regression", regressors=[2, 5], drift=[4, 0], noise=7, mean=[1, 2], variance=[3, 5]),
              A=np.eye(2), G=[[2, 0], [0, 0]], H=[2, 5], R=[7], x0=[1, 2], P0=[[3, 0], [0, 5]])


def test_factors_are_stationary():
    made = built("factor", loadings=[[1, 0.5], [0, 1], [2, -1]], transition=[[0.5, 0.25], [0, 0.5]], drift=[1, 4],
                 noise=[1, 2, 3])
    assert_is(made, A=[[0.5, 0.25], [0, 0.5]], G=[[1, 0], [0, 2]], H=[[1, 0.5], [0, 1], [2, -1]], R=[1, 2, 3])
    assert_stationary(made, 16 * EPS)
    assert made["P0"][1, 1] == pytest.approx(16 / 3, rel=8 * EPS)


# ------------------------------------------------------------------------------ motion


@pytest.mark.parametrize("name, order", [("constant_velocity", 2), ("constant_acceleration", 3)])
@pytest.mark.parametrize("axes", [1, 2, 3])
def test_the_noise_of_a_motion_is_its_integral(name, order, axes):
    dt, density = 0.5, np.array([4.0, 9.0, 1.0])[:axes]
    n, noise, variance = order * axes, np.arange(1.0, axes + 1), np.arange(1.0, order * axes + 1)
    made = Model.of_continuous(**built(name, dt=dt, density=density, noise=noise, variance=variance))
    powers = [lambda s, i=i: s ** (order - 1 - i) / math.factorial(order - 1 - i) for i in range(order)]
    Q = [[integrate.quad(lambda s: a(s) * b(s), 0, dt)[0] for b in powers] for a in powers]
    A = [[dt ** (j - i) / math.factorial(j - i) if j >= i else 0 for j in range(order)] for i in range(order)]
    assert_is(vars(made), A=linalg.block_diag(*[A] * axes), H=np.eye(n)[::order], R=np.diag(noise), P0=np.diag(variance))
    expected = linalg.block_diag(*(one * np.array(Q) for one in density))
    np.testing.assert_allclose(made.Q, expected, rtol=1e-13, atol=1e-16)
    assert np.all(np.tril(made.A, -1) == 0)


# ------------------------------------------------------------------------------ continuous time


def flow(name, dt, **given):
    return Model.of_continuous(**built(name, dt=dt, **given))


@pytest.mark.parametrize("dt", [1e-3, 0.4, 30.0])
def test_a_bias_that_fades_is_its_closed_form(dt):
    tau, sigma = np.array([2.0, 50.0]), np.array([3.0, 0.1])
    made = flow("gauss_markov", dt, time_constant=tau, sigma=sigma, noise=[1, 1])
    assert_is(vars(made), A=np.diag(np.exp(-dt / tau)), Q=np.diag(-(sigma**2) * np.expm1(-2 * dt / tau)), P0=np.diag(sigma**2), H=np.eye(2))


@pytest.mark.parametrize("dt", [1e-3, 0.4, 30.0])
def test_a_clock_is_its_closed_form(dt):
    made = flow("clock", dt, density=[2.0, 0.5], noise=1, variance=[1, 1])
    assert_is(vars(made), A=[[1, dt], [0, 1]], Q=[[2 * dt + 0.5 * dt**3 / 3, 0.25 * dt**2], [0.25 * dt**2, 0.5 * dt]])
    walk = flow("random_walk", dt, density=[2.0, 0.5], noise=[1, 1], variance=[1, 1])
    assert_is(vars(walk), A=np.eye(2), Q=np.diag([2 * dt, 0.5 * dt]))


@pytest.mark.parametrize("damping", [0.0, 0.1, 2.0])
def test_an_oscillator_is_its_closed_form(damping):
    dt, w = 0.3, 2 * math.pi / 1.7
    made = flow("oscillator", dt, period=1.7, damping=damping, density=1, noise=1, variance=[1, 1])
    root = w * np.sqrt(complex(damping**2 - 1))
    c, s = np.cosh(root * dt).real, (np.sinh(root * dt) / root).real
    A = math.exp(-damping * w * dt) * np.array([[c + damping * w * s, s], [-w * w * s, c - damping * w * s]])
    np.testing.assert_allclose(made.A, A, rtol=0, atol=64 * EPS * w)


@pytest.mark.parametrize("name, given", [("gauss_markov", dict(time_constant=[3.0], sigma=[2.0], noise=[1])), *(
    ("gaussian_process", dict(smoothness=nu, length=1.5, sigma=2.0, noise=1)) for nu in (0.5, 1.5, 2.5))])
def test_a_process_that_stays_has_a_prior_that_stays(name, given):
    made = flow(name, 0.7, **given)
    np.testing.assert_allclose(made.A @ made.P0 @ made.A.T + made.Q, made.P0, rtol=1e-12, atol=1e-13)


def matern(nu, r):
    a = math.sqrt(2 * nu) * r
    return {0.5: 1, 1.5: 1 + a, 2.5: 1 + a + a * a / 3}[nu] * np.exp(-a)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("nu", [0.5, 1.5, 2.5])
def test_a_gaussian_process_is_the_regression_by_its_kernel(nu, seed):
    """Mean and sigma at 60 times that are not a grid, some without a measurement; Rasmussen and Williams (2006), 2.25"""
    draw, length, sigma, noise = np.random.default_rng(seed), 1.3, 1.7, 0.04
    times, z = np.cumsum(draw.exponential(0.4, 60)), draw.normal(size=60)
    z[draw.random(60) < 0.3] = np.nan
    run = Smoother(flow("gaussian_process", 0.1, smoothness=nu, length=length, sigma=sigma, noise=noise)).run(z, times=times)
    there = ~np.isnan(z)
    K = sigma**2 * matern(nu, np.abs(np.subtract.outer(times, times)) / length)
    gain = np.linalg.solve(K[np.ix_(there, there)] + noise * np.eye(there.sum()), K[there]).T
    np.testing.assert_allclose(run.smoothed[:, 0], gain @ z[there], rtol=0, atol=1e-8)
    np.testing.assert_allclose(run.smoothed_sigma[:, 0], np.sqrt(np.diag(K - gain @ K[there])), rtol=0, atol=1e-8)


def test_waves_repeat_after_a_period():
    made = flow("trend_harmonic", 0.5, period=12, harmonics=3, density=[0, 0, 0], noise=1, variance=np.ones(8))
    again = np.linalg.matrix_power(made.A[2:, 2:], 24)
    np.testing.assert_allclose(again, np.eye(6), rtol=0, atol=1e-13)
    np.testing.assert_allclose(made.A[:2, :2], [[1, 0.5], [0, 1]], rtol=0, atol=EPS)
    assert made.H.tolist() == [[1, 0, 1, 0, 1, 0, 1, 0]] and [one.name for one in made.states][:4] == ["level", "slope", "wave_1", "wave_1_turned"]
    seasonal = flow("harmonic", 1.0, period=4, harmonics=2, density=0.0, noise=1, variance=np.ones(4))
    effects = [(seasonal.H @ np.linalg.matrix_power(seasonal.A, t))[0] for t in range(4)]
    np.testing.assert_allclose(np.sum(effects, axis=0), np.zeros(4), rtol=0, atol=1e-14)  # they add up to 0, as those of a season do


@pytest.mark.parametrize("name, change, key", [
    ("gauss_markov", dict(time_constant=[0.0]), "time_constant"), ("oscillator", dict(period=-1.0), "period"),
    ("gaussian_process", dict(smoothness=1.0), "smoothness"), ("gaussian_process", dict(length=0.0), "length"),
    ("harmonic", dict(harmonics=7), "harmonics"), ("harmonic", dict(harmonics=0), "harmonics"), ("clock", dict(density=[1.0]), "density")])
def test_what_is_no_flow_is_refused(name, change, key):
    with pytest.raises(ModelError, match=key):
        built(name, **{**ONE[name], **change})


# ------------------------------------------------------------------------------ what is refused

ONE = {"level": dict(drift=1, noise=1, variance=1), "trend": dict(drift=[1, 1], noise=1, variance=[1, 1]),
       "ar": dict(phi=[0.25, 0.25], variance=1), "arma": dict(phi=[0.25], theta=[0.25], variance=1),
       "ma": dict(theta=[0.25], variance=1, noise=1), "season": dict(seasons=3, drift=1, noise=1, variance=[1, 1]),
       "trend_season": dict(seasons=3, drift=[1, 1, 1], noise=1, variance=[1, 1, 1, 1]),
       "regression": dict(regressors=[1, 1], drift=[1, 1], noise=1, variance=[1, 1]),
       "factor": dict(loadings=[[1, 1]], transition=[[0.5, 0], [0, 0.5]], drift=[1, 1], noise=[1]),
       "random_walk": dict(dt=1, density=[1, 1], noise=[1, 1], variance=[1, 1]),
       "gauss_markov": dict(dt=1, time_constant=[3.0], sigma=[1.0], noise=[1.0]),
       "clock": dict(dt=1, density=[1, 1], noise=1, variance=[1, 1]),
       "oscillator": dict(dt=1, period=9, damping=0.1, density=1, noise=1, variance=[1, 1]),
       "gaussian_process": dict(dt=1, smoothness=1.5, length=2, sigma=1, noise=1),
       "harmonic": dict(dt=1, period=12, harmonics=2, density=[1.0], noise=1, variance=np.ones(4)),
       "constant_velocity": dict(dt=1, density=[1, 1], noise=[1, 1], variance=[1, 1, 1, 1])}
VARIANCE_NAMES = ("drift", "noise", "variance", "density")


def with_entry(value, entry):
    if np.ndim(value) == 0:
        return entry
    changed = np.array(value, float)
    changed.flat[-1] = entry
    return changed


@pytest.mark.parametrize("name", ONE)
def test_arguments_must_be_finite(name):
    built(name, **ONE[name])
    for key in ONE[name]:
        if key in ("seasons", "harmonics"):
            continue
        for entry in (math.nan, math.inf, -math.inf):
            with pytest.raises(ModelError, match="not finite|NaN|infinit"):
                built(name, **{**ONE[name], key: with_entry(ONE[name][key], entry)})


@pytest.mark.parametrize("name", ONE)
def test_variances_must_not_be_negative(name):
    for key in VARIANCE_NAMES:
        if key in ONE[name]:
            with pytest.raises(ModelError, match="not positive semi-definite"):
                built(name, **{**ONE[name], key: with_entry(ONE[name][key], -1.0)})


@pytest.mark.parametrize("name, given", [
    ("ar", dict(phi=np.zeros(17), variance=1)), ("ma", dict(theta=np.zeros(16), variance=1)),
    ("arma", dict(phi=[0], theta=np.zeros(16), variance=1)),
    ("season", dict(seasons=18, drift=1, noise=1, variance=np.ones(17))),
    ("trend_season", dict(seasons=1, drift=[1, 1, 1], noise=1, variance=[1, 1])),
    ("trend_season", dict(seasons=16, drift=[1, 1, 1], noise=1, variance=np.ones(17))),
    ("factor", dict(loadings=np.zeros((17, 1)), transition=[[0.5]], noise=np.ones(17))),
    ("constant_velocity", dict(dt=1, density=np.ones(4), noise=np.ones(4), variance=np.ones(8))),
])
def test_orders_out_of_range_are_refused(name, given):
    with pytest.raises(ModelError):
        built(name, **given)


@pytest.mark.parametrize("dt", [0.0, -1.0])
def test_time_must_go_on(dt):
    with pytest.raises(ModelError):
        flow("constant_velocity", **{**ONE["constant_velocity"], "dt": dt})


def test_what_overflows_is_refused():
    with pytest.raises(ModelError, match="not representable"):
        flow("constant_velocity", **{**ONE["constant_velocity"], "dt": 1e308})
    with pytest.raises(ModelError, match="not finite|NaN|infinit"):
        built("ar", phi=[0.99], variance=1.7e308)
