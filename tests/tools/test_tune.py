"""kalmanq tune: its page has the library's bits, in Node and in a browser, and does what it says."""

from __future__ import annotations

import base64
import json
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import browser
from command import kalmanq
from kalmanq import Filter, LagSmoother, Robust, Smoother, fit
from kalmanq.data import joining
from kalmanq.model import Model, Quantity, model_file
from kalmanq.run.simulation import drawn
from kalmanq.tune import page
from kalmanq.tune.noises import Shape, noises_of

HERE = Path(__file__).parent
EXAMPLES = Path(page.HERE).parent / "examples"
SOURCES = {"model": "model.toml", "data": "data.csv"}
FILTERED = ("mean", "sigma", "innovation", "innovation_sigma", "nis", "log_likelihood")
needs_node = pytest.mark.skipif(not shutil.which("node"), reason="node is not installed: tools/setup.sh, kq_setup browser")
needs_browser = pytest.mark.skipif(not browser.found(), reason="chromium is not installed: tools/setup.sh, kq_setup browser")


def read(name):
    return model_file.read(EXAMPLES / f"{name}.toml")


def content_of(model, z, u=None, times=None):
    return page.content(model, z, u, times, SOURCES)


def in_node(cases):
    made = subprocess.run(["node", HERE / "tune_bits.js", page.HERE / "engine.js", page.CORE], input=json.dumps(cases), capture_output=True,
                          text=True, check=True)
    return json.loads(made.stdout)


def numbers(text):
    return np.frombuffer(base64.b64decode(text), "<f8")


# ------------------------------------------------------------------------------ bits, in Node


def with_gaps(model, rows=120, u=None):
    _, z = drawn(model, rows, 3, (40, 55), u)
    z[70, 0] = np.nan
    return z


def several():
    """Two sensors at times of their own, correlated noise, offsets and a control"""
    ranges = [Quantity("x", "m", 1000.0), Quantity("v", "m/s", 100.0)]
    model = Model.of_continuous([[0, 1], [0, -0.1]], [[1, 0], [0, 1], [1, 1]], [[4, 1, 0], [1, 2, 0], [0, 0, 0.5]], [0.1, 0.3], dt=0.5,
                                B=[0, 1], c=[0, 0.2], d=[1, 0, -2], P0=[9, 4], states=ranges,
                                measurements=[Quantity(name, "m", 1000.0) for name in "abc"], controls=[Quantity("push", "N", 10.0)])
    times = np.cumsum(np.random.default_rng(1).choice([0.5, 1.0, 0.75], 90))
    u = np.sin(times)[:, None]
    _, z = drawn(model, 90, 5, (30, 40), u, times)
    z[::3, 1] = np.nan
    return model, z, u, times


def cases():
    nile = read("nile")
    yield "nile", nile, *joining.record(EXAMPLES / "nile.csv", nile)
    for name in ("track", "two_gauges", "trend_season"):
        yield name, read(name), with_gaps(read(name)), None, None
    co2 = read("co2")
    yield "co2", co2, *joining.record(EXAMPLES / "co2.csv", co2)
    yield "several", *several()


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
def test_losses_are_the_packages():
    model = read("track")
    z = with_gaps(model)
    z[20] += 500
    ways = [Robust("gate", 0.99), Robust("huber", 2.0), Robust("student", 5.0), Robust("jump", 12.0)]
    content = content_of(model, z)
    asked = [{"theta": [one["value"] for one in content["noises"]], "arithmetic": arithmetic, "loss": way.way, "parameter": way.value}
             for way in ways for arithmetic in ("f32", "f64", "q31")]
    told = in_node([{"content": content, "asked": one, "names": ["mean", "sigma"]} for one in asked])
    for one, found in zip(asked, told):
        run = Filter(model, one["arithmetic"]).run(z, robust=Robust(one["loss"], one["parameter"]))
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


def model_of(content, theta, tmp=None):
    """Of the model file that the page writes"""
    def value(one):
        if isinstance(one, list):
            return repr(sum(factor * theta[k] for k, factor in one))
        return repr(one["of"] * (theta[one["root"]] / content["noises"][one["root"]]["value"]) ** 0.5)
    text = "".join(one if isinstance(one, str) else value(one) for one in content["template"])
    import tempfile
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "tuned.toml"
        path.write_text(text, encoding="utf-8")
        return model_file.read(path)
