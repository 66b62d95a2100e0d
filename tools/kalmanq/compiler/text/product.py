"""A model compiled: its request, the steady covariance, and the texts of its C."""

from __future__ import annotations

import hashlib
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Optional, Sequence

from kalmanq.compiler.algorithm import cycle
from kalmanq.compiler.algorithm.arithmetic import Arithmetic
from kalmanq.compiler.algorithm.fixed.loops import LoopedWords
from kalmanq.compiler.algorithm.fixed.rescaled import RescaledWords, finer_by
from kalmanq.compiler.algorithm.fixed.words import WordFilter
from kalmanq.compiler.algorithm.floats import FloatFilter
from kalmanq.compiler.algorithm.loops import LoopedFilter
from kalmanq.compiler.given import enclosure
from kalmanq.compiler.given.request import GAP, LONGEST_GAP, Options, Request, request
from kalmanq.compiler.text import emit, head
from kalmanq.compiler.text.cycle_text import CycleText
from kalmanq.compiler.text.delayed import Delayed, delayed
from kalmanq.errors import KalmanqError
from kalmanq.formulas import graph
from kalmanq.model import Model
from kalmanq.run.checks import lasting

TOO_SLOW = f"it takes more than {1 << enclosure.MOST} full samples to settle"


@dataclass(frozen=True)
class Product:
    """code: without what takes late measurements"""

    given: Request
    steady: Optional[enclosure.Settled]
    cycle: Optional[cycle.Cycle]
    arithmetic: Arithmetic
    text: emit.Text
    header: str
    code: str
    late: Optional[Delayed] = None

    def sources(self) -> dict[str, str]:
        return {f"{self.given.name}.c": self.code + (f"\n{self.late.code()}" if self.late else ""), f"{self.given.name}.h": self.header}

    @property
    def calls(self) -> int:
        """The filter's count of calls once it has settled; 0: it does not settle"""
        return 2 * self.steady.samples if self.steady and not self.given.options.student else 0

    @property
    def events(self) -> dict[str, str]:
        """Names of the bits of f->events, from the lowest, and what they mean"""
        return dict(re.findall(rf"^    {self.given.upper}_([A-Z_]+) = \d+,? /\* (.*) \*/", self.header, re.M))

    @property
    def ram(self) -> int:
        """Bytes of the filter where words are aligned: its arithmetic's, calls and a counter if there are any, events, rejections"""
        options, align = self.given.options, self._align
        events = 8 if self.text.counter else align if options.nis else 2
        size = self.arithmetic.size() + events + (self.given.of.m if options.gate is not None else 0)
        return -(-size // align) * align

    @property
    def ram_delayed(self) -> int:
        """Bytes of NAME_delayed; 0: all come in time"""
        return self.late.ram(self.ram, self._align) if self.late else 0

    @property
    def _align(self) -> int:
        return 4 if self.given.options.arithmetic == "f32" else 8


def compiled(model: Model, name: str, options: Options = Options(), source: str = "") -> Product:
    """source: a line about the model's file"""
    given = request(model, name, options)
    gap = min(max(model.gaps.max_gap, GAP), LONGEST_GAP)
    steady = None if options.every else enclosure.settled(given.of, gap, options.settle)
    turn = _cycle(given)
    if options.lag and not options.settles:
        other = "--tunable" if options.tunable else "--robust student"
        raise KalmanqError(f"--lag and {other}: a lag has a constant gain, and {other} works it out in each row: leave --lag or {other} out")
    if options.lag and steady is None:
        raise KalmanqError("--lag: is of a constant gain, and this filter has none (kalmanq check says why): leave --lag out; the "
                           "library's kq_lag takes any model")
    with graph.fresh():
        a = _arithmetic(given, steady if options.settles else None, turn)
        text = emit.Text(a) if turn is None else CycleText(a, turn)
        return written(text, remarks(given, steady, turn, source), delayed(text), steady, turn)


def written(text: emit.Text, remarks: Sequence[str], late: Optional[Delayed] = None, steady: Optional[enclosure.Settled] = None,
            turn: Optional[cycle.Cycle] = None) -> Product:
    return Product(text.given, steady, turn, text.a, text, head.header(text, late), text.code(remarks), late)


def remarked(product: Product, source: str) -> Product:
    """The same, with a line about the model's file in its C"""
    return compiled(product.given.model, product.given.name, product.given.options, source)


def _cycle(given: Request) -> Optional[cycle.Cycle]:
    options = given.options
    if not options.every:
        return None
    cycle.check(given)
    return cycle.settled(given.of, options.every, options.settle) if options.settles else None


def _arithmetic(given: Request, steady: Optional[enclosure.Settled], turn: Optional[cycle.Cycle]) -> Arithmetic:
    is_fixed, options = given.options.arithmetic == "q31", given.options
    straight, looped = (WordFilter, LoopedWords) if is_fixed else (FloatFilter, LoopedFilter)
    known = (given, steady, turn) if is_fixed else (given, steady)
    if options.loops is None and not options.tunable:
        made = straight(*known)
        if is_fixed and made.operations <= made.most_operations and (finer := finer_by(given, made, steady)):
            return RescaledWords(*known, finer)
        return made if made.operations <= made.most_operations else looped(*known)
    return (looped if options.loops else straight)(*known)


def remarks(given: Request, steady: Optional[enclosure.Settled], turn: Optional[cycle.Cycle], source: str) -> list[str]:
    what = f"{given.name}: written by kalmanq compile."
    return [what, *([source] if source else []), "", *settling(given, steady, turn)]


def settling(given: Request, steady: Optional[enclosure.Settled], turn: Optional[cycle.Cycle]) -> list[str]:
    """What is known of the steady state, in a sentence or two"""
    if turn is not None:
        return [f"After {turn.cycles} cycles of {len(turn.rows)} rows each row of the cycle has a constant gain, if every row has the",
                f"components that are due: each variance is then within {turn.tolerance:.0e} of the steady one."]
    if steady is None:
        return ["The covariance has no steady state that every start leads to: the gain is worked out in each row."] \
            if given.options.every or lasting(given.model) else [f"The gain is worked out in each row: {TOO_SLOW}."]
    if not given.options.settles:
        return ["With --robust student or --tunable the gain is worked out in each row."]
    return [f"After {steady.samples} full samples the gain is constant: whatever happened before, each variance is then",
            f"within {steady.tolerance:.0e} of the steady one.  After one missing sample: {steady.after_gap[0]} samples."]


def fingerprint(path: Path) -> str:
    return f"Model file {path.name}, SHA-256 {hashlib.sha256(path.read_bytes()).hexdigest()}"
