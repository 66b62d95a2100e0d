"""Parameters of a model from records: expectation and maximisation, maximum likelihood, standard errors."""

from kalmanq.fitting.em import Estimate, Estimation
from kalmanq.fitting.fit_model import Fit, fit
from kalmanq.fitting.likelihood import gradient, likelihood

__all__ = ["Estimate", "Estimation", "Fit", "fit", "gradient", "likelihood"]
