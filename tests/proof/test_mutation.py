#!/usr/bin/env python3
"""The machinery of mutation.py on a small program: every kind is found and dies, what is equivalent survives, and rows of survivors
that nothing needs fail."""

import contextlib
import io
import subprocess
import sys
import tempfile
from pathlib import Path

import mutation
from mutants import KINDS, Finder, instrumented, key_of, numbered, sample

SOURCE = """
#define TWICE(x) (2 * (x))
#define SAME(x) (x)
enum { LENGTH = 4 };
static int refuses(int n, int m) { if (n < 1 || m > 9) return 1; return 0; }
static int power(int n, int m) { int p = 1; while (m-- > 0) p *= n; return p; }
static int largest(int n, int m) { return n >= m ? n : m; }
int answer(int n, int m)
{
    static const int start = 7;
    int word[LENGTH + 1] = {0}, k;
    if (refuses(n, m)) return -1;
    for (k = 0; k < LENGTH; k++) word[k] = SAME(power(k, m) + n);
    if (m == 3) word[1] = start; else word[2] += 1;
    switch (m) { case 9 - 1: return TWICE(word[3]); }
    if (m < -LENGTH) word[0] = 0;
    return largest(word[1] + word[2] + word[LENGTH], m);
}
"""
TEST = """
int answer(int n, int m);
int main(void)
{
    return answer(0, 1) != -1 || answer(1, 10) != -1 || answer(2, 3) != 17 || answer(1, 9) != 516 || answer(1, 0) != 5 ||
           answer(1, 8) != 13124 || answer(1, 1) != 6;
}
"""
DIE = ("int.h | refuses | comparison | n < 1 => n <= 1", "int.h | refuses | logical | n < 1 || m > 9 => n < 1 && m > 9",
       "int.h | power | removed statement | p *= n; => ;", "int.h | answer | swapped arguments | power(k, m) => power(m, k)",
       "int.h | answer | removed guard | refuses(n, m) => 0 && (refuses(n, m))", "int.h | answer | operator | power(k, m) + n => power(k, m) - n",
       "int.h | answer | constant | 1 => 1 + 1", "int.h | answer | negated condition | m == 3 => !(m == 3)")
LIVE = {"int.h | largest | comparison | n >= m => n > m": "survived", "int.h | answer | removed statement | word[0] = 0; => ;": "not reached"}


def program(folder, text, of):
    (folder / "unit.c").write_text(mutation.CHOICE + instrumented(text, of) + TEST + mutation.RUNTIME.replace("COUNT", str(len(of))))
    subprocess.run(["cc", "-std=c11", "-w", "-o", folder / "unit", folder / "unit.c"], check=True)
    return mutation.Suite("unit", [str(folder / "unit")])


def found_in(folder, text):
    (folder / "int.h").write_text(text)
    finder = Finder(folder)
    finder.parse('#include "int.h"\n', [f"-I{folder}"])
    assert finder.left_out["label"] == finder.left_out["static initialiser"] == finder.left_out["size of an array"] == 1, finder.left_out
    return finder.found


def check_ends(folder):
    found = found_in(folder, SOURCE)
    assert {one.kind for one in found.values()} == set(KINDS)
    assert not any("TWICE" in one.new and one.kind == "operator" for one in found.values())
    chosen = list(numbered(found))
    suite = program(folder, SOURCE, list(enumerate(chosen)))
    ends = {key_of(one): mutation.end_of(number, [suite]) for number, one in enumerate(chosen)}
    for key in DIE:
        assert ends[key] == "unit", (key, ends[key])
    for key, end in LIVE.items():
        assert ends[key] == end, (key, ends[key])
    return chosen, ends


def check_sample(folder):
    """Text that is added elsewhere moves no other mutant out of the sample or into it."""
    def names(text):
        return {key_of(one) for one in sample(found_in(folder, text), 80, 1)}
    added = SOURCE.replace("int answer", "\n\nstatic int unused(int n) { return n + n; }\nint answer", 1)
    assert {key for key in names(added) if "unused" not in key} <= names(SOURCE)


def check_report(chosen, ends):
    """Each survivor needs its row, each row its survivor, and gaps are counted."""
    alive = [key for key, end in ends.items() if end != "unit"]
    rows = {key: "equivalent: it is" for key in alive}
    assert not mutation.report(chosen, ends, rows, True)
    assert mutation.report(chosen, ends, dict(list(rows.items())[1:]), True)
    assert mutation.report(chosen, ends, {**rows, DIE[0]: "equivalent: it is not"}, False)
    assert mutation.report(chosen, ends, {**rows, "int.h | gone | operator | a => b": "slack: it was"}, True)
    assert mutation.report(chosen, ends, {key: "gap: open" for key in alive}, True)


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name).resolve()
        chosen, ends = check_ends(folder)
        check_sample(folder)
        with contextlib.redirect_stdout(io.StringIO()):
            check_report(chosen, ends)
    print(f"OK: {len(chosen)} mutants, {sum(end == 'unit' for end in ends.values())} killed")


if __name__ == "__main__":
    sys.exit(main())
