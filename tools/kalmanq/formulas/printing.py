"""C of formulas: a formula that is used more than once gets a name, in the order in which it is needed."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Iterable, Mapping, Optional, Protocol, Sequence

import numpy as np

from kalmanq.errors import KalmanqError
from kalmanq.formulas.choices import Choice, choices
from kalmanq.formulas.graph import CONDITIONS, FUNCTIONS, Node, needed

WORD = re.compile(r"\b[A-Za-z_]\w*\b")
Target = tuple[str, Node]  # what is assigned to, and its formula
DEEPEST = 100  # of operations in one expression: compilers limit brackets, and Python its stack
ATOM = 9  # rank of a name, a literal and a call: never in brackets


class Operations(Protocol):
    """How an arithmetic writes its operations"""

    def type_of(self, one: Node) -> str:
        """The C type of a formula's value"""

    def literal(self, one: Node) -> str:
        """A constant"""

    def text(self, one: Node, argument: Argument) -> tuple[str, int]:
        """The C text, and the rank of its outermost operator"""


class Argument(Protocol):
    def __call__(self, one: Node, rank: int = 0) -> str:
        """The text of an argument, in brackets where its rank is below"""


@dataclass
class Body:
    """The lines of a block.

    hints   what formulas are called, by id(node); others are t0, t1, ..., or `stem` and a number
    fields  of the filter, by the names of locals that are loaded where they are first needed; of a local that is there, itself
    uses    how often formulas are used that are asked for later, too; choices: the selects among them that become branches;
            hidden: what is inside those
    """

    operations: Operations
    hints: dict[int, str] = field(default_factory=dict)
    lines: list[str] = field(default_factory=list)
    count: int = 0  # operations
    known: dict[int, str] = field(default_factory=dict)
    used: dict[str, int] = field(default_factory=dict)
    named: int = 0
    stem: str = "t"
    fields: Mapping[str, str] = field(default_factory=dict)
    uses: Mapping[int, int] = field(default_factory=dict)
    choices: Mapping[int, Choice] = field(default_factory=dict)
    hidden: set[int] = field(default_factory=set)

    def store(self, targets: Sequence[Target]) -> list[str]:
        """Each target, a field or a local, is written as soon as its formula is there: few values are held at a time"""
        read = {self.fields[one.args[0]]: one for one in self.expect([one for _, one in targets])
                if one.op == "symbol" and one.args[0] in self.fields}
        for name, one in targets:
            if read.get(name) is one:
                continue
            self.name_shared([one, *([read[name]] if name in read else [])])
            self.lines.append(f"{name} = {self.text(one)};")
        return self.lines

    def expect(self, roots: Sequence[Node]) -> list[Node]:
        """All that these need, which the next calls ask for"""
        order, self.uses = needed(roots)
        self.choices = choices(order, roots)
        self.hidden = {id(one) for choice in self.choices.values() for side in choice.inside for one in side}
        return order

    def assign(self, targets: Sequence[Target], under: Optional[Node] = None, then: Sequence[str] = (),
               otherwise: Sequence[str] = ()) -> list[str]:
        """All formulas are worked out before the first target is written.  under: a condition of the writes and of
        `then`"""
        targets = [(name, one) for name, one in targets if not (one.op == "symbol" and one.args[0] == name)]
        self.name_shared([one for _, one in targets] + ([] if under is None else [under]))
        written = [(name, self.text(one)) for name, one in targets]
        if _clash(written):
            types = [self.operations.type_of(one) for _, one in targets]
            self.lines += [f"const {type_} new_{_plain(name)} = {text};" for type_, (name, text) in zip(types, written)]
            written = [(name, f"new_{_plain(name)}") for name, _ in written]
        writes = [f"{name} = {text};" for name, text in written]
        if under is not None:
            rest = ["} else {", *indented(otherwise)] if otherwise else []
            writes = [f"if ({self.text(under)}) {{", *indented([*writes, *then]), *rest, "}"]
        self.lines += writes
        return self.lines

    def name_shared(self, roots: Sequence[Node]) -> None:
        order, uses = needed(roots)
        depth: dict[int, int] = {}  # of what is written in one expression
        for one in order:
            depth[id(one)] = 0
            if one.op == "symbol" and one.args[0] in self.fields and id(one) not in self.known:
                self._load(one)
            if one.op in ("constant", "symbol") or id(one) in self.known or id(one) in self.hidden:
                continue
            if id(one) in self.choices:
                self._branch(self.choices[id(one)])
                continue
            depth[id(one)] = 1 + max(depth[id(a)] for a in one.args)
            if max(uses[id(one)], self.uses.get(id(one), 0)) > 1 or id(one) in self.hints or depth[id(one)] > DEEPEST:
                self._name(one)
                depth[id(one)] = 0

    def _branch(self, choice: Choice) -> None:
        """Names its selects"""
        self.name_shared([choice.condition, *choice.outside()])
        names = [f"{self.stem}{self.named + k}" for k in range(len(choice.selects))]
        self.named += len(names)
        start, hidden, sides = len(self.lines), self.hidden, []
        for side, inside in enumerate(choice.inside, 1):
            self.hidden = hidden - {id(one) for one in inside}
            values = [one.args[side] for one in choice.selects]
            self.name_shared(values)
            sides.append(indented([*self.lines[start:], *(f"{name} = {self.text(one)};" for name, one in zip(names, values))]))
            del self.lines[start:]
        self.hidden = hidden
        self.known.update((id(one), name) for one, name in zip(choice.selects, names))
        self.lines += [f"{self.operations.type_of(choice.selects[0])} {', '.join(names)};",
                       f"if ({self.text(choice.condition)}) {{", *sides[0], "} else {", *sides[1], "}"]

    def _load(self, one: Node) -> None:
        local = one.args[0]
        name = self.known[id(one)] = local if self.fields[local] != local else f"was_{local}"
        self.lines.append(f"const {self.operations.type_of(one)} {name} = {self.fields[local]};")

    def _name(self, one: Node) -> None:
        text, hint = self.text(one), self.hints.get(id(one))
        name = self._fresh(hint) if hint else f"{self.stem}{self.named}"
        self.named += 1
        self.lines.append(f"const {self.operations.type_of(one)} {name} = {text};")
        self.known[id(one)] = name

    def _fresh(self, hint: str) -> str:
        count = self.used[hint] = self.used.get(hint, 0) + 1
        return hint if count == 1 else f"{hint}_{count}"

    def text(self, one: Node, rank: int = 0) -> str:
        if id(one) in self.known:
            return self.known[id(one)]
        if one.op == "constant":
            text = self.operations.literal(one)
            return f"({text})" if text[0] == "-" and rank else text
        if one.op == "symbol":
            return one.args[0]
        self.count += 1
        text, mine = self.operations.text(one, self.text)
        return f"({text})" if mine < rank else text


