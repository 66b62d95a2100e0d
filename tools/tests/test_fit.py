"""Fits: gradients beside differences of the likelihood, maxima and how soon they are found, standard errors, and what
is said where there is no maximum."""

from __future__ import annotations

import functools
import json
import re
import subprocess
import warnings
from pathlib import Path

import fit_cases
import numpy as np
import pytest
from command import kalmanq as command, refused, succeeds
from library import EXAMPLES, saved
from typer.testing import CliRunner

import kalmanq
from kalmanq import KalmanqError, Model, command_line
from kalmanq.fitting.choice import Choice
from kalmanq.fitting.coordinates import Cholesky
from kalmanq.fitting.entries import free_and_held
from kalmanq.fitting.expectation import Records
from kalmanq.fitting.problem import Problem
from kalmanq.fitting.noise import Noise
from kalmanq.model import model_file
from kalmanq.pages import pictures

NILE = EXAMPLES / "nile.csv"
SEEDS = range(3)


def nile_model(**prior) -> Model:
    return Model([[1]], H=[1], R=1e4, Q=1e4, **prior)


def nile() -> np.ndarray:
    return fit_cases.nile(EXAMPLES)


# ------------------------------------------------------------------------------ the gradient


def slope(f, step: float) -> float:
    """f'(0) by central differences, extrapolated to no step (Richardson); steps of step, step / 2, ..."""
    rows = [(f(h) - f(-h)) / (2 * h) for h in step / 2.0 ** np.arange(5)]
    for order in range(1, 5):
        rows = [(4**order * b - a) / (4**order - 1) for a, b in zip(rows, rows[1:])]
    return rows[0]


def covariance(random: np.random.Generator, n: int) -> np.ndarray:
    G = random.normal(size=(n, n))
    return G @ G.T + 0.2 * np.eye(n)


def random_problem(seed: int, unknown: bool):
    """A model, two records with gaps and controls"""
    random = np.random.default_rng(seed)
    n, m, T = int(random.integers(1, 4)), int(random.integers(1, 4)), 40
    A = random.normal(size=(n, n))
    A *= 0.9 / max(np.abs(np.linalg.eigvals(A)))
    B = random.normal(size=(n, 1))
    model = Model(A, H=random.normal(size=(m, n)), R=covariance(random, m), Q=covariance(random, n), B=B,
                  x0=random.normal(size=n), P0=covariance(random, n), unknown="all" if unknown else ())
    records = [fit_cases.drawn(A, model.H, model.Q, model.R, T, 10 * seed + k, B=B) for k in range(2)]
    for z, _ in records:
        z[random.random(z.shape) < 0.15] = np.nan
        z[20:24] = np.nan
    return model, [z for z, _ in records], [u for _, u in records]


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("unknown", [False, True])
def test_the_gradient_is_that_of_the_filter_s_likelihood(seed, unknown):
    """Of the filter with its exact start, which takes no part in the gradient."""
    model, records, u = random_problem(seed, unknown)
    names = ("A", "H", "Q", "R") + (() if unknown else ("x0", "P0"))
    found = kalmanq.gradient(model, records, u, of=names)
    for name in names:
        value = getattr(model, name)
        size, expected = 0.02 * np.max(np.abs(value)), np.zeros(value.shape)
        is_symmetric = name in ("Q", "R", "P0")
        for at in np.ndindex(value.shape):
            if is_symmetric and at[0] < at[1]:
                continue
            change = np.zeros(value.shape)
            change[at] = 1
            if is_symmetric:
                change = (change + change.T) / 2
            expected[at] = slope(lambda h: kalmanq.likelihood(model.changed(**{name: value + h * change}), records, u),
                                 size)
            expected[at[::-1] if is_symmetric else at] = expected[at]
        assert np.max(np.abs(found[name] - expected)) < 1e-9 * np.max(np.abs(expected)), name


HELD = {"none": np.zeros((3, 3), bool), "an entry": np.eye(3, dtype=bool)[[1, 0, 2]] & ~np.eye(3, dtype=bool),
        "a variance": np.diag([False, True, False]), "all but variances": ~np.eye(3, dtype=bool)}


@pytest.mark.parametrize("rank", [1, 2, 3])
def test_a_singular_covariance_s_coordinates_keep_its_rank_and_have_its_slopes(rank):
    """Each direction of a covariance of that rank, and no other, is that of some coordinates."""
    random = np.random.default_rng(rank)
    factor = random.normal(size=(4, rank)) * [[1], [1e-3], [1e3], [1]]
    start, none = factor @ factor.T, np.zeros((4, 4), bool)
    block, weight = Cholesky("Q", start, none, 50, rank), random.normal(size=(4, 4))
    weight += weight.T
    assert block.size == 4 * rank - rank * (rank - 1) // 2
    deviation = np.sqrt(np.diag(start))
    unit = np.outer(deviation, deviation)
    assert np.max(np.abs(block.matrix(np.zeros(block.size)) - start) / unit) < 1e-11
    assert np.linalg.matrix_rank(block.tangent().reshape(16, -1) / unit.reshape(16, 1), 1e-6) == block.size
    x = random.normal(size=block.size)
    values = np.linalg.eigvalsh(block.matrix(x) / unit)
    assert np.all(values[: 4 - rank] < 1e-10) and values[4 - rank] > 1e-4
    found = block.slopes(weight / unit)
    for k, move in enumerate(np.eye(block.size)):
        expected = slope(lambda h: np.sum(weight / unit * Cholesky("Q", start, none, 50, rank).matrix(x + h * move)), 0.1)
        assert abs(found[k] - expected) < 1e-9 * np.max(np.abs(found))


