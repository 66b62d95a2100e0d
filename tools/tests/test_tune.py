"""kalmanq tune: its page has the library's bits, in Node and in a browser, and does what it says."""

from __future__ import annotations

import json
import re
import shlex
import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy as np
import pytest

import browser
import tune_node
from command import kalmanq, refused, succeeds
from library import EXAMPLES, ROOT, saved
from kalmanq import Estimation, Filter, LagSmoother, Robust, Smoother, fit
from kalmanq.compiler.given.request import Options
from kalmanq.compiler.report.costs import costs_of
from kalmanq.compiler.text.product import compiled
from kalmanq.data import joining
from kalmanq.fitting.entries import free_and_held
from kalmanq.model import Model, Quantity, model_file
from kalmanq.run.diagnostics import mean_bounds
from kalmanq.run.robust import LOSSES
from kalmanq.run.simulation import drawn
from kalmanq.tune import page
from tune_node import nameless, needs_browser, needs_node, numbers, ready, settled, shown
from whole import MEASURED, WHOLE

SOURCES = {"model": "model.toml", "data": "data.csv"}
FILTERED = ("mean", "sigma", "innovation", "innovation_sigma", "nis", "log_likelihood")


def read(name):
    return model_file.read(EXAMPLES / f"{name}.toml")


def content_of(model, z, u=None, times=None):
    return page.content(model, z, u, times, SOURCES)


def in_node(cases):
    return tune_node.ran(page.core(), cases)


# ------------------------------------------------------------------------------ bits, in Node


def with_gaps(model, rows=120, u=None):
    _, z = drawn(model, rows, 3, (40, 55), u)
    z[70, 0] = np.nan
    return z


def several():
    """Two sensors at times of their own, correlated noise, offsets and a control"""
    ranges = [Quantity("x", "m", 1000.0), Quantity("v", "m/s", 100.0)]
    model = Model.of_continuous([[0, 1], [0, -0.1]], H=[[1, 0], [0, 1], [1, 1]], R=[[4, 1, 0], [1, 2, 0], [0, 0, 0.5]], Qc=[0.1, 0.3], dt=0.5,
                                B=[0, 1], c=[0, 0.2], d=[1, 0, -2], P0=[9, 4], states=ranges,
                                measurements=[Quantity(name, "m", 1000.0) for name in "abc"], controls=[Quantity("push", "N", 10.0)])
    times = np.cumsum(np.random.default_rng(1).choice([0.5, 1.0, 0.75, 0.0], 90))
    u = np.sin(times)[:, None]
    _, z = drawn(model, 90, 5, (30, 40), u, times)
    z[::3, 1] = np.nan
    return model, z, u, times


SENSORS = """[model]
F = [[0.0, 1.0], [0.0, 0.0]]
Qc = [[0.0, 0.0], [0.0, 0.5]]
dt = 1.0
P0 = [100.0, 10.0]
[[sensors]]
name = "gps"
H = [[1.0, 0.0]]
R = [[4.0]]
ranges = [4000]
[[sensors]]
name = "wheel"
measurements = ["left", "right"]
H = [[0.0, 1.0], [0.0, 1.0]]
R = [[0.5, 0.1], [0.1, 0.5]]
ranges = [900, 900]
[states]
ranges = [4000, 900]
"""


def sensors():
    """In two files, joined by their times"""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "model.toml").write_text(SENSORS)
        (Path(folder) / "gps.csv").write_text("t (s),gps\n" + "".join(f"{k},{k + 3 * np.sin(k):.3f}\n" for k in range(0, 60, 3)))
        (Path(folder) / "wheel.csv").write_text("t (s),left,right\n" + "".join(f"{k + 0.5},{1 + np.cos(k):.3f},{1 - np.sin(k):.3f}\n" for k in range(60)))
        model = model_file.read(Path(folder) / "model.toml")
        return model, *joining.record([Path(folder) / "gps.csv", Path(folder) / "wheel.csv"], model)


def cases():
    nile = read("nile")
    yield "nile", nile, *joining.record(EXAMPLES / "nile.csv", nile)
    for name in ("track", "two_gauges", "trend_season"):
        yield name, read(name), with_gaps(read(name)), None, None
    co2 = read("co2")
    yield "co2", co2, *joining.record(EXAMPLES / "co2.csv", co2)
    yield "several", *several()
    yield "sensors", *sensors()


