"""Textbook models by name, and the names of what they are given."""

from __future__ import annotations

import difflib
import math
from dataclasses import dataclass
from typing import Any, Callable, Mapping, Optional

import numpy as np

from kalmanq.core import ffi, lib
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

    @property
    def is_needed(self) -> bool:
        return self.default is _NOTHING

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


SEARCHED = ("time_constant", "period", "damping", "length", "sigma", "density", "noise")  # above 0, of continuous time


def searched(given: Optional[Mapping[str, Any]]) -> list[str]:
    """Parameters that can be estimated, of a builder with what its file gives it"""
    of = BUILDERS[given["builder"]].parameters if given else ()
    return [one.name for one in of if one.name in SEARCHED] if any(one is _DT for one in of) else []


# ------------------------------------------------------------------------------ models


class _Refused(Exception):
    """What is wrong, in words."""


def _refusal(status: int) -> _Refused:
    return _Refused(ffi.string(lib.kq_status_text(status)).decode())


def _finite(*values: Any) -> None:
    if not all(np.all(np.isfinite(value)) for value in values):
        raise _refusal(lib.KQ_ERR_NOT_FINITE)


def _roots(variances: Any) -> np.ndarray:
    _finite(variances)
    if np.any(np.asarray(variances) < 0):
        raise _refusal(lib.KQ_ERR_NOT_SEMIDEFINITE)
    return np.sqrt(variances)


class _Model:
    """x[t+1] = A x + G w, w ~ N(0, I), z = H x + v, v ~ N(0, diag R): zeros to be filled in."""

    def __init__(self, n: int, r: int, m: int):
        self.A, self.G, self.H, self.R = np.zeros((n, n)), np.zeros((n, r)), np.zeros((m, n)), np.zeros(m)
        self.x0, self.P0 = np.zeros(n), np.zeros((n, n))

    def prior(self, mean: Optional[np.ndarray], variance: Any) -> None:
        if mean is not None:
            _finite(mean)
            self.x0[:] = mean
        _roots(variance)
        np.fill_diagonal(self.P0, variance)

    def noise(self, variances: Any) -> None:
        _roots(variances)
        self.R[:] = variances


def _built(n: int, r: int, m: int, fill: Callable[[_Model], None], names: list[str], what: str) -> dict[str, Any]:
    for size, of in ((n, "states"), (r, "noises"), (m, "measurements")):
        if not 1 <= size <= lib.KQ_SIZE_MAX:
            raise ModelError("builder", f"{what} would have {size} {of}; there are 1 to {lib.KQ_SIZE_MAX}")
    model = _Model(n, r, m)
    try:
        fill(model)
        _finite(*vars(model).values())
    except _Refused as problem:
        raise ModelError("builder", f"{what}: {problem}") from None
    return {**vars(model), "states": names}


def _lengths(of: dict[str, Any], **lengths: int) -> None:
    for name, length in lengths.items():
        if of[name] is _ONES:
            of[name] = np.ones(max(0, min(length, lib.KQ_SIZE_MAX)))
            continue
        if of[name] is not None and np.size(of[name]) != length:
            raise ModelError(name, f"has {np.size(of[name])} numbers, not {length}")


# ------------------------------------------------------------------------------ continuous time
#
# x' = F x + noise of density: a row is at its time, or dt after the one before.


def _flow(of: dict[str, Any], F: Any, density: Any, H: Any, names: list[str], what: str, P0: Any = None) -> dict[str, Any]:
    """P0: what it settles to, where it does"""
    F, H = np.array(F, float), np.atleast_2d(np.array(H, float))

    def fill(model: _Model) -> None:
        _finite(of["dt"])
        model.A[:], model.H[:] = F, H
        np.fill_diagonal(model.G, _roots(density))
        model.noise(of["noise"])
        if P0 is None:
            model.prior(of["mean"], of["variance"])
        else:
            model.P0[:] = P0

    made = _built(len(F), len(F), len(H), fill, names, what)
    F, G = made.pop("A"), made.pop("G")
    return {**made, "F": F, "Qc": G @ G.T, "dt": of["dt"]}


def _above_0(of: dict[str, Any], *names: str) -> None:
    for name in names:
        if not np.all(np.isfinite(of[name])):
            raise ModelError(name, "is not finite")
        if not np.all(np.asarray(of[name]) > 0):
            raise ModelError(name, "is not above 0")


