"""Free parameters as a vector without bounds, in which the likelihood is about as curved in every direction:
about, since a unit that is right where the search begins may be wrong where it ends, and is then made anew.

A covariance C is L L'.  Below the diagonal L moves linearly, the logarithm of the diagonal does (Pinheiro and Bates
1996), so that C is positive definite wherever the vector is; an entry of C that is held is solved for.  One is the
standard deviation that a coordinate would have if the states were measured without noise.
"""

from __future__ import annotations

from typing import Optional

import numpy as np

FARTHEST = 35.0  # log of a standard deviation from where it began: a variance changes by e^70 at most
FLOOR = 1e-12  # share of its variance that each noise has by itself at least: C is never as good as singular


class Infeasible(Exception):
    """There is no covariance with the entries that are held."""


class Entries:
    """Free entries of A, H or x0 (`free`: a mask), each in units of `scale`."""

    def __init__(self, name: str, start: np.ndarray, free: np.ndarray, scale: np.ndarray):
        self.name, self.start, self.at = name, start.copy(), np.nonzero(free)
        self.scale = scale[self.at]
        self.size = len(self.scale)
        self.logarithmic = np.zeros(self.size, bool)
        self.units = np.ones(self.size)

    def matrix(self, x: np.ndarray) -> np.ndarray:
        made = self.start.copy()
        made[self.at] += self.scale * x
        return made

    def grown(self, scale: np.ndarray) -> np.ndarray:
        """The units that it has in `scale`, in those that it has."""
        return scale[self.at] / self.scale

    def rescale(self, ratio: np.ndarray) -> None:
        self.scale = self.scale * ratio

    def slopes(self, gradient: np.ndarray) -> np.ndarray:
        return gradient[self.at] * self.scale

    def tangent(self) -> np.ndarray:
        """The matrix's derivative to each coordinate: shape x size."""
        made = np.zeros((*self.start.shape, self.size))
        made[(*self.at, np.arange(self.size))] = self.scale
        return made


class Multiple:
    """exp(2 x / sqrt(2 N r)) times what it was: C is r x r, there are N noises."""

    def __init__(self, name: str, start: np.ndarray, noises: int):
        self.name, self.start, self.size = name, start.copy(), 1
        self.units = np.array([1 / np.sqrt(2 * noises * len(start))])
        self.logarithmic = np.ones(1, bool)
        self.now = self.start

    def matrix(self, x: np.ndarray) -> np.ndarray:
        self.now = self.start * np.exp(2 * self.units[0] * x[0])
        return self.now

    def slopes(self, gradient: np.ndarray) -> np.ndarray:
        return np.array([2 * self.units[0] * np.sum(gradient * self.now)])

    def tangent(self) -> np.ndarray:
        return 2 * self.units[0] * self.now[..., None]


class Deviation(Multiple):
    """exp(x / sqrt(2 N)) times what it was: a standard deviation, or what is in the place of one; or exp(unit x)"""

    def __init__(self, name: str, start: np.ndarray, noises: int, unit: float = 0.0):
        super().__init__(name, start, noises)
        self.units = np.array([unit / 2]) if unit else self.units / 2


