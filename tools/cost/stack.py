#!/usr/bin/env python3
"""stack.py: a bound of the stack of each public function, from the compiler's call graph, beside the deepest stack of the table.

gcc's -fcallgraph-info=su has the frame of each function and its calls; frames of libgcc, libc and libm are read from their code.  An
indirect call stands at a place of the source: `->member(` may be whatever an initialiser of src calls `.member = `; PASSED has what is
passed as an argument.  Nothing may call itself; ALONE and take_innovations are calls of the same function for something else.  Each
indirect call has to be resolved, or be the user's own function (USERS).  Fails where a bound is below what was measured (tools/cost.csv)."""

from __future__ import annotations

import re
import sys
import tempfile
from collections import defaultdict
from concurrent.futures import ThreadPoolExecutor
from copy import deepcopy
from functools import lru_cache
from pathlib import Path

import command_line  # noqa: F401  finds the package
import table
from build import CALLED, TARGET, Place, compiled, library_sources
from cases import GCC, RUNTIME
from cores import BY_NAME, ROOT, Core, run, toolchain

SOURCE = ROOT / "src"
NODE = re.compile(r'node: \{ title: "([^"]+)" label: "[^"]*\\n(\d+) bytes \(([^"]*)\)"')
EDGE = re.compile(r'edge: \{ sourcename: "([^"]+)" targetname: "([^"]+)"(?: label: "([^"]+)")? \}')
USERS = {"g": "f or h of a nonlinear model"}
PASSED = {"undo": ("undo_mean_and_root", "undo_with_extras", "undo_mean"), "update": ("update_by_base", "update_robust", "update_gated")}
ALONE = ("filter/attached.h", "steady/freeze.h")  # here kq_predict and its like are called after the filter's attached object was taken off
PROGRAM = {  # what a whole program calls, beside what the row is about
    "step": "process_init sensor_init_diagonal filter_init predict update step mean sigma",
    "smooth": "process_init sensor_init_diagonal filter_init predict update step mean sigma history_assign attach smooth smooth_step "
              "smoothed"}
PLAIN = ("step", "update")  # with a bound of a program that attaches nothing and whose sensors are independent, too
LEFT_OUT = ("roots", "lean", "changed", "extended", "points", "dearest")  # other programs, or those functions with a user's own
PUSH = {"arm": re.compile(r"\b(?:push|stmdb)(?:\.w)?\s+(?:sp!, )?\{([^}]*)\}|\bvpush\s+\{([^}]*)\}|\bsub(?:\.w|w)?\s+sp, (?:sp, )?#(\d+)"
                          r"|\[sp, #-(\d+)\]!")}
PLANTED = "int again(int n); int again(int n) { volatile int k = n; if (n > 3) k += again(n - 1); return k; }"


class Graph:
    def __init__(self) -> None:
        self.frame: dict[str, int] = {}
        self.calls: dict[str, set[str]] = defaultdict(set)
        self.indirect: dict[str, set[tuple[str, bool]]] = defaultdict(set)  # function: members, and are they of what is attached?
        self.problems: list[str] = []
        self.users: set[str] = set()

    def read(self, text: str, symbols: str) -> None:
        """symbols: of objdump -t, as a function that is another one's double has no node"""
        for title, size, kind in NODE.findall(text):
            self.frame[title] = int(size)
            if "dynamic" in kind:
                self.problems.append(f"{title}: its frame is dynamic")
        for source, target, place in EDGE.findall(text):
            if target == "__indirect_call":
                self.indirect[source].add(member_at(place))
            else:
                is_alone = target.startswith(("kq_predict_", "kq_update_subset_", "kq_step_")) and place.rsplit(":", 2)[0].endswith(ALONE)
                self.calls[source].add(target + " alone" * is_alone)
        at: dict[tuple[str, str], set[str]] = defaultdict(set)
        for address, section, name in re.findall(r"^(\w+) .{6}F (\S+)\s+\w+ (\S+)$", symbols, re.M):
            at[section, address].add(name)
        file = next(iter(re.findall(r'graph: \{ title: "([^"]+)"', text)), "")
        for doubles in at.values():
            known = [title for name in doubles for title in (name, f"{file}:{name}") if title in self.frame]
            for name in doubles:
                if known and name not in self.frame and f"{file}:{name}" not in self.frame:
                    self.frame[f"{file}:{name}"], self.calls[f"{file}:{name}"] = 0, {known[0]}

    def resolve(self, members: dict[str, set[str]], is_plain: bool = False) -> None:
        """is_plain: of a program that attaches nothing, and has independent sensors"""
        named = defaultdict(set)
        for title in self.frame:
            named[plain(title)].add(title)
        resolved: dict[str, dict[bool, set[str]]] = {}
        for source, asked in self.indirect.items():
            resolved[source] = {True: set(), False: set()}
            for member, is_attached in asked:
                found = {title for name in members[member] - {plain(source)} for title in named[name]}
                if is_plain and is_attached:
                    continue
                if is_plain and member == "take":
                    found = named["take_independent"]
                resolved[source][is_attached] |= found
                if member in USERS:
                    self.users.add(plain(source))
                elif not found:
                    self.problems.append(f"{source}: who is {member}()?")
        for alone in {each for calls in self.calls.values() for each in calls if each.endswith(" alone")}:
            source = alone.removesuffix(" alone")
            self.frame[alone] = self.frame.get(source, 0)
            self.calls[alone] = self.calls[source] | resolved[source][False]
        for source, found in resolved.items():
            self.calls[source] |= found[True] | found[False]

    def bounds(self, outside: dict[str, int]) -> dict[str, int]:
        """Of each function; a call of itself is a problem."""
        done: dict[str, int] = {}

        def bound(title: str, above: tuple[str, ...]) -> int:
            if title in above:
                self.problems.append("recursion: " + " > ".join(map(plain, (*above[above.index(title):], title))))
                return 0
            if title not in done:
                if title not in self.frame and title not in outside:
                    self.problems.append(f"{plain(title)}: no frame is known of it")
                own = self.frame.get(title, outside.get(title, 0))
                done[title] = own + max((bound(each, (*above, title)) for each in sorted(self.calls[title])), default=0)
            return done[title]

        for title in sorted(self.frame):
            bound(title, ())
        return done


