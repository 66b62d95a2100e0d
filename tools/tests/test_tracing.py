"""What a function reaches while it is traced, and that everything is as it was afterwards; C of all formulas"""

from __future__ import annotations

import ctypes
import math
import site
import subprocess
import sys
import types
from pathlib import Path

import numpy as np
import pytest
import test_formulas as of_constructs
from test_formulas import Formulas, helper, refused, traced

import kalmanq
from kalmanq.compiler.run.building import compiler
from kalmanq.formulas import tracing
from kalmanq.formulas.graph import using
from kalmanq.formulas.outside import Outside
from kalmanq.formulas.printing import Body, Floats, indented
from kalmanq.nonlinear import read

EVERY = {"all": math.sin}


def traced_alone(function, count=3):
    graph = tracing.graph_of_formulas()
    with using(graph):
        return tracing.traced(function, [tracing.symbols("x", count)], graph)


def inside(one, depth=3):
    """Names of what is in a module, an object or a container, and what they are"""
    if isinstance(one, np.ndarray):
        return one.tolist()
    found = one if isinstance(one, dict) else vars(one) if hasattr(one, "__dict__") else None
    if found is not None and depth:
        return {name: (id(value), inside(value, depth - 1)) for name, value in found.items() if name != "__builtins__"}
    return [*map(id, one)] if isinstance(one, (list, set, tuple)) else None


@pytest.mark.parametrize("module", [traced, refused])
def test_a_module_is_as_it_was(module):
    modules = (traced, helper, refused, np, math, np.linalg)
    traced.cached.cache_clear()  # of numbers, by other tests
    before = [inside(one, 2) for one in modules]
    functions = [refused.EXPECTED[name][0] for name in refused.EXPECTED if name not in ("counting", "endless")]
    for function in of_constructs.TRACED.values() if module is traced else functions:
        try:
            Formulas(function)
        except tracing.Untraced:
            assert module is refused
    assert [inside(one, 2) for one in modules] == before
    assert refused.SEEN == [] and refused.state == {"last": 0.0} and refused.kept.angle == 0.0 and refused.Kept.last is None
    assert refused.kept_in_a_default.__defaults__ == (0, []) and refused.previous is None
    assert traced.cached.cache_info().currsize == 0
    assert traced.Pendulum(2.0).torque(0.5) == -9.81 * np.sin(0.5) / 2.0


def test_numbers_kept_in_a_module_are_put_back():
    with pytest.raises(tracing.Untraced, match="twice"):
        Formulas(refused.counting)
    assert refused.calls == 0


def test_one_trace_inside_another():
    def outer(x):
        assert len(traced_alone(traced.filled)) == 3
        return [math.sin(x[0]) + np.zeros(3)[0]]

    before = dict(globals())
    assert repr(traced_alone(outer)[0].op) == "'sin'"
    with pytest.raises(tracing.Untraced, match="formula"):
        traced_alone(lambda x: [math.sin(x[0]), *Formulas(refused.gamma).nodes])
    assert {**globals()} == before and math.sin(0.0) == 0.0 and traced.math is math and traced.helper.math is math


def test_only_modules_of_the_folder_have_stand_ins(tmp_path):
    """Of a model's folder and below, but for what is installed there"""
    texts = {"far/far_away.py": "import math\n\ndef turned(x): return math.sin(x)\n",
             "near/model.py": "import math\nfrom far_away import turned\nfrom parts.deep import cosine\nimport beside\n\n"
                              "def far(x): return [turned(x[0])]\ndef deep(x): return [cosine(x[0]), beside.sine(x[1])]\n"
                              "states, x0, P0, Q, R = ['a', 'b', 'c'], [0.0, 0, 0], [1, 1, 1], [1, 1, 1], [1, 1]\n"
                              "f, h = (lambda x: x), deep\n",
             "near/beside.py": "from math import sin as sine\n", "near/parts/__init__.py": "",
             "near/parts/deep.py": "import math\n\ndef cosine(x): return math.cos(x)\n"}
    for name, text in texts.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    sys.path.insert(0, str(tmp_path / "far"))
    try:
        model = read(tmp_path / "near/model.py")
        assert [one.op for one in model.formulas.expected] == ["cos", "sin"]
        with pytest.raises(tracing.Untraced, match=r"near/model.py: line 6: far: .*turned\(x\[0\]\).*: wants a number.*another module"):
            traced_alone(model.given["h"].function.__globals__["far"])
        assert sys.modules["beside"].sine is math.sin and sys.modules["parts.deep"].math is math
    finally:
        sys.path.remove(str(tmp_path / "far"))
        for name in ("far_away", "beside", "parts", "parts.deep"):
            sys.modules.pop(name, None)


@pytest.mark.parametrize("path", [kalmanq.__file__, np.__file__, f"{site.getusersitepackages()}/other.py"])
def test_what_is_installed_below_a_model_is_not_the_users(path):
    (other := types.ModuleType("other")).__file__ = path
    names = {"__file__": str(Path(path).parents[-2] / "model.py"), "other": other}
    exec("def f(x): return x", names)
    assert len(Outside(names["f"]).spaces) == 1


def test_an_interrupt_puts_everything_back():
    def stopped(x):
        raise KeyboardInterrupt

    before = dict(globals())
    with pytest.raises(KeyboardInterrupt):
        traced_alone(stopped)
    assert {**globals()} == before and traced_alone(lambda x: x)[0].op == "symbol"


def test_what_a_closure_keeps_is_put_back():
    seen, last = [1.0], 0.0

    def f(x):
        nonlocal last
        last = 1.0
        seen[0] = 2.0
        return [x[0] * seen[0]]

    assert traced_alone(f)[0].op == "mul" and (seen, last) == ([1.0], 0.0)


def test_the_c_of_every_construct_is_the_function(tmp_path):
    """In double, without a warning"""
    text = ["#include <math.h>", ""]
    for name in of_constructs.TRACED:
        body = Body(Floats("double"))
        nodes = of_constructs.formulas_of(name).nodes
        text += [f"void {name}(double x0, double x1, double x2, double t, double *y);",
                 f"void {name}(double x0, double x1, double x2, double t, double *y)", "{",
                 *indented([f"(void){one};" for one in ("x0", "x1", "x2", "t")]),
                 *indented(body.assign([(f"y[{k}]", one) for k, one in enumerate(nodes)])), "}", ""]
    source, library = tmp_path / "formulas.c", tmp_path / "formulas.so"
    source.write_text("\n".join(text))
    subprocess.run([compiler(), "-std=c11", "-O0", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror", "-ffp-contract=off",
                    "-shared", "-fPIC", str(source), "-o", str(library), "-lm"], check=True)
    loaded = ctypes.CDLL(str(library))
    for name in of_constructs.TRACED:
        of = of_constructs.formulas_of(name)
        for x, t in of_constructs.points() + of_constructs.AWKWARD:
            made = (ctypes.c_double * len(of.nodes))()
            getattr(loaded, name)(*map(ctypes.c_double, [*x, t]), made)
            own = of.own(x, t)
            assert np.all(np.abs(np.array(made) - own) <= 1e-14 * np.maximum(np.abs(own), 1)), (name, x, t)
