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
    """first: what entries begin with"""
    first = {key: rounded(value) for key, value in first.items()}
    known: dict[Key, Fact] = dict(first)
    while True:
        entries = entries_of(known, lambda key: f"p{key}")
        results = [transfer(dict(entries)) for transfer in transfers]
        nodes = {key: [node(result[key]) for result in results] for key in known}  # all of them at once: equal formulas are one object
        made: dict[Key, Fact] = {}
        representatives: dict[tuple, Key] = {}
        for key, fact in known.items():
            if not isinstance(fact, tuple) and all(one.is_constant and rounded(one.value) == fact for one in nodes[key]):
                made[key] = fact
            else:
                sort = first[key], fact if isinstance(fact, tuple) else None, tuple(map(id, nodes[key]))
                made[key] = representatives.setdefault(sort, key)
        if made == known:
            return known
        known = made
