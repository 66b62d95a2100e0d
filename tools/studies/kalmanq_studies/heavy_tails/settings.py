"""What is drawn, how often, and the tasks that this is cut into."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, Iterator, Sequence

import numpy as np

from kalmanq.model import Model
from kalmanq_studies.heavy_tails import stable

PARTS = ("known", "skewed", "fitted", "robust")


@dataclass(frozen=True)
class Setting:
    """a = c = R = 1; the noise's scale, and rows of a run"""

    sigma: float
    rows: int

    @property
    def ratio(self) -> float:
        """Q / R of the filter"""
        return round(2 * self.sigma**2, 12)

    def model(self) -> Model:
        """The Gaussian of the same sigma; x[0] is as wide as a step."""
        return Model(A=1.0, H=1.0, Q=self.ratio, R=1.0, x0=0.0, P0=self.ratio, name="walk")

    def draw(self, random: np.random.Generator, runs: int, alpha: float, beta: float) -> tuple[np.ndarray, np.ndarray]:
        """States and measurements, runs x rows.  The same `random` draws runs that differ in alpha and beta alone."""
        x = np.cumsum(stable.draw(random, (runs, self.rows), alpha, beta, self.sigma), axis=1)
        return x, x + random.standard_normal(x.shape)


SETTINGS = (Setting(1.0, 100), Setting(0.1, 200))


@dataclass(frozen=True)
class Part:
    """So many blocks of so many runs for each alpha and beta"""

    blocks: int
    runs: int
    alphas: tuple[float, ...]
    betas: tuple[float, ...] = (0.0,)


@dataclass(frozen=True)
class Plan:
    known: Part
    skewed: Part
    fitted: Part
    robust: Part

    def parts(self) -> Iterator[tuple[str, Part]]:
        for name in PARTS:
            yield name, getattr(self, name)

    def fingerprint(self) -> dict[str, Any]:
        return asdict(self)


def _range(first: float, last: float, step: float) -> tuple[float, ...]:
    return tuple(round(first + k * step, 6) for k in range(int(round((last - first) / step)) + 1))


FULL = Plan(
    known=Part(10, 1000, _range(1.0, 1.4, 0.1) + _range(1.45, 2.0, 0.05)),
    skewed=Part(4, 500, (1.3, 1.5, 1.7), _range(-1, 1, 0.25)),
    fitted=Part(8, 25, _range(1.0, 2.0, 0.1)),
    robust=Part(10, 100, _range(1.1, 2.0, 0.1)))
QUICK = Plan(
    known=Part(2, 400, (1.1, 1.3, 1.4, 1.5, 1.6, 1.7, 1.8, 1.9, 2.0)),
    skewed=Part(1, 400, (1.5,), (-1.0, -0.5, 0.0, 0.5, 1.0)),
    fitted=Part(1, 12, (1.3, 1.6, 2.0)),
    robust=Part(1, 60, (1.3, 1.5, 1.7, 2.0)))


@dataclass(frozen=True)
class Task:
    """A block of runs, all with the same noise"""

    part: str
    setting: Setting
    alpha: float
    beta: float
    block: int
    runs: int
    seed: int

    def draw(self) -> tuple[np.ndarray, np.ndarray]:
        key = (PARTS.index(self.part), SETTINGS.index(self.setting), self.block)
        random = np.random.default_rng(np.random.SeedSequence(self.seed, spawn_key=key))
        return self.setting.draw(random, self.runs, self.alpha, self.beta)


def tasks_of(plan: Plan, seed: int) -> Sequence[Task]:
    return [Task(name, setting, alpha, beta, block, part.runs, seed)
            for name, part in plan.parts() for setting in SETTINGS for alpha in part.alphas for beta in part.betas
            for block in range(part.blocks)]
