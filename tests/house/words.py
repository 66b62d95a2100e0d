#!/usr/bin/env python3
"""Checks the words of headers, pages and messages: words.py [ROOT].

Phrases that point at a thing in the place of its name are in none of them.  Of the sentences of headers, and of pages, at most
LONG in 100 have more than WORDS words.  Answers 0 where that holds; prints the shares.
"""
import ast
import pathlib
import re
import sys

POINTING = ("that of", "those of", "of its own", "is told", "is none", "as ever", "at a desk")
WORDS, LONG = 30, 3.0
LEFT_OUT = ("CHANGELOG.md", "tools/studies/heavy_tails/README.md")  # what was; what a study writes


def headers(root):
    for path in sorted((root / "include").rglob("*.h")):
        comments = re.findall(r"/\*\*?(.*?)\*/", path.read_text(encoding="utf-8"), re.S)
        yield path, "\n\n".join(re.sub(r"^ *\* ?", "", one, flags=re.M) for one in comments)


def pages(root):
    for path in sorted(root.rglob("*.md")):
        name = str(path.relative_to(root))
        if not name.startswith((".", "build")) and "/." not in name and name not in LEFT_OUT:
            yield path, re.sub(r"^```.*?^```", "", path.read_text(encoding="utf-8"), flags=re.S | re.M)


def messages(root):
    """Texts of the package that are no docstrings"""
    for path in sorted((root / "tools" / "kalmanq").rglob("*.py")):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        notes = {id(one.body[0].value) for one in ast.walk(tree) if isinstance(one, (ast.Module, ast.ClassDef, ast.FunctionDef))
                 and one.body and isinstance(one.body[0], ast.Expr)}
        yield path, "\n\n".join(one.value for one in ast.walk(tree)
                                if isinstance(one, ast.Constant) and isinstance(one.value, str) and id(one) not in notes)


def sentences(text):
    """Of running text: no tables, no code, no lists of parameters or errors"""
    lines = [line for line in text.split("\n") if not line.startswith((" ", "|", "#", "<", "    "))]
    for part in re.split(r"\n\s*\n|(?<=[:;])\s+(?=[A-Z])|(?<![ (]al)(?<![ (]ch)(?<=[.?!])(?:\*\*)?\s+(?=\S)|\n- ", "\n".join(lines)):
        words = re.findall(r"[A-Za-z][\w'-]*", re.sub(r"`[^`]*`|\[([^\]]*)\]\([^)]*\)", r"\1 x", part))
        if len(words) > 2 and part.count("KQ_ERR_") < 3:  # a list of errors is none
            yield " ".join(part.split()), len(words)


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parents[2])
    faults = []
    for kind, texts in (("headers", headers), ("pages", pages), ("messages", messages)):
        long_ones = count = 0
        for path, text in texts(root):
            flat = " ".join(text.split())
            for phrase in POINTING:
                faults += [f"{path.relative_to(root)}: {flat[max(0, at.start() - 40):at.end() + 20]!r}: name the thing"
                           for at in re.finditer(rf"\b{phrase}\b", flat)]
            lengths = [words for _, words in sentences(text)] if kind != "messages" else []
            count, long_ones = count + len(lengths), long_ones + sum(one > WORDS for one in lengths)
        if count:
            share = 100 * long_ones / count
            print(f"{kind}: {share:.1f} % of {count} sentences have more than {WORDS} words")
            if share > LONG:
                faults.append(f"{kind}: {share:.1f} % of the sentences have more than {WORDS} words; at most {LONG:g}")
    print(*faults, f"{len(faults)} faults", sep="\n")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
