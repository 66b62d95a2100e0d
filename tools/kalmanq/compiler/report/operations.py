"""What the C of a filter is made of: how many operations of which kind, and how often a value has no register.

An instruction's price depends on more than its operator: a product of constants is shifts, a sum with a product is one
instruction where the core multiplies and accumulates, a product of 64 bits costs nothing more in such a sum.  So each
expression is read as a tree, with the width of its words.
"""

from __future__ import annotations

import ast
import re
from collections import Counter
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any, Iterator, Mapping, Optional, Sequence

from kalmanq.firmware.costs import Factors, table

LINE = re.compile(r"^\s*(?:(?:const )?(float|u?int32_t|u?int64_t|reciprocal) (\w+)|f->(\w+(?:\[\d+\])?)|(\w+)) (\+?)= (.*);$")
FAR = re.compile(r"^\s*(?:uint32_t )?far \|?= ")
CHECK = re.compile(r"^\s*if \(\(\(.* >> \d+\)", re.M)  # of a word's range
COUNTERS = re.compile(r"\bf->(?:rows|missed|calls|gap|events|rejected)\b")
REGISTERS = (5, 8, 12, 16, 26, 30)  # of cores, less what addresses take
KINDS = (
    "calls", "functions", "loads", "wide_loads", "stores", "wide_stores", "constant_stores", "samples", "doors",
    "literals", "new_literals", "sums", "negations", "products", "fused", "divisions", "roots", "shifts",
    "constant_products", "powers", "accumulated", "wide_sums", "roundings", "wide",
    "high_shifts", "wide_shifts", "has_product", "has_wide", "has_inverse", "selects", "controls",
    "components", "settles", "tables", "parts", "shifted", "fractions", "words", "narrowed", "stopped", "checks", "far",
    "checked",
    *(f"spills{k}" for k in REGISTERS))
ARGUMENTS = {"f", "z", "u"}  # which point to words
CALLED = {"part": "parts", "half_part": "parts", "twice_part": "parts", "shifted": "shifted", "fraction": "fractions",
          "ratio": "fractions", "word": "words", "inverse_root": "roots", "narrow": "narrowed"}  # of the factor
WIDE = ("shifted",)  # of those, what makes 64 bits
SMALL = 256  # constants below are part of an instruction


def counted(body: str, is_fixed: bool) -> Counter[str]:
    """Of a function's body, each line of it once"""
    counting = Counting(is_fixed)
    for line in body.splitlines():
        found = LINE.match(re.sub(r"/\*.*?\*/", "", line).rstrip())
        if FAR.match(line):
            counting.made["far"] += 1
        elif found and "= stopped(" in line:
            counting.made["stopped"] += 1
        elif found and not COUNTERS.search(line):
            *places, adds, text = found.groups()
            counting.line(*places, f"{places[-1]} + {text}" if adds else text)
    made, checks = counting.made, CHECK.findall(body)
    made.update(checks=len(checks), checked="".join(checks).count("product("))
    made["doors"] = len(re.findall(r"z\[\d+\] (?:[<>]=? |\+ \d+u <= )", body))
    made.update({f"spills{registers}": counting.spills(registers) for registers in REGISTERS})
    return made


def table_of(made: Counter[str]) -> dict[str, int]:
    return {kind: int(made[kind]) if kind != "calls" else 1 for kind in KINDS}


@lru_cache(maxsize=None)
def factors() -> Mapping[tuple[str, str, str, str], Factors]:
    """By core, arithmetic, level and measure"""
    return {(row["core"], row["arithmetic"], row["level"], row["measure"]):
            Factors({kind: float(row[kind]) for kind in KINDS if row.get(kind)}, float(row["off"]))
            for row in table("costs.csv", __package__)}


def sums(core: str, arithmetic: str, measures: Sequence[str], made: Mapping[str, Mapping[str, int]]) -> dict[str, Any]:
    """At -O2: by measure what such operations cost, None where it has no factors; `off`: how far off that was at most, a share"""
    by = {measure: factors().get((core, arithmetic, "O2", measure)) for measure in measures}
    of = {measure: round(factor.sum(made[measure])) if factor and measure in made else None for measure, factor in by.items()}
    return {**of, "off": {measure: factor.off for measure, factor in by.items() if factor}}


