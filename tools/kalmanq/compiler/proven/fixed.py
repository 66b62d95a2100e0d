"""q31: words of 32 bits with a binary point of their own each, a mean of 64.

Each entry of the covariance has as many bits after the point as the largest sigmas of its states leave room for.  A
gain's point is such that gain times innovation lands on the point of the 64-bit mean: one multiply-accumulate, no
shift.  All points are constants, so all that is left of them in the C are shifts.
"""

from __future__ import annotations

from dataclasses import dataclass
from decimal import ROUND_HALF_EVEN, Decimal
from typing import Optional, Sequence

from kalmanq.compiler.exact import Numbers
from kalmanq.compiler.proven.lines import Lines
from kalmanq.compiler.proven.sums import Sum
from kalmanq.errors import KalmanqError

Mean = list[list[Sum]]
TWO = Decimal(2)


@dataclass(frozen=True)
class Formats:
    """Powers of two and fractions (value = word 2^-fraction).

    sigma, row_sigma    the least a with sigma <= 2^a, of states and of rows of H x
    variance            fractions of the innovations' variances; zeros: the most leading zeros that they have
    x, rows             fractions of means, of rows of H x
    z, u                of measurements, controls
    y, settled          of innovations; of those that the constant gain takes, which reach less far and are finer
    weighed             of innovations over their variances; nis: of 64 bits
    """

    sigma: Sequence[int]
    row_sigma: Sequence[int]
    variance: Sequence[int]
    zeros: Sequence[int]
    x: Sequence[int]
    rows: Sequence[int]
    z: Sequence[int]
    y: Sequence[int]
    settled: Sequence[int]
    u: Sequence[int]
    weighed: Sequence[int]
    nis: int


def rounded(value: Decimal) -> int:
    return int(value.to_integral_value(rounding=ROUND_HALF_EVEN))


def exponent(value: Decimal) -> Optional[int]:
    """k where |value| = 2^k; None where it is no power of two."""
    k = floor_log2(value)
    return k if abs(value) == TWO ** k else None


def floor_log2(value: Decimal) -> int:
    """The largest k with 2^k <= |value|, by exact comparisons."""
    k = int((abs(value).ln() / TWO.ln()).to_integral_value(rounding=ROUND_HALF_EVEN))
    while TWO ** k > abs(value):
        k -= 1
    while TWO ** (k + 1) <= abs(value):
        k += 1
    return k


def ceil_log2(value: Decimal) -> int:
    """The least k with |value| <= 2^k"""
    k = floor_log2(value)
    return k if abs(value) == TWO ** k else k + 1


