"""EM as the textbooks have it, in double precision: covariance filter, Rauch-Tung-Striebel smoother
with lag-one covariances, sums of products, all six parameters.

Nothing here is a root, and nothing is shared with the library: this is what it is compared with.
Steps without a measurement have no part in H and R.  In the others missing components belong to
the complete data: their noise is what the current R makes of the noise of those that are there.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

NAMES = ("A", "H", "Q", "R", "x0", "P0")
FULL, DIAGONAL, MULTIPLE = range(3)


@dataclass
class Parameters:
    A: np.ndarray
    H: np.ndarray
    Q: np.ndarray
    R: np.ndarray
    x0: np.ndarray
    P0: np.ndarray

    def __post_init__(self) -> None:
        for name in NAMES:
            value = np.array(getattr(self, name), float)
            setattr(self, name, value if name == "x0" else np.atleast_2d(value))
        self.x0 = np.atleast_1d(self.x0)


@dataclass
class Recording:
    z: np.ndarray  # T x m, nan: missing
    u: np.ndarray | None = None  # T - 1 x l

    def __post_init__(self) -> None:
        self.z = np.asarray(self.z, float).reshape(len(self.z), -1)


@dataclass
class Choice:
    free: tuple = ("Q", "R")
    Q_form: int = FULL
    R_form: int = FULL
    A_held: np.ndarray | None = None
    H_held: np.ndarray | None = None

    @property
    def is_default(self) -> bool:
        return (self.free == ("Q", "R") and self.Q_form == self.R_form == FULL and
                self.A_held is None and self.H_held is None)


@dataclass
class Problem:
    start: Parameters
    recordings: list[Recording]
    choice: Choice = field(default_factory=Choice)
    B: np.ndarray | None = None
    F: np.ndarray | None = None
    empty_steps: bool = False  # they are complete data, too: their noise is the current R

    @property
    def n(self) -> int:
        return len(self.start.A)

    @property
    def m(self) -> int:
        return len(self.start.H)

    def drive(self, recording: Recording) -> np.ndarray:
        """B u of every transition"""
        if self.B is None or recording.u is None:
            return np.zeros((len(recording.z) - 1, self.n))
        return recording.u @ self.B.T

    def state_noise(self, p: Parameters) -> np.ndarray:
        return p.Q if self.F is None else self.F @ p.Q @ self.F.T

    def with_choice(self, **change) -> Problem:
        return replace(self, choice=Choice(**change))


@dataclass
class Noise:
    """Of a regression on x: sums of E[e e'], E[e x'], E[x x'] over the steps, e = y - C x"""

    ee: np.ndarray
    ex: np.ndarray
    xx: np.ndarray
    count: int = 0

    @staticmethod
    def none(rows: int, n: int) -> Noise:
        return Noise(np.zeros((rows, rows)), np.zeros((rows, n)), np.zeros((n, n)))

    def residual(self, move: np.ndarray) -> np.ndarray:
        """The sum of E[e e'] once the coefficients have moved"""
        cross = move @ self.ex.T
        return self.ee - cross - cross.T + move @ self.xx @ move.T


@dataclass
class Sums:
    log_likelihood: float
    process: Noise
    sensor: Noise
    start: np.ndarray  # sum of E[x[0]]
    start_square: np.ndarray  # sum of E[(x[0] - x0)(x[0] - x0)'] with the current x0
    count: int


def filtered(problem: Problem, p: Parameters, recording: Recording):
    """Predicted and filtered means and covariances, and the log-likelihood"""
    Q, drive = problem.state_noise(p), problem.drive(recording)
    steps, n = len(recording.z), problem.n
    means, covariances = np.empty((2, steps, n)), np.empty((2, steps, n, n))
    x, P, log_likelihood = p.x0, p.P0, 0.0
    for t, z in enumerate(recording.z):
        if t:
            x, P = p.A @ x + drive[t - 1], p.A @ P @ p.A.T + Q
        means[0, t], covariances[0, t] = x, P
        there = ~np.isnan(z)
        if there.any():
            H, R = p.H[there], p.R[np.ix_(there, there)]
            e, S = z[there] - H @ x, H @ P @ H.T + R
            solved = np.linalg.solve(S, np.column_stack((H @ P, e)))
            K = solved[:, :-1].T
            log_likelihood -= 0.5 * (len(e) * np.log(2 * np.pi) + np.linalg.slogdet(S)[1] +
                                     e @ solved[:, -1])
            rest = np.eye(n) - K @ H
            x, P = x + K @ e, rest @ P @ rest.T + K @ R @ K.T
        means[1, t], covariances[1, t] = x, P
    return means, covariances, log_likelihood


def smoothed(p: Parameters, means, covariances):
    """Means, covariances, and Cov(x[t+1], x[t])"""
    x, P = means[1].copy(), covariances[1].copy()
    inverse = np.linalg.pinv(covariances[0, 1:], rcond=1e-14, hermitian=True)
    gain = P[:-1] @ p.A.T @ inverse
    lag_one = np.empty_like(gain)
    for t in range(len(gain) - 1, -1, -1):
        G = gain[t]
        x[t] += G @ (x[t + 1] - means[0, t + 1])
        P[t] += G @ (P[t + 1] - covariances[0, t + 1]) @ G.T
        lag_one[t] = P[t + 1] @ G.T
    return x, P, lag_one


def process_noise(problem: Problem, p: Parameters, recording, x, P, lag_one) -> Noise:
    w = x[1:] - x[:-1] @ p.A.T - problem.drive(recording)
    AP, AL = p.A @ P[:-1], lag_one @ p.A.T
    ee = P[1:] - AL - np.swapaxes(AL, 1, 2) + AP @ p.A.T
    return Noise(w.T @ w + ee.sum(0), w.T @ x[:-1] + (lag_one - AP).sum(0),
                 x[:-1].T @ x[:-1] + P[:-1].sum(0), len(w))


def sensor_noise(problem: Problem, p: Parameters, recording, x, P) -> Noise:
    m, n = p.H.shape
    sums = Noise.none(m, n)
    missing = np.isnan(recording.z)
    taken = ~missing.all(1) | problem.empty_steps
    sums.xx, sums.count = x[taken].T @ x[taken] + P[taken].sum(0), taken.sum()
    for pattern in np.unique(missing[taken], axis=0):
        steps = (missing == pattern).all(1)
        there, H = ~pattern, p.H[~pattern]
        # all components from those that are there: v = M v_there + what they do not tell
        M = p.R[:, there] @ np.linalg.pinv(p.R[np.ix_(there, there)])
        untold = p.R - M @ p.R[there]
        v, Ps = recording.z[steps][:, there] - x[steps] @ H.T, P[steps].sum(0)
        sums.ee += M @ (v.T @ v + H @ Ps @ H.T) @ M.T + steps.sum() * untold
        sums.ex += M @ (v.T @ x[steps] - H @ Ps)
    return sums


def e_step(problem: Problem, p: Parameters) -> Sums:
    n, m = problem.n, problem.m
    sums = Sums(0.0, Noise.none(n, n), Noise.none(m, n), np.zeros(n), np.zeros((n, n)),
                len(problem.recordings))
    for recording in problem.recordings:
        means, covariances, log_likelihood = filtered(problem, p, recording)
        x, P, lag_one = smoothed(p, means, covariances)
        sums.log_likelihood += log_likelihood
        for total, part in ((sums.process, process_noise(problem, p, recording, x, P, lag_one)),
                            (sums.sensor, sensor_noise(problem, p, recording, x, P))):
            total.ee += part.ee
            total.ex += part.ex
            total.xx += part.xx
            total.count += part.count
        sums.start += x[0]
        sums.start_square += np.outer(x[0] - p.x0, x[0] - p.x0) + P[0]
    return sums


def regression(sums: Noise, covariance: np.ndarray, held: np.ndarray | None) -> np.ndarray:
    """How far the coefficients move: all at once; with held entries row after row, the last one
    first, each to its best for the others as they are and the covariance as it was"""
    if held is None or not held.any():
        return np.linalg.lstsq(sums.xx, sums.ex.T, rcond=1e-14)[0].T
    move = np.zeros_like(sums.ex)
    weight = np.linalg.pinv(covariance, rcond=1e-13, hermitian=True)
    alone = np.abs(covariance @ weight - np.eye(len(covariance))).max(0) < 1e-8
    for row in reversed(range(len(move))):
        free = held[row] == 0
        if alone[row] and free.any():
            pull = weight[row] @ (sums.ex - move @ sums.xx)
            move[row, free] += np.linalg.solve(sums.xx[np.ix_(free, free)],
                                               pull[free] / weight[row, row])
    return move


def of_form(mean: np.ndarray, current: np.ndarray, form: int) -> np.ndarray:
    if form == DIAGONAL:
        return np.diag(np.diag(mean))
    if form == MULTIPLE:
        inverse = np.linalg.pinv(current, hermitian=True)
        return current * (np.trace(inverse @ mean) / np.linalg.matrix_rank(current))
    return (mean + mean.T) / 2


def m_step(problem: Problem, p: Parameters, sums: Sums) -> Parameters:
    choice, new = problem.choice, replace(p)
    free = choice.free
    A_move, H_move = np.zeros_like(p.A), np.zeros_like(p.H)
    if "A" in free:
        A_move = regression(sums.process, problem.state_noise(p), choice.A_held)
        new.A = p.A + A_move
    if "H" in free:
        H_move = regression(sums.sensor, p.R, choice.H_held)
        new.H = p.H + H_move
    if "Q" in free and sums.process.count:
        mean = sums.process.residual(A_move) / sums.process.count
        if problem.F is not None:
            inverse = np.linalg.pinv(problem.F)
            mean = inverse @ mean @ inverse.T
        new.Q = of_form(mean, p.Q, choice.Q_form)
    if "R" in free:
        new.R = of_form(sums.sensor.residual(H_move) / sums.sensor.count, p.R, choice.R_form)
    move = sums.start / sums.count - p.x0
    if "x0" in free:
        new.x0 = p.x0 + move
    if "P0" in free:
        new.P0 = sums.start_square / sums.count - np.outer(move, move) * ("x0" in free)
    return new


def gradient(problem: Problem, p: Parameters, sums: Sums) -> dict[str, np.ndarray]:
    """By Fisher's identity; entries of a covariance are independent.  dL/dA only without F."""
    def of_covariance(C, total, count):
        inverse = np.linalg.inv(C)
        return inverse @ (total - count * C) @ inverse / 2

    q = sums.process.ee
    if problem.F is not None:
        q = np.linalg.pinv(problem.F) @ q @ np.linalg.pinv(problem.F).T
    slopes = {"H": np.linalg.solve(p.R, sums.sensor.ex),
              "Q": of_covariance(p.Q, q, sums.process.count),
              "R": of_covariance(p.R, sums.sensor.ee, sums.sensor.count),
              "x0": np.linalg.solve(p.P0, sums.start - sums.count * p.x0),
              "P0": of_covariance(p.P0, sums.start_square, sums.count)}
    if problem.F is None:
        slopes["A"] = np.linalg.solve(p.Q, sums.process.ex)
    return slopes


def log_likelihood(problem: Problem, p: Parameters) -> float:
    return sum(filtered(problem, p, recording)[2] for recording in problem.recordings)


def iterate(problem: Problem, iterations: int):
    """Log-likelihoods before each iteration, and the parameters after each"""
    p, likelihoods, path = problem.start, [], []
    for _ in range(iterations):
        sums = e_step(problem, p)
        likelihoods.append(sums.log_likelihood)
        p = m_step(problem, p, sums)
        path.append(p)
    return np.array(likelihoods), path
