"""Rows at their times and noises that are functions: beside an extended filter and smoother in NumPy, in C, and as a user has them."""

from __future__ import annotations

import json
import runpy
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from command import json_of, kalmanq, refused, succeeds
from library import passes, saved
from models import updated
from whole import first

from kalmanq import KalmanqError
from kalmanq.compiler.run.equation_run import CompiledEquations
from kalmanq.compiler.run.building import compiler
from kalmanq.fitting.equations import Equations, likelihood_of
from kalmanq.fitting.expectation import Records
from kalmanq.nonlinear import NonlinearFilter, NonlinearModel, NonlinearSmoother, read, simulate
from kalmanq.nonlinear.objective import objective

ROWS, SEEDS = 120, (1, 2, 3)
TIMED = Path(__file__).parent / "equations" / "timed"
NAMES = ("vehicle", "radar", "battery")


@pytest.fixture(params=NAMES)
def made(request) -> SimpleNamespace:
    path = TIMED / f"{request.param}.py"
    return SimpleNamespace(name=request.param, model=read(path), space=runpy.run_path(str(path)))


def drawn(model: NonlinearModel, seed: int, rows: int = ROWS) -> SimpleNamespace:
    """Exponential intervals, some of the measurements missing; of a model that takes no dt no times"""
    random = np.random.default_rng(seed)
    times = np.cumsum([0, *random.exponential(0.8, rows - 1)]) if model.takes_step else None
    x, z, u = simulate(model, rows, seed, times=times)
    z[random.random(z.shape) < 0.1] = np.nan
    return SimpleNamespace(x=x, z=z, u=u if model.l else None, times=times)


def by_hand(name: str, of: dict[str, Any], data: SimpleNamespace) -> SimpleNamespace:
    """The textbook's extended filter and Rauch-Tung-Striebel smoother, with A(dt), Q(dt) and R(x)"""
    x, P = np.array(of["x0"], float), np.diag(of["P0"]).astype(float)
    made: dict[str, list] = {key: [] for key in ("mean", "covariance", "predicted", "ahead", "A", "log_likelihood")}
    for k, z in enumerate(data.z):
        u = None if data.u is None else data.u[k]
        if k:
            before, t = (None if data.u is None else data.u[k - 1]), float(k - 1)
            dt = None if data.times is None else data.times[k] - data.times[k - 1]
            if name == "vehicle":
                A, Q, x = np.array(of["A"](x, before, dt)), of["Q"](x, t, before, dt), np.array(of["f"](x, before, dt))
            elif name == "radar":
                G = of["G"](x, t, None, dt)
                A, Q, x = of["A"](x, dt), G @ G.T, x + of["increment"](x, dt)
            else:
                A, Q, x = np.array(of["A"](x)), np.diag(of["Q"](x, t, before)), x + of["increment"](x, t, before)
            P = A @ P @ A.T + Q
            made["A"].append(A), made["predicted"].append(x), made["ahead"].append(P)
        likelihood = 0.0
        for first, h, H, R in sensors_by_hand(name, of, float(k), u):
            e = np.atleast_1d(z[first:first + len(np.atleast_1d(h(x)))] - h(x))
            e[1:] = (e[1:] + np.pi) % (2 * np.pi) - np.pi if name == "radar" else e[1:]
            x, P, term = updated(x, P, e, np.atleast_2d(H(x)), np.diag(np.atleast_1d(R(x))))
            likelihood += term
        made["mean"].append(x), made["covariance"].append(P), made["log_likelihood"].append(likelihood)
    return SimpleNamespace(**{key: np.array(one) for key, one in made.items()})


def sensors_by_hand(name: str, of: dict[str, Any], t: float, u: Any) -> list[tuple]:
    if name == "vehicle":
        return [(0, lambda x: np.array(of["h"](x)), of["H"], lambda x: of["R"])]
    if name == "radar":
        return [(0, lambda x: np.array(of["h_radar"](x)), of["H_radar"], of["R_radar"]),
                (2, lambda x: x[:1], lambda x: np.eye(1, 4), lambda x: 9.0)]
    return [(0, lambda x: of["h"](x, t, u), of["H"], lambda x: of["R"](x, t, u))]


