"""What grows without end while nothing is measured: whether a model has it, and where the C looks at it.

P grows along the directions whose eigenvalues are beyond 1.  In U D U' the entry of D of the last state that such a
direction moves grows with it, so predict looks at this entry alone.  Where it is large, a function looks at each state.
"""

from __future__ import annotations

import decimal
from dataclasses import dataclass
from typing import Any, Callable, Optional, Sequence

import numpy as np

from kalmanq.compiler.given.enclosure import DIGITS, Settled
from kalmanq.compiler.given.exact import Numbers
from kalmanq.compiler.given.request import Request, first_variances

EVENT = ("OVERFLOW", "a mean or a variance grew without end: of such a state nothing is known, until measurements bring it back")
RATE = 2.0**-24  # of a mean, in a step: slower growth is not above rounding, and takes 7e8 missing samples in a row
DOUBLINGS = 40
RATIO = {"float": 2.0**44, "double": 2.0**90}  # of a variance over what the state is known with: an update rounds by a share of it
LARGEST = {"float": 1e24, "double": 1e200}  # of any variance and the square of any mean
ROOM = 2.0**16  # from what a variance is held at to where it is held: steps in which measurements have not yet seen all
NEAR = 2.0**-6  # of a limit, where predict begins to look closer
GONE = 1e-6  # of a direction, scaled: it does not move the state
UNMOVED = 1e-24  # of a direction, squared: no noise drives it


def grows(of: Numbers) -> bool:
    """Is the spectral radius of A above 1?  It is at most |A^k|^(1/k), which is at most 1e-9 above it for this k."""
    with decimal.localcontext(DIGITS):
        power = of.A
        for _ in range(DOUBLINGS):
            power = power @ power
        norm = of.n * max(abs(one) for one in power.ravel())
        return bool(norm) and float(norm.ln()) > RATE * 2.0**DOUBLINGS


@dataclass(frozen=True)
class Growth:
    """most: of each variance, where its state is held.  looked_at: states whose D a predict looks at, and up to which value it
    does no more.  by_itself: may a mean grow where no variance does?"""

    most: np.ndarray
    looked_at: dict[int, float]
    by_itself: bool


def growth(given: Request, steady: Optional[Settled], type_: str, is_free: bool) -> Optional[Growth]:
    """None: nothing grows without end.  is_free: a program may set A, so all is looked at"""
    of = given.of.doubles()
    if not (is_free or grows(given.of)):
        return None
    scale = np.sqrt(np.where((spread := np.diag(of.P0) + np.diag(of.Q)) > 0, spread, 1.0))
    scaled = of.A * scale / scale[:, None]
    values, vectors = np.linalg.eig(scaled)
    grown = vectors[:, np.abs(values) > 1 + RATE / 2]
    if is_free or not grown.size:
        most, looked_at = _most(given, steady, type_), {}
        return Growth(most, {i: NEAR * one for i, one in enumerate(most)}, False)
    moved = np.abs(grown).max(axis=1) > GONE
    most = np.where(moved, _most(given, steady, type_), LARGEST[type_])
    looked_at = {k: NEAR * float(np.min(most[moved] / share[moved].clip(GONE**4)))
                 for k, share in _leading(np.hstack([grown.real, grown.imag]), scale)}
    return Growth(most, looked_at, not _is_driven(scaled, of.Q / np.outer(scale, scale)))


def _most(given: Request, steady: Optional[Settled], type_: str) -> np.ndarray:
    of = given.of.doubles()
    known = np.diag(steady.filtered).astype(float) if steady else first_variances(of, np.ones(of.n, bool))
    ranges = np.array([one.range or 0.0 for one in given.model.states])
    least = np.maximum.reduce([np.diag(of.P0), ranges**2, of.x0**2, known])
    return np.minimum(np.maximum(RATIO[type_] * known, ROOM * least), LARGEST[type_])


def _leading(left: np.ndarray, scale: np.ndarray) -> list[tuple[int, np.ndarray]]:
    """The last state that each direction moves, and variances along it, that state's being 1"""
    made = []
    for k in reversed(range(len(left))):
        size = np.abs(left).max(axis=0)
        shares = np.where(size > GONE, np.abs(left[k]) / np.maximum(size, GONE), 0)
        if shares.max() > GONE:
            pivot = left[:, int(np.argmax(shares))]
            made.append((k, (pivot * scale / (pivot[k] * scale[k]))**2))
            left = left - np.outer(pivot, left[k] / pivot[k])
    return made


def _is_driven(A: np.ndarray, Q: np.ndarray) -> bool:
    """Does noise move each growing direction?"""
    values, vectors = np.linalg.eig(A.T)
    grown = vectors[:, np.abs(values) > 1 + RATE / 2]
    return bool(np.all(np.einsum("ik,ij,jk->k", grown.conj(), Q, grown).real > UNMOVED))


def hold(given: Request, number: Callable[[float], str], most: Sequence[float], live: int, place: Sequence[int],
         first: Sequence[float] = ()) -> dict[str, Any]:
    """What NAME.c is given.  most: of each variance; place: of U and D column after column, P[k] with k < live; empty: all are carried, in
    this order; first: means that functions of the model have a value for; otherwise 0"""
    return {"most": [*map(number, most)] if len(set(most)) > 1 else [number(most[0])], "place": place, "live": live,
            "held": number(1 / ROOM) if len(set(most)) > 1 else number(most[0] / ROOM), "first": [] if given.nominal else [*map(number, first)]}
