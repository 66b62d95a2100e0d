"""q31: where the first sigma is far above what follows, the words of S become finer, all by the same power of two.

f->finer, from 0 at the start, is that power.  Between rows of S nothing changes; the roots of Q and R, and what an update
adds to the mean, are shifted by it.  After an update S is doubled while it has room, and where a predict has none it is halved.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, Optional, Sequence

import numpy as np

from kalmanq.compiler.algorithm.cycle import Cycle
from kalmanq.compiler.algorithm.fixed.expressions import Expressions
from kalmanq.compiler.algorithm.fixed.factor import Column, Factor, entry
from kalmanq.compiler.algorithm.fixed.first import settled_covariance
from kalmanq.compiler.algorithm.fixed.formats import BITS, Formats, formats, gap_of, half_of, largest_sigmas, root_of, variance_word
from kalmanq.compiler.algorithm.fixed.lines import living
from kalmanq.compiler.algorithm.fixed.words import Place, WordFilter
from kalmanq.compiler.given.enclosure import Settled
from kalmanq.compiler.given.request import Request
from kalmanq.formulas.printing import indented

ENOUGH, RIGHT = 17.5, 1e-4  # bits at most, however late it settles; of sigma_i sigma_j
LEAST = 2  # bits that are worth their instructions
MOST = 62  # bits of a shift


class RescaledFactor(Factor):
    def __init__(self, given: Request, of: Formats, order: Sequence[int], power: int):
        self.power = power
        super().__init__(given.of, of, order)

    def finest(self, P: np.ndarray) -> dict:
        return self.words(P, self.power)

    def _columns(self, P: np.ndarray) -> list[Column]:
        made = self.finest(P)
        return [Column([made.get((i, j)) or None for i in range(self.n)]) for j in range(self.n)]

    def noises(self, lines: Expressions) -> list[Column]:
        return [Column([None if word is None else lines.let("q", f"{word} >> coarse", cost=1) for word in one.entries]) for one in self.noise]

    def variance(self, j: int) -> tuple[str, tuple[str, str]]:
        square = variance_word(self.formats.least[j], 2 * (self.formats.row[j] - self.power))
        root, half = root_of(square)
        return f"(UINT64_C({square}) >> 2 * coarse)", (str(root), f"{half} + coarse")


class RescaledWords(WordFilter):
    def __init__(self, given: Request, steady: Optional[Settled], turn: Optional[Cycle], power: int):
        self.power = power
        super().__init__(given, steady, turn)

    def factor_of(self, order: Sequence[int]) -> Factor:
        return RescaledFactor(self.given, self.formats, order, self.power)

    def finest_fraction(self, i: int) -> int:
        return super().finest_fraction(i) + self.power

    # ---- fields and locals

    @property
    def fields(self) -> list[str]:
        return [*super().fields, f"int32_t finer; /* words of S are 2^-finer of what they are at first, {self.power} at most */"]

    def size(self) -> int:
        return super().size() + 4

    def start(self) -> list[str]:
        return [*super().start(), "f->finer = 0;"]

    def start_at(self) -> list[str]:
        return [*super().start_at(), "f->finer = 0;"]

    def places(self, mean: bool = True, factor: bool = True) -> list[Place]:
        return [*super().places(mean, factor), *([("int32_t", "finer", "f->finer")] if factor else [])]

    def factor_literals(self, P: np.ndarray) -> list[str]:
        made = self.factor.finest(P[np.ix_(self.factor.order, self.factor.order)])
        return [str(made[key]) for key in self.live]

    def first_low(self) -> Sequence[str]:
        return [f"f->finer = {self.power};"]

    def covariance(self) -> dict[str, Any]:
        finer = f"(f->calls >= SETTLED ? {self.power} : f->finer)" if self.steady else "f->finer"
        return {**super().covariance(), "value": f"sum >> 2 * {finer}"}

    # ---- what is done

    less, more = " - finer", " + finer"

    @property
    def coarse(self) -> list[str]:
        return [f"const int coarse = {self.power} - finer;"]

    def predict_factor(self) -> list[str]:
        lines = Expressions()
        after = self.factor.predict(lines, self.entries)
        beyond = self.factor.too_long(lines, after)
        halves = [f"{entry(key)} = ({entry(key)} + 1) >> 1;" for key in self.live]
        if not beyond:
            return living([*self.coarse, *lines.c, *self._stored(after)])
        again = [f"if ({beyond}) {{", "    if (finer) {", *indented(indented([*halves, "finer -= 1;", "continue;"])), "    }",
                 f"    {self.event('SIGMA_SATURATED')}", "} else {", *indented(self._stored(after)), "}", "break;"]
        return living(["for (;;) {", *indented([*self.coarse, *lines.c, *again]), "}"])

    def update(self, j: int) -> list[str]:
        made = super().update(j)
        return living([*self.coarse, *made]) if made else []

    def finer_lines(self) -> list[str]:
        """After an update: while S has room it is doubled"""
        n, f = self.of.n, self.factor
        room = min(BITS - e + held for e, held in zip(f.exponent, f.held)) - 1 - math.ceil(math.log2(n) / 2)
        sizes = " | ".join(f"(uint32_t)({entry(key)} < 0 ? -{entry(key)} : {entry(key)})" for key in self.live)
        doubles = [f"{entry(key)} = {entry(key)} * 2;" for key in self.live]
        return [f"for (uint32_t bits = {sizes}; finer < {self.power} && !(bits >> {room - 1}); bits <<= 1) {{", *indented([*doubles, "finer += 1;"]), "}"]


def _enough(steady: Optional[Settled]) -> float:
    """Bits of a sigma with which covariances are right to 1e-4: roundings add up while it settles"""
    return ENOUGH if steady is None else min(ENOUGH, math.log2(math.sqrt(steady.samples) / RIGHT))


def finer_by(given: Request, of: WordFilter, steady: Optional[Settled]) -> int:
    """By how many bits S may become finer: 0, where it is fine enough, or where that is no use"""
    options, P = given.options, settled_covariance(given, steady)
    if options.nis or options.student or options.every or options.loops or P is None:
        return 0
    sigma = np.sqrt(np.diag(P).astype(float))
    if (np.log2(np.maximum(sigma, 1e-300)) + BITS - of.formats.exponent).min() >= _enough(steady):
        return 0
    later = replace(given, of=replace(given.of, P0=P))
    made = formats(later, of.model, None, [], largest_sigmas(later.of, gap_of(given.model)))
    now = of.formats
    added = max(max(now.weighed) + BITS - e - x for e, x in zip(now.exponent, now.x))  # shifts of what an update adds
    found = int(min([*np.subtract(now.exponent, made.exponent), *np.subtract(now.row, made.row), MOST - added]))
    while found >= LEAST and not all(_has_shift(now, j, found) for j in range(len(now.row))):
        found -= 1
    return found if found >= LEAST else 0


def _has_shift(of: Formats, j: int, power: int) -> bool:
    """Is an innovation over its sigma still shifted down, by 1 bit or more, where words are finest?  So are they by 31 bits at most"""
    half = half_of(variance_word(of.least[j], 2 * (of.row[j] - power)))
    return of.wide[j] + of.row[j] - of.weighed[j] - of.more[j] - power - half >= 1
