#!/usr/bin/env python3
"""How many faults the everyday tests find: single-token mutants of src/, each built and tested by itself.
usage: mutants.py WORK [--count 154] [--seed 1] [--first 0] [--number COUNT]

--first and --number choose a part of the sample.  A mutant is killed where unit_f32, unit_q31, the golden vectors or the
digests of f32 fail, crash or do not end.  The sample is the same for the same sources and seed.
"""
import argparse
import collections
import pathlib
import random
import re
import resource
import shutil
import signal
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAMS = ("tests/vectors/vectors_q31", "tests/vectors/vectors_f32", "tests/unit/unit_q31", "tests/unit/unit_f32")
SECONDS = 200  # of a processor, however loaded: a program that takes more hangs
SWAPS = {  # a token and what it becomes
    "operator": {" + ": " - ", " - ": " + ", " * ": " / ", " += ": " -= ", " -= ": " += ", " && ": " || ", " || ": " && ",
                 " << ": " >> ", " >> ": " << ", " & ": " | ", " | ": " & "},
    "comparison": {" < ": " <= ", " <= ": " < ", " > ": " >= ", " >= ": " > ", " == ": " != ", " != ": " == "},
}


def blank_comments(text):
    return re.sub(r"/\*.*?\*/|\"(\\.|[^\"\\\n])*\"", lambda match: re.sub(r"[^\n]", " ", match.group()), text, flags=re.S)


def mutants_of(name, text):
    """(kind, file, offset, old, new) of all that can be changed within its functions"""
    at, is_inside = 0, False
    for line in blank_comments(text).split("\n"):
        if line == "{":
            is_inside = True
        elif line.startswith("}"):
            is_inside = False
        elif is_inside and not line.startswith("#"):
            for kind, swaps in SWAPS.items():
                for old, new in swaps.items():
                    for match in re.finditer(re.escape(old), line):
                        yield kind, name, at + match.start(), old, new
            for match in re.finditer(r"(?<![\w.\[])\d+(?![\w.\]])", line):
                yield "constant", name, at + match.start(), match.group(), str(int(match.group()) + 1)
            match = re.fullmatch(r"( +)((?:\w+\(|[\w.>\[\]-]+ [-+*/|&]?= |\+\+|--|\w+\+\+|\w+--)[^;{}]*;|return;)", line)
            if match and match.group(2).count("(") == match.group(2).count(")"):
                yield "removed statement", name, at + match.start(2), match.group(2), ";"
        at += len(line) + 1


def sample(count, seed):
    kinds = collections.defaultdict(list)
    for path in sorted((ROOT / "src").glob("*/*.h")):
        name = str(path.relative_to(ROOT))
        if "fixed_size" in name:  # unrolled kernels: their tests take minutes to compile
            continue
        for mutant in mutants_of(name, path.read_text()):
            kinds[mutant[0]].append(mutant)
    chance = random.Random(seed)
    names = sorted(kinds)
    return [chance.choice(kinds[names[number % len(names)]]) for number in range(count)]


def run(command, **options):
    return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, **options)


def copy(work):
    """The sources and a build folder of their own; tests are not optimised, and neither is the library."""
    tree = work / "tree"
    shutil.rmtree(tree, ignore_errors=True)
    for name in ("src", "include", "port", "tests", "tools"):
        shutil.copytree(ROOT / name, tree / name, symlinks=True)
    shutil.copy(ROOT / "CMakeLists.txt", tree)
    run(["cmake", "-S", tree, "-B", work / "build", "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Debug", "-DCMAKE_C_FLAGS=-w",
         f"-DKALMANQ_UNITY_DIR={ROOT / '.deps/unity/src'}"], check=True)
    return tree


def build(work):
    names = [pathlib.Path(program).name for program in PROGRAMS]
    return run(["cmake", "--build", work / "build", "--parallel", "2", "--target", *names])


def killer(work):
    """The program that fails, or nothing"""
    for program in PROGRAMS:
        limit = lambda: resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS + 5))
        if status := run([work / "build" / program], preexec_fn=limit).returncode:
            return pathlib.Path(program).name + " (no end)" * (status == -signal.SIGXCPU)
    return None


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("work", type=lambda path: pathlib.Path(path).resolve())
    for name, value in (("--count", 154), ("--seed", 1), ("--first", 0), ("--number", None)):
        parser.add_argument(name, type=int, default=value)
    asked = parser.parse_args()
    tree, tally = copy(asked.work), collections.Counter()
    if (done := build(asked.work)).returncode or killer(asked.work):
        sys.exit("the sources themselves do not pass: " + done.stdout.decode()[-2000:])
    chosen = list(enumerate(sample(asked.count, asked.seed)))[asked.first:]
    for number, (kind, name, offset, old, new) in chosen[:asked.number]:
        text = (ROOT / name).read_text()
        (tree / name).write_text(text[:offset] + new + text[offset + len(old):])
        end = "does not compile" if build(asked.work).returncode else killer(asked.work) or "SURVIVED"
        (tree / name).write_text(text)
        tally[end if end in ("does not compile", "SURVIVED") else "killed"] += 1
        line = text.count("\n", 0, offset) + 1
        print(f"{number:3} {name}:{line}: {kind}, {old.strip()} -> {new.strip()}: {end}", flush=True)
    print(", ".join(f"{count} {what}" for what, count in sorted(tally.items())))


if __name__ == "__main__":
    main()
