"""Nonlinear models: beside textbook filters in NumPy, beside direct calls of the C core, and as a user has them."""

from __future__ import annotations

import functools
import json
import math
import re
import subprocess
import sys
from pathlib import Path

import models
import numpy as np
import pytest
from command import json_of, kalmanq, refused, rows_of, succeeds
from library import EXAMPLES, saved
from scipy.optimize import least_squares

from kalmanq import KalmanqError, KalmanqWarning, ModelError, Quantity, Smoother, _core
from kalmanq.compiler.run.equation_run import CompiledEquations
from kalmanq.data import joining
from kalmanq.nonlinear import NonlinearFilter, NonlinearModel, NonlinearSmoother, read, simulate
from kalmanq.nonlinear.checks import findings
from kalmanq.nonlinear.jacobians import points_along, prior_points, worst_entry, wrong_entries

sys.path.insert(0, str(Path(__file__).parents[2] / "tests/reference"))
import nonlinear_models as textbook  # noqa: E402
from shared_library import Library  # noqa: E402

TRACK, TRACK_DATA = EXAMPLES / "range_bearing.py", EXAMPLES / "range_bearing.csv"
BATTERY, BATTERY_DATA = EXAMPLES / "battery.py", EXAMPLES / "battery.csv"
LINEARISE = {"extended": textbook.linearise_extended, "cubature": textbook.linearise_cubature}
METHODS = ("extended", "iterated", "cubature", "central", "posterior")
# ranges of states and of innovations, for fixed point
RANGES = {textbook.RangeBearing: ((2000, 2000, 50, 50), (2000, 500)), textbook.Battery: ((2, 1), (16,)),
          textbook.GpsImu: ((4000, 4000, 50, 50, 8, 8), (4000, 4000))}


def of(model: textbook.Model, **other) -> NonlinearModel:
    """The reference's model as the package has it; its Jacobians are found"""
    names = {}
    if type(model) in RANGES:
        for key, letter, ranges in zip(("states", "measurements"), "xz", RANGES[type(model)]):
            names[key] = [Quantity(f"{letter}{k}", "", span) for k, span in enumerate(ranges)]
    functions = {"h": model.h, "increment": model.increment, **other}
    return NonlinearModel(**functions, x0=model.x0, P0=model.P0, Q=model.Q, R=model.R, angles=list(model.angles),
                          name=type(model).__name__, **names)


def drawn(model: textbook.Model, seed: int) -> tuple[np.ndarray, np.ndarray]:
    states, z = model.simulate(np.random.default_rng(seed))
    z[[t for t in range(model.steps) if not model.measures(t)]] = np.nan
    return states, z


def off(ours: np.ndarray, reference) -> float:
    """The largest distance of a mean, in sigmas of the reference"""
    return max(float(np.max(np.abs(x - y) / np.sqrt(np.diag(P)))) for x, (y, P) in zip(ours, reference))


def apart(run, exact) -> tuple[float, float]:
    """Filtered and smoothed means, in sigmas"""
    return (float(np.max(np.abs(run.mean - exact.mean) / exact.sigma)),
            float(np.max(np.abs(run.smoothed - exact.smoothed) / exact.smoothed_sigma)))


# ------------------------------------------------------------------ beside the textbook


@pytest.mark.parametrize("method", LINEARISE)
@pytest.mark.parametrize("make, f32", [
    (textbook.RangeBearing, 5e-5), (textbook.Battery, 5e-5), (textbook.GpsImu, 1e-4),
    (textbook.CoordinatedTurn, 5e-4)])
def test_filter_and_smoother_are_those_of_the_textbook(make, f32, method):
    model = make()
    model.steps = min(model.steps, 100)
    for seed in range(2):
        z = drawn(model, seed)[1]
        filtered, smoothed = textbook.run(model, z, LINEARISE[method])
        for arithmetic, limit in (("f64", 1e-9), ("f32", f32)):
            run = NonlinearSmoother(of(model), arithmetic, method).run(z)
            assert off(run.mean, filtered) < limit and off(run.smoothed, smoothed) < limit
            assert run.event_names == [] and np.all(np.isnan(run.nis) == np.isnan(z[:, 0]))


@pytest.mark.parametrize("method", ["extended", "iterated"])
@pytest.mark.parametrize("make", RANGES)
def test_q31_is_near(make, method):
    model = make()
    model.steps = min(model.steps, 60)
    for seed in range(2):
        z = drawn(model, seed)[1]
        exact, run = (NonlinearSmoother(of(model), arithmetic, method).run(z) for arithmetic in ("f64", "q31"))
        assert max(apart(run, exact)) < 2e-4
        assert np.nanmax(np.abs(run.innovation_sigma / exact.innovation_sigma - 1)) < 1e-4
        assert np.nanmax(np.abs(run.nis - exact.nis)) < 1e-3
        assert abs(run.log_likelihood.sum() - exact.log_likelihood.sum()) < 1e-2


def iterated_by_hand(model: textbook.Model, z: np.ndarray, count: int, linearise) -> list:
    """Posterior linearisation in the covariance form; with Jacobians the iterated extended filter"""
    x, P, made = model.x0, model.P0, []
    for t in range(model.steps):
        if t:
            d, J, left = linearise(lambda y: model.increment(y, t - 1), x, P)
            A = J + np.eye(len(x))
            x, P = x + d, A @ P @ A.T + left + model.Q
        c, C = x, P
        for _ in range(count):
            mean, H, left = linearise(lambda y: textbook.unwrapped(model, y, c, t), c, C)
            S = H @ P @ H.T + left + model.R
            K = np.linalg.solve(S, H @ P).T
            e = textbook.wrapped(model, z[t] - mean) - H @ (x - c)
            c, C = x + K @ e, P - K @ S @ K.T
            C = (C + C.T) / 2
        x, P = c, C
        made.append((x, P))
    return made


