#!/usr/bin/env python3
"""How many faults of src/ the everyday tests find: a thousand mutants in one build, each chosen at run time (mutants.py).
usage: mutation.py WORK [--part 1/1] [--count 1000] [--seed 1] [--jobs 1]

A mutant runs against the everyday unit tests of f32 and q31 and the recorded vectors that reach it, the shortest first, until one fails,
crashes, or takes 20 times its time.  WORK keeps the build and what is known; a campaign that is begun again goes on.
survivors.txt says of each survivor why.  It fails if less than 95 % of the meaningful mutants are killed, a survivor has no row or a
row no survivor."""

import argparse
import hashlib
import os
import re
import resource
import subprocess
import sys
import tempfile
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from mutants import KINDS, Finder, instrumented, key_of, sample

ROOT = Path(__file__).resolve().parents[2]
INCLUDES = [f"-I{ROOT / 'include'}", f"-I{ROOT / 'src'}"]
ARITHMETICS = ("f32", "q31")
INSTRUMENTED = {"f32": "sanitized", "q31": "checked"}
GOAL = 95
REASONS = ("equivalent", "slack", "gap")
CHOICE = """
#ifndef KQ_MUTANT
extern int kq_mutant;
extern unsigned char kq_reached[];
#define KQ_MUTANT(number) (kq_reached[number] = 1, kq_mutant == (number))
#endif
"""
RUNTIME = """
#include <stdio.h>
#include <stdlib.h>
int kq_mutant = -1;
unsigned char kq_reached[COUNT + 1];
__attribute__((constructor)) static void choose(void)
{
    if (getenv("KQ_MUTANT")) kq_mutant = atoi(getenv("KQ_MUTANT"));
}
__attribute__((destructor)) static void tell(void)
{
    FILE *file = getenv("KQ_REACHED") ? fopen(getenv("KQ_REACHED"), "w") : NULL;
    for (int k = 0; file && k < COUNT; k++) if (kq_reached[k]) fprintf(file, "%d\\n", k);
    if (file) fclose(file);
}
"""


def find():
    finder = Finder(ROOT / "src")
    for arithmetic in ARITHMETICS:
        for path in [*sorted((ROOT / "src").glob(f"kq_*_{arithmetic}.c")), ROOT / "src/kq_status.c"]:
            finder.parse(path.read_text(), INCLUDES, str(path))
        finder.parse(f'#include "fixed_size/kq_fixed_{arithmetic}.h"\n', INCLUDES)
    return finder


def tree_of(chosen):
    """{path: bytes} of the repository with all mutants, whose unit tests end with their first failure"""
    listed = subprocess.run(["git", "-C", ROOT, "ls-files", "-z", "-co", "--exclude-standard"], check=True, capture_output=True, text=True).stdout
    tree = {path: (ROOT / path).read_bytes() for path in listed.split("\0") if (ROOT / path).is_file()}
    for file in {mutant.file for mutant in chosen}:
        of_file = [(number, mutant) for number, mutant in enumerate(chosen) if mutant.file == file]
        tree[f"src/{file}"] = instrumented(tree[f"src/{file}"].decode(), of_file).encode()
    tree["src/kq_status.c"] += RUNTIME.replace("COUNT", str(len(chosen))).encode()
    tree["tests/unit/runner.c"] = tree["tests/unit/runner.c"].replace(b"void setUp(void)\n{", b"void exit(int);\nvoid setUp(void)\n{ if (Unity.TestFailures) exit(1);")
    return tree


def build(work, chosen):
    """Programs of the sources with all mutants; where a build is there, of what has changed"""
    for path, text in {**tree_of(chosen), "choice.h": CHOICE.encode()}.items():
        target = work / "tree" / path
        if not target.exists() or target.read_bytes() != text:
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(text)
    subprocess.run(["cmake", "-S", work / "tree", "-B", work / "build", "-G", "Ninja", "-DCMAKE_BUILD_TYPE=None", f"-DKALMANQ_UNITY_DIR={ROOT / '.deps/unity/src'}",
                    f"-DCMAKE_C_FLAGS=-O1 -w -include {work / 'tree/choice.h'}"], check=True, stdout=subprocess.DEVNULL)
    programs = sorted({Path(command[0]).name for _, command in commands(work)})
    done = subprocess.run(["cmake", "--build", work / "build", "--parallel", "2", "--target", *programs], capture_output=True, text=True)
    if done.returncode:
        sys.exit("mutation.py: " + "\n".join(re.findall(r".*error.*\n.*", done.stdout)[:20]))


def commands(work):
    """{name: command}: a suite of unit tests, also sanitized or checked as every day, or all vectors of an arithmetic"""
    cmake = (ROOT / "tests/unit/suites.cmake").read_text()
    for arithmetic in ARITHMETICS:
        yield f"vectors.{arithmetic}", [work / f"build/tests/vectors/vectors_{arithmetic}"]
        suites = re.search(rf"KALMANQ_SUITES_{arithmetic} ([^)]*)\)", cmake)[1].split()
        for suite in [*suites, "fixed", "fixed_smoother", "conditions_fixed"]:
            yield f"unit.{suite}.{arithmetic}", [work / f"build/tests/unit/unit_{arithmetic}", suite]
        for suite in set(suites) - {"diffuse_rank", "diffuse_orders", "inverse_q31"}:
            yield f"unit.{INSTRUMENTED[arithmetic]}.{suite}.{arithmetic}", [work / f"build/tests/unit/unit_{INSTRUMENTED[arithmetic]}_{arithmetic}", suite]