@needs_node
@pytest.mark.parametrize("name, model, z, u, times", list(cases()), ids=lambda one: one if isinstance(one, str) else "")
def test_runs_are_the_packages_bit_for_bit(name, model, z, u, times):
    content = content_of(model, z, u, times)
    theta = [one["value"] for one in content["noises"]]
    can_fix = all(one.range is not None for one in (*model.states, *model.measurements, *model.inputs))
    arithmetics = ("f32", "f64", "q31") if can_fix else ("f32", "f64")
    asked = [{"theta": theta, "arithmetic": one, "smooth": True, "lag": 3, "ahead": 7} for one in arithmetics]
    names = (*FILTERED, "smoothed", "smoothed_sigma", "lagged", "lagged_sigma", "forecast", "forecast_sigma")
    told = in_node([{"content": content, "asked": one, "names": names} for one in asked])
    for arithmetic, found in zip(arithmetics, told):
        filter_ = Filter(model, arithmetic)
        run, smooth = filter_.run(z, u, times=times), Smoother(model, arithmetic).run(z, u, times=times)
        lag = LagSmoother(model, 3, arithmetic).run(z, u, times=times)
        ahead = [filter_.forecast(k, None if u is None else np.repeat(u[-1:], k, axis=0)) for k in range(1, 8)]
        wanted = {**{one: getattr(run, one) for one in FILTERED}, "smoothed": smooth.smoothed, "smoothed_sigma": smooth.smoothed_sigma,
                  "lagged": lag.lagged, "lagged_sigma": lag.lagged_sigma, "forecast": [one.mean for one in ahead],
                  "forecast_sigma": [one.sigma for one in ahead]}
        assert found["total"] == filter_.log_likelihood
        for one, array in wanted.items():
            np.testing.assert_array_equal(numbers(found[one]), np.ravel(array), err_msg=f"{name}, {arithmetic}, {one}")


@needs_node
@pytest.mark.parametrize("name", ["track", "sensors"])
def test_losses_are_the_packages(name, tmp_path):
    """With sensors each has a gate of its own, and each run of the page, with the lag, too, begins anew"""
    model = read("track") if name == "track" else model_file.read(saved(tmp_path / "model.toml", SENSORS))
    z = with_gaps(model)
    z[20] += 500
    z[100:, -1] += 200
    ways = [Robust("gate", 0.99), Robust("huber", 2.0), Robust("student", 5.0), Robust("jump", 12.0)]
    content = content_of(model, z)
    asked = [{"theta": [one["value"] for one in content["noises"]], "arithmetic": arithmetic, "loss": way.way, "parameter": way.value}
             for way in ways for arithmetic in ("f32", "f64", "q31")]
    told = in_node([{"content": content, "asked": {**one, "lag": 2}, "names": ["mean", "sigma", "nis", *["lagged"] * (one["loss"] != "jump")]} for one in asked])
    for one, found in zip(asked, told):
        robust = Robust(one["loss"], one["parameter"])
        run = Filter(model, one["arithmetic"]).run(z, robust=robust)
        if one["loss"] != "jump":
            lagged = LagSmoother(model, 2, one["arithmetic"]).run(z, robust=robust).lagged
            np.testing.assert_array_equal(numbers(found["lagged"]), lagged.ravel())
        np.testing.assert_array_equal(numbers(found["nis"]), run.nis)
        np.testing.assert_array_equal(numbers(found["mean"]), run.mean.ravel())
        np.testing.assert_array_equal(numbers(found["sigma"]), run.sigma.ravel())


@needs_node
def test_other_sizes_of_the_noises():
    """As the model of the package with these sizes, but for the rounding of Q"""
    for name, model, z, u, times in cases():
        content = content_of(model, z, u, times)
        theta = [one["value"] * 1.7 ** (k + 1) for k, one in enumerate(content["noises"])]
        found, = in_node([{"content": content, "asked": {"theta": theta, "arithmetic": "f64", "smooth": True}, "names": ["smoothed"]}])
        other = model_of(content, theta)
        filter_ = Filter(other)
        filter_.run(z, u, times=times)
        assert found["total"] == pytest.approx(filter_.log_likelihood, rel=1e-11), name
        np.testing.assert_allclose(numbers(found["smoothed"]), Smoother(other).run(z, u, times=times).smoothed.ravel(), rtol=1e-7, atol=1e-7)


IN_TIME = {  # of each builder in continuous time, what it is given beside dt
    "constant_velocity": {"density": [0.5, 2.0], "noise": [0.04, 1.0], "variance": [100.0, 10.0] * 2},
    "constant_acceleration": {"density": [2.0], "noise": [0.25], "variance": [100.0, 10.0, 1.0]},
    "random_walk": {"density": [1.0, 1e-3], "noise": [1.0, 0.1], "variance": [10.0, 1.0]},
    "gauss_markov": {"time_constant": [0.3, 100.0], "sigma": [1.0, 0.02], "noise": [0.1, 0.1]},
    "clock": {"density": [1e-2, 1e-5], "noise": 1.0, "variance": [10.0, 1.0]},
    "oscillator": {"period": 3.0, "damping": 0.1, "density": 0.5, "noise": 0.04, "variance": [4.0, 4.0]},
    **{f"gaussian_process {nu}": {"smoothness": nu, "length": 2.0, "sigma": 1.5, "noise": 0.04} for nu in (0.5, 1.5, 2.5)},
    "harmonic": {"period": 200.0, "harmonics": 2, "density": [0.1], "noise": 0.1, "variance": [1.0] * 4},
    "trend_harmonic": {"period": 200.0, "harmonics": 2, "density": [0.1, 1e-4, 0.01], "noise": 0.1, "variance": [1.0] * 6}}