class Cholesky:
    """The entries of a covariance that are not held: C = L L' + FLOOR diag(L L') is r x r, `held` a symmetric mask,
    there are N noises.

    A singular C: L has `rank` columns, and nothing is held.  L[i, i] is not 0 in those columns alone.  The rows that
    the others explain least come first, so that each C of this rank nearby has one L."""

    def __init__(self, name: str, start: np.ndarray, held: np.ndarray, noises: int, rank: Optional[int] = None):
        self.name, self.held, self.rank = name, held, len(start) if rank is None else rank
        self.start = start - np.diag(np.diag(start)) * FLOOR / (1 + FLOOR)  # L L'
        self.order = np.arange(len(start))
        if rank is None:
            self.root = _root(self.start)
        else:
            self.root, self.order = _pivoted(self.start, rank)
        columns, rows = np.nonzero(np.triu(~held[np.ix_(self.order, self.order)])[: self.rank])
        at = np.lexsort((columns, rows))
        rows, columns = self.order[rows[at]], self.order[columns[at]]
        self.cells = list(zip(rows.tolist(), columns.tolist()))
        self.size = len(self.cells)
        self.logarithmic = rows == columns
        deviation = np.sqrt(np.diag(start))
        self.units = np.where(self.logarithmic, 1 / np.sqrt(2 * noises), deviation[rows] / np.sqrt(noises))
        self.rows, self.noises = rows, noises
        self.at = rows, columns
        self.solved = [(i, j) for i in range(len(start)) for j in range(i + 1) if held[i, j]]
        self.L, self.dL = self.root, np.zeros((*start.shape, self.size))

    def matrix(self, x: np.ndarray) -> np.ndarray:
        """What is free is moved, what is held is solved for, row after row; with the derivatives."""
        self.L, self.dL = np.zeros_like(self.root), np.zeros_like(self.dL)
        move, root = self.units * x, self.root[self.at]
        self.L[self.at] = np.where(self.logarithmic, root * np.exp(np.where(self.logarithmic, move, 0.0)), root + move)
        self.dL[(*self.at, np.arange(self.size))] = self.units * np.where(self.logarithmic, self.L[self.at], 1.0)
        for i, j in self.solved:
            self._solve(i, j)
        made = self.L @ self.L.T
        np.fill_diagonal(made, (1 + FLOOR) * np.diag(made))
        return made

    def grown(self) -> np.ndarray:
        """The units of what is below the diagonal, with the deviations that the noises now have, in those it has."""
        deviation = np.sqrt(np.sum(self.L**2, axis=1) / self.noises)
        return np.where(self.logarithmic, 1.0, deviation[self.rows] / self.units)

    def rescale(self, ratio: np.ndarray) -> None:
        self.units = np.where(self.logarithmic, self.units, self.units * ratio)

    def _solve(self, i: int, j: int) -> None:
        L, dL = self.L, self.dL
        rest = self.start[i, j] - L[i, :j] @ L[j, :j]
        slope = -(L[i, :j] @ dL[j, :j] + L[j, :j] @ dL[i, :j])
        if i == j:
            if not rest > 0:
                raise Infeasible
            L[i, i] = np.sqrt(rest)
            dL[i, i] = slope / (2 * L[i, i])
        else:
            L[i, j] = rest / L[j, j]
            dL[i, j] = (slope - L[i, j] * dL[j, j]) / L[j, j]

    def slopes(self, gradient: np.ndarray) -> np.ndarray:
        weighed = gradient + gradient.T + 2 * FLOOR * np.diag(np.diag(gradient))
        return np.tensordot(weighed @ self.L, self.dL, 2)

    def tangent(self) -> np.ndarray:
        half = np.einsum("ijk,lj->ilk", self.dL, self.L)
        made = half + np.swapaxes(half, 0, 1)
        diagonal = np.arange(len(self.L))
        made[diagonal, diagonal] *= 1 + FLOOR
        return made

    def is_alone(self, k: int) -> bool:
        """Is coordinate k most of a variance, or only of what other noises do not explain?"""
        i, j = self.cells[k]
        return i == j and self.L[i, i] ** 2 >= 0.5 * float(np.sum(self.L[i] ** 2))


def _root(C: np.ndarray) -> np.ndarray:
    """L of L L' = C; of the nearest C that is definite, where it is not to rounding."""
    deviation = np.sqrt(np.diag(C))
    values, vectors = np.linalg.eigh(C / np.outer(deviation, deviation))
    if values[0] < FLOOR:
        C = (vectors * np.maximum(values, FLOOR)) @ vectors.T * np.outer(deviation, deviation)
    return np.linalg.cholesky(C)


def _pivoted(C: np.ndarray, rank: int) -> tuple[np.ndarray, np.ndarray]:
    """L with `rank` columns of which L L' is next to C, and the rows in the order in which they were taken: the one
    of which the largest share is left comes next."""
    left, L, order = C.copy(), np.zeros_like(C), list(range(len(C)))
    for at in range(rank):
        best = max(range(at, len(C)), key=lambda k: left[order[k], order[k]] / C[order[k], order[k]])
        order[at], order[best] = order[best], order[at]
        i, rest = order[at], order[at:]
        L[rest, i] = left[rest, i] / np.sqrt(left[i, i])
        left -= np.outer(L[:, i], L[:, i])
    return L, np.array(order)
