"""The yardstick: the exact posterior mean of a random walk with alpha-stable steps, on a grid.

Forward and backward recursions over the density of the state, with the true density of the steps.  A measurement
has Gaussian noise, so that all of a posterior that is not below exp(-width^2 / 2) lies around it: the grid of each row
is centred there, on one lattice, and the move from row to row is a convolution.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Iterator

import numpy as np
from scipy import fft

from kalmanq_studies.heavy_tails import stable

TABLE = 2048  # offsets whose density is tabulated
FINER = {"step": 0.25, "width": 11.0}  # shows the error of a Grid


@dataclass(frozen=True)
class Grid:
    """alpha, sigma  of the steps and of the first state, S(alpha, 0, sigma); measurements have variance 1
    step          of the lattice, in sigma: the density's transform is exp(-(2 pi / step)^alpha) where it is cut off
    width         of a row's grid on each side of the measurement
    """

    alpha: float
    sigma: float
    step: float = 0.5
    width: float = 8.0

    @property
    def spacing(self) -> float:
        return self.step * self.sigma

    @property
    def half(self) -> int:
        return int(np.ceil(self.width / self.spacing))


def posterior_means(grid: Grid, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of the state at each row of runs x T measurements, given all rows so far, and given all rows."""
    lattice = np.rint(z / grid.spacing)
    offsets = np.arange(-grid.half, grid.half + 1)
    likelihood = np.exp(-0.5 * ((z - lattice * grid.spacing)[..., None] - offsets * grid.spacing) ** 2)
    moves = _Moves(grid, np.diff(lattice, axis=1))
    first = moves.densities(lattice[:, :1] + offsets)
    filtered = np.stack(list(_forward(first, likelihood, moves)), axis=1)
    smoothed = np.stack(list(_backward(filtered, likelihood, moves))[::-1], axis=1)
    centre, around = lattice * grid.spacing, offsets * grid.spacing
    return centre + filtered @ around, centre + smoothed @ around


def _forward(first: np.ndarray, likelihood: np.ndarray, moves: _Moves) -> Iterator[np.ndarray]:
    density = _normal(first * likelihood[:, 0])
    yield density
    for t in range(1, likelihood.shape[1]):
        density = _normal(moves.apply(density, t - 1, 1) * likelihood[:, t])
        yield density


def _backward(filtered: np.ndarray, likelihood: np.ndarray, moves: _Moves) -> Iterator[np.ndarray]:
    later = np.ones_like(filtered[:, 0])
    yield filtered[:, -1]
    for t in range(filtered.shape[1] - 2, -1, -1):
        later = _normal(moves.apply(later * likelihood[:, t + 1], t, -1))
        yield _normal(filtered[:, t] * later)


def _normal(density: np.ndarray) -> np.ndarray:
    return density / density.sum(axis=-1, keepdims=True)


class _Moves:
    """Convolutions with the density of a step, from the grid of one row to that of the next, or back."""

    def __init__(self, grid: Grid, lattice: np.ndarray):
        self.grid, self.lattice = grid, lattice
        self.table = stable.density(np.arange(TABLE) * grid.spacing, grid.alpha, grid.sigma)
        self.reach = np.arange(-2 * grid.half, 2 * grid.half + 1)
        self.length = fft.next_fast_len(len(self.reach), real=True)

    def densities(self, points: np.ndarray) -> np.ndarray:
        size = np.abs(points)
        made = self.table[np.minimum(size, TABLE - 1).astype(int)]
        far = size >= TABLE
        made[far] = stable.density(size[far] * self.grid.spacing, self.grid.alpha, self.grid.sigma)
        return made

    def apply(self, density: np.ndarray, t: int, way: int) -> np.ndarray:
        """From row t to row t + 1 (way 1), or back (-1): the density of a step is symmetric."""
        kernel = self.densities(way * self.lattice[:, t, None] + self.reach)
        transforms = fft.rfft(kernel, self.length) * fft.rfft(density, self.length)
        moved = fft.irfft(transforms, self.length)[:, 2 * self.grid.half : 4 * self.grid.half + 1]
        return np.maximum(moved, 0)  # rounding of what is nothing