IN_STEPS = {
    "level": {"drift": 1.0, "noise": 2.0, "variance": 10.0}, "trend": {"drift": [0.5, 1e-3], "noise": 2.0, "variance": [10.0, 1.0]},
    "season": {"seasons": 5, "drift": 0.1, "noise": 1.0, "variance": [1.0] * 4},
    "trend_season": {"seasons": 4, "drift": [0.5, 1e-3, 0.1], "noise": 1.0, "variance": [1.0] * 5},
    "ar": {"phi": [0.5, 0.25], "variance": 4.0, "noise": 3.0}, "ma": {"theta": [0.5, 0.2], "variance": 4.0, "noise": 0.5},
    "arma": {"phi": [0.5], "theta": [-0.25], "variance": 1.0, "noise": 0.1},
    "regression": {"regressors": [1.0, 0.5], "drift": [0.1, 0.01], "noise": 1.0, "variance": [1.0, 1.0]},
    "factor": {"loadings": [[1.0, 0.5], [0.3, 1.0], [1.0, -1.0]], "transition": [[0.9, 0.1], [0.0, 0.8]], "drift": [1.0, 0.1], "noise": [0.1, 0.2, 0.3]}}
MIXED = [[0, 1, 0, 0], [-40, -0.2, 1, 0], [0, 0, -1 / 30, 0], [0, 0, 0.5, -2]]  # an oscillator pushed by a slow bias, which a filter follows


def of_builder(folder, name, given):
    text = "".join(f"{key} = {json.dumps(value)}\n" for key, value in {"builder": name.partition(" ")[0], **given}.items())
    (folder / "model.toml").write_text(f"[model]\n{text}")
    return model_file.read(folder / "model.toml")


def short_and_long_steps(folder):
    """Of every builder, and of every place of Qc"""
    for name, given in IN_STEPS.items():
        yield name, of_builder(folder, name, given)
    for dt in (1e-4, 1e-2, 10.0):
        for name, given in IN_TIME.items():
            yield f"{name}, {dt}", of_builder(folder, name, {**given, "dt": dt})
        for F in (np.eye(3, k=1), np.array(MIXED)):
            n = len(F)
            for which, Qc in (*((k, np.eye(n)[k]) for k in range(n)), ("all", 10.0 ** np.arange(n)), ("block", np.eye(n) + 0.5)):
                yield f"{n} states, Qc {which}, {dt}", Model.of_continuous(F, H=np.eye(n)[:1], R=0.25, Qc=Qc, dt=dt, P0=np.full(n, 100.0))


def with_ranges(model):
    """That a step of ten times dt has the integer bits for"""
    A = model.A if model.continuous is None else model.continuous.step(10 * model.continuous.dt)[0]
    spans = 1e3 * np.maximum(1, np.abs(A).max(axis=1))
    return model.changed(states=[Quantity(one.name, "", span) for one, span in zip(model.states, spans)],
                         measurements=[Quantity(one.name, "", 10 * spans.max()) for one in model.measurements])


@needs_node
def test_a_slider_moves_a_covariance_to_a_covariance(tmp_path):
    """All the way, one noise and all of them against each other, at this dt and others: as the package has the model"""
    cases = []
    for name, model in short_and_long_steps(tmp_path):
        content = content_of(with_ranges(model), np.ones((4, model.m)))
        theta, dt = np.array([one["value"] for one in content["noises"]]), (content["flow"] or {}).get("dt")
        moved = [theta * 10.0 ** (by * np.array(way)) for by in (-6, -1, 0.3, 6) for way in (*np.eye(len(theta)), (-1.0) ** np.arange(len(theta)))]
        cases.append({"name": name, "content": content, "sweep": [
            {"theta": one.tolist(), "arithmetic": arithmetic, **({"dt": by * dt} if dt else {})}
            for one in moved for by in ((1, 0.1, 10) if dt else (1,)) for arithmetic in ("f64", "f32", "q31")]})
    for case, told in zip(cases, in_node(cases)):
        assert not [one for one in zip(case["sweep"], told) if isinstance(one[1], str)], case["name"]
        for asked, total in list(zip(case["sweep"], told))[::27]:
            filter_ = Filter(model_of(case["content"], asked["theta"], asked.get("dt")), asked["arithmetic"])
            filter_.run(np.ones((4, case["content"]["m"])))
            assert asked["arithmetic"] == "f64" and total == pytest.approx(filter_.log_likelihood, rel=1e-7, abs=1e-7), (case["name"], asked)


@needs_node
def test_a_noise_of_a_short_step_has_all_its_degrees_of_freedom():
    """Of EM: the position's variance is 1e-18 of the acceleration's"""
    model = Model.of_continuous(np.eye(3, k=1), H=[[1, 0, 0]], R=0.25, Qc=[0, 0, 2.0], dt=1e-4, P0=[100, 10, 1])
    found, = in_node([{"content": content_of(model, np.ones((11, 1))), "em": "degrees", "asked": {}}])
    assert found == [30, 11]


