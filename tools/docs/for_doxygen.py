#!/usr/bin/env python3
"""A header as Doxygen takes it: its comments as paragraphs, lists and parameters, functions without a comment with a link to their
twin, objects whose fields are the library's left out.  for_doxygen.py HEADER"""

import re
import sys
from pathlib import Path

PIECE = re.compile(r"(?P<block>/\*\*(?!<).*?\*/)\n?|(?P<note>/\*\n.*?\*/)|(?P<line>/\*.*?\*/)|(?P<macro>^#define (?P<word>\w+)(?P<arguments>\([^)]*\))?"
                   r"(?:[^\n]*\\\n)*[^\n]*\n)|(?P<struct>^typedef struct[^;{]*\{(?:[^{}]|\{[^{}]*\})*\} (?P<type>\w+);)|"
                   r"(?P<function>^[^\n;{}/#]*?\b(?P<name>kq_\w+)\((?P<list>[^;{}()]*)\);)", re.M | re.S)
ROW = re.compile(r"  ((?:\w+|\.\.\.)(?:, \w+)*) {2,}(\S.*)")
LABEL = re.compile(r"(Events?\b|Errors?\b|Cost\b|Stack\b|Accuracy\b|KQ_ERR_\w+|KQ_EVENT_\w+|KQ_SATURATED\b|KQ_NOT_IDENTIFIED\b)")
SUFFIX = re.compile(r"_(f32|f64|q31)$", re.I)

FUNCTIONS: dict[str, str] = {}


def plain(text: str) -> str:
    text = text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    text = re.sub(r"`([^`]*)`", r"<code>\1</code>", re.sub(r"([\\@#%$])", r"\\\1", text))
    return re.sub(r"<code>.*?</code>|\bkq_\w+", lambda one: linked(one[0]), text)


def linked(name: str) -> str:
    """A function's name as a link to the first of its arithmetics"""
    first = FUNCTIONS.get(SUFFIX.sub("", name))
    return f'@ref {first if name not in FUNCTIONS.values() else name} "{name}"' if first else name


def functions(folder: Path) -> dict[str, str]:
    found: dict[str, str] = {}
    for header in sorted(folder.glob("*.h")):
        for piece in PIECE.finditer(header.read_text(encoding="utf-8")):
            if piece["name"] and "typedef" not in piece[0]:
                found.setdefault(SUFFIX.sub("", piece["name"]), piece["name"])
    return found


def paragraph(lines: list[str]) -> str:
    text = plain(" ".join(line.strip() for line in lines))
    text = re.sub(r"^(Events?|Errors?|Cost|Stack|Accuracy)\b([^:.]{0,60}:)", r"<b>\1\2</b>", text)
    return re.sub(r"^(?=KQ_ERR_)", "<b>Errors:</b> ", text)


def row(names: str, lines: list[str], parameters: list[str]) -> str:
    said = plain(" ".join(line.strip() for line in lines))
    mine = [name for name in names.split(", ") if name in parameters]
    return "\n\n".join(f"@param {name} {said}" for name in mine) or f"<b>{names}</b> {said}"


def goes_on(last: str, line: str, inside: str) -> bool:
    """Is a line of the paragraph before it?"""
    if not line.strip() or line.startswith((inside, "  - ")) or ROW.match(line) or (last.startswith(" ") and not line.startswith(" ")):
        return False
    return not (LABEL.match(line) and re.search(r"[.:)]$", last))


def parts(text: str, parameters: list[str], indent: int = 4) -> list[str]:
    """A comment's text: rows become parameters, what is `indent` further in stays as it is"""
    made: list[str] = []
    inside = " " * indent
    lines = [*text.split("\n"), ""]
    at = 0
    while at < len(lines):
        end = at + 1
        if lines[at].startswith("  - "):
            while lines[end].startswith("    "):
                end += 1
            made.append("<ul><li>" + plain(" ".join(line.strip(" -") for line in lines[at:end])) + "</li></ul>")
        elif lines[at].startswith(inside):
            while lines[end].startswith(inside) or (not lines[end] and end + 1 < len(lines) and lines[end + 1].startswith(inside)):
                end += 1
            made += ["@verbatim\n" + "\n".join(line[indent:] for line in lines[at:end]) + "\n@endverbatim"]
        elif found := ROW.match(lines[at]):
            while lines[end].startswith("      "):
                end += 1
            made.append(row(found[1], [found[2], *lines[at + 1:end]], parameters))
        elif lines[at].strip():
            while goes_on(lines[end - 1], lines[end], inside):
                end += 1
            made.append(paragraph(lines[at:end]))
        at = end
    return made


