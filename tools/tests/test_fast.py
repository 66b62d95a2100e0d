"""What is quick is the same: rows taken alone, cycles of roots, many series, printed numbers; counts of what is done, no time."""

from __future__ import annotations

import io
import re
import sys
from pathlib import Path

import numpy as np
import pytest
from library import saved

import fit_cases
import kalmanq
from kalmanq import Filter, KalmanqError, Model, Quantity, Smoother, run_series
from kalmanq.core import ffi
from kalmanq.data import joining
from kalmanq.data.written import Form, _write_rows
from kalmanq.fitting.flow import FlowExpectation
from kalmanq.model import model_file
from kalmanq.model.continuous import Continuous
from kalmanq.model.fitted_file import fitted_text
from kalmanq.run.one_row import OneRow
from test_twin import ARITHMETICS


def moving(n: int, derivatives: int, dt: float = 0.1, **more) -> Model:
    """Axes of so many derivatives each, of which the places are measured"""
    A, Q = np.eye(derivatives), np.zeros((derivatives, derivatives))
    for i in range(derivatives):
        for j in range(i + 1, derivatives):
            A[i, j] = dt ** (j - i) / (j - i)
        Q[i, i] = dt ** (2 * (derivatives - i))
    axes = np.eye(n // derivatives)
    named = {"states": [Quantity(f"x{i}", range=1e4) for i in range(n)], "measurements": [Quantity(f"z{i}", range=1e4) for i in range(len(axes))]}
    return Model(np.kron(axes, A), H=np.kron(axes, np.eye(1, derivatives)), Q=np.kron(axes, Q), R=0.25 * np.ones(len(axes)), P0=10 * np.ones(n), **named, **more)


def drawn(model: Model, T: int, seed: int, missing: float = 0.0) -> np.ndarray:
    random = np.random.default_rng(seed)
    z = random.normal(size=(T, model.m)).cumsum(axis=0)
    z[random.random(z.shape) < missing] = np.nan
    return z


def one_by_one(model: Model, z: np.ndarray, arithmetic: str) -> tuple[Filter, np.ndarray, np.ndarray]:
    f, mean, sigma = Filter(model, arithmetic), [], []
    for t, row in enumerate(z):
        if t:
            f.predict()
        f.update(row)
        mean.append(f.mean)
        sigma.append(f.sigma)
    return f, np.array(mean), np.array(sigma)


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
@pytest.mark.parametrize("model", [moving(4, 2), moving(9, 3), moving(1, 1), moving(16, 2), moving(4, 2, unknown="all"), moving(4, 2, d=[3.0, -1.5])],
                         ids=["4", "9", "1", "16", "unknown", "offset"])
def test_rows_taken_alone_are_those_of_a_run(model, arithmetic):
    z = drawn(model, 60, model.n, 0.1)
    f, mean, sigma = one_by_one(model, z, arithmetic)
    run = Filter(model, arithmetic)
    made = run.run(z)
    assert np.array_equal(f.memory, run.memory) and f.log_likelihood == run.log_likelihood and f.events == run.events
    assert np.array_equal(mean, made.mean, equal_nan=True) and np.array_equal(sigma, made.sigma, equal_nan=True)


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
@pytest.mark.parametrize("given", [[1.0], (1.0, 2.0, 3.0), ["one", 2.0], np.zeros((2, 1)), [np.inf, 0.0], None, [1.0, 1e300]])
def test_a_row_that_is_none_is_refused_as_a_sequence_is(given, arithmetic):
    f, before = Filter(moving(4, 2), arithmetic), Filter(moving(4, 2), arithmetic).memory
    if arithmetic == "f64" and isinstance(given, list) and given[1:] == [1e300]:
        return f.update(given)
    with pytest.raises(KalmanqError):
        f.update(given)
    assert np.array_equal(f.memory, before)


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_a_row_may_be_of_any_kind_of_numbers(arithmetic):
    rows = [np.array([1.0, np.nan]), [1.0, np.nan], (1.0, None), np.array([1, np.nan], np.float32)]
    memories = []
    for z in rows:
        f = Filter(moving(4, 2), arithmetic)
        f.update(z)
        memories.append(f.memory.tolist())
    assert all(one == memories[0] for one in memories)


def test_a_row_taken_alone_makes_nothing(monkeypatch):
    """No sequence, no memory that stays, no object of C but the first one's"""
    f, z, made = Filter(moving(4, 2)), np.ones(2), []
    f.update(z)
    monkeypatch.setattr(Filter, "_sequence", lambda *given, **more: made.append(given))
    monkeypatch.setattr(OneRow, "__init__", lambda *given: made.append(given))
    before = sys.getallocatedblocks()
    for _ in range(1000):
        f.predict()
        f.update(z)
    assert made == [] and sys.getallocatedblocks() - before < 100


# ------------------------------------------------------------------------------ cycles


def rested(model: Model, z: np.ndarray, arithmetic: str) -> int:
    f = Filter(model, arithmetic)
    words, q = f.parts.words(z, "measurements"), ffi.new(f"kq_sequence_{arithmetic} *")
    q.filter, q.process, q.sensor, q.steps, q.begins, q.z = f._handle, f.parts.process, f.parts.sensor, len(z), True, f._pointer(words)
    assert f.arithmetic.function("sequence_run")(q) == 0
    return int(q.rested)


@pytest.mark.parametrize("n, derivatives", [(4, 2), (6, 2), (6, 3), (8, 2), (9, 3), (12, 3)])
def test_roots_that_go_round_are_left_as_they_are(n, derivatives):
    """Whole steps until then; a missing row, after which the cycle is found again"""
    model = moving(n, derivatives)
    z = drawn(model, 3000, n)
    z[2000] = np.nan
    assert rested(model, z, "f64") > 1500
    f, mean, sigma = one_by_one(model, z[:2500], "f64")
    run = Filter(model)
    made = run.run(z[:2500])
    assert np.array_equal(f.memory, run.memory) and f.log_likelihood == run.log_likelihood
    assert np.array_equal(mean, made.mean) and np.array_equal(sigma, made.sigma)
    parts = Filter(model)
    pieces = [parts.run(z[k : k + 7]) for k in range(0, 2500, 7)]
    for name in ("innovation", "innovation_sigma", "nis", "log_likelihood"):
        assert np.array_equal(np.concatenate([getattr(one, name) for one in pieces])[:2500], getattr(made, name)[:2500], equal_nan=True), name


def test_a_smoother_over_a_cycle_is_that_of_whole_steps():
    model = moving(9, 3)
    z = drawn(model, 1200, 5)
    made, times = Smoother(model).run(z), np.arange(1200.0)
    varying = kalmanq.Varying(A=np.broadcast_to(model.A, (1200, 9, 9)) + 1e-300 * np.arange(1200)[:, None, None])
    whole = Smoother(model).run(z, varying=varying)
    assert np.array_equal(made.smoothed, whole.smoothed) and np.array_equal(made.smoothed_sigma, whole.smoothed_sigma), times


# ------------------------------------------------------------------------------ series


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
@pytest.mark.parametrize("kind", ["known", "unknown", "offset", "controls"])
def test_series_are_runs(kind, arithmetic):
    model = {"known": moving(4, 2), "unknown": moving(4, 2, unknown="all"), "offset": moving(4, 2, c=[0.0, 0.1, 0.0, -0.1]),
             "controls": moving(4, 2, B=np.eye(4)[:, [1]], controls=[Quantity("u", range=10)])}[kind]
    z = np.stack([drawn(model, 50, seed, 0.1) for seed in range(7)])
    u = np.random.default_rng(1).uniform(-1, 1, (7, 50, 1)) if kind == "controls" else None
    z[3, 30:] = np.nan
    made = run_series(model, z, u, arithmetic)
    for k in range(7):
        one = Filter(model, arithmetic).run(z[k], None if u is None else u[k])
        for name in ("mean", "sigma", "innovation", "innovation_sigma", "nis", "taken", "log_likelihood"):
            assert np.array_equal(getattr(made, name)[k], getattr(one, name), equal_nan=True), name
        assert made.events | one.events == made.events and np.array_equal(made.words["mean"][k], one.words["mean"], equal_nan=True)


@pytest.mark.parametrize("z, u, said", [
    (np.zeros((2, 3)), None, "S x T x 2"), (np.zeros((2, 3, 4)), None, "S x T x 2"), ("z", None, "not an array"),
    (np.zeros((2, 3, 2)), np.zeros((2, 4, 1)), "u"), (np.where(np.arange(12).reshape(2, 3, 2) == 9, np.inf, 0.0), None, "series 1")])
def test_series_that_are_none_are_refused(z, u, said):
    model = moving(4, 2, B=np.eye(4)[:, [1]], controls=[Quantity("u", range=10)]) if u is not None else moving(4, 2)
    with pytest.raises(KalmanqError, match=said) as problem:
        run_series(model, z, u)
    assert said != "series 1" or problem.value.row == 1


# ------------------------------------------------------------------------------ fits


def diffuse_in_long_double(A: np.ndarray, Q: np.ndarray, H: np.ndarray, R: float, z: np.ndarray) -> float:
    """By a column of means for each unknown state (de Jong 1991), of one measurement; A and Q: of the step before each row"""
    n, total = H.shape[1], np.longdouble(0)
    X, P, S = np.eye(n, n + 1, 1, dtype=np.longdouble), np.zeros((n, n), np.longdouble), np.zeros((n + 1, n + 1), np.longdouble)
    for t, value in enumerate(z):
        if t:
            X, P = A[t] @ X, A[t] @ P @ A[t].T + Q[t]
        if not np.isnan(value):
            V, s = -(H @ X), (H @ P @ H.T)[0, 0] + R
            V[0, 0] += value
            X, P = X + P @ H.T @ V / s, P - P @ H.T @ H @ P / s
            S, total = S + V.T @ V / s, total - (np.log(s) + np.log(2 * np.longdouble(np.pi))) / 2
    for k in range(n, 0, -1):  # the unknown states out of S, one after the other
        total, S = total - np.log(S[k, k]) / 2, S[:k, :k] - np.outer(S[:k, k], S[k, :k]) / S[k, k]
    return float(total - S[0, 0] / 2)


@pytest.mark.skipif(np.finfo(np.longdouble).eps > 1e-18, reason="long double is double")
@pytest.mark.parametrize("harmonics", [0, 1, 2, 3, 5, 7])
def test_an_unknown_start_that_the_first_rows_hardly_determine_is_exact(harmonics):
    """Where statsmodels can tell it says the same (fit_peers.py)"""
    A, Q, H, R, z = fit_cases.waves(harmonics)
    steps = [np.broadcast_to(one.astype(np.longdouble), (len(z), *one.shape)) for one in (A, Q)]
    expected = diffuse_in_long_double(*steps, H.astype(np.longdouble), np.longdouble(R[0, 0]), z[:, 0])
    found = kalmanq.likelihood(Model(A, Q=Q, H=H, R=R, P0=np.zeros(len(A)), unknown="all"), [z])
    assert abs(found / expected - 1) < 1e-11 and abs(found / fit_cases.DIFFUSE.get(harmonics, expected) - 1) < 1e-11


DAILY = """# A year in days
[model]
builder = "trend_harmonic"
time_unit = "day"
dt = 1.0
period = 90.0   # of a season
harmonics = 2
density = [
  0.1,    # of the level
  1e-8, 1e-6]
noise = 1.0  # of a day
P0 = "unknown"

[measurements]
names = ["y"]
"""


def daily(folder: Path, seed: int) -> tuple[Path, Path]:
    random, t = np.random.default_rng(seed), np.arange(300)
    y = 20 + 8 * np.sin(2 * np.pi * t / 90 - 1) + np.cumsum(0.15 * random.normal(size=300)) + 1.2 * random.normal(size=300)
    model = saved(folder / "daily.toml", DAILY)
    data = saved(folder / "daily.csv", "time [day],y\n" + "".join(f"{k},{value:.3f}\n" for k, value in zip(t, y) if random.random() > 0.1))
    return model, data


@pytest.mark.parametrize("seed", range(3))
def test_a_fit_of_a_season_ends_soon_and_leaves_the_file_as_it_was(seed, tmp_path, monkeypatch):
    """The distinct steps are made once for each likelihood, not again for its slopes or by the filter"""
    counts, steps, run = {"steps": 0, "runs": 0}, Continuous.steps, FlowExpectation.run

    def counted(key, call):
        counts[key] += 1
        return call()

    monkeypatch.setattr(Continuous, "steps", lambda self, dt: counted("steps", lambda: steps(self, dt)) if len(dt) > 1 else steps(self, dt))
    monkeypatch.setattr(FlowExpectation, "run", lambda self: counted("runs", lambda: run(self)))
    model, data = daily(tmp_path, seed)
    begun = model_file.read(model)
    [(z, u, times)] = [joining.record(one, begun) for one in joining.records_of([data], begun)]
    found = kalmanq.fit(begun, [z], ("density", "noise"), times=[times])
    assert found.converged and found.evaluations < 450, found.message
    assert counts["runs"] < found.evaluations + 30 and counts["steps"] <= counts["runs"] + 10
    assert found.log_likelihood == kalmanq.likelihood(found.model, [z], times=[times])
    text = fitted_text(model, found.model)
    lines = [line for line in DAILY.splitlines() if "#" in line or "builder" in line or "names" in line]
    assert all(re.sub(r"[\d.e-]+,", "", line) in re.sub(r"[\d.e-]+,", "", re.sub(r"noise = [\d.]+ ", "noise = 1.0 ", text)) for line in lines), text
    (tmp_path / "again.toml").write_text(text)
    again = model_file.read(tmp_path / "again.toml")
    assert np.array_equal(again.R, found.model.R) and np.array_equal(again.Q, found.model.Q) and again.name == "daily"


@pytest.mark.parametrize("changed", ["arrays", "variances", "sensors", "builder", "with L"])
def test_the_fitted_text_says_what_was_fitted(changed, tmp_path):
    head = "# mine\n[model]\n"
    body = {"arrays": "A = [[1, 1], # up\n  [0, 1]]\nQ = [[1, 0.5], [0.5, 2]]\nH = [1, 0] # left\nR = 3 # it\nP0 = [1, 1]\n",
            "variances": "A = [[1, 1], [0, 1]]\nQ = [1, 2] # q\nH = [1, 0]\nR = [3]\nP0 = [1, 1]\n",
            "sensors": "A = [[1, 1], [0, 1]]\nQ = [1, 2]\nP0 = [1, 1]\n[[sensors]]\nname = 'a'\nH = [1, 0]\nR = 3 # a\n[[sensors]]\nname = 'b'\nH = [1, 0]\nR = 4 # b\n",
            "builder": "builder = 'level'\ndrift = 2.0 # d\nnoise = 3.0\nP0 = 'unknown'\n",
            "with L": "F = [[0, 1], [0, 0]]\nL = [[0], [2]]\nQc = 0.5 # c\ndt = 1.0\nH = [1, 0]\nR = 2.0\nP0 = [1, 1]\n"}[changed]
    path = saved(tmp_path / "m.toml", head + body)
    given = model_file.read(path)
    more = {"Qc": 1.5 * given.continuous.Qc} if given.continuous else {"Q": 1.5 * given.Q}
    found = given.flowing(**more, R=2 * given.R) if given.continuous else given.changed(**more, R=2 * given.R)
    path.with_name("n.toml").write_text(fitted_text(path, found))
    again, text = model_file.read(path.with_name("n.toml")), fitted_text(path, found)
    assert np.allclose(again.Q, found.Q, 1e-14) and np.array_equal(again.R, found.R) and again.name == "m"
    assert all(one in text for one in re.findall("#.*", body)) and ("builder" in text) == ("builder" in body)
    path.write_text(head + body)
    correlated = given.changed(R=given.R + 0.5 * (given.m > 1) * np.ones((given.m, given.m)), Q=np.ones((given.n, given.n)) + np.diag(np.arange(1.0, given.n + 1)))
    path.with_name("n.toml").write_text(fitted_text(path, correlated))
    assert np.allclose(model_file.read(path.with_name("n.toml")).R, correlated.R) and np.allclose(model_file.read(path.with_name("n.toml")).Q, correlated.Q)


# ------------------------------------------------------------------------------ printed numbers


@pytest.mark.parametrize("digits", [1, 2, 5, 9, 10, 17])
def test_printed_numbers_are_those_of_printf(digits):
    random = np.random.default_rng(digits)
    halves = np.concatenate([(random.integers(10**8, 10**9, 2000) + 0.5) * 10.0**k for k in range(-12, 1)])
    values = np.concatenate([random.normal(size=20000) * 10 ** random.uniform(-9, 17, 20000), np.round(random.normal(size=5000), 3), halves, [
        0.0, -0.0, np.inf, -np.inf, 1e-4, 9.9999999995e-5, 0.9999999995, 999999999.5, 1e9, 1e15, 1e16, 1e17, -1e-300, 5e-324, 1.7e308, 0.5, 10, 99.5, 9.5]])
    text = io.StringIO()
    _write_rows(text, Form(), digits, [values, np.full(len(values), np.nan), np.arange(len(values))])
    assert text.getvalue().splitlines() == [f"{value:.{digits}g},,{k}" for k, value in enumerate(values.tolist())]