@pytest.mark.parametrize("method, linearise", [
    ("iterated", textbook.linearise_extended), ("posterior", textbook.linearise_cubature)])
def test_iterated_updates_are_those_of_the_textbook(method, linearise):
    for seed, r in ((0, (0.5, 0.02)), (1, (0.02, 1e-3)), (2, (0.02, 1e-3))):
        model = textbook.RangeBearing(r, steps=30)
        z = drawn(model, seed)[1]
        reference = iterated_by_hand(model, z, 3, linearise)
        assert off(NonlinearFilter(of(model), "f64", method, 3).run(z).mean, reference) < 1e-9
    once, many = (NonlinearFilter(of(model), "f64", method, count).run(z).mean for count in (1, 4))
    assert off(once, reference) > 0.1 and off(many, reference) < 0.05  # there is something to iterate


def test_iterating_is_right_where_a_sensor_is_sharp():
    model, scores = textbook.RangeBearing(r=(1e-4, 1e-6), steps=30), {}
    for method in METHODS:
        scores[method] = np.mean([nees(NonlinearSmoother(of(model), "f64", method).run(z, covariance=True), states)
                                  for states, z in (drawn(model, seed) for seed in range(4))])
    assert scores["extended"] > 100 and scores["cubature"] > 3
    assert 0.7 < scores["iterated"] < 1.3 and 0.7 < scores["posterior"] < 1.3


def nees(run, states) -> float:
    return float(np.mean([(x - s) @ np.linalg.pinv(P, hermitian=True) @ (x - s) / len(s)
                          for x, P, s in zip(run.smoothed, run.smoothed_covariance, states)]))


# ------------------------------------------------------------------ passes of the smoother


def most_likely(model: textbook.Model, z: np.ndarray, start: np.ndarray) -> np.ndarray:
    """All states at once: the maximum of their density, by SciPy"""
    roots = [np.linalg.inv(np.linalg.cholesky(of)) for of in (model.P0, model.Q, model.R)]

    def residuals(flat: np.ndarray) -> np.ndarray:
        x = flat.reshape(start.shape)
        made = [roots[0] @ (x[0] - model.x0)]
        for t in range(len(x)):
            if t:
                made.append(roots[1] @ (x[t] - x[t - 1] - np.real(model.increment(x[t - 1], t - 1))))
            made.append(roots[2] @ model.innovation(z[t], x[t], t))
        return np.concatenate(made)

    found = least_squares(residuals, start.ravel(), x_scale="jac", xtol=1e-14, ftol=1e-14, gtol=1e-12)
    return found.x.reshape(start.shape)


def test_passes_with_jacobians_find_the_most_likely_states():
    model = textbook.RangeBearing(steps=12)
    for seed in range(2):
        z = drawn(model, seed)[1]
        first = NonlinearSmoother(of(model)).run(z)
        best = most_likely(model, z, first.smoothed)
        assert np.max(np.abs(first.smoothed - best) / first.smoothed_sigma) > 1e-2
        for arithmetic in ("f64", "f32", "q31"):
            smoother = NonlinearSmoother(of(model), arithmetic, passes=10)
            run = smoother.run(z)
            assert smoother.is_settled and 2 <= smoother.passes_done < 10 and smoother.halvings == 0
            assert np.max(np.abs(run.smoothed - best) / run.smoothed_sigma) < 1e-3
            assert arithmetic != "f64" or np.array_equal(first.mean, run.mean)  # the filter's are the first pass's


class FallingBody(textbook.FallingBody):
    """A short fall, with eight steps of the integration a second and less doubt of the ballistic coefficient"""
    steps, parts = 30, 8

    def __init__(self):
        super().__init__()
        self.P0 = np.diag([1e6, 4e6, 1e-4])


@pytest.mark.parametrize("method", ["extended", "cubature", "central"])
def test_passes_mend_a_poor_start(method):
    model, scores = FallingBody(), []
    for passes in (1, 6):
        runs = [(NonlinearSmoother(of(model), "f64", method, passes=passes).run(z, covariance=True), states)
                for states, z in (drawn(model, seed) for seed in range(3))]
        errors = np.sqrt(np.mean([(run.smoothed[:, 0] - states[:, 0]) ** 2 for run, states in runs]))
        scores.append((errors, np.mean([nees(run, states) for run, states in runs])))
    assert scores[1][0] < 0.95 * scores[0][0] and 0.7 < scores[1][1] < 1.3


def growth() -> NonlinearModel:
    """Two solutions: the sign of the state is not measured."""
    return NonlinearModel(lambda x, t: x / 2 + 25 * x / (1 + x * x) + 8 * np.cos(1.2 * t), lambda x: x * x / 20,
                          x0=[0.1], P0=[5], Q=[10], R=[1], name="growth")


@pytest.mark.parametrize("method", ["extended", "cubature"])
def test_a_smoother_that_goes_the_wrong_way_says_so_and_keeps_the_best(method):
    for seed in range(2):
        z = simulate(growth(), 60, seed)[1]
        smoother = NonlinearSmoother(growth(), "f64", method, passes=8)
        with pytest.warns(KalmanqWarning, match="solution"):
            run = smoother.run(z)
        assert not smoother.is_settled and smoother.halvings > 0
        first = NonlinearSmoother(growth(), "f64", method).run(z)
        value = smoother._value
        none = np.zeros((60, 0))
        assert value(run.smoothed, z, none) <= min(smoother.objectives) + 1 < value(first.smoothed, z, none)


def test_a_step_goes_half_of_the_way_until_it_is_as_good():
    class Means:
        def __init__(self, means):
            self.move_to(np.array([means]))

        def move_to(self, means):
            self.means = means

    smoother = NonlinearSmoother(growth())
    smoother._value = lambda means, z, u: abs(float(means[0]) - 1)
    for after, best, halvings in ((8.0, 2.0, 2), (2.5, 1.25, 1), (1000.0, 62.5, 4)):
        smoother.halvings, found = 0, Means(after)
        assert smoother._halve(np.zeros(1), found, 1.0, None, None) == abs(best - 1)
        assert found.means[0] == best and smoother.halvings == halvings


