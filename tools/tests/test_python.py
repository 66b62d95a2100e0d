"""Python as its users write it: calls that are likely and wrong, builders by name, a run's repr, types, docstrings with examples."""

import doctest
import inspect
import re

import numpy as np
import pytest
from library import EXAMPLES

import kalmanq
from kalmanq.model import builders, model_file
from kalmanq.model.model_file import tomllib
from kalmanq.model.textbook import _ABOUT

CART = dict(A=[[1, 1], [0, 1]], H=[1, 0], R=4, G=[0.5, 1], P0=[100, 10])
CONE = dict(f=lambda x: x, h=lambda x: x, Q=1.0, R=1.0, x0=[0.0], P0=[1.0])
Z = [1.0, 2.0, np.nan, 4.0]


def cart(**more):
    return kalmanq.Model(**{**CART, **more})


def cone():
    return kalmanq.NonlinearModel(**CONE)


def without(name, **more):
    return {**{key: one for key, one in CART.items() if key != name}, **more}


def set_of(what, name):
    return lambda: setattr(what(), name, [1.0, 2.0])


# what is called, and the name of here that the sentence has
WRONG = {
    "data in the place of a model": (lambda: kalmanq.Filter(Z), TypeError, "Model"),
    "an array in its place": (lambda: kalmanq.Smoother(np.array(Z)), TypeError, "Model"),
    "a path in its place": (lambda: kalmanq.Filter("nile.toml"), TypeError, "model_file.read"),
    "a nonlinear one in its place": (lambda: kalmanq.Filter(cone()), TypeError, "NonlinearFilter"),
    "a linear one of a nonlinear filter": (lambda: kalmanq.NonlinearFilter(cart()), TypeError, "Filter and Smoother"),
    "a linear one of a nonlinear smoother": (lambda: kalmanq.NonlinearSmoother(cart()), TypeError, "Filter and Smoother"),
    "reweighted": (lambda: kalmanq.ReweightedSmoother(Z), TypeError, "Model"),
    "lag": (lambda: kalmanq.LagSmoother(Z, 3), TypeError, "Model"),
    "steady": (lambda: kalmanq.steady_state(Z), TypeError, "Model"),
    "consistency": (lambda: kalmanq.Consistency(Z), TypeError, "Model"),
    "a fit of data": (lambda: kalmanq.fit(Z, [Z]), TypeError, "Model"),
    "data in the place of an arithmetic": (lambda: kalmanq.Filter(cart(), Z), kalmanq.KalmanqError, "f32"),
    "F": (lambda: kalmanq.Model(F=CART["A"], **without("A")), TypeError, "A here"),
    "transition_matrices": (lambda: kalmanq.Model(transition_matrices=CART["A"], **without("A")), TypeError, "A here"),
    "observation_covariance": (lambda: kalmanq.Model(observation_covariance=4, **without("R")), TypeError, "R here"),
    "x": (lambda: cart(x=[0, 0]), TypeError, "x0 here"),
    "P": (lambda: kalmanq.Model(P=[1, 1], **without("P0")), TypeError, "P0 here"),
    "dim_x": (lambda: kalmanq.Model(dim_x=2, dim_z=1), TypeError, "sizes"),
    "dt": (lambda: cart(dt=0.1), TypeError, "of_continuous"),
    "a slip": (lambda: cart(measurement=["z"]), TypeError, "measurements?"),
    "R is missing": (lambda: kalmanq.Model(CART["A"], H=[1, 0]), TypeError, "R is missing"),
    "sizes of a filter": (lambda: kalmanq.Filter(dim_x=2, dim_z=1), TypeError, "sizes"),
    "matrices of a filter": (lambda: kalmanq.Filter(transition_matrices=CART["A"]), TypeError, "kalmanq.Model"),
    "no model": (lambda: kalmanq.Filter(), TypeError, "model is missing"),
    "a run of no data": (lambda: kalmanq.Filter(cart()).run(), TypeError, "z is missing"),
    "a smoother's": (lambda: kalmanq.Smoother(cart()).run(), TypeError, "z is missing"),
    "data by another name": (lambda: kalmanq.Filter(cart()).run(data=Z), TypeError, "z here"),
    "controls by another name": (lambda: kalmanq.Filter(cart()).run(Z, exog=Z), TypeError, "u here"),
    "the class of others": (lambda: kalmanq.KalmanFilter, AttributeError, "kalmanq.Filter"),
    "f.x": (lambda: kalmanq.Filter(cart()).x, AttributeError, "mean"),
    "f.P": (lambda: kalmanq.Filter(cart()).P, AttributeError, "covariance"),
    "f.F": (lambda: kalmanq.Filter(cart()).F, AttributeError, "model.A"),
    "f.smooth": (lambda: kalmanq.Filter(cart()).smooth(Z), AttributeError, "Smoother"),
    "f.batch_filter": (lambda: kalmanq.Filter(cart()).batch_filter(Z), AttributeError, "run(z)"),
    "run.llf": (lambda: kalmanq.Filter(cart()).run(Z).llf, AttributeError, "log_likelihood"),
    "f.x = ": (set_of(lambda: kalmanq.Filter(cart()), "x"), AttributeError, "x0="),
    "f.Q = ": (set_of(lambda: kalmanq.Filter(cart()), "Q"), AttributeError, "changed"),
    "nonlinear f.P = ": (set_of(lambda: kalmanq.NonlinearFilter(cone()), "P"), AttributeError, "P0="),
    "model.R = ": (set_of(cart, "R"), AttributeError, "model.changed(R="),
    "filterpy's functions": (lambda: kalmanq.NonlinearModel(fx=len, hx=len, Q=1, R=1, x0=[0], P0=[1]), TypeError, "f here"),
    "an arithmetic in the place of a lag": (lambda: kalmanq.LagSmoother(cart(), "f32"), kalmanq.KalmanqError, "whole number"),
    "an arithmetic in the place of a row": (lambda: kalmanq.InstantSmoother(cart(), "f32"), kalmanq.KalmanqError, "whole number"),
    "what a run has": (lambda: kalmanq.Smoother(cart()).smoothed, AttributeError, "run(z).smoothed"),
    "a builder without names": (lambda: kalmanq.level(0.1, 1.0, 100.0), TypeError, "drift=..."),
    "a builder's slip": (lambda: kalmanq.level(drift=1, noise=1, variance=1, names=["x"]), TypeError, "level("),
    "a builder without": (lambda: kalmanq.level(drift=1, variance=1), kalmanq.ModelError, "noise"),
}


