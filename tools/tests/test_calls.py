"""A sequence in one call is the core's functions row by row, bit for bit; readings of the next update are the textbook's."""

from __future__ import annotations

import ctypes
import subprocess
from typing import Any, Optional

import numpy as np
import pytest

import models
from library import ROOT
from random_models import random_model
from kalmanq import _core
from kalmanq import AdaptiveFilter, Filter, LagSmoother, Model, Quantity, Robust, Smoother, SteadyFilter
from kalmanq.core import ffi, lib
from kalmanq.model.model import Sensor
from kalmanq.run.robust import LEVELS, bits_of
from test_twin import ARITHMETICS, LIMITS, SEEDS, unknown

pytestmark = pytest.mark.filterwarnings("ignore::kalmanq.KalmanqWarning")
LOSSES = [None, Robust("gate", 0.95, 2), Robust("huber", 1.5), Robust("student", 4.0), Robust("jump", 9.0)]
VIEW = ("mean", "mean_low", "sigma")


class Calls:
    """A filter by the core's functions: of the package it has tables and memory alone."""

    def __init__(self, model: Any, arithmetic: str, rows: int):
        self.f = Filter(model, arithmetic)
        self.a, self.parts, self.handle = self.f.arithmetic, self.f.parts, self.f._handle
        if np.any(model.unknown):
            self.start = self.f._object("diffuse", model.n, rows, sizes=(model.n, rows))
            self.parts.init_filter(self.handle, self.start)
        self.losses: dict[tuple[Robust, int], Any] = {}

    def call(self, stem: str, *arguments: Any) -> None:
        status = self.a.function(stem)(*arguments)
        assert status >= 0, f"{stem}: {status}"

    def words(self, row: np.ndarray, which: str) -> Any:
        self.kept = self.parts.words(row[None], which)
        return self.a.pointer(self.kept)

    def row(self, z: np.ndarray, u: Optional[np.ndarray], robust: Optional[Robust], moves: bool) -> list[tuple[int, float]]:
        """Of each update what was taken, and its NIS: one of all that is there, or by the gates of the sensors"""
        if moves:
            self.call("predict", self.handle, self.parts.process, ffi.NULL if u is None else self.words(u, "controls"))
        there = sum(1 << int(c) for c in np.flatnonzero(~np.isnan(z)))
        given = self.handle, self.parts.sensor, self.words(np.nan_to_num(z, nan=7.0), "measurements")
        told = []
        for sensor, bits in enumerate(bits_of(self.f.model.sensor_sizes) if robust and robust.way == "gate" else [there]):
            present, status = there & bits, lib.KQ_ERR_NOT_READY
            if not present:
                continue
            if robust:
                status = self.a.function("update_robust")(*given, present, self.loss(robust, sensor, present))
            if status == lib.KQ_ERR_NOT_READY:  # a start that is in part unknown
                self.call("update_subset", *given, present)
            told.append((self.f.taken, self.f.nis))
        return told

    def loss(self, robust: Robust, sensor: int, present: int) -> Any:
        """One of each sensor, as a gate counts its rejections."""
        losses = self.losses.setdefault((robust, sensor), self.a.losses(robust.way, 1))
        loss = losses[0]
        if robust.way == "gate":
            loss.limit = self.a.function("chi_square_limit")(bin(present).count("1"), LEVELS[robust.value])
            loss.run = robust.run
        else:
            loss.parameter = self.a.parameter(robust.value)
        return losses

    def shown(self, view: Any) -> list[list]:
        return [self.f._words(name, view).tolist() for name in VIEW]

    def smoothed(self, steps: int) -> np.ndarray:
        """steps x 3 x n, as Run.words has them; with an unknown start, what the start says"""
        self.call("smooth", self.history) if not hasattr(self, "start") else self.call("diffuse_smooth", self.start)
        name, source = ("diffuse_smoothed", self.start) if hasattr(self, "start") else ("smoothed", self.history)
        made = []
        for t in range(steps):
            view = self.a.struct("filter")
            self.call(name, source, t, view)
            made.append(self.shown(view))
        return np.array(made)


def ranged(model: Any) -> Any:
    return model.changed(states=[Quantity(one.name, "", 4000.0) for one in model.states],
                         measurements=[Quantity(one.name, "", 8000.0) for one in model.measurements],
                         controls=[Quantity(one.name, "", 10.0) for one in model.controls])


def any_model(seed: int) -> Any:
    """Of each size that is compiled for itself, and of sizes that are not"""
    random = np.random.default_rng(seed)
    return ranged(random_model(random, seed % 8 + 1, int(random.integers(1, min(seed % 8 + 1, 4) + 1))))


def sensed(model: Any, *sizes: int) -> Any:
    """As a file that names its sensors"""
    names = iter(one.name for one in model.measurements)
    model.sensors = tuple(Sensor(f"s{k}", tuple(next(names) for _ in range(size))) for k, size in enumerate(sizes))
    return model


