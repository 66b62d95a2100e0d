#!/usr/bin/env python3
"""static.py [MORE.c...]: what gcc -fanalyzer, clang-tidy and cppcheck say of src/ and include/, and of other C files; and cppcheck's addon
for MISRA C:2012, by the numbers of the rules.

Each finding is of a kind that DEVIATIONS or MISRA argues in a line, or it fails.  So does, where there are other files, a kind without a
finding, and an analyser that does not find what PLANTED has of its own."""

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
CPPCHECK = ["cppcheck", "--std=c11", "--language=c", "--quiet", "--suppress=missingIncludeSystem",
            "--template={file}:{line}:{column}: {severity}: {message} [{id}]", *INCLUDES]
HOST = ["-D__GNUC__=12", "-D__x86_64__", "-D__SIZEOF_INT128__=16", "-DUINT_MAX=4294967295U", "-DSIZE_MAX=18446744073709551615UL", "-DDBL_MANT_DIG=53"]
FINDING = re.compile(r"^(?:(?P<file>[^:\s]+):(?P<line>\d+):\d+: )?(?:warning|error|style|performance|portability): .*\[(?P<kind>[^\]]+)\]$", re.M)

ANALYSERS = {
    "gcc -fanalyzer": ["gcc", "-std=c11", "-O1", "-fanalyzer", *INCLUDES, "-c", "-o", "/dev/null", "{}"],
    "clang-tidy": ["clang-tidy-19", "--quiet", "--header-filter=.*", "--checks=-*,clang-analyzer-*,bugprone-*,cert-*,performance-*,portability-*",
                   "{}", "--", "-std=c11", *INCLUDES],
    "cppcheck": [*CPPCHECK, "--enable=warning,performance,portability", "{}"],
    "MISRA": [*CPPCHECK, *HOST, "--addon=misra", "--cppcheck-build-dir={build}", "{}"],
}
MISRA = [  # required rules, advisory ones, why; none is mandatory
    ("10.1 10.3 10.4 10.6 10.7 10.8", "10.5", "integers of 16 to 64 bits, bits and 0 or 1 are converted as C does: -Wconversion of two compilers is an error, tests/checked looks at each operation"),
    ("14.4", "12.1 12.3", "a pointer, a count or a bit is asked as it is, operators bind as in C: -Wall of two compilers is an error"),
    ("14.1 14.2", "13.3 13.4 17.8", "loops count down or end by what they find, rows are walked by *row++, a parameter is the variable that it begins"),
    ("15.6 15.7 16.4", "15.5", "what is refused returns at once; a body of one statement has no braces, a chain no empty else; without a default -Wswitch names what is missing"),
    ("", "18.4", "rows and triangles are pointers into the caller's memory"),
    ("8.14 11.3 11.6 11.8 11.9", "11.5", "an object begins with what is attached, a context is void, a seal is made of addresses, 0 is a null pointer; restrict where the header says so; -Wcast-qual finds no const that is dropped"),
    ("5.4 5.5 7.2 20.1 20.7", "20.10", "one text for all arithmetics: T pastes names, macros declare objects; the addon has no system headers"),
    ("2.2", "2.3 2.4 2.5 8.7 8.9", "a text that several instances include: each uses a part of it, with its own constants"),
    ("", "19.2", "the bits of a float"),
    ("9.2 9.3 9.4", "", "initialisers name the entries that are not 0"),
]
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
    "MISRA": "int f(int n) { if (n > 3) { goto out; } n = 2; out: return n; }",
}


def said(name, file):
    with tempfile.TemporaryDirectory() as build:
        done = subprocess.run([one.format(file, build=build) if one in ("{}", ANALYSERS["MISRA"][-2]) else one for one in ANALYSERS[name]],
                              capture_output=True, text=True)
    text = done.stdout + done.stderr
    if done.returncode not in (0, 1) or "is not recognized" in text or "Bailing out" in text:
        sys.exit(f"static.py: {name} {file}: {text[-2000:]}")
    found = {(os.path.relpath(match["file"] or file, ROOT), match["line"], match["kind"].removeprefix("-W").split(",")[0])
             for match in FINDING.finditer(text)}
    return {one for one in found if (name == "MISRA") == one[2].startswith("misra-")}


def argued():
    return {*DEVIATIONS, *(f"misra-c2012-{rule}" for required, advisory, _ in MISRA for rule in f"{required} {advisory}".split())}


def finds_its_own(name):
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "planted.c")
        file.write_text(PLANTED[name] + "\n")
        return any(name != "MISRA" or kind not in argued() for _, _, kind in said(name, str(file)))


def table(library, more):
    """Of each kind its places in the library and in the other files"""
    yield "\n| kind | places | generated | why it stays |\n|---|---:|---:|---|"
    for kind, why in DEVIATIONS.items():
        yield f"| {kind} | {library[kind]} | {more[kind]} | {why} |"
    yield "\n| MISRA C:2012: required | advisory | places | generated | why it stays |\n|---|---|---:|---:|---|"
    for required, advisory, why in MISRA:
        rules = [f"misra-c2012-{rule}" for rule in f"{required} {advisory}".split()]
        yield f"| {required} | {advisory} | {sum(library[one] for one in rules)} | {sum(more[one] for one in rules)} | {why} |"


def main(more):
    files = [str(path) for path in sorted((ROOT / "src").glob("kq_*.c"))]
    failed, seen, own = [], Counter(), {os.path.relpath(file, ROOT) for file in more}
    others = Counter()
    with ThreadPoolExecutor(2) as pool:
        for name in ANALYSERS:
            if not finds_its_own(name):
                failed.append(f"{name} does not find what is planted")
            found = set().union(*pool.map(lambda file: said(name, file), files + more))
            new = sorted(one for one in found if one[2] not in argued())
            failed += [f"{name}: {file}:{line}: {kind}" for file, line, kind in new]
            seen.update(kind for file, _, kind in found if file not in own)
            others.update(kind for file, _, kind in found if file in own)
            print(f"- {name}: {len(files)} files and {len(more)} that are generated, {len(found)} findings, {len(new)} of them not argued", flush=True)
    print(*table(seen, others), sep="\n")
    failed += [f"{kind}: there is none any more: leave it out" for kind in sorted(argued()) if more and not seen[kind] + others[kind]]
    print("\n" + "\n".join(failed) if failed else "")
    return bool(failed)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
