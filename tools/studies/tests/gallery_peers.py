"""gallery_peers.py FITTED.json: every log-likelihood of the gallery by statsmodels, at the same parameters.

The class that a user of statsmodels would take: UnobservedComponents, SARIMAX, RecursiveLS, DynamicFactor; where there
is none, an MLEModel with the matrices.  No parameter that is fitted may be moved by 1 % to a higher likelihood.
"""

from __future__ import annotations

import json
import sys
import warnings
from typing import Any, Callable

import numpy as np
import statsmodels.api as sm
from statsmodels.tsa.statespace.mlemodel import MLEModel

SAME = 1e-8  # of a log-likelihood, relative
SAME_STATES = 1e-6  # of smoothed states, in their sigma
BETTER = 1e-3  # of log-likelihood, that a parameter moved by 1 % may give
HEARD = 1e-7  # of log-likelihood, that it changes at least
Likelihood = Callable[[dict[str, Any]], float]


def structural(of: dict[str, Any], drift: list[str], **components: Any) -> Likelihood:
    """drift: statsmodels' names of ours; the start is exactly diffuse"""
    model = sm.tsa.UnobservedComponents(of["z"], use_exact_diffuse=True, **components)
    names = {"drift": [f"sigma2.{name}" for name in drift], "noise": ["sigma2.irregular"]}
    return lambda given: model.loglike(ordered(model, given, names))


def sarimax(of: dict[str, Any], p: int, q: int, **more: Any) -> Likelihood:
    model = sm.tsa.SARIMAX(of["z"], order=(p, 0, q), trend="n", **more)
    names = {"phi": [f"ar.L{k + 1}" for k in range(p)], "theta": [f"ma.L{k + 1}" for k in range(q)],
             "variance": ["sigma2"], "noise": ["var.measurement_error"]}
    used = {ours: theirs for ours, theirs in names.items() if ours in of["free"]}
    return lambda given: model.loglike(ordered(model, given, used))


def ordered(model: Any, given: dict[str, Any], names: dict[str, Any]) -> np.ndarray:
    """Our parameters as statsmodels orders its own; each of both is used once."""
    values: dict[str, float] = {}
    for ours, theirs in names.items():
        numbers = np.ravel(given[ours])
        assert len(numbers) == len(theirs), (ours, theirs)
        values.update(zip(theirs, numbers))
    assert sorted(values) == sorted(model.param_names), (sorted(values), model.param_names)
    return np.array([values[name] for name in model.param_names])


def recursive_least_squares(of: dict[str, Any]) -> Likelihood:
    model = sm.RecursiveLS(of["z"], of["regressors"])

    def likelihood(given: dict[str, Any]) -> float:
        with model.ssm.fixed_scale(given["noise"]):
            return float(model.ssm.loglike())

    return likelihood


def factor(of: dict[str, Any]) -> Likelihood:
    model = sm.tsa.DynamicFactor(of["z"], k_factors=1, factor_order=1)
    names = {"loadings": [f"loading.f1.y{k}" for k in (1, 2, 3)], "noise": [f"sigma2.y{k}" for k in (1, 2, 3)],
             "transition": ["L1.f1.f1"]}
    return lambda given: model.loglike(ordered(model, given, names))


class Matrices(MLEModel):
    """A model as it is; a regressors' row is its H."""

    def __init__(self, of: dict[str, Any], Q: np.ndarray, R: np.ndarray):
        super().__init__(of["z"], k_states=len(of["A"]), k_posdef=len(Q))
        self["transition"], self["selection"], self["state_cov"] = of["A"], np.eye(len(of["A"])), Q
        self["design"] = of["H"] if of["regressors"] is None else of["regressors"].T[None]
        self["obs_cov"] = R
        self.ssm.tolerance = 0  # it would take a covariance for settled before it is
        if of["unknown"]:
            self.ssm.initialize("diffuse")
        else:
            self.ssm.initialize_known(of["x0"], of["P0"])

    def update(self, params: Any, **_: Any) -> None:
        """There are none."""


def by_matrices(of: dict[str, Any], Q: Callable[[dict[str, Any]], np.ndarray]) -> Likelihood:
    return lambda given: Matrices(of, Q(given), np.diag(np.atleast_1d(given["noise"]))).ssm.loglike()


