"""Nonlinear models: filters and smoothers of functions f and h, over the C core's extended.h and sigma_points.h."""

from kalmanq.nonlinear.file import read
from kalmanq.nonlinear.filters import NonlinearFilter
from kalmanq.nonlinear.jacobians import prior_points, wrong_entries
from kalmanq.nonlinear.model import NonlinearModel
from kalmanq.nonlinear.simulation import simulate
from kalmanq.nonlinear.smoothers import NonlinearSmoother

__all__ = ["NonlinearFilter", "NonlinearModel", "NonlinearSmoother", "prior_points", "read", "simulate",
           "wrong_entries"]
