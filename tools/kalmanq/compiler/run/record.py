"""Records that a compiled filter is tried with, and the same filter in long double beside it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Optional, Sequence

import numpy as np

from kalmanq.compiler.given.request import GAP, STUDENT_STEPS, Request, due
from kalmanq.compiler.run import truth
from kalmanq.compiler.run.host import Host, Ran
from kalmanq.compiler.text.emit import PREDICTS, UPDATES
from kalmanq.compiler.text.product import Product
from kalmanq.core import ffi, lib
from kalmanq.model import root_of
from kalmanq.run.simulation import read_off

LONG = np.longdouble
FADED = 1e-12  # of its largest sigma: a state without noise that fades away is known, and no error is told of it
Moments = tuple[np.ndarray, np.ndarray]


@dataclass(frozen=True)
class Record:
    """what, present: of each row, as Host.run takes them; z: rows x m; u: rows x l, of the step that leads to the row; now: of
    the row itself, where a model reads them there; clock: rows x 3, t of the row before, the step between them, t of the row;
    mean: of a filter that is settled before the first row"""

    what: np.ndarray
    present: np.ndarray
    z: np.ndarray
    u: np.ndarray
    now: Optional[np.ndarray] = None
    clock: Optional[np.ndarray] = None
    mean: Optional[np.ndarray] = None

    @property
    def measured(self) -> np.ndarray:
        """z with NaN where it is missing"""
        return np.where(self.present[:, None] >> np.arange(self.z.shape[1]) & 1, self.z, np.nan)


def clock_of(times: np.ndarray, dt: float = np.nan) -> np.ndarray:
    """dt: of the step to the first row"""
    return np.column_stack([np.concatenate([times[:1] - dt, times[:-1]]), np.diff(times, prepend=times[:1] - dt), times])


def times_of(record: Record) -> Optional[np.ndarray]:
    return None if record.clock is None else record.clock[:, 2]


@dataclass(frozen=True)
class Accuracy:
    """The largest errors of a record: of a mean in sigma, of a covariance in sigma_i sigma_j"""

    mean: float
    covariance: float
    events: int
    taken: float  # share of the components that were given


def drawn(given: Request, rows: int, seed: int, longest: int = 0, first: Optional[np.ndarray] = None) -> Record:
    """Samples of the model with what happens in the field: gaps, components that are missing, second updates.  first: the steady
    covariance, of a record that begins settled"""
    draws, longest = np.random.default_rng(seed), longest or 2 * max(given.model.gaps.max_gap, GAP)
    what, present = _events(given, rows, longest, draws)
    what[0] |= 0 if first is None else PREDICTS
    x, u, mean = truth.drawn(given, what & PREDICTS > 0, draws, first)
    z = x @ given.model.H.T + draws.standard_normal((rows, given.of.m)) @ root_of(np.asarray(given.model.R)).T
    z = read_off(z + (0.0 if given.model.d is None else given.model.d), given.model)
    return Record(what, present, z.astype(np.float32).astype(float), u, mean=None if first is None else mean)


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


def exact_of(given: Request, record: Record, taken: np.ndarray, first: Optional[np.ndarray] = None) -> Moments:
    """Means and covariances in long double, by Joseph's form, on the model's numbers; taken: the components that the filter took;
    first: covariance before the first row, the model's if None"""
    rows, n, nu = len(taken), given.of.n, given.options.student
    means, covariances = np.empty((rows, n), LONG), np.empty((rows, n, n), LONG)
    means[0] = given.of.x0.astype(float) if record.mean is None else record.mean
    covariances[0] = given.of.P0.astype(float) if first is None else first
    held = [_long(getattr(given.of, name).astype(float)) for name in ("A", "B", "H", "Q", "R")]
    z = record.z.astype(LONG) @ given.mixing.astype(LONG).T - given.offsets
    exact = ffi.new("kq_exact *", (n, given.of.m, given.of.l, STUDENT_STEPS if nu else 0, *held, nu or 0.0, work := _long(np.empty(n * (n + 3)))))
    lib.kq_exact_run(exact, rows, ffi.from_buffer("uint8_t[]", np.ascontiguousarray(record.what & PREDICTS, np.uint8)),
                     ffi.from_buffer("uint32_t[]", np.ascontiguousarray(taken, np.uint32)), _long(record.u), _long(z), _long(means), _long(covariances))
    return means, covariances


def _long(values: np.ndarray) -> Any:
    return ffi.from_buffer("long double[]", np.ascontiguousarray(values, LONG))


def apart(given: Request, record: Record, ran: Ran, means: np.ndarray, covariances: np.ndarray) -> Accuracy:
    sigma = np.sqrt(np.einsum("tii->ti", covariances)).clip(1e-300)
    sigma = np.maximum(sigma, FADED * sigma.max(axis=0))
    off = np.abs(ran.mean - means) / sigma
    spread = np.abs(ran.covariance - covariances) / (sigma[:, :, None] * sigma[:, None, :])
    whole = in_whole_groups(record, given.together)
    count, given_ = (np.count_nonzero(one[:, None] >> np.arange(given.of.m) & 1) for one in (ran.taken, whole.present[whole.what & UPDATES > 0]))
    return Accuracy(float(off.max()), float(spread.max()), int(np.bitwise_or.reduce(ran.events)), count / max(given_, 1))


def tried(product: Product, host: Host, rows: int, seeds: Sequence[int], longest: int = 0, is_settled: bool = False) -> list[Accuracy]:
    """Records from the start, or such that begin settled, with measurements as the filter takes them"""
    given, first = product.given, product.arithmetic.steady.filtered.astype(float) if is_settled else None
    records = [as_taken(product, drawn(given, rows, seed, longest, first)) for seed in seeds]
    ran = [host.run_record(one) for one in records]
    return [apart(given, record, one, *exact_of(given, record, one.taken, first)) for record, one in zip(records, ran)]


def as_taken(product: Product, record: Record) -> Record:
    """In fixed point rounded to raw values"""
    a = product.arithmetic
    if product.given.options.arithmetic != "q31":
        return record

    def rounded(which: str, values: np.ndarray) -> np.ndarray:
        return np.ldexp(a.raws(which, values), -a.fractions(which, values.shape[1]))
    mean = None if record.mean is None else rounded("states", record.mean[None])[0]
    return replace(record, z=rounded("measurements", record.z), u=rounded("controls", record.u), mean=mean)


def in_whole_groups(record: Record, together: Sequence[int]) -> Record:
    """Without samples of which a part with correlated noises is missing: the straight-line C leaves out all of it"""
    present = record.present.copy()
    for group in set(together):
        present[(present & group) != group] &= ~np.uint32(group)
    what = np.where(present > 0, record.what, record.what & PREDICTS).astype(np.uint8)
    return replace(record, present=present, what=what)
