#!/usr/bin/env python3
"""Checks the manual in the public headers: manual.py [ROOT].

A comment /** */ is of the functions that follow it up to an empty line; a function of another arithmetic has that of its
twin, too, and "As kq_..." brings the comment of that function.  Of every function:
  - each parameter has a line: name, two spaces, what it is
  - each status that its code in src/ can answer is named, or the function whose errors they are
  - each event that its code can set is named
Answers 0 where that holds; prints each fault.  And as advice: several parameters share a line only to say where they are described;
results that are no status say what they are for a bad argument; what the code has a loop for has a cost.
"""
import pathlib
import re
import sys

SUFFIX = re.compile(r"_(f32|f64|q31)$")
PIECE = re.compile(r"(?P<block>/\*\*(?!<).*?\*/)|(?P<note>/\*.*?\*/)|(?P<macro>^#(?:[^\n]*\\\n)*[^\n]*)|"
                   r"(?P<type>^(?:typedef|extern(?! .C)|struct)\b[^;{]*(?:\{[^}]*(?:\{[^}]*\}[^}]*)*\})?[^;{}]*;)|"
                   r"(?P<function>^[^\n;{}/#]*?\b(?P<name>kq_\w+)\((?P<list>[^;{}()]*)\);)", re.M | re.S)
CODE = re.compile(r"^(?!#|extern|\s)([^\n;={}]*?)\b(?:T\((\w+)\)|(\w+))\([^;{}]*?\)\s*\{(?: ([^\n]*)\}$|\n(.*?)^\})", re.M | re.S)
ROW = re.compile(r"^ \*   ((?:\w+|\.\.\.)(?:, \w+)*) {2,}(.*(?:\n \*     +.*)*)", re.M)
KEEPS_EVENTS = re.compile(r"^kq_(filter|history|lag|instant|diffuse|least_squares|steady)_\w+ \*", re.M)
# Statuses that the code of a function names and the function does not answer: EM fits its own filter; a check only asks if there is
# memory
INSIDE = {"kq_em_advance": {"KQ_ERR_MISMATCH"}, "kq_em_iterate": {"KQ_ERR_MISMATCH"},
          "kq_steady_solve": {"KQ_ERR_SIZE"},
          "kq_em_maximise": {"KQ_ERR_NOT_FINITE", "KQ_ERR_NOT_SEMIDEFINITE", "KQ_ERR_NOT_SYMMETRIC"}}
FAILURE = re.compile(r"\b(bad|NULL|never|does not exist|out of)\b")


class Function:
    def __init__(self, header, name, parameters, block):
        self.header, self.name, self.block = header, name, block or ""
        self.stem, self.arithmetic = SUFFIX.sub("", name), (SUFFIX.findall(name) or [""])[0]
        self.keeps_events = bool(KEEPS_EVENTS.search(re.sub(r",\s*", "\n", parameters)))
        self.parameters = [re.search(r"(\w+)(?:\[\w*\])?$", one).group(1) for one in re.split(r",\s*", parameters) if one != "void"]


def functions(header):
    """The public functions of a header, each with its comment"""
    text, block, end = header.read_text(encoding="utf-8"), None, 0
    for piece in PIECE.finditer(text):
        if "\n\n" in text[end:piece.start()]:
            block = None
        end = piece.end()
        if piece["function"]:
            answers = piece["function"].split(piece["name"])[0].split()
            made = Function(header.name, piece["name"], " ".join(piece["list"].split()), block)
            made.answers = "status" if "kq_status" in answers else "nothing" if answers[-1] == "void" else "value"
            yield made
        else:
            block = piece["block"]


