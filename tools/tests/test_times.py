"""Rows at times of their own: beside the joint normal of all rows in long double, of steps by SciPy in double."""

from __future__ import annotations

import re
from datetime import datetime, timezone
from pathlib import Path

import numpy as np
import pytest
from command import json_of, kalmanq, refused, succeeds
from dense import LONG, Steps, conditioned
from library import saved
from scipy.linalg import expm
from scipy.optimize import minimize
from scipy.stats import chi2

from kalmanq import (
    Filter, FrozenGainFilter, InstantSmoother, KalmanqError, LagSmoother, Model, Quantity, Smoother, Varying, fit, likelihood)
from kalmanq.fitting.choice import Choice
from kalmanq.fitting.expectation import Records
from kalmanq.fitting.problem import Problem
from kalmanq.model import model_file
from kalmanq.pages import pictures
from kalmanq.run.simulation import simulate
from whole import first

ROWS = 40


def exact_steps(model: Model, dt: np.ndarray) -> Steps:
    """Van Loan's matrices by SciPy's exponential"""
    of, n, rows = model.continuous, model.n, dt[:, None, None]
    e = expm(np.block([[-of.F, of.Qc], [np.zeros((n, n)), of.F.T]]) * rows)
    pushed = expm(np.block([[of.F, of.B], [np.zeros((model.l, n + model.l))]]) * rows)
    A = e[:, n:, n:].swapaxes(1, 2)
    return Steps(A, pushed[:, :n, n:], A @ e[:, :n, n:], *(np.tile(one, (len(dt), 1, 1)) for one in (model.H, model.R)))


def random_record(seed: int, rounded: bool = False):
    """A model in continuous time of n = 1 to 5, some of it integrated, and a record at irregular times"""
    draw = np.random.default_rng(seed)
    n, m, l = 1 + seed % 5, 1 + seed % 2, 1 + seed % 2
    turn = draw.normal(size=(n, n))
    F = turn - turn.T - np.diag(draw.uniform(0.1, 1, n))
    if seed % 3 == 0:
        F = np.diag(np.ones(n - 1), 1) - np.diag(draw.uniform(0.4, 1, n))
    G, N = draw.normal(size=(n, n)) / np.sqrt(n), 0.3 * draw.normal(size=(m, m))
    made = [F, draw.normal(size=(m, n)), N @ N.T + 0.1 * np.eye(m), G @ G.T + 0.01 * np.eye(n), draw.normal(size=(n, l))]
    times = np.cumsum(draw.exponential(0.3, ROWS) + 1e-3)
    u = draw.normal(size=(ROWS, l))
    if rounded:
        made = [np.float32(one).astype(float) for one in made]
        u = np.float32(u).astype(float)
    F, H, R, Qc, B = made
    names = [[Quantity(f"{letter}{k}", "", span) for k in range(size)] for letter, size, span in
             (("x", n, 400), ("z", m, 1600), ("u", l, 20))]
    model = Model.of_continuous(F, H=H, R=R, Qc=Qc, dt=0.3, B=B, P0=np.full(n, 2.0), states=names[0], measurements=names[1],
                                controls=names[2])
    x, z = draw.normal(0, 1.4, n), np.empty((ROWS, m))
    for t in range(ROWS):
        z[t] = H @ x + np.linalg.cholesky(R) @ draw.normal(size=m)
        if t < ROWS - 1:
            A, Q, b = model.continuous.step(times[t + 1] - times[t])
            x = A @ x + b @ u[t] + np.linalg.cholesky(Q + 1e-15 * np.eye(n)) @ draw.normal(size=n)
    z[draw.random(z.shape) < 0.15] = np.nan
    return model, times, np.float32(z).astype(float) if rounded else z, u


def errors(mean, sigma, of_mean, of_covariance) -> float:
    exact = np.sqrt(np.diagonal(of_covariance, axis1=1, axis2=2))
    return float(max(np.abs((mean - of_mean) / exact).max(), np.abs(sigma / exact - 1).max()))


@pytest.mark.parametrize("arithmetic, most", [("f64", 1e-10), ("f32", 1e-5), ("q31", 1e-5)])
@pytest.mark.parametrize("seed", range(20))
def test_irregular_times_beside_the_joint_normal(seed, arithmetic, most):
    model, times, z, u = random_record(seed, arithmetic == "f32")
    right = conditioned(model.x0, model.P0, exact_steps(model, np.append(np.diff(times), 1)), z, u)
    run = Smoother(model, arithmetic).run(z, u, times=times)
    assert errors(run.mean, run.sigma, right.mean, right.covariance) < most
    assert errors(run.smoothed, run.smoothed_sigma, right.smoothed, right.smoothed_covariance) < most
    assert abs(run.log_likelihood.sum() - right.log_likelihood) < most * (1 + abs(right.log_likelihood))
    if arithmetic == "f64":
        assert likelihood(model, [z], [u], times=[times]) == pytest.approx(float(right.log_likelihood), rel=1e-12)


