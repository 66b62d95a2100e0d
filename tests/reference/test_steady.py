"""kq_steady_solve against SciPy's solve_discrete_are, on random models.

  test_steady.py LIBRARY [--seed N]     LIBRARY: kalmanq as a shared library

An error of P- is relative to sqrt(P_ii P_jj), one of K_ic to sqrt(P_ii / S_cc).  Where the two
solutions are further apart than the goal, the equation's residual in 80-bit arithmetic says which
of them is the less accurate one.  f32's error is held against what the equation makes of rounding,
eps times the sum of |C^k|^2, C = A (I - K H) in units of the sigmas.
"""

from __future__ import annotations

import argparse
import ctypes
import sys
from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_discrete_are

from shared_library import Library

GOAL_F64 = 1e-10
MODELS = 200
WIDE = np.longdouble


@dataclass(frozen=True)
class Model:
    A: np.ndarray
    H: np.ndarray
    Q: np.ndarray
    R: np.ndarray

    @property
    def n(self) -> int:
        return self.A.shape[0]

    @property
    def m(self) -> int:
        return self.H.shape[0]


@dataclass(frozen=True)
class Solution:
    status: int
    P: np.ndarray
    K: np.ndarray
    G: np.ndarray


# ---- models ----------------------------------------------------------------------------------


def covariance(random: np.random.Generator, n: int, rank: int) -> np.ndarray:
    """Of a factor of few bits, so that nothing is rounded, and what is singular stays so."""
    F = np.round(random.standard_normal((n, rank)) * 16) / 16
    F[F == 0] = 1 / 16
    return F @ F.T


def narrow(a: np.ndarray) -> np.ndarray:
    """What f32 has, too: both solve the same problem."""
    return a.astype("f4").astype(float)


def draw(random: np.random.Generator) -> Model:
    """Any A up to a spectral radius of 1.2, Q of any rank, R full: almost surely stabilisable."""
    n = int(random.integers(1, 13))
    m = int(random.integers(1, min(n, 4) + 1))
    A = random.standard_normal((n, n))
    A *= random.uniform(0.3, 1.2) / np.abs(np.linalg.eigvals(A)).max()
    H = random.standard_normal((m, n))
    Q = covariance(random, n, int(random.integers(1, n + 1))) * 4.0 ** random.integers(-3, 2)
    R = covariance(random, m, m) + 0.125 * np.eye(m)
    return Model(narrow(A), narrow(H), Q, R)


def transformed(random: np.random.Generator, model: Model) -> Model:
    """The same model in other coordinates, so that nothing in it is 0 any more."""
    n = model.n
    T = np.linalg.qr(random.standard_normal((n, n)))[0] * 2 ** random.uniform(-1, 1, n)
    back = np.linalg.inv(T)
    Q = T @ model.Q @ T.T
    return Model(T @ model.A @ back, model.H @ back, (Q + Q.T) / 2, model.R)


def diagonal(poles: list[float], measured: list[float], noise: list[float]) -> Model:
    return Model(np.diag(poles), np.array([measured]), np.diag(noise), np.eye(1))


REFUSED = {  # the model, the status
    "constant, no noise": (diagonal([1], [1], [0]), -16),
    "unstable, no noise": (diagonal([1.5], [1], [0]), -16),
    "random walk, not measured": (diagonal([1], [0], [1]), -15),
    "unstable, not measured": (diagonal([1.5], [0], [1]), -15),
    "a bias without noise": (diagonal([0.9, 1], [1, 1], [1, 0]), -16),
    "an unstable one without noise": (diagonal([0.9, 1.2, 0.4], [1, 1, 1], [1, 0, 2]), -16),
    "one not measured": (diagonal([0.9, 1, 0.3], [1, 0, 2], [1, 1, 1]), -15),
    "an unstable one not measured": (diagonal([0.9, 1.2], [1, 0], [1, 1]), -15),
    "two walks, their sum measured": (diagonal([1, 1], [1, 1], [1, 2]), -15),
    "position of a velocity": (
        Model(np.array([[1, 0.1], [0, 1]]), np.array([[0.0, 1]]), np.eye(2), np.eye(1)), -15),
    "a turn without noise": (
        Model(np.array([[0.6, 0.8], [-0.8, 0.6]]), np.array([[1.0, 0]]), np.zeros((2, 2)),
              np.eye(1)), -16),
}  # fmt: skip

TAKEN = {
    "stable, not measured": diagonal([0.5, 1], [0, 1], [1, 1]),
    "stable, no noise": diagonal([0.99, 1], [1, 1], [0, 1]),
    "stable, neither": diagonal([0.9, 1.1], [0, 1], [0, 1]),
}


# ---- the library and SciPy -------------------------------------------------------------------


def solutions(library: str, models: list[Model]) -> list[tuple[Solution, Solution]]:
    """In f64 and in f32."""
    kinds = [Library(library, arithmetic) for arithmetic in ("f64", "f32")]
    return [tuple(solution(k, model) for k in kinds) for model in models]


def solution(k: Library, model: Model) -> Solution:
    n, m = model.n, model.m
    k.kept.clear()
    process, sensor = k.made("process", n, 0), k.made("sensor", n, m)
    k.call("process_init", process, k.numbers(model.A), None, k.numbers(model.Q))
    k.call("sensor_init", sensor, k.numbers(model.H), k.numbers(model.R))
    P, K, G, memory = (np.zeros(shape, dtype=k.type) for shape in ((n, n), (n, m), (n, n), 8192))
    out = (ctypes.c_void_p * 4)(P.ctypes.data, None, K.ctypes.data, G.ctypes.data)  # a kq_steady_solution
    status = k.answer("steady_solve", process, sensor, memory, len(memory), out)
    return Solution(status, *(a.astype(float) for a in (P, K, G)))


