"""Straight-line C: each result has a name and a line of its own, the same result only one."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Iterable, Optional

from kalmanq.compiler.proven.sums import Sum

NAME = re.compile(r"[A-Za-z_]\w*")


@dataclass(frozen=True)
class Line:
    """type name = text; a store has neither type nor name."""

    name: str
    type: str
    text: str
    note: str = ""

    def code(self) -> str:
        return f"const {self.type} {self.name} = {self.text};" if self.name else self.text


@dataclass
class Lines:
    """What is written, and which names are taken."""

    rows: list[Line] = field(default_factory=list)
    seen: dict[str, Sum] = field(default_factory=dict)
    used: dict[str, int] = field(default_factory=dict)
    taken: set[str] = field(default_factory=set)  # words that no line may be called
    formats: dict[str, int] = field(default_factory=dict)  # in fixed point: the fraction of each name

    def fresh(self, base: str) -> str:
        while True:
            count = self.used.get(base, 0)
            self.used[base] = count + 1
            name = base if count == 0 else f"{base}_{count}"
            if name not in self.taken:
                self.taken.add(name)
                return name

    def add(self, base: str, type_: str, text: str, note: str = "") -> Sum:
        """The name of this text, which is that of an earlier line where it is the same."""
        key = f"{type_} {text}"
        if key not in self.seen:
            name = self.fresh(base)
            self.seen[key] = Sum.named(name)
            self.rows.append(Line(name, type_, text, note))
        return self.seen[key]

    def load(self, name: str, type_: str, text: str, word: Optional[int]) -> Sum:
        made = self.add(name, type_, text)
        if word is not None:
            self.formats[name] = word
        return made

    def put_off(self, names: Iterable[str]) -> None:
        """The lines of these names come after what is written so far, which has no use for them."""
        late = set(names)
        self.rows = [row for row in self.rows if row.name not in late] + [row for row in self.rows if row.name in late]

    def do(self, statement: str) -> None:
        self.rows.append(Line("", "", statement))

    def title(self, text: str) -> None:
        """A remark of its own; a rule of its own where nothing follows."""
        self.rows.append(Line("", "", f"/* {text} */"))

    def living(self) -> list[Line]:
        """Without the lines whose names nobody reads, and titles under which nothing is left."""
        needed: set[str] = set()
        kept: list[Line] = []
        for row in reversed(self.rows):
            if row.name and row.name not in needed:
                continue
            if is_title(row) and (not kept or is_title(kept[-1])):
                continue
            if not is_title(row):
                needed |= set(NAME.findall(row.text))
            kept.append(row)
        return kept[::-1]


def is_title(row: Line) -> bool:
    return not row.name and row.text.startswith("/*")
