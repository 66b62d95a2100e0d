"""Rows of A x + B u and of z - H x that a float rounds by more than their share of a sigma.

A state of 1e4 with a sigma of 1e-3 is rounded by as much as its sigma in each row, by its coefficients above all, and a filter
with a long memory adds that up.  Of each row it is known what its coefficients and sums are rounded by at the ends of the
ranges, and what the filter remembers of that, in sigmas after 2^14 rows: coefficients err to one side, sums to either.
"""

from __future__ import annotations

import decimal
from typing import Optional

import numpy as np

from kalmanq.compiler.given.enclosure import DIGITS, Settled
from kalmanq.compiler.given.exact import Numbers
from kalmanq.compiler.given.request import Request
from kalmanq.compiler.given.slow import after_long

ROWS = 14  # 16384 rows, as a power of two
BLOCK = 128  # of them
HALF = 2.0**-25  # of a number, what a float rounds it by at most
OFTEN = 2.5  # of what sums are rounded by, the root of their squares: as far as some row is off
GOAL = 3e-4  # sigma


def far_rows(given: Request, steady: Optional[Settled]) -> tuple[list[int], list[int]]:
    """States whose A x + B u, and components whose z - H x, are to be worked out in double words"""
    P = steady.filtered if steady and steady.samples <= 1 << ROWS else _late(given.of)
    if P is None:
        return [], []
    with np.errstate(all="ignore"):  # of what nothing sees
        bound = _bound(given, P.astype(float))
    order = np.argsort(bound)
    is_far = [*order[np.cumsum(bound[order]) > GOAL]]  # the others add up to less
    return [i for i in range(given.of.n) if i in is_far], [j for j in range(given.of.m) if given.of.n + j in is_far]


def _late(of: Numbers) -> Optional[np.ndarray]:
    with decimal.localcontext(DIGITS):
        return next((P for _, P in after_long(of, 0, range(ROWS, ROWS + 1))), None)


def _bound(given: Request, P: np.ndarray) -> np.ndarray:
    """Of each state and component, in sigma"""
    of, model = given.of.doubles(), given.model
    constant, rounded = _remembered(of, P)
    first = np.where(model.unknown, 0.0, np.sqrt(np.diag(of.P0)))
    states = np.array([one.range or abs(x) + sigma for one, x, sigma in zip(model.states, of.x0, first)])
    controls = [1.0 if one.constant else one.range or 0.0 for one in model.controls]
    z = np.array([one.range or 0.0 for one in model.measurements])
    moved = _errors(np.hstack([of.A - np.eye(of.n), of.B]), np.concatenate([states, controls]), of.n)
    seen = _errors(np.hstack([given.mixing - np.eye(of.m), -np.diag(given.offsets), of.H]), np.concatenate([z, z**0, states]), 0)
    off, sums = (np.concatenate(both) for both in zip(moved, seen))
    return np.nan_to_num(constant * off + OFTEN * rounded * sums, nan=0.0)


def _remembered(of: Numbers, P: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of an error of 1 in each predicted state and each innovation of all rows, at most what is left, in sigmas: to one side, to either"""
    M = of.A @ P @ of.A.T + of.Q
    K = np.linalg.solve(of.H @ M @ of.H.T + np.diag(of.R), of.H @ M).T
    left = np.eye(of.n) - K @ of.H
    powers = [np.eye(of.n)]
    for _ in range(BLOCK):
        powers.append(powers[-1] @ left @ of.A)
    now, sums, squares = np.hstack([left, K]), 0.0, 0.0
    for _ in range((1 << ROWS) // BLOCK):
        block = np.array(powers[:-1]) @ now
        sums, squares, now = sums + np.abs(block).sum(axis=0), squares + (block**2).sum(axis=0), powers[-1] @ now
    sigma = np.sqrt(np.diag(P))
    has, sigma = sigma > 0, sigma[:, None]  # a state without one is known
    return (sums / sigma)[has].max(axis=0, initial=0), (np.sqrt(squares) / sigma)[has].max(axis=0, initial=0)


def _errors(C: np.ndarray, sizes: np.ndarray, pairs: int) -> tuple[np.ndarray, np.ndarray]:
    """What the coefficients of rows are rounded by, times the sizes, and their sums; pairs: columns whose values are rounded first"""
    is_there, is_exact = C != 0, np.frexp(np.abs(C))[0] == 0.5
    after = np.cumsum(is_there[:, ::-1], axis=1)[:, ::-1] - is_there + (np.arange(C.shape[1]) < pairs)
    return np.abs(C.astype(np.float32) - C) @ sizes, HALF * (np.abs(C) * (after + ~is_exact)) @ sizes