def smoothed_by_hand(of: SimpleNamespace) -> np.ndarray:
    made = [of.mean[-1]]
    for k in range(len(of.mean) - 2, -1, -1):
        C = of.covariance[k] @ of.A[k].T @ np.linalg.inv(of.ahead[k])
        made.append(of.mean[k] + C @ (made[-1] - of.predicted[k]))
    return np.array(made[::-1])


def apart(run, by: SimpleNamespace) -> float:
    """Of means in sigma, of covariances in sigma_i sigma_j, of the log-likelihood of a row"""
    sigma = np.sqrt(np.einsum("tii->ti", by.covariance))
    return max(np.abs((run.mean - by.mean) / sigma).max(), np.abs(run.log_likelihood - by.log_likelihood).max(),
               np.abs((run.covariance - by.covariance) / (sigma[:, :, None] * sigma[:, None])).max())


@pytest.mark.parametrize("seed", first(1, SEEDS))
def test_the_filter_and_smoother_are_those_of_the_textbook(made, seed):
    data = drawn(made.model, seed)
    by = by_hand(made.name, made.space, data)
    given = {"times": data.times, "covariance": True}
    run = NonlinearFilter(made.model).run(data.z, data.u, **given)
    assert apart(run, by) < 1e-10
    assert apart(NonlinearFilter(made.model.without_jacobians()).run(data.z, data.u, **given), by) < 1e-10
    smoothed = NonlinearSmoother(made.model).run(data.z, data.u, **given).smoothed
    sigma = np.sqrt(np.einsum("tii->ti", by.covariance))
    assert np.abs((smoothed - smoothed_by_hand(by)) / sigma).max() < 1e-8  # the inverse of P+ in NumPy
    by_f32 = NonlinearFilter(made.model, "f32").run(data.z, data.u, **given)
    by_q31 = NonlinearFilter(made.model, "q31").run(data.z, data.u, **given)
    assert apart(by_f32, by) < 2e-3 and np.abs((by_q31.mean - by.mean) / sigma).max() < 0.02


def test_row_by_row_and_in_blocks_are_as_at_once(made):
    data = drawn(made.model, 4)
    whole = NonlinearFilter(made.model).run(data.z, data.u, times=data.times)
    rows, blocks = NonlinearFilter(made.model), NonlinearFilter(made.model)
    for k in range(ROWS):
        u = None if data.u is None else data.u[k]
        rows.update(data.z[k], u)
        assert np.allclose(rows.mean, whole.mean[k], 1e-12, 1e-12)
        rows.predict(u, None if data.times is None or k + 1 == ROWS else data.times[k + 1] - data.times[k])
    for some in (slice(0, 50), slice(50, 51), slice(51, ROWS)):
        run = blocks.run(data.z[some], *(None if one is None else one[some] for one in (data.u,)),
                         times=None if data.times is None else data.times[some])
        assert np.array_equal(run.mean, whole.mean[some])


def test_passes_keep_the_noises_of_the_first_and_settle(made):
    """At the smoothed states the objective with these noises is flat"""
    data = drawn(made.model, 5)
    smoother = NonlinearSmoother(made.model, passes=20)
    run = smoother.run(data.z, data.u, times=data.times)
    assert smoother.is_settled
    u = np.zeros((ROWS, 0)) if data.u is None else data.u

    def value(states: np.ndarray) -> float:
        return objective(made.model, states, data.z, u, made.model.instants(ROWS, data.times), smoother._noises)

    least = value(run.smoothed)
    direction = np.random.default_rng(1).standard_normal(run.smoothed.shape) * run.smoothed_sigma
    assert least <= smoother.objectives[0] + 1e-9 and all(value(run.smoothed + a * direction) > least for a in (-0.3, 0.3))