@pytest.mark.parametrize("held", HELD)
def test_a_covariance_s_coordinates_keep_what_is_held_and_have_its_slopes(held):
    random = np.random.default_rng(3)
    start = covariance(random, 3) if held != "all but variances" else np.diag([1.0, 2, 3])
    block, weight = Cholesky("Q", start, HELD[held], 50), random.normal(size=(3, 3))
    weight += weight.T
    x = random.normal(size=block.size)
    C = block.matrix(x)
    assert np.allclose(C[HELD[held]], start[HELD[held]], rtol=1e-12) and np.linalg.eigvalsh(C)[0] > 0
    assert np.max(np.abs(block.matrix(np.zeros(block.size)) - start)) < 1e-11
    block.matrix(x)
    found, tangent = block.slopes(weight), block.tangent()
    for k in range(block.size):
        move = np.eye(block.size)[k]
        expected = slope(lambda h: np.sum(weight * Cholesky("Q", start, HELD[held], 50).matrix(x + h * move)), 0.1)
        assert abs(found[k] - expected) < 1e-9 * np.max(np.abs(found))
        assert abs(np.sum(weight * tangent[..., k]) - found[k]) < 1e-12 * np.max(np.abs(found))


def test_the_slope_of_what_has_no_noise_is_that_of_the_likelihood():
    """Fisher's identity has none for the entries of A in a row without noise."""
    model = model_file.read(EXAMPLES / "ar.toml")
    z = fit_cases.drawn(model.A, model.H, model.Q, model.R, 60, 1)[0]
    problem = Problem(model, Records(model, [z]), Choice(model, ("A", "Q", "R"), "full", "full", None))
    problem.anchor()
    x = np.zeros(problem.size)
    _, found = problem.evaluate(x)
    for k, move in enumerate(np.eye(problem.size)):
        expected = slope(lambda h: problem.value(h * move), 0.1)
        assert abs(found[k] - expected) < 1e-9 * np.max(np.abs(found))


# ------------------------------------------------------------------------------ maxima


@pytest.mark.parametrize("prior, figures", [({}, fit_cases.NILE_EXACT), ({"P0": [1e7]}, fit_cases.NILE_KNOWN)])
@pytest.mark.parametrize("method", ["ml", "both"])
def test_the_nile_is_statsmodels_nile(prior, figures, method):
    found = kalmanq.fit(nile_model(**prior), [nile()], method=method)
    measured = found.log_likelihood, found.model.R[0, 0], found.model.Q[0, 0]
    assert found.converged and found.distance < 1e-9
    assert np.max(np.abs(np.array(measured) / figures - 1)) < 1e-6
    assert abs(found.standard_errors["Q"][0, 0] - 1280) < 2 and abs(found.standard_errors["R"][0, 0] - 3146) < 2


def test_standard_errors_are_those_of_the_exact_hessian():
    found = kalmanq.fit(nile_model(), [nile()])
    for name, exact in fit_cases.NILE_ERRORS.items():
        assert abs(found.standard_errors[name][0, 0] / exact - 1) < 1e-4


@pytest.mark.parametrize("method", ["em", "ml", "both"])
def test_a_form_that_the_model_has_not_is_named(method, tmp_path):
    """Which parameter, which entry, and what to do; a Q from G of a builder, too."""
    z = np.zeros((9, 2))
    for model in (Model(np.eye(2), H=np.eye(2), R=np.eye(2), Q=[[2, 0.5], [0.5, 1]]),
                  Model(np.eye(2), H=np.eye(2), R=np.eye(2), G=[[1, 0.5], [0, 1]])):
        with pytest.raises(KalmanqError, match=r"^Q .*diagonal, Q\[1,0\] is 0.5, .*--q-form multiple"):
            kalmanq.fit(model, [z], Q_form="diagonal", method=method)
    with pytest.raises(KalmanqError, match=r"^R .*diagonal, R\[1,0\] is -0.25, .*--r-form multiple .* or full"):
        kalmanq.fit(Model(np.eye(2), H=np.eye(2), R=[[1, -0.25], [-0.25, 1]], Q=np.eye(2)), [z], R_form="diagonal", method=method)
    (tmp_path / "z.csv").write_text("east,north\n" + "1,2\n" * 9)
    refused(within("fit", EXAMPLES / "track.toml", tmp_path / "z.csv", "--q-form", "diagonal"), "Q of the model is not diagonal, Q[1,0] is 0.025")


def test_the_course_of_a_search_that_begins_again_goes_up_alone():
    """What was tried from another place is in dots, not in the curve."""
    course = [-9.0, -5.0, -3.0, -1.0, -1.5, -0.5, -7.0, -2.0, -0.6, 0.0]
    found = kalmanq.Fit(nile_model(), 0.0, course=course, em_evaluations=2)
    picture = pictures.draw_course(found, "again")
    drawn = [line for line in picture.axes[0].get_lines() if line.get_linestyle() == "-"]
    assert len(drawn) == 2 and all(np.all(np.diff(line.get_ydata()) <= 0) for line in drawn)
    tried = np.concatenate([line.get_ydata() for line in picture.axes[0].get_lines() if line.get_linestyle() == "None"])
    assert sorted(tried[np.isfinite(tried)]) == [0.6, 1.5, 2.0, 7.0]
    assert [text.get_text() for text in picture.legends[0].get_texts()] == ["EM", "maximum likelihood", "tried besides"]


def test_a_trend_is_statsmodels_trend():
    model = Model([[1, 1], [0, 1]], H=[1, 0], R=3, Q=np.diag([1, 0.1]))
    found = kalmanq.fit(model, [fit_cases.trend(0)], Q_form="diagonal")
    measured = found.log_likelihood, found.model.R[0, 0], *np.diag(found.model.Q)
    assert np.max(np.abs(np.array(measured) / fit_cases.TREND_EXACT - 1)) < 1e-5
    assert np.isnan(found.standard_errors["Q"][0, 1]) and found.standard_errors["Q"][1, 1] > 0


def soon(found, best: float, most: int) -> bool:
    course = np.array(found.course)
    return found.converged and bool(np.any(course[:most] > best - 1e-6)) and abs(found.log_likelihood - best) < 1e-6


