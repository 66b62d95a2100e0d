"""kalmanq tune MODEL.py: its page has the bits of the C that `kalmanq compile` writes, and gives this C with its noises."""

from __future__ import annotations

import re
import shlex

import browser
import numpy as np
import pytest
import tune_node
from command import kalmanq, refused, succeeds
from equations import EXAMPLES, FOLDER
from library import saved
from tune_node import nameless, needs_browser, needs_node, numbers, ready, settled, shown
from whole import WHOLE

from kalmanq import fit
from kalmanq.compiler.given.request import Options
from kalmanq.compiler.run.equation_run import CompiledEquations
from kalmanq.compiler.run.host import Host
from kalmanq.compiler.text.equation_product import compiled_equations
from kalmanq.data import joining
from kalmanq.nonlinear import file, read
from kalmanq.nonlinear.simulation import simulate
from kalmanq.tune import emitted, equations
from kalmanq.tune.equation_noises import noises_of, text_of

OTHERS = [0.25, 3e-6, 1e-4, 4.0, 0.3]  # of the correlated ones powers of 4: other factors are off by a last bit
FILTERED = ("mean", "sigma", "innovation", "innovation_sigma", "nis", "log_likelihood")
# Nothing but operations that have the same bits everywhere: no function of the C library but the root
EXACT = """
import numpy as np
states = {"names": ["place", "speed", "drag"], "units": ["m", "m/s", ""]}
measurements = {"names": ["range", "height", "side", "pace"], "units": ["m", "m", "m", "m/s"]}
controls = ["push"]
x0, P0 = [3.0, 1.0, 0.1], [1.0, 0.5, 0.01]
Q = [[0.01, 0.002, 0], [0.002, 0.03, 0], [0, 0, 1e-6]]
def increment(x, t, u): return [0.1 * x[1], 0.1 * (u[0] - (0.3 + x[2]) * x[1] / (1 + x[1] ** 2)), 0]
sensors = {"radar": (lambda x: [np.sqrt(9 + x[0] ** 2), x[0], 2 * x[0]], [[0.04, 0, 0], [0, 1.0, 0.3], [0, 0.3, 0.5]]), "pace": (lambda x: [x[1]], [0.09])}
def simulated_controls(t): return [0.5 if t % 20 < 10 else -0.25]
"""


# Small, with functions of the C library
TANK = """
import numpy as np
states = {"names": ["level"], "units": ["m"]}
measurements = {"names": ["echo"], "units": ["ms"]}
x0, P0, Q, R = [1.0], [0.1], [0.002], 0.01
def f(x): return [x[0] + 0.1 * np.sin(2 * x[0])]
def h(x): return [6 * np.exp(-0.3 * x[0])]
"""


@pytest.fixture(scope="module")
def exact(tmp_path_factory):
    """A model, its recording, and a page's content and WebAssembly"""
    path = saved(tmp_path_factory.mktemp("exact") / "exact.py", EXACT)
    model = read(path)
    _, z, u = simulate(model, 60, 2)
    z[20:25] = np.nan
    z[::3, 3] = np.nan
    z[40, 0] += 4
    return model, z, u, *equations.content(model, z, u, None, {"model": "exact.py", "data": ""})


# Far away where its noises are large: there a float's rounding of the range would be looked at
TRACKER = """
import numpy as np
states, measurements, angles = ["x", "y", "vx", "vy"], ["range", "bearing"], ["bearing"]
x0, P0, Q, R = [10.0, 5.0, -0.5, 0.0], [1.0, 1.0, 0.1, 0.1], [1e-6, 1e-6, 1e-4, 1e-4], [0.01, 1e-4]
def f(x): return [x[0] + x[2], x[1] + x[3], x[2], x[3]]
def h(x): return [np.hypot(x[0], x[1]), np.arctan2(x[1], x[0])]
"""


def test_a_range_and_a_bearing_have_one_form_for_all_noises(tmp_path):
    path = saved(tmp_path / "tracker.py", TRACKER)
    model = read(path)
    noises = noises_of(model)
    made = emitted.variants(lambda sizes: with_sizes(model, sizes), [one.value for one in noises], 60, "tracker")
    double, single = next(made), next(made)
    assert single.name == "none_f32" and {one.noise for one in single.run.literals} >= set(range(len(noises)))