def motion(dt: float, density: np.ndarray, order: int) -> np.ndarray:
    """The noise of each axis, integrated over dt"""
    q = {2: [[dt**3 / 3, dt**2 / 2], [dt**2 / 2, dt]],
         3: [[dt**5 / 20, dt**4 / 8, dt**3 / 6], [dt**4 / 8, dt**3 / 3, dt**2 / 2], [dt**3 / 6, dt**2 / 2, dt]]}[order]
    return np.kron(np.diag(density), q)


PEERS: dict[str, Callable[[dict[str, Any]], Likelihood]] = {
    "level": lambda of: structural(of, ["level"], level="llevel"),
    "trend": lambda of: structural(of, ["level", "trend"], level="lltrend"),
    "season": lambda of: structural(of, ["seasonal"], irregular=True, seasonal=4),
    "trend-season": lambda of: structural(of, ["level", "trend", "seasonal"], level="lltrend", seasonal=12),
    "ar": lambda of: sarimax(of, 2, 0),
    "ar-noise": lambda of: sarimax(of, 1, 0, measurement_error=True),
    "ma": lambda of: sarimax(of, 0, 2),
    "arma": lambda of: sarimax(of, 1, 1),
    "regression": recursive_least_squares,
    "regression-drifting": lambda of: by_matrices(of, lambda given: np.diag(given["drift"])),
    "factor": factor,
    "constant-velocity": lambda of: by_matrices(of, lambda given: motion(given["dt"], given["density"], 2)),
    "constant-acceleration": lambda of: by_matrices(of, lambda given: motion(given["dt"], given["density"], 3)),
}


def moved_by_a_percent(likelihood: Likelihood, of: dict[str, Any]) -> np.ndarray:
    """What each parameter of those that are fitted gains where it is moved by 1 % of its size, either way"""
    best, gains = likelihood(of["parameters"]), []
    for name in of["free"]:
        value = np.array(of["parameters"][name], float)
        for k in np.ndindex(value.shape):
            for factor_ in (0.99, 1.01):
                moved = value.copy()
                moved[k] *= factor_
                changed = {**of["parameters"], name: moved.tolist()}
                gains.append(likelihood(changed) - best)
    return np.array(gains)


def arrays(of: dict[str, Any]) -> dict[str, Any]:
    for name in ("z", "regressors", "A", "Q", "H", "R", "x0", "P0", "smoothed", "smoothed_sigma"):
        of[name] = None if of[name] is None else np.array(of[name], float)
    return of


def states_apart(of: dict[str, Any]) -> float:
    """Of all smoothed states beside those of the matrices by statsmodels: means in sigma, variances in sigma^2, which
    is taken for at least a thousandth of the state's own size: in ARMA models without noise it is 0."""
    smoothed = Matrices(of, of["Q"], of["R"]).ssm.smooth()
    sigma = np.maximum(of["smoothed_sigma"], 1e-3 * np.sqrt(np.mean(of["smoothed"] ** 2, axis=0)))
    variance = np.diagonal(smoothed.smoothed_state_cov, axis1=0, axis2=1)
    return float(max(np.max(np.abs(smoothed.smoothed_state.T - of["smoothed"]) / sigma),
                     np.max(np.abs(variance - of["smoothed_sigma"] ** 2) / sigma**2)))


def main() -> None:
    warnings.simplefilter("ignore")
    with open(sys.argv[1], encoding="utf-8") as text:
        entries = json.load(text)
    faults = 0
    for name, given in entries.items():
        of = arrays(given)
        likelihood = PEERS[name](of)
        theirs = likelihood(of["parameters"])
        apart = abs(theirs - of["log_likelihood"]) / abs(theirs)
        gains, states = moved_by_a_percent(likelihood, of), states_apart(of)
        deaf = np.min(np.abs(gains)) < HEARD  # statsmodels has not got that parameter
        wrong = deaf or not apart < SAME or not gains.max() < BETTER or not states < SAME_STATES
        faults += wrong
        print(f"{name:22} {of['log_likelihood']:.8f} statsmodels {theirs:.8f}: apart {apart:.1e}, "
              f"uphill {gains.max():.1e}, smoothed states {states:.1e} sigma{'  WRONG' if wrong else ''}")
    print(f"{len(entries)} models, {faults} unlike statsmodels")
    sys.exit(faults > 0 or len(entries) < 12)


if __name__ == "__main__":
    main()
