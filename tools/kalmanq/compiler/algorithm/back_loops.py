"""The step back of `back` as loops over small arrays: a few hundred bytes of code for any number of states.

A column of [x; x+] is 2 n numbers: v has the part of x of column c in its row 2 c and the part of x+ in row 2 c + 1.
Once x+ is taken out, rows 2 c + 1 are free for C U.  Columns of noise are not among them: rotations start from them.
"""

from __future__ import annotations

from typing import Any, Sequence

from kalmanq.compiler.algorithm import ud
from kalmanq.compiler.algorithm.equations import EquationFilter
from kalmanq.compiler.algorithm.floats import Mean
from kalmanq.formulas.graph import Node, constant, symbol
from kalmanq.formulas.printing import Body, Target


def bodies(a: EquationFilter, off: Sequence[Node], refused: Sequence[str]) -> tuple[list[str], list[str], dict[str, Any]]:
    """Lines over locals x0, l0, ... of the record: those before the loops, and those that move nominal numbers; and what else there is"""
    n, type_, body = a.of.n, a.type, Body(a.words)
    A, noise = [part for row in a.coefficients.A for part in row], _noise(a)
    body.lines += a.unless_finite_step(body, refused)
    body.name_shared([*A, *off, *noise])
    before = [*body.lines, f"const {type_} A[{n * n}] = {{{', '.join(map(body.text, A))}}};",
              f"{type_} d[{n}] = {{{', '.join(map(body.text, off))}}}; /* of the next instant, beside what was predicted */",
              f"{type_} ahead[{2 * n * n}] = {{{', '.join(map(body.text, noise))}}};"]
    place, constants = a.places_of_entries()
    value = f"place[k] < {len(a.live)} ? P[place[k]] : constants[place[k] - {len(a.live)}]" if constants else "P[place[k]]" if place else "P[k]"
    return before, _moved(a) if a.given.nominal else [], {
        "place": place, "constants": [*map(a.number, constants)], "value": value, "least": a.number(a.form.least),
        "entries": [] if a.live == ud.keys(n) else [n * j + i for i, j in a.live]}


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


def _moved(a: EquationFilter) -> list[str]:
    """Nominal numbers, from the record's"""
    n = a.of.n
    sums = [f"const {a.type} c{i} = {' + '.join(f'ahead[{2 * n * c + i}] * d[{c}]' for c in range(n))};" for i in range(n)]
    return [*sums, *Body(a.words, stem="s").assign(written(a.moved_by([symbol(f"c{i}") for i in range(n)])))]