FORMS = ("def f(x, u, dt): return x + u[0] * dt", "def f(x, t, u, dt): return x + u[0] * dt", "def f(x, dt, u): return x + u[0] * dt",
         "def f(state, time, control, dt): return state + control[0] * dt",
         "def f(x, t, u, dt, gains=[1.0, 2.0]): return x + u[0] * dt * gains[0]")
WALK = """
controls, measurements, states, dt = ["v"], ["z"], ["x"], 0.25
x0, P0, R = 0, 1, 1
{}
def Q(x, dt): return dt
def h(x, t): return x + {}
"""


@pytest.mark.parametrize("form", FORMS)
def test_arguments_are_taken_by_their_names(form, tmp_path):
    (tmp_path / "walk.py").write_text(WALK.format(form, "0 * t"))
    model = read(tmp_path / "walk.py")
    z, u = np.random.default_rng(1).standard_normal((2, 40, 1))
    run = NonlinearFilter(model).run(z, u)
    x, P = 0.0, 1.0
    for k in range(40):
        x, P = (x + 0.25 * u[k - 1, 0], P + 0.25) if k else (x, P)
        x, P = x + P / (P + 1) * (z[k, 0] - x), P / (P + 1)
        assert abs(run.mean[k, 0] - x) < 1e-12
    assert model.formulas.change[0].op != "constant"


def test_t_is_seconds_where_rows_have_times_or_a_step(tmp_path):
    (tmp_path / "walk.py").write_text(WALK.format(FORMS[0], "t"))
    for times, at in ((None, 0.25 * np.arange(5)), (np.array([0, 0.3, 1, 5, 5.5]),) * 2):
        run = NonlinearFilter(read(tmp_path / "walk.py")).run(np.zeros((5, 1)), np.zeros((5, 1)), times=times)
        assert np.allclose(run.mean[0] + run.innovation[0], [0]) and np.allclose(
            run.innovation[1:, 0], -at[1:] - run.mean[:-1, 0])


def csv_of(folder: Path, times: np.ndarray, z: np.ndarray, name: str = "t [ms]") -> Path:
    path = saved(folder / "data.csv", "\n".join([f"{name},z", *(f"{1000 * t:.17g},{v:.17g}" for t, v in zip(times, z))]) + "\n")
    return path


FIXED = """
states, measurements, x0, P0, R = ["x", "v"], ["z"], [0, 0], [1, 1], 0.01
def f(x): return [x[0] + x[1], x[1]]
Q = [[1/3, 1/2], [1/2, 1]]
def h(x): return x[0]
"""
AT_TIMES = FIXED.replace("f(x)", "f(x, dt)").replace("+ x[1],", "+ x[1] * dt,").replace(
    "Q = [[1/3, 1/2], [1/2, 1]]", "def Q(x, t, u, dt): return [[dt**3/3, dt**2/2], [dt**2/2, dt]]")


TWO_SENSORS = AT_TIMES.replace('["z"]', '["a", "b"]').replace(", R =", " =").replace(", 0.01", "") + """
def R(x): return 1 + x[0]**2
sensors = {"one": (h, R), "two": (lambda x: x[1], 0.5)}
del h, R
"""
SPRING = """
import numpy as np
states, measurements, dt = ["angle", "rate"], ["z"], 0.2
omega, damping, q, r = {}
free = ["omega", "damping", "q", "r"]
x0, P0 = [1, 0], [1, 1]
def increment(x, dt):
    push = omega**2 * np.tanh(x[0])
    return [dt * x[1] - dt**2 / 2 * push, -dt * (push + damping * x[1])]
def Q(x, t, u, dt): return [[q * dt**3 / 3, q * dt**2 / 2], [q * dt**2 / 2, q * dt]]
def R(x): return r * (1 + 0.2 * np.tanh(x[0])**2)
def h(x): return x[0]
"""


