"""The ways to run a model on a chip: tried on records, priced, and one of them chosen."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, field
from typing import Callable, Iterable, Optional, Sequence

import numpy as np

from kalmanq.core import lib, names_of
from kalmanq.errors import KalmanqError, KalmanqWarning
from kalmanq.firmware.costs import Cost, is_offered
from kalmanq.firmware.ranges import Choice, widened
from kalmanq.firmware.reach import Reach, Record, draw, reach
from kalmanq.model import Gaps, Model
from kalmanq.run.filters import Filter
from kalmanq.run.parts import Parts, ways_of
from kalmanq.run.resolution import COARSE, coarse_of, said
from kalmanq.run.results import Run

ACCURATE, TOLERABLE = 1e-4, 1e-3  # of sigma: means farther from double's are warned of, are not recommended
SUMMED = 4  # an error of the mean is at most about so many roundings of a measurement
DRAWN, DRAWN_SEEDS = 4000, range(100, 103)  # rows and seeds of records beside those that are given
WORTH = 0.9  # fewer instructions than that share are worth more code
START_UP = 1024  # bytes of flash that a program has beside all this
WRONG = (lib.KQ_EVENT_SATURATED | lib.KQ_EVENT_OVERFLOW | lib.KQ_EVENT_PRECISION | lib.KQ_EVENT_LOW_NOISE
         | lib.KQ_EVENT_REDUNDANT | lib.KQ_EVENT_CONTRADICTION)
# kB of flash and RAM of a part as one would take it; --flash and --ram say otherwise
PARTS = {"m0": (32, 4), "m3": (128, 20), "m4f": (256, 64), "m7": (512, 128), "m33": (256, 64), "rv32": (128, 32),
         "avr": (32, 2)}


@dataclass(frozen=True)
class Part:
    core: str
    flash: int  # bytes
    ram: int

    def holds(self, cost: Cost) -> Optional[bool]:
        """None: not known"""
        if cost.flash is not None and cost.flash + START_UP > self.flash or (cost.ram or 0) + (cost.stack or 0) > self.ram:
            return False
        return None if None in (cost.flash, cost.ram, cost.stack) else True


@dataclass(frozen=True)
class Reading:
    """What kq_mean alone, without its low part, is off double's mean at most, in sigma, where states are within their
    ranges.

    low    what the low part has at most
    seen   the largest error of mean and low part over so many rows: of the records, and of others drawn from the model
    times  as far as the ranges are beyond the states there: an error is in proportion to the states, or less
    """

    low: float
    seen: float
    times: float
    rows: int

    @property
    def within(self) -> float:
        return self.low + self.times * self.seen


@dataclass
class Trial:
    """An arithmetic compared with double, over all records: of each state, in sigma, of the mean with its low part."""

    arithmetic: str  # or a way in it
    worst: np.ndarray
    rms: np.ndarray
    events: int = 0
    refused: str = ""
    cure: str = ""
    reading: Optional[Reading] = None  # where it is not refused
    cause: str = ""  # of its error, where measurements are coarse beside their noise
    start: float = 0.0  # how far first estimates are from those of an unknown start, where the ranges are the prior

    @property
    def wrong(self) -> int:
        """Events that are counted against it: where the ranges are the prior of a start that is told of, and measured, by itself"""
        return self.events & WRONG & ~(lib.KQ_EVENT_PRECISION if self.start > ACCURATE else 0)

    @property
    def is_good(self) -> bool:
        return not self.refused and not self.wrong and bool(self.worst.max(initial=0) <= TOLERABLE)

    @property
    def warnings(self) -> list[str]:
        cure = [f"{self.arithmetic} would do with {self.cure}"] if self.cure else []
        if self.refused:
            return [self.refused, *cure]
        made = cure + [f"{self.arithmetic}: {name}" for name in names_of(self.wrong)]
        if self.start > ACCURATE:
            made.append(f"{self.arithmetic}: the ranges are the prior of the diffuse start; it takes first estimates "
                        f"{self.start:.1g} sigma from double's")
        if self.worst.max(initial=0) > ACCURATE:
            cause = f": {self.cause}" if self.cause else ""
            made.append(f"{self.arithmetic}: a mean is {self.worst.max():.1g} sigma from double's{cause}")
        return made


@dataclass
class Way:
    """One way to run, with what it costs on the core; why_not: of that nothing, or not all, is known."""

    arithmetic: str
    way: str
    cost: Cost
    why_not: str
    fits: Optional[bool]
    trial: Trial

    @property
    def is_good(self) -> bool:
        return self.fits is not False and self.trial.is_good


@dataclass
class Designs:
    """model: with all ranges; notes: what was chosen for ranges."""

    model: Model
    part: Part
    reached: Reach
    trials: dict[str, Trial]
    ways: list[Way]
    notes: list[Choice] = field(default_factory=list)

    def chosen(self, arithmetic: Optional[str] = None, way: Optional[str] = None) -> Optional[Way]:
        """The one with fewest instructions that is good, unless a little more buys less code; where none are known, the first:
        f32 before q31, the library's least code before its other ways and these before compiled.  None: there is none."""
        asked = [one for one in self.ways
                 if arithmetic in (None, one.arithmetic) and way in (None, one.way)]
        good = [one for one in asked if one.is_good]
        if not good:
            return None
        known = [(one.cost.instructions, one.cost.flash or 0, one) for one in good if one.cost.instructions is not None]
        if not known:
            return good[0]
        fastest = min(instructions for instructions, _, _ in known)
        near = [(flash, one) for instructions, flash, one in known if WORTH * instructions <= fastest]
        return min(near, key=lambda pair: pair[0])[1]


