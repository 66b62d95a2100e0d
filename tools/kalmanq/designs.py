"""The ways to run a model on a chip: tried on records, priced, and one of them chosen."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, field
from typing import Optional, Sequence

import numpy as np

from kalmanq import costs
from kalmanq.c_source import ways_of
from kalmanq.core import lib, names_of
from kalmanq.costs import Cost
from kalmanq.errors import KalmanqError, KalmanqWarning
from kalmanq.filters import Filter
from kalmanq.model import Model
from kalmanq.parts import Parts
from kalmanq.reach import Reach, Record, reach
from kalmanq.results import Run

ACCURATE, TOLERABLE = 1e-4, 1e-3  # of sigma: means farther from double's are warned of, are not recommended
BLUNT = 2.0**-14  # R / S from which on a lean sensor is safe: it refuses less than 2^-16
WORTH = 0.9  # fewer instructions than that share are worth more code
START_UP = 1024  # bytes of flash that a program has beside all this
WRONG = (lib.KQ_EVENT_SATURATED | lib.KQ_EVENT_OVERFLOW | lib.KQ_EVENT_PRECISION | lib.KQ_EVENT_SHARP
         | lib.KQ_EVENT_FLOOR | lib.KQ_EVENT_CONTRADICTION)
# kB of flash and RAM of a part as one would take it; --flash and --ram say otherwise
PARTS = {"m0": (32, 4), "m3": (128, 20), "m4f": (256, 64), "m7": (512, 128), "m33": (256, 64), "rv32": (128, 32),
         "avr": (32, 2)}


@dataclass(frozen=True)
class Part:
    core: str
    flash: int  # bytes
    ram: int

    def holds(self, cost: Cost) -> bool:
        return cost.flash + START_UP <= self.flash and cost.ram + cost.stack <= self.ram


@dataclass
class Trial:
    """An arithmetic beside double, over all rows of the records: of each state, in sigma, of the mean with its low part.

    reading    what kq_mean without that part loses at most, where states are within their ranges
    """

    arithmetic: str
    worst: np.ndarray
    rms: np.ndarray
    events: int = 0
    refused: str = ""
    rows: int = 0
    reading: float = 0.0

    @property
    def is_good(self) -> bool:
        return not self.refused and not self.events & WRONG and bool(self.worst.max(initial=0) <= TOLERABLE)

    @property
    def warnings(self) -> list[str]:
        if self.refused:
            return [self.refused]
        made = [f"{self.arithmetic}: {name}" for name in names_of(self.events & WRONG)]
        if self.worst.max(initial=0) > ACCURATE:
            made.append(f"{self.arithmetic}: a mean is {self.worst.max():.1g} sigma from double's")
        if self.reading > TOLERABLE:
            made.append(f"{self.arithmetic}: kq_mean alone loses up to {self.reading:.1g} sigma: add kq_mean_low to it")
        return made


@dataclass
class Way:
    """One way to run, with what it costs on the core and why it may not do."""

    arithmetic: str
    way: str
    cost: Cost
    fits: bool
    trial: Trial

    @property
    def is_good(self) -> bool:
        return self.fits and self.trial.is_good


@dataclass
class Designs:
    """model: with all ranges; notes: what was chosen for them."""

    model: Model
    part: Part
    reached: Reach
    trials: dict[str, Trial]
    ways: list[Way]
    notes: list[str] = field(default_factory=list)

    def chosen(self, arithmetic: Optional[str] = None, way: Optional[str] = None) -> Optional[Way]:
        """The one with fewest instructions that is good, unless a little more buys less code; None: there is none."""
        asked = [one for one in self.ways
                 if arithmetic in (None, one.arithmetic) and way in (None, one.way)]
        good = [one for one in asked if one.is_good]
        if not good:
            return None
        fastest = min(one.cost.instructions for one in good)
        near = [one for one in good if WORTH * one.cost.instructions <= fastest]
        return min(near, key=lambda one: one.cost.flash)


def design(model: Model, part: Part, records: Sequence[Record], notes: Sequence[str] = ()) -> Designs:
    """Tries every way to run a model that has all its ranges."""
    runs = [_run(model, "f64", record) for record in records]
    trials = {name: _try(model, name, records, runs) for name in ("f32", "q31")}
    made = Designs(model, part, reach(model, records), trials, [], list(notes))
    for name, trial in trials.items():
        if trial.refused:
            continue
        for way in ways_of(Parts(model, name)):
            if costs.is_measured(part.core, name, way) and (way != "lean" or _is_blunt(model, runs)):
                cost = costs.estimate(model, part.core, name, way)
                made.ways.append(Way(name, way, cost, part.holds(cost), trial))
    return made


def _run(model: Model, arithmetic: str, record: Record) -> Run:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", KalmanqWarning)  # events are told of the trial
        return Filter(model, arithmetic).run(record.z, record.u)


def _try(model: Model, arithmetic: str, records: Sequence[Record], exact: Sequence[Run]) -> Trial:
    worst, squares, count, events = np.zeros(model.n), np.zeros(model.n), np.zeros(model.n), 0
    try:
        for record, double in zip(records, exact):
            run = _run(model, arithmetic, record)
            error = errors_of(run, double)
            worst = np.fmax(worst, np.nanmax(np.abs(error), axis=0, initial=0))
            squares += np.nansum(error**2, axis=0)
            count += np.sum(np.isfinite(error), axis=0)
            events |= run.events
    except KalmanqError as problem:
        return Trial(arithmetic, worst, worst, refused=f"{arithmetic}: {problem}")
    return Trial(arithmetic, worst, np.sqrt(squares / np.maximum(count, 1)), events, "",
                 sum(len(record.z) for record in records), _reading(model, arithmetic, exact))


def _reading(model: Model, arithmetic: str, exact: Sequence[Run]) -> float:
    """Half a last bit at the range, in the least sigma of each state"""
    spans = np.array([one.range or 0.0 for one in model.states])
    half = 2.0 ** (-1.0 - np.array(Parts(model, "q31").fractions("states"))) if arithmetic == "q31" else spans * 2.0**-24
    sigmas = np.concatenate([run.sigma for run in exact if run.sigma is not None])
    with np.errstate(divide="ignore", invalid="ignore"):
        return float(np.nanmax(np.where(sigmas > 0, half / sigmas, 0), initial=0))


def errors_of(run: Run, exact: Run) -> np.ndarray:
    """T x n, of means in sigma; NaN where nothing is known, or all."""
    assert exact.sigma is not None
    sigma = np.where(exact.sigma > 0, exact.sigma, np.nan)
    return (run.mean - exact.mean) / sigma


def _is_blunt(model: Model, runs: Sequence[Run]) -> bool:
    """Is no measurement so sharp that a lean sensor might refuse it?"""
    for run in runs:
        assert run.innovation_sigma is not None
        with np.errstate(invalid="ignore", divide="ignore"):
            share = np.diag(model.R) / run.innovation_sigma**2
        if np.nanmin(share, initial=np.inf) < BLUNT:
            return False
    return True