# ------------------------------------------------------------------ a linear model


def linear_as_functions(model) -> NonlinearModel:
    control = (lambda u: model.B @ u) if model.l else (lambda u: 0)
    noise = {"Q": model.Q} if model.G is None else {"G": model.G}
    return NonlinearModel(lambda x, t, u: model.A @ x + control(u), lambda x: model.H @ x, x0=model.x0, P0=model.P0,
                          R=model.R, states=model.states, measurements=model.measurements,
                          controls=[one.name for one in model.controls], name=model.name, **noise)


@pytest.mark.parametrize("make", [models.cart, models.pair])
@pytest.mark.parametrize("method", METHODS)
def test_a_linear_model_gives_the_linear_results(make, method):
    """With samples missing, in part and whole, controls, and correlated noise"""
    model = make()
    for seed in range(2):
        z, u = models.data(model, 60, seed)
        assert np.any(np.isnan(z).sum(axis=1) == 1) and np.any(np.all(np.isnan(z), axis=1))
        for arithmetic, limit in (("f64", 1e-11), ("f32", 1e-4), ("q31", 2e-5)):  # an increment is rounded to its word
            if arithmetic == "q31" and method not in ("extended", "iterated"):
                continue
            exact = Smoother(model, "f64").run(z, u)
            run = NonlinearSmoother(linear_as_functions(model), arithmetic, method).run(z, u)
            assert max(apart(run, exact)) < limit
            assert np.array_equal(run.taken, exact.taken)
            assert np.nanmax(np.abs(run.nis - exact.nis)) < 100 * limit
            assert abs(run.log_likelihood.sum() - exact.log_likelihood.sum()) < 1000 * limit
            there = ~np.isnan(z)
            assert np.array_equal(np.isnan(run.innovation), ~there)
            assert np.max(np.abs(run.innovation_sigma / exact.innovation_sigma - 1)[there]) < 100 * limit


def test_row_by_row_and_in_blocks_is_the_same():
    model = of(textbook.Battery())
    z = drawn(textbook.Battery(), 0)[1]
    whole = NonlinearFilter(model, "f32").run(z)
    blocks = NonlinearFilter(model, "f32")
    parts = [blocks.run(z[:70]), blocks.run(z[70:])]
    assert np.array_equal(np.vstack([part.mean for part in parts]), whole.mean)
    single = NonlinearFilter(model, "f32")
    for t in range(5):
        if t:
            single.predict()
        single.update(z[t])
    assert np.array_equal(single.mean, whole.mean[4]) and np.array_equal(single.sigma, whole.sigma[4])


# ------------------------------------------------------------------ angles


@pytest.mark.parametrize("method", METHODS)
def test_a_bearing_that_passes_half_a_turn_is_as_any_other(method):
    """The same track, seen as it is and turned by pi: in one of the two the bearing jumps by 2 pi on its way."""
    def seen(turn: float) -> NonlinearModel:
        s, c = np.sin(turn), np.cos(turn)
        return NonlinearModel(
            increment=lambda x: [x[2], x[3], 0, 0],
            h=lambda x: [np.hypot(x[0], x[1]), np.arctan2(s * x[0] + c * x[1], c * x[0] - s * x[1])],
            x0=[30, -20, 0, 1], P0=[4, 4, 0.1, 0.1], Q=[1e-4] * 4, R=[0.04, 1e-3],
            angles=["z2"])

    z = simulate(seen(0), 40, 1)[1]
    turned = z.copy()
    turned[:, 1] = (z[:, 1] + np.pi + np.pi) % (2 * np.pi) - np.pi
    assert np.ptp(z[:, 1]) < 2 and np.max(np.abs(np.diff(turned[:, 1]))) > 6
    runs = [NonlinearSmoother(seen(turn), "f64", method).run(data) for turn, data in ((0, z), (np.pi, turned))]
    assert max(apart(*runs)) < 1e-6 and np.max(np.abs(runs[1].innovation[:, 1])) < 1


@pytest.mark.parametrize("method", ["cubature", "central", "posterior"])
def test_sigma_points_beyond_half_a_turn_are_as_any_other(method):
    model = NonlinearModel(lambda x: x, lambda x: x, x0=[0], P0=[1], Q=[0], R=[1], angles=["z1"])
    assert abs(NonlinearFilter(model, "f64", method).run([3.1]).mean[0, 0] - 1.55) < 1e-12  # as without a turn
    assert abs(NonlinearFilter(model, "f64", method).run([3.1 + 2 * np.pi]).mean[0, 0] - 1.55) < 1e-12


TURNS = {"": 2 * np.pi, "rad": 2 * np.pi, "mrad": 2000 * np.pi, "deg": 360, "Degrees": 360, "°": 360, "mdeg": 360e3, "grad": 400, "turn": 1, "rev": 1,
         "cycles": 1, "arcmin": 21600, "arcsec": 1296e3}


def compass(unit, turn, **changed):
    """Of a heading that turns ever on, read with an error"""
    return NonlinearModel(lambda x: [x[0] + 0.05 * turn], lambda x: x, x0=[0.4 * turn], P0=[(0.1 * turn) ** 2], Q=[(0.01 * turn) ** 2],
                          R=[(0.02 * turn) ** 2], states=["yaw"], **{"measurements": [Quantity("compass", unit)], "angles": ["compass"], **changed})