@pytest.mark.parametrize("call, kind, name", WRONG.values(), ids=WRONG)
def test_a_wrong_call_is_answered_in_a_sentence(call, kind, name):
    with pytest.raises(kind) as said:
        call()
    text = str(said.value)
    assert name in text and "\n" not in text and len(text) < 200, text


def test_what_is_set_and_read_here_is_as_before():
    f = kalmanq.Filter(cart())
    f.own = 1  # a user's attribute
    assert f.own == 1 and not hasattr(f, "nothing") and not hasattr(f.run(Z), "x") and {"own", "mean", "time", "run"} <= set(dir(f))
    assert not {"x", "F", "transition_matrices", "smooth"} & {*dir(f), *dir(kalmanq.Filter), *dir(kalmanq.Smoother)}


# ------------------------------------------------------------------------------ builders


@pytest.mark.parametrize("name", builders.BUILDERS)
def test_a_builder_is_its_model_file(name, tmp_path):
    """The example of the builder, by name and as a file; written and read again it is the same"""
    path = EXAMPLES / f"{name}.toml"
    given = tomllib.loads(path.read_text())["model"]
    given.pop("builder")
    if given.get("P0") == "unknown":
        given["P0"] = None
    model, of_file = getattr(kalmanq, name)(**given), model_file.read(path)
    (tmp_path / "m.toml").write_text(model_file.text_of(model))
    for other in (of_file, model_file.read(tmp_path / "m.toml")):
        for key in ("A", "H", "R", "Q", "x0", "P0", "unknown"):
            assert np.array_equal(getattr(model, key), getattr(other, key)), key
        assert (model.continuous is None) == (other.continuous is None) and model.builder == other.builder


