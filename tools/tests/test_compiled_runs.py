"""--compiled of compare, report and simulate --runs: they are of the emitted C, and say what it has not."""

from __future__ import annotations

import hashlib
import json
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from command import json_of, kalmanq, refused, succeeds
from library import EXAMPLES, saved
from test_commands import rows_of
from test_report import Page
from whole import first

from kalmanq import Filter, KalmanqError, Model, Quantity, nonlinear
from kalmanq.compiler.run.simulation import CompiledFilter
from kalmanq.data import joining
from kalmanq.data.written import writing
from kalmanq.model import model_file
from kalmanq.pages import verdict
from kalmanq.run.campaigns import journal_of, run_campaign
from kalmanq.run.comparison import beside
from kalmanq.run.diagnostics import nees
from kalmanq.run.monte_carlo import Study, one_run, root_mean_square
from kalmanq.run.simulation import drawn

CART, GAUGES = EXAMPLES / "cart.toml", EXAMPLES / "two_gauges.toml"


@pytest.fixture(scope="module")
def known(tmp_path_factory):
    """The cart with a start that is known, and data of it with a gap"""
    folder = tmp_path_factory.mktemp("known")
    path = saved(folder / "cart.toml", CART.read_text().replace('"unknown"', "4.0"))
    succeeds("simulate", path, "-n", 150, "--seed", 3, "--gap", 40, 45, "--out", folder / "z.csv")
    return path, folder / "z.csv"


def emitted(model, arithmetic, path):
    z, u, _ = joining.record(path, model)
    with CompiledFilter(model, arithmetic) as one:
        return z, u, one.run(z, u)


# ------------------------------------------------------------------------------ compare


def test_compare_has_rows_of_the_emitted_c(known, tmp_path):
    cart, pushed = known
    done = kalmanq("compare", cart, pushed, "--compiled", "--json", "--plot", tmp_path / "errors.png")
    told = json.loads(done.stdout)
    assert list(told) == ["f32", "q31", "compiled f32", "compiled q31"] and (tmp_path / "errors.png").is_file()
    model = model_file.read(cart)
    for name in ("f32", "q31"):
        z, u, run = emitted(model, name, pushed)
        assert told[f"compiled {name}"] == json.loads(json.dumps(beside(run, Filter(model, "f64").run(z, u))[1]))
        assert told[f"compiled {name}"]["mean_error_in_sigma"] < 1e-3
        assert told[f"compiled {name}"]["sigma_relative_error"] < 1e-4
    plain = json_of("compare", cart, pushed)
    assert plain == {name: told[name] for name in ("f32", "q31")}
    shown = kalmanq("compare", cart, pushed, "--compiled").stdout
    assert "compiled f32" in shown and "compiled q31" in shown


def test_an_event_of_the_emitted_c_has_its_own_name(tmp_path):
    path = tmp_path / "z.csv"
    model = model_file.read(CART)
    z = drawn(model, 30, 1, None)[1]
    z[10] = 10 * model.measurements[0].range
    path.write_text("range,push\n" + "".join(f"{one!r},0\n" for one in z[:, 0].tolist()))
    told = json_of("compare", CART, path, "--compiled")
    assert told["compiled f32"]["events"] == ["refused"]
    run = emitted(model, "f32", path)[2]
    events = [one for one in verdict.findings(run, z) if one.subject == "Events"]
    assert events[0].state == "bad" and "outside its range: it was not taken" in events[0].said


def test_what_is_not_compiled_is_said_and_the_others_stay(tmp_path):
    path = saved(tmp_path / "still.toml", "[model]\nA = 1\nH = 1\nQ = 1\nR = 0\nP0 = 1\n")
    data = saved(tmp_path / "z.csv", "z0\n" + "\n".join(map(str, range(20))) + "\n")
    name = model_file.read(path).measurements[0].name
    data.write_text(data.read_text().replace("z0", name))
    told = json_of("compare", path, data, "--compiled")
    assert "mean_error_in_sigma" in told["f32"] and "has no noise" in told["compiled f32"]["refused"]
    refused(kalmanq("report", path, data, "--compiled", "-o", tmp_path / "r.html"), "has no noise", tmp_path)
    refused(kalmanq("simulate", path, "--compiled", "--runs", 2, "--workers", 1, "--out", tmp_path / "o.csv"),
            "has no noise", tmp_path)


def test_a_nonlinear_model_in_q31_is_the_device_over_the_library(tmp_path):
    model, data = EXAMPLES / "range_bearing.py", EXAMPLES / "range_bearing.csv"
    told = json_of("run", model, data, "--compiled", "--arith", "q31")
    near = json_of("run", model, data, "--compiled", "--arith", "f64")
    assert told["taken"] == near["taken"] and told["log_likelihood"] == pytest.approx(near["log_likelihood"], abs=0.01)
    for more, said in ((("--smooth",), "--smooth"), (("--method", "iterated"), "--method iterated")):
        refused(kalmanq("run", model, data, "--compiled", "--arith", "q31", *more), f"is an extended filter: leave {said} out", tmp_path)


