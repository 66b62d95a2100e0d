#!/usr/bin/env python3
"""Does a line serve one house?  The core names no path of the host or the shelf, the host none of the shelf.

The houses are the headings of budgets.txt.  Pages may lead anywhere; what is of all houses is said here."""
import pathlib
import re
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
OF_ALL = ("tools/setup.sh", "tools/test.sh", "tools/proof.sh", "tools/package.sh", "tools/release.sh", "tools/docs/", "tests/house/", "tests/readme/")
LINKS = re.compile(r"tools/\w+\.(sh|py)\b|\S+\.(md|csv)\b")  # scripts that whoever runs the tests has; pages, and what they show


def houses():
    """Of each house, its folders: the whole project's files are of none"""
    found = {}
    for row in (HERE / "budgets.txt").read_text().splitlines():
        if row.startswith("# ") and len(row.split()) == 2:
            found[row[2:]] = []
        elif not row.startswith(("#", ". ")):
            found[list(found)[-1]].append(row.split()[0])
    return found


def faults(files, of, read):
    """read(name): the text of a file"""
    host, shelf = of["host"], of["shelf"]
    barred = {"core": [*shelf, *host], "host": shelf}
    for name in files:
        house = max(((folder, one) for one, folders in of.items() for folder in folders if name.startswith(f"{folder}/")), default=("", ""),
                    key=lambda pair: len(pair[0]))[1]
        if house not in barred or name.endswith(".md") or name.startswith(OF_ALL):
            continue
        for number, line in enumerate(read(name).splitlines(), 1):
            named = [folder for folder in barred[house] if f"{folder}/" in line and re.search(rf"\b{folder}/", LINKS.sub("", line))]
            if named:
                yield f"{name}:{number}: the {house} names {named[0]}: {line.strip()}"


def main():
    if not (ROOT / ".git").exists():
        return print("not a checkout of git: nothing is looked at")
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, check=True, capture_output=True, text=True).stdout.split("\0")[:-1]
    files = [name for name in listed if (ROOT / name).is_file() and b"\0" not in (ROOT / name).read_bytes()]
    found = list(faults(files, houses(), lambda name: (ROOT / name).read_text(encoding="utf-8")))
    print(*found, f"{len(files)} files, {len(found)} faults", sep="\n")
    return bool(found)


if __name__ == "__main__":
    sys.exit(main())