@needs_node
@pytest.mark.parametrize("name, rows", [("track", {10: 3, 11: 3, 12: 1, 30: 8, 34: 4}), ("nile", {20: 5, 22: 3})])
def test_what_comes_late_counts_from_the_row_that_it_comes_in(name, rows):
    """Compared with a filter that goes over all rows again, with what has come by then"""
    model = read(name)
    z = with_gaps(model)[:60] if name == "track" else joining.record(EXAMPLES / "nile.csv", model)[0][:60]
    late = {t * model.m + c: by for t, by in rows.items() for c in range(model.m) if c == 0 or t < 30}
    content = content_of(model, z)
    asked = [{"theta": [one["value"] for one in content["noises"]], "arithmetic": arithmetic, "ahead": 3} for arithmetic in ("f64", "f32", "q31")]
    told = in_node([{"content": content, "asked": one, "late": {"cells": list(late), "rows": list(late.values())}, "names": FILTERED + ("taken",)} for one in asked])
    mean, sigma = np.empty((len(z), model.n)), np.empty((len(z), model.n))
    for t in range(len(z)):
        run = Filter(model).run(tune_node.come_by(z, late, t))
        mean[t], sigma[t] = run.mean[-1], run.sigma[-1]
    in_time = Filter(model)
    plain = in_time.run(z)
    assert np.max(np.abs(plain.mean - mean) / sigma) > 0.1  # it matters
    for one, found, most in zip(asked, told, (1e-9, 2e-5, 1e-5)):
        off = np.abs(numbers(found["mean"]).reshape(mean.shape) - mean) / sigma
        assert off.max() < most, one["arithmetic"]
        np.testing.assert_allclose(numbers(found["sigma"]).reshape(mean.shape), sigma, rtol=most * 10)
        assert found["total"] == pytest.approx(in_time.log_likelihood, abs=1e-3 if most > 1e-6 else 1e-8)
        np.testing.assert_array_equal(numbers(found["taken"]), (~np.isnan(z)).sum(axis=1))
        assert np.sum(numbers(found["log_likelihood"])) == pytest.approx(found["total"], abs=1e-3 if most > 1e-6 else 1e-8)


@needs_node
def test_what_cannot_be_late_says_why():
    model = read("nile")
    content = content_of(model, joining.record(EXAMPLES / "nile.csv", model)[0])
    theta = [one["value"] for one in content["noises"]]
    found, = in_node([{"content": content, "asked": {"theta": theta, "arithmetic": "f64"}, "late": {"cells": [0], "rows": [3]}, "names": ["mean"]}])
    assert found["refused"] == "row 0: cannot be late: nothing is known of the start yet; restore this row"


def model_of(content, theta, dt=None):
    """Of the model file that the page writes"""
    dt = dt or (content["flow"] or {}).get("dt")

    def value(one):
        if isinstance(one, list):
            return repr(sum(factor * theta[k] for k, factor in one))
        if "dt" in one:
            return repr(dt)
        return repr(one["of"] * (theta[one["root"]] / content["noises"][one["root"]]["value"]) ** 0.5)
    text = "".join(one if isinstance(one, str) else value(one) for one in content["template"])
    with tempfile.TemporaryDirectory() as folder:
        path = saved(Path(folder) / "tuned.toml", text)
        return model_file.read(path)


@needs_node
def test_another_dt():
    for name in ("track", "oscillator", "several"):
        model = read(name) if name != "several" else several()[0]
        u = np.ones((120, 1)) if model.inputs else None
        z = with_gaps(model, u=u)
        content = content_of(model, z, u)
        theta = [one["value"] * 1.3 for one in content["noises"]]
        found, = in_node([{"content": content, "asked": {"theta": theta, "dt": 1.7 * model.continuous.dt, "arithmetic": "f64"}, "names": ["mean"]}])
        other = model_of(content, theta, 1.7 * model.continuous.dt)
        np.testing.assert_allclose(numbers(found["mean"]), Filter(other).run(z, u).mean.ravel(), rtol=1e-9, atol=1e-9, err_msg=name)


@needs_node
def test_the_fit_finds_the_optimum_of_the_package():
    for name, model, z, u, times in cases():
        if name not in ("nile", "two_gauges", "trend_season"):  # those that take no time
            continue
        content = content_of(model, z, u, times)
        theta = [one["value"] for one in content["noises"]]
        found, = in_node([{"content": content, "asked": {"theta": theta}, "free": [True] * len(theta)}])
        free, held = free_and_held(",".join(one["fit"] for one in content["noises"]), "", model)
        best = fit(model, [z], free, held=held, Q_form="diagonal", R_form="diagonal")
        assert best.converged and found["value"] >= best.log_likelihood - 1e-6, name
        filter_ = Filter(model_of(content, found["theta"]))
        filter_.run(z)
        assert filter_.log_likelihood == pytest.approx(found["value"], abs=1e-7)


@needs_node
def test_a_step_of_em_is_the_cores():
    """Two sensors, one of them with gaps, and a step that the core's EM (em.h) makes of the same rows"""
    model = Model([[1.0, 1.0], [0.0, 0.9]], H=[[1.0, 0.0], [0.0, 1.0]], R=[[2.0, 0], [0, 0.5]], Q=[[0.3, 0], [0, 0.1]], P0=[[4.0, 0], [0, 1.0]])
    _, z = drawn(model, 80, 4, (30, 36))
    content = content_of(model, z)
    theta = [0.5, 0.2, 1.0, 1.5]
    found, = in_node([{"content": content, "em": "step", "asked": {"theta": theta}}])
    began = Model(model.A, H=model.H, R=np.diag(theta[2:]), Q=np.diag(theta[:2]), P0=model.P0)
    stepped = Estimation(began, [z], ["Q", "R"], Q_form="diagonal", R_form="diagonal").run(iterations=1).model
    np.testing.assert_allclose(found, [*np.diag(stepped.Q), *np.diag(stepped.R)], rtol=1e-6)


