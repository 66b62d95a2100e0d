"""kalmanq.constant_velocity(dt=..., ...) and its like: the models that `builder = "..."` in a model file makes."""

from __future__ import annotations

import inspect
from typing import Any, Callable

import numpy as np

from kalmanq.errors import ModelError
from kalmanq.model.builders import BUILDERS, Parameter, build
from kalmanq.model.model import Model
from kalmanq.model.spellings import cure

_OF_MODEL = ("x0", "P0", "unknown", "c", "d")  # in the place of what the builder makes, or beside it
_NAMES = ("states", "measurements", "gaps", "name", "time_unit", "jitter")
_MEANING = {
    "dt": "time from row to row", "density": "spectral density of the noise of each axis, walk or state",
    "noise": "variance of a measurement", "mean": "mean before the first row; 0", "drift": "variance of a step of each state",
    "variance": "variances before the first row; of an autoregression or a moving average, of its shocks", "seasons": "rows of a season, 2 or more",
    "phi": "coefficients of the values before", "theta": "coefficients of the shocks before", "regressors": "one for each coefficient; Varying(H=...) has those of each row",
    "time_constant": "of each bias, in the unit of dt", "sigma": "standard deviation that it keeps", "period": "in the unit of dt",
    "damping": "share of the critical one; 0", "smoothness": "Matern's nu: 0.5, 1.5 or 2.5", "length": "correlation length, in the unit of dt",
    "harmonics": "waves of period / 1, period / 2, ...", "loadings": "m x k", "transition": "k x k"}
_ABOUT = {  # what it is, and an example
    "level": ("A level that walks.", "drift=0.1, noise=1.0, variance=100.0"),
    "trend": ("A level and its slope.", "drift=[0.1, 0.01], noise=1.0, variance=[100.0, 1.0]"),
    "season": ("Effects of a season, whose sum is noise.", "seasons=4, drift=0.1, noise=1.0, variance=[10.0, 10.0, 10.0]"),
    "trend_season": ("A trend and a season.", "seasons=4, drift=[0.1, 0.01, 0.1], noise=1.0, variance=[100.0, 1.0, 10.0, 10.0, 10.0]"),
    "ar": ("An autoregression.", "phi=[0.5, 0.25], variance=1.0"),
    "ma": ("A moving average.", "theta=[0.5], variance=1.0"),
    "arma": ("An autoregression whose shocks are a moving average.", "phi=[0.5], theta=[0.25], variance=1.0"),
    "regression": ("Coefficients that walk.", "regressors=[1.0, 2.0], drift=[0.0, 0.01], noise=1.0, variance=[100.0, 100.0]"),
    "constant_velocity": ("Position and velocity on 1 to 3 axes: positions are measured, acceleration is white noise.",
                          "dt=0.1, density=0.2, noise=0.04, variance=[100.0, 10.0]"),
    "constant_acceleration": ("Position, velocity, acceleration on 1 to 3 axes: positions are measured, jerk is white noise.",
                              "dt=0.1, density=0.2, noise=0.04, variance=[100.0, 10.0, 1.0]"),
    "random_walk": ("Walks, each of which is measured.", "dt=1.0, density=[0.1, 0.2], noise=[1.0, 1.0], variance=[100.0, 100.0]"),
    "gauss_markov": ("Biases that decay and keep a sigma.", "dt=0.1, time_constant=300.0, sigma=0.02, noise=0.01"),
    "clock": ("Phase and frequency of a clock.", "dt=1.0, density=[1e-20, 1e-24], noise=1e-18, variance=[1e-6, 1e-12]"),
    "oscillator": ("Position and velocity of a damped oscillator.", "dt=0.1, period=5.0, damping=0.05, density=0.1, noise=0.04, variance=[4.0, 6.0]"),
    "gaussian_process": ("Regression by a Gaussian process of Matern's kernel.", "dt=0.1, smoothness=1.5, length=2.0, sigma=1.5, noise=0.04"),
    "harmonic": ("A season as a few waves.", "dt=1.0, period=24.0, harmonics=1, density=0.01, noise=1.0, variance=[9.0, 9.0]"),
    "trend_harmonic": ("A level, its slope and a season as a few waves.",
                       "dt=1.0, period=24.0, harmonics=1, density=[0.1, 1e-4, 1e-3], noise=1.0, variance=[100.0, 1.0, 9.0, 9.0]"),
    "factor": ("Series that a few factors move.", "loadings=[[1.0], [0.7]], transition=[[0.9]], noise=[0.5, 0.3]"),
}


def _named(name: str) -> Callable[..., Model]:
    own = [one.name for one in BUILDERS[name].parameters]

    def make(*places: Any, **given: Any) -> Model:
        if places:
            raise TypeError(f"{name}({', '.join(f'{one}=...' for one in own)}): give the parameters by their names, in any order")
        known = [*own, *(one for one in (*_OF_MODEL, *_NAMES) if one not in own)]
        for key in given:
            if key not in known:
                raise TypeError(f"{name}({', '.join(own)}): {key} {cure(key, known)}")
        parameters = {key: given[key] for key in given if key in own}
        others = {key: given[key] for key in given if key not in own}
        made = build(name, parameters, has_prior=bool(others.keys() & {"P0", "unknown"}))
        if made.keys().isdisjoint({"F"}) and others.keys() & {"time_unit", "jitter"}:
            raise ModelError("time_unit", f"is of a model in continuous time, and {name} is of steps")
        model = Model.of(**{"name": name, **made, **others})
        if "unknown" not in given:  # as its file says it, so that a fit estimates its parameters
            kept = {key: others[key] for key in _OF_MODEL if key in others and (key == "P0" or others[key] is not None)}
            model.builder = {"builder": name, **{key: _plain(one) for key, one in {**parameters, **kept}.items() if one is not None or key == "P0"}}
        return model

    make.__name__ = make.__qualname__ = name
    make.__signature__ = inspect.Signature([  # type: ignore[attr-defined]
        *map(_as_argument, BUILDERS[name].parameters), inspect.Parameter("of_model", inspect.Parameter.VAR_KEYWORD)], return_annotation=Model)
    make.__doc__ = _doc(name)
    return make


def _plain(value: Any) -> Any:
    return "unknown" if value is None else np.asarray(value).tolist()


def _as_argument(one: Parameter) -> inspect.Parameter:
    return inspect.Parameter(one.name, inspect.Parameter.KEYWORD_ONLY, default=inspect.Parameter.empty if one.is_needed else one.default)


def _doc(name: str) -> str:
    what, example = _ABOUT[name]
    kinds = {"number": "number", "whole": "int", "vector": "number or list of them", "matrix": "list of rows"}
    lines = [f"{one.name} : {kinds[one.kind]}\n    {_MEANING[one.name]}" for one in BUILDERS[name].parameters]
    rest = ", ".join(one for one in (*_OF_MODEL, *_NAMES) if one not in _MEANING)
    return "\n".join([what, "", "Parameters", "----------", *lines, "**of_model", f"    of Model: {rest}.  P0 takes the place of the variances",
                      "", "Examples", "--------", f">>> model = kalmanq.{name}({example})"])


(level, trend, season, trend_season, ar, ma, arma, regression, constant_velocity, constant_acceleration, random_walk, gauss_markov, clock,
 oscillator, gaussian_process, harmonic, trend_harmonic, factor) = map(_named, BUILDERS)
