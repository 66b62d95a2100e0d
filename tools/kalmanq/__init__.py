"""Kalman filters for microcontrollers, at a desk: the C core itself over NumPy arrays.

    model = kalmanq.Model(A=[[1, 1], [0, 1]], H=[1, 0], R=4, G=[0.5, 1], P0=[100, 10])
    run = kalmanq.Smoother(model, "f32").run(z)        z: T values, NaN where one is missing
    run.mean, run.sigma, run.smoothed, run.smoothed_sigma, run.log_likelihood.sum()

Results are those of the chip, bit for bit: `Filter(model, "q31").memory` are its words.
"""

from kalmanq.errors import KalmanqError, KalmanqWarning, ModelError
from kalmanq.fitting import Estimate, Estimation, Fit, fit, gradient, likelihood
from kalmanq.model import Gaps, Model, Quantity
from kalmanq.nonlinear import NonlinearFilter, NonlinearModel, NonlinearSmoother
from kalmanq.run.filters import AdaptiveFilter, Filter, LagSmoother, Robust, Smoother, run_many
from kalmanq.run.following import PointSmoother, SettlingFilter
from kalmanq.run.results import Run
from kalmanq.run.reweighting import ReweightedSmoother
from kalmanq.run.statistics import Consistency, LeastSquares
from kalmanq.run.steady import SteadyFilter, SteadyState, steady_state
from kalmanq.run.varying import VaryingSmoother

__all__ = [
    "AdaptiveFilter", "Consistency", "Estimate", "Estimation", "Filter", "Fit", "Gaps", "KalmanqError",
    "KalmanqWarning", "LagSmoother", "LeastSquares", "Model", "ModelError", "NonlinearFilter", "NonlinearModel",
    "NonlinearSmoother", "PointSmoother", "Quantity", "ReweightedSmoother", "Robust", "Run", "SettlingFilter",
    "Smoother", "SteadyFilter", "SteadyState", "VaryingSmoother", "fit", "gradient", "likelihood", "run_many",
    "steady_state",
]