@pytest.mark.parametrize("seed", first(1, SEEDS))
def test_a_column_of_times_makes_the_nis_right(seed, tmp_path):
    """Exponential intervals of 1 s on average: of steps that are all alike the NIS is far off"""
    (tmp_path / "right.py").write_text(AT_TIMES), (tmp_path / "fixed.py").write_text(FIXED)
    times = np.cumsum(np.random.default_rng(seed).exponential(1.0, 1000))
    z = simulate(read(tmp_path / "right.py"), 1000, seed, times=times)[1][:, 0]
    data = csv_of(tmp_path, times, z)
    made = {}
    for name in ("right", "fixed"):
        done = kalmanq("run", tmp_path / f"{name}.py", data, "--digits", 17, "--out", tmp_path / f"{name}.csv")
        assert done.returncode == 0 and ("are irregular" in done.stderr) == (name == "fixed"), done
        if name == "fixed":  # a default is the file's own: the rows are steps as before
            (tmp_path / "fixed.py").write_text(FIXED.replace("f(x)", "f(x, t, u, dt=1.0)"))
            assert done.stdout.startswith(kalmanq("run", tmp_path / "fixed.py", data).stdout)
        made[name] = float(done.stdout.split("NIS ")[1].split()[0])
    assert abs(made["right"] - 1) < 4 * np.sqrt(2 / 1000) < 1 < abs(made["fixed"] - 1)
    told = np.genfromtxt(tmp_path / "right.csv", delimiter=",", names=True)
    assert np.allclose(told["time"], times - times[0]) and np.allclose(
        told["x_mean"], NonlinearFilter(read(tmp_path / "right.py")).run(z, times=times - times[0]).mean[:, 0], 1e-9, 1e-9)


OF_FILE = {  # a change of AT_TIMES
    "line 5: h: takes dt, which is of a step: f, increment, A, Q and G may take it": ("h(x)", "h(x, dt)"),
    "line 3: f: dt has a default, and another function takes dt: leave the default out": ("f(x, dt)", "f(x, dt=1.0)"),
    "line 3: f: its arguments are x, t, u, or fewer of the last ones, and dt by its name": ("f(x, dt)", "f(x, t, u, v, dt)"),
    "line 4: Q: is not symmetric, at x = (": ("[dt**2/2, dt]]", "[dt, dt]]"),
    "line 4: Q: has a negative variance: Q[1,1] = -1, at x = (": ("dt**2/2, dt]]", "dt**2/2, -dt]]"),
    "line 4: Q: is no covariance: it is not positive semidefinite, at x = (": ("dt**3/3", "dt**3/5"),
    "line 4: Q: is 1 x 3, not 2 x 2, nor 2 variances, at x = (": ("[[dt**3/3, dt**2/2], [dt**2/2, dt]]", "[[1, dt, 1]]"),
    "line 4: Q: has an entry that is not finite: Q[1,1] is inf, at x = (": ("[dt**2/2, dt]]", "[dt**2/2, float('inf')]]"),
    "line 4: Q: ZeroDivisionError": ("return [[", "return [[1 / (dt - dt) + "),
    "line 4: dt: is not a number above 0": ("def Q(x", "dt = 'now'\ndef Q(x"),
    "line 5: R: is 1 x 2, not 1 x 1, nor 1 variance": ("def h", "R = lambda x: [[1, 2]]\ndef h"),
}
OF_DATA = {  # times in ms; what is said
    "0,20,10,30": "data.csv: row 4, column t [ms]: the time goes back, from 20 to 10: --sort sorts the rows",
    "0,20,,30": "data.csv: row 4, column t [ms]: the time is missing",
}


@pytest.mark.parametrize("said", OF_FILE)
def test_a_bad_file_is_refused_in_one_line(said, tmp_path):
    data = csv_of(tmp_path, np.arange(5.0), np.zeros(5))
    (tmp_path / "m.py").write_text(AT_TIMES.replace(*OF_FILE[said]))
    refused(kalmanq("run", tmp_path / "m.py", data, "--out", tmp_path / "out.csv"), f"m.py: {said}", tmp_path)