@pytest.mark.parametrize("unit, turn", TURNS.items())
def test_an_angle_is_wrapped_by_its_unit(unit, turn):
    """As one that is never wrapped, by the package, simulated, and by the C: below 0, and turns away"""
    model, whole = compass(unit, turn), compass(unit, turn, angles=[])
    seen = simulate(whole, 60, 3)[1]
    drawn = simulate(model, 60, 3)[1]
    assert np.max(np.abs(drawn)) <= turn / 2 and np.allclose(np.round((seen - drawn) / turn), (seen - drawn) / turn, atol=1e-9)
    away = seen + turn * np.array([-5, 2, 0, -1, 1] * 12)[:, None]
    for method in ("extended", "cubature"):
        wanted = NonlinearFilter(whole, "f64", method).run(seen)
        for z in (seen, drawn, away):
            run = NonlinearFilter(model, "f64", method).run(z)
            assert np.max(np.abs(run.mean - wanted.mean)) < 1e-9 * turn and np.max(np.abs(run.innovation)) < turn / 2
    if unit in ("", "deg", "turn"):
        with CompiledEquations(model, "f64") as c:
            assert np.max(np.abs(c.run(away).mean - wanted.mean)) < 1e-6 * turn
    assert [one for one in findings(model) if not one.is_good or one.subject.startswith("angle")] == []


def test_an_angle_of_no_known_unit_is_refused(tmp_path):
    with pytest.raises(KalmanqError, match="^angles: compass .*LSB, .*rad, deg, "):
        compass("LSB", 4096)
    (tmp_path / "yaw.csv").write_text("compass (deg)\n2\n")
    with pytest.raises(KalmanqError, match="compass .deg. .*compass in rad"):
        joining.record([tmp_path / "yaw.csv"], compass("", 1))


# ------------------------------------------------------------------ Jacobians


def test_jacobians_are_derived_from_the_formulas():
    right = np.array([[0.6, -0.8], [4 / 25, 3 / 25]])
    ways = (lambda x: [np.sqrt(x[0] ** 2 + x[1] ** 2), np.arctan2(x[1], x[0])],
            lambda x: [np.linalg.norm(x), math.atan2(x[1], x[0])],
            lambda x: np.array([np.hypot(x[0], x[1]), np.arctan2(*np.real(x)[::-1])]))
    for h in ways:
        model = NonlinearModel(lambda x: x, h, x0=[0, 0], P0=[1, 1], Q=[1, 1], R=[1, 1], angles=[1])
        assert np.max(np.abs(model.measurement(np.array([3.0, -4.0]), 0) - right)) < 1e-15
        assert np.array_equal(model.transition(np.array([3.0, -4.0]), 0), np.eye(2))


def test_a_function_without_a_formula_needs_a_jacobian_or_sigma_points():
    table = [0.0, 1.0, 4.0, 9.0]
    given = dict(x0=[1.5], P0=[1e-3], Q=[1e-6], R=[1])
    model = NonlinearModel(lambda x: x, lambda x: [table[int(x[0])]], **given)
    with pytest.raises(KalmanqError, match=r"line \d+: .*table\[int\(x\[0\]\)\].*: wants a number where .*np.interp.*Or give its "
                       r"Jacobian H\(x, t, u\)"):
        NonlinearFilter(model).run([1.0])
    assert len(NonlinearFilter(model, method="cubature").run([1.0])) == 1
    known = NonlinearModel(lambda x: x, lambda x: [table[int(x[0])]], H=lambda x: [[2 * x[0]]], **given)
    assert len(NonlinearFilter(known).run([1.0])) == 1
    assert {one.subject: one.said for one in findings(known)}["H"].startswith("not compared: ")


def planted(which: str, i: int, j: int, by: float, only_beyond: float = -np.inf) -> NonlinearModel:
    """The track with a wrong entry, at some states or everywhere"""
    good = read(TRACK)

    def wrong(x):
        J = np.array(good.given[which].function(x), float)
        J[i, j] += by if x[0] > only_beyond else 0
        return J

    functions = {key: given.function for key, given in good.given.items()}
    return NonlinearModel(**{**functions, which: wrong}, x0=good.x0, P0=good.P0, Q=good.Q, R=good.R, states=good.states,
                          measurements=good.measurements, angles=good.angles)


def test_the_checker_accepts_right_jacobians_and_finds_planted_errors():
    good = read(TRACK)
    points = prior_points(good) + points_along(simulate(good, 60, 2)[0], np.zeros((60, 0)))
    assert wrong_entries(good, points) == [] and worst_entry(good, "H", points).share < 1e-8
    assert worst_entry(read(BATTERY), "H", prior_points(read(BATTERY))) is None
    for which, i, j, by in (("A", 0, 2, 1e-3), ("A", 3, 0, 1e-5), ("H", 0, 1, 1e-4), ("H", 1, 0, 1e-6),
                            ("H", 1, 3, 1e-6)):
        found, = wrong_entries(planted(which, i, j, by), points)
        rows = good.state_names if which == "A" else good.measurement_names
        assert (found.which, found.row, found.column) == (which, rows[i], good.state_names[j])
        assert abs(found.given - found.right - by) < 1e-2 * abs(by)
    far = planted("H", 1, 1, 1e-4, only_beyond=0)
    assert wrong_entries(far, prior_points(good)) == []
    found, = wrong_entries(far, points)
    assert (found.row, found.column) == ("bearing", "north") and found.point[0][0] > 0 and found.point[1] > 10
    assert re.match(r"H\[bearing, north\] is \S+, not \S+, at x = \(.*\), t = \d+$", str(found))


