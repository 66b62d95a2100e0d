"""A start that is in part unknown, as a start that the E-step can take: variances far beyond what the data say."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from kalmanq.model import Model
from kalmanq.run.filters import Smoother

if TYPE_CHECKING:
    from kalmanq.fitting.expectation import Records

FAR = 1e12  # times the variance of the first state given all rows
EXACT = 1e6  # times the variance of the measurements, of a state that is measured without noise or not at all


def known_start(model: Model, records: Records) -> tuple[np.ndarray, np.ndarray]:
    """x0 (n) and P0 (n x n) with FAR times the smoothed variance for each unknown state, around its smoothed mean.

    The log-likelihood is then the exact one less half the logarithms of these variances, and its gradient the
    exact one but for 1 / FAR of its size: the unknown direction has no slope (Durbin and Koopman 2012, ch. 5).
    """
    means, variances = [], []
    for z, u in zip(records.z, records.u):
        run = Smoother(model).run(z, u)
        means.append(run.smoothed[0])
        variances.append(run.smoothed_sigma[0] ** 2)
    x0, P0 = model.x0.copy(), np.array(model.P0)
    unknown = model.unknown
    mean, variance = np.nanmean(means, axis=0), np.nanmax(variances, axis=0)
    spread = max(float(np.max(np.nanvar(z[:, ~np.all(np.isnan(z), axis=0)], axis=0), initial=0.0))
                 for z in records.z)
    P0[unknown], P0[:, unknown] = 0, 0
    P0[unknown, unknown] = np.fmax(FAR * variance, EXACT * spread)[unknown]
    P0[unknown, unknown] = np.where(P0[unknown, unknown] > 0, P0[unknown, unknown], 1.0)
    x0[unknown] = np.where(np.isfinite(mean), mean, 0.0)[unknown]
    return x0, P0
