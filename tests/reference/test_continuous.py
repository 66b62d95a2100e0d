"""kq_process_init_continuous against 60 decimal digits, on random models and on named ones.

  test_continuous.py LIBRARY [--models N] [--seed N]     LIBRARY: kalmanq as a shared library

Errors in eps: of A and B relative to the largest entry, or to 1 where A is below that; of Q_ij = (G G')_ij relative to
sqrt(Q_ii Q_jj); of G_ii, the sigma of a state given those behind it, which may be far below its own, relative to
sqrt(Q_ii) n/2, as predict rounds rows (where Qc is diagonal: no other is known better than to sqrt(eps)).  dt is 1e-6 to 1e3 time constants; the models are stable, stiff, oscillate or grow.  Subtracted is twice
what four F whose entries are off by eps make: what the rounding of F dt costs any method.  (Of an oscillator without damping
A grows or shrinks by |F| dt eps / 2: 370 eps at 1000 radians, so it is run to 10.)
In f32 no sigma given the states below it is near 2^-60, the least that a process has.
"""

from __future__ import annotations

import argparse
import ctypes
from decimal import Decimal, getcontext

import numpy as np

from shared_library import Library

getcontext().prec = 60
GOAL = 20  # eps, of both arithmetics: 4.4e-15 in f64
exact = np.vectorize(Decimal, otypes=[object])


def reference(F, B, Qc, dt):
    """A, B, Q by series over dt / 2^k and doubling, a sum of covariances without a difference"""
    F, B, Qc, dt = exact(F), exact(B), exact(Qc), Decimal(dt)
    k = max(0, int(np.ceil(np.log2(float(np.abs(F).sum(1).max() * dt) + 1e-300))) + 8)
    h = dt / 2**k
    A, S, Q = np.eye(len(F), dtype=int) * Decimal(1), 0 * F, 0 * F
    power, noise = A, Qc * h
    for i in range(1, 24 + len(F)):
        S, Q = S + power * (h / i), Q + noise
        power, noise = F @ power * (h / i), (F @ noise + noise @ F.T) * (h / (i + 1))
        A = A + power
    for _ in range(k):
        A, S, Q = A @ A, S + A @ S, Q + A @ Q @ A.T
    return A, S @ B, Q