def test_functions_that_should_agree_are_compared():
    good = read(TRACK)
    given = {key: one.function for key, one in good.given.items()}
    same = dict(x0=good.x0, P0=good.P0, Q=good.Q, R=good.R, states=good.states, measurements=good.measurements)

    def told(**changed):
        model = NonlinearModel(**{**given, **changed}, **same, angles=["bearing"])
        return {one.subject: one for one in findings(model) if not one.is_good}

    def innovation(z, x):
        return z - np.array(given["h"](x))

    right = told(f=lambda x: x + np.array(given["increment"](x)), innovation=innovation)
    assert right == {}
    units = {**same, "measurements": [Quantity("range", "m"), Quantity("bearing", "deg")], "states": "abcd"}
    degrees = findings(NonlinearModel(**given, **units))
    assert [one.said for one in degrees if one.subject == "angle bearing"][0].startswith("is in deg and not among angles")
    other = told(f=lambda x: np.array([x[0] + x[2], x[1] + x[3], x[2], x[3] + 0.1]))
    assert "of v_north it is 0" in other["increment"].said
    assert "range" in told(innovation=lambda z, x: -innovation(z, x))["innovation"].said


def test_a_formula_of_q_that_is_nan_is_not_the_function():
    def root(x):
        try:
            return math.sqrt(x[0])
        except ValueError:  # a formula raises nothing
            return 1.0

    def said(Q):
        model = NonlinearModel(lambda x: 0.5 * x, lambda x: x[:1], x0=[-2, 1], P0=[1, 1], Q=Q, R=[1])
        return [one.said for one in findings(model) if one.subject == "formulas" and not one.is_good]

    assert said(lambda x: [0.1 * root(x), 1.0])[0].startswith("of Q an entry of the formula is nan and of the function 0.1, at x = (-2, 1)")
    assert not said(lambda x, dt=1e-4: [[dt**3 / 3, dt**2 / 2], [dt**2 / 2, dt + 0 * x[0]]])


# ------------------------------------------------------------------ bits


@pytest.mark.parametrize("arithmetic", ["f32", "f64"])
def test_the_words_are_those_of_direct_calls(arithmetic):
    """The calls of extended.h and sigma_points.h, written out, with numbers of one's own"""
    model, k, n = textbook.RangeBearing(), Library(_core.__file__, arithmetic), 4
    z = drawn(model, 3)[1]

    def A(x, t):
        return textbook.jacobian(lambda y: model.increment(y, t), x) + np.eye(n)

    def H(x, t):
        return textbook.jacobian(lambda y: model.h(y, t), x)

    innovation = k.callback(lambda x: z[t] - model.h(x, t), 2, n)
    increment = k.callback(lambda x: model.increment(x, t - 1), n, n)
    for method in ("extended", "cubature"):
        process, sensor, filter_ = k.made("process", n, 0), k.made("sensor", n, 2), k.made("filter", n)
        memory, work = k.kept[-1], k.numbers(np.zeros(512))
        ours = NonlinearFilter(of(model, A=A, H=H), arithmetic, method)
        k.call("process_init", process, k.numbers(np.eye(n)), None, k.numbers(model.Q))
        k.call("sensor_init_diagonal_extended", sensor, k.numbers(np.zeros((2, n))), k.numbers(np.diag(model.R)))
        k.call("filter_init", filter_, k.numbers(model.x0), k.numbers(model.P0))

        def mean():
            return np.array([k.read("mean", filter_, i) + k.read("mean_low", filter_, i) for i in range(n)])

        for t in range(12):
            if t:
                ours.predict()
                if method == "extended":
                    k.call("process_change_transition", process, k.numbers(A(mean(), t - 1)))
                    k.call("predict_extended", filter_, process, k.numbers(model.increment(mean(), t - 1)))
                else:
                    k.call("predict_sigma_points", filter_, process, increment, None, 0, work)
            ours.update(z[t])
            if method == "extended":
                k.call("sensor_change_measurement", sensor, k.numbers(H(mean(), t)))
                k.call("update", filter_, sensor, k.numbers(z[t] - np.real(model.h(mean(), t))))
            else:
                k.call("update_sigma_points", filter_, sensor, innovation, None, 0, work)
            assert np.array_equal(memory[:len(ours.memory)], ours.memory)


# ------------------------------------------------------------------ what is wrong is said in one line