# ------------------------------------------------------------------------------ dates, weeks and a page

WEEKS = """
[model]
builder = "trend_harmonic"
{unit}dt = {dt!r}
period = {period!r}
harmonics = 1
density = {density}
noise = 4.0
variance = [100.0, {slope!r}, 9.0, 9.0]
"""


def test_a_model_in_weeks_is_the_one_in_seconds(tmp_path):
    """Dates two weeks apart now and then: rows, results, and what is simulated at them"""
    week = 604800.0
    weeks, seconds, log = (tmp_path / name for name in ("weeks.toml", "seconds.toml", "log.csv"))
    weeks.write_text(WEEKS.format(unit='time_unit = "week"\n', dt=1.0, period=52.0, density=[0.1, 1e-4, 1e-3], slope=1.0))
    seconds.write_text(WEEKS.format(unit="", dt=week, period=52.0 * week, density=[0.1 / week, 1e-4 / week**3, 1e-3 / week],
                                    slope=1.0 / week**2))
    dates = np.datetime64("2024-01-01") + 7 * np.array([0, 1, 2, 4, 5, 6, 9, 10])
    log.write_text("date,z1\n" + "".join(f"{date},{10 + k * k}\n" for k, date in enumerate(dates)))
    a, b = (json_of("run", model, log, "--smooth") for model in (weeks, seconds))
    assert a["log_likelihood"] == pytest.approx(b["log_likelihood"], rel=1e-9) and a["mean"][0] == pytest.approx(b["mean"][0], rel=1e-9)
    assert model_file.read(weeks).continuous.unit == "week"
    copy = saved(tmp_path / "copy.toml", model_file.text_of(model_file.read(weeks)))
    assert 'time_unit = "week"' in copy.read_text() and np.array_equal(model_file.read(copy).Q, model_file.read(weeks).Q)
    out = tmp_path / "out.csv"
    succeeds("simulate", weeks, "--at", log, "--seed", "1", "--out", out)
    assert out.read_text().splitlines()[0] == "step,time [week],z1" and out.read_text().splitlines()[4].startswith("3,4,")
    again = json_of("run", weeks, out)
    assert again["rows"] == 8 and again["taken"] == 8
    weeks.write_text(weeks.read_text().replace('"week"', '"fortnight"'))
    refused(kalmanq("run", weeks, log), "line 4: time_unit: is not one of ms, s, min, h, day, week, year")


def test_the_page_s_log_with_time_stamps(tmp_path):
    """Its model is the example's, NIS is what it says, and the C that is written moves by dt"""
    folder = Path(model_file.__file__).parents[1]
    example, page = (folder / "examples" / "co2.toml").read_text(), (Path(__file__).parents[2] / "tools/docs/guides/data.md").read_text()
    assert example.partition("\n")[2] in page
    told = json_of("run", folder / "examples" / "co2.toml", folder / "examples" / "co2.csv", "--smooth")
    assert told["taken"] == 281 and f"NIS {told['nis_per_measurement']:.3f} a measurement" in page
    done = kalmanq("compile", folder / "examples" / "co2.toml", "--tunable", "-o", tmp_path / "co2.c")
    assert done.returncode == 0 and "int co2_move(co2_filter *f, float dt);" in (tmp_path / "co2.h").read_text()


# ------------------------------------------------------------------------------ fits


def cart(**more) -> Model:
    return Model.of_continuous(**{**dict(F=[[0, 1], [0, -0.2]], H=[1, 0], R=0.05, Qc=[0, 0.5], dt=0.2, P0=[1, 1]), **more})


def drawn_at_random_times(seed: int, rows: int = 120):
    times = np.cumsum(np.random.default_rng(seed).exponential(0.2, rows) + 1e-3)
    return times, simulate(cart(R=0.2, Qc=[0, 0.1]), rows, seed, times=times)[1]


