"""Derivatives of formulas beside differences in long double, rule by rule; formulas that are deeper than Python's stack"""

from __future__ import annotations

import math

import numpy as np
import pytest

from kalmanq.formulas import tracing
from kalmanq.formulas.calculus import jacobian, less, substituted
from kalmanq.formulas.functions import NAMED, NoFormula
from kalmanq.formulas.graph import Graph, add, call, compare, constant, divide, inverse, logic, mul, needed, power, select, sub, symbol, using
from kalmanq.formulas.printing import Body, Floats
from kalmanq.formulas.program import Program

MANY = (-3.7, -1.3, -0.4, 1e-3, 0.2, 0.9, 2.6, 40.0)
BETWEEN = (-3.7, -1.3, -0.4, 0.23, 0.9, 2.6)  # jumps
POSITIVE = (1e-8, 1e-3, 0.2, 0.9, 2.6, 40.0, 1e8)
WITHIN = (-0.999, -0.5, 1e-6, 0.3, 0.99)
RULES = {
    **{name: (lambda x, y, name=name: call(name, x), MANY) for name in ("sin", "cos", "tan", "exp", "atan", "sinh", "cosh", "tanh",
                                                                        "abs", "expm1", "cbrt", "asinh")},
    **{name: (lambda x, y, name=name: call(name, x), BETWEEN) for name in ("floor", "rint")},
    **{name: (lambda x, y, name=name: call(name, x), POSITIVE) for name in ("sqrt", "log", "log1p")},
    **{name: (lambda x, y, name=name: call(name, x), WITHIN) for name in ("asin", "acos", "atanh")},
    "acosh": (lambda x, y: call("acosh", x), (1.0001, 1.5, 30.0)),
    "add": (lambda x, y: add(mul(3.0, x), y), MANY), "sub": (lambda x, y: sub(y, mul(2.0, x)), MANY),
    "mul": (lambda x, y: mul(mul(x, y), call("sin", x)), MANY), "square": (lambda x, y: mul(x, x), MANY),
    "inverse": (lambda x, y: inverse(x), MANY), "divide": (lambda x, y: divide(call("sin", x), add(x, y)), MANY),
    "atan2 by y": (lambda x, y: call("atan2", x, y), MANY), "atan2 by x": (lambda x, y: call("atan2", y, x), MANY),
    "atan2 by both": (lambda x, y: call("atan2", mul(x, y), add(x, mul(x, x))), MANY),
    "fmod by a": (lambda x, y: call("fmod", mul(7.1, x), 2.0), BETWEEN), "fmod by b": (lambda x, y: call("fmod", 57.3, x), BETWEEN),
    **{f"power {k}": (lambda x, y, k=k: power(x, k), MANY) for k in (-3, -1, 1, 2, 3, 7, 16, 17, -20)},
    **{f"power {k}": (lambda x, y, k=k: power(x, k), POSITIVE) for k in (0.5, -0.5, 1.5, 0.1, -2.25)},
    "exponent": (lambda x, y: power(2.5, x), MANY), "both": (lambda x, y: power(x, mul(x, y)), POSITIVE[1:-1]),
    "base": (lambda x, y: power(x, y), POSITIVE[1:-1]), "negative base": (lambda x, y: power(x, add(y, 1.3)), MANY),
    "select": (lambda x, y: select(compare("lt", x, 0.5), mul(x, x), call("sin", x)), MANY),
    "not chosen": (lambda x, y: select(compare("lt", x, 0.0), call("exp", x), add(x, call("sqrt", call("abs", x)))), MANY),
    "conditions": (lambda x, y: select(logic("and", compare("le", x, 1.0), logic("not", compare("eq", x, y))), power(x, 3), x), MANY),
    "shared": (lambda x, y: (lambda s: mul(add(s, mul(s, s)), call("cos", s)))(add(call("sin", x), mul(x, y))), MANY[:-1]),
}


def symbols(graph=None):
    with using(graph or tracing.graph_of_formulas()) as made:
        return made, symbol("x"), symbol("y")


@pytest.mark.parametrize("name", RULES)
def test_a_rule_is_the_slope(name):
    build, where = RULES[name]
    graph, x, y = symbols()
    with using(graph):
        one = build(x, y)
        slope = Program(jacobian([one], [x])[0])
    program, long = Program([one]), np.longdouble
    for at in where:
        def value(k):
            return program.values({"x": long(at) * (1 + k * h), "y": 0.7}, long)[0]
        edge = 1 - abs(at) if where == WITHIN else at - 1 if name == "acosh" else 1.0  # how far from where there is no slope
        h = long(min(1e-5, edge / 1000))
        near = (8 * (value(1) - value(-1)) - (value(2) - value(-2))) / (12 * h * long(at))  # to the fourth order
        rest = float(max(abs(value(0)), abs(value(1)))) / abs(at) * 1e-13 + 2e-9 * float(abs(near))
        assert abs(float(near) - slope.values({"x": at, "y": 0.7})[0]) <= rest, (at, near)


