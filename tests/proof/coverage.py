#!/usr/bin/env python3
"""coverage.py BUILD [--missed]: statements, branch sides and MC/DC of src/ by folder and arithmetic, as the unit tests reach them.

BUILD has the unit tests compiled by clang 19 (tools/proof.sh coverage).  Prints a table, as Markdown, and what is excluded;
what is neither reached nor excluded with --missed.  Fails if a goal is missed, or a row of excluded.txt excludes nothing.

What counts, once an arithmetic:
- a text that several instances compile is one.  A statement or a side is reached if it is in one of them.  A condition is
  shown by two test vectors of one text: so a mode, which is constant in an inlined instance, varies over its instances.
- a function that no instance calls is not compiled, and does not count.
- a condition that the compiler folds to a constant of the arithmetic does not count (in llvm-cov report neither), nor
  what it stops from ever being evaluated (`Constants`)."""

import re
import sys
from collections import Counter, defaultdict
from pathlib import Path

import llvm
from exclusions import Exclusions
from places import Constants, text_of

WHOLE = ("filter", "arithmetic", "model", "smoother")  # folders of which each condition is to be shown
LEAST = 0.97  # of all others, in each arithmetic
KINDS = ("statements", "sides", "conditions")


class Item:
    """A statement, the side of a branch or a condition that is to decide: where, in which function, and whether it is reached"""

    def __init__(self, kind, place, what, function):
        self.kind, self.place, self.what, self.function = kind, place, what, function
        self.is_reached, self.why = False, None

    @property
    def folder(self):
        return self.place[0].split("/")[0]

    def __str__(self):
        return " | ".join([self.place[0], f"{self.place[1]} {self.function}", text_of(self.place), self.what])


class Texts:
    """All that counts of an arithmetic, its instances together"""

    def __init__(self, functions):
        self.items, self.decisions, self.counts = {}, {}, Counter()
        self.constants, self.starts = set(), {}
        for function in functions:
            self._add(function)
        for place, (decision, function) in self.decisions.items():
            for k, at in enumerate(decision.conditions):
                if k not in decision.constants:
                    shown = decision.shown(k) if decision.vectors else self._is_shown_by_sides(place, decision, k)
                    self._reach("conditions", self.condition_place(place[0], at), "decides", function, shown)

    def condition_place(self, file, at):
        """The range of the condition that begins there: a branch has it"""
        return self.starts[file, *at]

    def _is_shown_by_sides(self, place, decision, k):
        """Of `a || b ? c : d` of a structure clang 19 keeps no vectors.  In a chain of one operator the sides say it: condition k
        has decided alone, and the last one has let the other result through."""
        operators = set(re.findall(r"&&|[|][|]", text_of(place)))
        own, last = (self.condition_place(place[0], decision.conditions[c]) for c in (k, -1))
        decides, leaves = ("true", "false") if operators == {"||"} else ("false", "true")
        return len(operators) == 1 and self.items["sides", own, decides].is_reached and self.items["sides", last, leaves].is_reached

    def _reach(self, kind, place, what, function, is_reached):
        item = self.items.setdefault((kind, place, what), Item(kind, place, what, function))
        item.is_reached |= bool(is_reached)

    def _add(self, function):
        name = function.name.split(":")[-1].removesuffix("_f32").removesuffix("_f64").removesuffix("_q31")
        for place, count in function.statements.items():
            self._reach("statements", place, "statement", name, count)
            self.counts[place] += count
        for (place, side), count in function.sides.items():
            self.starts[function.files[0], *place[-4:-2]] = place
            if place[1:3] in function.folded:
                self.constants.add(place)
            else:
                self._reach("sides", place, side, name, count)
        for place, decision in function.decisions.items():
            whole, _ = self.decisions.setdefault(place, (decision, name))
            whole.vectors |= decision.vectors
            whole.constants &= decision.constants
        for branches in function.unread_decisions():
            for place in branches:
                self._reach("conditions", place, "decides", name, False)

    def leave_out(self, is_dead):
        """What cannot run is no item; what has run is no such thing"""
        for key, item in list(self.items.items()):
            if is_dead(item.place):
                if item.is_reached and item.kind != "conditions":
                    sys.exit(f"coverage.py: called constant, and reached: {item}")
                del self.items[key]