# ------------------------------------------------------------------------------ report


@pytest.mark.parametrize("arithmetic", first(1, ("q31", "f32", "f64")))
def test_the_report_is_of_the_emitted_c(arithmetic, known, tmp_path):
    """Of a start that is unknown the emitted filter counts the first rows, with a wide sigma: the library does not."""
    out, pushed = tmp_path / "report.html", known[1]
    done = succeeds("report", CART, pushed, "--compiled", "--arith", arithmetic, "-o", out)
    assert "left out: smoothed states and sigmas; the emitted filter looks at no later row" in done.stdout
    text = Page(out).text
    assert f"arithmetic {arithmetic}, compiled" in text and "left out: smoothed states" in text
    assert "smoothed: given all rows" not in text and "compiled q31" in text
    z, u, run = emitted(model_file.read(CART), arithmetic, pushed)
    found = verdict.findings(run, z)
    assert verdict.headline(found) in done.stdout and all(one.said in text for one in found)
    log_likelihood = np.sum(run.log_likelihood)
    assert f"log-likelihood {log_likelihood:.8g}" in text
    assert abs(log_likelihood - np.sum(Filter(run.model, arithmetic).run(z, u).log_likelihood)) > 1


@pytest.mark.parametrize("arithmetic", ("f32", "q31"))
def test_a_gap_of_k_steps_is_k_predictions(arithmetic, tmp_path):
    """Beside the library, which goes through a gap in one step; controls stay as they are; two calls are one"""
    model = Model.of_continuous(
        F=[[0, 1], [0, -0.2]], Qc=[[0, 0], [0, 0.1]], B=[[0], [1]], dt=0.1, H=[[1, 0]], R=[0.04], x0=[0, 0], P0=[1, 1],
        states=[Quantity("p", range=500), Quantity("v", range=50)], measurements=[Quantity("z", range=500)], controls=[Quantity("push", range=10)])
    draw = np.random.default_rng(3)
    times = 0.1 * np.cumsum(draw.choice([1, 1, 1, 2, 7], 200))
    u = np.sin(times)[:, None]
    z = np.where(draw.random((200, 1)) < 0.1, np.nan, draw.normal(0, 0.2, (200, 1)))
    exact = Filter(model, "f64").run(z, u, times=times)
    with CompiledFilter(model, arithmetic) as one:
        run = one.run(z, u, times)
        assert len(run) == 200 and (run.taken == exact.taken).all() and beside(run, exact)[1]["mean_error_in_sigma"] < 1e-3
        assert np.allclose(run.log_likelihood, exact.log_likelihood, atol=1e-3)
        one.restart()
        first = 1 + int(np.argmax(np.diff(times) > 0.5))  # the second call begins behind a gap
        parts = [one.run(z[rows], u[rows], times[rows]) for rows in (slice(0, first), slice(first, None))]
        assert (np.concatenate([part.mean for part in parts]) == run.mean).all()
        with pytest.raises(KalmanqError, match="steps of dt = 0.1 alone"):
            one.run(z[:1], u[:1], times[-1:] + 0.15)
        with pytest.raises(KalmanqError, match="join rows of one time"):
            one.run(z[:2], u[:2], times[-1] + np.array([0.1, 0.1]))


# ------------------------------------------------------------------------------ simulate --runs


@pytest.mark.parametrize("arithmetic", ("f32", "q31"))
def test_a_campaign_is_of_the_emitted_c(arithmetic, tmp_path):
    out, common = tmp_path / "runs.csv", ("simulate", CART, "-n", 60, "--seed", 5, "--compiled", "--arith", arithmetic)
    done = succeeds(*common, "--runs", 6, "--workers", 1, "--out", out, "--json")
    assert json.loads(done.stdout)["way"] == "compiled"
    rows, model = rows_of(out), model_file.read(CART)
    with CompiledFilter(model, arithmetic) as one:
        for number in (0, 5):
            x, z = drawn(model, 60, np.random.SeedSequence(5, spawn_key=(number,)), None)
            one.restart()
            run = one.run(z)
            for i, state in enumerate(model.states):
                assert float(rows[number][f"{state.name}_rmse"]) == root_mean_square(run.mean[:, i] - x[:, i])
            score, dimensions = nees(run.mean - x, run.covariance, arithmetic)
            assert float(rows[number]["nees"]) == score.sum() / dimensions.sum()
            assert float(rows[number]["loglik"]) == run.log_likelihood.sum()
    more = kalmanq(*common, "--runs", 6, "--workers", 2, "--out", tmp_path / "two.csv")
    assert (tmp_path / "two.csv").read_bytes() == out.read_bytes() and f"60 rows, {arithmetic}, compiled" in more.stdout


