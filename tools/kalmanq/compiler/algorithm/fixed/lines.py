"""Lines of C over words, that q31's two algorithms make: names of expressions, in C and in Python."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from heapq import heappop, heappush
from itertools import groupby
from typing import Any, Callable, Optional, Sequence

from kalmanq.compiler.algorithm.fixed.python import functions
from kalmanq.formulas.printing import WORD, indented

EMPTY = {"reciprocal": "{0, 0, 1}", "inverted": "{0, 0}"}
END = 1 << 63
CONSTANT, NAME = re.compile(r"\s*const \w+ (\w+) = "), re.compile(r"[A-Za-z_]\w*")
Guard = tuple[tuple[str, bool], ...]  # names of conditions, and their answers


@dataclass(frozen=True)
class Line:
    """guard: what it is worked out with; python: where it is not C's text; without a name the text is a statement"""

    guard: Guard
    type: str
    name: str
    text: str
    python: str

    @property
    def c(self) -> str:
        return f"const {self.type} {self.name} = {self.text};" if self.name else self.text


@dataclass
class Lines:
    """cost: an estimate, to compare two texts that do the same"""

    made: list[Line] = field(default_factory=list)
    cost: int = 0
    known: dict[tuple[str, Guard], str] = field(default_factory=dict)
    used: dict[str, int] = field(default_factory=dict)

    def let(self, base: str, text: str, type_: str = "int32_t", cost: int = 0, guard: Guard = (), python: Optional[str] = None) -> str:
        """The name of an expression; equal ones are written once"""
        if (text, guard) not in self.known:
            count = self.used[base] = self.used.get(base, -1) + 1
            self.known[text, guard] = f"{base}{count}"
            self.made.append(Line(guard, type_, f"{base}{count}", text, python or text))
            self.cost += cost
        return self.known[text, guard]

    def do(self, statement: str) -> None:
        self.made.append(Line((), "", "", statement, ""))

    @property
    def c(self) -> list[str]:
        """Of lines without conditions"""
        return [one.c for one in self.made]


# ------------------------------------------------------------------------------ what an expression is written by


def aligned(text: str, by: int) -> str:
    """2^-by of it"""
    return text if not by else f"({text} >> {min(by, 62)})" if by > 0 else f"{text} * (INT64_C(1) << {-by})"


def rounded(text: str, by: int) -> str:
    """2^-by of it, to the nearest"""
    if by <= 0:
        return aligned(text, by)
    return f"(({text} + (INT64_C(1) << {min(by, 62) - 1})) >> {min(by, 62)})"


def word_of(c: float, digits: int) -> int:
    return min(round(math.ldexp(c, digits)), 2**31 - 1)


# ------------------------------------------------------------------------------ in which order, and in Python


def living(lines: Sequence[str]) -> list[str]:
    """Without the constants that no later line reads"""
    kept: list[str] = []
    needed: set[str] = set()
    for line in reversed(lines):
        made = CONSTANT.match(line)
        if made is None or made[1] in needed:
            needed |= set(NAME.findall(line.split(" = ", 1)[1] if made else line))
            kept.append(line)
    return kept[::-1]


def gathered(lines: Sequence[Line]) -> list[Line]:
    """In an order in which lines with one guard are together, as far as they may be"""
    places = {one.name: k for k, one in enumerate(lines)}
    needs = [{places[name] for name in _read(one) if name in places} for one in lines]
    users: list[list[int]] = [[] for _ in lines]
    for k, of in enumerate(needs):
        for place in of:
            users[place].append(k)
    ready: dict[Guard, list[int]] = {}
    for k, one in enumerate(lines):
        if not needs[k]:
            ready.setdefault(one.guard, []).append(k)
    made, guard = [], ()
    while any(ready.values()):
        if not ready.get(guard):
            guard = () if ready.get(()) else min((of[0], one) for one, of in ready.items() if of)[1]
        k = heappop(ready[guard])
        made.append(lines[k])
        for user in users[k]:
            needs[user].remove(k)
            if not needs[user]:
                heappush(ready.setdefault(lines[user].guard, []), user)
    return made


def _read(one: Line) -> set[str]:
    """Names that a line needs"""
    return {*WORD.findall(one.text), *(bit for bit, _ in one.guard)}


def c_of(lines: Sequence[Line], outputs: Sequence[str]) -> list[str]:
    """What a block makes for itself alone is declared in it"""
    runs = [(guard, list(own)) for guard, own in groupby(lines, lambda one: one.guard)]
    last = {name: k for k, (_, own) in enumerate(runs) for one in own for name in _read(one)}
    last.update({name: len(runs) for text in outputs for name in WORD.findall(text)})
    made, before = [], []
    for k, (guard, own) in enumerate(runs):
        outside = [one for one in own if guard and last.get(one.name, k) > k]
        before += [f"{one.type} {one.name} = {EMPTY.get(one.type, '0')};" for one in outside]
        block = [f"{'' if one in outside else f'const {one.type} '}{one.name} = {one.text};" for one in own]
        condition = " && ".join(f"{'' if answer else '!'}{bit}" for bit, answer in guard)
        made += [f"if ({condition}) {{", *indented(block), "}"] if guard else block
    return [*before, *made]


def python_of(lines: Sequence[Line], names: Sequence[str], outputs: Sequence[str],
              is_watched: bool = False) -> Callable[..., list[Any]]:
    """(far, numbers by name) -> outputs; watched: far gets the name of each line"""
    made = []
    for guard, own in groupby(lines, lambda one: one.guard):
        block = [text for one in own for text in _python(one, is_watched)]
        condition = " and ".join(f"{'' if answer else 'not '}{bit}" for bit, answer in guard)
        made += [f"if {condition}:", *indented(block)] if guard else block
    text = "\n".join([f"def run({', '.join(['far', *names])}):", *indented([*made, f"return [{', '.join(outputs)}]"])])
    space: dict[str, Any] = dict(functions())
    exec(text, space)
    return space["run"]


def _python(one: Line, is_watched: bool) -> list[str]:
    """C's 64 bits have to hold what Python has"""
    mark = [f"far.line = '{one.name}'"] if is_watched and "far" in one.python else []
    return [*mark, f"{one.name} = {one.python}", *([f"assert -{END} <= {one.name} < {END}"] if one.type == "int64_t" else [])]
