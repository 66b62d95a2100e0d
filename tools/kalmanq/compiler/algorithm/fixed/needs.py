"""In which forms formulas are needed: as words, wide, as inverses, as roots."""

from __future__ import annotations

import math
from typing import Optional, Sequence

from kalmanq.formulas.graph import CONDITIONS, Node, needed

WORDS = ("constant", "symbol", "sin", "cos", "exp", "sqrt", "atan2", "inverse")
OF_ANY = ("inverse", "sqrt", "sin", "cos", "exp", "log", "not", "and", "or")


def doubled(one: Node) -> Optional[tuple[int, Node]]:
    """k and a, where it is 2^k a"""
    if one.op == "mul" and one.args[0].is_constant and not one.args[1].is_constant:
        half, k = math.frexp(one.args[0].value)
        return (k - 1, one.args[1]) if half == 0.5 else None
    return None


def weighed(one: Node) -> bool:
    """Is it a constant times a formula?"""
    return one.op == "mul" and one.args[0].is_constant and one.args[0].value > 0


def divided(one: Node) -> Optional[tuple[Node, Node]]:
    """b and 1 / c, where it is their product"""
    if one.op != "mul" or doubled(one):
        return None
    for a, b in (one.args, one.args[::-1]):
        if b.op == "inverse":
            return a, b
    return None


def kind(one: Node) -> str:
    """What it is made as"""
    half = doubled(one)
    if half:
        return kind(half[1])
    if one.op in CONDITIONS:
        return "bit"
    return "word" if one.op in WORDS or divided(one) else "wide"


def needs(roots: Sequence[Node]) -> dict[int, set[str]]:
    """By id: bit, word, wide, inverted, root"""
    order = needed(roots)[0]
    made: dict[int, set[str]] = {id(one): set() for one in order}

    def need(one: Node, what: str) -> None:
        own = kind(one)
        made[id(one)].add(own if what == "any" or what == "wide" and own == "word" else what)

    for one in roots:
        need(one, "any")
    for one in reversed(order):
        for a, what in _asked(one, made[id(one)]):
            need(a, what)
    return made


def _asked(one: Node, as_: set[str]) -> list[tuple[Node, str]]:
    args, half, quotient = one.args, doubled(one), divided(one)
    if one.op in ("constant", "symbol"):
        return []
    if half:
        return [(half[1], what) for what in sorted(as_)]
    if quotient:
        return [(quotient[0], "word"), (quotient[1], "inverted")]
    if one.op == "inverse" and args[0].op == "sqrt":
        return [(args[0], "root")]
    what = "any" if one.op in OF_ANY or weighed(one) else "word" if one.op == "mul" else "wide"
    return [(a, "bit" if one.op == "select" and not k else what) for k, a in enumerate(args)]