def _motion(order: int) -> Callable[[dict[str, Any]], dict[str, Any]]:
    """Bar-Shalom, Li and Kirubarajan, Estimation with Applications to Tracking and Navigation (2001), 6.2."""
    words = ("position", "velocity", "acceleration")[:order]

    def build_motion(of: dict[str, Any]) -> dict[str, Any]:
        d = len(of["density"])
        _lengths(of, noise=d, variance=order * d, mean=order * d)
        if d > 3:
            raise ModelError("density", f"has {d} numbers, and space no more than 3 axes")
        names = [word + axis for axis in ([""] if d == 1 else ["_x", "_y", "_z"][:d]) for word in words]
        return _flow(of, np.kron(np.eye(d), np.eye(order, k=1)), np.kron(of["density"], np.eye(order)[-1]), np.eye(order * d)[::order],
                     names, f"constant_{words[-1]}")

    return build_motion


def _random_walk(of: dict[str, Any]) -> dict[str, Any]:
    n = len(of["density"])
    _lengths(of, noise=n, mean=n, variance=n)
    return _flow(of, np.zeros((n, n)), of["density"], np.eye(n), [f"walk_{i + 1}" for i in range(n)], "random_walk")


def _gauss_markov(of: dict[str, Any]) -> dict[str, Any]:
    """x' = -x / tau + noise, of a sigma that it keeps: Ornstein and Uhlenbeck's process"""
    tau = of["time_constant"]
    n = len(tau)
    _lengths(of, sigma=n, noise=n)
    _above_0(of, "time_constant")
    variance = of["sigma"] ** 2
    return _flow(of, np.diag(-1 / tau), 2 * variance / tau, np.eye(n), [f"bias_{i + 1}" for i in range(n)], "gauss_markov",
                 np.diag(variance))


def _clock(of: dict[str, Any]) -> dict[str, Any]:
    """Brown and Hwang, Introduction to Random Signals and Applied Kalman Filtering (2012), 9.3"""
    _lengths(of, density=2, mean=2, variance=2)
    return _flow(of, [[0, 1], [0, 0]], of["density"], [1, 0], ["phase", "frequency"], "clock")


def _oscillator(of: dict[str, Any]) -> dict[str, Any]:
    """x'' = -w^2 x - 2 damping w x' + noise, w = 2 pi / period"""
    _lengths(of, mean=2, variance=2)
    _above_0(of, "period")
    w = 2 * math.pi / of["period"]
    return _flow(of, [[0, 1], [-w * w, -2 * of["damping"] * w]], [0, of["density"]], [1, 0], ["position", "velocity"],
                 "oscillator")


def _gaussian_process(of: dict[str, Any]) -> dict[str, Any]:
    """Matern's kernels as models: Hartikainen and Sarkka, IEEE MLSP (2010)"""
    _above_0(of, "smoothness", "length")
    variance, rate = of["sigma"] ** 2, math.sqrt(2 * of["smoothness"]) / of["length"]
    names = ["value", "slope", "curvature"]
    if of["smoothness"] == 0.5:
        return _flow(of, [[-rate]], [2 * rate * variance], [1], names[:1], "gaussian_process", [[variance]])
    if of["smoothness"] == 1.5:
        return _flow(of, [[0, 1], [-(rate**2), -2 * rate]], [0, 4 * rate**3 * variance], [1, 0], names[:2], "gaussian_process",
                     np.diag([variance, rate**2 * variance]))
    if of["smoothness"] == 2.5:
        bend = rate**2 * variance / 3
        return _flow(of, [[0, 1, 0], [0, 0, 1], [-(rate**3), -3 * rate**2, -3 * rate]], [0, 0, 16 / 3 * rate**5 * variance],
                     [1, 0, 0], names, "gaussian_process", [[variance, 0, -bend], [0, bend, 0], [-bend, 0, rate**4 * variance]])
    raise ModelError("smoothness", "is 0.5, 1.5 or 2.5, Matern's nu")


def _harmonic(has_trend: bool) -> Callable[[dict[str, Any]], dict[str, Any]]:
    """A season as waves of period / 1, period / 2, ...; a level and its slope before it"""

    def build_harmonic(of: dict[str, Any]) -> dict[str, Any]:
        waves, first = of["harmonics"], 2 if has_trend else 0
        _above_0(of, "period", "dt")
        if not 1 <= waves <= of["period"] / of["dt"] / 2:
            raise ModelError("harmonics", "are from 1 to period / dt / 2: rows see no shorter waves")
        n = first + 2 * waves
        _lengths(of, density=1 + first, mean=n, variance=n)
        F, H = np.zeros((n, n)), np.eye(1, n)[0] * first / 2
        F[:first, :first] = np.eye(first, k=1)
        for k in range(waves):
            at = first + 2 * k
            F[at, at + 1] = 2 * math.pi * (k + 1) / of["period"]
            F[at + 1, at], H[at] = -F[at, at + 1], 1
        names = ["level", "slope"][:first] + [f"wave_{k + 1}{part}" for k in range(waves) for part in ("", "_turned")]
        return _flow(of, F, [*of["density"][:first], *[of["density"][-1]] * (2 * waves)], H, names,
                     "trend_harmonic" if has_trend else "harmonic")

    return build_harmonic


