"""NAME_test.c: a program that ends with OK where a filter, on any core, does what it did on the host."""

from __future__ import annotations

from typing import Optional, Sequence

import numpy as np

from kalmanq.compiler.exact import Settled
from kalmanq.compiler.proven.header import comment
from kalmanq.compiler.printing import indented
from kalmanq.compiler.proven.plan import Plan
from kalmanq.compiler.proven.search import Track

ROWS = 40
LONGEST_PUSH = 256  # rows of the worst input
REACHED = 0.9  # of its bound, by the worst input in so many rows
FLOAT_ROOM = 8  # times the error of a record, that two contractions may differ


def trial(plan: Plan, track: Track, error: float, worst: Optional[Worst]) -> str:
    """track: of ROWS rows, printed; error: of a mean, in sigma"""
    ends = "; then the worst input keeps within its words." if worst else "."
    lines = [*comment(plan, [f"{plan.name}_test: {ROWS} rows come to the words that they came to on the host; then the "
                             "covariance settles", f"to its constants{ends}"]),
             "#include <stdio.h>", "", f'#include "{plan.name}.h"', "", *rows_of(plan, track), *near(plan, error)]
    lines += compares(plan, track) + (settles(plan) if plan.carries_covariance else [])
    if worst:
        lines += worst.lines(plan)
    tests = ["as_on_the_host", *(["settles"] if plan.carries_covariance else []), *(["keeps_within"] if worst else [])]
    lines += ["int main(void)", "{", *indented([
        f"const int wrong = {' + '.join(f'{test}()' for test in tests)};",
        f'printf("{plan.name}: %d wrong\\n", wrong);', 'if (wrong == 0) puts("OK");', "return wrong != 0;"]), "}", ""]
    return "\n".join(lines)


def literal(plan: Plan, word: str) -> str:
    if not plan.subject.words.is_fixed:
        return f"{word}f"
    return f"INT64_C({word})" if abs(int(word)) >= 1 << 31 else word


def mean_fields(plan: Plan) -> list[tuple[str, str]]:
    return [one for i in range(plan.subject.of.n) for one in plan.subject.mean.fields(i)]


def rows_of(plan: Plan, track: Track) -> list[str]:
    """A table of what is given and what comes of it."""
    s, fields = plan.subject, mean_fields(plan)
    lines = []
    for line in track.lines:
        (present,), u, z, words = (part.split() for part in line.split("|"))
        cells = [present if plan.partial else str(int(present == "0")),
                 *([f"{{{', '.join(literal(plan, word) for word in u)}}}"] if s.of.l else []),
                 f"{{{', '.join(literal(plan, word) for word in z)}}}",
                 f"{{{', '.join(literal(plan, word) for word in words[:len(fields)])}}}"]
        lines.append(f"{{{', '.join(cells)}}},")
    controls = [f"{s.words.type} u[{s.of.l}];"] if s.of.l else []
    which = "present" if plan.partial else "is_missing"
    return ["static const struct {", *indented([f"unsigned char {which};", *controls,
                                                f"{s.words.type} z[{s.of.m}];",
                                                f"{fields[0][1]} mean[{len(fields)}];"]), f"}} rows[{len(lines)}] = {{",
            *indented(lines), "};", ""]


def near(plan: Plan, error: float) -> list[str]:
    if plan.subject.words.is_fixed:
        return []
    return [f"/* Within {FLOAT_ROOM * error:.0e} sigma: a core may fuse products where another rounds them. */",
            "static int is_near(float difference, float variance)", "{",
            f"    return difference * difference <= {FLOAT_ROOM * error:.0e}f * {FLOAT_ROOM * error:.0e}f * variance;",
            "}", ""]


def compares(plan: Plan, track: Track) -> list[str]:
    s, name = plan.subject, plan.name
    u = ", rows[t].u" if s.of.l else ""
    fields, differences = [field for field, _ in mean_fields(plan)], []
    for i in range(s.of.n):
        if s.words.is_fixed:
            differences.append(f"wrong += f.{fields[i]} != rows[t].mean[{i}];")
        else:
            high, low = fields[2 * i:2 * i + 2]
            variance = f"{name}_variance_{s.states[i]}(&f)" if plan.carries_covariance else \
                f"{float(plan.settled.filtered[i, i]):.9g}f"
            apart = f"(f.{high} - rows[t].mean[{2 * i}]) + (f.{low} - rows[t].mean[{2 * i + 1}])"
            differences.append(f"wrong += !is_near({apart}, {variance});")
    other = [f"else {name}_step_some(&f{u}, rows[t].z, rows[t].present);"] if plan.partial else \
        [f"else if (rows[t].is_missing) {name}_predict(&f{u});", f"else {name}_step(&f{u}, rows[t].z);"]
    return ["static int as_on_the_host(void)", "{", *indented([
        f"{plan.type} f;", "int wrong = 0;", f"{name}_start(&f);",
        f"for (unsigned t = 0; t < {len(track.lines)}; t++) {{", *indented([
            f"if (t == 0) {name}_update(&f, rows[t].z);", *other, *differences]), "}",
        "return wrong + (f.events != 0);"]), "}", ""]


