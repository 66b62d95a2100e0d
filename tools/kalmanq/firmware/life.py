"""How far a model goes within so many rows: prior, noise and controls."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Iterator, Sequence

import numpy as np

from kalmanq.firmware.reach import MARGIN, Record
from kalmanq.model import Model
from kalmanq.run.filters import Filter

CHANCE = 1e-6  # that a model goes farther than is said, within a life
LIFE, LEAST_LIFE = 4, 10_000  # times the rows of the longest record; rows
STEPS, FOREVER, MOST_REPLAYED = 1024, 1 << 40, 100_000  # rows: one by one, until what fades has, of controls


@dataclass(frozen=True)
class Life:
    """How far a model goes within so many rows, without its measurements: states first, then measurements.

    reach    of each, left within the life with a chance of CHANCE at most; infinite: it grows by a power
    wanders  whether it goes farther in a longer life
    """

    rows: int
    reach: np.ndarray
    wanders: np.ndarray


def life_of(model: Model, records: Sequence[Record], rows: int) -> Life:
    """The variance of an estimate is at most that of the state: what holds the state holds its estimates."""
    sees = np.concatenate([np.eye(model.n), model.H])
    errors = np.concatenate([np.zeros(model.n), np.diag(model.R)])
    driven, ends = _driven(model, records, rows, sees)
    # what controls without end do is what the records' do: their mean by `driven`, their spread as noise
    loud = model.Q if model.B is None else model.Q + model.B @ _spread(model, records) @ model.B.T
    most, wanders, sigmas = np.zeros(len(sees)), ~ends, tail(rows * len(sees))
    for x0, P0 in _starts(model, records):
        for Q, which in ((model.Q, ends), (loud, ~ends)):
            if np.any(which):
                with np.errstate(over="ignore", invalid="ignore"):
                    now, later = (far + sigmas * np.sqrt(spread + errors)
                                  for far, spread in _grown(model, x0, P0, Q, rows, sees))
                # twice the rows are 2^n times as far at most, unless it grows by a power
                now = np.where(later <= 4.0**model.n * now, now, np.inf)
                most = np.where(which, np.fmax(most, now), most)
                wanders |= which & ~(later + driven <= 1.01 * (now + driven))
    most = most + driven
    most[model.n:] += 0.0 if model.d is None else np.abs(model.d)
    return Life(rows, most, wanders)


def tail(count: float) -> float:
    """Sigmas that so many Gaussian numbers stay within, but for CHANCE"""
    from scipy.special import ndtri

    return float(-ndtri(CHANCE / (2 * count)))


def _starts(model: Model, records: Sequence[Record]) -> list[tuple[np.ndarray, np.ndarray]]:
    """Mean and covariance that a life begins with: the prior; where that is unknown, what each record ends with."""
    if not np.any(model.unknown):
        return [(model.x0, model.P0)]
    ends = [Filter(model, "f64").run(one.z, one.u, covariance=True) for one in records if len(one.z)]
    return [(np.nan_to_num(run.mean[-1]), np.nan_to_num(run.covariance[-1], posinf=0.0)) for run in ends]


def _grown(model: Model, x0: np.ndarray, P0: np.ndarray, Q: np.ndarray, rows: int,
           sees: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """The largest |mean| and variance within a life, then within one of twice the rows: row by row at first, then at
    twice as many, and so on.  What fades is followed until it has."""
    A, W, count, fades, ends = np.eye(model.n), np.zeros((model.n, model.n)), 0, _fades(model), 0
    steps = -(-rows // (1 << max(0, int(np.ceil(np.log2(rows / STEPS))))))  # the life itself is twice as many, or again
    most, swing = np.zeros((2, len(sees))), np.zeros(len(sees))  # what P0 comes to again where A turns
    while ends < 2:
        before = most
        prior, noise = (np.einsum("ci,ij,cj->c", sees, one, sees) for one in (A @ P0 @ A.T, W))
        swing = np.fmax(swing, prior) if count >= steps // 2 else swing
        most = np.fmax(most, [np.abs(sees @ A @ x0), np.fmax(prior, swing) + noise])
        if ends or count >= rows and (not fades or count >= FOREVER or not np.any(most > 1.0001 * before)):
            yield most[0], most[1]
            ends += 1
        if count < steps:
            A, W, count = model.A @ A, model.A @ W @ model.A.T + Q, count + 1
        else:
            A, W, count = A @ A, A @ W @ A.T + W, 2 * count


def _fades(model: Model) -> bool:
    return bool(np.abs(np.linalg.eigvals(model.A)).max() < 1 - 1e-12)


def _given(records: Sequence[Record]) -> list[np.ndarray]:
    return [one.u for one in records if one.u is not None and len(one.u)]


def _spread(model: Model, records: Sequence[Record]) -> np.ndarray:
    given = _given(records)
    return np.atleast_2d(np.cov(np.concatenate(given).T, bias=True)) if given else np.zeros((model.l, model.l))


def _driven(model: Model, records: Sequence[Record], rows: int, sees: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """How far controls drive each, and whether that has an end: by any controls within their ranges where it has,
    otherwise by the recorded ones, over and over."""
    total, last = np.zeros(len(sees)), np.zeros(len(sees))
    if model.B is None:
        return total, total == 0
    column = model.B * controls_reach(model, records)
    for _ in range(MOST_REPLAYED if _fades(model) else 2 * STEPS):
        last = np.abs(sees @ column).sum(axis=1)
        total, column = total + last, model.A @ column
        if not np.any(last > 1e-6 * total):
            break
    ends = (last <= 1e-6 * total) | _fades(model)
    return np.where(ends, total, _replayed(model, records, rows, sees)), ends


def _replayed(model: Model, records: Sequence[Record], rows: int, sees: np.ndarray) -> np.ndarray:
    most = np.zeros(len(sees))
    for u in _given(records):
        x, pushes = np.zeros(model.n), u @ np.asarray(model.B).T
        for row in range(min(rows, MOST_REPLAYED)):
            x = model.A @ x + pushes[row % len(u)]
            most = np.fmax(most, np.abs(sees @ x))
    return most


def controls_reach(model: Model, records: Sequence[Record]) -> np.ndarray:
    """As far as is declared, or as those of the records tell"""
    given = _given(records)
    if not given:
        return np.array([one.range or 0.0 for one in model.controls])
    u = np.concatenate(given)
    seen = np.fmax(np.abs(u).max(axis=0), np.abs(u.mean(axis=0)) + tail(LIFE * u.size) * u.std(axis=0) / MARGIN)
    return np.array([MARGIN * span if one.range is None else one.range for one, span in zip(model.controls, seen)])
