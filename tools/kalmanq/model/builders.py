"""Models by name: the builders of the C core (models.h), with the names of what they are given."""

from __future__ import annotations

import difflib
from dataclasses import dataclass
from typing import Any, Callable, Mapping, Optional

import numpy as np

from kalmanq.core import ffi, lib, require
from kalmanq.errors import ModelError
from kalmanq.model.arrays import numbers_of

_NOTHING = object()
_ONES = np.ones(lib.KQ_SIZE_MAX)  # of as many states as there may be
_ANY_PRIOR = {"number": 1.0, "vector": _ONES}
WHOLE_MAX = 1000


@dataclass(frozen=True)
class Parameter:
    """kind: "number", "whole", "vector", "matrix"; without a default it has to be given.  is_prior: the variances
    before the first row, which a P0 of its own takes the place of."""

    name: str
    kind: str
    default: Any = _NOTHING
    is_prior: bool = False  # of a number or a vector

    def value(self, given: Mapping[str, Any]) -> Any:
        if self.name not in given:
            if self.default is _NOTHING:
                raise ModelError(self.name, f"is missing: {self._expected}")
            return self.default
        return self._checked(given[self.name])

    @property
    def _expected(self) -> str:
        return {"number": "a number", "whole": f"a whole number of at most {WHOLE_MAX}", "vector": "a list of numbers",
                "matrix": "a list of rows of numbers"}[self.kind]

    def _checked(self, value: Any) -> Any:
        if self.kind == "whole":
            if isinstance(value, bool) or not isinstance(value, int) or abs(value) > WHOLE_MAX:
                raise ModelError(self.name, f"is not {self._expected}")
            return value
        try:
            array = numbers_of(value)
        except (TypeError, ValueError, OverflowError):
            raise ModelError(self.name, f"is not {self._expected}") from None
        if self.kind == "vector" and array.ndim == 0:
            array = array.reshape(1)
        if array.ndim != {"number": 0, "vector": 1, "matrix": 2}[self.kind] or isinstance(value, (bool, str)):
            raise ModelError(self.name, f"is not {self._expected}")
        return float(array) if self.kind == "number" else array


@dataclass(frozen=True)
class Builder:
    parameters: tuple[Parameter, ...]
    make: Callable[[dict[str, Any]], dict[str, Any]]


def build(name: str, given: Mapping[str, Any], has_prior: bool = False) -> dict[str, Any]:
    """Arguments of Model.  has_prior: P0 comes from elsewhere, so that no variances are needed."""
    if name not in BUILDERS:
        near = difflib.get_close_matches(name, BUILDERS, 1)
        raise ModelError("builder", f"there is no {name!r}" + (f"; {near[0]}?" if near else
                                                               f": {', '.join(BUILDERS)}"))
    builder = BUILDERS[name]
    known = [one.name for one in builder.parameters]
    for key in given:
        if key not in known:
            near = difflib.get_close_matches(key, known, 1)
            raise ModelError(key, f"{name} has no such parameter" + (f"; {near[0]}?" if near else
                                                                     f": {', '.join(known)}"))
    return builder.make({one.name: _ANY_PRIOR[one.kind] if has_prior and one.is_prior and one.name not in given
                         else one.value(given) for one in builder.parameters})


# ------------------------------------------------------------------------------ what C builds


def _vector(value: Optional[np.ndarray]) -> Any:
    return ffi.NULL if value is None else ffi.new("double[]", np.ravel(value).tolist() or [0.0])


def _built(n: int, r: int, m: int, fill: Callable[[Any], int], names: list[str], what: str) -> dict[str, Any]:
    for size, of in ((n, "states"), (r, "noises"), (m, "measurements")):
        if not 1 <= size <= lib.KQ_SIZE_MAX:
            raise ModelError("builder", f"{what} would have {size} {of}; there are 1 to {lib.KQ_SIZE_MAX}")
    model = ffi.new("kq_model_f64 *")
    memory = ffi.new("double[]", int(lib.kq_model_length_f64(n, r, m)))
    require(lib.kq_model_assign_f64(model, n, r, m, memory, len(memory)), what)
    status = fill(model)
    if status == lib.KQ_ERR_NO_CONVERGENCE:
        raise ModelError("builder", f"{what}: the model is not stationary")
    if status != lib.KQ_OK:
        raise ModelError("builder", f"{what}: {ffi.string(lib.kq_status_text(status)).decode()}")

    def array(pointer: Any, *shape: int) -> np.ndarray:
        flat = np.frombuffer(ffi.buffer(pointer, 8 * int(np.prod(shape))), np.float64)
        return flat.reshape(shape).copy()

    return {"A": array(model.A, n, n), "G": array(model.F, n, r), "H": array(model.H, m, n),
            "R": array(model.R, m), "x0": array(model.x0, n), "P0": array(model.P0, n, n), "states": names}


def _motion(order: int) -> Callable[[dict[str, Any]], dict[str, Any]]:
    stem, words = {2: ("velocity", ("position", "velocity")),
                   3: ("acceleration", ("position", "velocity", "acceleration"))}[order]
    make = {2: lib.kq_model_velocity_f64, 3: lib.kq_model_acceleration_f64}[order]

    def build_motion(of: dict[str, Any]) -> dict[str, Any]:
        d = len(of["density"])
        _lengths(of, noise=d, variance=order * d, mean=order * d)
        axes = [""] if d == 1 else ["_x", "_y", "_z"][:d]
        names = [word + axis for axis in axes for word in words]
        built = _built(order * d, order * d, d, lambda model: make(
            model, d, of["dt"], _vector(of["density"]), _vector(of["noise"]), _vector(of["mean"]),
            _vector(of["variance"])), names, f"constant_{stem}")
        return built

    return build_motion


