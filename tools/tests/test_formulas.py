"""What of Python has a formula, that the formula is the function, and what is said of the rest"""

from __future__ import annotations

import copy
import functools
import inspect
import re
import sys
import types
from pathlib import Path

import numpy as np
import pytest

from kalmanq.formulas import tracing
from kalmanq.formulas.calculus import jacobian
from kalmanq.formulas.graph import symbol, using
from kalmanq.formulas.program import Program

sys.path.insert(0, str(Path(__file__).parent / "constructs"))
import helper  # noqa: E402, F401
import refused  # noqa: E402
import traced  # noqa: E402

NOT_CONSTRUCTS = ("turned", "closure", "scaled", "cached", "decorated_with")
TRACED = {name: one for name, one in vars(traced).items() if callable(one) and not isinstance(one, type) and
          getattr(one, "__module__", "traced") == "traced" and name not in NOT_CONSTRUCTS and not name.startswith("_")}
TRACED.update(partly=traced.partly, method=traced.method, instance=traced.instance)


@functools.lru_cache(maxsize=None)
def formulas_of(name):
    return Formulas(TRACED[name])


class Formulas:
    def __init__(self, function):
        self.function = function
        self.count = len([one for one in inspect.signature(function).parameters if one in ("x", "t")])
        graph = tracing.graph_of_formulas()
        with using(graph):
            x, t = tracing.symbols("x", 3), symbol("t")
            self.nodes = tracing.traced(function, [x, t][:self.count], graph)
            self.slopes = jacobian(self.nodes, list(x))
        self.program, self.by_state = Program(self.nodes), Program([one for row in self.slopes for one in row])

    @staticmethod
    def _given(x, t):
        return {**{f"x{i}": one for i, one in enumerate(x)}, "t": t}

    def at(self, x, t):
        return np.array(self.program.values(self._given(x, t)), float)

    def slopes_at(self, x, t):
        return np.array(self.by_state.values(self._given(x, t)), float).reshape(-1, 3)

    def own(self, x, t):
        return np.ravel(np.array(self.function(*[x.copy(), t][:self.count]), float))


def points():
    random = np.random.default_rng(7)
    return [(x, t) for t, x in enumerate(random.normal(0, 1.3, (20, 3)))]


AWKWARD = [(np.array(x), t) for x, t in (((0.3, -0.2, 0.8), 49), ((1.0, 1.0, 1.0), 98), ((-1.0, 0.5, -0.5), 147), ((0.5, 2.0, 1.5), 30))]


@pytest.mark.parametrize("name", TRACED)
def test_a_construct_is_its_formula(name, capsys):
    of = formulas_of(name)
    for x, t in points() + AWKWARD:
        own = of.own(x, t)
        assert np.all(np.abs(of.at(x, t) - own) <= 1e-14 * np.maximum(np.abs(own), 1)), (x, t, of.at(x, t), own)


@pytest.mark.parametrize("name", TRACED)
def test_its_derivatives_are_its_slopes(name, capsys):
    of = formulas_of(name)
    for x, t in points():
        by_difference = np.array([(of.own(x + step, t) - of.own(x - step, t)) / 2e-6 for step in 1e-6 * np.eye(3)]).T
        scale = 1 + np.abs(by_difference) + np.abs(of.own(x, t))[:, None]
        assert np.all(np.abs(of.slopes_at(x, t) - by_difference) <= 2e-7 * scale), (x, t)


@pytest.mark.parametrize("name", refused.EXPECTED)
def test_what_has_no_formula_is_refused_in_one_line(name):
    function, line, reason = refused.EXPECTED[name]
    with pytest.raises(tracing.Untraced) as problem:
        Formulas(function)
    said = str(problem.value)
    place = re.match(rf"{re.escape(refused.__file__)}: line (\d+): (.*)", said)
    assert place, said
    assert "\n" not in said and re.search(reason, said), said
    text = Path(refused.__file__).read_text().splitlines()[int(place[1]) - 1].strip()
    assert name in said or text in said
    assert line in said, said