@functools.cache
def best_of(name: str, seed: int) -> float:
    """From other starts"""
    draw, model, given = {**WELL, **SINGULAR}[name]
    return kalmanq.fit(model, [draw(seed)], starts=3, seed=7, **given).log_likelihood


WELL = {"local level": (lambda seed: fit_cases.drawn(1, 1, 0.3, 1, 100, seed)[0], Model([[1]], H=[1], R=5, Q=5),
                        {"free": ("Q", "R")}),
        "AR(1) and noise": (fit_cases.ar1, Model([[0.5]], H=[1], R=1.5, Q=1, P0=[1]), {"free": ("A", "Q", "R")}),
        "trend": (fit_cases.trend, Model([[1, 1], [0, 1]], H=[1, 0], R=3, Q=np.diag([1, 0.1])), {"Q_form": "diagonal"}),
        "two states": (fit_cases.pair, Model(0.8 * fit_cases.MATRIX, H=fit_cases.SENSORS, R=[2, 2], Q=[1, 1], P0=[1, 1]),
                       {"free": ("A", "Q", "R")})}


@pytest.mark.parametrize("method", ["ml", "both"])
@pytest.mark.parametrize("name", WELL)
def test_a_maximum_inside_is_found_in_60_evaluations(name, method):
    draw, model, given = WELL[name]
    inside = 0
    for seed in range(7):
        z = draw(seed)
        found = kalmanq.fit(model, [z], method=method, **given)
        if found.boundary:  # the other test's
            continue
        inside += 1
        assert soon(found, best_of(name, seed), 60), (seed, len(found.course), found.message)
    assert inside >= 4


SINGULAR = {"track": (fit_cases.track, Model(fit_cases.AXES, H=fit_cases.PLACES, R=[2, 2], Q=0.5 * np.eye(4), P0=[10] * 4),
                      {"Q_form": "full"}),
            "quarters": (fit_cases.quarters, model_file.read(EXAMPLES / "trend_season.toml"), {"Q_form": "diagonal"})}


@pytest.mark.parametrize("method", ["ml", "both"])
@pytest.mark.parametrize("name", SINGULAR)
def test_a_maximum_at_a_variance_of_0_is_found_in_500_evaluations(name, method):
    draw, model, given = SINGULAR[name]
    for seed in SEEDS:
        found = kalmanq.fit(model, [draw(seed)], method=method, **given)
        assert soon(found, best_of(name, seed), 500), (seed, len(found.course), found.message)


def level_and_slope(seed: int) -> np.ndarray:
    """A level with noise, and no slope in every second seed"""
    random = np.random.default_rng(seed)
    random.normal(size=(240, 1))
    slope = np.cumsum(0.05 * (seed % 2) * random.normal(size=60))
    return np.cumsum(slope + random.normal(size=60)) + random.normal(size=60)


def test_a_variance_of_0_is_said_and_has_no_standard_error():
    model = model_file.read(EXAMPLES / "trend_season.toml")
    found = kalmanq.fit(model, [fit_cases.quarters(1)], Q_form="diagonal")
    assert found.boundary == ("Q[1,1]",) and found.converged
    errors = np.diag(found.standard_errors["Q"])
    assert np.isnan(errors[1]) and errors[0] > 0 and errors[2] > 0 and found.standard_errors["R"][0, 0] > 0
    zero = found.model.changed(Q=np.diag([1.0, 0, 1, 1, 1]) * found.model.Q)
    assert kalmanq.likelihood(zero, [fit_cases.quarters(1)]) > found.log_likelihood - 1e-6
    singular = kalmanq.fit(SINGULAR["track"][1], [fit_cases.track(0)])
    assert singular.boundary == ("Q (singular: rank 2 of 4)",)
    assert np.all(np.isnan(singular.standard_errors["Q"])) and np.all(singular.standard_errors["R"] > 0)


PUSHED = Model(fit_cases.AXES, H=np.eye(4), R=np.eye(4), Q=0.1 * np.eye(4), P0=[100] * 4)


@pytest.mark.parametrize("seed, quiet", fit_cases.PUSHED_BEST)
def test_a_variance_as_small_as_it_may_be_is_at_its_boundary(seed, quiet):
    """Its logarithm is flat there, beside a singular Q.  It was called not determined, or a lower place was found."""
    found = kalmanq.fit(PUSHED, [fit_cases.pushed(seed, quiet)], R_form="diagonal")
    assert found.undetermined == () and found.converged, found.message
    assert f"R[{quiet},{quiet}]" in found.boundary and np.isnan(found.standard_errors["R"][quiet, quiet])
    assert abs(found.log_likelihood - fit_cases.PUSHED_BEST[seed, quiet]) < 1e-6
    assert found.boundary[0].startswith("Q (singular: rank ") and found.evaluations < 300


def test_a_variance_next_to_0_that_others_make_up_for_is_followed():
    """Its best value was 65 times as large, and it was called not determined"""
    z = fit_cases.pushed(103, 3)
    found = kalmanq.fit(PUSHED, [z], R_form="diagonal")
    assert found.converged and found.undetermined == () and "R[3,3]" not in found.boundary, found.message
    best = found.model.R[3, 3]
    for factor in (0.01, 0.1, 10.0):
        held = np.zeros((4, 4), bool)
        held[3, 3] = True
        R = np.diag([*np.diag(found.model.R)[:3], factor * best])
        other = kalmanq.fit(PUSHED.changed(R=R), [z], R_form="diagonal", held={"R": held})
        assert other.log_likelihood < found.log_likelihood - 1e-5


@pytest.mark.parametrize("seed", range(100, 107))
def test_no_variance_of_what_all_is_measured_is_undetermined(seed):
    for quiet in (0, 1, 3):
        found = kalmanq.fit(PUSHED, [fit_cases.pushed(seed, quiet)], R_form="diagonal")
        assert found.undetermined == (), (quiet, found.message)