@needs_node
def test_em_finds_the_optimum_of_the_package():
    for name, model, z, u, times in cases():
        if name not in ("nile", "two_gauges", "trend_season", "sensors"):
            continue
        content = content_of(model, z, u, times)
        theta = [one["value"] for one in content["noises"]]
        found, = in_node([{"content": content, "em": "all", "asked": {"theta": theta}, "free": [True] * len(theta)}])
        climbed, = in_node([{"content": content, "asked": {"theta": theta}, "free": [True] * len(theta)}])
        assert found["hasEnded"] and found["value"] == pytest.approx(climbed["value"], abs=1e-6), name
        if name == "nile":
            best = fit(model, [z], ["Q", "R"], method="em", tolerance=1e-8)
            assert found["value"] == pytest.approx(best.log_likelihood, abs=1e-6)


REPLAY = """#include "cases.h"
#include "vector.h"
void *memset(void *to, int byte, size_t size) { for (unsigned char *a = to; size--;) *a++ = (unsigned char)byte; return to; }
void *memcpy(void *to, const void *from, size_t size) { unsigned char *a = to; for (const unsigned char *b = from; size--;) *a++ = *b++; return to; }
int cases(void) { return vector_case_count; }
unsigned replay(int k) { vector_difference d; return (unsigned)vector_replay(vector_cases[k].words, vector_cases[k].count, 0, &d); }
"""
IN_NODE = """const { instance } = await WebAssembly.instantiate(require("fs").readFileSync(process.argv[1]), {});
const { cases, replay } = instance.exports;
console.log(JSON.stringify(Array.from({ length: cases() }, (_, k) => replay(k))));"""


@WHOLE
@needs_node
@pytest.mark.skipif(not (shutil.which("clang") and shutil.which("wasm-ld")), reason="no clang or wasm-ld: tools/setup.sh, kq_setup wasm")
def test_golden_vectors_in_webassembly(tmp_path):
    """By the flags that the page's library is compiled with"""
    native = ROOT / "tools/kalmanq/native/wasm"
    flags = re.findall(r" (-[\w=-]+)", re.search(r"set\(flags(.*?)\)", (native / "CMakeLists.txt").read_text(), re.S).group(1))
    assert {"--target=wasm32", "-O2", "-ffp-contract=off"} <= set(flags)
    (tmp_path / "replay.c").write_text(REPLAY)
    parts = ("filter", "statistics", "lengths", "steady", "adaptation", "prepare")
    sources = [ROOT / "src/kq_status.c", ROOT / "src/kq_range_error_q31.c", *(ROOT / f"src/kq_{one}_q31.c" for one in parts),
               *(ROOT / f"tests/vectors/{one}.c" for one in ("vector", "q31", "cases")), tmp_path / "replay.c"]
    subprocess.run(["clang", *flags, f"-I{native}", f"-I{ROOT}/include", f"-I{ROOT}/src", f"-I{ROOT}/tests/vectors", "-nostdlib",
                    "-Wl,--no-entry", "-Wl,--export=cases", "-Wl,--export=replay", *sources, "-o", tmp_path / "vectors.wasm"], check=True)
    made = subprocess.run(["node", "--input-type=commonjs", "-e", "(async () => {" + IN_NODE + "})()", tmp_path / "vectors.wasm"],
                          capture_output=True, text=True, check=True)
    outputs = json.loads(made.stdout)
    assert len(outputs) >= 18 and all(one > 0 for one in outputs), outputs


# ------------------------------------------------------------------------------ the command


@pytest.fixture(scope="module")
def nile(tmp_path_factory):
    path = tmp_path_factory.mktemp("tune") / "nile.html"
    succeeds("tune", EXAMPLES / "nile.toml", EXAMPLES / "nile.csv", "-o", path)
    return path


def test_a_page_asks_nothing_of_a_network(nile):
    text = nile.read_text(encoding="utf-8")
    assert not re.search(r"<(?:link|script|img|iframe)\b[^>]*\s(?:src|href)=|https?://|@import|url\(|fetch\(", text)
    assert "default-src 'none'" in text


MODEL = '[model]\nA = [[1.0]]\nH = [[1.0]]\nQ = [[%s]]\nR = [[%s]]\nP0 = "unknown"\n'
def test_commands_take_the_files_and_their_layout(tmp_path):
    (tmp_path / "model.toml").write_text(MODEL % (1.0, 2.0))
    (tmp_path / "my data.csv").write_text("time;flow\n0;1,5\n1;-9\n3;2,5\n4;2\n")
    options = ["--decimal=,", "--missing=-9", "--rename=z1=flow", "--time=none"]
    succeeds("tune", "model.toml", "my data.csv", *options, folder=tmp_path)
    content = json.loads(re.search(r'id="content">(.*?)</script>', (tmp_path / "tune.html").read_text(encoding="utf-8")).group(1))
    assert content["sources"]["files"] == ["my data.csv"] and content["sources"]["options"] == options
    succeeds("run", "model.toml", *content["sources"]["files"], *content["sources"]["options"], folder=tmp_path)