def settles(plan: Plan) -> list[str]:
    s, name = plan.subject, plan.name
    values = plan.form.values(plan.settled.filtered)
    same = [f"wrong += !(f.{plan.field(key)} <= {value} && f.{plan.field(key)} >= {value});"
            for key in plan.structure.carried
            for value in [s.words.constant(values[key], plan.form.word(s, key))]]
    u = ", rows[0].u" if s.of.l else ""
    return ["/* In two calls and in one */", "static int settles(void)", "{", *indented([
        f"{plan.type} f, g;", "int wrong = 0;", f"{name}_start(&f);", f"{name}_update(&f, rows[0].z);", "g = f;",
        f"for (unsigned t = 0; t < {plan.rows}; t++) {{", *indented([
            f"{name}_step(&f{u}, rows[0].z);", f"{name}_predict(&g{u});", f"{name}_update(&g, rows[0].z);"]), "}",
        f"wrong += f.rows != {plan.rows} || g.rows != {plan.rows};", *same,
        *[line.replace("f.", "g.") for line in same], "return wrong;"]), "}", ""]


# ------------------------------------------------------------------------------ the worst input


class Worst:
    """Measurements at the ends of their ranges that drive one state of a settled filter farthest."""

    def __init__(self, plan: Plan, settled: Settled, ranges: Sequence[float]):
        d, K = plan.subject.of.doubles(), settled.gain.astype(float)
        closed, columns = (np.eye(len(K)) - K @ d.H) @ d.A, []
        term = K * np.array(ranges)
        for _ in range(LONGEST_PUSH):
            columns.append(term)
            term = closed @ term
        whole = np.abs(np.array(columns)).sum(axis=(0, 2))  # of each state
        room = [bound / reached for bound, reached in zip(plan.bounds, whole)]
        self.state = int(np.argmin(np.round(room, 6)))
        self.signs = np.sign(np.array(columns)[::-1, self.state, :]).astype(int)  # LONGEST_PUSH x m, first row first
        self.reached = float(whole[self.state])
        self.bound = float(plan.bounds[self.state])

    def lines(self, plan: Plan) -> list[str]:
        s, name = plan.subject, plan.name
        signs = [", ".join(str(sign) for sign in row) for row in self.signs]
        scale = 2.0**plan.fraction("states", self.state)
        least, most = int(REACHED * self.reached * scale), int(min(self.bound * scale, 2**31 - 1))
        none = f"static const {s.words.type} none[{max(s.of.l, s.of.m)}] = {{0}};"
        u = ", none" if s.of.l else ""
        ends = ", ".join(str(plan.doors[j] or 0) for j in range(s.of.m))
        return [f"/* Drives {s.states[self.state]} to {self.reached:.4g}; no input within the ranges, no gap drives it "
                f"beyond {self.bound:.4g}. */", f"static const signed char signs[{len(signs)}][{s.of.m}] = {{",
                *indented([f"{{{row}}}," for row in signs]), "};", "", "static int keeps_within(void)", "{", *indented([
                    none, f"static const {s.words.type} ends[{s.of.m}] = {{{ends}}};", f"{plan.type} f;",
                    f"{name}_start(&f);", f"{name}_update(&f, none);",
                    f"for (unsigned t = 0; t < {2 * plan.rows}; t++) {name}_step(&f{u}, none);",
                    f"for (unsigned t = 0; t < {len(signs)}; t++) {{", *indented([
                        f"{s.words.type} z[{s.of.m}];",
                        *(f"z[{j}] = signs[t][{j}] < 0 ? -ends[{j}] : signs[t][{j}] > 0 ? ends[{j}] : 0;"
                          for j in range(s.of.m)), f"{name}_step(&f{u}, z);"]), "}",
                    f"const int32_t reached = {name}_mean_{s.states[self.state]}(&f);",
                    f"return !(reached >= {least} && reached <= {most}) + (f.events != 0);"]), "}", ""]
