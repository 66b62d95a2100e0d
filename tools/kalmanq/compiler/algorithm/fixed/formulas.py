"""Formulas in fixed point: each gets a binary point from the values that it had in records, and a line of C and of Python.

    word     31 bits, value = word 2^-fraction, for products and arguments
    wide     64 bits: products and sums of them, exact but for bits far below; their bounds are constants, so none overflows
    inverted 1 / value, a number and the power of two of its own, for quotients

A word is held at its end, which `far` tells.  A formula that only one branch of a condition needs is worked out in that branch.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, Callable, Iterable, Mapping, Optional, Sequence

from kalmanq.compiler.algorithm.fixed.functions import HALF, LOG2_E, TURN, WORD
from kalmanq.compiler.algorithm.fixed.lines import Lines, c_of, gathered, python_of
from kalmanq.compiler.algorithm.fixed.needs import divided, doubled, kind, needs, weighed
from kalmanq.compiler.algorithm.fixed.python import Far
from kalmanq.compiler.algorithm.fixed.values import WORD_BITS, Guard, Number, constant_word, fraction_for, guards
from kalmanq.formulas.graph import CONDITIONS, Node, needed

LIMIT = 1 << 62  # of wide numbers
LOGARITHM = 1 << 39  # bound of logarithms, 2^-31
ROUNDS = 12  # in which formats are widened
NARROWEST = 1 << 10  # beyond it an exponential is 0, or out of all formats
STEMS = {"int64_t": "w", "int32_t": "v", "uint32_t": "p", "int": "c", "reciprocal": "r", "inverted": "i"}
SIGNS = {"lt": "<", "le": "<=", "eq": "=="}


@dataclass(frozen=True)
class Input:
    fraction: int
    bound: int = 1 << 31


@dataclass
class FixedFormulas:
    """roots: lowered; inputs: of symbols; most: largest values by id"""

    roots: Sequence[Node]
    inputs: Mapping[str, Input]
    most: Mapping[int, float]
    lines: Lines = field(default_factory=Lines)

    def __post_init__(self) -> None:
        self.guards = guards(self.roots)
        self.needs = needs(self.roots)
        self.words: dict[int, Number] = {}
        self.wides: dict[int, Number] = {}
        self.others: dict[int, tuple[str, int]] = {}  # roots, inverses: names and fractions
        self.bits: dict[int, str] = {}
        self.phases: dict[tuple[int, Guard], str] = {}
        for one in needed(self.roots)[0]:
            if one.op in CONDITIONS:
                self._condition(one)
            elif one.op not in ("constant", "symbol") and doubled(one) is None:
                self._make(one)
        self.order = gathered(self.lines.made)

    # ---- numbers in a form

    def word(self, one: Node) -> Number:
        half = doubled(one)
        if half:
            made = self.word(half[1])
            return made._replace(fraction=made.fraction - half[0])
        if one.op == "constant":
            return constant_word(one.value)
        if one.op == "symbol":
            return Number(one.args[0], self.inputs[one.args[0]].fraction, self.inputs[one.args[0]].bound)
        return self.words[id(one)]

    def wide(self, one: Node) -> Number:
        """Or a word"""
        half = doubled(one)
        if half:
            made = self.wide(half[1])
            return made._replace(fraction=made.fraction - half[0])
        return self.wides[id(one)] if id(one) in self.wides else self.word(one)

    def at(self, one: Node, fraction: int) -> Number:
        """Wide, at a fraction"""
        if one.op == "constant":
            value = round(math.ldexp(one.value, fraction))
            return Number(f"INT64_C({value})", fraction, abs(value))
        text, from_, bound = self.wide(one)
        by = fraction - from_
        if by >= 0:
            return Number(f"{text} * INT64_C({1 << by})" if by or not self._is_wide(one) else text, fraction, bound << by)
        if by < -62:
            return Number("INT64_C(0)", fraction, 0)
        return Number(f"({text} >> {-by})", fraction, (bound >> -by) + 1)

    def _is_wide(self, one: Node) -> bool:
        half = doubled(one)
        return self._is_wide(half[1]) if half else id(one) in self.wides

    def together(self, args: Sequence[Node], total: Callable[[Iterable[int]], int]) -> list[Number]:
        """At the finest fraction at which the total of the bounds stays within LIMIT"""
        fractions = [self.wide(one).fraction for one in args if one.op != "constant"]
        finest = max(fractions)
        constants = [constant_word(one.value).fraction for one in args if one.op == "constant" and one.value]
        finest = max([finest, *(min(one, finest + 31) for one in constants)])
        while True:
            made = [self.at(one, finest) for one in args]
            if total(number.bound for number in made) <= LIMIT:
                return made
            finest -= 1

    def fraction_of(self, one: Node) -> int:
        return fraction_for(self.most[id(one)])

    def fraction_at(self, id_: int) -> int:
        """Of a word"""
        return self.words[id_].fraction

    # ---- lines

    def _let(self, one: Node, type_: str, text: str, python: Optional[str] = None) -> str:
        guard = tuple((self.bits[condition], answer) for condition, answer in self.guards[id(one)])
        return self.lines.let(STEMS[type_], text, type_, guard=guard, python=python)

    def _condition(self, one: Node) -> None:
        if one.op in ("lt", "le", "eq"):
            a, b = self.together(one.args, max)
            self.bits[id(one)] = self._let(one, "int", f"{a.text} {SIGNS[one.op]} {b.text}")
            return
        args = [self.bits[id(a)] for a in one.args]
        c, python = (f"!{args[0]}", f"not {args[0]}") if one.op == "not" else \
            (f" {'&&' if one.op == 'and' else '||'} ".join(args), f" {one.op} ".join(args))
        self.bits[id(one)] = self._let(one, "int", c, python)

    def _make(self, one: Node) -> None:
        needs = self.needs[id(one)]
        if one.op == "sqrt":
            self._root(one)
        elif one.op == "inverse":
            self._inverse(one)
        elif kind(one) == "word":
            self.words[id(one)] = self._function(one)
        else:
            made, python = self._wide(one)
            if "wide" in needs or python:
                made = made._replace(text=self._let(one, "int64_t", made.text, python))
                self.wides[id(one)] = made
            if "word" in needs:
                self._narrow(one, made)

    def _narrow(self, one: Node, made: Number) -> None:
        fraction = min(self.fraction_of(one), made.fraction)
        by = made.fraction - fraction
        text, bound = f"rounded({made.text}, {by})" if by else made.text, (made.bound >> by) + 1 if by else made.bound
        if by > 62:
            text, bound = "INT64_C(0)", 0
        fits = bound < WORD
        name = self._let(one, "int32_t", f"narrowed({text})" if fits else f"held({text}, far)")
        self.words[id(one)] = Number(name, fraction, min(bound, WORD))

    def _wide(self, one: Node) -> tuple[Number, Optional[str]]:
        """And Python where it is not C"""
        args, op = one.args, one.op
        if op == "mul" and weighed(one) and self._is_wide(args[1]):
            return self._times(args[1], constant_word(args[0].value, 31, whole=True)), None
        if op == "mul":
            a, b = map(self.word, args)
            return Number(f"product({a.text}, {b.text})", a.fraction + b.fraction, a.bound * b.bound), None
        if op in ("add", "sub"):
            if op == "sub" and args[0].equals(0):
                b = self.wide(args[1])
                return Number(f"INT64_C(0) - {b.text}", b.fraction, b.bound), None
            a, b = self.together(args, sum)
            return Number(f"{a.text} {'+' if op == 'add' else '-'} {b.text}", a.fraction, a.bound + b.bound), None
        if op == "select":
            bit, (a, b) = self.bits[id(args[0])], self.together(args[1:], max) if not all(a.is_constant for a in args[1:]) else \
                self._constants(args[1:])
            return Number(f"{bit} ? {a.text} : {b.text}", a.fraction, max(a.bound, b.bound)), f"({a.text} if {bit} else {b.text})"
        if op == "fmod":
            a, b = self.together(args, max)
            return Number(f"remainder_of({a.text}, {b.text}, far)", a.fraction, b.bound), None
        a = self.wide(args[0])
        if op == "log":
            return Number(f"logarithm({a.text}, {a.fraction}, far)", 31, LOGARITHM), None
        if op == "abs":
            return Number(f"absolute({a.text})", a.fraction, a.bound), None
        return self._whole(op, a), None

    def _constants(self, args: Sequence[Node]) -> list[Number]:
        fraction = min([constant_word(one.value).fraction for one in args if one.value] or [0])
        fraction = max(fraction, 30 - max(math.frexp(one.value)[1] for one in args))
        return [self.at(one, fraction) for one in args]

    @staticmethod
    def _whole(op: str, a: Number) -> Number:
        """floor, rint"""
        if a.fraction <= 0:
            return a._replace(text=f"{a.text} * INT64_C(1)")
        if a.fraction > 61:
            return Number(f"{a.text} >> 63" if op == "floor" else "INT64_C(0)", 0, 1)
        text = f"{a.text} * INT64_C(1) >> {a.fraction}" if op == "floor" else f"nearest({a.text}, {a.fraction})"
        return Number(text, 0, (a.bound >> a.fraction) + 1)

    def _root(self, one: Node) -> None:
        a = self.wide(one.args[0])
        by = a.fraction % 2
        while a.bound << max(by, 0) >> max(-by, 0) >= LIMIT:
            by -= 2
        a = self.at(one.args[0], a.fraction + by)
        name, half = self._let(one, "reciprocal", f"root_of({a.text}, far)"), a.fraction // 2
        self.others[id(one)] = name, half
        if "word" in self.needs[id(one)]:
            fraction = self.fraction_of(one)
            text = f"placed({name}.root, {name}.half{_plus(half - fraction - 1)}, far)"
            self.words[id(one)] = Number(self._let(one, "int32_t", text), fraction, WORD)

    def _inverse(self, one: Node) -> None:
        of = one.args[0]
        if of.op == "sqrt":
            root, fraction = self.others[id(of)]
            name = self._let(one, "inverted", f"over_root({root})")
        else:
            a = self.wide(of)
            name, fraction = self._let(one, "inverted", f"one_over({a.text}, far)"), a.fraction
        self.others[id(one)] = name, fraction
        if "word" in self.needs[id(one)]:
            to = self.fraction_of(one)
            text = f"placed({name}.over, {name}.by{_plus(-fraction - to)}, far)"
            self.words[id(one)] = Number(self._let(one, "int32_t", text), to, WORD)

    def _function(self, one: Node) -> Number:
        op, quotient = one.op, divided(one)
        if quotient:
            a, (name, fraction), to = self.word(quotient[0]), self.others[id(quotient[1])], self.fraction_of(one)
            text = f"placed(product({a.text}, {name}.over), {name}.by{_plus(a.fraction - fraction - to)}, far)"
            return Number(self._let(one, "int32_t", text), to, WORD)
        if op == "atan2":
            y, x = self.together(one.args, max)
            return Number(self._let(one, "int32_t", f"angle({y.text}, {x.text})"), 29, HALF)
        if op == "exp":
            to = self.fraction_of(one)
            return Number(self._let(one, "int32_t", f"exponential({self._doublings(one.args[0])}, {to}, far)"), to, WORD)
        turned = "" if op == "sin" else f" + UINT32_C({1 << 30})"
        return Number(self._let(one, "int32_t", f"sine({self._phase(one)}{turned})"), 30, WORD)

    def _times(self, one: Node, by: Number) -> Number:
        """A constant times a word, or times a wide number, which is made as fine as it may be before"""
        a = self.wide(one)
        if not self._is_wide(one):
            return Number(f"product({a.text}, {by.text})", a.fraction + by.fraction, a.bound * by.bound)
        a = self.at(one, a.fraction + min(31, (LIMIT // max(a.bound, 1)).bit_length() - 1))
        return Number(f"wide({by.text}, {a.text})", a.fraction + by.fraction - 32, (a.bound * by.bound >> 32) + 1)

    def _phase(self, one: Node) -> str:
        guard, of = self.guards[id(one)], one.args[0]
        for k in range(len(guard) + 1):
            if (id(of), guard[:k]) in self.phases:
                return self.phases[id(of), guard[:k]]
        turns = self._times(of, constant_word(TURN, 31, whole=True))
        by = turns.fraction - 32
        text = f"phase({turns.text}, {min(by, 62)})" if by > 0 else f"large_phase({turns.text}, {min(-by, 63)})"
        self.phases[id(of), guard] = name = self._let(one, "uint32_t", text)
        return name

    def _doublings(self, of: Node) -> str:
        """Wide, the logarithm to the base 2 at the fraction 32"""
        text, fraction, bound = self._times(of, constant_word(LOG2_E, 31, whole=True))
        by = fraction - 32
        if by > 0:
            return f"{text} >> {by}" if by < 63 else "INT64_C(0)"
        if bound << -by > LIMIT:
            text = f"within({text}, INT64_C({NARROWEST << max(fraction, 0)}))"
        return f"{text} * INT64_C({1 << -by})"

    # ---- what comes out

    def out(self, one: Node, fraction: int, is_kept: bool = False) -> str:
        """32 bits at a fraction; beyond them what the library refuses, or where it is kept, no value"""
        if one.is_constant:
            return str(max(-2**31 + 1, min(2**31 - 1, round(math.ldexp(one.value, fraction)))))
        text, from_, bound = self.wide(one)
        by = from_ - fraction
        if by > 62:
            return "0"
        if by < 0 and bound << -by > LIMIT:
            text, bound = f"within({text}, INT64_C({LIMIT >> -by}))", LIMIT >> -by
        text, bound = (f"rounded({text}, {by})", (bound >> by) + 1) if by > 0 else (f"{text} * INT64_C({1 << -by})", bound << -by)
        return f"narrowed({text})" if bound < 2**31 else f"kept({text}, far)" if is_kept else f"known({text})"

    def out_scaled(self, one: Node, exponent: int) -> str:
        """Times 2^exponent"""
        text, fraction, _ = self.wide(one)
        return f"scaled({text}, {exponent - fraction})"

    def c(self, outputs: Sequence[str]) -> list[str]:
        return c_of(self.order, outputs)

    def python(self, outputs: Sequence[str]) -> Callable[..., list[Any]]:
        """(far, numbers by name) -> outputs"""
        return python_of(self.order, list(self.inputs), outputs)

    def lacks(self, rows: Iterable[Mapping[str, int]]) -> dict[int, int]:
        """Bits that formulas' words have too few for, by id: what cancels in double leaves what words are rounded by"""
        run, far = python_of(self.order, list(self.inputs), [], True), Far()
        for row in rows:
            run(far, **row)
        of = {number.text: id_ for id_, number in self.words.items()}
        return {of[line]: bits for line, bits in far.lacks.items() if line in of}


def formulas_for(roots: Sequence[Node], inputs: Mapping[str, Input], most: Mapping[int, float],
                 rows: Sequence[Mapping[str, int]]) -> FixedFormulas:
    """With formats in which no word of these rows is beyond its end"""
    most = dict(most)
    for _ in range(ROUNDS):
        made = FixedFormulas(roots, inputs, most)
        lacks = made.lacks(rows)
        if not lacks:
            break
        for id_, bits in lacks.items():
            most[id_] = math.ldexp(1.0, WORD_BITS - made.fraction_at(id_) + bits)
    return made


def _plus(number: int) -> str:
    return f" {'-' if number < 0 else '+'} {abs(number)}" if number else ""
