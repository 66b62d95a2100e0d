"""What holds of each entry of a factor for ever: a constant, or the entry that it always equals.

An optimistic fixed point: at first each entry is thought to keep its first value.  Predict and the update of each
component are traced; entries that change become variables, and entries that start alike and change alike stay one.  So
axes that are alike share their entries, and entries that are 0 for ever cost nothing.
"""

from __future__ import annotations

from typing import Callable, Mapping, Sequence, Union

from kalmanq.formulas.graph import Node, constant, node, symbol

Key = tuple[int, int]
Fact = Union[float, Key]  # a constant, or the entry that stands for it
Entries = dict[Key, Node]


def entries_of(facts: Mapping[Key, Fact], name: Callable[[Key], str]) -> Entries:
    return {key: symbol(name(fact)) if isinstance(fact, tuple) else constant(fact) for key, fact in facts.items()}


def facts(first: Mapping[Key, float], transfers: Sequence[Callable[[Entries], Entries]],
          rounded: Callable[[float], float]) -> dict[Key, Fact]:
    known: dict[Key, Fact] = {key: rounded(value) for key, value in first.items()}
    while True:
        entries = entries_of(known, lambda key: f"p{key}")
        results = [transfer(dict(entries)) for transfer in transfers]
        parted = _parted(known, first, results, rounded)
        if parted == known:
            return known
        known = parted


def _parted(known: Mapping[Key, Fact], first: Mapping[Key, float], results: Sequence[Entries],
            rounded: Callable[[float], float]) -> dict[Key, Fact]:
    made: dict[Key, Fact] = {}
    representatives: dict[tuple, Key] = {}
    for key, fact in known.items():
        after = [node(result[key]) for result in results]
        if isinstance(fact, float) and all(one.is_constant and rounded(one.value) == fact for one in after):
            made[key] = fact
        else:
            sort = (rounded(first[key]), fact if isinstance(fact, tuple) else None, tuple(map(id, after)))
            made[key] = representatives.setdefault(sort, key)
    return made