@pytest.mark.parametrize("seed", first(1, range(3)))
def test_a_fit_is_the_top_of_the_dense_likelihood(seed):
    """Estimates and standard errors beside the joint normal in long double, by Newton"""
    times, z = drawn_at_random_times(seed)
    found = fit(cart(), [z], ("Q", "R"), times=[times], Q_form="multiple", R_form="multiple")
    assert found.converged, found.message
    steps = exact_steps(cart(B=[[0.0], [0.0]]), np.append(np.diff(times), 1))

    def value(q, r):  # at multiples of what was found
        scale = found.model.continuous.Qc[1, 1] / 0.5 * LONG(q), found.model.R[0, 0] / 0.05 * LONG(r)
        made = steps._replace(Q=steps.Q * scale[0], R=steps.R * scale[1], B=None)
        return conditioned(np.zeros(2), np.eye(2), made, z).log_likelihood

    h = LONG(1e-4)
    top = value(1, 1)
    assert abs(found.log_likelihood - top) < 1e-9 * abs(top)
    for at, error, entry in (((h, 0), found.standard_errors["Qc"][1, 1], found.model.continuous.Qc[1, 1]),
                             ((0, h), found.standard_errors["R"][0, 0], found.model.R[0, 0])):
        ahead, behind = (value(1 + sign * at[0], 1 + sign * at[1]) for sign in (1, -1))
        slope, curve = (ahead - behind) / (2 * h), (ahead + behind - 2 * top) / h**2
        assert curve < 0 and slope**2 / -curve < 2e-6  # twice what is left of the log-likelihood
        assert error / entry >= 0.999 / np.sqrt(float(-curve))  # beside others that are known better than they are
    assert np.isnan(found.standard_errors["Qc"][0, 0])


def test_a_fit_of_several_entries_and_records():
    draws = [drawn_at_random_times(seed, 150) for seed in (4, 5)]
    found = fit(cart(Qc=[0.01, 0.5]), [z for _, z in draws], ("Q", "R"), times=[t for t, _ in draws], Q_form="diagonal")
    alone = fit(cart(), [z for _, z in draws], ("Q", "R"), times=[t for t, _ in draws])
    assert alone.converged and abs(alone.model.R[0, 0] / 0.2 - 1) < 0.3 and 0.03 < alone.model.continuous.Qc[1, 1] < 0.3
    assert found.log_likelihood > alone.log_likelihood - 1e-6 and found.model.continuous.dt == 0.2


def test_a_fit_of_steps_of_dt_is_the_one_without_times():
    z = simulate(cart(), 200, 1)[1]
    without, with_times = (fit(cart(), [z], ("Q", "R"), Q_form="multiple", times=times)
                           for times in (None, [0.2 * np.arange(200)]))
    assert without.log_likelihood == with_times.log_likelihood and np.array_equal(without.model.Q, with_times.model.Q)


@pytest.mark.parametrize("unknown", [(), "all", [0]])
@pytest.mark.parametrize("seed", first(2, range(5)))
def test_slopes_at_irregular_times(seed, unknown):
    """Of two records with controls and gaps, beside differences of the likelihood"""
    model, times, z, u = random_record(seed)
    model = model.changed(unknown=unknown)
    records = Records(model, [z, z[:15]], [u, u[:15]], [times, times[:15]])
    choice = Choice(model, ("F", "Qc", "R", *(() if len(unknown) else ("H", "x0", "P0"))), "full", "full", None)
    if len(unknown):  # H is not determined then, and has slopes
        choice.flow.free = (*choice.flow.free, "H")
    e = Problem(model, records, choice).expectation
    e.run()
    for name, slopes in e.gradient().items():
        array = e.arrays[name]
        for at in np.ndindex(array.shape):
            step = np.zeros(array.shape)
            step[at] = step[at[::-1] if name in ("Q", "R", "P0") else at] = 1e-3 * np.abs(array).max() + 1e-4
            wanted = 0.0
            for share, weight in ((1, 2 / 3), (-1, -2 / 3), (2, -1 / 12), (-2, 1 / 12)):
                array += share * step
                e.run()
                wanted += weight * e.log_likelihood
                array -= share * step
            assert abs(np.sum(slopes * step) - wanted) < 3e-7 * (1 + np.abs(slopes).max()) * step.max(), (name, at)


BUILT = {  # a product: file, what is true, what is free
    "temperature": ('builder = "gauss_markov"\ndt = 0.5\ntime_unit = "min"\ntime_constant = [{}]\nsigma = [{}]\nnoise = [{}]', (20, 0.5, 0.04),
                    "time_constant,sigma,noise"),
    "gyro": ('builder = "random_walk"\ndt = 0.1\ndensity = [{}]\nnoise = [{}]\nP0 = "unknown"', (0.01, 0.04), "density,noise"),
    "mast": ('builder = "oscillator"\ndt = 0.1\nperiod = {}\ndamping = {}\ndensity = {}\nnoise = {}\nvariance = [1.0, 1.0]', (1.7, 0.05, 0.5, 0.01),
             "period,damping,Q,R"),
    "process": ('builder = "gaussian_process"\ndt = 0.5\nsmoothness = 1.5\nlength = {}\nsigma = {}\nnoise = {}', (3, 1, 0.05), "length,sigma,R")}


