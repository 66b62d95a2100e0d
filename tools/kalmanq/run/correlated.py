"""Process noise that is correlated with the noise of the measurement before the step, E w[t] v[t]' = S."""

from __future__ import annotations

from typing import Any, Optional

import numpy as np
from numpy.typing import ArrayLike

from kalmanq.data.rows import Varying, controls_of, present_of, rows_of
from kalmanq.errors import KalmanqError, ModelError
from kalmanq.model import Model, Quantity
from kalmanq.model.column_model import refuse_rows

NEGATIVE = 1e-9  # an eigenvalue of the joint correlations: no covariance


def decorrelated(model: Model, S: ArrayLike, z: ArrayLike, u: Optional[ArrayLike] = None) -> tuple[Model, np.ndarray, Optional[Varying]]:
    """An equal model whose noises are independent, its controls, and what varies, of E w[t] v[t]' = S.

    A* = A - K H, B* = [B, K], Q* = Q - K S' with K = S R^-1, and the measurements are controls of the step after them.
    What is missing tells nothing of w, so the step after such a row has other matrices (varying).

    Parameters
    ----------
    model : Model of steps
    S : n x m; Q, S and R together are positive semidefinite
    z, u : T x m (NaN: missing) and T x l, as Filter.run has them

    Raises
    ------
    KalmanqError
        a model in continuous time, an S that is no covariance of w and v

    Examples
    --------
    >>> z = [1.0, 2.0, 3.0]
    >>> equal, controls, varying = kalmanq.decorrelated(kalmanq.Model([1], H=[1], R=1, Q=1, P0=1), [[0.5]], z)
    >>> kalmanq.Smoother(equal).run(z, controls, varying=varying).smoothed.shape
    (3, 1)
    """
    if model.continuous is not None:
        raise KalmanqError("S: of a model of steps, A and Q: in continuous time a step has no noise of one instant")
    refuse_rows(model, "S", "leave D out, and give z - D u" if model.D is not None else "it is of one model for all rows")
    made = _array(model, S)
    rows, controls = rows_of(z, model.measurements, "z"), controls_of(u, model, len(z))  # type: ignore[arg-type]
    given = np.nan_to_num(rows - (0.0 if model.d is None else model.d))
    given = given if controls is None else np.hstack([controls, given])
    masks, which = np.unique(np.append(present_of(rows), (1 << model.m) - 1), return_inverse=True)
    steps = [_step(model, made, np.flatnonzero(int(mask) >> np.arange(model.m) & 1)) for mask in masks]
    A, B, Q = (np.stack(one) for one in zip(*steps))
    equal = Model(A[-1], H=model.H, R=model.R, Q=Q[-1], B=B[-1], d=model.d, x0=model.x0, P0=model.P0, unknown=np.flatnonzero(model.unknown).tolist(),
                  states=model.states, measurements=model.measurements, controls=_controls(model), gaps=model.gaps, name=model.name)
    at = which[:-1]
    return equal, given, Varying(A=A[at], B=B[at], Q=Q[at]) if np.any(at != len(masks) - 1) else None


def _array(model: Model, S: ArrayLike) -> np.ndarray:
    try:
        made = np.asarray(S, float).reshape(model.n, model.m)
    except (TypeError, ValueError):
        raise ModelError("S", f"is not {model.n} x {model.m} numbers") from None
    if not np.all(np.isfinite(made)):
        raise ModelError("S", "has an entry that is not finite")
    joint = np.block([[model.Q, made], [made.T, model.R]])
    sigma = np.sqrt(np.diag(joint))
    unit = np.where(sigma > 0, sigma, 1)
    if np.any(made[np.outer(sigma[:model.n], sigma[model.n:]) == 0]) or \
            np.linalg.eigvalsh(joint / np.outer(unit, unit))[0] < -NEGATIVE:
        raise ModelError("S", "Q, S and R together are not positive semidefinite")
    return made


def _step(model: Model, S: np.ndarray, there: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A*, B*, Q* after a row with these components"""
    K = np.zeros_like(S)
    K[:, there] = S[:, there] @ np.linalg.pinv(model.R[np.ix_(there, there)], hermitian=True) if len(there) else 0
    sigma = np.sqrt(np.diag(model.Q))
    unit = np.where(sigma > 0, sigma, 1.0)[:, None]  # so that no state loses what is small beside the others
    k, s = K.astype(np.longdouble), S.astype(np.longdouble)  # what is left may be far less than Q
    left = (model.Q - k @ s.T - (s - k @ model.R) @ k.T).astype(float)
    values, vectors = np.linalg.eigh(left / (unit * unit.T))
    Q = unit * ((vectors * values.clip(0)) @ vectors.T) * unit.T
    return model.A - K @ model.H, K if model.B is None else np.hstack([model.B, K]), (Q + Q.T) / 2


def _controls(model: Model) -> list[Quantity]:
    """The model's, the 1 of an offset among them, and the measurements without theirs"""
    offsets = np.zeros(model.m) if model.d is None else np.abs(model.d)
    own = [Quantity("offset", range=one.range, fraction=one.fraction) if one.constant else one for one in model.controls]
    return own + [Quantity(f"{one.name} before", one.unit, None if one.range is None else one.range + float(d))
                  for one, d in zip(model.measurements, offsets)]