def three() -> Any:
    """A place and a speed, by three sensors that share no noise"""
    return ranged(Model([[1, 0.5], [0, 1]], H=[[1, 0], [0, 1], [1, 0], [1, 1]], R=[[1, 0, 0, 0], [0, 2, 0.5, 0], [0, 0.5, 4, 0], [0, 0, 0, 1]],
                        Q=[[0.02, 0.05], [0.05, 0.3]], P0=[50, 10]))


MODELS = [models.cart(), models.pair(), unknown(models.cart()), unknown(models.pair()), *map(any_model, range(16)),
          sensed(ranged(models.pair().changed(R=[1, 2])), 1, 1), sensed(three(), 1, 2, 1), sensed(unknown(three()), 1, 2, 1)]


def rows_of(model: Any, rows: int, seed: int) -> tuple[np.ndarray, Optional[np.ndarray]]:
    """Data with gaps and outliers"""
    z, u = models.data(model, rows, seed)
    z[rows // 3] += 40
    z[rows // 4, 0] -= 30
    z[3 * rows // 4:, -1] += 60 * (len(model.sensors) > 1)  # a sensor that jumps for good
    return z, u


def test_the_package_s_core_has_the_golden_words(tmp_path):
    """The program of tests/vectors, by the functions of the package's own module"""
    replay = tmp_path / "replay.so"
    subprocess.run(["cc", "-std=c11", "-O1", "-shared", "-fPIC", f"-I{ROOT / 'include'}", "-o", str(replay),
                    *(str(ROOT / "tests" / "vectors" / f"{name}.c") for name in ("replay", "vector", "q31", "cases"))], check=True)
    ctypes.CDLL(_core.__file__, ctypes.RTLD_GLOBAL)
    assert ctypes.CDLL(str(replay)).main() == 0


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
@pytest.mark.parametrize("robust", LOSSES, ids=lambda robust: robust.way if robust else "plain")
def test_a_run_is_the_core_s_calls(robust, arithmetic):
    rejected = jumped = 0
    for seed, model in enumerate(MODELS):
        z, u = rows_of(model, 40, seed)
        f, calls = Filter(model, arithmetic), Calls(model, arithmetic, 40)
        run = f.run(z, u, robust=robust)
        for t in range(40):
            told = calls.row(z[t], None if u is None else u[t - 1], robust, t > 0)
            for name in ("mean", "sigma"):
                assert np.array_equal(calls.f._words(name), run.words[name][t], equal_nan=True), (seed, t, name)
            if told:
                some = [one for one in told if one[0]] or told  # what is rejected counts where nothing is taken
                taken, nis = map(sum, zip(*some))
                assert taken == run.taken[t] and (nis == run.nis[t] or len(some) > 1 and nis == pytest.approx(run.nis[t], rel=1e-6) or np.isnan(nis)), (seed, t)
            else:
                assert run.log_likelihood[t] == 0 and run.taken[t] == 0 and np.isnan(run.nis[t]), (seed, t)
        assert np.array_equal(f.memory, calls.f.memory) and f.events == calls.f.events
        assert f.log_likelihood == calls.f.log_likelihood or np.isnan(f.log_likelihood)
        rejected += bool(f.events & lib.KQ_EVENT_GATED)
        jumped += bool(f.events & lib.KQ_EVENT_JUMP)
        f.clear_events()
        assert f.events == 0
    assert (rejected > 5) == (robust is not None and robust.way == "gate")
    assert (jumped > 5) == (robust is not None and robust.way == "jump")


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_smoothers_are_the_core_s_calls(arithmetic):
    for seed, model in enumerate(MODELS):
        z, u = rows_of(model, 30, seed)
        calls, lags = Calls(model, arithmetic, 30), Calls(model, arithmetic, 30)
        calls.history = calls.f._object("history", model.n, sizes=(model.n, model.m, 30, 0))
        calls.f._attach(calls.history, "history")
        lag = lags.f._object("lag", model.n, model.m, 4, sizes=(model.n, model.m, 4))
        is_lagged, lagged = False, []
        for t in range(30):
            for one in (calls, lags):
                one.row(z[t], None if u is None else u[t - 1], None, t > 0)
            is_lagged = is_lagged or lags.a.function("attach")(lags.handle, ffi.addressof(lag[0], "attached")) == 0
            view = lags.a.struct("filter")
            if is_lagged and lags.a.function("lag_steps")(lag) >= 4:
                lags.call("lagged", lag, 4, view)
            lagged.append(lags.shown(view))
        run, late = Smoother(model, arithmetic).run(z, u), LagSmoother(model, 4, arithmetic).run(z, u)
        made, lagged = calls.smoothed(30), np.array(lagged)
        for k, part in enumerate(("", "_low", "_sigma")):
            assert np.array_equal(run.words[f"smoothed{part}"], made[:, k], equal_nan=True), (seed, part)
            assert np.array_equal(late.words[f"lagged{part}"], lagged[:, k], equal_nan=True), (seed, part)
        if not np.any(model.unknown):
            means = Smoother(model, arithmetic).run(z, u, means_only=True)
            assert means.smoothed_sigma is None and np.allclose(means.smoothed, run.smoothed, rtol=1e-3, atol=1e-2)


@pytest.mark.parametrize("arithmetic", ["f32", "f64"])
def test_a_smoother_that_has_settled_is_the_core_s_calls(arithmetic):
    """Rows that leave the root as it is are recorded without working it out; gaps end that, and it comes again"""
    for seed, model in enumerate([any_model(0), any_model(8), any_model(16), ranged(models.cart())]):
        z, u = models.data(model, 900, seed)
        z[400:403] = z[650, :1] = np.nan
        calls = Calls(model, arithmetic, 900)
        calls.history = calls.f._object("history", model.n, sizes=(model.n, model.m, 900, 0))
        calls.f._attach(calls.history, "history")
        for t in range(900):
            calls.row(z[t], None if u is None else u[t - 1], None, t > 0)
        run, made = Smoother(model, arithmetic).run(z, u), calls.smoothed(900)
        for k, part in enumerate(("", "_low", "_sigma")):
            assert np.array_equal(run.words[f"smoothed{part}"], made[:, k], equal_nan=True), (seed, part)


@pytest.mark.parametrize("scales", ["both", "process", "sensor"])
@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_an_adaptation_keeps_to_its_rule(arithmetic, scales):
    """Both noises are 30 times too large, then too small: the scales go to the limits and no farther."""
    z, _ = models.data(models.pair(), 500, 3)
    rule = dict(scales=scales, step=0.125, limits=(0.25, 8), sensor_limits=(0.5, 4))
    for factor, end in ((30.0, 0), (1 / 30, 1)):
        model = models.pair().changed(R=models.pair().R * factor, Q=models.pair().Q * factor)
        f = AdaptiveFilter(model, arithmetic, memory=50, **rule)
        seen = f.run(z).scales
        wanted = [(0.25, 8)[end] if scales != "sensor" else 1, (0.5, 4)[end] if scales != "process" else 1]
        assert np.array_equal(seen[-1], wanted) and np.array_equal(f.scales, wanted)
        most = np.exp(np.abs(np.diff(np.log(seen), axis=0)).max())
        assert most < 1.1251 and (most > 1.12 or scales == "process")
    pace = [np.abs(np.diff(np.log(AdaptiveFilter(models.pair(), arithmetic, memory=memory, **rule).run(z).scales[200:]), axis=0))
            .mean() for memory in (50, 5000)]
    assert 0 < pace[1] < pace[0] / 3


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("make", [models.cart, models.pair])
@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_what_the_next_update_would_do_is_the_textbook_s(make, arithmetic, seed):
    model, limit = make(), LIMITS[arithmetic]
    z, u = models.data(model, 40, seed)
    f = Filter(model, arithmetic)
    f.run(z, u)
    ahead = f.forecast(3, None if u is None else u[:3])
    exact = models.textbook(model, z, u)
    x, P = exact["mean"][-1], exact["covariance"][-1]
    for t in range(3):
        x = model.A @ x + (0 if u is None else model.B @ u[t])
        P = model.A @ P @ model.A.T + model.Q
    S = model.H @ P @ model.H.T + model.R
    K, sigma, spread = P @ model.H.T @ np.linalg.inv(S), np.sqrt(np.diag(P)), np.sqrt(np.diag(S))
    shown, covariance = ahead.measurement()
    assert np.max(np.abs(ahead.mean - x) / sigma) < limit
    assert np.max(np.abs(ahead.covariance - P) / np.outer(sigma, sigma)) < limit
    assert np.max(np.abs(shown - model.H @ x) / spread) < limit
    assert np.max(np.abs(covariance - S) / np.outer(spread, spread)) < limit
    assert np.max(np.abs(ahead.gain() - K) / np.outer(sigma, 1 / spread)) < limit


@pytest.mark.parametrize("make", [models.cart, models.pair])
@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_a_steady_filter_of_a_given_gain_is_the_textbook_s(make, arithmetic):
    model = make()
    z, u = models.data(model, 50, 2)
    z[np.any(np.isnan(z), axis=1)] = np.nan
    K = np.arange(1, model.n * model.m + 1).reshape(model.n, model.m) * 2.0**-5
    run, x = SteadyFilter(model, arithmetic, K).run(z, u), model.x0
    for t in range(50):
        x = models.moved(model, x, u, t) if t else x
        e = z[t] - model.H @ x
        assert np.allclose(run.innovation[t], e, rtol=0, atol=1e-5, equal_nan=True)
        x = x if np.any(np.isnan(e)) else x + K @ e
        assert np.allclose(run.mean[t], x, rtol=0, atol=1e-5)