Prices = Callable[[Sequence[tuple[str, str]]], Sequence[tuple[Cost, str]]]  # of arithmetics and ways; why a cost is not known


def unpriced(ways: Sequence[tuple[str, str]]) -> list[tuple[Cost, str]]:
    return [(Cost(), "")] * len(ways)


def offered(model: Model, core: str, arithmetic: Optional[str] = None, way: Optional[str] = None) -> list[tuple[str, str]]:
    """Arithmetics and ways, or those that are asked for"""
    return [(name, one) for name in ("f32", "q31") if arithmetic in (None, name) for one in ways_of(model)
            if way in (None, one) and is_offered(core, name, one)]


def design(model: Model, part: Part, records: Sequence[Record], notes: Sequence[Choice] = (), prices: Prices = unpriced,
           asked: Optional[Sequence[tuple[str, str]]] = None) -> Designs:
    """Tries every way to run a model that has all its ranges, or those that are asked for"""
    runs = [_run(model, "f64", record) for record in records]
    drawn = [one for one in draw(model.changed(gaps=Gaps()), DRAWN, DRAWN_SEEDS) if len(one.z)]
    exact, reached = [_run(model, "f64", one) for one in drawn], reach(model, records)
    states = np.fmax(reached.states, reach(model, drawn).states)

    def tried(name: str, way: str = "") -> Trial:
        trial = _try(model, name, records, runs, way)
        trial.cause = cause_of(model, name, records, trial)
        if not trial.refused:
            seen = np.fmax(trial.worst.max(), _try(model, name, drawn, exact, way).worst.max())
            trial.reading = _reading(model, name, float(seen), states, [*runs, *exact])
        return trial

    trials = {name: tried(name) for name in ("f32", "q31")}
    trials["q31"].cure = _cure(model, records, runs, trials["q31"])
    made = Designs(model, part, reached, trials, [], notes=list(notes))
    ways = [(name, way) for name, way in (offered(model, part.core) if asked is None else asked) if not trials[name].refused]
    for (name, way), (cost, why_not) in zip(ways, prices(ways)):
        trial = trials[name]
        own = tried(name, way) if way == "lean" else trial  # low-noise measurements are taken otherwise
        is_same = own.events == trial.events and np.array_equal(own.worst, trial.worst)
        made.ways.append(Way(name, way, cost, why_not, part.holds(cost), trial if is_same else own))
    return made


