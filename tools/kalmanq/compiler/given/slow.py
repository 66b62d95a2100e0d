"""Entries of U and D that change by less than a float resolves in a row, and do not forget what was lost.

A variance of 0.04 that grows by 1e-9 a row stays where it is in a float, and one that is divided by a sum that has grown by
as little shrinks by what the quotient is rounded by.  Such entries are carried in two numbers.  They are found in P after
2^18 and more rows, in decimals: without an enumeration of rows, by doubling.
"""

from __future__ import annotations

import decimal
from dataclasses import dataclass
from decimal import Decimal
from itertools import permutations
from typing import Iterator, Optional, Sequence

import numpy as np

from kalmanq.compiler.given.enclosure import BEYOND, DIGITS, steps
from kalmanq.compiler.given.exact import Numbers, ordered, predicted, symmetric, taken
from kalmanq.compiler.given.request import GAP, LONGEST_GAP, Request
from kalmanq.errors import KalmanqError
from kalmanq.formulas.calculus import without
from kalmanq.formulas.graph import Node, mul

TIMES = range(18, 28, 2)  # rows, as powers of two: less do not add up to a percent, more are not asked for
WORD_TIMES = range(8, 28, 2)  # of words, whose last bit is the same however small a sigma becomes
RESOLVED = 2.0**-18  # of a variance, what it changes by in a row: a float has a percent of it
ROUNDED, ROUNDINGS = 2.0**-22, 4  # of an entry, in a row, which takes so many operations; of what it moves by it is one
COUNTS = 2.0**-7  # of a variance, what is lost of it
NOTICED = 2.0**-12  # the same of a float, where a second number may be carried
TRIED = 1e-12  # of an entry, by which it is moved to see what is left of that a row later
MOST_ORDERED = 3  # slow states, of which all orders are tried
MOST_OF_U = 9  # states, of which U is looked at, too
Key = tuple[int, int]


@dataclass(frozen=True)
class Lost:
    """rows: from how many on; is_small: what it moves by in a row is so small that two numbers keep it; counts: more than 1 % of a
    variance is lost"""

    rows: int
    is_small: bool
    counts: bool


def slow_entries(given: Request, order: Sequence[int]) -> dict[Key, Lost]:
    """Of the factor of states in this order"""
    found: dict[Key, Lost] = {}
    with decimal.localcontext(DIGITS):
        of = ordered(given.of, order)
        for gap in (0, min(max(given.model.gaps.max_gap, GAP), LONGEST_GAP)):
            for rows, P in after_long(of, gap):
                for key, is_small, counts in _lost(of, P, gap, rows):
                    before = found.get(key, Lost(rows, True, False))
                    found[key] = Lost(min(rows, before.rows), is_small and before.is_small, counts or before.counts)
    return {key: found[key] for key in sorted(found, key=lambda key: (key[1], key[0]))}


def slow_words(given: Request, word: Sequence[float]) -> dict[int, int]:
    """States whose sigma moves by less than a word of it, and does not forget it; from how many rows on.  word: of each sigma"""
    found: dict[int, int] = {}
    with decimal.localcontext(DIGITS):
        for rows, P in after_long(given.of, 0, WORD_TIMES):
            chain = list(_cycle(given.of, P, 0))
            for i, least in enumerate(map(Decimal, word)):
                sigma = [one[i, i].sqrt() for one in chain]
                moves = max(abs(after - before) for before, after in zip(sigma, sigma[1:]))
                if i in found or not 0 < moves < 2 * least:
                    continue
                moved = P.copy()
                moved[i] *= 1 + Decimal(TRIED)
                moved[:, i] *= 1 + Decimal(TRIED)
                if least > sigma[0] * Decimal(COUNTS) * _forgotten(given.of, chain, moved, 0, rows):
                    found[i] = rows
    return found


def slow_states(given: Request) -> list[int]:
    """Whose variance a predict hardly moves"""
    with decimal.localcontext(DIGITS):
        pairs = [(np.diag(P), np.diag(predicted(given.of, P))) for _, P in after_long(given.of, 0)]
        return [i for i in range(given.of.n) if any(abs(after[i] - P[i]) <= Decimal(RESOLVED) * P[i] for P, after in pairs)]


def orders(n: int, slow: Sequence[int]) -> Iterator[tuple[int, ...]]:
    """As the model has them; then with slow states at the end, where their variances are entries of D"""
    yield tuple(range(n))
    fast = [i for i in range(n) if i not in slow]
    for last in permutations(slow) if len(slow) <= MOST_ORDERED else (tuple(slow), tuple(reversed(slow))):
        yield (*fast, *last)


