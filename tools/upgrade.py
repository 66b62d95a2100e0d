#!/usr/bin/env python3
"""Renames kalmanq's names of version 0.1 in your sources to those of 1.0: upgrade.py [--write] PATH...

PATH is a file, or a folder whose C and C++ files are taken.  Prints each line that changes, and each line that
you have to change yourself, with what to write there.  Writes nothing without --write.  Ends with 1 where
something is left to you.  The names are those of the table in CHANGELOG.md.
"""
import argparse
import pathlib
import re
import sys

CHANGES = pathlib.Path(__file__).resolve().parents[1] / "CHANGELOG.md"
ENDINGS = {".c", ".h", ".cc", ".cpp", ".cxx", ".hpp", ".ino", ".inc"}
ARITHMETIC = r"(_f32|_f64|_q31|_F32|_F64|_Q31)?"
CODE = re.compile(r"`([^`]+)`")


def rows():
    """(old, new, how) of each row; new: None where you have to change the line yourself"""
    for line in CHANGES.read_text(encoding="utf-8").splitlines():
        cells = [cell.strip() for cell in line.strip("|").split(" | ")]
        if line.startswith("| `") and len(cells) == 3:
            old, new = CODE.findall(cells[0]), CODE.findall(cells[1])
            plain = new if len(new) == len(old) else new * len(old)
            for k, name in enumerate(old):
                yield name, None if cells[2] else plain[k], f"{cells[1]}: {cells[2]}"


def arguments(text, start):
    """The arguments of the call whose ( is at start, and the place behind its )"""
    depth, parts, begin = 0, [], start + 1
    for k in range(start, len(text)):
        depth += (text[k] in "([{") - (text[k] in ")]}")
        if depth == 0 or (depth == 1 and text[k] == ","):
            parts.append(text[begin:k].strip())
            begin = k + 1
        if depth == 0:
            return parts, k + 1
    return None, start


def member(object_, field):
    """&object.field of the address of an object"""
    if object_.startswith("&"):
        return f"{object_}.{field}"
    return f"&{object_ if object_.isidentifier() else f'({object_})'}->{field}"


def call(text, old, new):
    """Rewrites calls `old(a, b)` as `new(b, &a.attached)`, say: names of arguments are places"""
    name, places = old.rstrip(")").split("(")
    to, wanted = new.rstrip(")").split("(")
    places = [place.strip() for place in places.split(",")]

    def one(given, suffix):
        value = dict(zip(places, given))
        made = [member(value[p[1:].split(".")[0]], p.split(".")[1]) if p.startswith("&") else value.get(p, p)
                for p in (part.strip() for part in wanted.split(","))]
        return f"{to}{suffix}({', '.join(made)})"

    at = 0
    while found := re.compile(rf"\b{name}{ARITHMETIC}\s*(?=\()").search(text, at):
        given, end = arguments(text, found.end())
        at = found.end()
        if given and len(given) == len(places):
            made = one(given, found[1] or "")
            text, at = text[:found.start()] + made + text[end:], found.start() + len(made)
    return text


def upgraded(text, table):
    for old, new, _ in table:
        if new and "(" in old:
            text = call(text, old, new)
        elif new and "." in old:
            text = re.sub(rf"\bkalmanq/{re.escape(old)}", f"kalmanq/{new}", text)
        elif new:
            text = re.sub(rf"\b{old}{ARITHMETIC}\b", lambda found, new=new: new + (found[1] or ""), text)
    return text


def left(line, table):
    """What is to be done by hand in a line: (old name, how)"""
    for old, new, how in table:
        if not new and re.search(rf"\b{re.escape(old.split('(')[0])}{ARITHMETIC}\b", line):
            yield old, how


def files(paths):
    for path in map(pathlib.Path, paths):
        yield from sorted(p for p in path.rglob("*") if p.suffix in ENDINGS) if path.is_dir() else [path]


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--write", action="store_true", help="change the files")
    options.add_argument("paths", nargs="+", metavar="PATH")
    given = options.parse_args()
    table, changed, open_ = list(rows()), 0, 0
    for path in files(given.paths):
        try:
            before = path.read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError) as error:
            sys.exit(f"upgrade: {path}: {error}")
        after = upgraded(before, table)
        for number, (was, line) in enumerate(zip(before.split("\n"), after.split("\n")), 1):
            if was != line:
                changed += 1
                print(f"{path}:{number}: {line.strip()}")
            for old, how in left(line, table):
                open_ += 1
                print(f"{path}:{number}: BY HAND: {old}: {how}")
        if given.write and after != before:
            path.write_text(after, encoding="utf-8")
    print(f"upgrade: {changed} lines {'changed' if given.write else 'to change'}, {open_} left to you")
    return 1 if open_ else 0


if __name__ == "__main__":
    sys.exit(main())