@pytest.mark.parametrize("seed", [5, 6, 7, 10, 11])
def test_the_covariances_of_a_variance_of_0_are_0_and_have_no_standard_errors(seed):
    """The errors of the others are those of a model that has no such noise."""
    z = level_and_slope(seed)
    full = kalmanq.fit(Model([[1, 1], [0, 1]], H=[1, 0], R=1, Q=[1, 0.1]), [z])
    none = kalmanq.fit(Model([[1, 1], [0, 1]], H=[1, 0], R=1, Q=[1, 0]), [z])
    assert full.boundary == ("Q[1,1]",) and abs(full.log_likelihood - none.log_likelihood) < 1e-6
    errors = full.standard_errors["Q"]
    assert np.all(np.isnan([errors[1, 0], errors[0, 1], errors[1, 1]]))
    assert abs(errors[0, 0] / none.standard_errors["Q"][0, 0] - 1) < 1e-3
    assert abs(full.standard_errors["R"][0, 0] / none.standard_errors["R"][0, 0] - 1) < 1e-3


def test_a_start_at_a_variance_of_next_to_nothing_is_left():
    z = nile()
    for tiny in ({"Q": 1e-9, "R": 1e4}, {"Q": 1e4, "R": 1e-9}):
        found = kalmanq.fit(nile_model().changed(**{name: [[value]] for name, value in tiny.items()}), [z], method="ml")
        assert found.converged and abs(found.log_likelihood - fit_cases.NILE_EXACT[0]) < 1e-6, found.message


@pytest.mark.parametrize("unit", [1e-9, 1.0, 1e9])
def test_units_do_not_matter(unit):
    found = kalmanq.fit(nile_model(), [nile() * unit])
    assert found.converged
    assert abs(found.model.R[0, 0] / unit**2 / fit_cases.NILE_EXACT[1] - 1) < 1e-5
    assert abs(found.standard_errors["Q"][0, 0] / unit**2 / 1280.38 - 1) < 1e-3


def two_sensors(seed: int, unit: float) -> np.ndarray:
    """Of one state, with noises that belong together; the second one in another unit."""
    random = np.random.default_rng(seed)
    level, noise = np.cumsum(random.normal(size=80)), random.normal(size=(80, 2))
    noise[:, 1] = 0.5 * noise[:, 0] + 0.8 * noise[:, 1]
    return (level[:, None] + noise) * [1, unit]


@pytest.mark.parametrize("unit", [1e-6, 1e3, 1e5, 1e6, 1e7])
@pytest.mark.parametrize("seed", [0, 1, 4])
def test_the_unit_of_a_start_does_not_matter(unit, seed):
    """The maximum and the standard errors are those from a start in the right unit."""
    z = two_sensors(seed, unit)
    wrong, right = (kalmanq.fit(Model([[1]], H=[[1], [unit]], R=R, Q=1), [z]) for R in ([1, 1], [1, unit**2]))
    assert wrong.converged and right.converged and abs(wrong.log_likelihood - right.log_likelihood) < 1e-6
    for name in ("Q", "R"):
        assert np.max(np.abs(wrong.standard_errors[name] / right.standard_errors[name] - 1)) < 1e-4


@pytest.mark.parametrize("unit", [1e3, 1e7])
def test_the_unit_of_a_start_of_two_noises_does_not_matter(unit):
    random = np.random.default_rng(1)
    steps = random.normal(size=(100, 2)) @ [[1, 0.7], [0, 0.7]]
    z = np.cumsum(steps, 0) + 0.5 * random.normal(size=(100, 2))
    for units in ([1, unit], [unit, 1]):
        wrong, right = (kalmanq.fit(Model(np.eye(2), H=np.eye(2), R=np.square(units), Q=Q), [z * units])
                        for Q in ([1, 1], np.square(units)))
        assert wrong.converged and abs(wrong.log_likelihood - right.log_likelihood) < 1e-6
        assert np.max(np.abs(wrong.standard_errors["Q"] / right.standard_errors["Q"] - 1)) < 1e-4


def test_standard_errors_are_those_of_a_quadratic_profile():
    """Independent measurements of R alone: R^ = mean square, standard error R^ sqrt(2 / T)."""
    z = np.random.default_rng(1).normal(size=400) * 3
    found = kalmanq.fit(Model([[1]], H=[1], R=1.0, Q=[[0.0]], P0=[[0.0]]), [z], ("R",))
    assert abs(found.model.R[0, 0] / np.mean(z**2) - 1) < 1e-9
    assert abs(found.standard_errors["R"][0, 0] / (np.mean(z**2) * np.sqrt(2 / 400)) - 1) < 1e-5


# ------------------------------------------------------------------------------ structure


def test_held_entries_stay_and_only_the_free_ones_move():
    model = model_file.read(EXAMPLES / "ar.toml")
    z = fit_cases.drawn(model.A, model.H, model.Q, model.R, 300, 3)[0]
    begun = model.changed(A=[[0.5, 0.1], [1, 0]])
    for method in ("em", "ml", "both"):
        found = kalmanq.fit(begun, [z], ("A", "Q", "R"), held={"A": [[0, 0], [1, 1]]}, method=method, iterations=5000)
        assert found.converged, found.message
        assert found.model.A[1].tolist() == [1, 0] and np.all(np.isnan(found.standard_errors["A"][1]))
        assert np.all(np.abs(found.model.A[0] - [1.2, -0.5]) < 3 * found.standard_errors["A"][0])
        assert found.model.Q[1, 1] == 0
    apart = np.kron(np.eye(2), np.ones((2, 2))) == 0
    model, z = SINGULAR["track"][1], fit_cases.track(0)
    found = kalmanq.fit(model, [z], held={"Q": apart})
    assert np.all(found.model.Q[apart] == 0) and found.converged
    fixed = kalmanq.fit(model, [z], ("R",), held={"R": [[1, 0], [0, 0]]})
    assert abs(fixed.model.R[0, 0] - 2) < 1e-12 and fixed.model.R[0, 1] != 0
    with pytest.raises(KalmanqError, match="EM .*entries"):
        kalmanq.fit(model, [z], held={"Q": apart}, method="em")


