"""What a compiled filter is tried on: states that follow the model, from its first mean and sigma, within its ranges.

A state that wanders leaves every range one day.  So the draws of the process noise, and the controls, are those of a path
that stays: each is moved by a feedback, the least one that keeps the sigma of every state within a quarter of its range.
The path follows the model to the last bit; only its noise is not white to one who looks for it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Optional

import numpy as np

from kalmanq.compiler.algorithm.fixed.formats import gap_of, largest_sigmas, ranged
from kalmanq.compiler.given.exact import Numbers
from kalmanq.compiler.given.request import Request
from kalmanq.core import ffi, lib
from kalmanq.model import Model, root_of

PUSHED, STAYS, BEGINS = 0.2, 0.25, 0.8  # of a range: sigma of a control, and of a state; where a record begins at most
EASY = 30.0  # a control, in sigmas of what it is moved by anyway, that costs what one of a noise does
LOOKED_AT = 1000  # rows
LONGEST = 16  # doublings of a row: for so many it is known how far states go
WEIGHTS = 10.0 ** np.arange(-12, 7)  # of a state at the end of its range, in a square of a noise's sigma
LARGEST = 1e100


@dataclass(frozen=True)
class Path:
    """What holds of each record of a request.  by: of noises and controls; back, spread: of the feedback; bound: rows within which it stays"""

    noise: np.ndarray
    push: np.ndarray
    most: np.ndarray
    constant: np.ndarray
    rests: np.ndarray
    holds: np.ndarray
    by: np.ndarray
    back: np.ndarray
    spread: np.ndarray
    bound: np.ndarray


@lru_cache(maxsize=8)
def _path(given: Request) -> Path:
    of, model = given.of.doubles(), ranged(given.model, largest_sigmas(given.of, gap_of(given.model)))
    noise, push = root_of(of.Q), np.array([0.0 if one.constant else PUSHED * (one.range or 1.0) for one in given.model.controls])
    most = push / PUSHED
    constant = np.array([float(one.constant) for one in model.controls])
    rests, holds = _rest(of.A, of.B, of.x0, constant, np.array([one.range or 1.0 for one in model.states]), most)
    by = np.hstack([noise, EASY * of.B * push])
    limits = _limits(model, rests, of.n)
    back, spread = _feedback(of.A, by, noise.shape[1], limits)
    return Path(noise, push, most, constant, rests, holds, by, back, spread, np.vstack([limits / BEGINS, back[:noise.shape[1]]]))


def drawn(given: Request, moves: np.ndarray, draws: np.random.Generator,
          first: Optional[np.ndarray] = None) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """States of rows, controls of the steps to them, and the mean before the first row; moves: has a row such a step?
    first: covariance of a mean that is anywhere within the ranges; None: the model's mean and covariance"""
    rows, of, path = len(moves), given.of.doubles(), _path(given)
    rests, back, columns = path.rests, path.back, path.noise.shape[1]
    x, u = np.empty((rows, of.n)), np.empty((rows, of.l))
    anywhere = of.x0 if first is None else rests + root_of(path.spread) @ draws.standard_normal(of.n)
    begun = root_of(of.P0 if first is None else first) @ draws.standard_normal(of.n)
    now = rests + _within(anywhere - rests + begun, of.A - path.by @ back, path.bound)
    mean = of.x0 if first is None else (now - begun).astype(np.float32).astype(float)
    w, pushed = np.split(draws.standard_normal((rows, path.by.shape[1])), [columns], axis=1)
    _walked(path, of, moves, w, pushed, now, x, u)
    return x, u, mean


def _walked(path: Path, of: Numbers, moves: np.ndarray, w: np.ndarray, pushed: np.ndarray, now: np.ndarray, x: np.ndarray, u: np.ndarray) -> None:
    """x and u are written"""
    columns = path.noise.shape[1]
    held = [_doubles(one) for one in (of.A, of.B, path.noise, path.back[:columns], EASY * path.back[columns:], path.rests, path.holds, path.push,
                                      path.most, path.constant, now.copy(), np.empty(of.n + columns))]
    lib.kq_path_run(ffi.new("kq_path *", (of.n, columns, of.l, *held)), len(moves), ffi.from_buffer("uint8_t[]", np.ascontiguousarray(moves, np.uint8)),
                    _doubles(w), _doubles(pushed), _doubles(x), _doubles(u))