def built(name: str, values, folder: Path) -> Model:
    (folder / "built.toml").write_text("[model]\n" + BUILT[name][0].format(*map(float, values)) + '\n[gaps]\nmax_gap = 40\n')
    return model_file.read(folder / "built.toml")


def built_record(name: str, rows: int, seed: int, folder: Path) -> tuple[np.ndarray, np.ndarray]:
    """Exponential intervals, a pause, and rows without a measurement"""
    truth = built(name, BUILT[name][1], folder)
    times = np.cumsum(np.random.default_rng(seed).exponential(truth.continuous.dt, rows) + 1e-3)
    times[rows // 2:] += 20 * truth.continuous.dt
    z = simulate(truth, rows, seed, times=times)[1]
    z[rows // 6:rows // 6 + 10] = np.nan
    return times, z


@pytest.mark.parametrize("seed", first(1, range(3)))
@pytest.mark.parametrize("name", BUILT)
def test_parameters_of_a_builder_come_back(name, seed, tmp_path):
    """Within three standard errors, together as a chi-square says; the file has the builder again, and the likelihood that was said"""
    (times, z), truth = built_record(name, 600, seed, tmp_path), np.array(BUILT[name][1], float)
    begun = built(name, truth * np.array([1.25, 0.5, 2, 2])[:len(truth)], tmp_path)
    found = fit(begun, [z], BUILT[name][2].split(","), times=[times])
    assert found.converged, found.message
    off = [(value - right) / found.standard_errors[label][0] for (label, value), right in zip(found.model.constants.items(), truth)]
    assert len(off) == len(truth) and np.abs(off).max() < 3, off
    above = 2 * (found.log_likelihood - likelihood(built(name, truth, tmp_path), [z], times=[times]))
    assert above > 0 and chi2.sf(above, len(truth)) > 1e-3
    path = saved(tmp_path / "fitted.toml", model_file.text_of(found.model))
    again = model_file.read(path)
    assert again.builder == {**begun.builder, **again.builder} == found.model.builder and again.gaps == begun.gaps
    assert again.continuous.unit == begun.continuous.unit and np.array_equal(again.unknown, begun.unknown)
    assert likelihood(again, [z], times=[times]) == found.log_likelihood


def dense(name: str, times: np.ndarray, z: np.ndarray, values: np.ndarray) -> float:
    """The likelihood of all rows at once; of the mast by matrix exponentials, of the others by their kernels"""
    there, apart = ~np.isnan(z), np.abs(times[:, None] - times)
    if name == "temperature":
        K = values[1] ** 2 * np.exp(-apart / values[0])
    elif name == "process":
        r = np.sqrt(3) * apart / values[0]
        K = values[1] ** 2 * (1 + r) * np.exp(-r)
    else:
        w = 2 * np.pi / values[0]
        F, q, P, K = np.array([[0, 1], [-w * w, -2 * values[1] * w]]), np.diag([0, values[2]]), np.eye(2), np.zeros_like(apart)
        steps = expm(np.block([[-F, q], [np.zeros((2, 2)), F.T]]) * np.diff(times)[:, None, None])
        for s in range(len(times)):
            moved = P
            for t in range(s, len(times)):
                K[t, s] = K[s, t] = moved[0, 0]
                moved = steps[t, 2:, 2:].T @ moved if t < len(steps) else moved
            if s < len(steps):
                P = steps[s, 2:, 2:].T @ (P @ steps[s, 2:, 2:] + steps[s, :2, 2:])
    S = (K + values[-1] * np.eye(len(times)))[np.ix_(there, there)]
    return -(z[there] @ np.linalg.solve(S, z[there]) + np.linalg.slogdet(2 * np.pi * S)[1]) / 2


@pytest.mark.parametrize("name, rows", [("temperature", 200), ("process", 200), ("mast", 80)])
def test_a_builder_s_fit_is_the_top_of_the_dense_likelihood(name, rows, tmp_path):
    """By SciPy, from the truth, in logarithms"""
    (times, z), truth = built_record(name, rows, 4, tmp_path), np.array(BUILT[name][1], float)
    found = fit(built(name, truth, tmp_path), [z], BUILT[name][2].split(","), times=[times])
    right = minimize(lambda x: -dense(name, times, z[:, 0], np.exp(x)), np.log(truth), method="Nelder-Mead",
                     options=dict(xatol=1e-6, fatol=1e-9, maxiter=2000))
    best = np.array(list(found.model.constants.values()))
    assert found.converged and right.success and abs(found.log_likelihood + right.fun) < 1e-6 * abs(right.fun)
    assert abs(dense(name, times, z[:, 0], best) - found.log_likelihood) < 1e-8 * abs(right.fun)
    assert np.abs(np.log(best) - right.x).max() < 1e-3


@pytest.mark.parametrize("method, form", first(5, [(method, form) for form in ("full", "diagonal", "multiple") for method in ("ml", "em")]))
def test_qc_of_steps_of_dt_is_the_q_of_steps(method, form):
    """Two walks, unknown at first, with missing components; and of a size the noise of a cart, step by step of EM"""
    walks = Model.of_continuous(np.zeros((2, 2)), H=np.eye(2), R=np.eye(2), Qc=np.eye(2), dt=0.5)
    z = simulate(walks.flowing(Qc=np.diag([0.2, 0.4]), R=np.diag([0.3, 0.5]), P0=np.eye(2), unknown=()), 150, 1)[1]
    z[np.random.default_rng(0).random(z.shape) < 0.1] = np.nan
    cases = [(walks, z)] + [(cart(), simulate(cart(Qc=[0, 0.2]), 200, 1)[1])] * (form == "multiple")
    for model, z in cases:
        of_steps, found = (fit(model, [z], (q, "R"), method=method, Q_form=form, tolerance=1e-9, iterations=3000) for q in ("Q", "Qc"))
        assert of_steps.converged and found.converged and found.model.continuous and not of_steps.model.continuous
        assert np.abs(found.model.Q - of_steps.model.Q).max() < 1e-6 * of_steps.model.Q.max()
        assert np.abs(found.model.R / of_steps.model.R - 1)[found.model.R != 0].max() < 1e-6
        assert np.all(np.diff(found.course) > -1e-8) if method == "em" else len(found.course) < 30
        if model is walks:
            np.testing.assert_allclose(found.standard_errors["Qc"] * 0.5, of_steps.standard_errors["Q"], rtol=1e-5)


def test_em_held_entries_and_starts_at_irregular_times():
    times, z = drawn_at_random_times(1)
    found, by_em, again = (fit(cart(), [z], times=[times], **more) for more in (
        {}, dict(method="em", tolerance=1e-7, iterations=3000), dict(starts=3, seed=2)))
    assert found.converged and by_em.converged and np.all(np.diff(by_em.course) > -1e-8) and "3 of 3 starts" in again.message
    for other, most, left in ((by_em, 1e-3, 1e-6), (again, 1e-6, 1e-8)):
        assert abs(other.log_likelihood - found.log_likelihood) < left
        assert abs(other.model.continuous.Qc[1, 1] / found.model.continuous.Qc[1, 1] - 1) < most
    held = fit(cart(Qc=[0.01, 0.5]), [z], times=[times], Q_form="diagonal", held={"Qc": np.diag([True, False])})
    assert held.converged and abs(held.model.continuous.Qc[0, 0] / 0.01 - 1) < 1e-12
    freed = fit(cart(Qc=[0.01, 0.5]), [z], times=[times], Q_form="diagonal")
    other = fit(cart(Qc=freed.model.continuous.Qc), [z], times=[times], Q_form="diagonal", held={"Qc": np.diag([True, False])})
    assert held.log_likelihood < freed.log_likelihood and abs(other.log_likelihood - freed.log_likelihood) < 1e-8
    damped = fit(cart(), [z], ("F", "Q", "R"), times=[times], held={"F": [[1, 1], [1, 0]]})
    assert damped.converged and damped.log_likelihood > found.log_likelihood and damped.standard_errors["F"][1, 1] > 0
    assert damped.model.continuous.F[0].tolist() == [0, 1] and abs(damped.model.continuous.F[1, 1] + 0.2) < 3 * damped.standard_errors["F"][1, 1]


def test_the_scale_of_a_sensor_at_irregular_times():
    """Of a second sensor whose gain is not known, held where it would be the unit of the state"""
    F, H = [[0.0, 1.0], [0.0, -0.2]], [[1.0, 0.0], [0.7, 0.3]]
    truth = Model.of_continuous(F, H=H, R=[0.04, 0.02], Qc=[0.0, 0.5], dt=0.2, P0=[1.0, 1.0])
    times = np.cumsum(np.random.default_rng(4).exponential(0.2, 500) + 1e-3)
    z = simulate(truth, 500, 4, times=times)[1]
    found = fit(truth.changed(H=[[1.0, 0.0], [1.0, 0.0]]), [z], ("H", "R", "Q"), times=[times], held={"H": [[1, 1], [0, 0]]})
    assert found.converged and np.all(np.abs(found.model.H[1] - H[1]) < 3.5 * found.standard_errors["H"][1]), found.message
    assert found.model.H[0].tolist() == [1, 0] and np.all(found.standard_errors["H"][1] < 0.05)


def test_a_qc_of_fewer_noises_keeps_its_rank():
    times, z = drawn_at_random_times(1)
    found = fit(cart(Qc=[[1, 1], [1, 1]]), [z], times=[times])
    assert found.converged and np.ptp(found.model.continuous.Qc) < 1e-9 and found.standard_errors["Qc"][0, 1] > 0


def test_what_is_not_fitted_at_irregular_times(tmp_path):
    times, z = drawn_at_random_times(1)
    two, gm = cart(Qc=[0.1, 0.5]), built("temperature", (20, 0.5, 0.04), tmp_path)
    for given, said in ((dict(free=["A"]), "^A .*irregular .*--free"),
                        (dict(model=two, method="em"), r"^EM .*Qc, .*\(ml\), or --q-form multiple"),
                        (dict(free=["F"], method="em"), "^EM .*Qc and R, not F"),
                        (dict(model=two, method="em", Q_form="diagonal", held={"Q": np.eye(2)}), "^EM .*entries"),
                        (dict(model=cart(Qc=[[1, 1], [1, 1]]), Q_form="diagonal"), r"^Q .*diagonal, Q\[1,0\] is 1"),
                        (dict(model=cart(Qc=[0, 0])), "^Qc is 0"), (dict(times=[times, times]), "times .*2 records"),
                        (dict(model=gm, free=["time_constant", "x0"]), "^x0 .*builder: time_constant, "),
                        (dict(model=gm, free=["time_constant[1]"]), "time_constant .*1 number$"), (dict(model=gm, free=["sigma[a]"]), r"sigma\[a\]"),
                        (dict(model=gm, free=["sigma"], R_form="multiple"), "^parameters .*builder"),
                        (dict(model=gm, free=["dt"]), "time_constant, sigma, noise .*builder;"),
                        (dict(model=built("mast", (1.7, 0, 1, 1), tmp_path), free=["damping"]), "^damping .*logarithm")):
        with pytest.raises(KalmanqError, match=said):
            fit(given.pop("model", cart()), [z], given.pop("free", ["Q"]), times=given.pop("times", [times]), **given)


def test_what_the_rows_do_not_tell_of_a_builder_is_said(tmp_path):
    """White rows far apart: of two noises their sum, of a time constant that it is short, of a density that it may be 0"""
    white, begun = np.random.default_rng(3).normal(size=120), built("temperature", (0.001, 1, 1), tmp_path)
    found = fit(begun, [white], ["sigma", "noise"])
    assert not found.converged and re.search(r"^not determined by the records: sigma \+1 %, noise -[\d.]+ % changes nothing", found.message)
    found = fit(begun, [white], ["time_constant", "sigma"])
    assert found.converged and found.boundary == ("time_constant",) and np.isnan(found.standard_errors["time_constant"][0])
    times, z = built_record("mast", 40, 2, tmp_path)
    found = fit(built("mast", BUILT["mast"][1], tmp_path), [z], ["period", "damping", "Q", "R"], times=[times])
    assert found.converged and found.boundary == ("density",) and found.standard_errors["damping"][0] > 0


def test_the_command_writes_the_builder_again(tmp_path):
    """What is said of each number; entries of a list and of F, too"""
    times, z = built_record("temperature", 300, 1, tmp_path)
    begun, data, out = tmp_path / "begun.toml", tmp_path / "bias.csv", tmp_path / "out.toml"
    built("temperature", (30, 1, 0.1), tmp_path)
    begun.write_text((tmp_path / "built.toml").read_text())
    data.write_text("time [min],z1\n" + "".join(f"{t!r},{'' if np.isnan(y) else repr(y)}\n" for t, y in zip(times.tolist(), z[:, 0].tolist())))
    done = kalmanq("fit", begun, data, "--free", "time_constant,sigma,R", "--out", out)
    assert done.returncode == 0 and "time_constant" in done.stdout and "exact Hessian" in done.stdout, done.stderr
    assert 'builder = "gauss_markov"' in out.read_text() and "sigma = [0." in out.read_text() and "max_gap = 40" in out.read_text()
    told = json_of("run", out, data)
    assert f"-> {told['log_likelihood']:.6f} in" in done.stdout
    alone, raw = (json_of("fit", begun, data, "--free", free) for free in ("time_constant[0],noise", "F[0,0],Qc,R"))
    assert list(alone["standard_errors"]) == ["time_constant", "noise"] and list(raw["standard_errors"]) == ["F", "Qc", "R"]
    assert raw["F"][0][0] < 0 and raw["log_likelihood"] > alone["log_likelihood"] > told["log_likelihood"] - 30
    refused(kalmanq("fit", begun, data, "--free", "time_constant,R", "--method", "em", "--out", tmp_path / "none.toml"),
            "not time_constant: take maximum")
    assert not (tmp_path / "none.toml").exists()


# ------------------------------------------------------------------------------ what takes times


@pytest.mark.parametrize("arithmetic", ["f32", "f64", "q31"])
def test_times_in_steps_of_dt_are_no_times(arithmetic):
    """Bit for bit, though k dt - (k - 1) dt is not dt; rows that are not there are steps of them all"""
    model, _, z, u = random_record(4)
    plain = Smoother(model, arithmetic).run(z, u)
    for first in (0.0, 1e6, -5.0):
        run = Smoother(model, arithmetic).run(z, u, times=first + model.continuous.dt * np.arange(ROWS))
        assert np.array_equal(run.smoothed, plain.smoothed) and np.array_equal(run.sigma, plain.sigma)


@pytest.mark.parametrize("arithmetic, most", [("f64", 1e-9), ("f32", 1e-4), ("q31", 1e-4)])
def test_blocks_lag_instant_and_rows_one_by_one(arithmetic, most):
    model, times, z, u = random_record(7)
    whole = Filter(model, arithmetic).run(z, u, times=times)
    f = Filter(model, arithmetic)
    parts = [f.run(z[rows], u[rows], times=times[rows]) for rows in (slice(0, 1), slice(1, 9), slice(9, ROWS))]
    assert np.array_equal(np.concatenate([one.mean for one in parts]), whole.mean) and f.time == times[-1]
    single = Filter(model, arithmetic)
    single.update(z[0])
    for t in range(1, ROWS):
        single.predict(u[t - 1], dt=model.continuous.between(times)[t - 1])
        single.update(z[t])
    assert np.array_equal(single.mean, f.mean) and np.array_equal(single.sigma, f.sigma)
    lagged = LagSmoother(model, 5, arithmetic).run(z, u, times=times)
    instant = InstantSmoother(model, 3, arithmetic).run(z, u, times=times)
    smoothed = Smoother(model, arithmetic).run(z, u, times=times)
    for mean, sigma, row in ((lagged.lagged[-1], lagged.lagged_sigma[-1], ROWS - 6),
                             (instant.instant[-1], instant.instant_sigma[-1], 3)):
        assert np.abs((mean - smoothed.smoothed[row]) / smoothed.smoothed_sigma[row]).max() < most
        assert np.abs(sigma / smoothed.smoothed_sigma[row] - 1).max() < most


def test_a_forecast_is_of_steps_of_any_length():
    model, times, z, u = random_record(3)
    f = Filter(model)
    f.run(z, u, times=times)
    ahead, control = f.forecast(1, [[0.0] * model.l], dt=0.7), np.zeros(model.l)
    A, Q, _ = model.continuous.step(0.7)
    assert np.allclose(ahead.mean, A @ f.mean, rtol=1e-12) and ahead.time == times[-1] + 0.7
    assert np.allclose(ahead.covariance, A @ f.covariance @ A.T + Q, rtol=1e-10)
    twice = f.forecast(2, [control, control], dt=0.35)
    assert np.allclose(twice.sigma, ahead.sigma, rtol=1e-10)


@pytest.mark.parametrize("seed", [1, 5, 6, 11])
def test_an_unknown_start_at_irregular_times(seed):
    """By the joint normal with a start that is all but unknown"""
    model, times, z, u = random_record(seed)
    run = Smoother(model.changed(P0=None)).run(z, u, times=times)
    right = conditioned(model.x0, 1e9 * np.eye(model.n), exact_steps(model, np.append(np.diff(times), 1)), z, u)
    assert errors(run.smoothed, run.smoothed_sigma, right.smoothed, right.smoothed_covariance) < 1e-7


def test_a_step_has_one_number_whenever_it_is():
    """Of times in decimals, whose differences are off in their last bits: so few processes are made"""
    of = random_record(1)[0].continuous
    ms = np.cumsum(np.random.default_rng(1).integers(1, 200, 5000))
    times = ms / 1000 + 1234.567
    made, raw = of.between(times), np.diff(times)
    assert len(np.unique(made)) < 300 < 400 < len(np.unique(raw))
    assert np.abs(made - np.diff(ms) / 1000).max() < 4 * np.spacing(times[-1])


def test_jitter_within_a_share_of_dt_is_rounded():
    model = Model.of_continuous([[0, 1], [0, 0]], H=[1, 0], R=0.1, Qc=[0, 1], dt=0.1, P0=[1, 1], jitter=0.05)
    draw = np.random.default_rng(5)
    rows = np.cumsum(draw.choice([1, 1, 1, 2, 7], 200))
    z = draw.normal(size=200)
    times = 0.1 * rows + 0.1 * draw.uniform(-0.02, 0.02, 200)
    run, exact = Smoother(model).run(z, times=times), Smoother(model).run(z, times=0.1 * rows)
    assert np.array_equal(run.smoothed, exact.smoothed) and model.continuous.between(np.array([0, 0.004])) == 0.004
    far = times.copy()
    far[100:] += 0.04
    assert not np.array_equal(Filter(model).run(z, times=far).mean[99:], exact.mean[99:])
    assert np.array_equal(Filter(model).run(z[:90], times=far[:90]).mean, exact.mean[:90])


def test_a_frozen_gain_and_regressors_take_times():
    model = Model.of_continuous([[0.0]], H=[1], R=0.5, Qc=[0.2], dt=0.1, P0=[1])
    z, times = np.random.default_rng(1).normal(size=300), 0.1 * np.arange(300)
    times[200:] += 3
    run = FrozenGainFilter(model).run(z, times=times)
    assert run.settled[150] and not run.settled[200] and run.settled[-1]
    H = np.random.default_rng(2).normal(size=300)
    run = Filter(model).run(z, times=times, varying=Varying(H=H))
    steps = Varying(A=np.ones(300), Q=0.2 * np.append(np.diff(times), 1), H=H)
    assert np.allclose(run.mean, Filter(model).run(z, varying=steps).mean, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("times, said", [
    ([0, 1, 0.5, 2], "row 2: .*before"),
    ([0, 1, np.nan, 2], "row 2: .*missing"), ([0, 1, 2], "times are 3, not 4"), (["a", 1, 2, 3], "^times: .*numbers"),
    (np.array(["2020-01-02", "2020-01-01"] * 2, "datetime64[s]"), "row 1: .*before"),
    (["2020-01-01", "2020-01-02", "2020-01-03", "2020-01-04"], "^times: .* of texts$"),
    (np.array(["2020-01-01", "NaT", "2020-01-03", "2020-01-04"], "datetime64[s]"), "row 1: .*missing"),
    (np.arange(4).astype("timedelta64[M]"), "months.*unit"), (np.arange(4).astype("timedelta64"), "unit"),
    ([datetime(2020, 1, 1), datetime(2020, 1, 2, tzinfo=timezone.utc)] * 2, "^times: .*zone"),
    ([0, 1, 1e300, 2e300], "representable")])
def test_what_is_no_time_is_refused(times, said):
    model = Model.of_continuous([[0, 1], [0, 0]], H=[1, 0], R=0.1, Qc=[0, 1], dt=0.1, P0=[1, 1])
    with pytest.raises(KalmanqError, match=said):
        Filter(model).run(np.zeros(4), times=times)


def test_what_takes_no_times_says_so():
    steps, model = Model(1, H=1, R=1, Q=1, P0=1), Model.of_continuous([[0.0]], H=[1], R=1, Qc=[1], dt=0.1, P0=[1])
    for refused, said in ((lambda: Filter(steps).run([1, 2], times=[0, 1]), "F, Qc and dt"),
                          (lambda: Filter(steps).predict(dt=1.0), "F, Qc, dt"),
                          (lambda: Filter(model).predict(dt=0.0), "above 0"),
                          (lambda: Filter(model).run([1, 2], times=[0, 1], varying=Varying(A=[1, 1])), "A, B and Q")):
        with pytest.raises(KalmanqError, match=said):
            refused()
    f = Filter(model)
    f.run([1.0, 2.0])
    with pytest.raises(KalmanqError, match="last row"):
        f.run([1.0], times=[3.0])
    f = Filter(model)
    f.run([1.0, 2.0], times=[0, 1])
    with pytest.raises(KalmanqError, match="row 0: .*before"):
        f.run([1.0], times=[0.5])


def test_the_picture_is_over_time():
    model = Model.of_continuous([[0.0, 1.0], [0.0, 0.0]], H=[1, 0], R=0.3, Qc=[0, 0.1], dt=2.0, P0=[1, 1])
    times = np.array([0.0, 0.7, 3.0, 3.1])
    run = Smoother(model).run(np.arange(4.0), times=times)
    axis = pictures.draw_run(run, np.arange(4.0)[:, None], (np.zeros((2, 2)), np.ones((2, 2))), times).axes[-1]
    lines = {line.get_label(): line.get_xdata() for line in axis.get_lines()}
    assert np.array_equal(lines["smoothed, 95 %"], times) and np.array_equal(lines["forecast, 95 %"], [5.1, 7.1])
    assert axis.get_xlabel() == "time [s]"
