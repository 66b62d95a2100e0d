"""A compiled filter: the form that its proof allows, and its files."""

from __future__ import annotations

import decimal
from dataclasses import dataclass, field, replace
from decimal import Decimal
from typing import Any, Optional, Sequence

import numpy as np

from kalmanq.compiler import exact
from kalmanq.compiler.proven import classes, fixed, floats, formats, forms, rounding
from kalmanq.compiler.names import named
from kalmanq.compiler.proven.plan import LARGEST, Plan, bookkeeping
from kalmanq.compiler.proven.refusals import refuse
from kalmanq.compiler.proven.roots import Root
from kalmanq.compiler.proven.search import Found, Overflow, Runner, Track
from kalmanq.compiler.proven.structure import Structure, structure
from kalmanq.compiler.proven.text import probes_of
from kalmanq.errors import KalmanqError
from kalmanq.firmware.designs import TOLERABLE
from kalmanq.model import Model

SNAP = Decimal("1e-6")  # of P, where the covariance counts as settled
MOST_ROWS = {"f32": 2000, "q31": 200}  # to settle; q31's ranges are sums over all ways there
MOST_GAP = 250
MOST_TO_FORGET = 60_000  # rows, which a lag counts in 16 bits
MOST_MEMORY = 500_000_000  # bytes of the search
MARGIN = {"f32": 4, "q31": 1}  # a compiler contracts products as it likes
RECORD = 2000  # rows that are tried
RECORDS = 10  # of so many rows in all, at the ends of ranges
START = "what is better known at first (P0)"  # a cure
KINDS = ("covariance", "gain")  # what is asked for: the first form of these whose proof holds, or a constant gain
FORMS = {"f32": (forms.Covariance, forms.PlainCovariance, Root), "q31": (forms.Covariance,)}


@dataclass(frozen=True)
class Wanted:
    """bound: of the covariance's error, in sigma_i sigma_j, that a proof has to come to"""

    arithmetic: str
    name: str
    form: str = "covariance"  # or gain
    partial: bool = False
    nis: bool = False
    lag: int = 0
    bound: float = 1e-4


@dataclass(frozen=True)
class Refused:
    form: str
    reason: str


@dataclass(frozen=True)
class Proof:
    """found: by the way products are added; track: of a damped record with gaps; means, for q31: their bounds"""

    found: dict[str, Found]
    track: Track
    wandering: Track  # the worst of records that are not damped: as far as the model goes, within the ranges
    means: Optional[classes.Means]
    rounding: float  # of a settled mean in sigma, where states and innovations are at their ranges: a bound
    ends: Optional[Track] = None  # the worst at the ends of the ranges, where there are ranges
    losses: Optional[tuple[float, float]] = None  # of a constant gain: of sigma, at the start and after gaps

    @property
    def mean(self) -> Track:
        """The worse of both records"""
        return max(self.track, self.wandering, key=_worst)

    @property
    def worst(self) -> Found:
        return max(self.found.values(), key=lambda one: one.error)


@dataclass(frozen=True)
class Product:
    model: Model
    wanted: Wanted
    plan: Plan
    proof: Proof
    refused: list[Refused] = field(default_factory=list)


def compiled(model: Model, wanted: Wanted, most: Optional[int] = None) -> Product:
    """The first form whose proof holds; KalmanqError with the figures of all that do not.  most: covariances, after
    which the search is given up"""
    with decimal.localcontext(exact.DIGITS):
        refuse(model, wanted.arithmetic)
        if wanted.partial and wanted.form == "gain":
            raise KalmanqError("--partial: a constant gain takes samples as a whole; leave out --form gain")
        maker = Maker(model, wanted, most)
        refused: list[Refused] = []
        cures: dict[str, None] = {}
        if wanted.form == "gain":
            return Product(model, wanted, *maker.of_constant_gain())
        for form in FORMS[wanted.arithmetic]:
            try:
                plan, proof = maker.proven(form())
                return Product(model, wanted, plan, proof, refused)
            except NotProven as problem:
                refused.append(Refused(form.name, str(problem)))
                cures |= dict.fromkeys(problem.cures)
                if isinstance(problem, NotClosed):
                    raise
    raise KalmanqError("; ".join(f"{one.form}: {one.reason}" for one in refused)
                       + f"; {', '.join([*cures, *(['f32'] if wanted.arithmetic == 'q31' else [])])} or kalmanq design "
                         "may do")


