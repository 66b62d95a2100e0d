"""Lines of formulas in fixed point, as C and as Python."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import groupby
from typing import Any, Callable, Sequence

from kalmanq.compiler.fixed_python import PYTHON
from kalmanq.compiler.printing import indented

EMPTY = {"reciprocal": "{0, 0, 1}", "inverted": "{0, 0}"}
END = 1 << 63


@dataclass(frozen=True)
class Line:
    """guard: names of conditions, and the answers that it is worked out with; python: where it is not C's text"""

    guard: tuple[tuple[str, bool], ...]
    type: str
    name: str
    text: str
    python: str


def c_of(lines: Sequence[Line]) -> list[str]:
    made = [f"{one.type} {one.name} = {EMPTY.get(one.type, '0')};" for one in lines if one.guard]
    for guard, own in groupby(lines, lambda one: one.guard):
        if not guard:
            made += [f"const {one.type} {one.name} = {one.text};" for one in own]
            continue
        condition = " && ".join(f"{'' if answer else '!'}{bit}" for bit, answer in guard)
        made += [f"if ({condition}) {{", *indented(f"{one.name} = {one.text};" for one in own), "}"]
    return made


def python_of(lines: Sequence[Line], names: Sequence[str], outputs: Sequence[str], is_watched: bool = False) -> Callable[..., list[Any]]:
    """(far, numbers by name) -> outputs; watched: far gets the name of each line"""
    made = []
    for guard, own in groupby(lines, lambda one: one.guard):
        block = [text for one in own for text in _python(one, is_watched)]
        condition = " and ".join(f"{'' if answer else 'not '}{bit}" for bit, answer in guard)
        made += [f"if {condition}:", *indented(block)] if guard else block
    text = "\n".join([f"def run({', '.join(['far', *names])}):", *indented([*made, f"return [{', '.join(outputs)}]"])])
    space: dict[str, Any] = dict(PYTHON)
    exec(text, space)
    return space["run"]


def _python(one: Line, is_watched: bool) -> list[str]:
    """C's 64 bits have to hold what Python has"""
    mark = [f"far.line = '{one.name}'"] if is_watched and "far" in one.python else []
    return [*mark, f"{one.name} = {one.python}", *([f"assert -{END} <= {one.name} < {END}"] if one.type == "int64_t" else [])]