@pytest.mark.parametrize("times", OF_DATA)
def test_bad_times_are_refused_in_one_line(times, tmp_path):
    data = saved(tmp_path / "data.csv", "t [ms],z\n" + "".join(f"{one},0\n" for one in times.split(",")))
    (tmp_path / "m.py").write_text(AT_TIMES)
    for command in (["run", "--out", tmp_path / "out.csv"], ["compare"], ["check"], ["report", "-o", tmp_path / "out.html"]):
        refused(kalmanq(command[0], tmp_path / "m.py", data, *command[1:]), OF_DATA[times], tmp_path)
    if OF_DATA[times].endswith("--sort sorts the rows"):
        succeeds("run", tmp_path / "m.py", data, "--sort")


def test_what_has_no_step_or_no_times_is_refused_in_one_line(tmp_path):
    (tmp_path / "m.py").write_text(AT_TIMES)
    (tmp_path / "no_times.csv").write_text("z\n0\n1\n")
    needs = "takes dt, but the rows have no times, and the model has no dt = ... (seconds from row to row)"
    data = csv_of(tmp_path, np.arange(4.0), np.zeros(4))
    for said, given in ((f"no_times.csv: row 3: {tmp_path}/m.py: line 4: Q: {needs}", ["run", "no_times.csv"]), (f"m.py: line 4: Q: {needs}", ["simulate", "-n", 5]),
                        ("m.py: line 4: Q: is a function, so Q cannot be free", ["fit", "data.csv"]),
                        ("data.csv: column z is in", ["run", "data.csv", "data.csv"])):
        command, *more = given
        refused(kalmanq(command, tmp_path / "m.py", *(tmp_path / one if str(one).endswith("csv") else one for one in more)), said, tmp_path)
    model = read(tmp_path / "m.py")
    for said, do in (("^dt .*times", lambda f: (f.predict(dt=1.0), f.predict())),
                     ("row 0: .*before", lambda f: (f.run([0, 0], times=[0, 1]), f.run([0], times=[0.9]))),
                     ("^times .*missing", lambda f: (f.run([0, 0], times=[0, 1]), f.run([0]))),
                     ("^dt: .*duration", lambda f: f.predict(dt=0))):
        with pytest.raises(KalmanqError, match=said):
            do(NonlinearFilter(model))
    (tmp_path / "m.py").write_text(FIXED)
    refused(kalmanq("run", tmp_path / "m.py", data, data), "data.csv: several files are joined by their times: of a linear model", tmp_path)


@pytest.mark.parametrize("seed", first(1, SEEDS))
@pytest.mark.parametrize("name", (*NAMES, "correlated"))
def test_the_likelihood_of_a_fit_is_the_filters_and_its_slope_that_of_differences(name, seed):
    model = read(TIMED / f"{name}.py")
    equations = Equations(model, ["P0"])
    start = np.zeros(equations.parameters.count)
    equations.parameters.put(start, "P0", model.P0)
    data = drawn(model, seed)
    if name == "correlated":
        data.z[np.isnan(data.z).any(axis=1)] = np.nan
    records, at = Records(model, [data.z], [data.u], data.times is not None and [data.times] or None), model.instants(ROWS, data.times)
    towards = 1e-4 * start * np.random.default_rng(seed).normal(size=start.size)
    value, slope = equations.likelihood.at(at, data.z, records.u[0], start, towards)
    ends = [equations.likelihood.at(at, data.z, records.u[0], start + k * towards, towards)[0] for k in (-1, 1)]
    assert value == pytest.approx(likelihood_of(model, records), rel=1e-12)
    assert slope == pytest.approx((ends[1] - ends[0]) / 2, rel=1e-4)


