"""Kalman filters for microcontrollers, on the host: the C core itself over NumPy arrays.

    model = kalmanq.Model(A=[[1, 1], [0, 1]], H=[1, 0], R=4, G=[0.5, 1], P0=[100, 10])
    run = kalmanq.Smoother(model, "f32").run(z)        z: T values, NaN where one is missing
    run.mean, run.sigma, run.smoothed, run.smoothed_sigma, run.log_likelihood.sum()

Results are those of the chip, bit for bit: `Filter(model, "q31").memory` are its words.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:  # for type checkers; at run time a name is imported when it is first used, from its place below
    from kalmanq.data.rows import Varying
    from kalmanq.errors import KalmanqError, KalmanqWarning, ModelError
    from kalmanq.fitting import Estimate, Estimation, Fit, fit, gradient, likelihood
    from kalmanq.model import Gaps, Model, Quantity
    from kalmanq.nonlinear import NonlinearFilter, NonlinearModel, NonlinearSmoother
    from kalmanq.run.correlated import decorrelated
    from kalmanq.run.filters import AdaptiveFilter, Filter, LagSmoother, Robust, Smoother, run_many
    from kalmanq.run.following import InstantSmoother, FrozenGainFilter
    from kalmanq.run.results import Run
    from kalmanq.run.reweighting import ReweightedSmoother
    from kalmanq.run.statistics import Consistency, LeastSquares
    from kalmanq.run.steady import SteadyFilter, SteadyState, steady_state

_PLACES = {
    "data.rows": "Varying",
    "errors": "KalmanqError KalmanqWarning ModelError",
    "fitting": "Estimate Estimation Fit fit gradient likelihood",
    "model": "Gaps Model Quantity",
    "nonlinear": "NonlinearFilter NonlinearModel NonlinearSmoother",
    "run.correlated": "decorrelated",
    "run.filters": "AdaptiveFilter Filter LagSmoother Robust Smoother run_many",
    "run.following": "InstantSmoother FrozenGainFilter",
    "run.results": "Run",
    "run.reweighting": "ReweightedSmoother",
    "run.statistics": "Consistency LeastSquares",
    "run.steady": "SteadyFilter SteadyState steady_state",
}
_PLACE = {name: place for place, names in _PLACES.items() for name in names.split()}
__all__ = sorted(_PLACE)


def __getattr__(name: str) -> Any:
    if name in _PLACE:
        globals()[name] = found = getattr(import_module(f"kalmanq.{_PLACE[name]}"), name)
        return found
    try:
        return import_module(f"kalmanq.{name}")  # a folder or a module
    except ModuleNotFoundError as problem:
        if problem.name != f"kalmanq.{name}":
            raise
        raise AttributeError(f"module 'kalmanq' has no attribute {name!r}") from None


def __dir__() -> list[str]:
    return [*globals(), *__all__]