def test_common_factors_keep_their_rank():
    G = np.kron(np.eye(2), [[0.5], [1.0]])
    model = Model(fit_cases.AXES, H=fit_cases.PLACES, R=[2, 2], G=G, P0=[10] * 4)
    found = kalmanq.fit(model, [fit_cases.track(0)])
    assert found.converged and found.model.G.shape == (4, 2) and np.linalg.matrix_rank(found.model.Q) == 2
    inner = np.linalg.pinv(G) @ found.model.Q @ np.linalg.pinv(G).T
    assert np.max(np.abs(G @ inner @ G.T - found.model.Q)) < 1e-12
    assert np.all(found.standard_errors["Q"] > 0)


@pytest.mark.parametrize("form", ["diagonal", "multiple"])
def test_forms(form):
    model = Model(fit_cases.MATRIX, H=fit_cases.SENSORS, R=[2.0, 1], Q=[[1, 0], [0, 0.5]], P0=[1, 1])
    found = kalmanq.fit(model, [fit_cases.pair(0)], Q_form=form, R_form=form)
    assert found.converged
    for name in ("Q", "R"):
        value = getattr(found.model, name)
        assert value[0, 1] == 0
        if form == "multiple":
            assert abs(value[0, 0] / value[1, 1] - 2) < 1e-12


# ------------------------------------------------------------------------------ EM


SLOW = {"quarters": (fit_cases.quarters(1), model_file.read(EXAMPLES / "trend_season.toml"), "diagonal"),
        "track": (fit_cases.track(1), SINGULAR["track"][1], "full"),
        "Nile": (nile(), nile_model(), "full"),
        "Nile, far": (nile(), nile_model().changed(Q=[[1.0]], R=[[1e6]]), "full")}


@pytest.mark.parametrize("name", SLOW)
def test_em_never_says_converged_far_from_the_maximum(name):
    z, model, form = SLOW[name]
    best = kalmanq.fit(model, [z], Q_form=form).log_likelihood
    for tolerance in (1e-3, 1e-6):
        estimate = kalmanq.Estimation(model, [z], Q_form=form).run(3000, tolerance)
        assert np.all(np.diff(estimate.course) > -1e-8)
        assert not estimate.converged or best - estimate.log_likelihood < 2 * tolerance
    found = kalmanq.fit(model, [z], Q_form=form, method="em", iterations=3000, tolerance=1e-3)
    assert not found.converged or best - found.log_likelihood < 2e-3
    assert found.converged or "not at the maximum" in found.message or "no maximum" in found.message


def test_em_says_what_is_left():
    found = kalmanq.fit(nile_model(), [nile()], method="em", iterations=20)
    left = fit_cases.NILE_EXACT[0] - found.log_likelihood
    assert not found.converged and "is left" in found.message and 0.3 * left < found.distance < 10 * left


def test_em_with_an_unknown_start_is_that_of_the_maximum():
    estimate = kalmanq.Estimation(nile_model(), [nile()]).run(3000, 1e-9)
    assert estimate.converged and abs(estimate.log_likelihood - fit_cases.NILE_EXACT[0]) < 1e-7
    assert abs(estimate.model.R[0, 0] / fit_cases.NILE_EXACT[1] - 1) < 1e-5 and np.all(estimate.model.unknown)


def test_em_in_f32_is_near_that_in_f64():
    found = kalmanq.fit(nile_model(P0=[1e7]), [nile()], method="em", arithmetic="f32", tolerance=0.02)
    assert abs(found.model.R[0, 0] / fit_cases.NILE_KNOWN[1] - 1) < 0.05
    assert not found.converged or fit_cases.NILE_KNOWN[0] - found.log_likelihood < 0.04


def test_a_start_may_be_unknown_in_part():
    model = Model([[1, 1], [0, 1]], H=[1, 0], R=3, Q=np.diag([1, 0.1]), P0=[0, 0.5], unknown=[0])
    z = fit_cases.trend(2)
    found = kalmanq.fit(model, [z, z[:50]], Q_form="diagonal")
    assert found.converged and found.model.unknown.tolist() == [True, False] and found.model.P0[1, 1] == 0.5
    assert abs(kalmanq.likelihood(found.model, [z, z[:50]]) - found.log_likelihood) < 1e-9
    for name in ("Q", "R"):
        for factor in (0.9, 1.1):
            other = found.model.changed(**{name: getattr(found.model, name) * factor})
            assert kalmanq.likelihood(other, [z, z[:50]]) < found.log_likelihood


# ------------------------------------------------------------------------------ what there is no maximum of


