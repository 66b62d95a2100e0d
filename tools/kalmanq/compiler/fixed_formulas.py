"""Formulas in fixed point: each gets a binary point from the values that it had in records, and a line of C and of Python.

    word     31 bits, value = word 2^-fraction, for products and arguments
    wide     64 bits: products and sums of them, exact but for bits far below; their bounds are constants, so none overflows
    inverted 1 / value, a number and the power of two of its own, for quotients

A word is held at its end, which `far` tells.  A formula that only one branch of a condition needs is worked out in that branch.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, Callable, Iterable, Mapping, NamedTuple, Optional, Sequence

import numpy as np

from kalmanq.compiler.fixed_functions import HALF, HALF_WORD, LOG2_E, PYTHON, TURN
from kalmanq.compiler.printing import indented
from kalmanq.formulas.calculus import Memo, remade
from kalmanq.formulas.graph import CONDITIONS, Node, add, call, compare, inverse, mul, needed, select, sub
from kalmanq.formulas.program import Program

MARGIN = 2  # bits of a word that no record has used
LIMIT = 1 << 62  # of wide numbers
WORD_BITS, FINEST = 30, 90
LOGARITHM = 1 << 39  # bound of logarithms, 2^-31
NARROWEST = 1 << 10  # beyond it an exponential is 0, or out of all formats
Guard = tuple[tuple[int, bool], ...]  # conditions, by id, and their answers


class Number(NamedTuple):
    """text: of a word or a wide number with |text| <= bound, in C and in Python"""

    text: str
    fraction: int
    bound: int


@dataclass(frozen=True)
class Input:
    fraction: int
    bound: int = 1 << 31


@dataclass(frozen=True)
class Line:
    guard: Guard
    type: str
    name: str
    text: str
    python: str


# ------------------------------------------------------------------------------ what is made of other functions


def _power(a: Node, b: Node) -> Node:
    return select(compare("eq", a, 0.0), 0.0, call("exp", mul(b, call("log", a))))


def _cube_root(a: Node) -> Node:
    size = _power(call("abs", a), constant_third())
    return select(compare("lt", a, 0.0), sub(0.0, size), size)


def constant_third() -> Node:
    return mul(1.0, 1 / 3)


def _rest(a: Node) -> Node:
    """sqrt(1 - a a)"""
    return call("sqrt", sub(1.0, mul(a, a)))


MADE: dict[str, Callable[..., Node]] = {
    "tan": lambda a: mul(call("sin", a), inverse(call("cos", a))), "atan": lambda a: call("atan2", a, 1.0),
    "asin": lambda a: call("atan2", a, _rest(a)), "acos": lambda a: call("atan2", _rest(a), a), "pow": _power,
    "sinh": lambda a: mul(0.5, sub(call("exp", a), call("exp", sub(0.0, a)))),
    "cosh": lambda a: mul(0.5, add(call("exp", a), call("exp", sub(0.0, a)))),
    "tanh": lambda a: sub(1.0, mul(2.0, inverse(add(call("exp", mul(2.0, a)), 1.0)))),
    "log1p": lambda a: call("log", add(1.0, a)), "expm1": lambda a: sub(call("exp", a), 1.0), "cbrt": _cube_root,
    "asinh": lambda a: call("log", add(a, call("sqrt", add(mul(a, a), 1.0)))),
    "acosh": lambda a: call("log", add(a, call("sqrt", sub(mul(a, a), 1.0)))),
    "atanh": lambda a: mul(0.5, call("log", mul(add(1.0, a), inverse(sub(1.0, a)))))}


def lowered(roots: Sequence[Node]) -> list[Node]:
    """Of functions that fixed_functions.py has"""
    memo: Memo = {}
    for one in needed(roots)[0]:
        args = [memo[id(a)] for a in one.args] if one.op not in ("constant", "symbol") else []
        memo[id(one)] = one if not args else MADE[one.op](*args) if one.op in MADE else _one_quotient(remade(one.op, args))
    return [memo[id(one)] for one in roots]


def _one_quotient(one: Node) -> Node:
    """1 / a 1 / b is 1 / (a b): a word of 1 / a is coarse where a is large"""
    if one.op == "mul" and all(a.op == "inverse" for a in one.args):
        return inverse(mul(one.args[0].args[0], one.args[1].args[0]))
    return one


# ------------------------------------------------------------------------------ values in records


def guards(roots: Sequence[Node]) -> dict[int, Guard]:
    """The answers that a formula is needed with"""
    made: dict[int, Guard] = {id(one): () for one in roots}

    def needs(one: Node, guard: Guard) -> None:
        before = made.get(id(one))
        if before is not None:
            same = [a == b for a, b in zip(before, guard)]
            guard = before[:(same + [False]).index(False)]
        made[id(one)] = guard

    for one in reversed(needed(roots)[0]):
        guard = made[id(one)]
        for k, a in enumerate(one.args if one.op not in ("constant", "symbol") else ()):
            needs(a, guard if one.op != "select" or not k else (*guard, (id(one.args[0]), k == 1)))
    return made


def largest(roots: Sequence[Node], given: Mapping[str, np.ndarray]) -> dict[int, float]:
    """Of |values| by id, where the formula is needed; 0: never, or always 0"""
    program, guard = Program(roots), guards(roots)
    values = dict(zip(map(id, program.order), program.every(given, np.asarray)))
    made = {}
    for one in program.order:
        value = np.abs(np.asarray(values[id(one)], float))
        for condition, answer in guard[id(one)]:
            value = np.where(np.asarray(values[condition], bool) == answer, value, 0.0)
        made[id(one)] = float(np.max(np.where(np.isfinite(value), value, 0.0), initial=0.0))
    return made


def fraction_for(most: float, bits: int = WORD_BITS - MARGIN) -> int:
    """The most fraction bits with which so many bits hold it"""
    return min(bits - math.frexp(most)[1], FINEST) if most > 0 else bits


def constant_word(value: float, bits: int = 31, whole: bool = False) -> Number:
    """A number of so many bits, without zeros at its end unless `whole`"""
    if value == 0:
        return Number("0", 0, 0)
    fraction = bits - math.frexp(abs(value))[1]
    word = round(math.ldexp(value, fraction))
    if abs(word) >> bits:
        word, fraction = word // 2, fraction - 1
    while word % 2 == 0 and not whole:
        word, fraction = word // 2, fraction - 1
    return Number(str(word), fraction, abs(word))


# ------------------------------------------------------------------------------ lines


@dataclass
class FixedFormulas:
    """roots: lowered; inputs: of symbols; most: largest values by id"""

    roots: Sequence[Node]
    inputs: Mapping[str, Input]
    most: Mapping[int, float]
    lines: list[Line] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.guards = guards(self.roots)
        self.order = needed(self.roots)[0]
        self.needs: dict[int, set[str]] = {id(one): set() for one in self.order}
        self.words: dict[int, Number] = {}
        self.wides: dict[int, Number] = {}
        self.others: dict[int, tuple[str, int]] = {}  # roots, inverses: names and fractions
        self.bits: dict[int, str] = {}
        self.phases: dict[tuple[int, Guard], str] = {}
        for one in self.roots:
            self._need(one, "any")
        for one in reversed(self.order):
            self._ask(one)
        for one in self.order:
            if one.op in CONDITIONS:
                self._condition(one)
            elif one.op not in ("constant", "symbol") and _doubled(one) is None:
                self._make(one)

    # ---- what of an argument is needed

    def _kind(self, one: Node) -> str:
        doubled = _doubled(one)
        if doubled:
            return self._kind(doubled[1])
        if one.op in CONDITIONS:
            return "bit"
        is_word = one.op in ("constant", "symbol", "sin", "cos", "exp", "sqrt", "atan2", "inverse") or _divided(one) is not None
        return "word" if is_word else "wide"

    def _need(self, one: Node, what: str) -> None:
        kind = self._kind(one)
        self.needs[id(one)].add(kind if what == "any" or what == "wide" and kind == "word" else what)

    def _ask(self, one: Node) -> None:
        args, op = one.args, one.op
        if op in ("constant", "symbol"):
            return
        doubled, divided = _doubled(one), _divided(one)
        if doubled:
            for what in self.needs[id(one)]:
                self._need(doubled[1], what)
        elif divided:
            self._need(divided[0], "word")
            self._need(divided[1], "inverted")
        elif op == "inverse" and args[0].op == "sqrt":
            self._need(args[0], "root")
        else:
            what = "any" if _weighed(one) else "word" if op == "mul" else "any" if op in ("inverse", "sqrt", "sin", "cos", "exp", "log", "not", "and", "or") else "wide"
            for k, a in enumerate(args):
                self._need(a, "bit" if op == "select" and not k else what)

    # ---- numbers in a form

    def word(self, one: Node) -> Number:
        doubled = _doubled(one)
        if doubled:
            made = self.word(doubled[1])
            return made._replace(fraction=made.fraction - doubled[0])
        if one.op == "constant":
            return constant_word(one.value)
        if one.op == "symbol":
            return Number(one.args[0], self.inputs[one.args[0]].fraction, self.inputs[one.args[0]].bound)
        return self.words[id(one)]

    def wide(self, one: Node) -> Number:
        """Or a word"""
        doubled = _doubled(one)
        if doubled:
            made = self.wide(doubled[1])
            return made._replace(fraction=made.fraction - doubled[0])
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
        doubled = _doubled(one)
        return self._is_wide(doubled[1]) if doubled else id(one) in self.wides

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

    # ---- lines

    def _let(self, one: Node, type_: str, text: str, python: Optional[str] = None) -> str:
        name = {"int64_t": "w", "int32_t": "v", "uint32_t": "p", "int": "c", "reciprocal": "r", "inverted": "i"}[type_] + str(len(self.lines))
        self.lines.append(Line(self.guards[id(one)], type_, name, text, python or text))
        return name

    def _condition(self, one: Node) -> None:
        if one.op in ("lt", "le", "eq"):
            a, b = self.together(one.args, max)
            text = f"{a.text} {({'lt': '<', 'le': '<=', 'eq': '=='})[one.op]} {b.text}"
            self.bits[id(one)] = self._let(one, "int", text)
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
        elif self._kind(one) == "word":
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
        fits = bound < HALF_WORD
        name = self._let(one, "int32_t", f"narrowed({text})" if fits else f"held({text}, far)")
        self.words[id(one)] = Number(name, fraction, min(bound, HALF_WORD))

    def _wide(self, one: Node) -> tuple[Number, Optional[str]]:
        """And Python where it is not C"""
        args, op = one.args, one.op
        if op == "mul" and _weighed(one) and self._is_wide(args[1]):
            return self._weighed(args[1], constant_word(args[0].value, 31, whole=True)), None
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
            self.words[id(one)] = Number(self._let(one, "int32_t", text), fraction, HALF_WORD)

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
            self.words[id(one)] = Number(self._let(one, "int32_t", text), to, HALF_WORD)

    def _function(self, one: Node) -> Number:
        op, divided = one.op, _divided(one)
        if divided:
            a, (name, fraction), to = self.word(divided[0]), self.others[id(divided[1])], self.fraction_of(one)
            text = f"placed(product({a.text}, {name}.over), {name}.by{_plus(a.fraction - fraction - to)}, far)"
            return Number(self._let(one, "int32_t", text), to, HALF_WORD)
        if op == "atan2":
            y, x = self.together(one.args, max)
            return Number(self._let(one, "int32_t", f"angle({y.text}, {x.text})"), 29, HALF)
        if op == "exp":
            to = self.fraction_of(one)
            return Number(self._let(one, "int32_t", f"exponential({self._doublings(one.args[0])}, {to}, far)"), to, HALF_WORD)
        phase = self._phase(one)
        return Number(self._let(one, "int32_t", f"sine({phase})" if op == "sin" else f"sine({phase} + UINT32_C({1 << 30}))"), 30, HALF_WORD)

    def _weighed(self, one: Node, by: Number) -> Number:
        """A constant times a wide number, which is made as fine as it may be before"""
        a = self.wide(one)
        a = self.at(one, a.fraction + min(31, (LIMIT // max(a.bound, 1)).bit_length() - 1))
        return Number(f"wide({by.text}, {a.text})", a.fraction + by.fraction - 32, (a.bound * by.bound >> 32) + 1)

    def _times(self, one: Node, by: tuple[int, int]) -> Number:
        """A constant times a word or a wide number, in 64 bits"""
        a = self.wide(one)
        if self._is_wide(one):
            return Number(f"wide({by[0]}, {a.text})", a.fraction + by[1] - 32, a.bound * by[0] >> 32)
        return Number(f"product({a.text}, {by[0]})", a.fraction + by[1], a.bound * by[0])

    def _phase(self, one: Node) -> str:
        guard, of = self.guards[id(one)], one.args[0]
        for k in range(len(guard) + 1):
            if (id(of), guard[:k]) in self.phases:
                return self.phases[id(of), guard[:k]]
        turns = self._times(of, TURN)
        by = turns.fraction - 32
        text = f"phase({turns.text}, {min(by, 62)})" if by > 0 else f"large_phase({turns.text}, {min(-by, 63)})"
        self.phases[id(of), guard] = name = self._let(one, "uint32_t", text)
        return name

    def _doublings(self, of: Node) -> str:
        """Wide, the logarithm to the base 2 at the fraction 32"""
        text, fraction, bound = self._times(of, LOG2_E)
        by = fraction - 32
        if by > 0:
            return f"{text} >> {by}" if by < 63 else "INT64_C(0)"
        if bound << -by > LIMIT:
            text = f"within({text}, INT64_C({NARROWEST << max(fraction, 0)}))"
        return f"{text} * INT64_C({1 << -by})"

    # ---- what comes out

    def out(self, one: Node, fraction: int) -> str:
        """32 bits at a fraction; what the library refuses where it is beyond them"""
        if one.is_constant:
            return str(max(-2**31 + 1, min(2**31 - 1, round(math.ldexp(one.value, fraction)))))
        text, from_, bound = self.wide(one)
        by = from_ - fraction
        if by > 62:
            return "0"
        if by < 0 and bound << -by > LIMIT:
            text, bound = f"within({text}, INT64_C({LIMIT >> -by}))", LIMIT >> -by
        text, bound = (f"rounded({text}, {by})", (bound >> by) + 1) if by > 0 else (f"{text} * INT64_C({1 << -by})", bound << -by)
        return f"known({text})" if bound >= 2**31 else f"narrowed({text})"

    def out_scaled(self, one: Node, exponent: int) -> str:
        """Times 2^exponent"""
        text, fraction, _ = self.wide(one)
        return f"scaled({text}, {exponent - fraction})"

    def c(self) -> list[str]:
        lines = [f"{one.type} {one.name} = {EMPTY.get(one.type, '0')};" for one in self.lines if one.guard]
        for guard, own in _runs(self.lines):
            if not guard:
                lines += [f"const {one.type} {one.name} = {one.text};" for one in own]
                continue
            condition = " && ".join(f"{'' if answer else '!'}{self.bits[of]}" for of, answer in guard)
            lines += [f"if ({condition}) {{", *indented(f"{one.name} = {one.text};" for one in own), "}"]
        return lines

    def python(self, outputs: Sequence[str]) -> Callable[..., list[Any]]:
        """(far, numbers by name) -> outputs.  A wide number beyond its bound is a bug"""
        lines = []
        for guard, own in _runs(self.lines):
            condition = " and ".join(f"{'' if answer else 'not '}{self.bits[of]}" for of, answer in guard)
            made = [f"{one.name} = {one.python}" for one in own]
            made = [line + f"; assert -{LIMIT << 1} <= {one.name} < {LIMIT << 1}" if one.type == "int64_t" else line for line, one in zip(made, own)]
            lines += [f"if {condition}:", *indented(made)] if guard else made
        names = ", ".join(["far", *self.inputs])
        text = "\n".join([f"def run({names}):", *indented([*lines, f"return [{', '.join(outputs)}]"])])
        made_: dict[str, Any] = dict(PYTHON)
        exec(text, made_)
        return made_["run"]


EMPTY = {"reciprocal": "{0, 0, 1}", "inverted": "{0, 0}"}


def _plus(number: int) -> str:
    return f" {'-' if number < 0 else '+'} {abs(number)}" if number else ""


def _runs(lines: Sequence[Line]) -> list[tuple[Guard, list[Line]]]:
    made: list[tuple[Guard, list[Line]]] = []
    for one in lines:
        if not made or made[-1][0] != one.guard:
            made.append((one.guard, []))
        made[-1][1].append(one)
    return made


def _doubled(one: Node) -> Optional[tuple[int, Node]]:
    """k and a, where it is 2^k a"""
    if one.op == "mul" and one.args[0].is_constant and not one.args[1].is_constant:
        half, k = math.frexp(one.args[0].value)
        return (k - 1, one.args[1]) if half == 0.5 else None
    return None


def _weighed(one: Node) -> bool:
    """Is it a constant times a formula?"""
    return one.op == "mul" and one.args[0].is_constant and one.args[0].value > 0


def _divided(one: Node) -> Optional[tuple[Node, Node]]:
    """b and 1 / c, where it is their product"""
    if one.op != "mul" or _doubled(one):
        return None
    for a, b in (one.args, one.args[::-1]):
        if b.op == "inverse":
            return a, b
    return None
