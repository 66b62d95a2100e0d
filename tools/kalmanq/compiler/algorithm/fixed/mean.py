"""The mean in words of 64 bits: A x + B u, innovations, the constant gain.

A coefficient is a word of 31 bits; what it multiplies is aligned by a constant shift.
"""

from __future__ import annotations

import math
from typing import Iterable, Mapping, Sequence

import numpy as np

from kalmanq.compiler.algorithm.fixed.formats import Formats, down
from kalmanq.compiler.algorithm.fixed.lines import aligned, rounded, word_of
from kalmanq.compiler.given.exact import Numbers

NARROW = 34  # bits of a mean that has next to none in its high word
EXACT = 28  # bits of a coefficient that need no shift


class Mean:
    def __init__(self, of: Numbers, formats: Formats, saturated: str):
        """saturated: the statement of the event"""
        self.exact, self.of, self.formats, self.saturated = of, of.doubles(), formats, saturated

    def predicted(self, named: Sequence[bool]) -> tuple[list[str], dict[int, str]]:
        """What the states that move become: formulas, or names of the lines that are returned"""
        moved = {i: text for i in range(self.of.n) if (text := self._moved(i)) != f"x{i}"}
        return [f"const int64_t p{i} = {text};" for i, text in moved.items() if named[i]], \
            {i: f"p{i}" if named[i] else text for i, text in moved.items()}

    def _moved(self, i: int) -> str:
        x, text = self.formats.x, f"x{i}"
        for k in range(self.of.n):
            c = float(self.exact.A[i, k] - (1 if i == k else 0))
            text += self.times(c, f"x{k}", x[i] - x[k]) if c else ""
        for k in range(self.of.l):
            c = float(self.of.B[i, k])
            text += self.scaled(c, f"u{k}", x[i] - self.formats.u[k]) if c else ""
        return text

    def times(self, c: float, x: str, by: int) -> str:
        """+ c x 2^by of a word of 64 bits"""
        sign, size = "-" if c < 0 else "+", abs(c)
        if math.frexp(size)[0] == 0.5:
            return f" {sign} {aligned(x, -by - down(size))}"
        digits = 30 - down(size)
        if digits >= 32 + by >= digits - 30 + EXACT:
            digits = 32 + by
        return f" {sign} {aligned(f'wide({word_of(size, digits)}, {x})', digits - 32 - by)}"

    def scaled(self, c: float, word: str, by: int) -> str:
        """+ c word 2^by of a word of 32 bits"""
        digits = self._digits_at(c, by)
        return f" + {aligned(f'product({word}, {word_of(c, digits)})', digits - by)}"

    def nearest(self, c: float, word: str, by: int) -> str:
        """c word 2^by of a word of 32 bits, to the nearest"""
        digits = self._digits_at(c, by)
        return rounded(f"product({word}, {word_of(c, digits)})", digits - by)

    def _digits_at(self, c: float, by: int) -> int:
        digits = 30 - down(abs(c))
        return by if digits >= by >= digits - 30 + EXACT else digits

    def narrowed(self, c: float, word: str, by: int) -> str:
        """c word 2^by, of 32 bits"""
        digits = min(30 - down(abs(c)), by + 62)
        text = f"product({word}, {word_of(c, digits)})"
        return f"narrow({aligned(text, digits - by)})" if digits >= by else \
            f"narrow({text}) * (INT64_C(1) << {min(by - digits, 30)})"

    def innovation(self, j: int, x: Mapping[int, str]) -> str:
        """Of 32 bits: z<j> - H_j x, at the fraction of y; x: names of states that are not x<i>"""
        f = self.formats
        if f.y[j] == f.z[j] and not f.is_narrow[j]:
            return f"z{j}" + "".join(f" {sign} (int32_t)({text})" for sign, text in self._seen(j, x, f.y[j]))
        return f"narrow({self._apart(j, x, f.y[j])})"

    def wide_innovation(self, j: int) -> str:
        """The same of 64 bits"""
        return self._apart(j, {}, self.formats.wide[j])

    def _apart(self, j: int, x: Mapping[int, str], fraction: int) -> str:
        z = aligned(f"(int64_t)z{j}", self.formats.z[j] - fraction)
        return z + "".join(f" {sign} {text}" for sign, text in self._seen(j, x, fraction))

    def _seen(self, j: int, x: Mapping[int, str], fraction: int) -> list[tuple[str, str]]:
        """Signs and terms of - H_j x"""
        made = []
        for i in range(self.of.n):
            h, by, name = float(self.of.H[j, i]), self.formats.x[i] - fraction, x.get(i, f"x{i}")
            if math.frexp(abs(h))[0] == 0.5:
                made.append(("-" if h > 0 else "+", rounded(name, by - down(abs(h)))))
            elif h:
                digits = 30 - down(abs(h))
                made.append(("-" if h > 0 else "+", rounded(f"wide({word_of(abs(h), digits)}, {name})", by + digits - 32)))
        return made

    def corrected(self, i: int, gain: np.ndarray, least: np.ndarray) -> str:
        """What the constant gains of state i make of y0, y1, ...; least: what they may be off by"""
        return "".join(self._gained(float(k), float(e), i, j) for j, (k, e) in enumerate(zip(gain, least)) if k)

    def _gained(self, k: float, least: float, i: int, j: int) -> str:
        digits, by = self._digits_of(k, least, i, j), self.formats.x[i] - self.formats.y[j]
        return f" + {aligned(f'product(y{j}, {word_of(k, digits)})', digits - by)}"

    def _digits_of(self, k: float, least: float, i: int, j: int) -> int:
        """Of a gain: it lands on the point of x, where it has bits enough"""
        digits, by = 30 - down(abs(float(k))), self.formats.x[i] - self.formats.y[j]
        return by if digits >= by and math.ldexp(0.5, -by) <= least else digits

    def table(self, gains: Sequence[np.ndarray], least: np.ndarray) -> list[list[str]]:
        """Their words, which tabled() reads; least: what they may be off by"""
        digits = self._digits(gains, least)
        return [[str(word_of(float(k), int(by))) for k, by in zip(one.ravel(), digits.ravel())] for one in gains]

    def tabled(self, i: int, gains: Sequence[np.ndarray], least: np.ndarray, at: str, y: str) -> str:
        """What gains of a table make of innovations; at, y: of one, with {} for its place"""
        f, digits, terms = self.formats, self._digits(gains, least)[i], []
        for j in (j for j in range(self.of.m) if any(one[i, j] for one in gains)):
            text = f"product({y.format(j)}, {at.format(i * self.of.m + j)})"
            terms.append(aligned(text, int(digits[j]) - f.x[i] + f.y[j]))
        return " + ".join(terms)

    def _digits(self, gains: Sequence[np.ndarray], least: np.ndarray) -> np.ndarray:
        """Of the largest in each place of the tables"""
        most = np.abs(gains).max(axis=0)
        return np.array([[self._digits_of(k, float(least[i, j]), i, j) if k else 0 for j, k in enumerate(row)]
                         for i, row in enumerate(most)])

    def stored(self, x: Mapping[int, str]) -> list[str]:
        """Lines that store means, the names of formulas; one beyond its words stops at their end (stop, below)."""
        if not x:
            return []
        least, lines = self._least(x), []
        for k, (i, text) in enumerate(x.items()):
            far = f"{'far |=' if k else 'uint32_t far ='} {self._far(i, f'm{i}', least)};"
            lines += [f"const int64_t m{i} = {text};", f"f->x[{i}] = m{i};", far]
        return [*lines, f"if ((far >> {least - 31}) != 0u) stop(f);"]

    def _far(self, i: int, name: str, least: int) -> str:
        """Of the high word of a mean: 0 but for its lower bits, where it is within its end"""
        end = self.formats.end[i]
        if end < NARROW:
            return f"(stopped({name}, INT64_C(1) << {end}) == {name} ? 0 : UINT32_MAX)"
        text = f"(uint32_t)({name} >> 32) + UINT32_C({1 << end - 32})"
        return f"({text}) >> {end - least}" if end > least else text

    def _least(self, which: Iterable[int]) -> int:
        return max(NARROW, min(self.formats.end[i] for i in which))

    def stops(self, which: Sequence[int]) -> list[str]:
        """The same of locals x<i>"""
        least = self._least(which)
        far = " | ".join(f"({self._far(i, f'x{i}', least)})" for i in which)
        ends = [f"x{i} = stopped(x{i}, INT64_C(1) << {self.formats.end[i]});" for i in which]
        return [f"if ((({far}) >> {least - 31}) != 0u) {{", *(f"    {one}" for one in ends), f"    {self.saturated}", "}"]

    def stop(self, type_: str) -> list[str]:
        """C: a function that takes all means within their ends"""
        ends = [f"    f->x[{i}] = stopped(f->x[{i}], INT64_C(1) << {end});" for i, end in enumerate(self.formats.end)]
        return [f"static void stop({type_} *f)", "{", *ends, f"    {self.saturated}", "}", ""]