def gain(model: Model, P: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    S = model.H @ P @ model.H.T + model.R
    return np.linalg.solve(S, model.H @ P).T, S


def error(P: np.ndarray, reference: np.ndarray) -> float:
    sigma = np.sqrt(np.diag(reference))
    return float((np.abs(P - reference) / np.outer(sigma, sigma)).max())


def inverse_of_wide(S: np.ndarray) -> np.ndarray:
    """Newton's steps from the double's inverse: LAPACK has no 80 bits."""
    X = np.linalg.inv(S.astype(float)).astype(WIDE)
    for _ in range(4):
        X = X @ (2 * np.eye(len(S), dtype=WIDE) - S @ X)
    return X


def residual(model: Model, P: np.ndarray) -> float:
    """Of the equation, in 80 bits, relative to sqrt(P_ii P_jj)."""
    A, H, Q, R, P = (a.astype(WIDE) for a in (model.A, model.H, model.Q, model.R, P))
    K = P @ H.T @ inverse_of_wide(H @ P @ H.T + R)
    left = A @ (P - K @ H @ P) @ A.T + Q - P
    sigma = np.sqrt(np.diag(P))
    return float((np.abs(left) / np.outer(sigma, sigma)).max())


def amplification(model: Model, P: np.ndarray) -> float:
    """How much of rounding in P's units the equation keeps: the sum of |C^k|^2, C = A (I - K H)."""
    sigma = np.sqrt(np.diag(P))
    K, _ = gain(model, P)
    C = (model.A @ (np.eye(model.n) - K @ model.H)) * sigma / sigma[:, None]
    total, power = 0.0, np.eye(model.n)
    for _ in range(100000):
        size = np.linalg.norm(power, 2) ** 2
        total += size
        if size < 1e-6:
            break
        power = C @ power
    return total


# ---- the tests -------------------------------------------------------------------------------


def random_models(library: str, random: np.random.Generator) -> bool:
    models = [draw(random) for _ in range(MODELS)]
    errors, f32_errors, f32_shares, gains, smoothers = [], [], [], [], []
    less_accurate = failed = 0
    for model, (f64, f32) in zip(models, solutions(library, models)):
        reference = solve_discrete_are(model.A.T, model.H.T, model.Q, model.R)
        if f64.status or f32.status:
            print(f"refused: {f64.status}, {f32.status}: n {model.n}")
            failed += 1
            continue
        own = error(f64.P, reference)
        if not own <= GOAL_F64:
            ours, theirs = residual(model, f64.P), residual(model, reference)
            less_accurate += ours < theirs
            failed += not ours < theirs
            print(f"apart by {own:.1e}; residuals: kalmanq {ours:.1e}, SciPy {theirs:.1e}")
            continue
        errors.append(own)
        K, S = gain(model, f64.P)
        size = np.sqrt(np.outer(np.diag(f64.P), 1 / np.diag(S)))
        gains.append(float((np.abs(f64.K - K) / size).max()))
        P = f64.P - f64.K @ model.H @ f64.P
        scale = np.sqrt(np.outer(np.diag(f64.P), 1 / np.diag(f64.P)))
        G = np.linalg.solve(f64.P, model.A @ P).T
        smoothers.append(float((np.abs(f64.G - G) / scale).max() / np.linalg.cond(f64.P)))
        f32_errors.append(error(f32.P, reference))
        f32_shares.append(f32_errors[-1] / amplification(model, reference) / np.finfo("f4").eps)
    print(f"P- against SciPy, f64: worst {max(errors):.1e}, median {np.median(errors):.1e}"
          f" (goal {GOAL_F64:.0e}); SciPy the less accurate one in {less_accurate}")
    print(f"K from that P-, f64: worst {max(gains):.1e}")
    print(f"G from that P-, f64, by P-'s condition: worst {max(smoothers):.1e}")
    print(f"P- against SciPy, f32: worst {max(f32_errors):.1e}, median {np.median(f32_errors):.1e};"
          f" in units of eps sum |C^k|^2: worst {max(f32_shares):.1f}")  # fmt: skip
    failed += max(gains) > 1e-10 or max(smoothers) > 1e-13 or max(f32_shares) > 64
    return not failed


def refusals(library: str, random: np.random.Generator) -> bool:
    good = True
    for name, (model, status) in REFUSED.items():
        models = [model] + [transformed(random, model) for _ in range(20)]
        got = solutions(library, models)
        exact = {got[0][0].status, got[0][1].status}
        others = [pair[k].status for pair in got[1:] for k in (0, 1)]
        wrong = sum(other != status for other in others)
        good &= exact == {status} and wrong == 0
        print(f"{name}: {exact}, {wrong} of {len(others)} otherwise after a change of coordinates")
    for name, model in TAKEN.items():
        models = [model] + [transformed(random, model) for _ in range(20)]
        wrong = sum(pair[k].status != 0 for pair in solutions(library, models) for k in (0, 1))
        good &= wrong == 0
        print(f"{name}: {wrong} of {2 * len(models)} refused")
    return good


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("library")
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    random = np.random.default_rng(arguments.seed)
    results = [random_models(arguments.library, random), refusals(arguments.library, random)]
    sys.exit(0 if all(results) else 1)


if __name__ == "__main__":
    main()
