"""What holds of each entry of a factor or a covariance for ever: a constant, or the entry that it always equals.

An optimistic fixed point: at first each entry is thought to keep its first value.  Predict and the update of each
component are traced; entries that change become variables, and entries that start alike and change alike stay one.  So
axes that are alike share their entries, and entries that are 0 for ever cost nothing.
"""

from __future__ import annotations

from decimal import Decimal
from typing import Any, Callable, Hashable, Mapping, Sequence, Union

from kalmanq.formulas.graph import Node, constant, node, symbol

Key = tuple[int, int]
Fact = Union[float, Decimal, Key]  # a constant, or the entry that stands for it
After = tuple[Union[float, Decimal, None], Hashable]  # the constant that an entry becomes, and what is equal of equal formulas
Entries = dict[Key, Node]


def entries_of(facts: Mapping[Key, Fact], name: Callable[[Key], str]) -> Entries:
    return {key: symbol(name(fact)) if isinstance(fact, tuple) else constant(fact) for key, fact in facts.items()}


def facts(first: Mapping[Key, float], transfers: Sequence[Callable[[Entries], Entries]],
          rounded: Callable[[float], float]) -> dict[Key, Fact]:
    def after(known: Mapping[Key, Fact]) -> dict[Key, list[After]]:
        entries = entries_of(known, lambda key: f"p{key}")
        results = [transfer(dict(entries)) for transfer in transfers]
        made = {key: [node(result[key]) for result in results] for key in known}
        return {key: [(rounded(one.value) if one.is_constant else None, id(one)) for one in nodes] for key, nodes in made.items()}

    return lasting({key: rounded(value) for key, value in first.items()}, after)


def lasting(first: Mapping[Key, Any], after: Callable[[Mapping[Key, Fact]], Mapping[Key, Sequence[After]]]) -> dict[Key, Fact]:
    """first: what entries begin with.  after: of facts, what each transfer makes of each entry"""
    known: dict[Key, Fact] = dict(first)
    while True:
        results, made = after(known), {}
        representatives: dict[tuple, Key] = {}
        for key, fact in known.items():
            if not isinstance(fact, tuple) and all(value == fact for value, _ in results[key]):
                made[key] = fact
            else:
                sort = first[key], fact if isinstance(fact, tuple) else None, tuple(results[key])
                made[key] = representatives.setdefault(sort, key)
        if made == known:
            return known
        known = made