@pytest.mark.parametrize("seed", first(1, SEEDS))
def test_constants_of_steps_and_noises_are_fitted_from_rows_at_their_times(tmp_path, seed):
    """A spring that softens; what is written begins at the maximum"""
    path, began, truth = tmp_path / "spring.py", "2.0, 0.05, 0.1, 0.1", (1.4, 0.2, 0.3, 0.04)
    path.write_text(SPRING.format(", ".join(map(str, truth))))
    model = read(path)
    path.write_text(SPRING.format(began))
    times = np.round(np.cumsum(np.random.default_rng(seed).uniform(0.1, 0.3, 1500)), 6)
    _, z, _ = simulate(model, len(times), seed, times=times)
    data = csv_of(tmp_path, times, z[:, 0])
    done = kalmanq("fit", path, data, "--out", tmp_path / "fitted.py", "--json")
    found = json.loads(done.stdout)
    assert found["converged"], found
    for label, true in zip(("omega", "damping", "q", "r"), truth):
        assert abs(np.ravel(found[label])[0] - true) < 3.5 * np.ravel(found["standard_errors"][label])[0]
    again = json_of("fit", tmp_path / "fitted.py", data)
    assert again["log_likelihood"] == pytest.approx(found["log_likelihood"], rel=1e-9)


def test_files_of_two_sensors_are_joined_by_their_times(tmp_path):
    both = np.round(np.cumsum(np.random.default_rng(1).exponential(0.5, 60)), 6)
    z = np.random.default_rng(2).normal(size=(60, 2)).round(6)
    (tmp_path / "m.py").write_text(TWO_SENSORS)
    for name, kept in (("a", np.arange(60) % 3 != 1), ("b", np.arange(60) % 2 == 0)):
        k = "ab".index(name)
        (tmp_path / f"{name}.csv").write_text(f"t [s],{name}\n" + "".join(f"{t},{v[k]}\n" for t, v in zip(both[kept], z[kept])))
        z[~kept, k] = np.nan
    there = ~np.isnan(z).all(axis=1)
    (tmp_path / "both.csv").write_text("t [s],a,b\n" + "".join(
        f"{t},{','.join('' if np.isnan(one) else str(one) for one in v)}\n" for t, v in zip(both[there], z[there])))
    for out, files in (("joined", ("a.csv", "b.csv")), ("one", ("both.csv",))):
        succeeds("run", tmp_path / "m.py", *(tmp_path / one for one in files), "--out", tmp_path / f"{out}_out.csv")
    assert (tmp_path / "joined_out.csv").read_text() == (tmp_path / "one_out.csv").read_text()


@pytest.mark.parametrize("seed", first(1, SEEDS))
@pytest.mark.parametrize("name", (*NAMES, "correlated"))
def test_the_c_is_the_host(name, seed):
    """Without measurements missing in part, as correlated ones are taken together"""
    model = read(TIMED / f"{name}.py")
    data = drawn(model, seed)
    data.z[np.isnan(data.z).any(axis=1)] = np.nan
    wanted = NonlinearSmoother(model, "f64").run(data.z, data.u, times=data.times, covariance=True)
    with CompiledEquations(model, "f64", smooths=ROWS) as c:
        run = c.run(data.z, data.u, data.times)
    assert np.abs((run.mean - wanted.mean) / wanted.sigma).max() < 1e-10
    assert np.allclose(run.sigma, wanted.sigma, 1e-9, 0)
    assert np.abs((run.smoothed - wanted.smoothed) / wanted.sigma).max() < 1e-9
    assert np.allclose(run.smoothed_sigma, wanted.smoothed_sigma, 1e-7, 0)
    if len(model.sensors) == 1:
        assert np.allclose(run.log_likelihood, wanted.log_likelihood, 1e-8, 1e-8)
    with CompiledEquations(model, "f32") as c:
        parts = [c.run(data.z[some], None if data.u is None else data.u[some], None if data.times is None else data.times[some])
                 for some in (slice(0, 40), slice(40, ROWS))]
    assert np.abs((np.vstack([one.mean for one in parts]) - wanted.mean) / wanted.sigma).max() < 5e-3


