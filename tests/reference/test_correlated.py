"""kq_process_init_correlated beside the dense joint normal law of all states and measurements, on random models.

  test_correlated.py LIBRARY [--models N] [--seed N]     LIBRARY: kalmanq as a shared library

The law is conditioned on one measured number after the other, in long double: filtered, predicted and smoothed (a lag)
means in sigma, covariances in sigma_i sigma_j, log-likelihood.  Two fifths of the components are missing.  In each third
model the joint covariance of both noises is singular; there sigma is that of a state and one step's noise together, since
Q - S R^-1 S' is known to eps Q alone.  In another third all components are there, and leave 1e-6 to 1e-3 of Q, as far as
rounding Q, S and R has left a covariance.  There filtered and predicted covariances alone are in sigmas of their own.
"""

from __future__ import annotations

import argparse

import numpy as np

from shared_library import Library

STEPS = 12
GOALS = {"f64": 1e-12, "f32": 2e-4}


def random_model(random, k, number):
    n, m, l = (int(random.integers(*sizes)) for sizes in ((1, 7), (1, 4), (0, 3)))
    A = random.standard_normal((n, n))
    A *= random.uniform(0.5, 1.2) / np.linalg.norm(A, 2)
    scale = np.diag(10 ** random.uniform(-1, 1, n + m))
    F = random.standard_normal((n + m, m + n // 2 if k % 3 == 0 else n + m + 2))
    if k % 3 == 1:
        F[:n] = random.standard_normal((n, m)) @ F[n:] / np.sqrt(n + m) + 10 ** random.uniform(-3, -1.5) * F[:n]
    F = scale @ F
    P0 = random.standard_normal((n, n))
    given = A, random.standard_normal((n, l)), random.standard_normal((m, n)), F @ F.T, P0 @ P0.T + np.eye(n), random.standard_normal(n)
    given = [np.ascontiguousarray(a, dtype=number) for a in given]
    joint = given[3].astype(float)
    rest = joint[:n, :n] - joint[:n, n:] @ np.linalg.solve(joint[n:, n:], joint[n:, :n])
    return random_model(random, k, number) if k % 3 == 1 and np.linalg.eigvalsh(rest)[0] <= 0 else given


def drawn(random, A, B, H, joint, P0, x0):
    """z, u and what is present of z"""
    n, m = len(A), len(H)
    root = np.linalg.eigh(joint.astype(float))
    root = root[1] * np.sqrt(np.maximum(root[0], 0))
    x, u = x0 + np.linalg.cholesky(P0.astype(float)) @ random.standard_normal(n), random.standard_normal((STEPS, B.shape[1]))
    z = np.zeros((STEPS, m))
    for t in range(STEPS):
        noise = root @ random.standard_normal(n + m)
        z[t], x = H @ x + noise[n:], A @ x + B @ u[t] + noise[:n]
    return z.astype(A.dtype), u.astype(A.dtype), random.random((STEPS, m)) < 0.6


class Dense:
    """The joint law of x[0], ..., x[STEPS] and all z, conditioned on numbers"""

    def __init__(self, A, B, H, joint, P0, x0, u):
        A, B, H, joint, P0, x0, u = (a.astype(np.longdouble) for a in (A, B, H, joint, P0, x0, u))
        n, m = self.n, self.m = len(A), len(H)
        size = n + STEPS * (n + m)
        source = np.zeros((size, size), np.longdouble)  # covariance of x[0], then of (w; v) of each step
        source[:n, :n] = P0
        state = np.eye(n, size, dtype=np.longdouble)
        maps, means, mean = [state], [x0], x0
        seen, expected = [], []
        for t in range(STEPS):
            at = n + t * (n + m)
            source[at : at + n + m, at : at + n + m] = joint
            noise = np.eye(n + m, size, at, dtype=np.longdouble)
            seen.append(H @ state + noise[n:]), expected.append(H @ mean)
            state, mean = A @ state + noise[:n], A @ mean + B @ u[t]
            maps.append(state), means.append(mean)
        all_maps = np.concatenate(maps + seen)
        self.mean, self.P = np.concatenate(means + expected), all_maps @ source @ all_maps.T
        self.likelihood = np.longdouble(0)

    def measure(self, t, c, value):
        at = self.n * (STEPS + 1) + t * self.m + c
        e, s = value - self.mean[at], self.P[at, at]
        column = self.P[:, at].copy()
        self.mean, self.P = self.mean + column * (e / s), self.P - np.outer(column, column) / s
        self.likelihood -= (np.log(2 * np.longdouble(np.pi) * s) + e * e / s) / 2

    def state(self, t):
        at = slice(t * self.n, (t + 1) * self.n)
        return self.mean[at], self.P[at, at]


def distance(library, view, wanted, added, of_P):
    """Of mean and covariance, in sigma; added: to the variances that sigma is made of, of_P: of the covariance"""
    mean, P = wanted
    (far, sigma), found = (np.sqrt(np.diag(P) + more).astype(float) for more in (added, of_P)), np.zeros(P.shape, dtype=library.type)
    library.call("covariance", view, found)
    at = [library.read("mean", view, i) + library.read("mean_low", view, i) for i in range(len(mean))]
    return [(np.abs(at - mean) / far).astype(float).max(), (np.abs(found - P) / np.outer(sigma, sigma)).astype(float).max()]


def errors(library, random, k):
    """Mean and covariance of filter and smoother, likelihood"""
    model = random_model(random, k, library.type)
    A, B, H, joint, P0, x0 = (library.numbers(a) for a in model)
    z, u, present = drawn(random, *model)
    n, m, l = len(A), len(H), B.shape[1]
    present |= k % 3 == 1
    dense = Dense(*model, u)
    Q, R, S = (library.numbers(a) for a in (joint[:n, :n], joint[n:, n:], joint[:n, n:]))
    added = [1e-30 if k % 3 == 2 else np.diag(Q), 1e-30 if k % 3 else np.diag(Q)]
    p, s, f, lag = (library.made(*what) for what in (("process", n, l + m), ("sensor", n, m), ("filter", n), ("lag", n, m, STEPS)))
    library.call("sensor_init", s, H, R)
    library.call("filter_init", f, x0, P0)
    library.call("attach", f, lag)
    filtered, smoothed = [], []
    for t in range(STEPS):
        mask = sum(1 << c for c in range(m) if present[t, c])
        for c in np.flatnonzero(present[t]):
            dense.measure(t, int(c), z[t, c])
        library.call("update_subset", f, s, library.numbers(z[t]), mask)
        filtered.append(distance(library, f, dense.state(t), *added))
        library.call("process_init_correlated", p, A, B if l else None, Q, s, S, mask)
        library.call("predict", f, p, library.numbers(np.concatenate([u[t], np.where(present[t], z[t], 1e3)])))
        filtered.append(distance(library, f, dense.state(t + 1), *added))
    for t in range(STEPS):
        view = np.zeros(512, dtype=np.uint8)
        library.call("lagged", lag, STEPS - t, view)
        smoothed.append(distance(library, view, dense.state(t), added[0], added[0]))
    likelihood = abs(library.read("log_likelihood", f) - float(dense.likelihood)) / max(1, abs(float(dense.likelihood)))
    library.kept.clear()
    return [*np.max(filtered, axis=0), *np.max(smoothed, axis=0), likelihood]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("library")
    parser.add_argument("--models", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    failed = False
    for arithmetic, goal in GOALS.items():
        library, random = Library(given.library, arithmetic), np.random.default_rng(given.seed)
        found = np.array([errors(library, random, k) for k in range(given.models)])
        for kind, which in ("singular", found[::3]), ("nearly", found[1::3]), ("others", found[2::3]):
            texts = [f"{what} {worst:.1e}" for what, worst in zip(("mean", "P", "smoothed mean", "P", "likelihood"), which.max(axis=0))]
            print(f"{arithmetic} {kind}, {len(which)} models, worst: {', '.join(texts)}; median {np.median(which, axis=0)}")
        failed |= not (found <= goal).all()
    return failed


if __name__ == "__main__":
    raise SystemExit(main())
