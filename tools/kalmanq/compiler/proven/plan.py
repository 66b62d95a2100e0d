"""What is to be written of a filter."""

from __future__ import annotations

from dataclasses import dataclass, field
from decimal import Decimal
from typing import Any, Mapping, Sequence

from kalmanq.compiler.exact import Settled, taken
from kalmanq.compiler.proven.forms import Key, Subject
from kalmanq.compiler.proven.structure import Structure
from kalmanq.model import Model


LARGEST = 1e18  # taken where no range is declared; its square is a float, and what comes of it stays a number


@dataclass(frozen=True)
class Plan:
    """What is to be written.

    name      of files and functions
    rows      measured in a row, after which the covariance is what it settles to
    doors     the largest word of each measurement; stops: of each control
    """

    name: str
    model: Model
    subject: Subject
    form: Any
    structure: Structure
    settled: Settled
    rows: int
    max_gap: int
    min_run: int
    doors: Sequence[str]
    remarks: Sequence[str] = ()
    bounds: Sequence[float] = ()  # of means, in fixed point
    most: Sequence[float] = ()  # of a record that is tried: how far measurements can go, and controls
    pushes: Sequence[float] = ()
    probes: bool = False  # for the search: each line's value is told
    ranges: Mapping[str, str] = field(default_factory=dict)  # of lines, by function and name
    stops: Sequence[str] = ()
    partial: bool = False  # samples of some components
    nis: bool = False
    lag: int = 0  # samples
    cap: Any = None  # covariance after the longest gap from the start or, where that is less, from the settled one
    stays: Sequence[float] = ()  # in fixed point: |mean| at most after a gap that was not declared
    forgets: int = 0  # samples in a row, after which a constant gain's mean is the optimal one

    @property
    def type(self) -> str:
        return f"{self.name}_filter"

    @property
    def upper(self) -> str:
        return self.name.upper()

    def field(self, key: Key) -> str:
        return self.form.field(self.subject, key)

    def entry(self, key: Key) -> str:
        """The C text of an entry: a field, or a constant"""
        fact = self.structure.facts[key]
        if isinstance(fact, tuple):
            return f"f->{self.field(fact)}"
        return self.subject.words.constant(fact, self.form.word(self.subject, key))

    def fraction(self, which: str, k: int) -> int:
        """In fixed point, of the word in which a state is read, a measurement or a control given"""
        formats = self.subject.words.formats
        return {"states": self.subject.mean.readings, "measurements": formats.z, "controls": formats.u}[which][k]

    @property
    def pivots(self) -> list[Decimal]:
        """Variances of settled innovations, taken one after the other"""
        P, made = self.settled.predicted, []
        for j in range(self.subject.of.m):
            made.append(self.subject.of.H[j] @ P @ self.subject.of.H[j] + self.subject.of.R[j])
            P = taken(self.subject.of, P, j)
        return made

    @property
    def all(self) -> int:
        """Bits of all components"""
        return (1 << self.subject.of.m) - 1

    @property
    def carries_covariance(self) -> bool:
        return bool(self.structure.facts)

    @property
    def rows_to_constant_gain(self) -> int:
        """Measured in a row, after which a step takes a sample by the constant gain"""
        return self.rows if self.carries_covariance else self.min_run

    @property
    def needs_math(self) -> bool:
        return not self.subject.words.is_fixed and (self.subject.words.fused or self.form.has_roots)

    @property
    def sample(self) -> str:
        return f"const {self.subject.words.type} z[{self.subject.of.m}]"

    @property
    def controls(self) -> str:
        count = self.subject.of.l
        return f", const {self.subject.words.type} u[{count}]" if count else ""


def bookkeeping(plan: Plan) -> list[tuple[str, str]]:
    """Type and name.  rows: measured in a row, in the upper half between a predict and its update; missed: samples
    of the last gap, 0 once there may be another; events: bits that stay"""
    return [("uint32_t", "rows"), ("uint16_t", "missed"), ("uint16_t", "events")]


def events(plan: Plan) -> dict[str, str]:
    """Names of the bits of f->events, from the lowest, and what they mean"""
    made = {"REFUSED": "a measurement was outside its range, NaN or infinite, or a second one without a predict: it was not taken"}
    if plan.stops:
        made["CONTROL_REFUSED"] = "a control was outside its range: the nearer end was taken" + \
            ("" if plan.subject.words.is_fixed else "; NaN: 0")
    made["SIGMA_SATURATED"] = "a gap was not declared: " + (
        "the covariance stays what a declared one leaves" if plan.carries_covariance else "the gain is not for it")
    if plan.stays:
        made["MEAN_SATURATED"] = "a mean went too far in such a gap: it stays there"
    return made


def event(plan: Plan, name: str) -> str:
    return f"f->events |= {plan.upper}_{name};"