GOOD = TRACK.read_text()
BAD_FILES = {  # what is said: what is written in the place of what
    "line 11: angles: there is no measurement 'baring'": ('angles = ["bearing"]', 'angles = ["baring"]'),
    "line 11: angle: means nothing to kalmanq; angles?": ('angles = ["bearing"]', 'angle = ["bearing"]'),
    "x0: is missing": ("x0 = [", "y0 = ["),
    "P0: is 3 x 3": ("P0 = [25.0, 25.0, 1.0, 1.0]", "P0 = np.eye(3)"),
    "P0: has to be known": ("P0 = [25.0, 25.0, 1.0, 1.0]", 'P0 = "unknown"'),
    "P0: has a negative variance": ("P0 = [25.0,", "P0 = [-25.0,"),
    "x0: has an entry that is not finite": ("x0 = [-150.0", "x0 = [np.nan"),
    "R: not an array of numbers": ("R = [", 'R = ["a", '),
    "Q: give either Q or G": ("Q = np.kron", "Q_ = np.kron"),
    "f: is missing": ("def increment", "def _increment"),
    "h: is missing": ("def h(", "def _h("),
    "line 7: states: units has 4 units; there are 3 states": ('"v_east", "v_north"]', '"v_east"]'),
    "states: names is not a list of texts": ('["east", "north", "v_east", "v_north"]', '"east"'),
    "measurements: ranges: -1 is not above 0": ("[2000, 1000]", "[2000, -1]"),
    "unit: no such key in [states]; units?": ('"units": ["m", "m", "m/s"', '"unit": ["m", "m", "m/s"'),
    "line 5: unmatched ')'": ('"""\nimport numpy as np', '"""\nimport numpy as np)'),
    "line 5: the file: ModuleNotFoundError": ("import numpy as np", "import nothing_of_that_name"),
    "line 6: the file: ZeroDivisionError: division by zero": ("import numpy as np", "import numpy as np\n1 / 0"),
    "line 6: the file: ends the program (3)": ("import numpy as np", "import numpy as np\nraise SystemExit(3)"),
    "H: is int, not a function": ("def H(x):", "H = 3\ndef _H(x):"),
    "line 27: h: its arguments are x, t, u": ("def h(x):", "def h(x, t, u, more):"),
    "line 27: h: gain has a default, but is in the place of t": ("def h(x):", "def h(x, gain=2):"),
}
BAD_FUNCTIONS = {  # the same, found in a run
    "line 30: h: ZeroDivisionError: division by zero": ("    return [np.hypot", "    1 / 0\n    return [np.hypot"),
    "h: answers 3, not 2": ("np.arctan2(x[1], x[0])]\n", "np.arctan2(x[1], x[0]), 0]\n"),
    "h: answers list, no array of numbers": ("np.arctan2(x[1], x[0])]\n", '"1"]\n'),
    "h: answers NoneType, no array of numbers": ("    return [np.hypot", "    [np.hypot"),
    "h: answers nan for bearing at x = (-150, 20, 5, 0)": ("np.arctan2(x[1], x[0])]\n", "np.nan]\n"),
    "h: answers complex numbers": ("np.arctan2(x[1], x[0])]\n", "1j]\n"),
    "increment: answers inf for v_north at x =": ("x[3], 0, 0]", "x[3], 0, np.inf]"),
    "increment: answers 3, not 4": ("x[3], 0, 0]", "x[3], 0]"),
    "increment: IndexError: index 4 is out of bounds for axis 0 with size 4 (x has 4 numbers)": ("x[3], 0, 0]", "x[4], 0, 0]"),
    "h: IndexError: index 0 is out of bounds for axis 0 with size 0 (x has 4 numbers, no controls are declared)": (
        "def h(x):\n", "def h(x, u):\n    u[0]\n"),
    "h: ends the program": ("    return [np.hypot", "    raise SystemExit\n    return [np.hypot"),
}
BAD_JACOBIANS = {
    "H: answers 1 x 4, not 2 x 4": (", [-x[1] / r2, x[0] / r2, 0, 0]]", "]"),
    "H: answers nan for bearing, v_north at": ("x[0] / r2, 0, 0]]", "x[0] / r2, 0, np.nan]]"),
    "A: answers list, no array of numbers": ("[0, 0, 0, 1]]", "[0, 0, 0]]"),
}


def written(folder: Path, change: tuple[str, str]) -> Path:
    assert change[0] in GOOD
    return saved(folder / "bad.py", GOOD.replace(*change, 1))


