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
    from kalmanq.model.textbook import (
        ar as ar, arma as arma, clock as clock, constant_acceleration as constant_acceleration, constant_velocity as constant_velocity,
        factor as factor, gauss_markov as gauss_markov, gaussian_process as gaussian_process, harmonic as harmonic, level as level,
        ma as ma, oscillator as oscillator, random_walk as random_walk, regression as regression, season as season, trend as trend,
        trend_harmonic as trend_harmonic, trend_season as trend_season)
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
    "model.textbook": "ar arma clock constant_acceleration constant_velocity factor gauss_markov gaussian_process harmonic "
                      "level ma oscillator random_walk regression season trend trend_harmonic trend_season",
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
        classes = import_module("kalmanq.model.spellings").CLASSES
        said = f": take kalmanq.{classes[name]}" if name in classes else ""
        raise AttributeError(f"module 'kalmanq' has no attribute {name!r}{said}") from None


def __dir__() -> list[str]:
    return [*globals(), *__all__]