def with_sizes(model, theta):
    source = file.source_of(model.path).decode()
    return file.read_text(model.path, text_of(source, model, noises_of(model), lambda k, factor: factor * theta[k], lambda k, factor: factor * theta[k] ** 0.5))


def asked_of(content, theta=None, **more):
    return {"theta": theta or [one["value"] for one in content["noises"]], "loss": "none", "arithmetic": "f64", "parameter": None, "smooth": True, "ahead": 5, **more}


@needs_node
@pytest.mark.parametrize("loss, parameter", [("none", None), ("gate", 2.5), ("student", 6.0)])
def test_a_run_has_the_bits_of_the_emitted_c(exact, loss, parameter):
    model, z, u, content, core = exact
    values = [one["value"] for one in content["noises"]]
    cases = [(arithmetic, theta) for arithmetic in ("f32", "f64") for theta in ((values, OTHERS) if loss == "none" else (OTHERS,))]
    told = tune_node.ran(core, [{"content": content, "asked": asked_of(content, theta, arithmetic=arithmetic, loss=loss, parameter=parameter),
                                 "names": ["mean", "sigma", "smoothed", "taken"]} for arithmetic, theta in cases])
    for (arithmetic, theta), found in zip(cases, told):
        options = Options(arithmetic, nis=True, smooth=len(z), **({} if loss == "none" else {loss: parameter}))
        with Host(compiled_equations(model if theta is values else with_sizes(model, theta), "kf", options)) as host:
            carried = np.vstack([u[:1], u[:-1]])
            ran = host.run(z, carried, now=u)
            back = host.smoothed(np.arange(len(z)) > 0)
        wanted = {"mean": ran.mean, "sigma": np.sqrt(np.diagonal(ran.covariance, axis1=1, axis2=2)), "smoothed": back.mean,
                  "taken": [bin(one).count("1") for one in ran.taken]}
        for name, array in wanted.items():
            np.testing.assert_array_equal(numbers(found[name]), np.ravel(array), err_msg=f"{name}, {arithmetic}")


@needs_node
def test_what_is_told_of_rows_is_the_hosts(exact):
    model, z, u, content, core = exact
    found, = tune_node.ran(core, [{"content": content, "asked": asked_of(content), "names": [*FILTERED, "expected", "forecast"]}])
    with CompiledEquations(model, "f64") as host:
        run = host.run(z, u)
    for name in FILTERED:
        np.testing.assert_allclose(numbers(found[name]), np.ravel(getattr(run, name)), rtol=1e-9, atol=1e-11, err_msg=name)
    assert found["total"] == pytest.approx(content["total"], rel=1e-12) and found["apart"] == 0
    np.testing.assert_allclose(numbers(found["expected"]).reshape(len(z), -1), [model.expected(x, t, u[t]) for t, x in enumerate(run.mean)], rtol=1e-12)
    x, ahead = run.mean[-1], []
    for k in range(5):
        x = model.moved(x, len(z) - 1 + k, u[-1])
        ahead.append(x)
    np.testing.assert_allclose(numbers(found["forecast"]).reshape(5, -1), ahead, rtol=1e-9)


@needs_node
def test_what_comes_late_is_taken_when_it_comes(exact):
    """Compared with the emitted C over all rows again, with what has come by then: the same bits"""
    model, z, u, content, core = exact
    late = {t * model.m + c: by for t, by in {8: 4, 9: 4, 10: 1, 30: 7, 58: 5}.items() for c in range(model.m) if t != 30 or c == 0}
    asked = [asked_of(content, arithmetic=arithmetic, smooth=False, loss="gate", parameter=4.0) for arithmetic in ("f32", "f64")]
    told = tune_node.ran(core, [{"content": content, "asked": one, "late": {"cells": list(late), "rows": list(late.values())}, "names": ["mean", "taken", "innovation"]} for one in asked])
    for one, found in zip(asked, told):
        assert np.all(np.isnan(numbers(found["innovation"]).reshape(z.shape)[58]))  # what comes after the last row never came
        mean = np.empty((len(z), model.n))
        with Host(compiled_equations(model, "kf", Options(one["arithmetic"], gate=4.0))) as host:
            for t in range(len(z)):
                mean[t] = host.run(tune_node.come_by(z, late, t), np.vstack([u[:1], u[:t]]), now=u[:t + 1]).mean[-1]
            in_time = host.run(z, np.vstack([u[:1], u[:-1]]), now=u)
        np.testing.assert_array_equal(numbers(found["mean"]).reshape(mean.shape), mean)
        assert np.any(mean[8:14] != in_time.mean[8:14])