def test_what_is_not_determined_is_named():
    model = Model([[0.5]], H=[1], R=1.5, Q=1.0, P0=[1])
    found = kalmanq.fit(model, [fit_cases.ar1(1)], ("A", "H", "Q", "R", "x0", "P0"))
    assert not found.converged and "not determined" in found.message
    assert found.undetermined == ("H[0,0] +1 %, Q[0,0] -2 %, x0[0] -1 %",)
    assert np.isnan(found.standard_errors["H"][0, 0]) and found.standard_errors["A"][0, 0] > 0
    with pytest.raises(KalmanqError, match="^H .*P0 of x1"):
        kalmanq.fit(nile_model(), [nile()], ("H", "R"))
    with pytest.raises(KalmanqError, match="^A .*P0 of x2"):
        kalmanq.fit(Model([[1, 0.5], [0, 0.9]], H=[1, 0], R=1, Q=[1, 1]), [nile()], ("A", "Q", "R"),
                    held={"A": [[1, 0], [1, 1]]})
    once = Model([[1]], H=[[1], [1]], R=[1.0, 1.0], Q=[[0.0]], P0=[[1.0]])
    assert kalmanq.fit(once, [np.random.default_rng(1).normal(size=(50, 2))], ("R",)).converged
    level, slope = Model([[1, 1], [0, 1]], H=[1, 0], R=3, Q=[[1, 0.1], [0.1, 0.5]]), "Q[0,0] +1 %, Q[1,0] +"
    for seed in (0, 2, 3):  # the sum of a level's and a slope's noises has three autocovariances for four numbers
        for method in ("ml", "both"):
            found = kalmanq.fit(level, [fit_cases.trend(seed)], method=method)
            assert not found.converged and found.undetermined[0].startswith(slope), found.message
    z = np.column_stack([fit_cases.drawn(1, 1, 0.3, 1, 80, 1)[0], np.full(80, np.nan)])
    for form in ("full", "diagonal"):  # a component that is never there
        found = kalmanq.fit(Model([[1]], H=[[1], [1]], R=[1, 1], Q=1), [z], R_form=form)
        assert not found.converged and "R[1,1] +1 %" in found.undetermined and found.boundary == ()
    twice = Model(np.eye(2) * 0.5, H=[1, 1], R=1.0, Q=[0.3, 0.5], P0=[1, 1])
    found = kalmanq.fit(twice, [fit_cases.ar1(2)], ("Q",), Q_form="diagonal")
    assert not found.converged and re.search(r"Q\[0,0\] .* %, Q\[1,1\] .* %", found.undetermined[0])
    for seed in range(6):
        found = kalmanq.fit(twice.changed(Q=[0.3, 1e-12]), [fit_cases.ar1(seed)], ("Q",), Q_form="diagonal", method="ml")
        assert not found.converged and found.undetermined == ("Q[1,1] for Q[0,0] +1 %",), seed


def test_a_known_start_determines_H_beside_Q():
    """Many short records: the variances of the first rows are H^2 P0 + R."""
    random = np.random.default_rng(1)
    states = [random.normal(size=300)]
    for _ in range(3):
        states.append(0.8 * states[-1] + 0.5 * random.normal(size=300))
    records = list((2 * np.array(states) + 0.3 * random.normal(size=(4, 300))).T)
    found = kalmanq.fit(Model([[0.8]], H=[1], R=0.1, Q=0.1, P0=[1]), records, ("H", "Q", "R"))
    assert found.converged and found.undetermined == ()
    assert abs(found.model.H[0, 0] - 2) < 3 * found.standard_errors["H"][0, 0] < 0.5
    em = kalmanq.fit(Model([[0.8]], H=[1], R=0.1, Q=0.1, P0=[1]), records, ("H", "Q", "R"), method="em", arithmetic="f32")
    assert em.undetermined == ("H +1 %, Q -2 %",)


@pytest.mark.parametrize("seed", [14, 30, 117])
def test_a_variance_that_begins_next_to_0_is_found(seed):
    """R is flat in its logarithm where it is tiny beside Q, and determined."""
    z = fit_cases.drawn(1, 1, 76, 1, 60, seed)[0]
    best = kalmanq.fit(Model([[1]], H=[1], R=1, Q=1), [z], starts=3, seed=7)
    found = kalmanq.fit(Model([[1]], H=[1], R=1e-3, Q=200), [z])
    assert found.converged and found.boundary == best.boundary == (), found.message
    assert abs(found.log_likelihood - best.log_likelihood) < 1e-6


@pytest.mark.parametrize("z, said", [
    (np.full((30, 1), 5.0), "rises without an end"), (np.array([[1.0]]), "fewer measurements"),
    (np.full((9, 1), np.nan), "every measurement is missing"), (np.array([[1.0], [2.0]]), "not determined")])
@pytest.mark.parametrize("prior", [{}, {"P0": [1e7]}])
def test_no_maximum_is_a_line_and_the_best_point(z, said, prior):
    found = kalmanq.fit(nile_model(**prior), [z])
    assert not found.converged and said in found.message and "\n" not in found.message
    assert np.isfinite(found.log_likelihood) and np.all(np.isfinite(found.model.Q))
    begun = kalmanq.likelihood(nile_model(**prior), [z]) if np.any(np.isfinite(z)) else 0.0
    assert found.log_likelihood >= begun
    for errors in found.standard_errors.values():
        assert np.all(np.isnan(errors))


def test_too_few_evaluations_are_said():
    found = kalmanq.fit(nile_model(), [nile()], method="ml", iterations=4)
    assert not found.converged and "given up after" in found.message
    assert kalmanq.likelihood(nile_model(), [nile()]) < found.log_likelihood < fit_cases.NILE_EXACT[0]


def test_starts_are_counted_and_seeded():
    one, two = (kalmanq.fit(nile_model(), [nile()], starts=3, seed=5) for _ in range(2))
    assert "3 of 3 starts" in one.message and one.course == two.course
    assert np.array_equal(one.model.Q, two.model.Q)
    assert one.evaluations > kalmanq.fit(nile_model(), [nile()]).evaluations


@pytest.mark.parametrize("given, said", [
    ({"free": ("Q", "S")}, "^S "), ({"free": ()}, "nothing"), ({"method": "newton"}, "newton"),
    ({"Q_form": "round"}, "round"), ({"held": {"A": [[1]]}}, "^A|A "), ({"starts": 0}, "starts"),
    ({"held": {"Q": [[1]]}}, "Q .*fixed"), ({"free": ("x0",)}, "P0"),
    ({"u": [None, None]}, "2 records"), ({"seed": -1}, "seed"), ({"starts": 2.5}, "starts"),
    ({"iterations": 0}, "iterations"), ({"tolerance": -1.0}, "tolerance"), ({"tolerance": float("nan")}, "tolerance"),
    ({"arithmetic": "f32"}, "f64"), ({"arithmetic": "q31", "method": "em"}, "f32 and f64")])
def test_what_cannot_be_is_refused(given, said):
    with pytest.raises(KalmanqError, match=said):
        kalmanq.fit(nile_model(), [nile()], **given)
    with pytest.raises(KalmanqError, match="begin"):
        kalmanq.fit(nile_model(P0=[1.0]).changed(Q=[[0.0]]), [nile()])


# ------------------------------------------------------------------------------ the command