def indented(lines: Iterable[str], by: str = "    ") -> list[str]:
    return [f"{by}{line}" if line else line for line in lines]


def _clash(written: Sequence[tuple[str, str]]) -> bool:
    """Does a formula read what another one writes?"""
    return any(set(WORD.findall(text)) & {WORD.findall(other)[-1] for other, _ in written if other != name}
               for name, text in written)


def _plain(name: str) -> str:
    return re.sub(r"\W+", "_", name.removeprefix("f->")).strip("_")


@dataclass(frozen=True)
class Floats:
    """float or double, in C's own operators"""

    type: str

    RANKS = {"select": 0, "or": 1, "and": 2, "eq": 3, "lt": 3, "le": 3, "add": 4, "sub": 4, "mul": 5, "inverse": 5, "not": 6}
    SIGNS = {"add": "+", "sub": "-", "mul": "*", "eq": "==", "lt": "<", "le": "<=", "or": "||", "and": "&&"}

    def type_of(self, one: Node) -> str:
        return "int" if one.op in CONDITIONS else self.type

    def literal(self, one: Node) -> str:
        return self.number(one.value)

    def number(self, value: float) -> str:
        """With the fewest digits that give the same number"""
        if not abs(value) <= np.finfo(np.float32 if self.type == "float" else np.float64).max:
            raise KalmanqError(f"{value:.3g} follows from numbers of the model, and a {self.type} cannot hold it: "
                               f"use other units{', or --arith f64' if self.type == 'float' else ''}")
        if self.type == "double":
            text = repr(float(value))
        else:
            single = np.float32(value)
            text = np.format_float_positional(single, unique=True, trim="0") if value == 0 or 1e-4 <= abs(float(single)) < 1e7 else \
                np.format_float_scientific(single, unique=True, trim="0", exp_digits=1)
        text = text if "." in text or "e" in text else f"{text}.0"
        return text if self.type == "double" else f"{text}f"

    def text(self, one: Node, argument: Argument) -> tuple[str, int]:
        args = one.args
        if one.op in FUNCTIONS:
            return f"{self.function(one.op)}({', '.join(argument(a) for a in args)})", ATOM
        rank = self.RANKS[one.op]
        if one.op == "select":
            return f"{argument(args[0], 1)} ? {argument(args[1], 1)} : {argument(args[2], 0)}", rank
        if one.op == "inverse":
            return f"{self.number(1)} / {argument(args[0], rank + 1)}", rank
        if one.op == "sub" and args[0].equals(0):
            return f"-{argument(args[1], 6)}", 4
        for number, divisor in (args, args[::-1]) if one.op == "mul" else ():
            text = argument(divisor, rank) if divisor.op == "inverse" else ""
            if text.startswith(f"{self.number(1)} / "):  # b * (1 / c) is one division
                return f"{argument(number, rank)} {text.removeprefix(self.number(1)).strip()}", rank
        if one.op == "not":
            return f"!{argument(args[0], rank + 1)}", rank
        right = rank if one.op in ("add", "and", "or") else rank + 1
        least = rank + 2 if one.op == "or" else 0  # compilers warn of a && b || c
        return f"{argument(args[0], max(rank, least))} {self.SIGNS[one.op]} {argument(args[1], max(right, least))}", rank

    def function(self, name: str) -> str:
        """Of math.h"""
        name = {"abs": "fabs"}.get(name, name)
        return f"{name}f" if self.type == "float" else name
