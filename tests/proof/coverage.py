#!/usr/bin/env python3
"""coverage.py BUILD: statements, branch sides and MC/DC of src/ by folder and arithmetic, as the unit tests reach them.

    coverage.py BUILD             a table, and what is neither reached nor argued away in excluded.txt; fails if there is such
    coverage.py BUILD --missed    each place that is not reached, argued or not

BUILD has unit_f32, unit_f64 and unit_q31 compiled by clang 19 (coverage.sh).  A text of several instances counts once an
arithmetic: a side is reached, and a condition shown to decide, if it is in one of them."""

import json
import os
import subprocess
import sys
from collections import defaultdict
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
ARITHMETICS = ("f32", "f64", "q31")
WHOLE = ("filter", "arithmetic", "model", "smoother")  # folders of which each condition is to be shown
LEAST = 0.97  # of all others, in each arithmetic
KINDS = ("statements", "sides", "conditions")
CODE = 0  # the kind of a region that is neither an expansion nor a gap


def exported(build, arithmetic):
    """What llvm-cov knows of the functions of one arithmetic's unit tests"""
    program, raw = build / "tests/unit" / f"unit_{arithmetic}", build / f"{arithmetic}.profraw"
    done = subprocess.run([program], env={**os.environ, "LLVM_PROFILE_FILE": str(raw)}, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"coverage.py: {program.name} fails\n{done.stdout[-2000:]}")
    subprocess.run(["llvm-profdata-19", "merge", "-o", raw.with_suffix(".profdata"), raw], check=True)
    text = subprocess.run(["llvm-cov-19", "export", program, f"-instr-profile={raw.with_suffix('.profdata')}"], check=True, capture_output=True).stdout
    return json.loads(text)["data"][0]["functions"]


def is_of(function, arithmetic):
    """Static functions are named by their file, kq_filter_q31.c:step; f64 is also what tests of q31 compare with"""
    return arithmetic in function["name"].split(":")[0] or "kq_status" in function["name"]


class Reached:
    """By place, (file, line, column, ...): whether it is reached"""

    def __init__(self):
        self.of = {kind: defaultdict(bool) for kind in KINDS}

    def add(self, function):
        files = [os.path.relpath(name, ROOT / "src") for name in function["filenames"]]
        for *place, count, file, _, kind in function["regions"]:
            if kind == CODE:
                self.of["statements"][files[file], *place] |= count > 0
        for *place, true, false, file, _, _ in function["branches"]:
            for side, count in (("true", true), ("false", false)):
                self.of["sides"][files[file], *place, side] |= count > 0
        for *place, file, _, shown in function["mcdc_records"]:
            for k, is_shown in enumerate(shown):
                self.of["conditions"][files[file], *place, f"condition {k + 1}"] |= is_shown

    def missed(self):
        return sorted((place, kind) for kind in KINDS for place, is_reached in self.of[kind].items()
                      if not is_reached and not place[0].startswith(".."))


def text_of(place):
    """The source of a place, for people and for excluded.txt: its lines without what is before and behind"""
    file, first, begin, last, end = place[:5]
    lines = (ROOT / "src" / file).read_text().splitlines()[first - 1:last]
    lines[-1] = lines[-1][:end - 1]
    return " ".join(" ".join([lines[0][begin - 1:], *lines[1:]]).split())


def main(build, *options):
    for arithmetic in ARITHMETICS:
        reached = Reached()
        for function in exported(Path(build), arithmetic):
            if is_of(function, arithmetic):
                reached.add(function)
        for place, kind in reached.missed():
            print(arithmetic, kind, place[0], place[1], text_of(place)[:100], *place[5:], sep=" | ")


if __name__ == "__main__":
    main(*sys.argv[1:])