def plain(title: str) -> str:
    return re.sub(r"[.](isra|constprop|part|cold)[.0-9a-z]*", "", title.split(":")[-1])


@lru_cache(maxsize=None)
def lines_of(path: str) -> list[str]:
    return Path(path).read_text().splitlines()


def member_at(place: str) -> tuple[str, bool]:
    path, line, column = place.rsplit(":", 2)
    call = lines_of(path)[int(line) - 1][int(column) - 1:]
    names = re.findall(r"->(\w+)\(", call) or [name for name in re.findall(r"(\w+)\(", call) if name in PASSED] or [place]
    return names[0], "hooks" in call


def members_of_source() -> dict[str, set[str]]:
    members: dict[str, set[str]] = defaultdict(set)
    for path in SOURCE.rglob("*.h"):
        for member, function in re.findall(r"[.](\w+) = (\w+)\b(?!\()", path.read_text()):
            members[member].add(function)
    for member, functions in PASSED.items():
        members[member] |= set(functions)
    return members


@lru_cache(maxsize=None)
def outside_of(core: Core) -> dict[str, int]:
    """The bounds of functions of libgcc, libc and libm, from their code"""
    frame: dict[str, int] = defaultdict(int)
    calls: dict[str, set[str]] = defaultdict(set)
    doubles: dict[tuple[str, str, str], list[str]] = defaultdict(list)
    gcc = toolchain(core, "gcc").compiler
    for archive in ("libgcc.a", "libc_nano.a", "libm.a"):
        path = run([*gcc, f"-print-file-name={archive}"]).strip()
        name = ""
        for line in run([gcc[0].replace("gcc", "objdump"), "-dtr", path]).splitlines():
            if "file format" in line:
                member = f"{archive} {line}"
            elif at := re.match(r"(\w{8}) .{6}F (\S+)\s+\w+ (?:\.hidden )?(\S+)$", line):
                doubles[member, at[2], at[1]].append(at[3])
            elif at := re.match(r"[0-9a-f]+ <([^>]+)>:", line):
                name = at[1]
                frame[name] += 0
            elif at := re.search(r"R_ARM_THM_(?:CALL|JUMP24|JUMP11)\s+(\w+)", line) or re.search(r"\bb(?:l|\.n|\.w)?\s+[0-9a-f]+ <(\w+)>$", line):
                calls[name].add(at[1])
            elif at := PUSH["arm"].search(line):
                frame[name] += pushed(at)
    for names in doubles.values():  # of the same code
        most, called = max(frame[name] for name in names), set().union(*(calls[name] for name in names)) - set(names)
        for name in names:
            frame[name], calls[name] = most, called
    bounds: dict[str, int] = {}

    def bound(name: str, above: tuple[str, ...]) -> int:
        if name in above or name not in frame:  # a loop that jumps to the function's own name
            return 0
        if name not in bounds:
            bounds[name] = frame[name] + max((bound(each, (*above, name)) for each in calls[name]), default=0)
        return bounds[name]

    return {name: bound(name, ()) for name in list(frame) if not name.startswith(("_malloc", "_free", "printf"))}