@needs_node
def test_the_c_is_the_text_that_compile_writes(exact):
    model, z, u, content, core = exact
    cases = [(loss, parameter, arithmetic) for loss, parameter in (("none", None), ("gate", 2.5), ("student", 7.0)) for arithmetic in ("f32", "f64")]
    told = tune_node.ran(core, [{"content": content, "code": True, "asked": asked_of(content, OTHERS, loss=loss, parameter=parameter, arithmetic=arithmetic)}
                                for loss, parameter, arithmetic in cases])
    for (loss, parameter, arithmetic), found in zip(cases, told):
        options = Options(arithmetic, **({} if loss == "none" else {loss: parameter}))
        product = compiled_equations(with_sizes(model, OTHERS), "exact", options)
        assert found["header"] == product.sources()["exact.h"]
        assert found["code"] == product.sources()["exact.c"]


@pytest.fixture(scope="module")
def tank(tmp_path_factory):
    path = saved(tmp_path_factory.mktemp("tank") / "tank.py", TANK)
    model = read(path)
    _, z, u = simulate(model, 80, 3)
    return model, z, u, None, *equations.content(model, z, u, None, {"model": "tank.py", "data": ""})


@needs_node
def test_functions_of_the_browser_are_within_rounding_of_the_host(tank):
    judge(*tank)


@WHOLE
@needs_node
@pytest.mark.parametrize("name", ["range_bearing", "battery"])
def test_examples_are_within_rounding_of_the_host(name):
    model = read(EXAMPLES / f"{name}.py")
    z, u, times = joining.record(EXAMPLES / f"{name}.csv", model)
    judge(model, z, u, times, *equations.content(model, z, u, times, {"model": f"{name}.py", "data": ""}))


def judge(model, z, u, times, content, core):
    told = tune_node.ran(core, [{"content": content, "asked": asked_of(content, arithmetic=arithmetic), "names": [*FILTERED, "smoothed"]} for arithmetic in ("f32", "f64")])
    for arithmetic, found in zip(("f32", "f64"), told):
        with CompiledEquations(model, arithmetic, smooths=len(z)) as host:
            run = host.run(z, u, times=times)
        for field in ("mean", "smoothed"):
            off = np.abs(numbers(found[field]).reshape(run.mean.shape) - getattr(run, field)) / run.smoothed_sigma
            assert np.all(np.isfinite(off)) and off.max() < (1e-2 if arithmetic == "f32" else 1e-9), (arithmetic, field)
        np.testing.assert_allclose(numbers(found["innovation_sigma"]), np.ravel(run.innovation_sigma), rtol=1e-3 if arithmetic == "f32" else 1e-9)


@needs_node
def test_the_fit_finds_the_optimum_of_the_package(tank):
    model, z, _, _, content, core = tank
    found, = tune_node.ran(core, [{"content": content, "asked": asked_of(content), "free": [True, True]}])
    best = fit(model, [z], ["Q", "R"], Q_form="diagonal", R_form="diagonal")
    assert best.converged and found["value"] == pytest.approx(best.log_likelihood, abs=1e-6)
    np.testing.assert_allclose(found["theta"], [best.value("Q")[0, 0], best.value("R")[0, 0]], rtol=2e-3)


@WHOLE
@needs_node
@pytest.mark.parametrize("path", [*sorted(FOLDER.glob("*.py")), *sorted((FOLDER / "timed").glob("*.py"))], ids=lambda one: one.stem)
def test_models_of_all_kinds(path):
    if path.stem in ("planar", "rotations"):
        pytest.skip("helpers of models")
    model = read(path)
    _, z, u = simulate(model, 40, 1)
    content, core = equations.content(model, z, u, None, {"model": path.name, "data": ""})
    found, = tune_node.ran(core, [{"content": content, "asked": asked_of(content), "names": ["mean", "smoothed"]}])
    assert found["apart"] < 1e-6 and found["total"] == pytest.approx(content["total"], rel=1e-6)
    assert np.all(np.isfinite(numbers(found["smoothed"])))