class NotProven(KalmanqError):
    """A form whose search has not closed, or found something wrong; what may cure it."""

    def __init__(self, reason: str, *cures: str):
        super().__init__(reason)
        self.cures = cures


class NotClosed(NotProven):
    """There are too many covariances: in any form."""


class Maker:
    """A model in an arithmetic, from which plans of several forms are made."""

    def __init__(self, model: Model, wanted: Wanted, most: Optional[int] = None):
        self.model, self.wanted, self.most = model, wanted, most
        self.gaps = model.gaps
        self.of = exact.numbers(model, wanted.arithmetic == "f32")
        self.settled = exact.settled(self.of)
        if self.gaps.max_gap > MOST_GAP:
            raise KalmanqError(f"max_gap: {self.gaps.max_gap} rows; a proof is for at most {MOST_GAP}")
        if wanted.partial and not self.gaps.max_gap:
            raise KalmanqError("--partial: a sample in part is one of a gap, and the model declares none: give [gaps] "
                               "max_gap, or leave out --partial")
        self.rows = self._rows_to_settle(MOST_ROWS[wanted.arithmetic])
        least = self.gaps.min_run or (self.rows if self.gaps.max_gap else 1)
        self.min_run = min(least, self.rows)
        self.means: Optional[classes.Means] = None
        self.subject = self._floats(False) if wanted.arithmetic == "f32" else self._fixed()

    def _rows_to_settle(self, most: int) -> int:
        try:
            return exact.rows_to_settle(self.of, self.settled, self.gaps.max_gap, SNAP, most)
        except KalmanqError as problem:
            cure = f"leave out --form, or take f32, with up to {MOST_ROWS['f32']}" if self.wanted.arithmetic == "q31" else \
                "leave out --form, or take kalmanq design"
            raise KalmanqError(f"{problem}: {cure}") from None

    def _names(self) -> tuple[list[str], list[str], list[str]]:
        return named(self.model.states, self.model.measurements, self.model.controls)

    def _floats(self, fused: bool) -> forms.Subject:
        states, measurements, controls = self._names()
        words = floats.Floats(self.of, fused)
        return forms.Subject(self.of, words, floats.PairMean(words, states, controls), states, measurements, controls)

    def _fixed(self) -> forms.Subject:
        is_gain, gap = self.wanted.form == "gain", classes.Gap(self.gaps.max_gap, self.wanted.partial)
        if gap.count(self.of.m) > classes.MOST_WAYS:
            raise KalmanqError(f"--partial: {gap.count(self.of.m)} gaps of any components of {self.of.m} over "
                               f"{self.gaps.max_gap} rows, and q31's ranges are proven for at most "
                               f"{classes.MOST_WAYS}: a smaller max_gap")
        if self.gaps.max_gap and self.min_run < self.rows:
            raise KalmanqError(f"min_run: {self.gaps.min_run} rows between gaps, but the covariance takes {self.rows} "
                               f"to settle, and q31's ranges are proven from there: min_run = {self.rows}, or f32")
        z = formats.ranges_of("measurements", self.model.measurements)
        u = formats.ranges_of("controls", self.model.controls)
        reach = classes.reach_by_gain(self.of, self.settled, self.rows, gap) if is_gain else \
            classes.reach_of(self.of, self.settled, self.rows, gap)
        x = [one.range or np.inf for one in self.model.states]
        self.means = classes.means_of(self.of, self.settled, reach, gap, x, z, u)
        made = formats.formats_of(self.model, self.of, self.settled, reach, self.means)
        states, measurements, controls = self._names()
        words = fixed.Fixed(self.of, made)
        readings = formats.readings_of(self.model, self.means, made)
        mean = fixed.WideMean(words, states, measurements, readings)
        return forms.Subject(self.of, words, mean, states, measurements, controls)

    def _structure(self, subject: forms.Subject, form: Any) -> Structure:
        if isinstance(form, forms.ConstantGain):
            return Structure({})
        return structure(subject, form, self.wanted.partial)

    def plan(self, form: Any, subject: forms.Subject) -> Plan:
        ranges = [one.range or LARGEST for one in self.model.measurements]
        doors = [subject.words.door("z", j, one) for j, one in enumerate(ranges)]
        stops = [subject.words.door("u", k, one.range or LARGEST) for k, one in enumerate(self.model.controls)]
        return Plan(
            self.wanted.name, self.model, subject, form, self._structure(subject, form), self.settled, self.rows,
            self.gaps.max_gap, self.min_run, doors, bounds=() if self.means is None else self.means.x.tolist(),
            most=[subject.words.end("z", j, one) for j, one in enumerate(ranges)],
            pushes=[subject.words.end("u", k, one.range) if one.range else 1.0
                    for k, one in enumerate(self.model.controls)], stops=stops, partial=self.wanted.partial,
            nis=self.wanted.nis, lag=self.wanted.lag, cap=self._cap(),
            stays=() if self.means is None else self.means.stays.tolist())

    def _cap(self) -> np.ndarray:
        """What the longest declared gap leaves of the start, if nothing is known better there than once settled"""
        of, P = self.of, self.settled.predicted
        P = of.P0 if np.all(np.diag(of.P0) >= np.diag(P)) else P
        for _ in range(self.gaps.max_gap):
            P = of.A @ P @ of.A.T + of.Q
        return P

    def of_constant_gain(self) -> tuple[Plan, Proof]:
        plan = self.plan(forms.ConstantGain(), self.subject)
        if self.wanted.lag:
            plan = replace(plan, forgets=max(self.rows, classes.rows_to_forget(self.of, self.settled, self.gaps.max_gap,
                                                                              MOST_TO_FORGET)))
        with Runner(plan) as runner:
            track, wandering, ends = self._records(runner)
        self._judge_means(track)
        loss = classes.losses(self.of, self.settled, self.rows, self.gaps.max_gap)
        return plan, Proof({}, track, wandering, self.means, self._rounding(), ends, loss)

    def proven(self, form: Any) -> tuple[Plan, Proof]:
        plan = self.plan(form, self.subject)
        found, track, wandering, ends = self._run(plan)
        all_found = {"": found}
        if self.wanted.arithmetic == "f32":
            fused, *_ = self._run(self.plan(form, self._floats(True)))
            all_found = {"products rounded": found, "fused multiply-add": fused}
        for how, one in all_found.items():
            self._judge(one, how)
        self._judge_means(track)
        return replace(plan, ranges=self._ranges(plan, found)), Proof(all_found, track, wandering, self.means,
                                                                     self._rounding(), ends)

    def searched(self, form: Any, most: int) -> Plan:
        """A plan whose search closes; the rest of its proof is left"""
        plan = self.plan(form, self.subject)
        with Runner(replace(plan, probes=plan.subject.words.is_fixed)) as runner:
            self._judge(runner.search(most), "")
        return plan

    def _rounding(self) -> float:
        if self.means is None:
            return rounding.of_floats(self.model, self.of, self.settled)
        return rounding.of_words(self.model, self.of, self.settled, self.subject.words.formats, self.means)

    def _records(self, runner: Runner) -> tuple[Track, Track, Optional[Track]]:
        """Of what is drawn of the model, damped; the worst of several that are not, and at the ends of the ranges"""
        gap = self.gaps.max_gap
        seeds = range(1, 1 + RECORDS) if all(one.range for one in self.model.measurements) else ()
        ends = [runner.record(RECORD // RECORDS, gap, ends=seed) for seed in seeds]
        free = [runner.record(RECORD, gap, wanders=seed) for seed in range(1, 1 + RECORDS)]
        return runner.record(RECORD, gap), max(free, key=_worst), max(ends, key=_worst, default=None)

    def _run(self, plan: Plan) -> tuple[Found, Track, Track, Optional[Track]]:
        entries = self.of.n * (self.of.n + 1) // 2
        limit = MOST_MEMORY // (16 * entries + 8 * entries + 48 * self.of.n + 64)
        given_up = self.most is not None and self.most < limit
        try:
            with Runner(replace(plan, probes=plan.subject.words.is_fixed)) as runner:
                found = runner.search(self.most if given_up else limit)
                if given_up and not found.closed:
                    raise KalmanqError(f"more than {self.most} covariances")
                return (found, *self._records(runner))
        except Overflow:
            raise NotProven("words of 32 bits are too few from what is known least (P0, a long gap) to what the "
                            "covariance settles to", START) from None

    def _judge(self, found: Found, how: str) -> None:
        how = f", {how}" if how else ""
        if not found.closed:
            raise NotClosed(f"there are more than {found.count} covariances{how}; {self._fewer()} leaves fewer")
        if found.bad:
            raise NotProven(f"{found.bad} of {found.count} covariances are not positive definite{how}", START)
        error = found.error * MARGIN[self.wanted.arithmetic]
        if not error <= self.wanted.bound:
            raise NotProven(f"a covariance is {error:.1e} sigma_i sigma_j from the exact one{how}, the bound is "
                            f"{self.wanted.bound:.0e}", START, "a larger --bound")

    def _fewer(self) -> str:
        """What would leave fewer covariances to be proven"""
        ways = [f"min_run = {self.rows}"] if self.min_run < self.rows else []
        return " or ".join([*ways, "a smaller max_gap", *(["no --partial"] if self.wanted.partial else [])])

    def _judge_means(self, track: Track) -> None:
        if not track.worst <= TOLERABLE:
            raise NotProven(f"a mean is {track.worst:.1e} sigma from the exact one within {RECORD} rows, the bound is "
                            f"{TOLERABLE:.0e}", "--form factor")

    def _ranges(self, plan: Plan, found: Found) -> dict[str, str]:
        """Of each line that was told: least and largest value; of means and innovations by their bounds."""
        if not plan.subject.words.is_fixed:
            return {}
        made = {}
        weighed = [f"n_{measured}" for measured in plan.subject.measurements]  # 0 in a search: it measures nothing
        for place, (least, greatest) in zip(probes_of(replace(plan, probes=True)), found.ranges):
            if max(-least, greatest) > 2**31 - 1:
                raise NotProven(f"a word overflows: {place.split()[-1]}")
            if place.split()[-1] not in weighed:
                made[place] = self._range(plan, place, least, greatest)
        return made

    def _range(self, plan: Plan, place: str, least: int, greatest: int) -> str:
        function, name = place.split()
        innovations = [f"y_{measured}" for measured in plan.subject.measurements]
        if name in innovations and self.means is not None:
            j, formats = innovations.index(name), plan.subject.words.formats
            constant = function in ("settled", "step")
            most = (self.means.settled if constant else self.means.y)[j]
            return f"at most {most * 2.0**(formats.settled if constant else formats.y)[j]:.2g}"
        return f"{least} to {greatest}"


def _worst(track: Track) -> float:
    return track.worst


def ram_of(plan: Plan) -> int:
    """Bytes of the filter where words are aligned"""
    words = 8 if plan.subject.words.is_fixed else 4
    counted = sum(int(type_[4:-2]) // 8 for type_, _ in bookkeeping(plan))  # bytes of uint8_t and others
    mean = sum(words for i in range(plan.subject.of.n) for _ in plan.subject.mean.fields(i))
    size = words * -(-counted // words) + mean + 4 * len(plan.structure.carried)
    size += 4 * plan.subject.of.m + words if plan.nis else 0
    size += 4 * plan.subject.of.m if plan.lag else 0
    return size + size % words


def fractions_of(plan: Plan) -> Optional[Sequence[int]]:
    return list(plan.subject.words.formats.z) if plan.subject.words.is_fixed else None