def _doubles(values: np.ndarray) -> Any:
    """As they are, where they are that already"""
    return ffi.from_buffer("double[]", np.ascontiguousarray(values, np.float64))


def _rest(A: np.ndarray, B: np.ndarray, x0: np.ndarray, constant: np.ndarray, span: np.ndarray, most: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Where the model stays, as near to x0 as it may, and the controls that hold it there; 0 where there is nothing of that within
    the ranges"""
    none, sizes = (np.zeros(len(x0)), np.zeros(len(most))), np.concatenate([span, most])
    moves = np.hstack([A - np.eye(len(A)), B])
    left = -(moves @ np.concatenate([x0, constant]))
    rows = np.abs(moves * sizes).max(axis=1).clip(1e-300)
    steps = np.linalg.lstsq(moves * sizes / rows[:, None], left / rows, rcond=1e-12)[0]
    at = np.concatenate([x0, 0 * most]) + sizes * steps
    is_there = np.allclose(moves @ (sizes * steps) / rows, left / rows, rtol=0, atol=1e-9 * np.abs(left / rows).max(initial=1e-300))
    return (at[:len(x0)], at[len(x0):]) if is_there and np.all(np.abs(at) <= BEGINS * sizes + np.concatenate([np.abs(x0), 0 * most])) else none


def _limits(model: Model, rests: np.ndarray, n: int) -> np.ndarray:
    """Rows that each make 1 of a state or a measurement at the end of its range"""
    room = [max((one.range or np.inf) - abs(x), 0.1 * (one.range or np.inf)) for one, x in zip(model.states, rests)]
    seen = model.H @ rests
    room_of_z = [max((one.range or np.inf) - abs(z), 0.1 * (one.range or np.inf)) for one, z in zip(model.measurements, seen)]
    return np.vstack([np.eye(n) / np.array(room)[:, None], model.H / np.array(room_of_z)[:, None]])


def _within(start: np.ndarray, F: np.ndarray, bound: np.ndarray) -> np.ndarray:
    """As far from where it rests as no row of `bound` makes more than 1 of, once nothing but the feedback moves it"""
    most, ahead = np.abs(bound @ start).max(), start
    for _ in range(LOOKED_AT):
        ahead = F @ ahead
        most = max(most, np.abs(bound @ ahead).max())
    for _ in range(LONGEST):
        F = F @ F
        most = max(most, np.abs(bound @ F @ start).max())
    return start / max(1.0, most) if np.isfinite(most) else 0 * start


def _feedback(A: np.ndarray, by: np.ndarray, noises: int, limits: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The least that keeps `limits` of the states, in sigmas of what moves them and in units of controls that cost as little; and
    how far states go with it"""
    made, spread, moved = np.zeros((by.shape[1], len(A))), None, by / np.where(np.arange(by.shape[1]) < noises, 1, EASY)
    for weight in (0.0, *WEIGHTS):
        try:
            made = _regulator(A, by, weight * limits.T @ limits) if weight else made
        except np.linalg.LinAlgError:  # nothing keeps such limits
            break
        spread = _spread(A - by @ made, moved @ moved.T)
        if spread is not None and np.sqrt(np.einsum("ij,jk,ik->i", limits, spread, limits)).max() <= STAYS:
            break
    return made, np.zeros(A.shape) if spread is None else spread


def _regulator(A: np.ndarray, by: np.ndarray, cost: np.ndarray) -> np.ndarray:
    """Linear and quadratic, by doubling (Anderson 1978): what it takes of the states"""
    F, G, S, eye = A, by @ by.T, cost, np.eye(len(A))
    for _ in range(LONGEST):
        if max(np.abs(F).max(), np.abs(S).max()) > LARGEST:
            break
        W = np.linalg.inv(eye + G @ S)
        F, G, S = F @ W @ F, G + F @ W @ G @ F.T, S + F.T @ S @ W @ F
        G, S = (G + G.T) / 2, (S + S.T) / 2
    return np.linalg.solve(np.eye(by.shape[1]) + by.T @ S @ by, by.T @ S @ A)


def _spread(F: np.ndarray, N: np.ndarray) -> Optional[np.ndarray]:
    """What noise makes in 2^16 rows; None: beyond all ranges"""
    for _ in range(LONGEST):
        F, N = F @ F, N + F @ N @ F.T
        if not max(np.abs(F).max(), np.abs(N).max()) < LARGEST:
            return None
    return N