def within(*arguments) -> subprocess.CompletedProcess[str]:
    """The command in this process, which has loaded what it takes"""
    done = CliRunner().invoke(command_line.app, [str(one) for one in arguments])
    return subprocess.CompletedProcess(arguments, done.exit_code, done.stdout, done.stderr)


def guess(folder: Path, **changes: str) -> Path:
    path = folder / "guess.toml"
    text = (EXAMPLES / "nile_guess.toml").read_text()
    text = re.sub(r"variance = 1e7.*", 'P0 = "unknown"', re.sub(r"mean = .*", "", text))
    for key, value in changes.items():
        text = re.sub(rf"{key} = .*", f"{key} = {value}", text)
    path.write_text(text)
    return path


def test_the_command_writes_what_reads_back(tmp_path):
    out, plot = tmp_path / "fitted.toml", tmp_path / "fit.png"
    done = succeeds("fit", guess(tmp_path), NILE, "--out", out, "--plot", plot, "--json", "--starts", 2)
    said, fitted, begun = json.loads(done.stdout), model_file.read(out), model_file.read(tmp_path / "guess.toml")
    assert said["converged"] and abs(said["R"][0][0] / fit_cases.NILE_EXACT[1] - 1) < 1e-6
    assert np.allclose(said["Q"], fitted.Q, 1e-15, 0) and said["R"] == fitted.R.tolist() and fitted.builder["builder"] == "level"  # Q is a root, squared
    assert abs(said["standard_errors"]["Q"][0][0] - 1280) < 2 and said["boundary"] == []
    assert fitted.states == begun.states and fitted.measurements == begun.measurements and np.all(fitted.unknown)
    assert plot.read_bytes()[:4] == b"\x89PNG"
    shown = within("fit", out, NILE).stdout
    assert "at the maximum" in shown and "1280.3" in shown and "3145.5" in shown and "exact Hessian" in shown


def test_entries_are_named(tmp_path):
    data = tmp_path / "y.csv"
    model = model_file.read(EXAMPLES / "ar.toml")
    z = fit_cases.drawn(model.A, model.H, model.Q, model.R, 200, 3)[0]
    data.write_text(model.measurements[0].name + "\n" + "\n".join(map(repr, z[:, 0].tolist())) + "\n")
    one, two = (json.loads(within("fit", EXAMPLES / "ar.toml", data, *options, "--json").stdout) for options in (
        ("--free", "A[0,*],Q,R"), ("--free", "Q,A,R", "--hold", "A[1,0],A[1,1]")))
    assert one["A"] == two["A"] and one["A"][1] == [1, 0] and one["A"][0] != model.A[0].tolist()
    names, held = free_and_held("Q[0,1],R", "", Model(np.eye(2), H=[1, 0], R=1, Q=[1, 1]))
    assert names == ["Q", "R"] and held["Q"].tolist() == [[True, False], [False, True]] and "R" not in held


@pytest.mark.parametrize("options, said", [
    (["--free", "Q,S"], ": S is"), (["--free", "A[0]"], "A[ROW,COLUMN]"), (["--free", "Q[3,0]"], "1 x 1"),
    (["--hold", "Q"], "name entries"), (["--hold", "A[0,0]"], "A is not free"), (["--free", "Q R"], "is not NAME"),
    (["--free", "x0[0,0]"], "not of x0"), (["--free", ""], "names nothing"), (["--free", "H,Q,R"], "H^2 Q"),
    (["--hold", "Q[0,0]"], "Q is fixed")])
def test_wrong_input_is_one_line_and_no_file(options, said, tmp_path):
    refused(within("fit", guess(tmp_path), NILE, *options, "--out", tmp_path / "out.toml"), said)
    assert not (tmp_path / "out.toml").exists()


def test_a_gradient_to_what_is_no_parameter_is_refused():
    with pytest.raises(KalmanqError, match="B .*derivatives"):
        kalmanq.gradient(nile_model(P0=[1e7]), [nile()], of=("B",))


@pytest.mark.parametrize("out, plot, said", [
    ("a.png", "a.png", "are one file"), ("a.toml", "fit.pdf", "ends in .png"), ("a.toml", "fit", "ends in .png")])
def test_outputs_that_cannot_be_are_refused_before_anything_is_done(out, plot, said, tmp_path):
    refused(within("fit", guess(tmp_path), NILE, "--out", tmp_path / out, "--plot", tmp_path / plot), said)
    assert not (tmp_path / out).exists() and not (tmp_path / plot).exists()


@pytest.mark.parametrize("run, rows, options, said", [
    (command, ["5"] * 20, [], "rises without an end"), (within, ["1"], [], "fewer measurements"),
    (within, [""] * 5, [], "every measurement"),
    (within, ["1", "3", "2", "4", "3"], ["--iterations", "1"], "given up after")])
def test_no_maximum_has_its_own_exit_code_and_its_best_point(run, rows, options, said, tmp_path):
    data, out = tmp_path / "data.csv", tmp_path / "out.toml"
    data.write_text("year,flow\n" + "".join(f"{k},{row}\n" for k, row in enumerate(rows)))
    done = run("fit", guess(tmp_path), data, "--out", out, "--plot", tmp_path / "fit.png", *options)
    assert done.returncode == 3 and said in done.stderr and done.stderr.count("\n") == 1, done.stderr
    assert np.all(np.isfinite(model_file.read(out).R)) and (tmp_path / "fit.png").exists()


def test_a_singular_q_keeps_a_noise_that_is_small_beside_others():
    """Of two states that move together, and of one in another unit"""
    Q = np.array([[4.0, 2.0, 0], [2.0, 1.0, 0], [0, 0, 1e-14]])
    noise = Noise(Q)
    sigma = np.sqrt(np.diag(Q))
    assert noise.F.shape == (3, 2) and np.all(np.abs(noise.whole(noise.inner) - Q) <= 1e-14 * np.outer(sigma, sigma))


# ------------------------------------------------------------------------------ where there is no value