def comment(found: str, parameters: list[str], head: str = "", indent: int = 4) -> str:
    inner = re.sub(r"^/\*+\n?|\s*\*/\s*$", "", found)
    inner = "\n".join(re.sub(r"^ *\* ?|^ +", "", line).rstrip() for line in inner.split("\n"))
    inner = re.sub(r"^-{5,} *", "", inner)
    inner = re.sub(r"^kalmanq: (.)", lambda one: one[1].upper(), inner)
    return f"/** {head}" + "\n\n".join(parts(inner, parameters, indent)) + "\n*/\n"


def fields(text: str) -> str:
    text = re.sub(r"/\* ?(.*?) ?\*/", lambda one: f"/**< {plain(' '.join(one[1].split()))} */", text, flags=re.S)
    return re.sub(r"^typedef struct \w+", "typedef struct", text)  # or it is there twice


def names_of(piece: re.Match[str]) -> list[str]:
    if "typedef" in piece[0]:
        return []
    return re.findall(r"(\w+|\.\.\.)(?=\s*(?:,|$|\)))", (piece["list"] or piece["arguments"] or "").strip("()"))


def whole(block: str, parameters: list[str], stem: str, rows: dict[str, dict[str, str]]) -> tuple[str, list[str]]:
    """A comment with the rows of parameters that it leaves to a twin, or to the function that it is As; macros have all or none"""
    own = {name: said for names, said in re.findall(r"^ \*   ((?:\w+)(?:, \w+)*) {2,}(\S.*(?:\n \*     +.*)*)", block, re.M)
           for name in names.split(", ")}
    named = re.search(r"As (kq_\w+)", block)
    given = {**rows.get(SUFFIX.sub("", named[1]) if named else "", {}), **rows.get(stem, {})}
    rows[stem] = {**given, **own}
    missing = [name for name in parameters if name not in own]
    if not own or not missing:
        return block, parameters
    if not all(name in given for name in missing):
        return block, []
    added = "".join(f" *   {name}  {given[name]}\n" for name in missing)
    return re.sub(r"(?=^ \*   \w+(?:, \w+)* {2,}\S)", lambda _: added, block, count=1, flags=re.M), parameters


def made(text: str) -> str:
    out: list[str] = []
    block, first, known, rows, end = None, "", {}, {}, 0
    for piece in PIECE.finditer(text):
        out.append(text[end:piece.start()])
        if "\n\n" in text[max(0, end - 1):piece.start()] and not block:
            first = ""
        end = piece.end()
        name = piece["name"] or piece["word"] or piece["type"]
        if piece["block"]:
            block, first = piece["block"], ""
            after = PIECE.match(text, end)
            if not after or not (after["name"] or after["word"] or after["type"]):
                out.append(comment(block, []))
                block = None
        elif piece["note"]:
            out.append(comment(piece["note"], [], "@file\n", 2))
        elif not name or name.startswith("KQ_PRIVATE"):
            out.append(piece[0])
        else:
            twin = first or known.get(SUFFIX.sub("", name), "")
            if block:
                out.append(comment(*whole(block, names_of(piece), SUFFIX.sub("", name), rows)))
                first = name
            elif twin:
                verb = "As" if SUFFIX.sub("", name) == SUFFIX.sub("", twin) else "See"
                out.append(f"/** {verb} {twin}{'()' if piece['function'] else ''}. */\n")
            known.setdefault(SUFFIX.sub("", name), name if block else twin)
            shown = block or twin or not piece["struct"]
            out.append((fields(piece[0]) if piece["struct"] else piece[0]) if shown else f"/** @cond */\n{piece[0]}\n/** @endcond */")
            block = None
    return "".join([*out, text[end:]])


if __name__ == "__main__":
    FUNCTIONS.update(functions(Path(sys.argv[1]).parent))
    print(made(Path(sys.argv[1]).read_text(encoding="utf-8")))