def texts_of(build, arithmetic):
    made, unmade, totals = llvm.functions_of(build, arithmetic)
    texts = Texts(made)
    before = len(texts.items)
    texts.leave_out(Constants(texts).is_dead)
    own = {(f.files[0], *min(f.statements)[1:3]) for f in made if f.statements}
    uncalled = {min(f.statements) for f in unmade if f.statements} - {place for place in texts.counts}
    return texts, {"constants": before - len(texts.items), "uncalled": len({p[:3] for p in uncalled} - own), "totals": totals}


def figures(items):
    """{kind: (reached, all)} of what is not excluded"""
    count = defaultdict(lambda: [0, 0])
    for item in items:
        if not item.why:
            count[item.kind][0] += item.is_reached
            count[item.kind][1] += 1
    return {kind: tuple(count[kind]) for kind in KINDS}


def figure(reached, whole):
    return f"{reached}/{whole} {100 * reached / whole:.1f}" if whole else "-"


def table(texts):
    """Rows of Markdown: a folder, and its three kinds in each arithmetic"""
    folders = sorted({item.folder for of in texts.values() for item in of.items.values()})
    yield "| folder | | " + " | ".join(texts) + " |"
    yield "|---|---|" + "---:|" * len(texts)
    for folder in [*folders, "all"]:
        for kind in KINDS:
            of = (figures(i for i in t.items.values() if folder in (i.folder, "all"))[kind] for t in texts.values())
            yield f"| {folder} | {kind} | " + " | ".join(figure(*both) for both in of) + " |"


def failures(texts, exclusions):
    """What of the goals is missed, a line each"""
    for arithmetic, of in texts.items():
        for kind, (reached, whole) in figures(of.items.values()).items():
            if reached < LEAST * whole:
                yield f"{arithmetic}: {figure(reached, whole)} % of {kind}, less than {100 * LEAST:.0f} %"
        for folder in WHOLE:
            reached, whole = figures(i for i in of.items.values() if i.folder == folder)["conditions"]
            if reached < whole:
                yield f"{arithmetic}: {figure(reached, whole)} % of the conditions of {folder}, less than all"
    yield from exclusions.failures()


def print_missed(texts):
    for arithmetic, of in texts.items():
        for item in sorted(of.items.values(), key=lambda i: (i.place, i.kind, i.what)):
            if not item.is_reached and not item.why:
                print(arithmetic, item.kind, item, sep=" | ")


def main(build, *options):
    exclusions = Exclusions()
    texts, left_out = {}, {}
    for arithmetic in llvm.PROGRAMS:
        texts[arithmetic], left_out[arithmetic] = texts_of(Path(build), arithmetic)
        exclusions.apply(arithmetic, list(texts[arithmetic].items.values()), texts[arithmetic].counts)
    if "--missed" in options:
        print_missed(texts)
        return 0
    print("Reached/all, percent:\n", *table(texts), "", sep="\n")
    for arithmetic, of in left_out.items():
        print(f"- {arithmetic}: {of['constants']} items are behind constants, {of['uncalled']} functions are called by nothing.  llvm-cov report,",
              "which knows neither, nor excluded.txt, and takes the best instance of a text, not all together:",
              "; ".join(f"{figure(*both)} % of {kind}" for kind, both in of["totals"].items()) + ".")
    print("", *exclusions.table(), "", sep="\n")
    missed = list(failures(texts, exclusions))
    print(*(f"**{line}**" for line in missed), sep="\n\n")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
