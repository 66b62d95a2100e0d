"""The mean in words of 64 bits: A x + B u, innovations, the constant gain.

A coefficient is a word of 31 bits; what it multiplies is aligned by a constant shift.
"""

from __future__ import annotations

import math
from typing import Iterable, Sequence

import numpy as np

from kalmanq.compiler.exact import Numbers
from kalmanq.compiler.word_formats import Formats, down

EXACT = 28  # bits of a coefficient that need no shift


class Mean:
    def __init__(self, of: Numbers, formats: Formats, saturated: str):
        """saturated: the statement of the event"""
        self.exact, self.of, self.formats, self.saturated = of, of.doubles(), formats, saturated

    def predict(self) -> tuple[list[str], list[int]]:
        """Lines that write all x<i>, and which"""
        moved = {i: text for i in range(self.of.n) if (text := self._moved(i)) != f"x{i}"}
        return [*(f"const int64_t moved{i} = {text};" for i, text in moved.items()),
                *(f"x{i} = moved{i};" for i in moved)], list(moved)

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
        digits = 30 - down(abs(c))
        if digits >= by >= digits - 30 + EXACT:
            digits = by
        return f" + {aligned(f'product({word}, {word_of(c, digits)})', digits - by)}"

    def innovation(self, j: int) -> str:
        """z<j> - H_j x in words of z<j>"""
        narrow = self.formats.is_narrow[j]
        text = f"(int64_t)z{j}" if narrow else f"z{j}"
        for i in range(self.of.n):
            h = float(self.of.H[j, i])
            if h:
                text += self._seen(h, i, self.formats.x[i] - self.formats.z[j], narrow)
        return f"narrow({text})" if narrow else text

    def _seen(self, h: float, i: int, by: int, narrow: bool) -> str:
        size, digits = abs(h), 30 - down(h if h > 0 else -h)
        if math.frexp(size)[0] == 0.5:
            text = rounded(f"x{i}", by - down(size))
        else:
            text = rounded(f"wide({word_of(size, digits)}, x{i})", by + digits - 32)
        return f" {'-' if h > 0 else '+'} {text if narrow else f'(int32_t)({text})'}"

    def corrected(self, gain: np.ndarray, names: Sequence[str]) -> tuple[list[str], list[int]]:
        """x += gain * innovations; and which x"""
        lines, which = [], []
        for i in range(self.of.n):
            text = "".join(self._gained(float(gain[i, j]), i, j, names[j]) for j in range(self.of.m) if gain[i, j])
            if text:
                lines.append(f"x{i} += {text.removeprefix(' + ')};")
                which.append(i)
        return lines, which

    def _gained(self, k: float, i: int, j: int, y: str) -> str:
        """With a coefficient that lands on the point of x, where it has bits enough"""
        by = self.formats.x[i] - self.formats.z[j]
        digits = 30 - down(abs(k))
        if digits >= by >= digits - 30 + 20:
            digits = by
        return f" + {aligned(f'product({y}, {word_of(k, digits)})', digits - by)}"

    def stops(self, which: Iterable[int]) -> list[str]:
        """A mean stops at the end of its words."""
        tops: dict[int, list[int]] = {}
        for i in which:
            tops.setdefault(self.formats.end[i], []).append(i)
        lines = []
        for end, states in tops.items():
            ends = [f"x{i} = stopped(x{i}, INT64_C(1) << {end});" for i in states]
            if end > 33:
                sums = " | ".join(f"((uint32_t)(x{i} >> 32) + UINT32_C({1 << end - 32}))" for i in states)
                beyond = f"({sums}) >> {end - 31}"
            else:
                beyond = " || ".join(f"stopped(x{i}, INT64_C(1) << {end}) != x{i}" for i in states)
            lines += [f"if ({beyond}) {{", *(f"    {one}" for one in ends), f"    {self.saturated}", "}"]
        return lines


def word_of(c: float, digits: int) -> int:
    return min(round(math.ldexp(c, digits)), 2**31 - 1)


def aligned(text: str, by: int) -> str:
    """2^-by of it"""
    return text if not by else f"({text} >> {min(by, 63)})" if by > 0 else f"{text} * (INT64_C(1) << {-by})"


def rounded(text: str, by: int) -> str:
    """2^-by of it, to the nearest"""
    if by <= 0:
        return aligned(text, by)
    return f"(({text} + (INT64_C(1) << {min(by, 62) - 1})) >> {min(by, 62)})"