# ------------------------------------------------------------------------------ the command


@pytest.mark.parametrize("change, said", [
    (("x0, P0", "x0, P_0"), "P0: is missing"),
    (("np.sqrt(9 + x[0] ** 2)", "np.linalg.eigvals([[x[0]]])[0]"), "exact.py: line"),
    (("Q = [[0.01, 0.002, 0], [0.002, 0.03, 0], [0, 0, 1e-6]]", "Q = [[0.01, 0.2, 0], [0.2, 0.03, 0], [0, 0, 1e-6]]"), "Q: is no covariance"),
])
def test_refusals_are_one_line(tmp_path, change, said):
    (tmp_path / "exact.py").write_text(EXACT.replace(*change))
    refused(kalmanq("tune", "exact.py", "-o", "out.html", folder=tmp_path), said, tmp_path)


def test_without_clang_it_says_what_to_install(tmp_path, monkeypatch):
    for name in ("CLANG", "LINKER"):
        with monkeypatch.context() as patch:
            patch.setattr(emitted, name, ("no-such-program",))
            made = kalmanq("tune", EXAMPLES / "battery.py", folder=tmp_path)
        assert made.returncode != 0 and "apt install clang lld" in " ".join(made.stderr.split())
        assert not (tmp_path / "tune.html").exists()


# ------------------------------------------------------------------------------ in a browser


@needs_browser
def test_the_page_of_a_nonlinear_model(tmp_path):
    (tmp_path / "tank.py").write_text(TANK)
    model = read(tmp_path / "tank.py")
    z = simulate(model, 60, 5)[1]
    (tmp_path / "tank.csv").write_text("echo\n" + "".join(f"{one!r}\n" for one in z[:, 0].tolist()))
    page = tmp_path / "tune.html"
    succeeds("tune", "tank.py", "tank.csv", folder=tmp_path)
    with browser.Browser() as chromium:
        ready(chromium, page)
        bits = chromium.run("document.getElementById('bits').textContent")
        assert bits in ("start: the host's bits", "start: the host's but for last bits") or float(re.fullmatch(r"start: (\S+) sigma off the host", bits)[1]) < 1e-9
        chromium.run("setNoise(1, 0.02); document.getElementById('loss').value = 'gate'; document.getElementById('loss').onchange()")
        settled(chromium)
        chromium.run("document.getElementById('state').value = '0'; document.getElementById('state').onchange()")
        settled(chromium)
        with Host(compiled_equations(model.changed(R=0.02), "kf", Options("f64", gate=4.0))) as host:
            ran = host.run(z)
        np.testing.assert_allclose(shown(chromium, "pictures.filtered")[0], ran.mean[:, 0], rtol=1e-9)
        (tmp_path / "tank_tuned.py").write_text(chromium.run("modelText()"))
        chromium.run("Object.defineProperty(navigator, 'clipboard', { value: undefined }); document.getElementById('copy').click()")
        chromium.wait("document.getElementById('copied').textContent.includes('is selected')")
        assert chromium.run("getSelection().toString() === script().trimEnd() || getSelection().toString() === script()")
        lines = chromium.run("commands()").splitlines()
        assert lines.pop(0) == "# kalmanq run has no gate" and len(lines) == 3 and "--robust gate=4" in lines[2]
        for line in lines[1:]:
            succeeds(*shlex.split(line)[1:], folder=tmp_path)
        code = chromium.run("codeOf(content, set).then((made) => made.code)")
        assert code.split("\n", 3)[3] == (tmp_path / "tank.c").read_text().split("\n", 4)[4]  # but for the line with the file's digest
        chromium.run("document.getElementById('source').open = true")
        chromium.wait("document.getElementById('source-text').textContent.includes('tank_predict')")
        assert not nameless(chromium)
        for width in (400, 900, 1600):
            chromium.look(width, 900, dark=width == 900)
            assert chromium.run("document.documentElement.scrollWidth") == width
        chromium.look(1200, 900)
        again = saved(tmp_path / "again.html", chromium.run("pageText()"))
        told = chromium.run("JSON.stringify([set, drawn.total])")
        ready(chromium, again)
        assert chromium.run("JSON.stringify([set, drawn.total])") == told
        assert not chromium.errors
