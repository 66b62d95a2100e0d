"""Smoothers of records with outliers: the noise that a loss gives a row is the noise of that row for the smoother, too."""

from __future__ import annotations

import numpy as np
import pytest
from command import succeeds

from kalmanq import KalmanqError, Model, NonlinearFilter, NonlinearModel, NonlinearSmoother, Quantity, ReweightedSmoother, Robust, Smoother, Varying
from kalmanq.model import model_file
from kalmanq.run.robust import limit_of

LOSSES = (Robust("huber", 2.0), Robust("student", 4.0), Robust("gate", 4.0))
SEEDS = range(3)
TRUSTED = {"f64": 1e-9, "f32": 2e-4, "q31": 1e-5}  # sigma


def probe(rate: float = 0.02) -> Model:
    """A temperature that drifts, whose word is now and then a sensor's own: -127 and 85"""
    return Model([[1, 1], [0, 1]], H=[1, 0], R=0.04, Q=np.diag([1e-3, rate * 1e-3]), x0=[20, 0], P0=np.diag([4.0, 0.1]),
                 states=[Quantity("temperature", "K", 500), Quantity("rate", "", 50)], measurements=[Quantity("probe", "", 500)])


def record(seed: int, rows: int = 120) -> tuple[np.ndarray, np.ndarray]:
    draw = np.random.default_rng(seed)
    x = 20 + np.cumsum(np.cumsum(0.003 * draw.standard_normal(rows)))
    z = x + 0.2 * draw.standard_normal(rows)
    z[draw.choice(rows, 12, replace=False)] = draw.choice([-127.0, 85.0, np.nan], 12)
    return x, z


def noise_of(loss: Robust, r: float, square: float, e: float) -> float:
    """r' of robust.h; infinite: not taken"""
    s, k = r + square, loss.value
    if loss.way == "gate":
        return np.inf if e * e / s > k * k else r
    if loss.way == "huber":
        return r if abs(e) <= k * np.sqrt(s) else s * abs(e) / (k * np.sqrt(s)) - square
    heavy = r
    for _ in range(3):
        share = heavy / (heavy + square)
        heavy = (k * r + (e * share) ** 2 + square * share) / (k + 1)
    return heavy


def weighed(model: Model, z: np.ndarray, loss: Robust) -> tuple[np.ndarray, np.ndarray]:
    """The noise of each row, and the rows that are taken: a textbook filter of one component"""
    x, P, h = model.x0.copy(), model.P0.copy(), model.H[0]
    noises, taken, rejected = np.full(len(z), model.R[0, 0]), z.copy(), 0
    for t in range(len(z)):
        if t:
            x, P = model.A @ x, model.A @ P @ model.A.T + model.Q
        if np.isnan(z[t]):
            continue
        e = z[t] - h @ x
        r = noise_of(loss, model.R[0, 0], h @ P @ h, e)
        if np.isinf(r) and rejected < loss.run:
            taken[t], rejected = np.nan, rejected + 1
            continue
        noises[t], rejected = model.R[0, 0] if np.isinf(r) else r, 0
        K = P @ h / (h @ P @ h + noises[t])
        x, P = x + K * e, P - np.outer(K, h @ P)
    return noises, taken


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("loss", LOSSES, ids=lambda loss: loss.way)
@pytest.mark.parametrize("arithmetic", TRUSTED)
def test_a_smoother_weighs_each_row_as_its_loss(arithmetic, loss, seed):
    model, (x, z) = probe(), record(seed)
    noises, taken = weighed(model, z, loss)
    wanted = Smoother(model).run(taken, varying=Varying(R=noises[:, None, None]), covariance=True)
    run = Smoother(model, arithmetic).run(z, robust=loss, covariance=True)
    assert np.max(np.abs(run.smoothed - wanted.smoothed) / wanted.smoothed_sigma) < TRUSTED[arithmetic]
    assert np.allclose(run.smoothed_sigma, wanted.smoothed_sigma, rtol=TRUSTED[arithmetic])
    assert np.abs(run.smoothed[:, 0] - x).max() < 0.5 < np.abs(Smoother(model).run(z).smoothed[:, 0] - x).max()


def as_functions(model: Model) -> NonlinearModel:
    return NonlinearModel(lambda x, t, u: model.A @ x, lambda x, t, u: model.H @ x, Q=model.Q, R=model.R, x0=model.x0, P0=model.P0,
                          states=model.states, measurements=model.measurements)


