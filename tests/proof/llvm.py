"""What clang 19 and llvm-cov 19 know of the unit tests of one arithmetic: of each function of src its statements, the
sides of its branches, and the test vectors of its decisions (MC/DC)."""

import json
import os
import re
import subprocess
import sys
from collections import defaultdict
from pathlib import Path

SRC = Path(__file__).resolve().parents[2] / "src"
PROGRAMS = {"f32": ["unit_f32"], "f64": ["unit_f64", "unit_fixed_f64"], "q31": ["unit_q31"]}
CODE, EXPANSION = 0, 1  # kinds of regions
FLAGS = "-fprofile-instr-generate -fcoverage-mapping -fcoverage-mcdc -mllvm -system-headers-coverage"

DECISION = re.compile(r"MC/DC Decision Region \((\d+):(\d+)\) to \((\d+):(\d+)\)")
CONDITION = re.compile(r"Condition C\d+ --> \((\d+):(\d+)\)")
VECTOR = re.compile(r"\|\s+\d+ \{ (.*?)\s+= ([TF])\s*\}")
CONSTANT = re.compile(r"C(\d+)-Pair: constant folded")
FOLDED = re.compile(r"^  \|  Branch \((\d+):(\d+)\): \[Folded")


class Decision:
    """Its conditions' (line, column), which of them are constants, and the vectors that ran: ("TF-", "F")"""

    def __init__(self):
        self.conditions, self.constants, self.vectors = [], set(), set()

    def shown(self, k):
        """Is there a pair of vectors in which condition k alone differs, and the result?  (What did not run counts as equal.)"""
        return any(a[1] != b[1] and self._differ(a[0], b[0]) == [k] for a in self.vectors for b in self.vectors)

    def is_constant(self):
        """Has it run, and have only constants decided?"""
        return bool(self.vectors) and not any(value in "TF" for vector, _ in self.vectors for value in vector)

    @staticmethod
    def _differ(a, b):
        return [k for k, both in enumerate(zip(a, b)) if set(both) == {"T", "F"}]


class Function:
    """One instance of a text of src: statements[place] and sides[place, side] are counts, decisions[place] a Decision"""

    def __init__(self, json_function):
        self.name = json_function["name"]
        self.files = [os.path.relpath(file, SRC) for file in json_function["filenames"]]
        self.sites = {r[6]: r for r in json_function["regions"] if r[7] == EXPANSION}
        self.statements, self.sides, self.decisions, self.folded = defaultdict(int), {}, {}, set()
        for *place, count, file, _, kind in json_function["regions"]:
            if kind == CODE:
                self.statements[self._place(place, file)] += count
        for *place, true, false, file, _, _ in json_function["branches"]:
            self.sides[self._place(place, file), "true"], self.sides[self._place(place, file), "false"] = true, false
        self.mcdc = {tuple(place): shown for *place, _, _, shown in json_function["mcdc_records"]}

    def _place(self, place, file):
        """(file, line, column, line, column); of what stands in a macro, where that is used, and then where in it"""
        if file not in self.sites:
            return (self.files[file], *place)
        site = self.sites[file]
        return (*self._place(site[:4], site[5]), self.files[file], *place)

    def read_decision(self, place, decision):
        if [decision.shown(k) for k in range(len(decision.conditions))] != self.mcdc[place]:
            sys.exit(f"llvm.py: llvm-cov thinks otherwise of {self.name} {place}")
        self.decisions[(self.files[0], *place)] = decision

    def unread_decisions(self):
        """Those in macros, which llvm-cov does not show: the branches that they consist of"""
        for first, begin, last, end in self.mcdc.keys() - {place[1:] for place in self.decisions}:
            yield [place for place, side in self.sides if side == "true" and (first, begin) <= place[-4:-2] <= (last, end)]


def run(*command, **options):
    done = subprocess.run(command, capture_output=True, text=True, **options)
    if done.returncode:
        sys.exit(f"{command[0]} fails\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    return done.stdout


def read_shown(text, functions):
    """What llvm-cov shows and does not export: constants, and the vectors of decisions"""
    function, decisions = None, []
    for line in text.splitlines():
        if line[:1].strip() and line.endswith(":"):
            function = functions.get(line[:-1])
        elif function and (at := FOLDED.search(line)):
            function.folded.add((int(at[1]), int(at[2])))
        elif function and (at := DECISION.search(line)):
            decisions.append((function, tuple(map(int, at.groups())), Decision()))
        elif function and decisions:
            read_line_of_decision(line, decisions[-1][2])
    for function, place, decision in decisions:
        function.read_decision(place, decision)


def read_line_of_decision(line, decision):
    if at := CONDITION.search(line):
        decision.conditions.append((int(at[1]), int(at[2])))
    elif at := VECTOR.search(line):
        decision.vectors.add((at[1].replace(",", "").replace(" ", ""), at[2]))
    elif at := CONSTANT.search(line):
        decision.constants.add(int(at[1]) - 1)


def is_of(name, arithmetic):
    """Of tests of q31 f64 is a part that they compare with.  Static functions are named by their file, kq_filter_q31.c:step."""
    own = re.search(r"_(f32|f64|q31)(\.c)?$", name.split(":")[0])
    return not own or own[1] == arithmetic


def profiled(build, arithmetic):
    """Runs the tests; the options that name programs and profile to llvm-cov"""
    programs = [str(build / "tests/unit" / name) for name in PROGRAMS[arithmetic]]
    raw = [str(build / f"{Path(name).name}.profraw") for name in programs]
    for program, file in zip(programs, raw):
        if Path(file).exists() and os.path.getmtime(file) > os.path.getmtime(program):
            continue  # nothing new to run
        run(program, env={**os.environ, "LLVM_PROFILE_FILE": file})
    profile = str(build / f"{arithmetic}.profdata")
    run("llvm-profdata-19", "merge", "-o", profile, *raw)
    return profile, [programs[0], *(f"-object={name}" for name in programs[1:]), f"-instr-profile={profile}"]


def functions_of(build, arithmetic):
    """Those of src that the compiler has made; those that no instance calls, which it has not; and what llvm-cov itself counts:
    {kind: (reached, all)}"""
    profile, options = profiled(build, arithmetic)
    made = {line.strip()[:-1] for line in run("llvm-profdata-19", "show", "--all-functions", profile).splitlines()}
    exported = json.loads(run("llvm-cov-19", "export", *options))["data"][0]
    functions = [Function(f) for f in exported["functions"] if is_of(f["name"], arithmetic)]
    functions = {f.name: f for f in functions if not f.files[0].startswith("..")}
    shown = ("-name-regex=.*", "-show-mcdc", "-show-branches=count", "-show-expansions")
    read_shown(run("llvm-cov-19", "show", *options, *shown), functions)
    own, others = ([f for f in functions.values() if (f.name in made) == is_made] for is_made in (True, False))
    return own, others, totals(exported["files"])


def totals(files):
    """Of what llvm-cov report says of the files of src"""
    own = [file["summary"] for file in files if file["filename"].startswith(f"{SRC}/")]
    names = {"statements": "regions", "sides": "branches", "conditions": "mcdc"}
    return {kind: tuple(sum(of[name][what] for of in own) for what in ("covered", "count")) for kind, name in names.items()}


if __name__ == "__main__":
    print(FLAGS)
