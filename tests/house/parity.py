#!/usr/bin/env python3
"""Is the table of src/README.md, which public function is in which arithmetic, right by the headers?  And does the suite
full_size call every public function?

    parity.py [ROOT]

Answers 0 where it is; prints each difference.
"""
import pathlib
import re
import sys

FLOATING, FIXED = {"f32", "f64"}, {"q31"}
EVERY = FLOATING | FIXED


def declared(header):
    """The arithmetics of each function of a header"""
    text = re.sub(r"/\*.*?\*/", "", header.read_text(encoding="utf-8"), flags=re.S)
    text = re.sub(r"\btypedef\b[^;{]*;", "", text)
    text = re.sub(r"^[ \t]*#(?:.*\\\n)*.*", "", text, flags=re.M)
    functions = {}
    for name, arithmetic in re.findall(r"\b(kq_\w+)_(f32|f64|q31)\(", text):
        functions.setdefault(name, set()).add(arithmetic)
    return functions


def table(page):
    """The rows of the table: headers, and the two cells of names"""
    section = page.split("## What is in which arithmetic")[1].split("\n## ")[0]
    for line in section.splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if line.startswith("| `"):
            yield re.findall(r"`(\w+\.h)`", cells[0]), cells[1], cells[2]


def named(cell, functions):
    if cell == "all":
        return set(functions)
    return set() if cell == "none" else set(re.findall(r"`(\w+)`", cell))


def differences(header, functions, floating, fixed):
    for name, arithmetics in functions.items():
        said = FLOATING if name in floating else FIXED if name in fixed else EVERY
        if arithmetics != said:
            yield f"{header}: {name} is in {', '.join(sorted(arithmetics))}, not in {', '.join(sorted(said))}"
    for name in sorted((floating | fixed) - set(functions)):
        yield f"{header}: {name} is not there"


def called_at_full_size(root):
    """The functions that test_full_size.c calls, itself or by the helpers of all unit tests' models"""
    names = ("test_full_size.c", "models.h", "models_float.h", "models_q31.h", "q31.h", "views.h")
    text = "".join((root / "tests/unit" / name).read_text(encoding="utf-8") for name in names)
    return {f"kq_{name}" for name in re.findall(r"\b[SK]\((\w+)\)\(", text)} | set(re.findall(r"\b(kq_\w+?)_(?:q31|##T)\(", text))


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parents[2])
    headers = {path.name: declared(path) for path in sorted((root / "include/kalmanq").glob("*.h"))}
    headers = {name: functions for name, functions in headers.items() if functions}
    faults, seen = [], []
    for names, floating, fixed in table((root / "src/README.md").read_text(encoding="utf-8")):
        for header in names:
            functions = headers.get(header, {})
            seen.append(header)
            faults += differences(header, functions, named(floating, functions), named(fixed, functions))
    faults += [f"{header}: is in {seen.count(header)} rows" for header in sorted(headers | dict.fromkeys(seen))
               if seen.count(header) != 1 or header not in headers]
    called = called_at_full_size(root)
    faults += [f"{header}: {name} is not called by the suite full_size" for header, functions in headers.items()
               for name in sorted(functions) if name not in called]
    for fault in faults:
        print(fault)
    count = sum(map(len, headers.values()))
    print(f"{count} functions in {len(headers)} headers, {len(faults)} differences")
    return bool(faults) or count == 0


if __name__ == "__main__":
    sys.exit(main())