def test_what_is_late_is_where_it_was_measured(tmp_path):
    made = []
    for delay in (2, 0):
        (tmp_path / "model.toml").write_text(LATE.replace("delay = 2", f"delay = {delay}"))
        column = ["", ""] * (delay > 0) + ["1.5", "2.25", "", "4"] + ["", ""] * (delay == 0)
        (tmp_path / "data.csv").write_text("step,gps\n" + "".join(f"{k},{one}\n" for k, one in enumerate(column)))
        model = model_file.read(tmp_path / "model.toml")
        made.append(page.content(model, *joining.record([tmp_path / "data.csv"], model), SOURCES))
    assert made[0]["z"] == made[1]["z"] and made[0]["total"] == made[1]["total"]


LATE = ('[model]\nA = [[1.0]]\nQ = [[1.0]]\nP0 = "unknown"\n[[sensors]]\nname = "gps"\nH = [[1.0]]\nR = [[1.0]]\ndelay = 2\n')


@pytest.mark.parametrize("model, data, said", [
    (MODEL % (0.0, 0.0), None, "there is nothing to tune"),
    (MODEL % (1.0, 1.0), "z1\n1\nx\n", "data.csv: row 3, column z1"),
    (MODEL % (1.0, 1.0), "flow\n1\n", "there is no column z1"),
    (MODEL % (1.0, 1.0) + "B = [1.0]\n", "z1,u1\n1,1\n2,\n", "control is missing"),
    (MODEL % (1.0, "[1"), None, "model.toml: line 6: Unclosed array"),
])
def test_refusals_are_one_line(tmp_path, model, data, said):
    (tmp_path / "model.toml").write_text(model)
    given = []
    if data:
        (tmp_path / "data.csv").write_text(data)
        given = ["data.csv"]
    refused(kalmanq("tune", "model.toml", *given, "-o", "out.html", folder=tmp_path), said, tmp_path)


@MEASURED
def test_costs_are_those_of_compile_or_why_there_are_none(monkeypatch):
    made, told = page.costs(read("nile")), costs_of(compiled(read("nile"), "filter", Options("q31")))
    for core, one in told.items():
        of = one.of
        assert made["costs"][core]["q31"]["settled"] == [of["two_calls_settled"]]
        assert made["costs"][core]["q31"]["compiled"][::3] == [of["two_calls"], of["stack"]] and made["no_costs"] == ""
    monkeypatch.setenv("PATH", "")
    made = page.costs(Model(1, H=1, R=1, Q=1, P0=1))
    assert made["costs"] == {} and "arm-none-eabi-gcc was not found" in made["no_costs"] and made["no_costs"].startswith("Costs on")


def test_without_webassembly_it_says_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setattr(page, "CORE", tmp_path / "core.wasm")
    made = kalmanq("tune", EXAMPLES / "nile.toml", folder=tmp_path)
    assert made.returncode != 0 and "apt install clang lld" in " ".join(made.stderr.split())
    assert not (tmp_path / "tune.html").exists()


# ------------------------------------------------------------------------------ in a browser


@pytest.fixture(scope="module")
def chromium():
    with browser.Browser() as one:
        yield one


@needs_browser
def test_the_page_does_what_the_package_says(nile, chromium):
    model = read("nile")
    z, _, _ = joining.record(EXAMPLES / "nile.csv", model)
    ready(chromium, nile)
    assert chromium.run("document.body.dataset.bits") == "same"
    assert chromium.run("drawn.consistency.mean") == pytest.approx(np.mean(Filter(model).run(z).nis[1:]), rel=1e-12)  # the start is diffuse
    limits = mean_bounds(len(z) - 1)
    assert chromium.run("[drawn.consistency.low, drawn.consistency.high]") == pytest.approx(limits, abs=1e-4)  # as `kalmanq report`
    for arithmetic in ("f32", "q31", "f64"):
        chromium.run(f"document.querySelector('[value={arithmetic}]').click()")
        settled(chromium)
        np.testing.assert_array_equal(shown(chromium, "pictures.filtered")[0], Filter(model, arithmetic).run(z).mean[:, 0])
        np.testing.assert_array_equal(shown(chromium, "smoothed.smoothed")[0], Smoother(model, arithmetic).run(z).smoothed[:, 0])
    # a slider, by the keyboard
    chromium.run("document.getElementById('noise-0').focus()")
    before = chromium.run("document.getElementById('chart-nis').getBoundingClientRect().top")
    chromium.key("End")
    settled(chromium)
    other = model_file.rebuilt(model, {"drift": 1469.1e6})
    filter_ = Filter(other)
    np.testing.assert_allclose(shown(chromium, "pictures.filtered")[0], filter_.run(z).mean[:, 0], rtol=1e-10)
    assert chromium.run("drawn.total") == pytest.approx(filter_.log_likelihood, rel=1e-10)
    assert chromium.run("document.querySelector('.noise').className") == "noise changed"
    assert chromium.run("document.getElementById('chart-nis').getBoundingClientRect().top") == before
    chromium.key("z", modifiers=2)
    settled(chromium)
    assert chromium.run("set.theta[0]") == 1469.1 and not chromium.run("document.querySelector('.changed')")
    # the fit
    chromium.run("document.getElementById('fit').click()")
    chromium.wait("document.body.dataset.fitted !== undefined")
    settled(chromium)
    best = fit(model, [z], ["Q", "R"]).log_likelihood
    assert float(chromium.run("document.body.dataset.fitted")) == pytest.approx(best, abs=1e-6)
    chromium.run("document.getElementById('reset').click(); document.getElementById('em-fit').click()")
    chromium.wait("document.body.dataset.expected !== undefined")
    settled(chromium)
    assert float(chromium.run("document.body.dataset.expected")) == pytest.approx(best, abs=1e-6)
    assert not chromium.errors


