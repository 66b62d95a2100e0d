#!/usr/bin/env python3
"""static.py: what static analysers say of src/ and include/: gcc -fanalyzer, clang-tidy and cppcheck.

Each finding is of a kind that DEVIATIONS argues in a line, or it fails.  So does a kind without a finding, and an analyser that does
not find what PLANTED has of its own."""

import os
import re
import subprocess
import sys
import tempfile
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
INCLUDES = [f"-I{ROOT / 'include'}", f"-I{ROOT / 'src'}"]
FINDING = re.compile(r"^(?:(?P<file>[^:\s]+):(?P<line>\d+):\d+: )?(?:warning|error|style|performance|portability): .*\[(?P<kind>[^\]]+)\]$", re.M)

ANALYSERS = {
    "gcc -fanalyzer": ["gcc", "-std=c11", "-O1", "-fanalyzer", *INCLUDES, "-c", "-o", "/dev/null", "{}"],
    "clang-tidy": ["clang-tidy-19", "--quiet", "--header-filter=.*", "--checks=-*,clang-analyzer-*,bugprone-*,cert-*,performance-*,portability-*",
                   "{}", "--", "-std=c11", *INCLUDES],
    "cppcheck": ["cppcheck", "--std=c11", "--language=c", "--quiet", "--enable=warning,performance,portability", "--suppress=missingIncludeSystem",
                 "--template={file}:{line}:{column}: {severity}: {message} [{id}]", *INCLUDES, "{}"],
}
DEVIATIONS = {  # kind: why
    "bugprone-easily-swappable-parameters": "n, m and l are ints in one order everywhere; the order is read where they are declared",
    "bugprone-implicit-widening-of-multiplication-result": "products of sizes of at most 16 and 33, far below INT_MAX of 16 bits",
    "bugprone-macro-parentheses": "macros that declare: a type or a name cannot stand in parentheses",
    "bugprone-multi-level-implicit-pointer-conversion": "a pointer is copied as bytes onto the tape, and back",
    "bugprone-narrowing-conversions": "whole numbers that the arithmetic holds exactly (2, 2^24), and a bit of a word",
    "bugprone-sizeof-expression": "the size of a pointer is what is meant: it is copied onto the tape",
    "cert-flp30-c": "the shares of a search double exactly, and end at an infinite one",
    "clang-analyzer-deadcode.DeadStores": "what the text of the floats uses, and a constant of q31 makes needless",
    "clang-analyzer-security.FloatLoopCounter": "an exponent is counted while a double is halved or doubled, exactly, at most 1074 times",
    "analyzer-null-dereference": "what remembers early steps of a diffuse start is asked only where there is memory for them",
    "analyzer-use-of-uninitialized-value": "an array that is filled from its end is read from where it is filled; clang's sanitizer sees none",
    "AssignmentIntegerToAddress": "an int32_t that is declared behind two pointers",
    "ctunullpointer": "a sum that every caller has",
    "shiftNegativeLHS": "the assertion that signed numbers are shifted arithmetically, as all compilers do that the tests know",
    "shiftTooManyBitsSigned": "the sign of a word, by that shift",
    "uninitvar": "members that are written through an array of their addresses",
    "cert-int09-c": "an enumeration ends with INT_MAX, so that it is an int with every compiler; the others count from 0",
}
PLANTED = {
    "gcc -fanalyzer": "int f(int n) { int *p = 0; return n > 3 ? *p : n; }",
    "clang-tidy": "int f(int n) { int k; if (n > 3) k = n; return k; }",
    "cppcheck": "int f(int n) { int a[2]; a[0] = a[1] = n; return a[2]; }",
}


def said(name, file):
    done = subprocess.run([one.format(file) if one == "{}" else one for one in ANALYSERS[name]], capture_output=True, text=True)
    text = done.stdout + done.stderr
    if done.returncode not in (0, 1) or "is not recognized" in text:
        sys.exit(f"static.py: {name} {file}: {text[-2000:]}")
    return {(os.path.relpath(match["file"] or file, ROOT), match["line"], match["kind"].removeprefix("-W").split(",")[0])
            for match in FINDING.finditer(text)}


def finds_its_own(name):
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "planted.c")
        file.write_text(PLANTED[name] + "\n")
        return bool(said(name, str(file)))


def main():
    files = [str(path) for path in sorted((ROOT / "src").glob("kq_*.c"))]
    failed, seen = [], Counter()
    with ThreadPoolExecutor(2) as pool:
        for name in ANALYSERS:
            if not finds_its_own(name):
                failed.append(f"{name} does not find what is planted")
            found = set().union(*pool.map(lambda file: said(name, file), files))
            new = sorted(one for one in found if one[2] not in DEVIATIONS)
            failed += [f"{name}: {file}:{line}: {kind}" for file, line, kind in new]
            seen.update(kind for _, _, kind in found)
            print(f"- {name}: {len(files)} files, {len(found)} findings, {len(new)} of them not argued")
    print("\n| kind | places | why it stays |\n|---|---:|---|")
    for kind, why in DEVIATIONS.items():
        print(f"| {kind} | {seen[kind]} | {why} |")
        if not seen[kind]:
            failed.append(f"{kind}: there is none any more: leave it out")
    print("\n" + "\n".join(failed) if failed else "")
    return bool(failed)


if __name__ == "__main__":
    sys.exit(main())