def pushed(at: re.Match[str]) -> int:
    if at[3] or at[4]:
        return int(at[3] or at[4])
    count = 0
    for part in (at[1] or at[2]).split(","):
        ends = [int(end) for end in re.findall(r"\d+", part)]
        count += ends[1] - ends[0] + 1 if "-" in part and len(ends) == 2 else 1
    return 4 * count * (2 if at[2] and "d" in at[2] else 1)


def graph_of(core: Core, arithmetic: str, work: Path, planted: str = "") -> Graph:
    graph = Graph()
    place = Place(ROOT, work)
    sources = [(path, ()) for path in library_sources(place, arithmetic, ("filter", "statistics", "steady", "adaptation", "nonlinear", "lengths", "self_test", "em"))]
    sources.append((TARGET / "user.c", (f"-DKQ_COST_{arithmetic}", "-DKQ_COST_MODULES")))
    if planted:
        (work / "planted.c").write_text(planted + "\n")
        sources = [(work / "planted.c", ())]
    for path, flags in sources:
        compiled(place, core, GCC, path, work / f"{path.stem}.o", ("-fcallgraph-info=su", *flags))
        symbols = run([toolchain(core, "gcc").compiler[0].replace("gcc", "objdump"), "-t", str(work / f"{path.stem}.o")])
        graph.read((work / f"{path.stem}.ci").read_text(), symbols)
    return graph


def bounded(graph: Graph, core: Core, is_plain: bool) -> dict[str, int]:
    graph.resolve(members_of_source(), is_plain)
    return graph.bounds(outside_of(core))


def judge(core: Core, arithmetic: str, rows: list[table.Row]) -> tuple[list[str], list[str]]:
    """Lines of the table, and what is wrong"""
    with tempfile.TemporaryDirectory(prefix="kalmanq-stack-") as work:
        graph = graph_of(core, arithmetic, Path(work))
        recursive = graph_of(core, arithmetic, Path(work), PLANTED)
    plain_bounds = bounded(deepcopy(graph), core, True)
    bounds = bounded(graph, core, False)
    bounded(recursive, core, False)
    lines = []
    failed = [f"{core.name} {arithmetic}: {problem}" for problem in dict.fromkeys(graph.problems)]
    if not any("recursion" in problem for problem in recursive.problems):
        failed.append("a planted recursion is not found")

    def bound_of(names: str, of: dict[str, int]) -> int:
        return max(of.get(f"kq_{name}_{arithmetic}", of.get(f"user_{name}_{arithmetic}", 0)) for name in names.split())

    for what in dict.fromkeys(row.what for row in rows):
        own = [row for row in rows if row.what == what]
        names = PROGRAM.get(what, CALLED.get(what, what))
        measured = max(max(row.stack_bytes, row.stack_worst or 0) for row in own)
        bound, narrow = bound_of(names, bounds), bound_of(names, plain_bounds) if what in PLAIN else 0
        lines.append(f"| {core.name} | {arithmetic} | {what} | {measured} | {narrow or ''} | {bound} |")
        if min(bound, narrow or bound) < measured:
            failed.append(f"{core.name} {arithmetic} {what}: the bound {narrow or bound} is below {measured}")
    calls = sum(map(len, graph.indirect.values()))
    lines.append(f"| {core.name} | {arithmetic} | {len(graph.frame)} functions, {calls} indirect calls; of the user: {', '.join(sorted(graph.users)) or 'none'} | | | |")
    return lines, failed


def main() -> int:
    rows = table.read(ROOT / "tools" / "cost.csv").rows
    wanted = {(core, arithmetic): [] for core in ("m0", "m3", "m4f") for arithmetic in ("f32", "q31")}
    for row in rows:
        if (row.core, row.arithmetic) in wanted and (row.sizes, row.profile) == (RUNTIME, GCC) and row.what not in LEFT_OUT:
            wanted[row.core, row.arithmetic].append(row)
    with ThreadPoolExecutor(2) as pool:
        found = list(pool.map(lambda one: judge(BY_NAME[one[0][0]], one[0][1], one[1]), wanted.items()))
    print("| core | | what | measured, most | bound, plain | bound |\n|---|---|---|---:|---:|---:|")
    print("\n".join(line for lines, _ in found for line in lines))
    failed = [each for _, problems in found for each in problems]
    print("\n".join(["", *failed]))
    return bool(failed)


if __name__ == "__main__":
    sys.exit(main())
