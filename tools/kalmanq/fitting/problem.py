"""What is to be estimated: the log-likelihood as a function of a vector, with its gradient."""

from __future__ import annotations

from typing import Any, Callable, Mapping, Optional

import numpy as np

from kalmanq.core import lib
from kalmanq.errors import KalmanqError
from kalmanq.fitting.choice import Choice
from kalmanq.fitting.coordinates import FARTHEST, Cholesky, Deviation, Entries, Infeasible, Multiple
from kalmanq.fitting.equations import EquationExpectation
from kalmanq.fitting.expectation import Expectation, Records
from kalmanq.fitting.flow import STENCIL, FlowExpectation
from kalmanq.fitting.likelihood import likelihood
from kalmanq.fitting.noise import is_definite
from kalmanq.fitting.of_columns import ColumnExpectation
from kalmanq.model import ColumnModel, Model
from kalmanq.run.filters import Smoother

STEP = 1e-4  # of a constant, between two slopes
WIDE = 0.5  # of the logarithm of a builder's parameter: its unit at most
SHARE = 1e-2  # of a constant: its unit where the likelihood is not curved downwards


class Singular(KalmanqError):
    """A covariance from which there is no beginning."""


class Problem:
    """The likelihood of the records in coordinates around the present estimate: `evaluate(x)`, 0 is here.

    evaluations   E-steps so far; course: the log-likelihood that each of the search found
    """

    def __init__(self, model: Model, records: Records, choice: Choice, arithmetic: str = "f64"):
        self.model, self.records, self.choice = model, records, choice
        self.noise = choice.noise(model)
        if "Q" in choice.free and not np.any(self.noise.inner):
            raise KalmanqError(f"{'Qc' if choice.flow else 'Q'} is 0, and stays 0: begin with some noise")
        if "R" in choice.free and isinstance(model, Model) and not np.any(model.R):
            raise KalmanqError("R is 0, and stays 0: begin with some noise")
        if "Q" in choice.held and self.noise.axes is None:
            raise KalmanqError("held: Q = G Q' G' is of lower rank: its entries cannot be held: leave --hold out, or give Q in the place of G")
        self.course: list[float] = []
        self.allowed = 0  # evaluations
        self.best = -np.inf
        self.arithmetic = arithmetic
        self.report: Optional[Callable[[int, float], None]] = None
        self.status = lib.KQ_OK  # of the last E-step
        self._expect()
        self.begun = {name: array.copy() for name, array in self.arrays.items()}
        self.offset = self._offset()

    def _expect(self) -> None:
        choice, forms = self.choice, self.choice.forms
        if choice.equations:
            self.expectation: Any = EquationExpectation(choice.equations, self.model, self.records, self.noise, forms)
            return
        if isinstance(self.model, ColumnModel):
            self.expectation = ColumnExpectation(self.model, self.records, self.noise, choice.free, choice.flow)
            return
        if choice.flow:
            self.expectation = FlowExpectation(choice.flow, self.model, self.records, self.noise, forms)
            return
        held = {name: choice.held[name] for name in ("A", "H") if name in choice.held}
        self.expectation = Expectation(self.model, self.records, free=choice.free,
                                       noise=(self.noise.F, self.noise.inner), held=held,
                                       forms=(forms["Q"], forms["R"]), arithmetic=self.arithmetic)

    def _offset(self) -> float:
        """Of the exact log-likelihood, where the start is unknown, from that of the start which stands for it."""
        if self.choice.equations or self.choice.flow or isinstance(self.model, ColumnModel) or not np.any(self.model.unknown) or self.expectation.status < lib.KQ_OK or \
                self.expectation.run() != lib.KQ_OK:
            return 0.0
        return likelihood(self.model, self.records.z, self.records.u) - self.expectation.log_likelihood

    @property
    def arrays(self) -> dict[str, np.ndarray]:
        return self.expectation.arrays

    @property
    def evaluations(self) -> int:
        return self.expectation.evaluations

    def anchor(self, ranks: Optional[Mapping[str, int]] = None) -> None:
        """Coordinates of what the arrays now are; of singular covariances by their ranks."""
        e = self.expectation
        e.begin()
        self._ranks = ranks or {}
        self.measured = np.flatnonzero(np.diag(self.arrays["R"]) > 0)
        self.blocks = [self._block(name) for name in self.choice.free]
        ends = np.cumsum([0] + [block.size for block in self.blocks]).tolist()
        self.slices = [slice(a, b) for a, b in zip(ends, ends[1:])]
        self.size = ends[-1]
        self.logarithmic = np.concatenate([block.logarithmic for block in self.blocks])
        self.units = np.concatenate([block.units for block in self.blocks])

    def _block(self, name: str) -> Any:
        rows, steps = len(self.records), self.records.steps
        if self._is_constant(name):
            return self._block_of_constant(name)
        if name in ("A", "H", "x0", "F"):
            free = ~self.choice.held.get(name, np.zeros(self.arrays[name].shape, bool))
            return Entries(name, self.arrays[name], free, self._scale_of_flow(free) if name == "F" else self._scale(name))
        noises = {"Q": max(steps - rows, 1), "R": steps, "P0": rows}[name]
        start = self.inside(name, self.arrays[name])
        if name not in ("Q", *self._ranks) and not (start.size and is_definite(start)):
            raise Singular(f"{name} is singular: what has no noise cannot be estimated from there: begin with some noise")
        if self.choice.forms[name] == "multiple":
            return Multiple(name, start, noises)
        held = self.inside(name, self.choice.held.get(name, np.zeros(self.model.R.shape if name == "R" else
                                                                        (self.model.n, self.model.n), bool)), True)
        if self.choice.forms[name] == "diagonal":
            if np.any(start - np.diag(np.diag(start))):
                raise KalmanqError(f"{name} is not diagonal, and is to be: begin from a diagonal one")
            held = held | ~np.eye(len(start), dtype=bool)
        return Cholesky(name, start, held, noises, self._ranks.get(name))

    def _is_constant(self, name: str) -> bool:
        """Of a nonlinear model's file, or of a builder?"""
        return name in self.choice.constants

    def _block_of_constant(self, name: str) -> Any:
        """What is of the noise alone is a deviation.  The unit of others is what they are known to, as the likelihood is curved here."""
        start = self.arrays[name].copy()
        if name in (self.choice.equations or self.choice.flow).noises:
            return Deviation(name, start, self.records.steps)
        if self.choice.flow:
            curvature = self._curvature(name, (0,), STEP * start[0]) * start[0] ** 2
            return Deviation(name, start, self.records.steps, float(np.clip(curvature, WIDE**-2, self.records.steps)) ** -0.5)
        curvature = self._curvature(name, (0,), STEP * max(abs(float(start[0])), STEP))
        return Entries(name, start, np.ones(1, bool), np.array([curvature**-0.5 if curvature > 0 else SHARE * abs(start[0]) or SHARE]))

    def _curvature(self, name: str, at: tuple[int, ...], step: float) -> float:
        """Of the log-likelihood downwards, to an entry; 0 where it is not known"""
        array, slopes = self.arrays[name], []
        start = array[at]
        if isinstance(self.model, ColumnModel):  # its slopes are differences
            values = []
            for move in (step, 0.0, -step):
                array[at] = start + move
                values.append(self.value_here())
            array[at] = start
            made = (2 * values[1] - values[0] - values[2]) / step**2
            return made if np.isfinite(made) else 0.0
        for move in (step, -step):
            array[at] = start + move
            slopes.append(float(self.expectation.gradient_of(name)[at]))
        array[at] = start
        made = (slopes[1] - slopes[0]) / (2 * step)
        return made if np.isfinite(made) else 0.0

    def _scale_of_flow(self, free: np.ndarray) -> np.ndarray:
        """Of entries of F, as the likelihood is curved"""
        F = self.arrays["F"]
        rate, made = float(np.max(np.abs(F))) or 1 / self.model.continuous.dt / self.records.steps, np.ones(F.shape)
        for at in zip(*np.nonzero(free)):
            curvature = self._curvature("F", at, STEP * rate)
            made[at] = curvature**-0.5 if curvature > 0 else SHARE * rate
        return made

    @property
    def coordinates(self) -> tuple[Any, ...]:
        """Of `anchor`: kept, and put back, where another place was tried in vain."""
        return self.blocks, self.slices, self.size, self.logarithmic, self.units

    @coordinates.setter
    def coordinates(self, kept: tuple[Any, ...]) -> None:
        self.blocks, self.slices, self.size, self.logarithmic, self.units = kept

    def inside(self, name: str, whole: np.ndarray, is_mask: bool = False) -> np.ndarray:
        """The part of a covariance, or of a mask of its entries, that has noise."""
        if name == "R":
            return whole[np.ix_(self.measured, self.measured)]
        if name == "Q" and is_mask:
            return np.zeros_like(self.arrays["Q"], bool) if self.noise.axes is None else \
                whole[np.ix_(self.noise.axes, self.noise.axes)]
        return whole

    def _scale(self, name: str) -> np.ndarray:
        """Of an entry: what it moves is as large as the noise, over the root of the number of noises."""
        arrays, model = self.arrays, self.model
        if name == "x0":
            return np.sqrt(np.maximum(np.diag(arrays["P0"]), 1e-300) / len(self.records))
        size = self._sizes()
        noise = np.sqrt(np.diag(self.noise.whole(arrays["Q"]) if name == "A" else arrays["R"]))
        moved = size if name == "A" else np.maximum(np.abs(np.nan_to_num(model.H)) @ size, 1e-300)
        noise = np.where(noise > 0, noise, 1e-2 * moved)
        return np.outer(noise, 1 / size) / np.sqrt(self.records.steps)

    def _sizes(self) -> np.ndarray:
        """Root mean square of each state, smoothed."""
        if not hasattr(self, "_size"):
            squares = [np.nanmean(Smoother(self.model).run(z, u, times=times).smoothed ** 2, axis=0) for z, u, times in self.records.each()]
            size = np.sqrt(np.nanmean(squares, axis=0))
            self._size = np.where(size > 0, size, 1.0)
        return self._size

    # ------------------------------------------------------------------ the function

    def put(self, x: np.ndarray) -> None:
        """Writes the parameters at x to the arrays that C reads."""
        for block, part in zip(self.blocks, self.slices):
            self.put_inside(block.name, block.matrix(x[part]))

    def evaluate(self, x: np.ndarray) -> tuple[float, np.ndarray]:
        """Log-likelihood and gradient; -inf and zeros where there is none."""
        before = self.evaluations
        value = self.value(x)
        if self.evaluations > before:
            self.course.append(value)
        if self.report:
            self.report(self.evaluations, value)
        if not np.isfinite(value):
            return value, np.zeros(self.size)
        return value, self._slopes(x)

    def slopes_at(self, x: np.ndarray) -> np.ndarray:
        """The gradient alone; NaN where there is none."""
        return self._slopes(x) if np.isfinite(self.value(x)) else np.full(self.size, np.nan)

    def _slopes(self, x: np.ndarray) -> np.ndarray:
        found = self.expectation.gradient()
        slopes = np.concatenate([block.slopes(self.inside(block.name, found[block.name])) for block in self.blocks])
        for k in np.flatnonzero(~np.isfinite(slopes)):
            slopes[k] = self._difference(x, int(k))
        return slopes

    def ranks(self, least: float) -> dict[str, int]:
        """Of the full covariances that are as good as singular: eigenvalues of their correlations from `least`."""
        made = {}
        for block in self.blocks:
            if self.may_be_singular(block):
                C = self.inside(block.name, self.arrays[block.name])
                deviation = np.sqrt(np.diag(C))
                rank = int(np.sum(np.linalg.eigvalsh(C / np.outer(deviation, deviation)) >= least))
                if min(rank, block.rank) < len(C):
                    made[block.name] = min(rank, block.rank)
        return made

    def is_narrower(self, least: float) -> bool:
        """Is any of them of a lower rank than its coordinates have?"""
        now = self.now_ranks
        return any(rank < now.get(name, np.inf) for name, rank in self.ranks(least).items())

    @staticmethod
    def may_be_singular(block: Any) -> bool:
        """Is it of a full covariance?"""
        return isinstance(block, Cholesky) and not np.any(block.held)

    @property
    def narrow_blocks(self) -> list[Cholesky]:
        return [block for block in self.blocks if isinstance(block, Cholesky) and block.rank < len(block.L)]

    @property
    def now_ranks(self) -> dict[str, int]:
        return {block.name: block.rank for block in self.narrow_blocks}

    def by_block(self, mask: np.ndarray, ranks: Mapping[str, int]) -> dict[str, np.ndarray]:
        """A mask of coordinates, of those blocks that stay as they are with covariances of these ranks."""
        return {block.name: mask[part] for block, part in zip(self.blocks, self.slices)
                if not isinstance(block, Cholesky) or ranks.get(block.name, block.rank) == block.rank}

    def put_inside(self, name: str, C: np.ndarray) -> None:
        if name == "R":
            self.arrays["R"][np.ix_(self.measured, self.measured)] = C
        else:
            self.arrays[name][...] = C

    def grown(self, x: np.ndarray) -> np.ndarray:
        """The units that linear coordinates would have if they were made at x, in those that they have."""
        self.put(x)
        made = np.ones(self.size)
        for block, part in zip(self.blocks, self.slices):
            if isinstance(block, Entries) and block.name in ("A", "H", "x0"):
                made[part] = block.grown(self._scale(block.name))
            elif isinstance(block, Cholesky):
                made[part] = block.grown()
        return made

    def rescale(self, ratio: np.ndarray) -> None:
        """Other units: what was x is x / ratio, of a logarithm x; a slope is ratio times what it was."""
        for block, part in zip(self.blocks, self.slices):
            if not isinstance(block, Multiple):
                block.rescale(ratio[part])

    def value(self, x: np.ndarray) -> float:
        if not self.is_within(x):
            return -np.inf
        try:
            self.put(x)
        except Infeasible:
            return -np.inf
        return self.value_here()

    def is_within(self, x: np.ndarray) -> bool:
        """Is no variance farther from where it began than it may be?"""
        return not np.any(np.abs(x * self.units)[self.logarithmic] > FARTHEST)

    def value_here(self) -> float:
        """The log-likelihood of what is in the arrays."""
        self.status = self.expectation.run()
        if self.status != lib.KQ_OK:
            return -np.inf
        value = self.expectation.log_likelihood + self.offset
        return value if np.isfinite(value) else -np.inf

    def _difference(self, x: np.ndarray, k: int, step: float = 0.02) -> float:
        """Where there is no noise, Fisher's identity says nothing: of the likelihood itself."""
        return sum(weight * self.value(x + steps * step * np.eye(self.size)[k]) for steps, weight in STENCIL) / step

    def scatter(self, random: np.random.Generator, spread: float) -> None:
        """Moves the arrays to somewhere else: logarithms of standard deviations, and entries, by so much of what
        they are known to."""
        self.anchor()
        for _ in range(100):
            x = random.normal(size=self.size) * np.where(self.logarithmic, spread / self.units, 2 * spread)
            if np.isfinite(self.value(x)):
                return
        self.put(np.zeros(self.size))

    # ------------------------------------------------------------------ what it is of

    def estimated(self) -> Any:
        """The model with what is in the arrays."""
        if self.choice.flow:
            return self.choice.flow.model_at(self.arrays, self.noise)
        made: dict[str, Any] = {name: np.array(self.arrays[name], np.float64) for name in self.choice.free}
        for name in ("Q", "R", "P0"):
            if name in made:
                made[name] = (made[name] + made[name].T) / 2
        if "Q" in made:
            made.update(self.noise.of_model(made.pop("Q")))
        if self.choice.equations:
            return self.choice.equations.estimated(self.model, made)
        return self.model.changed(**made)

    def whole(self, name: str) -> np.ndarray:
        """A parameter as the model has it."""
        return self.noise.whole(self.arrays["Q"]) if name == "Q" else self.arrays[name]

    def place(self, name: str, i: int) -> Optional[int]:
        """The row of a covariance that row i of what is estimated of it is; None: it is no row."""
        if name == "Q":
            return None if self.noise.axes is None else int(self.noise.axes[i])
        return int(self.measured[i]) if name == "R" else i

    def tangents(self) -> dict[str, np.ndarray]:
        """The derivative of each free parameter, whole, to all coordinates: its shape x size."""
        made = {}
        for block, part in zip(self.blocks, self.slices):
            inside = block.tangent()
            if block.name == "Q" and self.noise.F is not None:
                inside = np.einsum("ia,abk,jb->ijk", self.noise.F, inside, self.noise.F)
            shape = self.whole(block.name).shape
            made[block.name] = np.zeros((*shape, self.size))
            if block.name == "R":
                made["R"][np.ix_(self.measured, self.measured, range(part.start, part.stop))] = inside
            else:
                made[block.name][..., part] = inside
        return made