def test_slopes_at_awkward_points():
    graph, x, y = symbols()
    with using(graph):
        safe = select(compare("lt", x, 1e-4), mul(x, x), call("sqrt", x))
        cases = [(power(x, y), {"x": 0.0, "y": 2.0}, 0.0), (power(x, 2), {"x": 0.0}, 0.0), (power(x, 1.5), {"x": 0.0}, 0.0),
                 (power(x, y), {"x": -2.0, "y": 3.0}, 12.0), (call("abs", x), {"x": 0.0}, 1.0), (safe, {"x": 0.0}, 0.0),
                 (NAMED["sinc"](x), {"x": 0.0}, 0.0), (call("atan2", x, y), {"x": 0.0, "y": -1.0}, -1.0),
                 (NAMED["hypot"](x, y), {"x": 0.0, "y": 3.0}, 0.0), (call("sqrt", x), {"x": 0.0}, math.inf),
                 (power(y, x), {"x": 0.0, "y": 0.0}, 0.0)]
        for one, at, wanted in cases:
            assert Program(jacobian([one], [x])[0]).values({"y": 0.7, **at})[0] == wanted, one


def test_constants_fold_as_numpy_has_them():
    with using(tracing.graph_of_formulas()):
        for made, wanted in ((divide(49.0, 49.0), 1.0), (divide(1.0, 0.0), np.inf), (divide(-1.0, 0.0), -np.inf),
                             (call("log", 0.0), -np.inf), (call("exp", 1e4), np.inf), (power(0.0, -1.0), np.inf),
                             (NAMED["remainder"](-7.0, 3.0), 2.0), (NAMED["floor_divide"](-7.0, 2.0), -4.0),
                             (NAMED["fmod"](-7.0, 3.0), -1.0), (NAMED["round"](2.5), 2.0), (NAMED["round"](-0.5), 0.0),
                             (call("cbrt", -8.0), -2.0), (power(-8.0, 3.0), -512.0), (NAMED["floor_divide"](1.0, 0.1), 9.0)):
            assert made.value == wanted
        for one in (divide(0.0, 0.0), call("sqrt", -1.0), call("log", -1.0), power(-8.0, 1 / 3), call("asin", 2.0)):
            assert math.isnan(one.value)
        nan, x = constant(math.nan), symbol("x")
        assert [compare(op, *pair).value for op in ("lt", "le", "eq") for pair in ((nan, x), (x, nan), (nan, 1.0))] == [0.0] * 9
        assert [compare("lt", x, math.inf).value, compare("le", math.inf, x).value, compare("lt", -math.inf, x).value] == [1, 0, 1]


def deep(count):
    """Neither sum nor product can be done without the one before."""
    graph, x, y = symbols()
    with using(graph):
        one = x
        for k in range(count // 2):
            one = call("sin", add(one, mul(y, 1.0 + k)))
        return graph, x, y, one


def test_formulas_may_be_deeper_than_the_stack():
    graph, x, y, one = deep(20000)
    with using(graph):
        assert len(needed([one])[0]) > 20000
        (by_x, by_y), = jacobian([one], [x, y])
        assert substituted(one, {"x": y}, {}) is not one
        total = x
        for k in range(20000):
            total = add(total, mul(y, 1.0 + k))
        chain = select(compare("lt", x, y), total, add(total, 1.0))
        assert "x" not in {a.args[0] for a in needed([less(total, x)])[0] if a.op == "symbol"}
        assert less(chain, x).op == "select"
        made = Program([one, by_x, by_y, total]).values({"x": 0.3, "y": 0.0})
        assert abs(made[1] - made[1]) == 0 and np.isfinite(made).all()
        for target in (one, total, by_x):
            lines = Body(Floats("float")).assign([("r", target)])
            assert max(line.count("(") for line in lines) <= 200


def test_a_deep_function_is_traced():
    def f(x):
        y = x[0]
        for k in range(4000):
            y = np.sin(y + (k + 1) * x[1])
        return [y]

    graph = tracing.graph_of_formulas()
    with using(graph):
        made = tracing.traced(f, [tracing.symbols("x", 2)], graph)
    assert np.isclose(Program(made).values({"x0": 0.3, "x1": 0.1})[0], f([0.3, 0.1])[0], rtol=1e-12)


def test_a_sum_of_terms_is_less_by_one_of_them():
    graph, x, y = symbols(Graph())
    with using(graph):
        v = mul(y, 3.0)
        assert less(add(x, v), x) is v and less(add(v, x), x) is v and less(x, x).equals(0)
        assert less(sub(x, v), x) is sub(0.0, v)
        assert less(sub(v, x), x) is sub(sub(v, x), x)
        assert less(select(compare("lt", x, y), add(x, v), x), x) is select(compare("lt", x, y), v, 0.0)
        assert less(add(add(v, x), y), x) is add(v, y)


def test_what_is_no_formula_is_said():
    with pytest.raises(NoFormula, match="frexp"):
        from kalmanq.formulas.functions import named
        named("frexp", 1.0)