class Fixed:
    """The arithmetic of q31: what forms.py asks of one.  A word is its fraction."""

    type = "int32_t"
    is_fixed = True
    fused = False

    def __init__(self, of: Numbers, formats: Formats):
        self.of = of
        self.formats = formats

    # ---- the points

    def covariance(self, i: int, j: int) -> int:
        return 30 - self.formats.sigma[i] - self.formats.sigma[j]

    cross = covariance

    def row(self, j: int, i: int) -> int:
        return 30 - self.formats.sigma[i] - self.formats.row_sigma[j]

    def variance(self, j: int) -> int:
        return self.formats.variance[j]

    def gain(self, j: int, i: int) -> int:
        return self.formats.x[i] - self.formats.y[j]

    def begin(self, lines: Lines) -> None:
        for letter, fractions in (("z", self.formats.z), ("u", self.formats.u)):
            lines.formats.update({f"{letter}[{k}]": fraction for k, fraction in enumerate(fractions)})

    # ---- lines

    def name(self, lines: Lines, base: str, value: Sum, word: int, note: str = "") -> Sum:
        if value.is_constant or (value.name and lines.formats[value.name] == word):
            return value
        made = lines.add(base, "int32_t", self._text(lines, value, word), self._noted(word, note))
        lines.formats[made.name] = word
        return made

    @staticmethod
    def _noted(word: int, note: str) -> str:
        return f"Q{word}{', ' if note else ''}{note}"

    def gained(self, lines: Lines, base: str, row: Sum, w: Sum, j: int, i: int) -> Sum:
        if row.is_zero:
            return row
        row = self.name(lines, "h", row, self.row(j, i))
        word, shift = self.gain(j, i), self.row(j, i) + self._reciprocal(j) - self.gain(j, i)
        made = lines.add(base, "int32_t", f"(int32_t)({product(row.name, w.name)} >> {shift})",
                         self._noted(word, "gain"))
        lines.formats[made.name] = word
        return made

    def named_row(self, lines: Lines, base: str, row: Sum, j: int, i: int) -> Sum:
        return self.name(lines, base, row, self.row(j, i), "P h")

    def _reciprocal(self, j: int) -> int:
        return 62 - self.formats.zeros[j] - self.formats.variance[j]

    def reciprocal(self, lines: Lines, base: str, variance: Sum, j: int) -> Sum:
        made = lines.add(base, "int32_t", f"inverse((uint32_t){variance.name}, {self.formats.zeros[j]})",
                         self._noted(self._reciprocal(j), ""))
        lines.formats[made.name] = self._reciprocal(j)
        return made

    def _text(self, lines: Lines, value: Sum, word: int) -> str:
        """Words that need no scaling, what is scaled in one sum that is rounded once, and products."""
        plain: list[tuple[bool, str]] = []
        scaled: list[tuple[Decimal, str]] = []
        for names, coefficient in value.terms.items():
            c = coefficient * TWO ** (word - sum(lines.formats[name] for name in names))
            if len(names) == 2:
                plain.append((c < 0, _narrowed(product(*names), -need(exponent(c)))))
            elif abs(c) >= 1 and exponent(c) is not None:
                plain.append((c < 0, names[0] if abs(c) == 1 else f"{int(abs(c))} * {names[0]}"))
            else:
                scaled.append((c, names[0]))
        if value.constant:
            plain.append((value.constant < 0, str(abs(rounded(value.constant * TWO ** word)))))
        plain += _scaled(scaled)
        plain.sort(key=lambda term: term[0])
        return joined(plain)

    def weighed(self, lines: Lines, base: str, value: Sum, j: int) -> Sum:
        """What an innovation is multiplied by for NIS"""
        return self.name(lines, base, value, self.formats.weighed[j])

    def nis(self, lines: Lines, parts: Sequence[tuple[int, Sum, Sum]]) -> str:
        f = self.formats
        return joined([(False, f"({product(weighed.name, y.name)} >> {f.weighed[j] + lines.formats[y.name] - f.nis})")
                       for j, weighed, y in parts])

    def constant(self, value: Decimal, word: int) -> str:
        return str(rounded(value * TWO ** word))

    def store(self, value: Sum, word: Optional[int] = None) -> str:
        return value.name or self.constant(value.constant, need(word))

    # ---- for the search

    def value(self, text: str, word: int) -> str:
        return f"(double){text} * {float(TWO ** -word)!r}"

    def taken(self, which: str, index: str) -> list[str]:
        return [f"static const double scale[] = {{{self._scales(which, 1)}}};",
                f"const double word = value * scale[{index}];", "return (int32_t)(word < 0 ? word - 0.5 : word + 0.5);"]

    def given(self, which: str, index: str) -> list[str]:
        return [f"static const double scale[] = {{{self._scales(which, -1)}}};",
                f"return (double)word * scale[{index}];"]

    def _scales(self, which: str, sign: int) -> str:
        fractions = self.formats.z if which == "z" else self.formats.u
        return ", ".join(repr(float(TWO ** (sign * fraction))) for fraction in fractions) or "1"

    def printed(self, text: str) -> list[str]:
        return [f'printf(" %lld", (long long){text});']

    def door(self, which: str, j: int, span: float) -> str:
        """The largest word of a measurement (z) or a control (u)"""
        return str(rounded(Decimal(span) * TWO ** getattr(self.formats, which)[j]))

    def end(self, which: str, j: int, span: float) -> float:
        """What the largest word is of: not quite the end of a range that is no multiple of a step"""
        return float(int(self.door(which, j, span)) * TWO ** -getattr(self.formats, which)[j])

    def is_outside(self, value: str, limit: str) -> str:
        return f"{value} < -{limit} || {value} > {limit}"


def need(value: Optional[int]) -> int:
    if value is None:
        raise ValueError("no power of two")
    return value


def product(a: object, b: object) -> str:
    return f"product({a}, {b})"


def _narrowed(text: str, shift: int) -> str:
    """A 64-bit text as a word, rounded"""
    return f"(int32_t)(({text} + {half(shift)}) >> {shift})" if shift > 0 else f"(int32_t)({text} * {1 << -shift})"


def _moved(name: str, places: int) -> str:
    """A word with so many more binary places, or fewer, rounded"""
    if places == 0:
        return name
    return f"{1 << places} * {name}" if places > 0 else f"(({name} + {half(-places)}) >> {-places})"


def half(shift: int) -> str:
    value = 1 << (shift - 1)
    return str(value) if value < 1 << 31 else f"INT64_C({value})"


def _scaled(terms: Sequence[tuple[Decimal, str]]) -> list[tuple[bool, str]]:
    if not terms:
        return []
    (c, name), *others = terms
    k = exponent(c)
    if not others and k is not None and -31 < k < 0:
        return [(c < 0, f"(({name} + {half(-k)}) >> {-k})")]
    shift = min(32, *(30 - floor_log2(c) for c, _ in terms))
    text = "".join(f" + {product(rounded(c * TWO ** shift), name)}" for c, name in terms if rounded(c * TWO ** shift))
    return [(False, f"(int32_t)(({half(shift)}{text}) >> {shift})")] if text else []


def joined(terms: Sequence[tuple[bool, str]]) -> str:
    made = ""
    for negative, text in terms:
        made += (" - " if negative else " + ") + text if made else ("-" if negative else "") + text
    return made or "0"