def _tree(text: str) -> ast.expr:
    """C's expressions are Python's but for casts, f's fields and the ends of numbers"""
    text = re.sub(r"\b(\d+(?:\.\d+)?(?:e[+-]?\d+)?)f\b", r"\1", text)
    text = re.sub(r"f->(\w+)\[(\d+)\]", r"f_\1_\2", text.replace("(int32_t)(", "cast("))
    text = re.sub(r"\((?:u?int(?:32|64)_t|float)\)", "", text).replace("INT64_C(1) << ", "1 << ")
    text = re.sub(r"\br(\d+)\.(\w+)", r"r\1_\2", text).replace("f->", "f_").strip()
    return ast.parse(_selects(text), mode="eval").body


def _selects(text: str) -> str:
    """a ? b : c as select(a, b, c), the last one first"""
    while "?" in text:
        at = text.rindex("?")
        begin, end = _end(text, at, -1, "?:,"), _end(text, at, 1, ",")
        colon = _end(text, at + 1, 1, ":")
        text = f"{text[:begin + 1]}select({text[begin + 1:at]}, {text[at + 1:colon]}, {text[colon + 1:end]}){text[end:]}"
    return text


def _end(text: str, at: int, step: int, marks: str) -> int:
    """Where the brackets around this place end, or one of the marks is, on one side of it"""
    deep, at = 0, at + step
    while 0 <= at < len(text):
        letter = text[at]
        deep += step * ((letter == "(") - (letter == ")"))
        if deep < 0 or not deep and letter in marks:
            return at
        at += step
    return at


