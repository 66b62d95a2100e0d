"""The likelihood of records and its gradient."""

from __future__ import annotations

from typing import Optional, Sequence, Union

import numpy as np
from numpy.typing import ArrayLike

from kalmanq.core import require
from kalmanq.data.rows import Varying
from kalmanq.errors import KalmanqError
from kalmanq.fitting.equations import likelihood_of
from kalmanq.fitting.expectation import FREE, Expectation, Records
from kalmanq.fitting.slopes import agrees, exact
from kalmanq.model import ColumnModel, Model
from kalmanq.model.column_model import refuse_rows
from kalmanq.nonlinear import NonlinearModel
from kalmanq.run.filters import Filter
from kalmanq.run.parts import Parts


def likelihood(model: Union[Model, NonlinearModel], records: Sequence[ArrayLike],
               u: Optional[Sequence[Optional[ArrayLike]]] = None, *, times: Optional[Sequence[Optional[ArrayLike]]] = None,
               varying: Optional[Sequence[Varying]] = None, arithmetic: str = "f64") -> float:
    """log p of all records, by the filter; an unknown start is exact: in f64 by covariances (slopes.h), where the filter's roots round.

    Parameters
    ----------
    model : Model or NonlinearModel
    records : each T x m; NaN: missing
    u, times, varying : of each record, as Filter.run has them
    arithmetic : "f64", "f32" or "q31"

    Examples
    --------
    >>> round(kalmanq.likelihood(kalmanq.Model([1], H=[1], R=1, Q=1, P0=1), [[1.0, 2.0]]), 3)
    -3.343
    """
    if isinstance(model, NonlinearModel):
        return likelihood_of(model, Records(model, records, u, times), arithmetic)
    made = Records(model, records, u, times, varying)
    parts = Parts(model.frame, arithmetic)
    total = 0.0
    for k, (z, controls) in enumerate(zip(made.z, made.u)):
        run = Filter(model, arithmetic, parts=parts)
        run.run(z, controls, times=made.times and made.times[k], varying=varying and varying[k])
        total += run.log_likelihood
    if arithmetic != "f64" or varying is not None or isinstance(model, ColumnModel) or not np.any(model.unknown):
        return total
    value = exact(model, made.rows(model))
    return value if agrees(value, total, True) else total


def gradient(model: Model, records: Sequence[ArrayLike], u: Optional[Sequence[Optional[ArrayLike]]] = None, *,
             of: Sequence[str] = ("Q", "R"), arithmetic: str = "f64") -> dict[str, np.ndarray]:
    """Derivatives of the log-likelihood to the entries of `of`, arrays of their shapes, by Fisher's identity (Segal and Weinstein 1989).

    Parameters
    ----------
    model : Model
    records, u : each T x m (NaN: missing), and T x l or None
    of : of A, H, Q, R, x0, P0.  Of a covariance the entries are taken for independent, so that along a symmetric change E of Q the
        slope is sum_ij gradient["Q"]_ij E_ij; NaN where the noise is singular
    arithmetic : "f64" or "f32"

    Raises
    ------
    KalmanqError
        a name that has no derivatives, records at irregular times

    Examples
    --------
    >>> kalmanq.gradient(kalmanq.Model([1], H=[1], R=1, Q=1, P0=1), [[0.0, 0.0]], of=["R"])["R"].round(3)
    array([[-0.5]])
    """
    for name in of:
        if name not in FREE:
            raise KalmanqError(f"{name} has no derivatives: {', '.join(FREE)}")
    refuse_rows(model, "gradient", "kalmanq.fit has it")
    made = Records(model, records, u)
    made.require_steps("gradient")
    if model.d is not None:
        model, made.z = model.changed(d=None), [one - model.d for one in made.z]
    expectation = Expectation(model, made, free=of, noise=(None, model.Q),
                              arithmetic=arithmetic)
    require(expectation.status, "gradient")
    require(expectation.run(), "gradient")
    return {name: array.copy() for name, array in expectation.gradient().items() if name in of}
