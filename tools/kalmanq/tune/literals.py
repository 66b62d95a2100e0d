"""The C of a model with its noises left open: which numbers of the text they are in, and how.

The C is emitted twice, with sizes of the noises that are different powers of two.  A number of the text that differs is of one
noise: its ratio says of which one, and how.  So the text with any sizes is the one that `kalmanq compile` writes for them, but for last
digits where a size is 1, which the text leaves out, or where a number has several terms in it.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Any, Callable, Optional, Sequence

import numpy as np

from kalmanq.errors import KalmanqError

NUMBER = re.compile(r"(?<![\w.])((?:\d+\.\d*|\d+)(?:e[+-]?\d+)?f?)(?![\w.])")
GATES, DEGREES, NO_LOSS = (3.0, 5.0), (1.0, 3.0), (1.0, 1.0)  # of a gate and of Student's noise, in the two texts
CLOSE = 1e-6  # of a ratio, but for the rounding of floats
SIZE, ROOT, SQUARE, INVERSE, SHARE = "size", "root", "square", "inverse", "share"  # factor times theta, its root, K^2, 1 / (nu + 1), theta nu / (nu + 1)


@dataclass(frozen=True)
class Literal:
    """noise: -1 where it is of the loss's parameter alone; begun: the number at the sizes of
    the model's file, where that is another one"""

    form: str
    noise: int
    factor: float
    begun: Optional[float] = None

    def told(self) -> list[Any]:
        return [self.form, self.noise, self.factor, self.begun]


@dataclass(frozen=True)
class Template:
    """pieces: of the text, between them the literals"""

    pieces: list[str]
    literals: list[Literal]


Emitted = Callable[[Sequence[float], float], str]  # the text with sizes of the noises, and the parameter of a loss


def sizes_of(count: int, which: int) -> list[float]:
    """Of the first text (0) and of the second one (1): powers of 4, never 1, so that roots are powers of 2.  From text to text the
    exponents go by 3, -3, 7, -7, ..."""
    made = []
    for k in range(count):
        j, sign = k // 2, 1 if k % 2 else -1
        made.append(4.0 ** (sign * 2 * (j + 1) if which == 0 else -sign * (2 * j + 1)))
    return made


def template(emitted: Emitted, count: int, loss: str, begun: Optional[tuple[Sequence[float], str]] = None) -> Template:
    """begun: sizes of the model's file, and their text"""
    parameters = {"gate": GATES, "student": DEGREES}.get(loss, NO_LOSS)
    first, second = (NUMBER.split(emitted(sizes_of(count, which), parameters[which])) for which in (0, 1))
    if len(first) != len(second) or first[::2] != second[::2]:
        raise KalmanqError("the C has another form with other noises: a page cannot show it; kalmanq compile writes it for each")
    pieces, literals = [""], []
    for k, (text, other) in enumerate(zip(first, second)):
        if k % 2 == 0 or text == other:
            pieces[-1] += text
        else:
            literals.append(_literal(_value(text), _value(other), count, parameters))
            pieces.append("")
    made = Template(pieces, literals)
    return made if begun is None else _as_begun(made, NUMBER.split(begun[1]), first, second, begun[0])


def _value(text: str) -> float:
    return float(np.float32(text[:-1]) if text.endswith("f") else text)


def value_of(form: str, noise: int, sizes: Sequence[float], parameter: float) -> float:
    """What a factor of 1 makes"""
    size = 1.0 if noise < 0 else sizes[noise]
    return {SIZE: size, ROOT: math.sqrt(size), SQUARE: parameter**2, INVERSE: 1 / (parameter + 1), SHARE: size * parameter / (parameter + 1)}[form]


def _literal(first: float, second: float, count: int, parameters: tuple[float, float]) -> Literal:
    """Of the ratio that it has: each noise and form has another one"""
    some = [(SQUARE, -1), (INVERSE, -1), (SHARE, -1), *((form, k) for k in range(count) for form in (SIZE, ROOT, SHARE))]
    for form, noise in some:
        made = [value_of(form, noise, sizes_of(count, which), parameters[which]) for which in (0, 1)]
        if made[0] != made[1] and abs(second / first * made[0] / made[1] - 1) < CLOSE:
            return Literal(form, noise, first / made[0])
    raise KalmanqError("a number of the C is of several noises: a page cannot show it; kalmanq compile writes it for each")


def _as_begun(made: Template, text: Sequence[str], first: Sequence[str], second: Sequence[str], sizes: Sequence[float]) -> Template:
    """With the numbers that the C has at the sizes of the file, where these are not factor times size to the last bit"""
    if text[::2] != first[::2]:
        return made  # a factor of 1 is left out of the file's text: last digits may differ
    numbers = [_value(text[k]) for k in range(1, len(text), 2) if first[k] != second[k]]
    rounded = np.float32 if any(one.endswith("f") for one in text[1::2]) else np.float64
    literals = [one if one.form not in (SIZE, ROOT) or rounded(one.factor * value_of(one.form, one.noise, sizes, 1.0)) == rounded(number)
                else Literal(one.form, one.noise, one.factor, number) for one, number in zip(made.literals, numbers)]
    return Template(made.pieces, literals)


def in_double(single: Template, double: Template) -> Template:
    """With the factors of the text in double, which a float has lost in part"""
    if len(single.literals) != len(double.literals):
        return single
    literals = [one if (one.form, one.noise) != (other.form, other.noise) or np.float32(other.factor) != np.float32(one.factor)
                else Literal(one.form, one.noise, other.factor, one.begun) for one, other in zip(single.literals, double.literals)]
    return Template(single.pieces, literals)


def with_loads(made: Template, array: str) -> str:
    """The text that reads its open numbers out of an array"""
    parts = [made.pieces[0]]
    for k, piece in enumerate(made.pieces[1:]):
        parts += [f"{array}[{k}]", piece]
    return "".join(parts)