def _run(model: Model, arithmetic: str, record: Record, way: str = "") -> Run:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", KalmanqWarning)  # events are told of the trial
        return Filter(model, arithmetic, way=way).run(record.z, record.u)


def _bounded(model: Model) -> Model:
    """With the prior that q31 has of an unknown start: a third of the range"""
    known = np.outer(~model.unknown, ~model.unknown)
    thirds = np.where(model.unknown, [(one.range or 0.0) / 3 for one in model.states], 0.0)
    return model.changed(P0=np.where(known, model.P0, 0.0) + np.diag(thirds**2), unknown=[])


def _try(model: Model, arithmetic: str, records: Sequence[Record], exact: Sequence[Run], way: str = "") -> Trial:
    """Compared with double; an unknown start in q31 also with double that has the ranges as its prior"""
    bounded = _bounded(model) if arithmetic == "q31" and np.any(model.unknown) else None
    runs = ((_run(model, arithmetic, record, way), double, _run(bounded, "f64", record) if bounded else None)
            for record, double in zip(records, exact))
    return trial_of(f"{way} in {arithmetic}" if way else arithmetic, model.n, runs)


def trial_of(name: str, n: int, runs: Iterable[tuple[Run, Run, Optional[Run]]]) -> Trial:
    """Of runs, each beside one in double and, where the start is unknown, beside another one in double that has the prior
    of the run; the nearer of both counts."""
    worst, squares, count, events, start = np.zeros(n), np.zeros(n), np.zeros(n), 0, 0.0
    try:
        for run, double, bounded in runs:
            error = errors_of(run, double)
            if bounded is not None:
                start = max(start, float(np.nanmax(np.abs(error), initial=0)))
                other = errors_of(run, bounded)
                error = np.where(np.abs(other) < np.abs(error), other, error)  # NaN: not known yet, and does not count
            worst = np.fmax(worst, np.nanmax(np.abs(error), axis=0, initial=0))
            squares += np.nansum(error**2, axis=0)
            count += np.sum(np.isfinite(error), axis=0)
            events |= run.events
    except KalmanqError as problem:
        return Trial(name, worst, worst, refused=f"{name}: {problem}")
    return Trial(name, worst, np.sqrt(squares / np.maximum(count, 1)), events, start=start)


def cause_of(model: Model, arithmetic: str, records: Sequence[Record], trial: Trial) -> str:
    """Of an error: steps of the measurements that are about as large, if there are any"""
    worst, z = trial.worst.max(initial=0), np.concatenate([one.z for one in records])
    return said(coarse_of(model, arithmetic, z, min(COARSE, worst / SUMMED)), arithmetic, model, z) if worst > ACCURATE else ""


def _cure(model: Model, records: Sequence[Record], exact: Sequence[Run], trial: Trial) -> str:
    """Wider ranges, where the records go beyond those that are declared and fixed point is good with them"""
    if trial.is_good:
        return ""
    wider, said = widened(model, records)
    return ", ".join(said) if said and _try(wider, "q31", records, exact).is_good else ""


def _reading(model: Model, name: str, seen: float, states: np.ndarray, exact: Sequence[Run]) -> Reading:
    ranges = np.array([one.range for one in model.states])
    half = 2.0 ** (-1.0 - np.array(Parts(model, name).fractions("states"))) if name == "q31" else ranges * 2.0**-24
    sigmas = np.concatenate([np.asarray(run.sigma) for run in exact])
    with np.errstate(divide="ignore", invalid="ignore"):
        low = np.nanmax(np.where(sigmas > 0, half / sigmas, 0), initial=0)
        times = np.max(np.where(states > 0, ranges / states, 1), initial=1)
    return Reading(float(low), seen, float(times), len(sigmas))


def errors_of(run: Run, exact: Run) -> np.ndarray:
    """T x n, of means in sigma; NaN where nothing is known, or all."""
    sigma = np.where(exact.sigma > 0, exact.sigma, np.nan)
    return (run.mean - exact.mean) / sigma
