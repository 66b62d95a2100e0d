"""Records that a compiled filter is tried with, and the same filter in long double beside it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Optional, Sequence

import numpy as np

from kalmanq.compiler.given.request import GAP, STUDENT_STEPS, Request, due
from kalmanq.compiler.run.host import Host, Ran
from kalmanq.compiler.text.emit import PREDICTS, UPDATES
from kalmanq.model import root_of
from kalmanq.run.simulation import read_off

LONG = np.longdouble
FADES = 0.98  # the largest eigenvalue of what is drawn, so that nothing leaves its range for ever
FADED = 1e-12  # of its largest sigma: a state without noise that fades away is known, and no error is told of it
PUSHED = 0.2  # of a control's range


@dataclass(frozen=True)
class Record:
    """what, present: of each row, as Host.run takes them; z: rows x m; u: rows x l, of the step that leads to the row; now: of
    the row itself, where a model reads them there; clock: rows x 3, t of the row before, the step between them, t of the row"""

    what: np.ndarray
    present: np.ndarray
    z: np.ndarray
    u: np.ndarray
    now: Optional[np.ndarray] = None
    clock: Optional[np.ndarray] = None


def clock_of(times: np.ndarray, dt: float = np.nan) -> np.ndarray:
    """dt: of the step to the first row"""
    return np.column_stack([np.concatenate([times[:1] - dt, times[:-1]]), np.diff(times, prepend=times[:1] - dt), times])


def times_of(record: Record) -> Optional[np.ndarray]:
    return None if record.clock is None else record.clock[:, 2]


@dataclass(frozen=True)
class Accuracy:
    """The largest errors of a record: of a mean in sigma, of a covariance in sigma_i sigma_j; settled: of a mean in the
    rows with the constant gain"""

    mean: float
    covariance: float
    events: int
    taken: float  # share of the components that were given


def drawn(given: Request, rows: int, seed: int, longest: int = 0) -> Record:
    """Samples of the model with what happens in the field: gaps, components that are missing, second updates."""
    draws, longest = np.random.default_rng(seed), longest or 2 * max(given.model.gaps.max_gap, GAP)
    what, present = _events(given, rows, longest, draws)
    z, u = _samples(given, rows, draws)
    return Record(what, present, z, u)


def _events(given: Request, rows: int, longest: int, draws: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    what = np.full(rows, PREDICTS | UPDATES, np.uint8)
    present = np.full(rows, given.all, np.uint32)
    what[0], t = UPDATES, 1
    while t < rows:
        kind = draws.random()
        if kind < 0.01:
            gap = int(draws.integers(1, longest + 1))
            what[t:t + gap], present[t:t + gap] = PREDICTS, 0
            t += gap
        elif kind < 0.02:
            what[t] = UPDATES
        elif kind < 0.05:
            present[t] = draws.integers(0, given.all + 1)
            what[t] = what[t] if present[t] else PREDICTS
        t += 1
    if given.options.every:
        present &= np.array([due(given.options.every, row) for row in range(rows)], np.uint32)
        what = np.where(present > 0, what, what & PREDICTS).astype(np.uint8)
    return what, present


def _samples(given: Request, rows: int, draws: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    model, of = given.model, given.of.doubles()
    largest = np.abs(np.linalg.eigvals(of.A)).max()
    A = of.A * min(1.0, FADES / max(largest, 1e-9))
    root, noise = root_of(of.Q), root_of(np.asarray(model.R))
    pushes = np.array([PUSHED * (one.range or 1.0) for one in model.controls])
    u = draws.standard_normal((rows, of.l)).clip(-3, 3) * pushes
    u[:, given.inputs:] = 1
    stays = of.x0 if np.allclose(of.A @ of.x0, of.x0, rtol=1e-6, atol=0) else np.zeros(of.n)  # far from 0 at rest
    x, z = of.x0 - stays, np.empty((rows, of.m))
    for t in range(rows):
        x = A @ x + root @ draws.standard_normal(of.n) + of.B @ u[t]
        z[t] = model.H @ (stays + x) + noise @ draws.standard_normal(of.m) + (0.0 if model.d is None else model.d)
    return read_off(z, model).astype(np.float32).astype(float), u.astype(np.float32).astype(float)


def exact(given: Request, record: Record, taken: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Means and covariances in long double, by Joseph's form; taken: the components that the filter took"""
    A, B, H, Q, R, x, P = (getattr(given.of, name).astype(float).astype(LONG)
                           for name in ("A", "B", "H", "Q", "R", "x0", "P0"))
    mixed, u = record.z.astype(LONG) @ given.mixing.astype(LONG).T - given.offsets, record.u.astype(LONG)
    means, covariances = np.empty((len(taken), len(A)), LONG), np.empty((len(taken), *A.shape), LONG)
    eye = np.eye(len(A), dtype=LONG)
    for t, bits in enumerate(taken.tolist()):
        if record.what[t] & PREDICTS:
            x, P = A @ x + B @ u[t], A @ P @ A.T + Q
        for j in (j for j in range(len(H)) if bits >> j & 1):
            row, y = P @ H[j], mixed[t, j] - H[j] @ x
            r = weighed(y, H[j] @ row, R[j], given.options.student)
            k = row / (H[j] @ row + r)
            column = k[:, None]
            left = eye - column * H[j]
            x, P = x + k * y, left @ P @ left.T + r * (column * k)
            P = (P + P.T) / 2
        means[t], covariances[t] = x, P
    return means, covariances


def weighed(y: np.longdouble, spread: np.longdouble, r: np.longdouble, student: Optional[float]) -> np.longdouble:
    """The variance that a component is taken with"""
    made, nu = r, student or 0.0
    for _ in range(STUDENT_STEPS if student else 0):
        share = made / (spread + made)
        made = (r * nu + (y * share) ** 2 + spread * share) / (nu + 1)
    return made


def accuracy(given: Request, record: Record, ran: Ran) -> Accuracy:
    means, covariances = exact(given, record, ran.taken)
    sigma = np.sqrt(np.einsum("tii->ti", covariances)).clip(1e-300)
    sigma = np.maximum(sigma, FADED * sigma.max(axis=0))
    apart = np.abs(ran.mean - means) / sigma
    spread = np.abs(ran.covariance - covariances) / (sigma[:, :, None] * sigma[:, None, :])
    count = sum(int(one).bit_count() for one in ran.taken)
    given_ = sum(int(one).bit_count() for one, what in zip(record.present, record.what) if what & UPDATES)
    return Accuracy(float(apart.max()), float(spread.max()), int(np.bitwise_or.reduce(ran.events)),
                    count / max(given_, 1))


def tried(given: Request, host: Host, rows: int, seed: int, longest: int = 0) -> Accuracy:
    record = drawn(given, rows, seed, longest)
    return accuracy(given, record, host.run(record.z, record.u, record.present, record.what))


def in_whole_groups(record: Record, together: Sequence[int]) -> Record:
    """Without samples of which a part with correlated noises is missing: the straight-line C leaves out all of it"""
    present = record.present.copy()
    for group in set(together):
        present[(present & group) != group] &= ~np.uint32(group)
    what = np.where(present > 0, record.what, record.what & PREDICTS).astype(np.uint8)
    return replace(record, present=present, what=what)