OPTIONS = {"vehicle": [], "radar": ["--smooth", 5, "--loops"], "battery": ["--iterate", 3, "--nis"], "correlated": ["--robust", "student=4"]}
# every day each model and each option once
COMPILED = [*OPTIONS.items(), ("vehicle", ["--arith", "f64", "--robust", "gate=4"]),
            *((name, options) for name in OPTIONS for one, options in OPTIONS.items() if one != name),
            *((name, ["--arith", "f64", "--robust", "gate=4"]) for name in OPTIONS if name != "vehicle")]


@pytest.mark.parametrize("name, options", first(5, COMPILED))
def test_the_c_has_no_warning_and_its_test_says_ok(name, options, tmp_path):
    path, out = TIMED / f"{name}.py", tmp_path / f"{name}.c"
    succeeds("compile", path, "-o", out, *options)
    passes(tmp_path, name, compiler=compiler())
    model = read(path)
    takes = ", const float u[1]" if model.l else ""
    assert f"void {name}_predict({name}_filter *f{takes}{', float dt' if model.takes_step else ''})" in out.with_suffix(".h").read_text() \
        .replace("double", "float")


@pytest.mark.parametrize("seed", (12, 15, 21, 25))
def test_the_c_of_random_noises_is_the_host(seed):
    """Full, and singular but for rounding"""
    r = np.random.default_rng(seed)
    n, m = map(int, r.integers([2, 1], [5, 4]))
    F, H, a, S = 0.3 * r.standard_normal((n, n)), r.standard_normal((m, n)), r.standard_normal(n), np.tril(r.standard_normal((n, n)))
    S[:, -1 if seed % 3 == 0 else n:] = 0
    V = np.eye(m) + np.tril(0.5 * r.standard_normal((m, m)))
    root = lambda x, t: S * (1 + 0.5 * np.sin(a @ x + t))  # noqa: E731
    noise = {"G": lambda x, t, u, dt: root(x, t) * np.sqrt(dt)} if seed % 4 == 1 else \
        {"Q": lambda x, t, u, dt: root(x, t) @ root(x, t).T * dt}
    model = NonlinearModel(lambda x, dt: x + dt * np.tanh(F @ x) - 0.2 * dt * x, lambda x: H @ x + 0.1 * np.sin(x[0]), x0=np.zeros(n),
                           P0=np.ones(n), R=lambda x: V @ V.T * (1 + 0.3 * np.cos(a @ x)), dt=0.5, name="random", **noise)
    data = drawn(model, seed)
    data.z[np.isnan(data.z).any(axis=1)] = np.nan
    wanted = NonlinearSmoother(model).run(data.z, times=data.times, covariance=True)
    with CompiledEquations(model, "f64", smooths=ROWS) as c:
        run = c.run(data.z, None, data.times)
    assert not run.event_names and np.abs((run.mean - wanted.mean) / wanted.sigma).max() < 1e-9
    assert np.abs((run.smoothed - wanted.smoothed) / wanted.sigma).max() < 1e-7
    assert np.allclose(run.log_likelihood, wanted.log_likelihood, 1e-7, 1e-7)


def test_the_c_refuses_a_noise_that_is_none(tmp_path):
    """Mean and covariance stay as they were, and an event says so; the host refuses the row"""
    (tmp_path / "m.py").write_text(AT_TIMES.replace("[dt**2/2, dt]]", "[dt**2/2, dt]] if x[0] < 1 else [[-1, 0], [0, 1]]").replace(
        "[1, 1], 0.01", "[1, 1], lambda x: 0.01 if x[0] < 2 else -1"))
    model = read(tmp_path / "m.py")
    z, times = np.array([0, 5.0, 5.0, 5.0]), np.array([0.0, 0.5, 1, 2])
    with CompiledEquations(model, "f32") as c:
        run = c.run(z, None, times)
    assert "not finite" in run.event_names and np.array_equal(run.mean[2:], run.mean[[1, 1]]) and run.taken[2] == 0
    with pytest.raises(KalmanqError, match="row 2: .*Q: .*negative"):
        NonlinearFilter(model).run(z, times=times)


