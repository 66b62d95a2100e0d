"""The joint normal of all states and all measurements of a record, conditioned once: by matrices of long double, without a
filter."""

from __future__ import annotations

from typing import NamedTuple, Optional

import numpy as np

LONG = np.longdouble


class Steps(NamedTuple):
    """T of each matrix: A, B, Q of the step from row t to row t + 1; H, R of row t"""

    A: np.ndarray
    B: Optional[np.ndarray]
    Q: np.ndarray
    H: np.ndarray
    R: np.ndarray


class Dense(NamedTuple):
    mean: np.ndarray  # T x n, given rows up to t
    covariance: np.ndarray
    smoothed: np.ndarray  # given all rows
    smoothed_covariance: np.ndarray
    log_likelihood: LONG


def cholesky(P: np.ndarray) -> np.ndarray:
    L = np.zeros(P.shape, LONG)
    for j in range(len(P)):
        L[j, j] = np.sqrt(P[j, j] - L[j, :j] @ L[j, :j])
        L[j + 1:, j] = (P[j + 1:, j] - L[j + 1:, :j] @ L[j, :j]) / L[j, j]
    return L


def forward(L: np.ndarray, b: np.ndarray) -> np.ndarray:
    x = np.array(b, LONG)
    for k in range(len(L)):
        x[k] = (x[k] - L[k, :k] @ x[:k]) / L[k, k]
    return x


def joint(x0, P0, s: Steps, T: int, u) -> tuple[np.ndarray, np.ndarray]:
    """Mean (T n) and covariance (T n x T n) of all states"""
    n = len(x0)
    mean, C = np.zeros(T * n, LONG), np.zeros((T * n, T * n), LONG)
    mean[:n], C[:n, :n] = x0, P0
    for t in range(T - 1):
        now, then, before = slice(t * n, t * n + n), slice(t * n + n, t * n + 2 * n), slice(0, t * n + n)
        A = s.A[t].astype(LONG)
        mean[then] = A @ mean[now]
        if u is not None:
            mean[then] += s.B[t].astype(LONG) @ u[t].astype(LONG)
        C[then, before] = A @ C[now, before]
        C[before, then] = C[then, before].T
        C[then, then] = A @ C[now, now] @ A.T + s.Q[t].astype(LONG)
    return mean, C


def conditioned(x0, P0, s: Steps, z, u=None) -> Dense:
    T, n, m = len(z), len(x0), z.shape[1]
    mean, C = joint(x0, P0, s, T, u)
    H = np.zeros((T * m, T * n), LONG)
    R = np.zeros((T * m, T * m), LONG)
    for t in range(T):
        H[t * m:t * m + m, t * n:t * n + n], R[t * m:t * m + m, t * m:t * m + m] = s.H[t], s.R[t]
    there = ~np.isnan(z).ravel()
    H, R = H[there], R[np.ix_(there, there)]
    ends = np.concatenate([[0], np.cumsum(there.reshape(T, m).sum(axis=1))])
    L = cholesky(H @ C @ H.T + R)
    e = forward(L, z.ravel()[there].astype(LONG) - H @ mean)
    G = forward(L, H @ C)  # rows of it: what each measurement says of all states, after those before it
    made = Dense(*(np.zeros(shape, LONG) for shape in ((T, n), (T, n, n), (T, n), (T, n, n))),
                 -(e @ e) / 2 - np.sum(np.log(np.diag(L))) - len(e) * np.log(2 * LONG(np.pi)) / 2)
    for t in range(T):
        here = slice(t * n, t * n + n)
        for m_, P_, k in ((made.mean, made.covariance, ends[t + 1]), (made.smoothed, made.smoothed_covariance, len(e))):
            g = G[:k, here]
            m_[t], P_[t] = mean[here] + g.T @ e[:k], C[here, here] - g.T @ g
    return made
