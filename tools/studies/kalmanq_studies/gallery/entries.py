"""The models of the gallery: a builder, the parameters where fitting begins, and what the data are."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import partial
from typing import Any, Callable, Mapping, Optional

from kalmanq.model import Model, Quantity
from kalmanq.model.builders import build
from kalmanq_studies.gallery import sources
from kalmanq_studies.gallery.sources import Data


@dataclass(frozen=True)
class Entry:
    """builder, start    of the model, with the parameters where fitting begins
    data       what is measured
    free       the builder's parameters that are fitted
    by         "fit": noises, by kalmanq.fit; "builder": any, by the likelihood over the builder's parameters, for
               models whose start depends on what is free
    Q_form     of kalmanq.fit
    units      of the measurements
    drawn      states in the picture, by name, with their units
    ahead      rows that are forecast
    is_unknown is nothing known of the states at first?
    """

    shows: str
    builder: str
    start: Mapping[str, Any]
    data: Callable[[], Data]
    free: tuple[str, ...]
    by: str = "fit"
    Q_form: str = "diagonal"
    units: tuple[str, ...] = ("",)
    drawn: Mapping[str, str] = field(default_factory=dict)
    ahead: int = 0
    is_unknown: bool = False

    def model(self, parameters: Optional[Mapping[str, Any]] = None, name: str = "model") -> Model:
        """With other parameters, with names and units"""
        made, data = build(self.builder, sources.arrays(self.start if parameters is None else parameters)), self.data()
        if self.is_unknown:
            made.update(x0=None, P0=None)
        if data.regressors is not None:
            made.update(H=data.regressors[0], states=list(data.regressor_names))
        made["states"] = [Quantity(one, self.drawn.get(one, "")) for one in made["states"]]
        measurements = [Quantity(one, unit) for one, unit in zip(data.names, self.units * len(data.names))]
        return Model.of(**made, measurements=measurements, name=name)


_PRIOR2, _PRIOR13 = [1.0] * 2, [1.0] * 13  # in the place of a prior that is unknown
_TRACK = dict(dt=1.0, noise=[25.0, 25.0], variance=[100.0, 25.0, 100.0, 25.0])
_CLIMB = dict(dt=0.5, mean=[0.0, 0.0, 5.0], variance=[100.0, 1.0, 1.0])
_REGRESSION = dict(regressors=[1.0, 1.0], variance=_PRIOR2)

ENTRIES: dict[str, Entry] = {
    "level": Entry(
        "local level: the flow of the Nile", "level", dict(drift=5e3, noise=1e4, variance=1.0), sources.nile,
        ("drift", "noise"), units=("1e8 m3",), ahead=10, is_unknown=True),
    "trend": Entry(
        "local linear trend: income in the United States", "trend",
        dict(drift=[0.5, 0.05], noise=0.1, variance=_PRIOR2), sources.income, ("drift", "noise"), units=("100 log",),
        drawn={"slope": "100 log a quarter"}, ahead=8,
        is_unknown=True),
    "season": Entry(
        "seasonal effects: quarters, drawn", "season", dict(seasons=4, drift=0.5, noise=0.5, variance=[1.0] * 3),
        partial(sources.drawn, "season", 60, 3, ("sales",), seasons=4, drift=0.1, noise=1.0, mean=[3.0, -1.0, 0.5],
                variance=[0.0] * 3), ("drift", "noise"), ahead=8, is_unknown=True),
    "trend-season": Entry(
        "trend and season: carbon dioxide at Mauna Loa, with months missing", "trend_season",
        dict(seasons=12, drift=[0.05, 1e-4, 1e-3], noise=0.05, variance=_PRIOR13), sources.co2, ("drift", "noise"),
        units=("ppm",), drawn={"level": "ppm", "slope": "ppm a month", "season": "ppm"}, ahead=24, is_unknown=True),
    "ar": Entry(
        "autoregression of order 2: sunspots", "ar", dict(phi=[1.0, -0.3], variance=300.0), sources.sunspots,
        ("phi", "variance"), by="builder", ahead=22),
    "ar-noise": Entry(
        "autoregression of order 1, measured with noise: drawn", "ar", dict(phi=[0.5], variance=0.5, noise=0.5),
        partial(sources.drawn, "ar", 300, 5, ("y",), phi=[0.9], variance=0.4, noise=1.0), ("phi", "variance", "noise"),
        by="builder", ahead=20),
    "ma": Entry(
        "moving average of order 2: drawn", "ma", dict(theta=[0.1, 0.1], variance=2.0),
        partial(sources.drawn, "ma", 200, 7, ("y",), theta=[0.6, 0.3], variance=1.0), ("theta", "variance"),
        by="builder", ahead=6),
    "arma": Entry(
        "ARMA(1, 1): inflation in the United States", "arma", dict(phi=[0.5], theta=[0.1], variance=5.0),
        sources.inflation, ("phi", "theta", "variance"), by="builder", units=("%",), ahead=12),
    "regression": Entry(
        "regression, recursively: growth of consumption on growth of income", "regression",
        dict(_REGRESSION, drift=[0.0, 0.0], noise=0.5), sources.consumption, ("noise",), by="builder", units=("%",),
        drawn={"constant": "%", "income": ""}, is_unknown=True),
    "regression-drifting": Entry(
        "regression with drifting coefficients: growth of consumption on growth of income", "regression",
        dict(_REGRESSION, drift=[0.01, 0.01], noise=0.3), sources.consumption, ("drift", "noise"), by="builder",
        units=("%",), drawn={"constant": "%", "income": ""}, is_unknown=True),
    "factor": Entry(
        "dynamic factor: what moves income, consumption and investment", "factor",
        dict(loadings=[[0.5], [0.5], [0.5]], transition=[[0.5]], noise=[0.5, 0.5, 0.5]), sources.growth,
        ("loadings", "transition", "noise"), by="builder", units=("sigma",), drawn={"factor_1": ""}, ahead=8),
    "constant-velocity": Entry(
        "constant velocity: a vehicle in the plane, drawn", "constant_velocity", dict(_TRACK, density=[0.2, 0.2]),
        partial(sources.drawn, "constant_velocity", 150, 11, ("east", "north"), **dict(_TRACK, density=[0.5, 0.5])),
        ("density", "noise"), by="builder", units=("m",), drawn={"velocity_x": "m/s", "velocity_y": "m/s"},
        ahead=10),
    "constant-acceleration": Entry(
        "constant acceleration: a rocket that climbs, drawn", "constant_acceleration",
        dict(_CLIMB, density=[0.1], noise=[1.0]),
        partial(sources.drawn, "constant_acceleration", 200, 13, ("position",),
                **dict(_CLIMB, density=[0.05], noise=[4.0])),
        ("density", "noise"), Q_form="multiple", units=("m",), drawn={"velocity": "m/s", "acceleration": "m/s2"},
        ahead=10),
}