@pytest.mark.parametrize("said", BAD_FILES)
def test_a_bad_file_is_refused_in_one_line(said, tmp_path):
    path = written(tmp_path, BAD_FILES[said])
    with pytest.raises(KalmanqError) as problem:
        read(path)
    assert said in str(problem.value) and str(problem.value).startswith(f"{path}: ")
    assert "\n" not in str(problem.value) and sorted(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("method", ["extended", "cubature"])
@pytest.mark.parametrize("said", BAD_FUNCTIONS)
def test_a_bad_function_is_named_with_its_line_and_row(said, method, tmp_path):
    path = written(tmp_path, BAD_FUNCTIONS[said])
    row = 1 if said.startswith("increment") else 0
    with pytest.raises(KalmanqError) as problem:
        NonlinearFilter(read(path), "f64", method).run(np.array([[150.0, 3.0], [145.0, 3.0]]))
    assert re.match(rf"row {row}: {re.escape(str(path))}: line \d+: ", str(problem.value))
    assert said in str(problem.value) and "\n" not in str(problem.value)


@pytest.mark.parametrize("said", BAD_JACOBIANS)
def test_a_bad_jacobian_is_named(said, tmp_path):
    with pytest.raises(KalmanqError, match=re.escape(said)):
        NonlinearFilter(read(written(tmp_path, BAD_JACOBIANS[said]))).run(np.full((2, 2), 3.0))


def test_what_is_raised_at_a_sigma_point_stops_the_call_of_c():
    """And what is no error, but an interrupt, goes through."""
    model, calls = textbook.RangeBearing(), []

    def h(x):
        calls.append(x)
        if len(calls) == 3:
            raise KeyboardInterrupt
        return model.h(x, 0)

    f = NonlinearFilter(of(model, h=h), "f32", "central")
    before = f.memory
    with pytest.raises(KeyboardInterrupt):
        f.update([150.0, 3.0])
    assert len(calls) == 3 and np.array_equal(f.memory, before)


def of_q31(**changed) -> NonlinearModel:
    given = dict(x0=[1.0], P0=[1.0], Q=[0.1], R=[0.1], states=[Quantity("level", "", 8)],
                 measurements=[Quantity("gauge", "", 8)])
    return NonlinearModel(**{**dict(f=lambda x: x, h=lambda x: x), **given, **changed})


def test_q31_refuses_by_name():
    z = np.ones((3, 1))
    for said, model in {
        "H: gauge .*3 .*bits: .*64": of_q31(h=lambda x: 100 * x, R=[100]),
        "increment of level .*1e\\+06": of_q31(f=lambda x: x + 1e6),
        "innovation of gauge = -399: .*range": of_q31(h=lambda x: x + 399, R=[1e4]),
        r"A\[fine, coarse\] = 1e\+300: .*coefficients": of_q31(
            A=lambda x: [[1, 1e300], [0, 1]], h=lambda x: x[0], x0=[1, 0], P0=[1, 1], Q=[1, 1],
            states=[Quantity("fine", "", 8), Quantity("coarse", "", 1e14)]),
        "states: level .*range": of_q31(states=["level"]),
    }.items():
        with pytest.raises(KalmanqError, match=said):
            NonlinearFilter(model, "q31").run(z)
    with pytest.raises(KalmanqError, match="sigma points"):
        NonlinearFilter(of_q31(), "q31", "cubature")


@pytest.mark.parametrize("said, do", {
    "'best'": lambda m: NonlinearFilter(m, "f64", "best"),
    "iterations: below 1": lambda m: NonlinearFilter(m, "f64", "iterated", 0),
    "passes: below 1": lambda m: NonlinearSmoother(m, passes=0),
    "^u .*current": lambda m: NonlinearFilter(m).run([4.0]),
    "u has 1 rows, z has 2": lambda m: NonlinearFilter(m).run([4.0, 4.0], [[1.0]]),
    "row 1: current: ": lambda m: NonlinearFilter(m).run([4.0, 4.0], [[1.0], [np.nan]]),
    "row 0: H: .*f32": lambda m: NonlinearFilter(
        NonlinearModel(lambda x: x, lambda x: x, H=lambda x: [[1e300]], x0=[0], P0=[1], Q=[1], R=[1]), "f32").run([1]),
}.items())
def test_bad_calls_are_refused(said, do):
    with pytest.raises(KalmanqError, match=said):
        do(read(BATTERY))


def test_no_noise_and_no_shape_is_a_model_error():
    for key, changed in {"Q": {"Q": None}, "angles": {"angles": [3]}, "controls": {"controls": ["u", "u"]},
                         "x0": {"x0": np.zeros(17)}, "R": {"R": np.ones(17)}}.items():
        with pytest.raises(ModelError, match=key):
            of_q31(**changed)


# ------------------------------------------------------------------ the command line


def columns(path: Path, *names: str) -> np.ndarray:
    return np.array([[float(row[name] or "nan") for name in names] for row in rows_of(path)])


@pytest.mark.parametrize("path, data, rows, seed", [(TRACK, TRACK_DATA, 60, 2), (BATTERY, BATTERY_DATA, 200, 1)])
def test_the_examples_data_are_simulated(path, data, rows, seed, tmp_path):
    succeeds("simulate", path, "-n", rows, "--seed", seed, "--truth", "--out", tmp_path / "data.csv")
    names = list(rows_of(data)[0])
    assert list(rows_of(tmp_path / "data.csv")[0]) == names
    # libm's last bits may be another machine's
    assert np.allclose(columns(data, *names), columns(tmp_path / "data.csv", *names), rtol=1e-9, atol=1e-9)


def test_run_writes_what_the_twin_says(tmp_path):
    data, out, plot = tmp_path / "data.csv", tmp_path / "out.csv", tmp_path / "out.png"
    data.write_text("\n".join(BATTERY_DATA.read_text().splitlines()[:41]) + "\n")
    done = kalmanq("run", BATTERY, data, "--arith", "f32", "--method", "posterior", "--iterate", 3, "--smooth",
                   "--passes", 5, "--digits", 17, "--out", out, "--plot", plot, "--json")
    assert done.returncode == 0 and done.stderr == "", done.stderr
    said = json.loads(done.stdout)
    smoother = NonlinearSmoother(read(BATTERY), "f32", "posterior", 3, 5)
    run = smoother.run(columns(data, "voltage"), columns(data, "current"))
    assert np.array_equal(columns(out, "charge_smoothed", "polarisation_smoothed"), run.smoothed)
    assert np.array_equal(columns(out, "charge_mean", "polarisation_mean"), run.mean)
    assert said["method"] == "posterior" and said["passes"] == smoother.passes_done and said["rows"] == 40
    assert said["is_settled"] == smoother.is_settled and 0.5 < said["nis_per_measurement"] < 1.5
    assert plot.read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
    printed = kalmanq("run", TRACK, TRACK_DATA, "--arith", "q31", "--smooth")
    assert printed.returncode == 0 and "60 rows, q31, extended" in " ".join(printed.stdout.split()), printed.stderr


def test_compare_and_check(tmp_path):
    said = compared()
    assert 0 < said["arithmetics"]["f32, extended"]["mean_error_in_sigma"] < 1e-3
    assert 0 < said["arithmetics"]["q31, extended"]["mean_error_in_sigma"] < 1e-3
    methods = said["methods"]
    assert methods["extended"]["smoothed_nees_per_state"] > 2 > 1.3 > methods["iterated"]["smoothed_nees_per_state"]
    z = columns(TRACK_DATA, "range", "bearing")
    states = columns(TRACK_DATA, *(f"{one}_true" for one in read(TRACK).state_names))
    run = NonlinearSmoother(read(TRACK), "f64", "cubature").run(z)
    east = np.sqrt(np.mean((run.smoothed - states)[:, 0] ** 2))
    assert abs(methods["cubature"]["smoothed_rms"]["east"] / east - 1) < 1e-12
    without = saved(tmp_path / "without.csv", "range,bearing\n" + "".join(f"{a},{b}\n" for a, b in z))
    assert "smoothed_rms" not in json_of("compare", TRACK, without)["methods"]["extended"]
    said = kalmanq("compare", TRACK, without).stdout
    assert "posterior" in said and "6 passes" not in said and "simulate --truth" in said
    for path, data in ((TRACK, TRACK_DATA), (BATTERY, None)):
        done = kalmanq("check", path, *([data] if data else []), "--json")
        assert done.returncode == 0 and json.loads(done.stdout)["ranges"]["good"], done.stderr
    wrong = saved(tmp_path / "wrong.py", GOOD.replace("-x[1] / r2, x[0] / r2", "x[1] / r2, x[0] / r2"))
    done = kalmanq("check", wrong)
    assert done.returncode == 1 and "NO  H: H[bearing, east] is" in done.stdout
    told = kalmanq("run", wrong, TRACK_DATA)
    assert told.returncode == 0 and "wrong.py: H[bearing, east] is" in told.stderr and told.stderr.count("\n") == 1
    assert kalmanq("run", wrong, TRACK_DATA, "--method", "cubature").stderr == ""  # which does not use them
    narrow = saved(tmp_path / "narrow.py", GOOD.replace("[2000, 1000]", "[2000, 0.5]"))
    done = kalmanq("check", narrow)
    assert done.returncode == 1 and "H: bearing needs" in " ".join(done.stdout.split())


@functools.lru_cache
def compared() -> dict:
    return json_of("compare", TRACK, TRACK_DATA)


def page_of_the_chapter() -> str:
    return (Path(__file__).parents[2] / "tools/docs/guides/nonlinear.md").read_text(encoding="utf-8")


def test_the_pages_programs_run(tmp_path):
    program, session, timed = re.findall(r"^```python.*?\n(.*?)^```", page_of_the_chapter(), re.M | re.S)
    (tmp_path / "cell.py").write_text(program)
    run = NonlinearFilter(read(tmp_path / "cell.py"), "f32").run([4.0, np.nan, 3.9], [[1.0], [1.0], [1.0]])
    assert run.taken.tolist() == [1, 0, 1]
    (tmp_path / "vehicle.py").write_text(timed)
    times = np.cumsum(np.random.default_rng(1).exponential(1.0, 300))
    _, z, u = simulate(read(tmp_path / "vehicle.py"), 300, 1, np.full((300, 1), 0.1), times)
    assert abs(np.mean(NonlinearFilter(read(tmp_path / "vehicle.py")).run(z, u, times=times).nis) / 2 - 1) < 0.15
    space = {"np": np, "kalmanq": __import__("kalmanq")}
    with pytest.warns(KalmanqWarning, match="solution"):
        exec(session, space)
    assert not space["smoother"].is_settled


def test_the_pages_figures_are_what_compare_says():
    """libm's last bits may be another machine's, the figures not"""
    said = compared()["methods"]
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in page_of_the_chapter().splitlines()
            if line.startswith("| ") and line.split("|")[1].strip() in said and line.count("|") == 8]
    assert [row[0] for row in rows] == list(said)
    for method, *cells in rows:
        of = said[method]
        told = [of.get("nis_per_measurement"), of.get("log_likelihood"), of.get("filtered_nees_per_state"),
                of["smoothed_nees_per_state"], of["smoothed_rms"]["east"], of["smoothed_rms"]["north"]]
        for cell, value in zip(cells, told):
            assert (cell == "") == (value is None)
            assert value is None or abs(float(cell) - value) <= 0.6 * 10.0 ** -len(cell.split(".")[1])


