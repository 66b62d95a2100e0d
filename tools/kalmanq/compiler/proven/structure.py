"""What holds of each entry of the covariance for ever (facts.py): zeros of models of several axes, axes that are alike and
states that are known for ever need no rule of their own.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Mapping

from kalmanq.compiler.facts import After, Fact, lasting
from kalmanq.compiler.proven.forms import Entries, Key, Subject
from kalmanq.compiler.proven.lines import Lines
from kalmanq.compiler.proven.sums import Sum


@dataclass(frozen=True)
class Structure:
    facts: dict[Key, Fact]

    @property
    def carried(self) -> list[Key]:
        """The entries that are variables."""
        return sorted({fact for fact in self.facts.values() if isinstance(fact, tuple)})

    def entries(self, names: dict[Key, str]) -> Entries:
        return {key: Sum.named(names[fact]) if isinstance(fact, tuple) else Sum(fact)
                for key, fact in self.facts.items()}


def structure(s: Subject, form: Any, in_part: bool = False) -> Structure:
    """in_part: components are updated without the others, too"""
    start = form.values(s.of.P0)
    names = {key: form.field(s, key) for key in start}

    def after(known: Mapping[Key, Fact]) -> dict[Key, list[After]]:
        results = _transfers(s, form, in_part, Structure(dict(known)).entries(names), names)
        made = {key: [result[key] for result in results] for key in known}
        return {key: [(one.constant if one.is_constant else None, (one.key(), form.word(s, key))) for one in sums]
                for key, sums in made.items()}

    return Structure(lasting(start, after))


def _transfers(s: Subject, form: Any, in_part: bool, P: Entries, names: dict[Key, str]) -> list[Entries]:
    """Of a predict, and of an update by all components or each alone, all of the same entries."""
    lines = Lines(taken=set(names.values()))
    s.words.begin(lines)
    lines.formats.update({name: form.word(s, key) for key, name in names.items()})
    x = [[Sum.named(name) for name, _ in s.mean.fields(i)] for i in range(s.of.n)]
    made, after = [form.predict(s, lines, dict(P))], dict(P)
    for j in range(s.of.m):
        after = form.update(s, lines, x, dict(P) if in_part else after, j, Sum.named(f"z[{j}]"), lambda *_: None)[1]
        made += [after] if in_part or j == s.of.m - 1 else []
    return made