class WideMean:
    """mean = x, 64 bits.  names: of the states"""

    single = "int64_t"

    def __init__(self, words: Fixed, names: Sequence[str], measurements: Sequence[str], readings: Sequence[int]):
        self.words, self.names, self.readings = words, names, readings
        self.measured = [f"f->y_{name}" for name in measurements]
        self.x = words.formats.x

    def fields(self, i: int) -> list[tuple[str, str]]:
        return [(f"x_{self.names[i]}", "int64_t")]

    def start(self, i: int) -> list[str]:
        return [str(rounded(self.words.of.x0[i] * TWO ** self.x[i]))]

    def word(self, i: int, value: float) -> str:
        return f"INT64_C({rounded(Decimal(value) * TWO ** self.x[i])})"

    def predict(self, lines: Lines, x: Mean, controls: Sequence[Sum]) -> Mean:
        A, B, f = self.words.of.A, self.words.of.B, self.words.formats
        made = []
        for i in range(self.words.of.n):
            terms = [part for l in [i, *(l for l in range(self.words.of.n) if l != i)] if A[i][l]
                     for part in times(A[i][l] * TWO ** (self.x[i] - self.x[l]), x[l][0].name)]
            terms += [(False, product(rounded(B[i][k] * TWO ** (self.x[i] - f.u[k])), u.name))
                      for k, u in enumerate(controls) if B[i][k]]
            made.append([self._named(lines, i, joined(sorted(terms, key=lambda term: term[0])), x[i][0])])
        return made

    def _named(self, lines: Lines, i: int, text: str, old: Sum) -> Sum:
        return old if text == old.name else lines.add(f"x_{self.names[i]}", "int64_t", text, f"Q{self.x[i]}")

    def innovation(self, lines: Lines, x: Mean, j: int, z: Sum, base: str, note: str, settled: bool = False) -> Sum:
        h, f = self.words.of.H[j], self.words.formats
        word = f.settled[j] if settled else f.y[j]
        seen = [i for i in range(self.words.of.n) if h[i]]
        point = f.rows[j]
        terms = [part for i in seen for part in times(h[i] * TWO ** (point - self.x[i]), x[i][0].name)]
        text = f"{_moved(z.name, word - f.z[j])} - {_narrowed(joined(terms), point - word)}"
        made = lines.add(base, "int32_t", text, f"Q{word}, {note}")
        lines.formats[made.name] = word
        return made

    def correct(self, lines: Lines, i: int, x: list[Sum], change: Sum) -> list[Sum]:
        text = x[0].name
        for names, c in change.terms.items():
            factor = c * TWO ** (self.x[i] - sum(lines.formats[name] for name in names))
            text += f" + {product(*(names if len(names) == 2 else (rounded(factor), names[0])))}"
        return [self._named(lines, i, text, x[0])]

    def value(self, i: int) -> tuple[str, str]:
        field = f"f->x_{self.names[i]}"
        return f"(double)({field} >> 32) * {float(TWO ** (32 - self.x[i]))!r}", \
            f"(double)({field} & 0xffffffff) * {float(TWO ** -self.x[i])!r}"

    def whole(self, i: int) -> str:
        return f"f->x_{self.names[i]}"

    def corrected(self, i: int, mean: str, change: Sum) -> str:
        for (name,), c in change.terms.items():
            j = self.measured.index(name)
            word = rounded(c * TWO ** (self.x[i] - self.words.formats.settled[j]))
            if abs(word) >= 1 << 31:
                raise KalmanqError(f"--lag: a gain of {self.names[i]} is {c:.3g}, too large for its word: a "
                                   "smaller lag, or f32")
            mean += f" + {product(word, name)}"
        return mean

    def reading(self, i: int) -> tuple[str, str]:
        return self.lagged(i, self.whole(i))

    def lagged(self, i: int, mean: str) -> tuple[str, str]:
        return "int32_t", _narrowed(mean, self.x[i] - self.readings[i])


def parts_of(c: Decimal) -> tuple[int, Decimal, int]:
    """A coefficient of a 64-bit word: whole times of it, and a part: by a shift, or else in units of 2^-32"""
    whole = rounded(c)
    part = c - whole
    shift = -need(exponent(part)) if part and exponent(part) is not None else 0
    if 0 < shift < 32:
        return whole, part, shift
    return whole, rounded(part * TWO ** 32) * TWO ** -32, 0


def held(c: Decimal) -> Decimal:
    """What `times` multiplies by"""
    whole, part, _ = parts_of(c)
    return whole + part


def times(c: Decimal, x: str) -> list[tuple[bool, str]]:
    """c x of a 64-bit x: whole times of it, and a part by a shift, or by its high and its low word"""
    whole, part, shift = parts_of(c)
    if shift:
        terms = [(part < 0, f"({x} >> {shift})")]
    else:
        terms = [(part < 0, f"wide({rounded(abs(part) * TWO ** 32)}, {x})")] if part else []
    if whole:
        terms.insert(0, (whole < 0, x if abs(whole) == 1 else f"{abs(whole)} * {x}"))
    return terms
