#!/usr/bin/env python3
"""Checks the rules of src/ (src/README.md): rules.py [ROOT].

Answers 0 where all hold.  Prints what is beyond the guides for sizes, which are no rules.
"""
import collections
import itertools
import pathlib
import re
import subprocess
import sys
import tempfile

# Left to right: a folder includes those before it.  Folders of one tuple don't include each other.
LAYERS = [("arithmetic",), ("model",), ("filter",), ("smoother",), ("linearised", "robust", "diffuse", "steady"),
          ("adaptation", "em", "nonlinear", "statistics"), ("self_test", "messages", "fixed_size", "lengths")]
RANK = {folder: rank for rank, folders in enumerate(LAYERS) for folder in folders}
CHOICES = {f"arithmetic/{one}.h" for one in ("f32", "f64", "q31")}  # an instance or a twin chooses one
COMPILE = ["cc", "-std=c11", "-fsyntax-only", "-Wall", "-Wextra", "-Wconversion", "-Werror", "-Iinclude"]
LINES, FUNCTION_LINES, PARAMETERS = 300, 40, 8


def without_comments(text):
    blank = lambda match: re.sub(r"[^\n]", " ", match.group())
    return re.sub(r'"(\\.|[^"\\\n])*"', '""', re.sub(r"/\*.*?\*/", blank, text, flags=re.S))


