"""Measurements that are coarse in an arithmetic beside their noise: every command says so, with the cure, and blames nothing else."""

from __future__ import annotations

import json
import warnings
from pathlib import Path

import numpy as np
import pytest
from command import json_of, kalmanq, succeeds
from library import EXAMPLES
from whole import first

from kalmanq import Filter, KalmanqWarning, LagSmoother, Model, Quantity, Smoother, SteadyFilter
from kalmanq.compiler.run.simulation import CompiledFilter
from kalmanq.model import model_file
from kalmanq.pages import verdict
from kalmanq.run.resolution import coarse_of, told_of


# A receiver's raw position, 1e-7 degrees, near 478e6 and -1221e6: a float's steps are 32 and 128 there
UBX = """[model]
builder = "constant_velocity"
dt = 1.0
density = [4.0, 4.0]
noise = [144.0, 324.0]
mean = [478e6, 0, -1221e6, 0]
variance = [1e10, 1e4, 1e10, 1e4]
[measurements]
names = ["lat", "lon"]
"""
RANGES = "ranges = [2e9, 2e9]\n[states]\nranges = [2e9, 1e4, 2e9, 1e4]\n"
LON = "where the step of a float is 128, and its noise has a sigma of 18: subtract an origin from the measurement and x0"


# The same of one state, which is sooner compiled
LEVEL = """[model]
A = [[1]]
H = [1]
Q = 2500
R = 324
x0 = -1221e6
P0 = 1e4
[states]
ranges = [2e9]
[measurements]
names = ["lon"]
ranges = [2e9]
"""


def written(folder: Path, text: str = UBX + RANGES, origin: tuple[float, float] = (0, 0)) -> tuple[Path, Path]:
    """The model, and 600 rows of data"""
    draw, t = np.random.default_rng(6), np.arange(600)
    lat = 478123456 + np.cumsum(30 + 5 * np.sin(t / 40)) + 12 * draw.normal(size=600)
    lon = -1221234567 + np.cumsum(-45 + 8 * np.cos(t / 30)) + 18 * draw.normal(size=600)
    (folder / "ubx.toml").write_text(text)
    (folder / "ubx.csv").write_text("lat,lon\n" + "".join(f"{a - origin[0]:.0f},{b - origin[1]:.0f}\n" for a, b in zip(lat, lon)))
    return folder / "ubx.toml", folder / "ubx.csv"


def test_the_step_is_that_of_the_arithmetic_where_the_measurement_is(tmp_path):
    ranged, plain = (model_file.read(written(tmp_path, text)[0]) for text in (UBX + RANGES, UBX))
    z = np.loadtxt(tmp_path / "ubx.csv", delimiter=",", skiprows=1)
    for model, given, steps in ((ranged, None, [128, 128]), (plain, None, [32, 128]), (ranged, z, [32, 128]), (plain, z, [32, 128])):
        assert [one.step for one in coarse_of(model, "f32", given)] == steps
        assert not coarse_of(model, "f64", given) and not coarse_of(model, "q31", given)
    assert all(told_of(one, "f32").endswith(f"{LON}, or take q31") for one in (plain, ranged))
    assert told_of(ranged.changed(R=[1e-3, 1e-3]), "f32").endswith("x0")  # q31's steps are 1
    sharp = ranged.changed(R=[0.25, 0.01])
    assert [one.step for one in coarse_of(sharp, "q31")] == [1, 1]
    assert not coarse_of(sharp, "q31", z)  # whole numbers
    assert [one.step for one in coarse_of(sharp, "q31", z + 0.3)] == [1, 1]
    assert told_of(sharp, "q31", z + 0.3).endswith("lon has steps of 1 in q31, and its noise a sigma of 0.1: give a smaller range, with an origin subtracted "
                                                   "from the measurement and x0")
    assert not coarse_of(ranged, "f32", np.float32(z).astype(float))  # a float has them as they are
    assert not coarse_of(ranged.changed(R=[0, 0]), "f32")  # nothing is told of a noise
    wild = z - [478e6, -1221e6]
    wild[:20] = 1.5e9
    assert not coarse_of(ranged, "f32", wild) and not coarse_of(ranged, "f32", np.full((3, 2), np.nan))


@pytest.mark.parametrize("make", [Filter, Smoother, SteadyFilter, lambda model, arithmetic: LagSmoother(model, 1, arithmetic), CompiledFilter])
def test_a_run_warns_once_and_only_in_that_arithmetic(tmp_path, make):
    model = model_file.read(written(tmp_path)[0])
    z = np.loadtxt(tmp_path / "ubx.csv", delimiter=",", skiprows=1)
    for arithmetic in ("f32", "f64", "q31"):
        made = make(model, arithmetic)
        with (made if make is CompiledFilter else warnings.catch_warnings()), warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always", KalmanqWarning)
            made.run(z[:300])
            if make is not Smoother:
                made.run(z[300:])
        said = [str(one.message) for one in told if "step" in str(one.message)]
        assert len(said) == (arithmetic == "f32"), said
        assert not said or said[0].startswith("ubx, f32: lat is as large as 4.781e+08, where the step of a float is 32, and its noise has a sigma of 12; lon")