def test_a_campaign_says_what_it_leaves_out(tmp_path):
    out = tmp_path / "runs.csv"
    done = succeeds("simulate", GAUGES, "-n", 20, "--runs", 3, "--compiled", "--smooth", "--workers", 1, "--out", out)
    assert "left out: --smooth; the emitted filter looks at no later row" in done.stdout
    assert not any("smoothed" in name for name in rows_of(out)[0])


def test_compiled_goes_with_runs(tmp_path):
    refused(kalmanq("simulate", CART, "--compiled", "-n", 5), "--compiled: goes with --runs", tmp_path)


def test_a_journal_of_the_librarys_filter_is_not_gone_on_with(tmp_path):
    out = tmp_path / "made.csv"
    command = ("simulate", GAUGES, "-n", 20, "--runs", 3, "--workers", 1, "--out", out)
    model, of = model_file.read(GAUGES), hashlib.sha256(GAUGES.read_bytes()).hexdigest()
    common = {"study": "simulate", "model": of, "rows": 20, "seed": 1, "arithmetic": "f64", "smooth": False, "gap": None}
    study = Study(model, 20, 1, "f64", False, None)
    list(run_campaign(partial(one_run, study), range(2), fingerprint=common, journal=journal_of(out), workers=1))
    refused(kalmanq(*command, "--compiled"), "is of another campaign (compiled None, not True)", tmp_path)
    assert kalmanq(*command).returncode == 0 and not journal_of(out).exists()


@pytest.mark.parametrize("options", [(), ("--method", "iterated", "--iterate", 3)])
def test_smoothed_nonlinear(tmp_path, options):
    """The C's smoother beside the host's"""
    out, common = tmp_path / "out.csv", ("run", EXAMPLES / "range_bearing.py", EXAMPLES / "range_bearing.csv", "--arith", "f64", "--smooth")
    columns = []
    for more in (("--compiled",), ()):
        succeeds(*common, *options, *more, "--out", out)
        columns.append(np.genfromtxt(out, delimiter=",", names=True))
    names = [one for one in columns[0].dtype.names if one.endswith(("_mean", "_sigma", "_smoothed", "_smoothed_sigma"))]
    assert len(names) == 4 * 4
    for name in names:
        assert np.allclose(columns[0][name], columns[1][name], 1e-8, 1e-8), name


@pytest.mark.parametrize("seed", range(3))
def test_smoothed_error_states(tmp_path, seed):
    """Closer to the truth than the filter, and errors as large as their sigmas say"""
    path = Path(__file__).parent / "equations" / "attitude.py"
    model = nonlinear.read(path)
    x, z, u = nonlinear.simulate(model, 300, seed)
    with writing(tmp_path / "z.csv", [one.name for one in (*model.measurements, *model.controls)]) as write:
        write([*z.T, *u.T])
    succeeds("run", path, tmp_path / "z.csv", "--arith", "f64", "--smooth", "--out", tmp_path / "out.csv")
    made = np.genfromtxt(tmp_path / "out.csv", delimiter=",", names=True)
    names = model.carried_names
    of = {kind: np.array([model.minus(np.array([row[f"{one}_{kind}"] for one in names]), truth) for row, truth in zip(made, x)])
          for kind in ("mean", "smoothed")}
    sigma = np.stack([made[f"{one}_smoothed_sigma"] for one in model.state_names], axis=1)
    square = {kind: np.mean(one[:200] ** 2, axis=0) for kind, one in of.items()}
    assert np.all(square["smoothed"][:3] < square["mean"][:3])
    assert 0.3 < np.mean((of["smoothed"] / sigma) ** 2) < 2.5
    done = kalmanq("run", path, tmp_path / "z.csv", "--smooth", "--passes", 2)
    assert done.returncode == 1 and done.stderr == "kalmanq: --compiled and --passes: the C smooths once\n"


def test_a_history_has_an_end(tmp_path):
    """Of 32767 steps; and one row is its own smoothed one"""
    path, data = EXAMPLES / "range_bearing.py", tmp_path / "z.csv"
    for rows, said in ((1, ""), (32768, "--smooth: 32768 rows; the C's history holds 32767: without --compiled there is no limit")):
        data.write_text("range,bearing\n" + "150,3\n" * rows)
        done = kalmanq("run", path, data, "--smooth", "--compiled", "--arith", "f64", "--out", tmp_path / "out.csv")
        assert said in done.stderr and done.returncode == bool(said), done.stderr
    made = np.genfromtxt(tmp_path / "out.csv", delimiter=",", names=True)  # of the one row: nothing else was written
    assert made["east_smoothed"] == made["east_mean"]