@pytest.mark.parametrize("method", ["both", "em", "ml"])
@pytest.mark.parametrize("free", [("Q", "R"), ("A",), ("H", "R"), ("x0",)], ids=lambda one: "".join(one))
def test_a_likelihood_without_a_value_says_so(free, method):
    z = 1e200 * np.random.default_rng(0).normal(size=60)
    found = kalmanq.fit(Model([[1]], H=[1], R=1, Q=1, P0=[1]), [z], free, method=method, iterations=60)
    assert not found.converged and found.log_likelihood == -np.inf and not found.standard_errors
    assert found.message.startswith("the log-likelihood is not finite where the search begins: the likelihood is infinite or zero")
    assert "\n" not in found.message and found.message.endswith("; begin nearer to the records, or take units in which numbers are smaller")


def test_starts_without_a_value_do_not_hide_one_that_has_one(tmp_path):
    z = 1e200 * np.random.default_rng(0).normal(size=60)
    found = kalmanq.fit(Model([[1]], H=[1], R=1, Q=1, P0=[1]), [z], starts=3)
    assert not found.converged and "not finite" in found.message
    with pytest.raises(KalmanqError, match="^P0 .*records .*give P0"):
        kalmanq.fit(Model([[1]], H=[1], R=1, Q=1), [z])
    model = saved(tmp_path / "wild.toml", "[model]\nA = [[1]]\nH = [1]\nQ = 1\nR = 1\nP0 = 1\n[measurements]\nnames = ['z']\n")
    data = saved(tmp_path / "wild.csv", "z\n" + "".join(f"{one!r}\n" for one in z.tolist()))
    for more in ((), ("--method", "em"), ("--method", "ml"), ("--starts", 2), ("--json",)):
        done = command("fit", model, data, *more)
        assert done.returncode == 3 and done.stderr.count("\n") == 1 and "the log-likelihood is not finite" in done.stderr, done.stderr
        assert not more or more[0] != "--json" or json.loads(done.stdout)["log_likelihood"] is None


@pytest.mark.parametrize("arithmetic", ["f32", "f64"])
def test_a_history_that_ends_by_an_overflow_says_so(arithmetic):
    """Not that memory is short, which the host has for all rows"""
    model, z = Model([[1.5]], H=[1], R=1, Q=1, P0=[1]), np.full(3000, np.nan)
    z[:5] = 1
    for run in (kalmanq.Smoother(model, arithmetic).run, kalmanq.Smoother(model.changed(P0=None), arithmetic).run, kalmanq.ReweightedSmoother(model, arithmetic).run,
                kalmanq.LagSmoother(model, 3, arithmetic).run, kalmanq.InstantSmoother(model, 3, arithmetic).run,
                lambda z: kalmanq.fit(model.changed(P0=None), [z])):
        with warnings.catch_warnings(), pytest.raises(KalmanqError, match="representable") as told:
            warnings.simplefilter("ignore")
            run(z)
        assert "memory" not in str(told.value)


def test_what_a_fit_cannot_begin_from_is_said():
    draw = np.random.default_rng(0)
    z, one = draw.normal(size=(20, 1)), dict(H=[1], R=1, Q=1)
    for model, free, more, said in (
            (Model([[0.5]], **{**one, "R": 0}, P0=[1]), ("R",), dict(R_form="multiple"), "^R .*begin"),
            (Model([[0.5]], **one, P0=[0]), ("x0", "P0"), {}, "^P0 .*singular"),
            (Model([[0.5]], **{**one, "Q": 1e305}, P0=[1]), ("R",), {}, r"^A, B, Q: .*large.*f64 .*2\^1000"),
            (Model([[0.5]], **one, P0=[1e305]), ("R",), {}, "^x0, P0: .*large.*f64")):
        with pytest.raises(KalmanqError, match=said):
            kalmanq.fit(model, [z], free, **more)
    tiny = Model([[0]], H=[[-2.66e8], [-2.57e8]], R=[1e4, 1e8], Q=0.0119, P0=[0])
    for method in ("both", "ml"):  # its records are so small that their units have squares that overflow
        found = kalmanq.fit(tiny, [1e-300 * draw.normal(size=(21, 2))], ("A", "x0"), method=method, iterations=25)
        assert not found.converged and "\n" not in found.message
    times = np.cumsum(draw.exponential(1.0, 20) + 1e-3)
    flowing = Model.of_continuous([[0.0]], H=[1], R=1, Qc=1, dt=0.5, P0=[1])
    for method in ("both", "em", "ml"):
        found = kalmanq.fit(flowing, [1e160 * z], times=[times], method=method, iterations=25)
        assert not found.converged and found.message.startswith("the log-likelihood is not finite where the search begins"), found.message


def test_a_function_without_a_value_is_named(tmp_path):
    model, data = tmp_path / "roots.py", tmp_path / "roots.csv"
    model.write_text("import numpy as np\nstates, measurements = {'names': ['x']}, {'names': ['z']}\nx0, P0, R, Q, a = [1.0], [1.0], 1.0, 0.1, -1.0\n"
                     "free = ['a']\ndef f(x): return [x[0] + np.sqrt(a)]\ndef h(x): return [x[0]]\n")
    data.write_text("z\n" + "1.5\n" * 20)
    done = command("fit", model, data)
    assert done.returncode == 3 and done.stderr.count("\n") == 1
    assert "not finite where the search begins: row 1: " in done.stderr and "line 5: f: answers nan for x at" in done.stderr, done.stderr


@pytest.mark.parametrize("z", [np.zeros(40), np.ones(40), np.arange(40.0)], ids=["zero", "constant", "line"])
def test_records_without_noise_have_a_sentence(z):
    """Exactly on a line, which a level and a slope follow: no variance is left"""
    for more in ({}, {"method": "ml"}):
        found = kalmanq.fit(Model([[1, 1], [0, 1]], H=[1, 0], R=1, Q=[1, 0.1], P0=[100, 10]), [z], iterations=40, **more)
        assert "\n" not in found.message