def run(command, seconds, **environment):
    """The status, and the seconds of a processor that it took"""
    limit = lambda: resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 2))
    child = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, preexec_fn=limit, env={**os.environ, **environment})
    _, status, usage = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    return child.returncode, usage.ru_utime + usage.ru_stime


class Suite:
    def __init__(self, name, command):
        self.name, self.command = name, command
        with tempfile.NamedTemporaryFile("r") as reached:
            status, self.seconds = run(command, 3600, KQ_REACHED=reached.name)
            self.reached = {int(line) for line in reached.read().split()}
        if status:
            sys.exit(f"mutation.py: {name} fails without a mutant")

    def kills(self, number):
        return number in self.reached and run(self.command, int(20 * self.seconds) + 2, KQ_MUTANT=str(number))[0] != 0


def end_of(number, suites):
    for suite in suites:
        if suite.kills(number):
            return suite.name
    return "survived" if any(number in suite.reached for suite in suites) else "not reached"


def digest():
    """Of what decides how a mutant ends"""
    files = sorted(path for name in ("src", "include", "tests/unit", "tests/vectors") for path in (ROOT / name).rglob("*") if path.is_file())
    return hashlib.sha256(b"".join(path.read_bytes() for path in files)).hexdigest()[:12]


def known(path):
    return dict(line.rsplit(" || ", 1) for line in path.read_text().splitlines()) if path.exists() else {}


def run_all(work, chosen, numbers, jobs):
    """{key: end} of these numbers and of others that ran before"""
    path = work / f"ends-{digest()}.txt"
    ends = known(path)
    todo = [number for number in numbers if key_of(chosen[number]) not in ends]
    if not todo:
        return ends
    build(work, chosen)

    def judge(number):
        key = key_of(chosen[number])
        ends[key] = end_of(number, suites)
        with path.open("a") as file:
            file.write(f"{key} || {ends[key]}\n")

    with ThreadPoolExecutor(jobs) as pool:
        suites = sorted(pool.map(lambda one: Suite(*one), commands(work)), key=lambda one: one.seconds)
        list(pool.map(judge, todo))
    return ends


def explained():
    """{key: reason} of survivors.txt"""
    rows = [line for line in Path(__file__).with_name("survivors.txt").read_text().splitlines() if line and not line.startswith("#")]
    return {key.strip(): why.strip() for key, why in (row.rsplit(" || ", 1) for row in rows)}


def table(head, counts):
    """Rows of name, mutants, killed, equivalent, slack, and percent of the meaningful ones"""
    print(f"| {head} | mutants | killed | equivalent | slack | gaps | killed, of what means something |\n|---|---:|---:|---:|---:|---:|---:|")
    for name, of in counts.items():
        meaningful = of["killed"] + of["gap"]
        print(f"| {name} | {of.total()} | {of['killed']} | {of['equivalent']} | {of['slack']} | {of['gap']} | {100 * of['killed'] / max(meaningful, 1):.1f} % |")
    print()


def report(chosen, ends, rows, is_whole):
    failed = []
    by = {"kind": {}, "folder": {}, "": {}}
    killers = Counter()
    for mutant in chosen:
        key, end = key_of(mutant), ends[key_of(mutant)]
        why = rows.get(key, "gap: no row").split(":")[0] if end in ("survived", "not reached") else "killed"
        if why == "killed":
            killers[re.sub(r"^(unit(?:\.sanitized|\.checked)?)\.\w+\.(?=\w+$)", r"\1.", end)] += 1
        elif key not in rows or why not in REASONS:
            failed.append(f"survives, and survivors.txt does not say why: {key} || {end}")
        for table_of, name in (("kind", mutant.kind), ("folder", mutant.file.split("/")[0]), ("", "all")):
            by[table_of].setdefault(name, Counter())[why] += 1
    alive = {key_of(mutant) for mutant in chosen if ends[key_of(mutant)] in ("survived", "not reached")}
    killed = {key_of(mutant) for mutant in chosen} - alive
    failed += [f"survivors.txt has a row without a survivor: {key}" for key in rows if key in killed or (is_whole and key not in alive)]
    for head, counts in by.items():
        table(head, dict(sorted(counts.items())))
    print("Killed first by: " + ", ".join(f"{name} {count}" for name, count in killers.most_common()) + ".")
    of = by[""]["all"]
    if 100 * of["killed"] < GOAL * (of["killed"] + of["gap"]):
        failed.append(f"less than {GOAL} % of the meaningful mutants are killed")
    print("\n".join(["", *failed]) if failed else "")
    return bool(failed)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("work", type=lambda path: Path(path).resolve())
    for name, value in (("--count", 1000), ("--seed", 1), ("--jobs", 1)):
        parser.add_argument(name, type=int, default=value)
    parser.add_argument("--part", default="1/1", help="number and count of the part")
    asked = parser.parse_args()
    part, of = map(int, asked.part.split("/"))
    finder = find()
    chosen = sample(finder.found, asked.count, asked.seed)
    print(f"{len(finder.found)} places of {len(KINDS)} kinds; left out: " + ", ".join(f"{why} {n}" for why, n in finder.left_out.most_common()), flush=True)
    numbers = range(part - 1, len(chosen), of)
    ends = run_all(asked.work, chosen, numbers, asked.jobs)
    return report([chosen[number] for number in numbers], ends, explained(), of == 1)


if __name__ == "__main__":
    sys.exit(main())