def test_commands_say_it_with_the_cure(tmp_path):
    model, data = written(tmp_path)
    done = kalmanq("check", model)
    assert done.returncode == 1 and "NO  resolution: f32: lat may be 2e+09" in done.stdout and f"{LON}, or take q31" in " ".join(done.stdout.split())
    assert kalmanq("check", model, "--arith", "q31").returncode == kalmanq("check", model, "--arith", "f64").returncode == 0
    for more in ((), ("--compiled",), ("--smooth",), ("--lag", 2)):
        done = kalmanq("run", model, data, "--arith", "f32", *more)
        assert done.returncode == 0 and done.stderr.count(LON) == 1 and "do not fit" not in done.stdout, more
        assert "f32 is too coarse for these measurements" in done.stdout or "--compiled" in more  # whose NIS is of double
    assert "step" not in kalmanq("run", model, data, "--arith", "q31").stderr
    model = written(tmp_path, LEVEL)[0]
    told = json_of("compile", model, "-o", tmp_path / "nav.c")["resolution"]
    report = " ".join((tmp_path / "nav_report.txt").read_text().split())
    assert told.startswith("lon may be 2e+09") and LON in told and f"Measurements are coarse in f32: {told}." in report


@pytest.mark.usefixtures("no_offers")
@pytest.mark.parametrize("by_command", first(1, [False, True]))
def test_a_report_does_not_judge_the_model(tmp_path, by_command):
    model, data = written(tmp_path)
    if by_command:
        done = kalmanq("report", model, data, "-o", tmp_path / "page.html", "--arith", "f32")
        assert done.stdout.startswith("The arithmetic is too coarse") and "its noise has a sigma of 12" in (tmp_path / "page.html").read_text()
        return
    read, z = model_file.read(model), np.loadtxt(data, delimiter=",", skiprows=1)
    for arithmetic in ("f32", "q31"):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            found = verdict.findings(Smoother(read, arithmetic).run(z), z)
        is_coarse = verdict.headline(found) == "The arithmetic is too coarse for these measurements, and the fit cannot be judged."
        assert is_coarse == (arithmetic == "f32") == all(one.state == "note" for one in found[1:]), arithmetic


@pytest.mark.parametrize("data", first(1, [True, False]))
def test_design_names_the_cause(tmp_path, data):
    model, rows = written(tmp_path, LEVEL)
    done = kalmanq("design", model, "--core", "m4f", "--arith", "f32", "--json", *(("--data", rows) if data else ()))
    assert done.returncode == 1 and "sigma from double's: lon is as large as 1.22" in done.stderr and LON in done.stderr
    assert done.stderr.count("\n") == 1
    trials = json.loads(done.stdout)["trials"]
    assert LON in trials["f32"]["warnings"][-1]
    if data:  # of whole numbers
        assert not trials["q31"]["warnings"]
    else:
        assert "lon has steps of 1 in q31" in trials["q31"]["warnings"][-1]


def test_with_an_origin_subtracted_nothing_is_said(tmp_path):
    text = UBX.replace("478e6, 0, -1221e6", "0, 0, 0") + RANGES.replace("2e9", "1e5")
    model, data = written(tmp_path, text, (478120000, -1221230000))
    succeeds("check", model)
    done = kalmanq("run", model, data, "--arith", "f32")
    assert done.returncode == 0 and not done.stderr and "too coarse" not in done.stdout
    read, z = model_file.read(model), np.loadtxt(data, delimiter=",", skiprows=1)
    single, double = Filter(read, "f32").run(z), Filter(read).run(z)
    assert np.max(np.abs(single.mean - double.mean) / double.sigma) < 1e-4


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.toml")), ids=lambda one: one.stem)
def test_no_example_is_coarse(path):
    assert not any(told_of(model_file.read(path), arithmetic) for arithmetic in ("f32", "f64", "q31"))


def test_a_step_that_noise_hides_is_none():
    """Rounding to half a sigma of the noise costs less than 2 % of what is known"""
    draw, model = np.random.default_rng(1), Model(1, H=1, R=1, Q=0.01, P0=1e4, x0=8e6, measurements=[Quantity("z")])
    x = 8e6 + np.cumsum(0.1 * draw.normal(size=20000))
    z = x + draw.normal(size=len(x))
    assert not coarse_of(model, "f32", z[:, None]) and coarse_of(model.changed(R=0.9), "f32", z[:, None] + 1e6)
    single, double = Filter(model, "f32").run(z), Filter(model).run(z)
    error = [np.sqrt(np.mean((run.mean[:, 0] - x) ** 2)) for run in (single, double)]
    assert error[0] < 1.02 * error[1]


def test_a_nonlinear_model_is_judged_where_h_is(tmp_path):
    """Its ranges are of innovations"""
    path, rows = tmp_path / "lon.py", tmp_path / "lon.csv"
    path.write_text("states, measurements = {'names': ['lon', 'v']}, {'names': ['z'], 'ranges': [1000]}\nx0, P0, R, dt = [-1.221e9, 0.0], [1e4, 1e2], 324.0, 1.0\n"
                    "Q = [0.0, 4.0]\ndef f(x, t, u, dt): return [x[0] + x[1] * dt, x[1]]\ndef h(x): return [x[0]]\n")
    rows.write_text("z\n" + "".join(f"{-1221234567 - 45 * k + 17 * (k % 3)}\n" for k in range(80)))
    for data in ((), (rows,)):
        done = kalmanq("check", path, *data)
        assert done.returncode == 1 and "NO  resolution: f32: z is" in done.stdout and " ".join(done.stdout.split()).endswith(LON), done.stdout
        succeeds("check", path, *data, "--arith", "f64")
    done = kalmanq("compile", path, "-o", tmp_path / "lon.c")
    said = " ".join(done.stdout.split())
    assert "Measurements are coarse: z is -1.221e+09 at first" in said and LON in said and "loses most" not in said
    assert LON in kalmanq("run", path, rows, "--arith", "f32", "--compiled").stderr
    assert "step" not in kalmanq("run", path, rows, "--arith", "f64", "--compiled").stderr