def _lengths(of: dict[str, Any], **lengths: int) -> None:
    for name, length in lengths.items():
        if of[name] is _ONES:
            of[name] = np.ones(max(0, min(length, lib.KQ_SIZE_MAX)))
            continue
        if of[name] is not None and np.size(of[name]) != length:
            raise ModelError(name, f"has {np.size(of[name])} numbers, not {length}")


def _level(of: dict[str, Any]) -> dict[str, Any]:
    return _built(1, 1, 1, lambda model: lib.kq_model_level_f64(
        model, of["drift"], of["noise"], of["mean"], of["variance"]), ["level"], "level")


def _trend(of: dict[str, Any]) -> dict[str, Any]:
    _lengths(of, drift=2, mean=2, variance=2)
    return _built(2, 2, 1, lambda model: lib.kq_model_trend_f64(
        model, _vector(of["drift"]), of["noise"], _vector(of["mean"]), _vector(of["variance"])),
        ["level", "slope"], "trend")


def _effects(seasons: int) -> list[str]:
    return ["season"] + [f"season_{k}_before" for k in range(1, seasons - 1)]


def _season(of: dict[str, Any]) -> dict[str, Any]:
    seasons = of["seasons"]
    _lengths(of, mean=seasons - 1, variance=seasons - 1)
    return _built(seasons - 1, 1, 1, lambda model: lib.kq_model_season_f64(
        model, seasons, of["drift"], of["noise"], _vector(of["mean"]), _vector(of["variance"])),
        _effects(seasons), "season")


def _trend_season(of: dict[str, Any]) -> dict[str, Any]:
    seasons = of["seasons"]
    _lengths(of, drift=3, mean=seasons + 1, variance=seasons + 1)
    return _built(seasons + 1, 3, 1, lambda model: lib.kq_model_trend_season_f64(
        model, seasons, _vector(of["drift"]), of["noise"], _vector(of["mean"]), _vector(of["variance"])),
        ["level", "slope", *_effects(seasons)], "trend_season")


def _arma(of: dict[str, Any]) -> dict[str, Any]:
    phi, theta = of.get("phi", np.zeros(0)), of.get("theta", np.zeros(0))
    p, q = len(phi), len(theta)
    if p + q == 0:
        raise ModelError("phi", "neither phi nor theta has a number")
    n = max(p, q + 1)
    if q == 0:
        fill = lambda model: lib.kq_model_ar_f64(model, _vector(phi), p, of["variance"], of["noise"])  # noqa: E731
    elif p == 0:
        fill = lambda model: lib.kq_model_ma_f64(model, _vector(theta), q, of["variance"], of["noise"])  # noqa: E731
    else:
        fill = lambda model: lib.kq_model_arma_f64(  # noqa: E731
            model, _vector(phi), p, _vector(theta), q, of["variance"], of["noise"])
    return _built(n, 1, 1, fill, [f"y{k}" for k in range(n)], "arma")


def _regression(of: dict[str, Any]) -> dict[str, Any]:
    k = len(of["regressors"])
    _lengths(of, drift=k, mean=k, variance=k)
    return _built(k, k, 1, lambda model: lib.kq_model_regression_f64(
        model, _vector(of["regressors"]), k, _vector(of["drift"]), of["noise"], _vector(of["mean"]),
        _vector(of["variance"])), [f"coefficient_{i + 1}" for i in range(k)], "regression")


def _factor(of: dict[str, Any]) -> dict[str, Any]:
    m, k = of["loadings"].shape
    drift = np.ones(k) if of["drift"] is None else of["drift"]
    _lengths({**of, "drift": drift}, transition=k * k, drift=k, noise=m)
    return _built(k, k, m, lambda model: lib.kq_model_factor_f64(
        model, k, m, _vector(of["loadings"]), _vector(of["transition"]), _vector(drift), _vector(of["noise"])),
        [f"factor_{i + 1}" for i in range(k)], "factor")


_NOISE, _DT = Parameter("noise", "number"), Parameter("dt", "number")
_PRIOR = (Parameter("mean", "vector", None), Parameter("variance", "vector", is_prior=True))
_SEASONS = Parameter("seasons", "whole")
_PHI, _THETA = Parameter("phi", "vector"), Parameter("theta", "vector")
_SHOCK = (Parameter("variance", "number"), Parameter("noise", "number", 0.0))
_AXES = (_DT, Parameter("density", "vector"), Parameter("noise", "vector"), *_PRIOR)

BUILDERS: dict[str, Builder] = {
    "level": Builder((Parameter("drift", "number"), _NOISE, Parameter("mean", "number", 0.0),
                      Parameter("variance", "number", is_prior=True)), _level),
    "trend": Builder((Parameter("drift", "vector"), _NOISE, *_PRIOR), _trend),
    "season": Builder((_SEASONS, Parameter("drift", "number"), _NOISE, *_PRIOR), _season),
    "trend_season": Builder((_SEASONS, Parameter("drift", "vector"), _NOISE, *_PRIOR), _trend_season),
    "ar": Builder((_PHI, *_SHOCK), _arma),
    "ma": Builder((_THETA, *_SHOCK), _arma),
    "arma": Builder((_PHI, _THETA, *_SHOCK), _arma),
    "regression": Builder((Parameter("regressors", "vector"), Parameter("drift", "vector"), _NOISE, *_PRIOR),
                          _regression),
    "constant_velocity": Builder(_AXES, _motion(2)),
    "constant_acceleration": Builder(_AXES, _motion(3)),
    "factor": Builder((Parameter("loadings", "matrix"), Parameter("transition", "matrix"),
                       Parameter("drift", "vector", None), Parameter("noise", "vector")), _factor),
}
