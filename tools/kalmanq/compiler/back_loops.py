"""The step back of `back` as loops over small arrays: a few hundred bytes, whatever the number of states.

A column of [x; x+] is 2 n numbers: so v has the part of x of column c in its row 2 c and the part of x+ in row 2 c + 1.
Once x+ is taken out, rows 2 c + 1 are free for C U.
"""

from __future__ import annotations

from typing import Sequence

from kalmanq.compiler import ud
from kalmanq.compiler.emit import function
from kalmanq.compiler.equations import EquationFilter
from kalmanq.compiler.printing import Body
from kalmanq.formulas.graph import Node


def lines(a: EquationFilter, off: Sequence[Node], refused: Sequence[str]) -> tuple[list[str], list[list[str]]]:
    """Those of the step back of f to the record r, over locals x0, l0, ... of the record; and the functions that they call"""
    n, type_, zero, one, body = a.of.n, a.type, a.number(0), a.number(1), Body(a.words)
    noise, A = a.coefficients.noise(), [part for row in a.coefficients.A for part in row]
    q, all_ = len(noise), n + len(noise)
    body.lines += a.unless_finite_step(body, refused)
    body.name_shared([*A, *off])
    G = ", ".join(body.text(part) for column in noise for part in column.entries)
    made = [
        *body.lines, f"const {type_} A[{n * n}] = {{{', '.join(map(body.text, A))}}};",
        f"{type_} d[{n}] = {{{', '.join(map(body.text, off))}}}; /* of the next instant, beside what was predicted */",
        f"{type_} U[{n * n}], v[{2 * all_ * n}], w[{n + all_}], ahead[{2 * n * n}];",
        "unpack(r->P, U);",
        f"for (int c = 0; c < {n}; c++) {{",
        f"    {type_} *const to = v + {2 * n} * c, *const column = U + {n} * c;",
        "    w[c] = column[c];", f"    column[c] = {one};",
        f"    for (int i = 0; i < {n}; i++) {{",
        f"        to[i] = i <= c ? column[i] : {zero};", f"        {type_} sum = {zero};",
        f"        for (int k = 0; k <= c; k++) sum += A[{n} * i + k] * column[k];", f"        to[{n} + i] = sum;", "    }", "}"]
    if noise:
        made += [
            f"static const {type_} G[{q * n}] = {{{G}}}, q[{q}] = {{{', '.join(body.text(part.weight) for part in noise)}}};",
            f"for (int c = 0; c < {q}; c++) {{", f"    w[{n} + c] = q[c];", f"    for (int i = 0; i < {n}; i++) {{",
            f"        v[{2 * n} * ({n} + c) + i] = {zero};", f"        v[{2 * n} * ({n} + c) + {n} + i] = G[{n} * c + i];",
            "    }", "}"]
    made += [
        f"triangular(v, w, {all_}, {2 * n}, {n}, ahead); /* row c of ahead: C U and U of what was predicted, column c */",
        f"for (int c = {n - 1}; c > 0; c--)", f"    for (int i = 0; i < c; i++) d[i] -= ahead[{2 * n} * c + {n} + i] * d[c];",
        f"for (int i = 0; i < {n}; i++) {{", f"    {type_} change = r->low[i];",
        f"    for (int c = 0; c < {n}; c++) change += ahead[{2 * n} * c + i] * d[c];",
        f"    const {type_} mean = r->x[i] + change;", "    f->x[i] = mean;", "    f->low[i] = change - (mean - r->x[i]);", "}",
        "if (!is_whole) return;"]
    if q > 1:
        made.append(f"for (int k = {n}; k < {q * n}; k++) v[{2 * n * n} + k] = v[{2 * n * n} + k + k / {n} * {n}];")
    made += [
        f"for (int c = {q - 1}; c >= 0; c--) w[{2 * n} + c] = w[{n} + c];" if q else "",
        f"for (int c = {n - 1}; c >= 0; c--) w[2 * c] = w[c];",
        "unpack(f->P, U);",
        f"for (int c = 0; c < {n}; c++) {{",
        f"    {type_} *const to = v + {2 * n} * c + {n}, *const column = U + {n} * c;",
        "    w[2 * c + 1] = column[c];", f"    column[c] = {one};",
        "    for (int k = c; k > 0; k--)",
        f"        for (int i = 0; i < k; i++) column[i] -= ahead[{2 * n} * k + {n} + i] * column[k];",
        f"    for (int i = 0; i < {n}; i++) {{", f"        {type_} sum = {zero};",
        f"        for (int k = 0; k <= c; k++) sum += ahead[{2 * n} * k + i] * column[k];", "        to[i] = sum;", "    }", "}",
        f"triangular(v, w, {n + all_}, {n}, 0, U);", "pack(U, f->P);"]
    return [line for line in made if line], [_unpack(a), _pack(a), _triangular(a, n + all_)]


def _triangular(a: EquationFilter, most: int) -> list[str]:
    type_, zero, one = a.type, a.number(0), a.number(1)
    return function(
        f"static void triangular({type_} *restrict v, const {type_} *restrict w, int count, int size, int first, {type_} *restrict U)", [
            f"for (int row = size - 1; row >= first; row--) {{", f"    {type_} *const u = U + (row - first) * size;",
            f"    {type_} d = {zero};", f"    for (int i = 0; i < row; i++) u[i] = {zero};",
            "    for (int k = 0; k < count; k++) {", f"        const {type_} *const from = v + k * size;",
            f"        const {type_} share = w[k] * from[row];", f"        if (share == {zero}) continue;",
            "        d += share * from[row];", "        for (int i = 0; i < row; i++) u[i] += share * from[i];", "    }",
            f"    const {type_} inverse = d < {a.number(a.form.least)} ? {zero} : {one} / d;",
            "    for (int i = 0; i < row; i++) u[i] *= inverse;",
            "    for (int k = 0; k < count; k++) {", f"        {type_} *const to = v + k * size;",
            f"        const {type_} part = to[row];", f"        if (part == {zero}) continue;",
            "        for (int i = 0; i < row; i++) to[i] -= part * u[i];", "    }",
            "    u[row] = d;", "}"],
        "Gram and Schmidt with weights w, of `count` columns v of `size`: rows of U from `first` on; on its diagonal is D")


def _places(a: EquationFilter) -> tuple[list[int], list[float]]:
    """Of the entries, column after column: the field P[k], or what follows them, the constants"""
    constants = sorted({fact for fact in a.facts.values() if not isinstance(fact, tuple)})
    slots = {key: slot for slot, key in enumerate(a.live)}
    return [slots[fact] if isinstance(fact, tuple) else len(slots) + constants.index(fact)
            for fact in (a.facts[key] for key in ud.keys(a.of.n))], constants


def _unpack(a: EquationFilter) -> list[str]:
    place, constants = _places(a)
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
