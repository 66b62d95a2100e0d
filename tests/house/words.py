#!/usr/bin/env python3
"""Advice on words: words.py [ROOT] prints where headers, pages and messages have one that CONTRIBUTING.md has a better one for, and how
many of their sentences are long.  It answers 0, whatever it finds."""
import ast
import pathlib
import re
import sys

WORDS = 30  # more are a long sentence
LEFT_OUT = ("CHANGELOG.md",)  # what was
TABLE = re.compile(r"^## Words\n.*?^\|---\|---\|\n(.*?)\n\n", re.M | re.S)
C_TEXT = re.compile(r"[{};]\n|->|#include|^\S*$")  # what the package writes into C files, and names


def better(root):
    """Of each word or phrase, what to say"""
    rows = [row.strip("| ").split(" | ") for row in TABLE.search((root / "CONTRIBUTING.md").read_text(encoding="utf-8"))[1].split("\n")]
    return {phrase: instead for phrases, instead in rows for phrase in phrases.split(", ")}


def headers(root):
    for path in sorted((root / "include").rglob("*.h")):
        comments = re.findall(r"/\*\*?(.*?)\*/", path.read_text(encoding="utf-8"), re.S)
        yield path, "\n\n".join(re.sub(r"^ *\* ?", "", one, flags=re.M) for one in comments)


def pages(root):
    for path in sorted(root.rglob("*.md")):
        name = str(path.relative_to(root))
        if not name.startswith((".", "build")) and "/." not in name and name not in LEFT_OUT:
            yield path, re.sub(r"^```.*?^```", "", TABLE.sub("", path.read_text(encoding="utf-8")), flags=re.S | re.M)


def messages(root):
    """Texts of the package that are no docstrings, and no C"""
    for path in sorted((root / "tools" / "kalmanq").rglob("*.py")):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        notes = {id(one.body[0].value) for one in ast.walk(tree) if isinstance(one, (ast.Module, ast.ClassDef, ast.FunctionDef))
                 and one.body and isinstance(one.body[0], ast.Expr)}
        yield path, "\n\n".join(one.value for one in ast.walk(tree)
                                if isinstance(one, ast.Constant) and isinstance(one.value, str) and id(one) not in notes
                                and not C_TEXT.search(one.value))


def sentences(text):
    """How many words each has, of running text: no tables, no code, no lists of parameters or errors"""
    lines = [line for line in text.split("\n") if not line.startswith((" ", "|", "#", "<", "    "))]
    for part in re.split(r"\n\s*\n|(?<=[:;])\s+(?=[A-Z])|(?<![ (]al)(?<![ (]ch)(?<=[.?!])(?:\*\*)?\s+(?=\S)|\n- ", "\n".join(lines)):
        words = re.findall(r"[A-Za-z][\w'-]*", re.sub(r"`[^`]*`|\[([^\]]*)\]\([^)]*\)", r"\1 x", part))
        if len(words) > 2 and part.count("KQ_ERR_") < 3:  # a list of errors is none
            yield len(words)


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parents[2])
    instead, found = better(root), 0
    phrases = re.compile(r"\b(" + "|".join(map(re.escape, sorted(instead, key=len, reverse=True))) + r")\b")
    for kind, texts in (("headers", headers), ("pages", pages), ("messages", messages)):
        counts = []
        for path, text in texts(root):
            flat = " ".join(re.sub(r"`[^`]*`", "`x`", text).split())
            for at in phrases.finditer(flat):
                print(f"{path.relative_to(root)}: {flat[max(0, at.start() - 40):at.end() + 20]!r}: {instead[at[1]]}")
                found += 1
            counts += sentences(text)
        if counts and kind != "messages":
            print(f"{kind}: {100 * sum(one > WORDS for one in counts) / len(counts):.1f} % of {len(counts)} sentences have more than {WORDS} words")
    print(f"{found} words to look at")


if __name__ == "__main__":
    main()