@needs_browser
def test_gaps_are_painted_and_taken_along(nile, chromium, tmp_path):
    model = read("nile")
    z, _, _ = joining.record(EXAMPLES / "nile.csv", model)
    ready(chromium, nile)
    band = [np.subtract(*reversed(shown(chromium, what))) for what in ("pictures.filteredBand", "smoothed.smoothedBand")]
    chromium.run("document.querySelector('[value=gap]').click()")
    box = chromium.run("(() => { const b = document.getElementById('chart-state').getBoundingClientRect(); return [b.left + charts.state.x(40), b.left + charts.state.x(52), b.top + 60]; })()")
    chromium.drag((box[0], box[2]), (box[1], box[2]))
    settled(chromium)
    z[40:53] = np.nan
    wider = [np.subtract(*reversed(shown(chromium, what))) for what in ("pictures.filteredBand", "smoothed.smoothedBand")]
    assert all(np.all(after[40:53] > before[40:53]) for before, after in zip(band, wider))
    np.testing.assert_array_equal(shown(chromium, "pictures.filtered")[0], Filter(model).run(z).mean[:, 0])
    chromium.run("document.querySelector('[value=outlier]').click()")
    at = chromium.run("(() => { const b = document.getElementById('chart-state').getBoundingClientRect(); return [b.left + charts.state.x(20), b.top + charts.state.y(900)]; })()")
    chromium.drag((at[0], at[1] - 30), tuple(at))
    settled(chromium)
    assert chromium.run("set.cells[20]") == pytest.approx(900, abs=10)
    # rows that come late: dragged
    chromium.run("document.querySelector('[value=late]').click(); document.getElementById('late').value = 4")
    box = chromium.run("(() => { const b = document.getElementById('chart-state').getBoundingClientRect(); return [b.left + charts.state.x(60), b.left + charts.state.x(63), b.top + 60]; })()")
    before = shown(chromium, "pictures.filtered")[0]
    chromium.drag((box[0], box[2]), (box[1], box[2]))
    settled(chromium)
    assert chromium.run("set.late") == {str(k): 4 for k in range(60, 64)}
    after = shown(chromium, "pictures.filtered")[0]
    changed = np.flatnonzero(np.abs(after - before) > 1e-6)
    assert changed[0] == 60 and changed[-1] == 66 and np.allclose(before[67:], after[67:])
    assert not chromium.run("document.querySelector('.legend .late').hidden")
    chromium.run("document.getElementById('undo').click()")
    settled(chromium)
    np.testing.assert_array_equal(shown(chromium, "pictures.filtered")[0], before)
    script = chromium.run("script()")
    assert script.startswith("cat > nile_tuned.toml <<'END_OF_MODEL'") and script.rstrip().endswith("nile_tuned.c")
    chromium.run("setNoise(1, 5000)")
    settled(chromium)
    again = saved(tmp_path / "again.html", chromium.run("pageText()"))
    tuned = saved(tmp_path / "tuned.toml", chromium.run("modelText()"))
    assert model_file.read(tuned).R == 5000
    tuned.rename(tmp_path / "nile_tuned.toml")
    for name in ("nile.toml", "nile.csv"):
        (tmp_path / name).symlink_to(EXAMPLES / name)
    said, *lines = chromium.run("commands()").splitlines()
    assert said.startswith("# of the recording as it was")
    for line in lines[:2]:  # fit and run
        succeeds(*shlex.split(line)[1:], folder=tmp_path)
    told = [chromium.run("JSON.stringify([set, drawn.total])"), *shown(chromium, "smoothed.smoothed")]
    ready(chromium, again)
    settled(chromium)
    assert chromium.run("JSON.stringify([set, drawn.total])") == told[0]
    np.testing.assert_array_equal(shown(chromium, "smoothed.smoothed"), told[1:])
    assert not chromium.errors