# ------------------------------------------------------------------------------ structural models
#
# Harvey, Forecasting, Structural Time Series Models and the Kalman Filter (1989).


def _coefficients(of: dict[str, Any], regressors: Any) -> Callable[[_Model], None]:
    def fill(model: _Model) -> None:
        _finite(regressors)
        np.fill_diagonal(model.A, 1)
        np.fill_diagonal(model.G, _roots(of["drift"]))
        model.H[0] = regressors
        model.noise(of["noise"])
        model.prior(of["mean"], of["variance"])

    return fill


def _level(of: dict[str, Any]) -> dict[str, Any]:
    return _built(1, 1, 1, _coefficients(of, 1.0), ["level"], "level")


def _regression(of: dict[str, Any]) -> dict[str, Any]:
    k = len(of["regressors"])
    _lengths(of, drift=k, mean=k, variance=k)
    names = [f"coefficient_{i + 1}" for i in range(k)]
    return _built(k, k, 1, _coefficients(of, of["regressors"]), names, "regression")


def _structure(has_trend: bool, has_season: bool, what: str) -> Callable[[dict[str, Any]], dict[str, Any]]:
    """A trend, then the effects of a season, whose sum is its noise."""

    def build_structure(of: dict[str, Any]) -> dict[str, Any]:
        first, seasons = 2 if has_trend else 0, of["seasons"] if has_season else 1
        n, noises = first + seasons - 1, first + has_season
        _lengths(of, **({"drift": noises} if has_trend else {}), mean=n, variance=n)

        def fill(model: _Model) -> None:
            roots = _roots(np.ravel(of["drift"]))
            if has_trend:
                model.A[:2, :2] = [[1, 1], [0, 1]]
                model.G[0, 0], model.G[1, 1], model.H[0, 0] = roots[0], roots[1], 1
            if has_season:
                if seasons < 2:
                    raise _refusal(lib.KQ_ERR_SIZE)
                model.A[first, first:] = -1
                for i in range(first + 1, len(model.A)):
                    model.A[i, i - 1] = 1
                model.G[first, first], model.H[0, first] = roots[-1], 1
            model.noise(of["noise"])
            model.prior(of["mean"], of["variance"])

        effects = ["season", *(f"season_{k}_before" for k in range(1, seasons - 1))] if has_season else []
        return _built(n, noises, 1, fill, ["level", "slope"][:first] + effects, what)

    return build_structure


# ------------------------------------------------------------------------------ stationary models


def _autocovariances(count: int, phi: list[float], variance: float) -> list[float]:
    """Of an autoregression: partial autocorrelations k by Durbin's recursion backwards, all below 1 in size if and only
    if it is stationary; then Levinson's recursion (Hamilton, Time Series Analysis, 1994, 3.4)."""
    k = list(phi)
    for j in range(len(phi) - 1, -1, -1):
        rest = (1 - k[j]) * (1 + k[j])
        if not rest > 0:
            raise _Refused("the model is not stationary: take a smaller phi")
        k[:j] = [(k[i] + k[j] * k[j - 1 - i]) / rest for i in range(j)]
    spread = variance
    for one in k:
        spread /= (1 - one) * (1 + one)
    gamma, a = [spread], []  # a: the autoregression of the order so far
    for j in range(1, count):
        own = k[j - 1] if j <= len(phi) else 0.0
        gamma.append(own * spread + sum(one * gamma[j - 1 - i] for i, one in enumerate(a)))
        if j <= len(phi):
            a = [one - own * back for one, back in zip(a, reversed(a))] + [own]
            spread *= (1 - own) * (1 + own)
    return gamma


def _arma(of: dict[str, Any]) -> dict[str, Any]:
    phi, theta = of.get("phi", np.zeros(0)), of.get("theta", np.zeros(0))
    p, q = len(phi), len(theta)
    if p + q == 0:
        raise ModelError("phi", "neither phi nor theta has a number")
    n = max(p, q + 1)

    def fill(model: _Model) -> None:
        """The states are past values of the autoregression; of a moving average past noises, the newest last."""
        _finite(phi, theta)
        root = _roots(of["variance"])
        if p:
            lag = np.abs(np.subtract.outer(range(n), range(n)))
            model.P0[:] = np.array(_autocovariances(n, phi.tolist(), of["variance"]))[lag]
            model.A[0, :p], model.G[0, 0] = phi, root
            model.A[range(1, n), range(n - 1)] = 1
            model.H[0, : q + 1] = [1, *theta]
        else:
            np.fill_diagonal(model.P0, of["variance"])
            model.A[range(q), range(1, n)], model.G[q, 0] = 1, root
            model.H[0] = [*theta[::-1], 1]
        model.noise(of["noise"])

    return _built(n, 1, 1, fill, [f"y{k}" for k in range(n)], "arma")


