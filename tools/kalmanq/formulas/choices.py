"""Formulas that only one side of a condition needs: the C works them out in a branch, not for both sides."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Mapping, Optional, Sequence

from kalmanq.formulas.graph import Node

LEAST = 4  # operations of one side alone, from which on a branch is worth it
Key = tuple[int, int]  # id of a condition, and how many selects are below
Home = Optional[tuple[Key, int]]  # and the side; None: needed in any case


@dataclass(frozen=True)
class Choice:
    """The selects of one condition; inside: of each side, the operations that nothing else needs"""

    selects: list[Node]
    inside: tuple[list[Node], list[Node]]

    @property
    def condition(self) -> Node:
        return self.selects[0].args[0]

    def outside(self) -> list[Node]:
        """What the sides need of the rest"""
        own = {id(one) for side in self.inside for one in side}
        parts = [part for one in [*self.selects, *(one for side in self.inside for one in side)] for part in one.args]
        return [part for part in parts if isinstance(part, Node) and id(part) not in own]


def choices(order: Sequence[Node], roots: Sequence[Node]) -> dict[int, Choice]:
    """By id of each select.  order: all nodes, arguments first.  A choice inside a side of another choice stays a select"""
    by_condition: dict[Key, list[Node]] = {}
    ranks: dict[int, int] = {}  # of selects below, so that no choice waits for itself
    for one in order:
        ranks[id(one)] = max((ranks[id(part)] for part in one.args if isinstance(part, Node)), default=0) + (one.op == "select")
        if one.op == "select":
            by_condition.setdefault((id(one.args[0]), ranks[id(one)]), []).append(one)
    while by_condition:
        homes = _homes(order, roots, by_condition)
        nested = [key for key, selects in by_condition.items() if any(homes[id(one)] for one in selects)]
        if not nested:
            break
        for key in nested:
            del by_condition[key]
    operations = [one for one in order if one.op not in ("symbol", "constant")]
    first, second = ({key: [one for one in operations if homes[id(one)] == (key, side)] for key in by_condition} for side in (0, 1))
    made = [Choice(selects, (first[key], second[key])) for key, selects in by_condition.items()]
    return {id(one): choice for choice in made if max(map(len, choice.inside)) >= LEAST for one in choice.selects}


def _homes(order: Sequence[Node], roots: Sequence[Node], by_condition: Mapping[Key, Sequence[Node]]) -> dict[int, Home]:
    """Where each node is needed"""
    homes: dict[int, Home] = {id(one): None for one in roots}
    own = {id(one): key for key, selects in by_condition.items() for one in selects}
    for one in reversed(order):
        home = homes[id(one)]
        for place, part in enumerate(one.args):
            if isinstance(part, Node):
                there = (own[id(one)], place - 1) if place and id(one) in own else home
                homes[id(part)] = there if homes.get(id(part), there) == there else None
    return homes
