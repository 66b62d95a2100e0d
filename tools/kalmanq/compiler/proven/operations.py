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
from typing import Iterator, Optional

FUNCTION = re.compile(r"^(?:NEVER_INLINE )?(?:static )?void (\w+)\([^\n]*\)\n\{\n(.*?)^\}", re.S | re.M)
SETTLED = re.compile(r"^    if \(rows >= \d+\) \{ /\* settled \*/\n(.*?)\n    \}\n", re.S | re.M)
LINE = re.compile(r"^\s*(?:const (float|int32_t|int64_t) (\w+)|f->(\w+)) = (.*);$")
COUNTERS = re.compile(r"\bf->(?:rows|missed|gap_refused|sample_refused)\b")
REGISTERS = (5, 8, 12, 16, 26, 30)  # of cores, less what addresses take
KINDS = (
    "calls", "functions", "loads", "wide_loads", "stores", "wide_stores", "constant_stores", "samples", "doors",
    "stops", "literals", "new_literals", "sums", "negations", "products", "fused", "divisions", "roots", "shifts",
    "constant_products", "powers", "accumulated", "wide_sums", "roundings", "wide", "called_wide", "whole",
    "whole_wide", "highs", "high_shifts", "wide_shifts", "has_product", "has_wide", "has_inverse",
    *(f"spills{k}" for k in REGISTERS))
ROUTINES = ("product", "wide", "inverse")
ARGUMENTS = {"f", "z", "u"}  # which point to words
INLINED = 10  # calls of wide(): of more, gcc -Os makes a function
SMALL = 256  # constants below are part of an instruction


def operations(text: str, name: str, is_fixed: bool) -> dict[str, dict[str, int]]:
    """Of a row in two calls before it has settled, of a step after, of the whole file: how many of each kind"""
    functions = {called.removeprefix(f"{name}_"): body for called, body in FUNCTION.findall(text)}
    bodies = {called: SETTLED.sub("", body) for called, body in functions.items()}
    apart = [found.group(1) for found in map(SETTLED.search, functions.values()) if found]
    counted = {called: _count(body, is_fixed) for called, body in bodies.items()}
    whole = sum((_count(body, is_fixed) for body in apart), sum(counted.values(), Counter()))
    whole["functions"] = len(functions)
    whole.update({f"has_{routine}": bool(re.search(rf"\b{routine}\(", text)) for routine in ROUTINES})
    made = {"two_calls": counted.get("predict", Counter()) + counted.get("update", Counter()),
            "step_settled": counted["step"], "flash": whole}
    for one in made.values():
        one["called_wide"] = one["wide"] * (whole["wide"] > INLINED)
    return {measure: {kind: int(one[kind]) if kind != "calls" else 1 for kind in KINDS}
            for measure, one in made.items()}


def _count(body: str, is_fixed: bool) -> Counter[str]:
    counting = Counting(is_fixed)
    for line in body.splitlines():
        found = LINE.match(re.sub(r"/\*.*?\*/", "", line).rstrip())
        if found and not COUNTERS.search(line):
            counting.line(*found.groups())
    made = counting.made
    made["doors"] = len(re.findall(r"z\[\d+\] [<>]=? ", body))
    made.update({f"spills{registers}": counting.spills(registers) for registers in REGISTERS})
    return made


def _tree(text: str) -> ast.expr:
    """C's expressions are Python's but for casts, f's fields and the ends of numbers"""
    text = re.sub(r"\b(\d+(?:\.\d+)?(?:e[+-]?\d+)?)f\b", r"\1", text)
    text = text.replace("(int32_t)(", "narrow(")
    return ast.parse(re.sub(r"\((?:u?int32_t|float)\)", "", text).replace("f->", "f_").strip(), mode="eval").body


@dataclass
class Counting:
    """Line after line of a function.  lines: the name of each and the names that it reads; wide: names of 64 bits"""

    is_fixed: bool
    made: Counter[str] = field(default_factory=Counter)
    wide: set[str] = field(default_factory=set)
    loaded: set[str] = field(default_factory=set)
    constants: set[float] = field(default_factory=set)
    lines: list[tuple[Optional[str], list[str]]] = field(default_factory=list)

    def line(self, type_: Optional[str], name: Optional[str], stored: Optional[str], text: str) -> None:
        tree, of_64 = _tree(text), type_ == "int64_t"
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
        assert isinstance(tree, ast.BinOp)
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
        called, (first, *_) = tree.func.id, tree.args  # type: ignore[attr-defined]
        if called in ("narrow", "sqrtf"):
            self.made["roots"] += called == "sqrtf"
            self._value(first)
            return False
        if called == "inverse":
            self.made["divisions"] += 1
            return False
        if called in ("within", "number"):
            self.made["stops"] += 1
            self._value(tree.args[2])
            return self._value(tree.args[1])
        if called == "product":
            self._product(first)
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
        by = tree.right.value  # type: ignore[attr-defined]
        if not self._value(tree.left):
            self.made["shifts"] += 1
            return False
        self.made["highs" if by == 32 else "high_shifts" if by > 32 else "wide_shifts"] += 1
        return True

    def _fixed(self, tree: ast.BinOp) -> bool:
        left, right = self._value(tree.left), self._value(tree.right)
        is_wide, sides = left or right, (tree.left, tree.right)
        if isinstance(tree.op, ast.Mult):
            by = tree.left.value  # type: ignore[attr-defined]
            self.made["whole" if not is_wide else "whole_wide" if by & (by - 1) else "wide_shifts"] += 1
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
        tree.func.id == "INT64_C"  # type: ignore[attr-defined]


def _is_product(tree: ast.expr) -> bool:
    return isinstance(tree, ast.Call) and tree.func.id in ("product", "wide")  # type: ignore[attr-defined]