def test_a_prior_takes_the_place_of_the_variances():
    model = kalmanq.constant_velocity(dt=1.0, density=[1, 1], noise=[1, 1], P0=[4, 1, 4, 1], states=["x", "vx", "y", "vy"], name="cart")
    assert np.array_equal(np.diag(model.P0), [4, 1, 4, 1]) and model.states[1].name == "vx" and model.name == "cart"
    assert np.all(kalmanq.constant_velocity(dt=1.0, density=1, noise=1, P0=None).unknown)
    assert list(kalmanq.trend(drift=[1, 1], noise=1, unknown=["slope"], P0=[1, 1]).unknown) == [False, True]


# ------------------------------------------------------------------------------ a run's repr


@pytest.mark.parametrize("n", [1, 2, 16])
def test_a_run_is_shown_in_ten_lines(n):
    model = kalmanq.Model(np.eye(n), H=np.eye(1, n), R=1, Q=np.ones(n), P0=np.ones(n), states=[kalmanq.Quantity(f"x{k}", "m") for k in range(n)])
    for run, there in ((kalmanq.Smoother(model).run(Z, covariance=True), f"4 x {n} x {n}"), (kalmanq.AdaptiveFilter(model).run(Z), "4 x 2"),
                       (kalmanq.SteadyFilter(model, gain=np.ones((n, 1))).run(Z), f"4 x {n}"), (kalmanq.Filter(model).run([]), f"0 x {n}"),
                       (kalmanq.run_series(model, [Z, Z, Z]), f"3 x 4 x {n}")):
        lines = repr(run).split("\n")
        assert len(lines) <= 10 and max(map(len, lines)) < 160 and any(there in one for one in lines), lines
        shown = [name for line in lines for name in re.findall(r"\w+", line)]
        for name, array in vars(run).items():
            assert not isinstance(array, np.ndarray) or name in shown, name


# ------------------------------------------------------------------------------ docstrings

PUBLIC = [name for name in kalmanq.__all__ if name not in ("KalmanqError", "KalmanqWarning", "ModelError")]
FIRST = 24  # lines of a class's docstring: help() fits a screen


@pytest.mark.parametrize("name", PUBLIC)
def test_a_public_name_has_a_docstring_whose_example_runs(name):
    what = getattr(kalmanq, name)
    text = inspect.getdoc(what)
    [found] = doctest.DocTestFinder(recurse=False).find(what, name, module=False, globs={"np": np, "kalmanq": kalmanq})
    assert found.examples and "Examples\n--------" in text
    assert not inspect.isclass(what) or text.count("\n") < FIRST
    told = []
    assert doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE).run(found, out=told.append).failed == 0, "".join(told)


@pytest.mark.parametrize("name", PUBLIC)
def test_a_docstring_has_every_parameter(name):
    what = getattr(kalmanq, name)
    text = inspect.getdoc(what)
    missing = [one for one in inspect.signature(what).parameters if one != "parts" and not re.search(rf"^(?!>>>).*\b{one}\b", text, re.M)]
    assert not missing


@pytest.mark.parametrize("name", PUBLIC)
def test_sections_of_a_docstring_have_names_alone(name):
    """What is said of all of them would be read as a parameter"""
    for section in re.findall(r"^(?:Parameters|Attributes|Raises)\n-+\n(.*?)(?=^\w+\n-+\n|\Z)", inspect.getdoc(getattr(kalmanq, name)), re.S | re.M):
        for line in section.splitlines():
            assert not line or line.startswith(" ") or re.fullmatch(r"\*{0,2}\w+(, \w+)*( : .*)?", line), line


def test_every_builder_has_a_line():
    assert set(_ABOUT) == set(builders.BUILDERS) <= set(kalmanq.__all__)