@dataclass
class Counting:
    """Line after line of a function.  lines: the name of each and the names that it reads; wide: names of 64 bits; now:
    of a name that is written again or is another's copy, the value that it is"""

    is_fixed: bool
    made: Counter[str] = field(default_factory=Counter)
    wide: set[str] = field(default_factory=set)
    loaded: set[str] = field(default_factory=set)
    constants: set[float] = field(default_factory=set)
    lines: list[tuple[Optional[str], list[str]]] = field(default_factory=list)
    now: dict[str, str] = field(default_factory=dict)

    def line(self, type_: Optional[str], name: Optional[str], stored: Optional[str], again: Optional[str],
             text: str) -> None:
        tree, of_64 = _tree(text), type_ in ("int64_t", "uint64_t")
        for one in ast.walk(tree):
            if isinstance(one, ast.Name):
                one.id = self.now.get(one.id, one.id)
        if isinstance(tree, ast.Name) and not tree.id.startswith("f_") and (again or (name or "").startswith("new_")):
            self.now[again or name or ""] = tree.id
            return
        if again:
            name = self.now[again] = f"{again}_{len(self.lines)}"
            of_64 = again in self.wide
        if name and of_64:
            self.wide.add(name)
        if name and isinstance(tree, ast.Name) and tree.id.startswith("f_"):
            self.made["wide_loads" if of_64 else "loads"] += 1
            self.loaded.add(name)
            return
        is_wide = self._value(tree)
        if not name:
            constant = isinstance(tree, ast.Constant)
            self.made["constant_stores" if constant else "wide_stores" if is_wide else "stores"] += 1
        self.lines.append((name, list(dict.fromkeys(self._reads(tree)))))

    def _reads(self, tree: ast.expr) -> Iterator[str]:
        """Names, and constants by their digits: both want registers"""
        called = {one.func.id for one in ast.walk(tree) if isinstance(one, ast.Call)}  # type: ignore[attr-defined]
        for one in ast.walk(tree):
            if isinstance(one, ast.Name):
                if one.id not in called | ARGUMENTS:
                    yield one.id
            elif isinstance(one, ast.Constant) and self._is_loaded(one.value):
                self.loaded.add(repr(one.value))
                yield repr(one.value)

    # ---- expressions: each is counted, and is of 64 bits or not

    def _value(self, tree: ast.expr) -> bool:
        if isinstance(tree, ast.Constant):
            self._literal(tree.value)
            return False
        if isinstance(tree, ast.Name):
            return tree.id in self.wide
        if isinstance(tree, ast.Subscript):
            self.made["samples"] += 1
            return False
        if isinstance(tree, ast.UnaryOp):
            self.made["negations"] += 1
            return self._value(tree.operand)
        if isinstance(tree, ast.Call):
            return self._call(tree)
        if isinstance(tree, ast.Compare):
            self._value(tree.left)
            return self._value(tree.comparators[0])
        assert isinstance(tree, ast.BinOp)
        if isinstance(tree.op, ast.LShift):
            return True
        if isinstance(tree.op, ast.RShift):
            return self._shift(tree)
        return self._fixed(tree) if self.is_fixed else self._floating(tree)

    def _literal(self, value: float) -> None:
        if not self._is_loaded(value):
            return
        self.made["literals"] += 1
        self.made["new_literals"] += value not in self.constants
        self.constants.add(value)

    def _is_loaded(self, value: float) -> bool:
        return not self.is_fixed or abs(value) >= SMALL

    def _call(self, tree: ast.Call) -> bool:
        called, (first, *rest) = tree.func.id, tree.args  # type: ignore[attr-defined]
        if called == "select":
            self.made["selects"] += 1
            self._value(first)
            return any([self._value(one) for one in rest])
        if called == "control":
            self.made["controls"] += 1
            return False
        if called in CALLED:
            self.made[CALLED[called]] += 1
            self._value(first)
            return called in WIDE
        if called in ("cast", "sqrtf"):
            self.made["roots"] += called == "sqrtf"
            self._value(first)
            return False
        if called == "inverse":
            self.made["divisions"] += 1
            return False
        if called == "product":
            self._product(next((one for one in tree.args if isinstance(one, ast.Constant)), first))
        else:  # wide, INT64_C
            self.made["wide"] += called == "wide"
            self._value(first)
        return True

    def _product(self, first: ast.expr) -> None:
        factor = first.operand if isinstance(first, ast.UnaryOp) else first
        if not isinstance(factor, ast.Constant):
            self.made["products"] += 1
        elif factor.value & (factor.value - 1) == 0:
            self.made["powers"] += 1
        else:
            self.made["constant_products"] += 1
            self._literal(factor.value)

    def _shift(self, tree: ast.BinOp) -> bool:
        by = tree.right.value if isinstance(tree.right, ast.Constant) else 0
        if not self._value(tree.left):
            self.made["shifts"] += 1
            return False
        if by != 32:  # of a pair of registers one is taken
            self.made["high_shifts" if by > 32 else "wide_shifts"] += 1
        return True

    def _fixed(self, tree: ast.BinOp) -> bool:
        left, right = self._value(tree.left), self._value(tree.right)
        is_wide, sides = left or right, (tree.left, tree.right)
        if isinstance(tree.op, ast.Mult):  # by a power of two
            self.made["wide_shifts"] += 1
        elif not is_wide:
            self.made["sums"] += 1
        elif any(map(_is_constant, sides)):
            self.made["roundings"] += 1
        else:
            self.made["accumulated" if any(map(_is_product, sides)) else "wide_sums"] += 1
        return is_wide

    def _floating(self, tree: ast.BinOp) -> bool:
        for side in (tree.left, tree.right):
            if not (isinstance(tree.op, ast.Div) and side is tree.left):  # 1 / x is one
                self._value(side)
        if isinstance(tree.op, (ast.Div, ast.Mult)):
            self.made["divisions" if isinstance(tree.op, ast.Div) else "products"] += 1
        elif any(isinstance(side, ast.BinOp) and isinstance(side.op, ast.Mult) for side in (tree.left, tree.right)):
            self.made["fused"] += 1
            self.made["products"] -= 1
        else:
            self.made["sums"] += 1
        return False

    # ---- registers

    def spills(self, registers: int) -> int:
        """Words that are stored and loaded again, where what is needed last gives way (Belady)"""
        uses: dict[str, list[int]] = {}
        for place, (_, reads) in enumerate(self.lines):
            for name in reads:
                uses.setdefault(name, []).append(place)
        held: set[str] = set()
        kept = set(self.loaded)  # in memory already
        begun: set[str] = set()
        count = 0
        for place, (made, reads) in enumerate(self.lines):
            for name in (name for name in reads if name in uses):
                if name not in held and name in begun:
                    count += self._words(name)
                begun.add(name)
                uses[name] = [use for use in uses[name] if use > place]
                held.add(name)
            held = {name for name in held if uses[name]}
            if made in uses:
                held.add(made)  # type: ignore[arg-type]
                begun.add(made)  # type: ignore[arg-type]
            while sum(map(self._words, held)) > registers:
                last = max(held, key=lambda name: (uses[name][0], name))
                held.remove(last)
                count += 0 if last in kept else self._words(last)
                kept.add(last)
        return count

    def _words(self, name: str) -> int:
        return 2 if name in self.wide else 1


def _is_constant(tree: ast.expr) -> bool:
    return isinstance(tree, ast.Constant) or isinstance(tree, ast.Call) and \
        tree.func.id in ("INT64_C", "UINT64_C") or \
        isinstance(tree, ast.BinOp) and isinstance(tree.op, ast.LShift)  # type: ignore[attr-defined]


def _is_product(tree: ast.expr) -> bool:
    return isinstance(tree, ast.Call) and tree.func.id in ("product", "wide")  # type: ignore[attr-defined]
