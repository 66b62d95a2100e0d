"""q31: what the shell asks of an arithmetic, in words of 32 bits; the mean has 64.

The factor is carried as the root S of P = S S' (factor.py), whose states may be in another order than the model's:
one that makes the C shorter.  Binary points are constants (formats.py).
"""

from __future__ import annotations

import math
from itertools import permutations
from typing import Mapping, Optional, Sequence

import numpy as np

from kalmanq.compiler.algorithm import lag
from kalmanq.compiler.algorithm.cycle import Cycle
from kalmanq.compiler.algorithm.fixed.expressions import Expressions, Value
from kalmanq.compiler.algorithm.fixed.factor import Entries, Factor, Key, entry, number_of
from kalmanq.compiler.algorithm.fixed.first import told_variances
from kalmanq.compiler.algorithm.fixed.formats import BITS, formats, gap_of, largest_sigmas, ranged, root_of, variance_word
from kalmanq.compiler.algorithm.fixed.lines import aligned, living
from kalmanq.compiler.algorithm.fixed.mean import Mean
from kalmanq.compiler.algorithm.fixed.readings import Readings
from kalmanq.compiler.given.enclosure import Settled
from kalmanq.compiler.given.request import RUN, Request
from kalmanq.compiler.given.slow import slow_words
from kalmanq.errors import KalmanqError
from kalmanq.formulas.printing import indented

NEGLIGIBLE = 1e-12  # of an innovation's sigma
GAIN_ERROR = 4e-6
ALL_ORDERS = 4  # states, of which all orders are tried
TUNABLE = ("--tunable: q31's formats are constants that follow from A, Q and R: leave --tunable out and compile one filter for "
           "each set of them, or take --arith f32")
Place = tuple[str, str, str]