class Manual:
    def __init__(self, root):
        self.functions = [one for header in sorted((root / "include/kalmanq").glob("*.h")) for one in functions(header)]
        self.code = {"q31": code(root, "_float.h"), "f32": code(root, "_q31.h")}
        self.code["f64"] = self.code["f32"]
        self.faults, self.advice, self.comments = [], [], {}
        for one in self.functions:
            if one.block and one.block not in self.comments.setdefault(one.stem, []):
                self.comments[one.stem].append(one.block)

    def blocks(self, stem):
        """The comments of a function in every arithmetic"""
        return self.comments.get(stem, [])

    def said(self, stem, wanted, seen=()):
        """The comments of a function, and of those that they refer to in sentences with a word of `wanted`, rows left out"""
        texts = self.blocks(stem)
        for sentence in re.split(r"(?<=\.)\s+", re.sub(r"\n \* ", " ", ROW.sub("", "\n\n".join(texts)))):
            if "kq_" in sentence and re.search(wanted, sentence):
                for other in {SUFFIX.sub("", one) for one in re.findall(r"\bkq_\w+", sentence)} - {stem, *seen}:
                    texts = texts + self.said(other, wanted, (stem, *seen))
        return texts

    def check(self):
        for one in self.functions:
            if not self.blocks(one.stem):
                self.fault(one, "has no comment")
                continue
            self.check_parameters(one)
            self.check_rows(one)
            self.check_result(one)
            self.check_work(one)

    def fault(self, function, what):
        self.faults.append(f"{function.header}: {function.name}: {what}")

    def advise(self, function, what):
        self.advice.append(f"{function.header}: {function.name}: {what}")

    def check_parameters(self, one):
        rows = [(names.split(", "), text) for block in self.said(one.stem, r"\bAs\b") for names, text in ROW.findall(block)]
        for name in one.parameters:
            mine = [(names, text) for names, text in rows if name in names]
            if not mine:
                self.fault(one, f"no line for {name}")
            elif all(len(names) > 1 and not re.search(r"as (in|for|by|of) kq_", text) for names, text in mine):
                self.advise(one, f"{name} shares a line with {', '.join(x for x in mine[0][0] if x != name)}")

    def check_rows(self, one):
        """A row is of a parameter of one of the functions that follow"""
        names = {name for other in self.functions if other.block == one.block for name in other.parameters}
        for row, _ in ROW.findall(one.block):
            for name in set(row.split(", ")) - names:
                self.advise(one, f"has no parameter {name}")

    def check_result(self, one):
        text = "\n".join(self.said(one.stem, r"[Ee]rrors?\b|\b[Aa]s\b|answers"))
        for status in sorted(self.reached(one, "KQ_ERR_") - INSIDE.get(one.stem, set())):
            if not re.search(rf"\b{status}\b", text):
                self.fault(one, f"does not name {status}")
        if one.answers == "value" and not FAILURE.search("\n".join(self.blocks(one.stem))):
            self.advise(one, "does not say what a bad argument gives")

    def check_work(self, one):
        text = "\n".join(self.said(one.stem, r"\b[Ee]vents?\b|\b[Aa]s\b|\bone\b"))
        for event in sorted(self.reached(one, "KQ_EVENT_")) if one.keeps_events else ():
            if not re.search(rf"\b{event}\b", text):
                self.fault(one, f"does not name {event}")
        cost = "\n".join(self.said(one.stem, r"\b[Aa]s\b|[Cc]ost\b"))
        if "for" in self.reached(one, "for") and not re.search(r"\b[Cc]osts?\b|multiplications|additions", cost):
            self.advise(one, "does not say what it costs")

    def reached(self, one, beginning):
        """What the code of a function, and the functions that it calls by name, have of words of a beginning.  A status comes
        from those that answer one."""
        code, seen, todo = self.code.get(one.arithmetic, {}), set(), [one.stem]
        while todo:
            name = todo.pop()
            if name in code and name not in seen and (code[name][0] or beginning != "KQ_ERR_"):
                seen.add(name)
                todo += code[name][1] & code.keys()
        return {word for name in seen for word in code[name][1] if word.startswith(beginning)}


def code(root, twin):
    """Of each function of src/, without the twins of the other arithmetic: does it answer a status, and its words"""
    found = {}
    for path in sorted((root / "src").glob("*/*.h")):
        if not path.name.endswith(twin) and path.parent.name != "fixed_size":
            for answers, public, name, line, lines in CODE.findall(re.sub(r"/\*.*?\*/", "", path.read_text(encoding="utf-8"), flags=re.S)):
                found[public or SUFFIX.sub("", name)] = ("kq_status" in answers, set(re.findall(r"\w+", line or lines)))
    return found


def main():
    manual = Manual(pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parents[2]))
    manual.check()
    print(*(f"advice: {one}" for one in manual.advice), *manual.faults, sep="\n")
    print(f"{len(manual.functions)} functions, {sum(len(one.parameters) for one in manual.functions)} parameters, {len(manual.faults)} faults")
    return bool(manual.faults) or not manual.functions


if __name__ == "__main__":
    sys.exit(main())