class House:
    def __init__(self, root):
        self.root = root
        self.src = root / "src"
        self.faults = []
        self.headers = {str(path.relative_to(self.src)): path.read_text()
                        for path in sorted(self.src.glob("*/*.h"))}
        self.instances = {path.name: path.read_text() for path in sorted(self.src.glob("*.c"))}

    def fault(self, where, what):
        self.faults.append(f"src/{where}: {what}")

    def included(self, name, text):
        """The headers of src/ that a file includes"""
        folder = (self.src / name).parent
        for line in re.findall(r'^#include "([^"]+)"', text, re.M):
            if not line.startswith("kalmanq/"):
                path = str((folder / line).resolve().relative_to(self.src.resolve()))
                if path in self.headers:
                    yield path
                else:
                    self.fault(name, f"includes {line}, which is not there")

    def public(self, name):
        """The public functions and tables that a header defines"""
        text = without_comments(self.headers[name])
        return re.findall(r"^(?!static|extern|#|\s)[^\n;={}]*\bT\((kq_\w+)\)(?:\([^;{}]*\)\s*\{| = )", text, re.M)

    def brought(self, name, seen=None):
        """A header and what it brings of its folder"""
        seen = set() if seen is None else seen
        if name not in seen:
            seen.add(name)
            for other in self.included(name, self.headers[name]):
                if other.split("/")[0] == name.split("/")[0]:
                    self.brought(other, seen)
        return sorted(seen)

    def branches(self):
        """Of each header that is included in an #if: the branches where it is, {header: {#if: {branch}}}"""
        found = collections.defaultdict(lambda: collections.defaultdict(set))
        for name, text in self.headers.items():
            inside = []
            for number, line in enumerate(without_comments(text).split("\n")):
                directive = re.match(r"#\s*(if|el|endif)", line)
                if directive and directive.group(1) == "if":
                    inside.append([f"{name}:{number}", 0])
                elif directive and directive.group(1) == "el":
                    inside[-1][1] += 1
                elif directive:
                    inside.pop()
                elif line.startswith("#include"):
                    for other in self.included(name, text.split("\n")[number]):
                        for which, branch in inside[1:]:  # inside[0] is the guard
                            found[other][which].add(branch)
        for name, own in list(found.items()):  # a chooser that is chosen, as mean_float.h
            if name in self.headers and any(key.startswith(name + ":") for one in found.values() for key in one):
                for other in self.included(name, self.headers[name]):
                    for which, branch in own.items():
                        found[other][which] |= branch
        return found

    def check_guards(self):
        for name, text in self.headers.items():
            if name.startswith("fixed_size/kq_"):  # a user's file: its guard is a public name
                continue
            guard = "KQ_SRC_" + re.sub(r"\W", "_", name).upper()
            if f"#ifndef {guard}\n#define {guard}\n" not in text:
                self.fault(name, f"its guard is not {guard}")

    def check_headers_alone(self):
        """Each header compiles by itself, without a warning."""
        with tempfile.TemporaryDirectory() as work:
            for name in self.headers:
                file = pathlib.Path(work) / "alone.c"
                file.write_text(f'#include "{(self.src / name).resolve()}"\ntypedef int alone;\n')
                done = subprocess.run([*COMPILE, str(file)], cwd=self.root, capture_output=True, text=True)
                if done.returncode:
                    self.fault(name, "does not compile alone: " + done.stderr.split("\n")[0])

    def check_layers(self):
        """A folder includes doors of folders to its left."""
        for name, text in self.headers.items():
            folder = name.split("/")[0]
            for other in self.included(name, text):
                beside = other.split("/")[0]
                if beside == folder:
                    continue
                if RANK[beside] >= RANK[folder]:
                    self.fault(name, f"includes {other}, which is not to its left")
                elif other != f"{beside}/{beside}.h" and other not in CHOICES:
                    self.fault(name, f"includes {other}, and not the door {beside}/{beside}.h")

    def check_public_files(self):
        """What defines something public is compiled once an arithmetic: no door brings it, and an api.h is for
        instances."""
        for name, text in self.headers.items():
            for other in self.included(name, text):
                if other.split("/")[0] != name.split("/")[0]:
                    for one in self.brought(other):
                        if self.public(one):
                            self.fault(name, f"includes {other}, so {one}, which defines {self.public(one)[0]}")
                if other.endswith("/api.h") and not name.startswith("fixed_size/kq_"):
                    self.fault(name, f"includes {other}, which is for instances")

    def check_names(self):
        """No function has two texts, but in headers of which one is chosen."""
        branches = self.branches()
        places = collections.defaultdict(set)
        for name, text in self.headers.items():
            for function in re.findall(r"^(?:KQ_\w+ |static )+[^\n;=]*?\b(?!T\()(\w+)\([^;]*?\)\s*\{",
                                       without_comments(text), re.M) + self.public(name):
                places[function].add(name)
        for function, names in places.items():
            for one, other in itertools.combinations(sorted(names), 2):
                ours, theirs = branches[one], branches[other]
                if {one, other} <= CHOICES or any(ours[key].isdisjoint(theirs[key]) for key in ours.keys() & theirs):
                    continue
                self.fault(one, f"{function} is defined in {other}, too")

    def check_arithmetic(self):
        """Only arithmetic/ knows which arithmetic it is; elsewhere twins are chosen: what is included, or, in a
        header that holds nothing else, one of two texts."""
        for name, text in self.headers.items():
            code = without_comments(text)
            if name.startswith("arithmetic/") or "KQ_FLOATING" not in code:
                continue
            choice = r"^#if KQ_FLOATING\n(.*?)^#endif\n"
            chosen, rest = re.findall(choice, code, re.M | re.S), re.sub(choice, "", code, flags=re.M | re.S)
            has_text = any(re.search(r"^(?!#|\s*$)", one, re.M) for one in chosen)
            if "KQ_FLOATING" in rest or has_text and (len(chosen) > 1 or re.search(r"^(?!#|\s*$)", rest, re.M)):
                self.fault(name, "knows its arithmetic")
        for name in self.headers:
            twin = name.replace("_float.h", "_q31.h")
            if twin == name or twin not in self.headers:
                continue
            ours, theirs = self.functions(name), self.functions(twin)
            for one, other in zip([x for x in ours if x in theirs], [x for x in theirs if x in ours]):
                if one != other:
                    self.fault(name, f"{one} is where {twin} has {other}")
                    break

    def functions(self, name):
        """What a header defines, in its order"""
        return re.findall(r"^(?!#|extern|\s)[^\n;={}]*?(\w+|T\(\w+\))\([^;{}]*\)\s*\{",
                          without_comments(self.headers[name]), re.M)

    def check_macros(self):
        for name, text in self.headers.items():
            code = without_comments(text)
            for line in code.split("\n"):
                if "##" in line and not re.match(r"#define T\(name\) name##_(f32|f64|q31)$", line):
                    self.fault(name, "makes a name: " + line.strip())
            for stem in re.findall(r"\bT\((\w+)\)", code):
                if not stem.startswith("kq_") and stem != "name":
                    self.fault(name, f"T({stem}) is no public name")

    def check_instances(self):
        for name, text in self.instances.items():
            for line in re.sub(r"/\*.*?\*/", "", text, flags=re.S).split("\n"):
                if line.strip() and not re.match(r'#include "[^"]+"$|#if KQ_HAS_DOUBLE$|#endif$', line):
                    self.fault(name, "holds a statement: " + line.strip())

    def guides(self):
        for name, text in self.headers.items():
            count = text.count("\n")
            if count > LINES:
                yield f"src/{name}: {count} lines"
            for match in re.finditer(r"^(?!#)[^\n]*\b(\w+)\)?\(([^;{}]*)\)\n\{\n(.*?)^\}", without_comments(text), re.M | re.S):
                lines = match.group(3).count("\n") + 2
                if lines > FUNCTION_LINES:
                    yield f"src/{name}: {match.group(1)} has {lines} lines"
                if match.group(2).count(",") >= PARAMETERS:
                    yield f"src/{name}: {match.group(1)} has {match.group(2).count(',') + 1} parameters"


def main():
    here = pathlib.Path(__file__).resolve().parents[2]
    house = House(pathlib.Path(sys.argv[1]).resolve() if len(sys.argv) > 1 else here)
    for check in ("guards", "headers_alone", "layers", "public_files", "names", "arithmetic", "macros",
                  "instances"):
        getattr(house, "check_" + check)()
    for line in house.guides():
        print("beyond a guide:", line)
    for line in house.faults:
        print(line)
    print(f"{len(house.headers)} headers and {len(house.instances)} instances, {len(house.faults)} faults")
    return bool(house.faults)


if __name__ == "__main__":
    sys.exit(main())
