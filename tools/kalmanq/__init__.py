"""Kalman filters for microcontrollers, on the host: the C core itself over NumPy arrays.

    model = kalmanq.Model(A=[[1, 1], [0, 1]], H=[1, 0], R=4, G=[0.5, 1], P0=[100, 10])
    run = kalmanq.Smoother(model, "f32").run(z)        z: T values, NaN where one is missing
    run.mean, run.sigma, run.smoothed, run.smoothed_sigma, run.log_likelihood.sum()

Results are those of the chip, bit for bit: `Filter(model, "q31").memory` are its words.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:  # for type checkers; at run time a name is imported when it is first used, from its
    # place below; `as` exports it
    from kalmanq.data.rows import Varying as Varying
    from kalmanq.errors import KalmanqError as KalmanqError, KalmanqWarning as KalmanqWarning, ModelError as ModelError
    from kalmanq.fitting import (
        Estimate as Estimate, Estimation as Estimation, Fit as Fit, fit as fit, gradient as gradient,
        likelihood as likelihood)
    from kalmanq.model import Gaps as Gaps, Model as Model, Quantity as Quantity
    from kalmanq.nonlinear import (
        NonlinearFilter as NonlinearFilter, NonlinearModel as NonlinearModel, NonlinearSmoother as NonlinearSmoother)
    from kalmanq.run.correlated import decorrelated as decorrelated
    from kalmanq.run.filters import (
        AdaptiveFilter as AdaptiveFilter, Filter as Filter, LagSmoother as LagSmoother, Smoother as Smoother, run_many as run_many)
    from kalmanq.run.following import InstantSmoother as InstantSmoother, FrozenGainFilter as FrozenGainFilter
    from kalmanq.run.results import Run as Run
    from kalmanq.run.reweighting import ReweightedSmoother as ReweightedSmoother
    from kalmanq.run.robust import Robust as Robust
    from kalmanq.run.series import run_series as run_series
    from kalmanq.run.statistics import Consistency as Consistency, LeastSquares as LeastSquares
    from kalmanq.run.steady import (
        SteadyFilter as SteadyFilter, SteadyState as SteadyState, steady_state as steady_state)

_PLACES = {
    "data.rows": "Varying",
    "errors": "KalmanqError KalmanqWarning ModelError",
    "fitting": "Estimate Estimation Fit fit gradient likelihood",
    "model": "Gaps Model Quantity",
    "nonlinear": "NonlinearFilter NonlinearModel NonlinearSmoother",
    "run.correlated": "decorrelated",
    "run.filters": "AdaptiveFilter Filter LagSmoother Smoother run_many",
    "run.following": "InstantSmoother FrozenGainFilter",
    "run.results": "Run",
    "run.reweighting": "ReweightedSmoother",
    "run.robust": "Robust",
    "run.series": "run_series",
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