def test_what_is_not_compiled_is_refused_in_one_line(tmp_path):
    (tmp_path / "m.py").write_text(AT_TIMES)
    data, out = csv_of(tmp_path, np.arange(4.0), np.zeros(4)), ("-o", tmp_path / "out.c")
    needs = "m.py: line 3: f: takes dt, but the rows have no times, and the model has no dt"
    q31 = "m.py: line 4: Q: is a function, and q31 has arrays of noises: give an array, or take f32 or f64"
    (tmp_path / "t.py").write_text(FIXED.replace("h(x): return", "h(x, t): return 0 * t +").replace("[1, 1], 0.01", "[1, 1], 0.01\nstates, "
                                   "measurements = [{'names': ['x', 'v'], 'ranges': [9, 9]}, {'names': ['z'], 'ranges': [9]}]"
                                   ).replace("0 * t", "t"))
    steps = AT_TIMES.replace("def Q(x, t, u, dt): return [[dt**3/3, dt**2/2], [dt**2/2, dt]]", "Q, dt = [1, 1], 1.0")
    for text, said, given in ((AT_TIMES, needs, ["compile", *out]), (AT_TIMES, needs, ["compile", *out, "--library"]),
                              (AT_TIMES, q31, ["compile", *out, "--library", "--arith", "q31"]),
                              (AT_TIMES, q31, ["run", data, "--compiled", "--arith", "q31"]),
                              (steps, "m.py: line 3: f: takes dt, and in q31 the rows are steps that are all alike",
                               ["compile", *out, "--library", "--arith", "q31"])):
        (tmp_path / "m.py").write_text(text)
        refused(kalmanq(given[0], tmp_path / "m.py", *given[1:]), said, tmp_path)
    refused(kalmanq("run", tmp_path / "t.py", data, "--compiled", "--arith", "q31"), "--time none takes rows so", tmp_path)


def test_commands_take_the_times(tmp_path):
    """run --compiled, report and compare see what run sees; simulate --at draws at them"""
    path, at, data = TIMED / "vehicle.py", tmp_path / "at.csv", tmp_path / "data.csv"
    at.write_text("time [s]\n" + "".join(f"{t}\n" for t in np.cumsum([0, *np.random.default_rng(1).exponential(0.8, 99)])))
    succeeds("simulate", path, "--at", at, "--truth", "--out", data)
    said = {}
    for name, given in (("host", ()), ("c", ("--compiled",))):
        done = kalmanq("run", path, data, "--smooth", *given, "--out", tmp_path / f"{name}.csv", "--digits", 17, "--plot", tmp_path / "p.png")
        assert done.returncode == 0 and not done.stderr, done.stderr
        said[name] = np.genfromtxt(tmp_path / f"{name}.csv", delimiter=",", names=True)
    assert all(np.allclose(said["host"][one], said["c"][one], 1e-8, 1e-8) for one in said["host"].dtype.names)
    assert np.allclose(said["c"]["time"], np.genfromtxt(at, skip_header=1))
    for given in (["compare", path, data, "--compiled"], ["report", path, data, "-o", tmp_path / "r.html", "--compiled"],
                  ["check", path, data], ["simulate", path, "--at", at, "--runs", 2, "--out", tmp_path / "runs.csv", "--workers", 1],
                  ["simulate", path, "--at", at, "--runs", 2, "--out", tmp_path / "runs2.csv", "--workers", 1, "--compiled"]):
        done = kalmanq(*given)
        assert done.returncode == 0 and not done.stderr, (given, done.stderr)
    runs = [np.genfromtxt(tmp_path / f"{name}.csv", delimiter=",", names=True)["nis"] for name in ("runs", "runs2")]
    assert np.allclose(*runs, 1e-6)
