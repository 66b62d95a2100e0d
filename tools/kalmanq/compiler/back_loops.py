"""The step back of `back` as loops over small arrays: a few hundred bytes of code for any number of states.

A column of [x; x+] is 2 n numbers: v has the part of x of column c in its row 2 c and the part of x+ in row 2 c + 1.
Once x+ is taken out, rows 2 c + 1 are free for C U.  Columns of noise are not among them: rotations start from them.
"""

from __future__ import annotations

from typing import Sequence

from kalmanq.compiler import ud
from kalmanq.compiler.emit import function
from kalmanq.compiler.equations import EquationFilter
from kalmanq.compiler.floats import Mean
from kalmanq.compiler.printing import Body, Target
from kalmanq.formulas.graph import Node, constant, symbol


def lines(a: EquationFilter, off: Sequence[Node], refused: Sequence[str]) -> tuple[list[str], list[list[str]]]:
    """Those of the step back of f to the record r, over locals x0, l0, ... of the record; and the functions that they call"""
    n, type_, body = a.of.n, a.type, Body(a.words)
    A = [part for row in a.coefficients.A for part in row]
    body.lines += a.unless_finite_step(body, refused)
    body.name_shared([*A, *off, *_noise(a)])
    made = [
        *body.lines,
        f"const {type_} A[{n * n}] = {{{', '.join(map(body.text, A))}}};",
        f"{type_} d[{n}] = {{{', '.join(map(body.text, off))}}}; /* of the next instant, beside what was predicted */",
        f"{type_} ahead[{2 * n * n}] = {{{', '.join(map(body.text, _noise(a)))}}};",
        f"{type_} U[{n * n}], v[{2 * n * n}], w[{2 * n}];",
        *_joint(a), f"triangular(v, w, {n}, {2 * n}, {n}, ahead); /* row c: C U and U of what was predicted, column c */",
        *_mean(a), "if (!is_whole) return;", *_crossed(a), f"triangular(v, w, {2 * n}, {n}, 0, U);", "pack(U, f->P);"]
    return made, [_unpack(a), _pack(a), _triangular(a)]


def written(mean: Mean) -> list[Target]:
    return [(f"f->{name}[{i}]", one) for i, both in enumerate(mean) for name, one in zip(("x", "low"), both)]


def stack(a: EquationFilter) -> int:
    """Bytes of its arrays"""
    return (4 if a.type == "float" else 8) * (6 * a.of.n**2 + 3 * a.of.n)


def _noise(a: EquationFilter) -> list[Node]:
    """Row c: 0 in the part of x, then the noise's column of state c, with its weight in the place of its 1"""
    n, zero = a.of.n, constant(0)
    made = [[zero] * (2 * n) for _ in range(n)]
    for column in ud.by_state(a.coefficients.noise(), a.form, n):
        c = max(i for i, one in enumerate(column.entries) if not one.equals(0))
        made[c] = [zero] * n + [column.weight if i == c else one for i, one in enumerate(column.entries)]
    return [one for row in made for one in row]


def _joint(a: EquationFilter) -> list[str]:
    """v and w from the record and A"""
    n, type_, zero = a.of.n, a.type, a.number(0)
    return [
        "unpack(r->P, U);", f"for (int c = 0; c < {n}; c++) {{", f"    {type_} *const to = v + {2 * n} * c, *const column = U + {n} * c;",
        "    w[c] = column[c];", f"    column[c] = {a.number(1)};", f"    for (int i = 0; i < {n}; i++) {{",
        f"        {type_} sum = {zero};", f"        for (int k = 0; k <= c; k++) sum += A[{n} * i + k] * column[k];",
        f"        to[i] = i <= c ? column[i] : {zero};", f"        to[{n} + i] = sum;", "    }", "}"]


def _mean(a: EquationFilter) -> list[str]:
    """C d, and the mean from the record's"""
    n = a.of.n
    solved = [f"for (int c = {n - 1}; c > 0; c--)", f"    for (int i = 0; i < c; i++) d[i] -= ahead[{2 * n} * c + {n} + i] * d[c];"]
    if a.given.nominal:
        sums = [f"const {a.type} c{i} = {' + '.join(f'ahead[{2 * n * c + i}] * d[{c}]' for c in range(n))};" for i in range(n)]
        return [*solved, *sums, *Body(a.words, stem="s").assign(written(a.moved_by([symbol(f"c{i}") for i in range(n)])))]
    return [
        *solved, f"for (int i = 0; i < {n}; i++) {{", f"    {a.type} change = r->low[i];",
        f"    for (int c = 0; c < {n}; c++) change += ahead[{2 * n} * c + i] * d[c];",
        f"    const {a.type} mean = r->x[i] + change;", "    f->x[i] = mean;", "    f->low[i] = change - (mean - r->x[i]);", "}"]