class WordFilter(Readings):
    type, zero = "int32_t", "0"
    mean_type = covariance_type = "int64_t"
    arrays = ("x", "P")  # without padding
    most_operations = 8000  # about 32 kB
    refused_start = "beyond its format: its nearer end is taken, and an event says so"
    events = (("SIGMA_SATURATED", "a sigma would be beyond its format: the covariance was not predicted"),
              ("MEAN_SATURATED", "a mean or an innovation was beyond its format: the nearer end was taken"))

    def __init__(self, given: Request, steady: Optional[Settled], turn: Optional[Cycle]):
        if given.options.tunable:
            raise KalmanqError(TUNABLE)
        sigma = largest_sigmas(given.of, gap_of(given.model), steady)
        self.model = ranged(given.model, sigma)
        self.given, self.of, self.steady = given, given.of.doubles(), steady
        self.constant = steady or turn
        lagged = lag.gains(given.of, steady, given.options.lag) if steady else []
        gains = [*(self.constant.gains if self.constant else []), *(one.astype(float) for one in lagged)]
        self.formats = formats(given, self.model, self.constant, gains, sigma)
        self.mean = Mean(given.of, self.formats, self.event("MEAN_SATURATED"))
        made = [self._in_order(order) for order in self._orders()]
        self.factor, self.live, self.operations = min(made, key=lambda one: one[2])
        if self.constant is None:
            self.unresolved = slow_words(given, [2.0**-self.finest_fraction(i) for i in range(self.of.n)])

    def finer(self, times: float) -> str:
        of = told_variances(self.given, self.formats, self.steady, times)
        return f"Raw values hold the first sigma, which is far above what follows: a P0 of at most {of} is small enough; or use --arith f32." \
            if of else "--arith f32 or f64 is finer."

    # ---- the order of states, and which entries there are

    def _orders(self) -> list[tuple[int, ...]]:
        n = self.of.n
        if n <= ALL_ORDERS:
            return list(permutations(range(n)))
        seen = np.any(self.of.H != 0, axis=0)
        last = sorted(range(n), key=lambda i: bool(seen[i]))
        back = sorted(reversed(range(n)), key=lambda i: bool(seen[i]))
        return list(dict.fromkeys((tuple(range(n)), tuple(reversed(range(n))), tuple(last), tuple(back))))

    def _in_order(self, order: Sequence[int]) -> tuple[Factor, list[Key], int]:
        """Its factor, what of it is carried, and what a row costs"""
        factor = self.factor_of(order)
        there = {key for key, word in factor.words(factor.exact.P0).items() if word}
        while True:
            S: Entries = {key: entry(key) for key in there}
            lines = Expressions()
            predicted = factor.predict(lines, dict(S))
            factor.too_long(lines, predicted)
            after = [predicted, *(factor.update(lines, dict(S), j)[0] for j in range(self.of.m))]
            more = there | {key for one in after for key, value in one.items() if value is not None}
            if more == there:
                return factor, sorted(there, key=lambda key: (key[1], key[0])), lines.cost
            there = more

    def factor_of(self, order: Sequence[int]) -> Factor:
        return Factor(self.given.of, self.formats, order)

    def finest_fraction(self, i: int) -> int:
        """Of the words of S"""
        return self.sigma_fraction(i)

    @property
    def entries(self) -> Entries:
        return {key: entry(key) for key in self.live}

    # ---- fields and locals

    def event(self, name: str) -> str:
        return f"f->events |= {self.given.upper}_{name};"

    @property
    def fields(self) -> list[str]:
        return [f"int64_t x[{self.of.n}]; /* mean */",
                f"int32_t P[{max(len(self.live), 1)}]; /* S of the covariance S S' */"]

    def start(self) -> list[str]:
        first = self.factor.words(self.factor.exact.P0)
        return [*(f"f->x[{i}] = INT64_C({round(math.ldexp(x, self.formats.x[i]))});"
                  for i, x in enumerate(self.of.x0)),
                *(f"f->P[{slot}] = {first[key]};" for slot, key in enumerate(self.live))]

    def start_at(self) -> list[str]:
        """From mean[n] and sigma[n], each at most what its format holds"""
        f, lines = self.formats, []
        for i in range(self.of.n):
            by, most = f.x[i] - f.read[i], self._most_mean(i)
            lines.append(f"const int32_t mean{i} = mean[{i}] > {most} ? {most} : mean[{i}] < -{most} ? -{most} : mean[{i}];")
            lines.append(f"f->x[{i}] = {f'(int64_t)mean{i} >> {-by}' if by < 0 else f'mean{i} * (INT64_C(1) << {by})'};")
        for slot, (i, j) in enumerate(self.live):
            state, most = self.factor.order[i], self._most_sigma(i)
            lines += [f"f->P[{slot}] = 0;"] if i != j else [
                f"const int32_t sigma{state} = sigma[{state}] < 0 ? 0 : sigma[{state}] > {most} ? {most} : sigma[{state}];",
                f"f->P[{slot}] = sigma{state};"]
        return lines

    def _most_mean(self, i: int) -> int:
        f = self.formats
        return min(2 ** max(f.end[i] - f.x[i] + f.read[i], 0), 2**31 - 1)

    def _most_sigma(self, row: int) -> int:
        return 1 << BITS - self.factor.exponent[row] + self.factor.held[row]

    def started_at(self) -> list[str]:
        means = [f"mean{i} != mean[{i}]" for i in range(self.of.n)]
        sigmas = [f"sigma{i} != sigma[{i}]" for row, i in enumerate(self.factor.order) if (row, row) in self.live]
        return [*(f"if ({' || '.join(one)}) {self.event(event)}" for one, event in ((means, "MEAN_SATURATED"), (sigmas, "SIGMA_SATURATED")) if one),
                "return !f->events;"]

    def places(self, mean: bool = True, factor: bool = True) -> list[Place]:
        made = [("int64_t", f"x{i}", f"f->x[{i}]") for i in range(self.of.n)] if mean else []
        return made + [("int32_t", entry(key), f"f->P[{slot}]") for slot, key in enumerate(self.live) if factor]

    def factor_literals(self, P: np.ndarray) -> list[str]:
        made = self.factor.words_of(P)
        return [str(made[key]) for key in self.live]

    # ---- what is done

    less = more = ""  # of shifts, where S has another scale

    def predict_mean(self) -> list[str]:
        lines, moved = self.mean.predicted([False] * self.of.n)
        return [*lines, *self.mean.stored(moved)]

    def predict_factor(self) -> list[str]:
        lines = Expressions()
        after = self.factor.predict(lines, self.entries)
        beyond = self.factor.too_long(lines, after)
        if not beyond:
            return living([*lines.c, *self._stored(after)])
        return living([*lines.c, f"if (({beyond}) != 0u) {self.event('SIGMA_SATURATED')}", "else {",
                       *indented(self._stored(after)), "}"])

    def _stored(self, after: Entries) -> list[str]:
        return [f"{entry(key)} = {number_of(after.get(key))};" for key in self.live if after.get(key) != entry(key)]

    def update(self, j: int) -> list[str]:
        """Component j, whose value is z<j>"""
        f, lines = self.formats, Expressions()
        weight = self._student(lines, j) if self.given.options.student else None
        b, last, first, stores = self._updated(lines, j, weight)
        if last is None:
            return []
        more, shift = f.more[j], f.wide[j] + f.row[j] - f.weighed[j] - f.more[j]
        made = [f"const int64_t y = {self.mean.wide_innovation(j)};", *lines.c,
                f"const int64_t weighed = shifted(wide({last}.over, {f'4 * wide({weight}, y)' if weight else 'y'}), "
                f"{shift}{self.less} - {last}.half);",
                f"const int32_t v = narrow(weighed{f' >> {more}' if more else ''});"]
        made += [f"const int32_t rest = (int32_t)(weighed & {(1 << more) - 1});"] if more else []
        writes = [f"if (v != {f'weighed >> {more}' if more else 'weighed'}) {self.event('MEAN_SATURATED')}"]
        if weight and self.given.options.nis:
            square = variance_word(self.of.R[j], 2 * f.row[j])
            last = "nominal"
            made += [f"const reciprocal nominal = inverse_root(UINT64_C({square}) + {self._spread(lines, j)});",
                     f"const int32_t apart = narrow(shifted(wide(nominal.over, y), {shift + more} - nominal.half));"]
        writes += self._nis(j, "apart" if last == "nominal" else "v", f"word({last})")
        writes += first
        moved = [(self.factor.order[i], one) for i, one in enumerate(b) if one is not None]
        for i, one in sorted(moved):
            by = f.weighed[j] + BITS - f.exponent[i] - f.x[i]
            text = f"product({one}, v)" + (f" + (product({one}, rest) >> {more})" if more else "")
            writes.append(f"x{i} += {f'shifted({text}, {by}{self.more})' if by else f'({text}) >> finer' if self.more else text};")
        writes += [*self.mean.stops(sorted(i for i, _ in moved)), *stores]
        if self.given.options.gate is None:
            return living([*made, *writes])
        most = self._gate(j)
        return [*living([*made, *writes])[:-len(writes)], f"const int is_near = v >= -{most} && v <= {most};",
                f"if (is_near || f->rejected[{j}] >= {RUN}) {{",
                *indented([*writes, f"if (is_near) f->rejected[{j}] = 0;"]), "} else {",
                *indented([f"f->rejected[{j}]++;", self.event("GATED"), f"taken &= ~{1 << j}u;"]), "}"]

    def _updated(self, lines: Expressions, j: int, weight: Value) -> tuple[list[Value], Optional[str], list[str], list[str]]:
        """Gain times sigma of the innovation, the name of that sigma, and lines before and after the mean's"""
        after, b, last = self.factor.update(lines, self.entries, j, weight)
        return b, last, [], self._stored(after)

    def _spread(self, lines: Expressions, j: int) -> str:
        """The name of H_j P H_j'"""
        return self.factor.spread(lines, self.entries, j)

    def _student(self, lines: Expressions, j: int) -> str:
        """Name of the weight of component j, a fraction: sqrt of the least variance over that which it is taken with"""
        f, nu = self.formats, float(self.given.options.student or 0)
        r, least = (variance_word(one, 2 * f.far[j]) for one in (self.of.R[j], f.least[j]))
        root, half = root_of(least)
        y, by = aligned("y", f.wide[j] + f.far[j] - BITS), min(2 * (f.far[j] - f.row[j]), 63)
        spread = self._spread(lines, j)
        return lines.let("k", f"student(narrow({y}), {f'{spread} >> {by}' if by else spread}, UINT64_C({r}), UINT64_C({least}), "
                         f"{min(round(2**31 / (nu + 1)), 2**31 - 1)}, {root}, {half})")

    def _gate(self, j: int) -> int:
        assert self.given.options.gate is not None
        return min(round(math.ldexp(self.given.options.gate, self.formats.weighed[j])), 2**31 - 2)

    @property
    def nis_fraction(self) -> int:
        """Of the coarsest; m squares of 62 bits fit"""
        return 2 * min(self.formats.weighed) - (self.of.m - 1).bit_length()

    def _nis(self, j: int, v: str, sigma: str) -> list[str]:
        """Squares at the fraction of the coarsest"""
        if not self.given.options.nis:
            return []
        by = 2 * self.formats.weighed[j] - self.nis_fraction
        square = f"product({v}, {v})"
        return [f"f->nis += {f'{square} >> {by}' if by else square};", f"f->s[{j}] = {sigma};"]

    # ---- settled

    @property
    def resolution(self) -> np.ndarray:
        """What a gain may be off by: an innovation of one sigma moves the state by as much less than its own"""
        return GAIN_ERROR * np.sqrt(np.outer(self.constant.means, 1 / self.constant.variances.astype(float)))

    def settled(self, predicts: bool, then: Sequence[str]) -> list[str]:
        """The mean by the constant gain, from z0, z1, ..., and `then`"""
        lines, x = self.mean.predicted(np.any(self.of.H != 0, axis=0)) if predicts else ([], {})
        lines += [f"const int32_t y{j} = {self.mean.innovation(j, x)};" for j in range(self.of.m)]
        x = {i: x.get(i, f"x{i}") + self.mean.corrected(i, self.steady.gain_that_moves[i], self.resolution[i]) for i in range(self.of.n)}
        options = self.given.options
        writes = ["f->nis = 0;"] if options.nis else []
        if options.nis or options.gate is not None:
            lines += self._apart()
            for j in range(self.of.m):
                sigma = math.sqrt(float(self.steady.variances[j]))
                writes += self._nis(j, f"v{j}", str(round(math.ldexp(sigma, BITS - self.formats.row[j]))))
        writes += [f"f->y[{j}] = y{j};" for j in range(self.of.m)] if options.lag else []
        writes += [*self.mean.stored({i: text for i, text in x.items() if text != f"x{i}"}), *then]
        if options.gate is None:
            return living([*lines, *writes])
        passes = " && ".join(f"v{j} >= -{self._gate(j)} && v{j} <= {self._gate(j)}" for j in range(self.of.m))
        return [*lines, f"if ({passes}) {{", *indented(writes), "}"]

    # ---- constant gains in a table

    def gain_literals(self, gains: Sequence[np.ndarray]) -> list[list[str]]:
        return self.mean.table(gains, self.resolution)

    def gained(self, i: int, gains: Sequence[np.ndarray], at: str, y: str) -> str:
        return self.mean.tabled(i, gains, self.resolution, at, y)

    def innovation_text(self, j: int) -> tuple[Sequence[str], str]:
        return [], self.mean.innovation(j, {})

    def moved(self, added: Mapping[int, str]) -> list[str]:
        return self.mean.stored({i: f"x{i} + {text}" for i, text in added.items()})

    def _apart(self) -> list[str]:
        """Each innovation given the components before it, over its sigma: v<j>"""
        f, lines = self.formats, []
        lower = np.linalg.inv(self.steady.lower.astype(float))
        for j in range(self.of.m):
            sigma, text = math.sqrt(float(self.steady.variances[j])), ""
            for k in range(j + 1):
                c = lower[j, k] / sigma
                if abs(c) > NEGLIGIBLE / sigma:
                    text += f" + (int64_t){self.mean.narrowed(c, f'y{k}', f.weighed[j] - f.y[k])}"
            lines.append(f"const int32_t v{j} = narrow({text.removeprefix(' + ')});")
        return lines