def made(library, F, B, Qc, dt):
    """A, B, G of the library; F, B, Qc of its type"""
    n, l = len(F), B.shape[1]
    p, memory = library.made("process", n, l), np.zeros(8 * 16 * 16 + 136, dtype=library.type)
    library.call("process_init_continuous", p, F, B if l else None, Qc, library.number(dt), memory, len(memory))
    noise = np.zeros((n, n))
    words = library.kept[-1][: n * (n + 1) // 2].astype(np.float64)
    for j in range(n):
        noise[: j + 1, j] = words[j * (j + 1) // 2 : (j + 1) * (j + 2) // 2]
    return memory[: n * n].reshape(n, n), memory[n * n : n * (n + l)].reshape(n, l), noise


def given_sigmas(Q):
    """Of each state given those behind it; of what has none left the others count"""
    rest, sigmas = Q.copy(), np.zeros(len(Q))
    for j in range(len(Q))[::-1]:
        if rest[j, j] > Decimal("1e-40") * Q[j, j]:
            sigmas[j], column = float(rest[j, j].sqrt()), rest[: j + 1, j].copy()
            rest[: j + 1, : j + 1] -= np.outer(column, column) / rest[j, j]
    return sigmas


def distances(found, wanted):
    """Of A, B, Q and the pivots of its root"""
    largest = [np.abs(a).astype(float).max() for a in wanted[:2]]
    sigma = np.sqrt(np.diag(wanted[2]).astype(float))
    apart = [np.abs(a - b).astype(float) for a, b in zip(found, wanted)]
    return np.array([apart[0].max() / max(1, largest[0]), apart[1].max() / largest[1], (apart[2] / np.outer(sigma, sigma)).max(), (np.abs(given_sigmas(found[2]) - given_sigmas(wanted[2])) / sigma).max()])


def errors(library, F, B, L, dt):
    """Of A, B, Q and its root's pivots, in eps"""
    given = [np.ascontiguousarray(a, dtype=library.type) for a in (F, B, L @ L.T)]
    F, B, Qc = (a.astype(float) for a in given)
    dt, eps = float(library.type(dt)), float(np.finfo(library.type).eps)
    A, control, G = (exact(a.astype(float)) for a in made(library, *given, dt))
    wanted = reference(F, B, Qc, dt)
    signs = np.random.default_rng(1).choice([-1.0, 1.0], (4, *F.shape))
    rounding = np.max([distances(reference(exact(F) * exact(1 + sign * eps), B, Qc, dt), wanted) for sign in signs], axis=0)
    found = np.maximum(distances((A, control, G @ G.T), wanted) - 2 * rounding, 0) / eps
    found[3] *= 2 / len(F) if np.count_nonzero(Qc) == np.count_nonzero(np.diag(Qc)) else 0
    return found


def random_model(random):
    """F of n modes in mixed axes, fastest time constant 1; B, L; dt"""
    n = int(random.integers(1, 7))
    modes = np.zeros((n, n))
    i, decades = 0, random.choice([0, 2, 5])
    while i < n:
        rate, ring = 10 ** -random.uniform(0, decades) if i else 1.0, random.choice([0, 1, 5])
        if i + 1 < n and ring:
            modes[i : i + 2, i : i + 2] = rate * np.array([[-1, ring], [-ring, -1]]) / ring
        else:
            modes[i, i] = -rate
        i += 2 if i + 1 < n and ring else 1
    axes = np.linalg.qr(random.standard_normal((n, n)))[0]
    dt = 10 ** random.uniform(-6, 3)
    if random.random() < 0.2 and dt < 10:
        modes = -modes
    return axes @ modes @ axes.T, random.standard_normal((n, 2)), random.standard_normal((n, random.integers(1, n + 1))), dt


def named_models():
    chain = lambda n: (np.eye(n, k=1), np.eye(n)[:, -1:], np.eye(n)[:, -1:])
    for n, name in (1, "random walk"), (2, "velocity"), (3, "acceleration"), (5, "chain of 5"), (10, "chain of 10"), (16, "chain of 16"):
        for dt in 1e-6 if n < 3 else 1e-2 if n < 10 else 10.0, 0.1 if n < 10 else 3.0, 1e3 if n < 10 else 30.0:
            yield f"{name}, dt = {dt:g}", *chain(n), dt
    for n in 6, 10:
        yield f"damped chain of {n}", np.eye(n, k=1) - np.diag(np.arange(n) % 3 / 2), np.eye(n)[:, -1:], np.eye(n)[:, -1:], 3.0
    for dt in 1e-3, 1.0, 1e3:
        yield f"clock, dt = {dt:g}", np.eye(2, k=1), np.eye(2)[:, :1], np.diag([1e-3, 1e-6]), dt
        yield f"Ornstein-Uhlenbeck, dt = {dt:g}", np.array([[-1.0]]), np.eye(1), np.eye(1), dt
        yield f"Singer, dt = {dt:g}", np.eye(3, k=1) - np.diag([0, 0, 0.05]), np.eye(3)[:, 1:2], np.eye(3)[:, 2:], dt
        dt = min(dt, 10.0)
        yield f"oscillator, dt = {dt:g}", np.array([[0, 1e4], [-1e-4, 0]]), np.eye(2)[:, 1:], np.eye(2)[:, 1:], dt


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("library")
    parser.add_argument("--models", type=int, default=40)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    failed = False
    for arithmetic in "f64", "f32":
        library, random = Library(given.library, arithmetic), np.random.default_rng(given.seed)
        models = list(named_models()) + [(f"random {k}", *random_model(random)) for k in range(given.models)]
        found = np.array([errors(library, *model[1:]) for model in models])
        for kind, which in ("named", slice(0, len(models) - given.models)), ("random", slice(-given.models, None)):
            names, figures = [m[0] for m in models[which]], found[which]
            text = ", ".join(f"{what} {figures[:, i].max():.1f} ({names[figures[:, i].argmax()]})" for i, what in enumerate("ABQG"))
            print(f"{arithmetic} {kind}: worst in eps: {text}; median {np.median(figures, axis=0).round(2)}")
        failed |= not (found <= GOAL).all()
    return failed


if __name__ == "__main__":
    raise SystemExit(main())
