"""What holds of each entry of the covariance for ever: a constant, or the entry that it always equals.

An optimistic fixed point: at first each entry is thought to keep the value that it starts with.  Every transfer
(predict, update) is traced; entries that are changed become variables, and those that start alike and are
changed alike stay one.  It ends where nothing parts any more: zeros of models of several axes, axes that are alike and
states that are known for ever need no rule of their own.
"""

from __future__ import annotations

from dataclasses import dataclass
from decimal import Decimal
from typing import Any, Union

from kalmanq.compiler.proven.forms import Entries, Key, Subject
from kalmanq.compiler.proven.lines import Lines
from kalmanq.compiler.proven.sums import Sum

Fact = Union[Decimal, Key]  # a constant, or the entry that stands for it


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
    made = Structure(dict(start))
    while True:
        parted = _parted(s, form, in_part, start, made)
        if parted == made:
            return made
        made = parted


def _parted(s: Subject, form: Any, in_part: bool, start: dict[Key, Decimal], made: Structure) -> Structure:
    names = {key: form.field(s, key) for key in start}
    results = _transfers(s, form, in_part, made.entries(names), names)
    first: dict[tuple, Key] = {}
    facts: dict[Key, Fact] = {}
    for key, fact in made.facts.items():
        after = tuple(result[key].key() for result in results)
        if isinstance(fact, Decimal) and all(one == (fact, ()) for one in after):
            facts[key] = fact
        else:
            sort = (start[key], fact if isinstance(fact, tuple) else None, form.word(s, key), after)
            facts[key] = first.setdefault(sort, key)
    return Structure(facts)


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