@pytest.mark.parametrize("method", ["extended", "iterated", "cubature", "posterior"])
@pytest.mark.parametrize("loss", LOSSES, ids=lambda loss: loss.way)
def test_functions_that_are_linear_are_smoothed_alike(loss, method):
    model, (_, z) = probe(), record(4)
    linear = Smoother(model).run(z, robust=loss)
    run = NonlinearSmoother(as_functions(model), method=method).run(z, robust=loss)
    assert np.max(np.abs(run.smoothed - linear.smoothed) / linear.smoothed_sigma) < 1e-5
    assert np.array_equal(run.taken, linear.taken)


@pytest.mark.parametrize("arithmetic", ["f32", "f64", "q31"])
def test_each_sensor_has_a_gate_of_its_own(arithmetic):
    """One that fails for good is taken again after its run; the other one's single outlier is rejected all the while"""
    states = [Quantity("x", "", 4000)]
    model = NonlinearModel(lambda x, t, u: x, Q=[[1e-4]], x0=[0], P0=[[1]], states=states, measurements=[Quantity(one, "", 4000) for one in "ab"],
                           sensors={"good": (lambda x, t, u: x, [[1.0]]), "lost": (lambda x, t, u: x, [[1.0]])})
    z = np.tile([0.0, 500.0], (24, 1))
    z[20, 0] = 300.0
    taken = NonlinearFilter(model, arithmetic).run(z, robust=Robust("gate", 4.0)).taken
    assert [t for t in range(24) if taken[t] == 2] == [8] and taken[20] == 0 and limit_of(4.0, 1) == 16


def test_an_unknown_start_and_many_states():
    """A start takes its rows as they are; sixteen states"""
    A = np.eye(16) + np.diag(np.full(15, 0.1), 1)
    model = Model(A, H=np.eye(16)[[0, 8]], R=[1.0, 1.0], Q=1e-4 * np.eye(16), P0=None)
    draw = np.random.default_rng(0)
    z = draw.standard_normal((200, 2))
    spoilt = z.copy()
    spoilt[150:160:3, 1] = 1e4
    clean, run = (Smoother(model).run(one, robust=Robust("gate", 5.0)) for one in (z, spoilt))
    rejected = z.copy()
    rejected[150:160:3] = np.nan
    assert np.allclose(run.smoothed, Smoother(model).run(rejected).smoothed) and np.all(clean.taken == 2)


@pytest.mark.parametrize("make", [lambda: Smoother(probe()), lambda: NonlinearSmoother(as_functions(probe()))])
def test_a_jump_is_not_undone(make):
    with pytest.raises(KalmanqError, match="ReweightedSmoother"):
        make().run([1.0, 2.0], robust=Robust("jump"))


def test_passes_are_of_gaussian_noise():
    with pytest.raises(KalmanqError, match="passes"):
        NonlinearSmoother(as_functions(probe()), passes=2).run([1.0], robust=Robust("huber"))


PROBE = """
[model]
builder = "constant_velocity"
dt = 3.0
density = [1e-5]
noise = [0.004]
variance = [100.0, 1.0]
mean = [78.0, 0.0]
[states]
names = ["temperature", "rate"]
[measurements]
names = ["temperature"]
ranges = [[-130, 110]]
"""
SEEN = "temperature\n78.62\n\n78.12\n\n77.81\n77.69\n-127\n\n85\n\n77.12\n76.87\n"


@pytest.mark.parametrize("robust", ["huber", "student=4", "gate"])
def test_the_command_smooths_a_file_with_wild_values(robust, tmp_path):
    model, data, out = tmp_path / "probe.toml", tmp_path / "probe.csv", tmp_path / "out.csv"
    model.write_text(PROBE), data.write_text(SEEN)
    succeeds("run", model, data, "--smooth", "--robust", robust, "-o", out)
    table = np.genfromtxt(out, delimiter=",", names=True, deletechars="")
    assert np.allclose(table["temperature_smoothed"][[6, 8]], [77.55, 77.30], atol=0.05)


def test_the_command_smooths_jumps_by_reweighting(tmp_path):
    model, data, out = tmp_path / "probe.toml", tmp_path / "probe.csv", tmp_path / "out.csv"
    z = np.concatenate([np.full(30, 20.0), np.full(30, 60.0)]) + np.random.default_rng(1).normal(0, 0.05, 60)
    model.write_text(PROBE), data.write_text("temperature\n" + "\n".join(map(repr, map(float, z))) + "\n")
    succeeds("run", model, data, "--smooth", "--robust", "jump", "--forecast", "2", "--digits", 17, "-o", out)
    table = np.genfromtxt(out, delimiter=",", names=True, deletechars="")
    wanted = ReweightedSmoother(model_file.read(model)).run(z)
    assert table["temperature_smoothed"].tolist() == wanted.smoothed[:, 0].tolist()