def after_long(of: Numbers, gap: int, times: range = TIMES) -> Iterator[tuple[int, np.ndarray]]:
    """Rows, and P after so many, each with a full sample after a gap; up to where one grows beyond all digits"""
    predict, (cycle,) = steps(of, [range(of.m)])
    for _ in range(gap):
        cycle = predict.then(cycle)
    for doublings in range(1, max(times) + 1):
        try:
            cycle = cycle.then(cycle)
            P = cycle.of(of.P0) if doublings in times else None
        except (KalmanqError, decimal.DecimalException):
            return
        if P is not None and np.all(np.diag(P) >= 0) and np.diag(P).max() < BEYOND:
            yield 2**doublings, P


def _lost(of: Numbers, P: np.ndarray, gap: int, rows: int) -> Iterator[tuple[Key, bool, bool]]:
    chain = list(_cycle(of, P, gap))
    factors = [_factor(one) for one in chain]
    first, left = factors[0], {}
    for (i, k), value in sorted(first.items(), key=lambda one: one[0][0] != one[0][1]):  # D before U
        moves = max(abs(after[i, k] - before[i, k]) for before, after in zip(factors, factors[1:]))
        if not value or not moves or i < k and of.n > MOST_OF_U:
            continue
        moved = _product({**first, (i, k): value + abs(value) * Decimal(TRIED)}, of.n)
        forgotten = left[i, k] = _forgotten(of, chain, moved, gap, rows)
        scale = value if i == k else (P[i, i] / first[k, k]).sqrt() if first[k, k] else abs(value)
        rows_of_H = () if i == k else [(h[i], h[k] + sum(h[c] * first[c, k] for c in range(k)), h @ P @ h + r) for h, r in zip(of.H, of.R)]

        def is_lost(size: Decimal, counts: float = NOTICED) -> bool:
            """Of what is rounded: itself, or D by what the rows of H U, wrong by it, seem to tell of D"""
            error = Decimal(ROUNDED) * size / forgotten
            told = sum(abs(h) * error * (2 * abs(f) + abs(h) * error) / s for h, f, s in rows_of_H) * first[k, k] / left.get((k, k), 1)
            return error > Decimal(counts) * scale or told > Decimal(counts)

        if is_lost(abs(value)):
            counts = is_lost(abs(value), COUNTS)
            yield (i, k), not is_lost(moves / ROUNDINGS, COUNTS if counts else NOTICED), counts


def _forgotten(of: Numbers, chain: Sequence[np.ndarray], moved: np.ndarray, gap: int, rows: int) -> Decimal:
    """What is not left of a change of P, the first of the chain, a cycle later; at least what the rows so far can have left"""
    *_, end = _cycle(of, moved, gap)
    size = _size(moved - chain[0], chain[0])
    return max(1 - _size(end - chain[-1], chain[0]) / size, Decimal(1) / rows) if size else Decimal(1)


def _size(difference: np.ndarray, P: np.ndarray) -> Decimal:
    """The root of the sum of squares, over sigma_i sigma_j: a rotation leaves it as it is"""
    return sum((one * one / (P[i, i] * P[k, k]) for (i, k), one in np.ndenumerate(difference) if P[i, i] and P[k, k]), Decimal(0)).sqrt()


def _cycle(of: Numbers, P: np.ndarray, gap: int) -> Iterator[np.ndarray]:
    yield P
    for _ in range(gap + 1):
        P = predicted(of, P)
        yield P
    for j in range(of.m):
        P = taken(of, P, j)
        yield P


def _factor(P: np.ndarray) -> dict[Key, Decimal]:
    n, rest, made = len(P), P.copy(), {}
    for k in reversed(range(n)):
        d = made[k, k] = max(rest[k, k], Decimal(0))
        u = rest[:k, k] / d if d else rest[:k, k] * 0
        made.update({(i, k): u[i] for i in range(k)})
        rest[:k, :k] = rest[:k, :k] - np.outer(u, u) * d
    return made


def _product(entries: dict[Key, Decimal], n: int) -> np.ndarray:
    U = np.array([[entries[i, k] if i < k else Decimal(int(i == k)) for k in range(n)] for i in range(n)])
    return symmetric((U * np.array([entries[k, k] for k in range(n)])) @ U.T)


def change(value: Node, term: Node) -> Optional[Node]:
    """value - term, where the value is a sum of the term, or of its product with a constant, and others.  None: it is not"""
    found = without(value, term)
    if found is not None:
        return found
    if value.op == "mul" and value.args[1] is term and value.args[0].is_constant:
        return mul(value.args[0].value - 1, term)
    if value.op not in ("add", "sub"):
        return None
    first, second = value.args
    found = change(first, term)
    if found is not None:
        return found + second if value.op == "add" else found - second
    found = change(second, term) if value.op == "add" else None
    return None if found is None else first + found