def _crossed(a: EquationFilter) -> list[str]:
    """v and w: what is left, and C times the columns of f; U: 0"""
    n, type_ = a.of.n, a.type
    return [
        "unpack(f->P, U);", f"for (int c = {n - 1}; c >= 0; c--) {{",
        f"    {type_} *const to = v + {2 * n} * c + {n}, *const column = U + {n} * c;", "    w[2 * c] = w[c];",
        "    w[2 * c + 1] = column[c];", f"    column[c] = {a.number(1)};", "    for (int k = c; k > 0; k--)",
        f"        for (int i = 0; i < k; i++) column[i] -= ahead[{2 * n} * k + {n} + i] * column[k];",
        f"    for (int i = 0; i < {n}; i++) {{", f"        {type_} sum = {a.number(0)};",
        f"        for (int k = 0; k <= c; k++) sum += ahead[{2 * n} * k + i] * column[k];", "        to[i] = sum;", "    }", "}",
        f"for (int k = 0; k < {n * n}; k++) U[k] = {a.number(0)};"]


def _triangular(a: EquationFilter) -> list[str]:
    type_, zero, one = a.type, a.number(0), a.number(1)
    rotates = [
        f"if (d > {zero}) {{", "    for (int k = 0; k < count; k++) {", f"        {type_} *const to = v + k * size;",
        f"        const {type_} part = to[row], share = w[k] * part, total = d + share * part;",
        f"        if (share == {zero}) continue;", f"        const {type_} inverse = {one} / total, turn = share * inverse;",
        "        w[k] *= d * inverse;", "        d = total;", "        for (int i = 0; i < row; i++) {",
        "            to[i] -= part * u[i];", "            u[i] += turn * to[i];", "        }", "    }"]
    projects = [
        "} else {", "    for (int k = 0; k < count; k++) {", f"        const {type_} *const from = v + k * size;",
        f"        const {type_} share = w[k] * from[row];", f"        if (share == {zero}) continue;",
        "        d += share * from[row];", "        for (int i = 0; i < row; i++) u[i] += share * from[i];", "    }",
        f"    const {type_} inverse = d < {a.number(a.form.least)} ? {zero} : {one} / d;",
        "    for (int i = 0; i < row; i++) u[i] *= inverse;", "    for (int k = 0; k < count; k++) {",
        f"        {type_} *const to = v + k * size;", f"        const {type_} part = to[row];",
        "        for (int i = 0; i < row; i++) to[i] -= part * u[i];", "    }", "}"]
    return function(
        f"static void triangular({type_} *restrict v, {type_} *restrict w, int count, int size, int first, {type_} *restrict U)", [
            "for (int row = size - 1; row >= first; row--) {", f"    {type_} *const u = U + (row - first) * size;",
            f"    {type_} d = u[row];", *(f"    {line}" for line in [*rotates, *projects, "u[row] = d;"]), "}"],
        "U, with D on its diagonal, of columns v with weights w; a row of U that begins with a D is a column of noise")


def _unpack(a: EquationFilter) -> list[str]:
    place, constants = a.places_of_entries()
    n, made, value = a.of.n, [], "P[k]"
    if place != list(range(len(place))):
        made, value = [f"static const uint8_t place[{len(place)}] = {{{', '.join(map(str, place))}}};"], "P[place[k]]"
    if constants:
        made.append(f"static const {a.type} constants[{len(constants)}] = {{{', '.join(map(a.number, constants))}}};")
        value = f"place[k] < {len(a.live)} ? P[place[k]] : constants[place[k] - {len(a.live)}]"
    return function(f"static void unpack(const {a.type} *restrict P, {a.type} *restrict U)", [
        *made, f"for (int j = 0, k = 0; j < {n}; j++)", f"    for (int i = 0; i <= j; i++, k++) U[{n} * j + i] = {value};"])


def _pack(a: EquationFilter) -> list[str]:
    n = a.of.n
    if a.live == ud.keys(n):
        return function(f"static void pack(const {a.type} *restrict U, {a.type} *restrict P)", [
            f"for (int j = 0, k = 0; j < {n}; j++)", f"    for (int i = 0; i <= j; i++) P[k++] = U[{n} * j + i];"])
    entries = ", ".join(str(n * j + i) for i, j in a.live)
    return function(f"static void pack(const {a.type} *restrict U, {a.type} *restrict P)", [
        f"static const uint{8 if n < 16 else 16}_t entries[{len(a.live)}] = {{{entries}}};",
        f"for (int k = 0; k < {len(a.live)}; k++) P[k] = U[entries[k]];"])
