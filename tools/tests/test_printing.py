"""C that writes fields as soon as their formulas are there, with branches in the place of selects, does what the formulas are"""

from __future__ import annotations

import ctypes
from pathlib import Path

import numpy as np

from kalmanq.compiler.run.building import build
from kalmanq.formulas.choices import choices
from kalmanq.formulas.graph import Graph, Node, add, call, compare, mul, needed, select, sub, symbol, using
from kalmanq.formulas.printing import Body, Floats
from kalmanq.formulas.program import Program

FIELDS, OPERATIONS, PROGRAMS = 6, 40, 60
NAMES = [f"p{k}" for k in range(FIELDS)]


def _drawn(random: np.random.Generator) -> list[Node]:
    """New values of all fields: a few are kept, some change places"""
    made: list[Node] = [symbol(name) for name in NAMES]
    conditions = [compare("lt", made[0], made[1]), compare("lt", made[2], made[3])]  # of several selects, one within another
    for _ in range(OPERATIONS):
        a, b, c, d = (made[int(k)] for k in random.integers(len(made), size=4))
        made.append([lambda: add(a, b), lambda: sub(a, b), lambda: mul(call("sin", a), b), lambda: mul(a, 0.5),
                     lambda: select(conditions[int(random.integers(2))], c, d)][random.integers(5)]())
    values = [made[int(k)] for k in random.integers(len(made), size=FIELDS)]
    return [select(conditions[0], one, made[int(random.integers(len(made)))]) if k % 2 else one for k, one in enumerate(values)]


def test_random_programs_in_place(tmp_path: Path) -> None:
    random, functions, programs, branches = np.random.default_rng(1), ["#include <math.h>"], [], 0
    fields = {name: f"f->P[{k}]" for k, name in enumerate(NAMES)}
    for k in range(PROGRAMS):
        with using(Graph()):
            values = _drawn(random)
            lines = Body(Floats("double"), fields=fields).store(list(zip(fields.values(), values)))
            programs.append(Program(values))
        branches += sum(line.startswith("if (") for line in lines)
        functions.append("\n".join([f"void run{k}(struct fields *f)", "{", *lines, "}"]))
    head = f"struct fields {{ double P[{FIELDS}]; }};"
    (tmp_path / "all.c").write_text("\n".join([functions[0], head, *functions[1:], ""]), encoding="utf-8")
    library = ctypes.CDLL(str(build(tmp_path, ["all.c"], "all.so", ("-shared", "-fPIC", "-w"))))
    assert branches > PROGRAMS / 4
    for k, program in enumerate(programs):
        for _ in range(5):
            given = random.normal(size=FIELDS)
            P = (ctypes.c_double * FIELDS)(*given)
            getattr(library, f"run{k}")(ctypes.byref(P))
            np.testing.assert_allclose(list(P), program.values(dict(zip(NAMES, given))), rtol=1e-12, atol=1e-12)


def test_what_one_side_alone_needs() -> None:
    with using(Graph()):
        x, y = symbol("x"), symbol("y")
        shared = call("cos", x)
        long = x
        for _ in range(4):
            long = call("sin", add(long, shared))
        value = select(compare("lt", x, y), long, shared)
        order, _ = needed([value])
        choice, = choices(order, [value]).values()
        inside = {id(one) for one in choice.inside[0]}
        assert len(inside) == 8 and id(shared) not in inside and not choice.inside[1]
        assert not choices(needed([value, long])[0], [value, long])  # it is needed in any case


def test_few_operations_stay_a_select() -> None:
    with using(Graph()):
        x, y = symbol("x"), symbol("y")
        value = select(compare("lt", x, y), call("sin", x), mul(y, y))
        assert Body(Floats("float"), fields={"x": "f->x"}).store([("f->x", value)]) == [
            "const float x = f->x;", "f->x = x < y ? sinf(x) : y * y;"]
