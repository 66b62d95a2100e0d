"""What holds of each entry of the covariance for ever: a constant, or the entry that it always equals.

An optimistic fixed point: at first each entry is thought to keep the value that it starts with.  Every transfer
(predict, each update) is traced; entries that are changed become variables, and those that start alike and are
changed alike stay one.  It ends where nothing parts any more: zeros of models of several axes, axes that are alike and
states that are known for ever need no rule of their own.
"""

from __future__ import annotations

from dataclasses import dataclass
from decimal import Decimal
from typing import Any, Union

from kalmanq.compiler.forms import Entries, Key, Subject
from kalmanq.compiler.lines import Lines
from kalmanq.compiler.sums import Sum

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


def structure(s: Subject, form: Any) -> Structure:
    start = form.values(s.of.P0)
    made = Structure(dict(start))
    while True:
        parted = _parted(s, form, start, made)
        if parted == made:
            return made
        made = parted


def _parted(s: Subject, form: Any, start: dict[Key, Decimal], made: Structure) -> Structure:
    names = {key: form.field(s, key) for key in start}
    results = _transfers(s, form, made.entries(names), names)
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


def _transfers(s: Subject, form: Any, P: Entries, names: dict[Key, str]) -> list[Entries]:
    """Of a predict and of each component's update, all of the same entries."""
    lines = Lines(taken=set(names.values()))
    s.words.begin(lines)
    lines.formats.update({name: form.word(s, key) for key, name in names.items()})
    x = [[Sum.named(name) for name, _ in s.mean.fields(i)] for i in range(s.of.n)]
    made = [form.predict(s, lines, dict(P))]
    for j in range(s.of.m):
        made.append(form.update(s, lines, x, dict(P), j, Sum.named(f"z[{j}]"), lambda *_: None)[1])
    return made