def test_the_command_line_refuses_in_one_line(tmp_path):
    nile, nile_data = EXAMPLES / "nile.toml", EXAMPLES / "nile.csv"
    broken = written(tmp_path, BAD_FUNCTIONS["line 30: h: ZeroDivisionError: division by zero"])
    data = saved(tmp_path / "data.csv", "range,bearing\n1,2\nx,3\n")
    out = ("--out", tmp_path / "out.csv")
    for said, arguments in {
        "range_bearing.csv: row 2: ": ("run", broken, TRACK_DATA, *out),
        "line 30: h: ZeroDivisionError: division by zero": ("compare", broken, TRACK_DATA),
        "data.csv: row 3, column range: 'x' is not a number": ("run", TRACK, data, *out),
        "there is no column voltage": ("run", BATTERY, TRACK_DATA, *out),
        "no such file": ("run", tmp_path / "none.py", TRACK_DATA, *out),
        "--lag: of a linear model": ("run", TRACK, TRACK_DATA, "--lag", 3, *out),
        "--smooth and --robust jump: jumps are smoothed of linear models": ("run", TRACK, TRACK_DATA, "--smooth", "--robust", "jump", *out),
        "--passes and --robust: ": ("run", TRACK, TRACK_DATA, "--smooth", "--passes", 3, "--robust", "huber", *out),
        "--as: of a linear model": ("run", TRACK, TRACK_DATA, "--as", "init", *out),
        "--forecast: of a linear model": ("run", TRACK, TRACK_DATA, "--forecast", 3, *out),
        "--iterate: of --method iterated and posterior": ("run", TRACK, TRACK_DATA, "--iterate", 3, *out),
        "--passes: is of --smooth": ("run", TRACK, TRACK_DATA, "--passes", 3, *out),
        "sigma points": ("run", TRACK, TRACK_DATA, "--arith", "q31", "--method", "central", *out),
        "--method: of a nonlinear model": ("run", nile, nile_data, "--method", "cubature", *out),
        "out.csv: is to be a .py file, as the model is": ("fit", TRACK, TRACK_DATA, *out),
        "--smooth: of a linear model": ("simulate", TRACK, "--runs", 3, "--smooth", *out),
    }.items():
        refused(kalmanq(*arguments), said, tmp_path)


@pytest.mark.parametrize("more", [(), ("--compiled", "--arith", "f32")])
def test_report_takes_it(more, tmp_path):
    done = kalmanq("report", TRACK, TRACK_DATA, "-o", tmp_path / "page.html", *more)
    page = (tmp_path / "page.html").read_text()
    assert done.returncode == 0 and done.stdout.startswith("The data fit the model.")
    assert ("compiled f64" in page) == bool(more) and ("extended" in page) and "What it costs" not in page
    assert "arithmetic f32, compiled" in page if more else "smoothed" in page


@pytest.mark.parametrize("command", [("design", "--core", "m3"), ("steady",)])
def test_other_commands_say_who_takes_it(command, tmp_path):
    done = kalmanq(command[0], TRACK, *(tmp_path / one if str(one).startswith("out") else one for one in command[1:]))
    refused(done, "is a nonlinear model, which run, compare, check, compile, simulate and report", tmp_path)


def test_a_process_of_its_own(tmp_path):
    path = written(tmp_path, BAD_FUNCTIONS["line 30: h: ZeroDivisionError: division by zero"])
    done = subprocess.run([sys.executable, "-m", "kalmanq.command_line", "run", path, TRACK_DATA, "--out",
                           tmp_path / "out.csv"], capture_output=True, text=True)
    refused(done, "line 30: h: ZeroDivisionError: division by zero", tmp_path)