def stationary_covariance(A: np.ndarray, Q: np.ndarray) -> np.ndarray:
    """P = A P A' + Q, summed by doubling: positive semi-definite by construction.  Smith, Matrix equation X A + B X = C,
    SIAM J. Appl. Math. 16 (1968)."""
    P, M = np.array(Q, float), np.array(A, float)
    with np.errstate(all="ignore"):
        for _ in range(_DOUBLINGS):
            if not np.finfo(float).eps * np.abs(M * M.T).sum() < 1:
                break  # the rounding of M M is as large as what may be left
            P = P + M @ P @ M.T
            P, M = (P + P.T) / 2, M @ M
            if np.all(np.abs(M) < _NOTHING_LEFT):
                _finite(P)
                return P
    raise _Refused("the model is not stationary")


_DOUBLINGS, _NOTHING_LEFT = 50, 2.0**-200  # after more, what has decayed was rounding


def _factor(of: dict[str, Any]) -> dict[str, Any]:
    m, k = of["loadings"].shape
    drift = np.ones(k) if of["drift"] is None else of["drift"]
    _lengths({**of, "drift": drift}, transition=k * k, drift=k, noise=m)

    def fill(model: _Model) -> None:
        _finite(of["loadings"], of["transition"])
        np.fill_diagonal(model.G, _roots(drift))
        model.A[:], model.H[:] = np.reshape(of["transition"], (k, k)), of["loadings"]
        model.noise(of["noise"])
        model.P0[:] = stationary_covariance(model.A, np.diag(drift))

    return _built(k, k, m, fill, [f"factor_{i + 1}" for i in range(k)], "factor")


_NOISE, _DT = Parameter("noise", "number"), Parameter("dt", "number")
_PRIOR = (Parameter("mean", "vector", None), Parameter("variance", "vector", is_prior=True))
_SEASONS = Parameter("seasons", "whole")
_PHI, _THETA = Parameter("phi", "vector"), Parameter("theta", "vector")
_SHOCK = (Parameter("variance", "number"), Parameter("noise", "number", 0.0))
_AXES = (_DT, Parameter("density", "vector"), Parameter("noise", "vector"), *_PRIOR)
_WAVES = (_DT, Parameter("period", "number"), Parameter("harmonics", "whole"), Parameter("density", "vector"), _NOISE, *_PRIOR)

BUILDERS: dict[str, Builder] = {
    "level": Builder((Parameter("drift", "number"), _NOISE, Parameter("mean", "number", 0.0),
                      Parameter("variance", "number", is_prior=True)), _level),
    "trend": Builder((Parameter("drift", "vector"), _NOISE, *_PRIOR), _structure(True, False, "trend")),
    "season": Builder((_SEASONS, Parameter("drift", "number"), _NOISE, *_PRIOR), _structure(False, True, "season")),
    "trend_season": Builder((_SEASONS, Parameter("drift", "vector"), _NOISE, *_PRIOR), _structure(True, True, "trend_season")),
    "ar": Builder((_PHI, *_SHOCK), _arma),
    "ma": Builder((_THETA, *_SHOCK), _arma),
    "arma": Builder((_PHI, _THETA, *_SHOCK), _arma),
    "regression": Builder((Parameter("regressors", "vector"), Parameter("drift", "vector"), _NOISE, *_PRIOR),
                          _regression),
    "constant_velocity": Builder(_AXES, _motion(2)),
    "constant_acceleration": Builder(_AXES, _motion(3)),
    "random_walk": Builder(_AXES, _random_walk),
    "gauss_markov": Builder((_DT, Parameter("time_constant", "vector"), Parameter("sigma", "vector"),
                             Parameter("noise", "vector")), _gauss_markov),
    "clock": Builder((_DT, Parameter("density", "vector"), _NOISE, *_PRIOR), _clock),
    "oscillator": Builder((_DT, Parameter("period", "number"), Parameter("damping", "number", 0.0),
                           Parameter("density", "number"), _NOISE, *_PRIOR), _oscillator),
    "gaussian_process": Builder((_DT, Parameter("smoothness", "number"), Parameter("length", "number"),
                                 Parameter("sigma", "number"), _NOISE), _gaussian_process),
    "harmonic": Builder(_WAVES, _harmonic(False)),
    "trend_harmonic": Builder(_WAVES, _harmonic(True)),
    "factor": Builder((Parameter("loadings", "matrix"), Parameter("transition", "matrix"),
                       Parameter("drift", "vector", None), Parameter("noise", "vector")), _factor),
}
