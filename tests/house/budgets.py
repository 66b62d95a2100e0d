#!/usr/bin/env python3
"""Has no folder more lines than budgets.txt allows?  budgets.py counts the text that git has, without pictures; a file counts
for the longest row that it is below."""
import pathlib
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]


def lines(path):
    text = path.read_bytes() if path.is_file() and path.suffix != ".svg" else b""
    return 0 if b"\0" in text else text.count(b"\n")


def main():
    if not (ROOT / ".git").exists():
        return print("not a checkout of git: nothing is counted")
    rows = [row.split() for row in (HERE / "budgets.txt").read_text().splitlines() if row and row[0] != "#"]
    counts = dict.fromkeys((folder for folder, _ in rows), 0)
    for name in subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, check=True, capture_output=True, text=True).stdout.split("\0")[:-1]:
        counts[max((one for one in counts if one == "." or f"{name}/".startswith(f"{one}/")), key=len)] += lines(ROOT / name)
    for folder, most in rows:
        print(f"{folder}: {counts[folder]} lines of {most}{'' if counts[folder] <= int(most) else ': TOO MANY; CONTRIBUTING.md, Budgets'}")
    return any(counts[folder] > int(most) for folder, most in rows)


if __name__ == "__main__":
    sys.exit(main())