@needs_browser
def test_nothing_stale_is_shown(chromium, tmp_path):
    """What a run has not told is not shown as if it had, and what changes nothing is no step to take back"""
    model, path = read("track"), tmp_path / "track.html"
    path.write_text(page.page(model, with_gaps(model), None, None, SOURCES), encoding="utf-8")
    ready(chromium, path)

    def do(script):
        chromium.run(script)
        settled(chromium)

    def text(name):
        return chromium.run(f"document.getElementById('{name}').textContent")

    do("$('from').value = 30; $('to').value = 20; change({ lag: 4 }); $('make-gap').click()")  # the other way round
    assert chromium.run("Object.keys(set.cells).length") == 11 * model.m
    count = chromium.run("past.length")
    do("$('make-gap').click(); $('was-0').click(); $('from').value = 5000; $('to').value = 6000; $('make-gap').click()")
    assert chromium.run("past.length") == count and text("message") == "the rows are 0 to 119"
    assert chromium.run("drawn.pictures.lagged !== undefined")
    do("paint('late', 50, 60)")  # then there is no lag
    assert chromium.run("drawn.pictures.lagged === undefined") and "no fixed lag" in text("painted")
    do("$('reset').click(); change({ lag: 4, loss: 'jump', parameter: 9 })")
    assert chromium.run("drawn.refused === null && drawn.pictures.lagged === undefined") and "--robust jump=9\n" in chromium.run("commands()")
    assert chromium.run("[...$('loss').options].map((one) => one.value)") == ["none", *LOSSES]
    do("setParameter(0.5)")
    assert "at least 1" in text("message") and chromium.run("set.parameter") == 9
    do("$('reset').click(); change({ loss: 'gate', parameter: 0.99 })")
    assert "--robust gate=2.5758\n" in chromium.run("commands()")
    do("paint('gap', 0, 110); measureDistance()")
    assert chromium.run("seenBy.second[0] === set.cells")  # by what the distances are measured
    do("$('reset').click(); change({ arithmetic: 'q31', cells: { 5: 1e9 } })")
    do("$('state').value = 1; $('state').onchange()")
    assert text("total") == "–" and "is beyond its range" in text("message")
    do("change({ cells: {} }); document.querySelector('[value=outlier]').click(); $('state').onchange()")
    box = chromium.run("(() => { const b = document.getElementById('chart-state').getBoundingClientRect(); return [b.left + 300, b.top + 60]; })()")
    chromium.drag((box[0], box[1]), (box[0], box[1] + 30))
    assert "No measurement sees this state" in text("message")
    assert "fit model.toml" in chromium.run("commands()")
    do("change({ free: set.free.map((one, k) => k > 0), theta: set.theta.map((one) => 2 * one) })")
    assert "fit track_tuned.toml" in chromium.run("commands()")  # it has the noise that is held
    do("$('reset').click(); change({ arithmetic: 'q31', theta: set.theta.map(() => 1e12) })")
    assert "the sigma of x is up to" in text("message")  # as `kalmanq run` warns
    assert text("total") != "–" and not chromium.run("document.body.className") and not chromium.errors


@needs_browser
def test_a_slider_of_a_short_step_leaves_the_page_full(chromium, tmp_path):
    model, path = of_builder(tmp_path, "constant_acceleration", {**IN_TIME["constant_acceleration"], "dt": 0.01}), tmp_path / "lift.html"
    path.write_text(page.page(with_ranges(model), np.ones((50, 1)), None, None, SOURCES), encoding="utf-8")
    ready(chromium, path)
    for arithmetic in ("f32", "q31", "f64"):
        chromium.run(f"document.querySelector('[value={arithmetic}]').click()")
        for place, end in ((0, "End"), (0, "Home"), (2, "Home"), (2, "End"), (1, "Home")):
            chromium.run(f"document.getElementById('noise-{place}').focus()")
            chromium.key(end)
            settled(chromium)
            assert chromium.run("document.body.dataset.refused || ''") == "" and chromium.run("Number.isFinite(drawn.total) && drawn.smoothed !== null"), (arithmetic, place, end)
    assert not chromium.errors


@needs_browser
def test_widths_names_and_the_tree(nile, chromium, tmp_path):
    for width in (400, 900, 1600):
        ready(chromium, nile, width=width, dark=width == 900)
        chromium.run("document.getElementById('source').open = true")
        assert chromium.run("document.documentElement.scrollWidth") == width
    assert not nameless(chromium)
    assert chromium.run("ticks(-0.42, 0.42, 3.2).made.length") == 5 and chromium.run("ticks(0, 100, 5).made.length") == 6
    # text of others: shown, never run
    bad = "</script><img src=x onerror=alert(1)>"
    model = Model([[1.0]], H=[[1.0]], R=[[1.0]], Q=[[1.0]], name=bad, states=[bad], measurements=[Quantity(bad, "\"'<b>", 9.0)])
    path = saved(tmp_path / "bad.html", page.page(model, np.zeros((20, 1)), None, None, {"model": bad, "data": bad}))
    ready(chromium, path)
    assert chromium.run("document.images.length") == 0 and chromium.run("document.getElementById('name').textContent") == bad
    assert not chromium.errors


@needs_browser
def test_a_browser_without_workers_or_webassembly(nile, chromium):
    with chromium.beginning_with("delete window.Worker"):  # the page itself does it
        ready(chromium, nile)
        assert chromium.run("document.body.dataset.bits") == "same" and chromium.run("drawn.smoothed !== null") and not chromium.errors
    with chromium.beginning_with("delete window.WebAssembly"):
        chromium.open(nile)
        chromium.wait("!document.getElementById('stop').hidden")
        assert "no WebAssembly" in chromium.run("document.getElementById('stop').textContent")
