"""Places in the texts of src, and what lies behind constants there."""

import re
from functools import cache

import llvm

@cache
def source(file):
    return (llvm.SRC / file).read_text().splitlines()


def text_of(place):
    """The source of a place, for people and for excluded.txt: on one line"""
    file, first, begin, last, end = place[:5]
    lines = source(file)[first - 1:last]
    lines[-1] = lines[-1][:end - 1]
    return " ".join(" ".join([lines[0][begin - 1:], *lines[1:]]).split())


def is_within(place, whole):
    return place[0] == whole[0] and place[1:3] >= whole[1:3] and place[3:5] <= whole[3:5]


def after(place, pattern):
    """What matches the pattern behind a place, and the (line, column) after that"""
    lines = source(place[0])
    rest = lines[place[3] - 1][place[4] - 1:] + "\n" + "\n".join(lines[place[3]:place[3] + 3])
    at = re.match(pattern, rest)
    if not at:
        return None, None
    passed = rest[:at.end()].split("\n")
    return at, (place[3] + len(passed) - 1, len(passed[-1]) + (1 if len(passed) > 1 else place[4]))


def arm(place, side, regions):
    """The region that runs only where the condition at `place` has this side, or None: its right operand, what an `if` or `?`
    chooses"""
    at, begin = after(place, r"(?P<end>[)\s]*)(?P<operator>&&|\|\||\?|)\s*")
    operator = at["operator"]
    if operator in ("&&", "||"):
        is_behind = ")" not in at["end"] and side == ("true" if operator == "&&" else "false")
        return region_at(place[0], begin, regions) if is_behind else None
    if side == "true":
        return region_at(place[0], begin, regions)
    chosen = region_at(place[0], begin, regions)
    at, begin = after(chosen, r"\s*(:|;?\s*else\b)\s*") if chosen else (None, None)
    return region_at(place[0], begin, regions) if at else None


def region_at(file, begin, regions):
    return max((r for r in regions if r[0] == file and r[1:3] == begin), key=lambda r: r[3:5], default=None)


class Constants:
    """What never runs because constants of the arithmetic say so.  Only what has not run is looked at, and only where its
    constant was asked: no gap of the tests hides there."""

    def __init__(self, texts):
        self.counts, self.dead = texts.counts, []
        inner = set()
        for place, (decision, _) in texts.decisions.items():
            inner |= {(place[0], *at) for at in decision.conditions}
            if decision.is_constant():
                varying = set(range(len(decision.conditions))) - decision.constants
                self.dead += [texts.condition_place(place[0], decision.conditions[k]) for k in varying]
                self._add_arms(place)
        for place in texts.constants:
            if place[:3] not in inner:
                self._add_arms(place)
            elif after(place, r"\s*&&\s*")[0]:
                self._add(arm(place, "true", self.counts), place)

    def is_dead(self, place):
        return any(is_within(place, dead) for dead in self.dead)

    def _add_arms(self, place):
        for side in ("true", "false"):
            self._add(arm(place, side, self.counts), place)

    def _add(self, region, asked):
        if region and not self.counts[region] and self._has_run(asked):
            self.dead.append(region)

    def _has_run(self, place):
        """Has what stands at a place run?  The smallest region around it says so."""
        around = [r for r in self.counts if r[0] == place[0] and r[1:3] <= place[1:3] < r[3:5]]
        return bool(around) and self.counts[max(around, key=lambda r: (r[1:3], [-x for x in r[3:5]]))] > 0
