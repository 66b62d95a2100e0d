"""Derivatives of formulas, other formulas in the place of symbols, and a formula less one of its terms."""

from __future__ import annotations

from typing import Callable, Mapping, Optional, Sequence, TypeVar

from kalmanq.formulas.graph import (CONDITIONS, Given, Node, add, call, compare, constant, divide, inverse, logic, mul, node,
                                    power, select, sub)

Memo = dict[int, Node]
Made = TypeVar("Made")


def jacobian(rows: Sequence[Node], by: Sequence[Node]) -> list[list[Node]]:
    memos: list[Memo] = [{} for _ in by]
    return [[derivative(one, symbol, memo) for symbol, memo in zip(by, memos)] for one in rows]


def derivative(one: Node, by: Node, memo: Memo) -> Node:
    """d one / d by, of a symbol; memo: of this symbol"""
    return _worked_out(one, memo, lambda of: [a for a in of.args if isinstance(a, Node)], lambda of: _derivative(of, by, memo))


def _worked_out(one: Node, memo: dict[int, Made], needs: Callable[[Node], Sequence[Node]], make: Callable[[Node], Made]) -> Made:
    """What is made of a formula from what is made of those that it needs; memo: by id.  A long chain of formulas is deeper than Python's
    stack"""
    waiting = [one]
    while waiting:
        last = waiting[-1]
        missing = [] if id(last) in memo else [a for a in needs(last) if id(a) not in memo]
        waiting += missing
        if not missing:
            waiting.pop()
            if id(last) not in memo:
                memo[id(last)] = make(last)
    return memo[id(one)]


def partial(one: Node, argument: Node) -> Node:
    """d one / d argument, of an argument of its operation"""
    d = [constant(part is argument) for part in one.args]
    if one.op in ("floor", "rint"):
        return constant(0)
    return select(one.args[0], d[1], d[2]) if one.op == "select" else _RULES[one.op](one, d, *one.args)


def _derivative(one: Node, by: Node, memo: Memo) -> Node:
    if one.op == "symbol":
        return constant(one is by)
    if one.op in CONDITIONS or one.op in ("constant", "floor", "rint"):
        return constant(0)
    d = [memo[id(a)] for a in one.args]
    if one.op == "select":
        return select(one.args[0], d[1], d[2])
    if all(part.equals(0) for part in d):
        return constant(0)
    return _RULES[one.op](one, d, *one.args)


def _product(one: Node, d: Sequence[Node], a: Node, b: Node) -> Node:
    return mul(2.0, mul(a, d[0])) if a is b else add(mul(d[0], b), mul(a, d[1]))


def _power(one: Node, d: Sequence[Node], a: Node, b: Node) -> Node:
    if b.is_constant:
        return mul(mul(b, power(a, b.value - 1)), d[0])
    slope = mul(mul(b, power(a, sub(b, 1.0))), d[0])
    by_exponent = constant(0) if d[1].equals(0) else mul(mul(one, call("log", a)), d[1])
    return add(slope, select(compare("eq", a, 0.0), 0.0, by_exponent))


def _remainder(one: Node, d: Sequence[Node], a: Node, b: Node) -> Node:
    return d[0] if d[1].equals(0) else sub(d[0], mul(call("rint", divide(sub(a, one), b)), d[1]))


def _angle(one: Node, d: Sequence[Node], y: Node, x: Node) -> Node:
    return divide(sub(mul(x, d[0]), mul(y, d[1])), add(mul(x, x), mul(y, y)))


def _chain(slope: Callable[[Node, Node], Given]) -> Callable[..., Node]:
    """slope: of the function, from its value and its argument"""
    return lambda one, d, a: mul(slope(one, a), d[0])


_RULES: dict[str, Callable[..., Node]] = {
    "add": lambda one, d, a, b: add(d[0], d[1]), "sub": lambda one, d, a, b: sub(d[0], d[1]), "mul": _product,
    "pow": _power, "atan2": _angle, "fmod": _remainder,
    "inverse": _chain(lambda f, a: sub(0.0, mul(f, f))), "sqrt": _chain(lambda f, a: mul(0.5, inverse(f))),
    "sin": _chain(lambda f, a: call("cos", a)), "cos": _chain(lambda f, a: sub(0.0, call("sin", a))),
    "tan": _chain(lambda f, a: add(1.0, mul(f, f))), "exp": _chain(lambda f, a: f), "log": _chain(lambda f, a: inverse(a)),
    "expm1": _chain(lambda f, a: add(f, 1.0)), "log1p": _chain(lambda f, a: inverse(add(1.0, a))),
    "cbrt": _chain(lambda f, a: inverse(mul(3.0, mul(f, f)))),
    "atan": _chain(lambda f, a: inverse(add(1.0, mul(a, a)))),
    "asin": _chain(lambda f, a: inverse(call("sqrt", sub(1.0, mul(a, a))))),
    "acos": _chain(lambda f, a: sub(0.0, inverse(call("sqrt", sub(1.0, mul(a, a)))))),
    "sinh": _chain(lambda f, a: call("cosh", a)), "cosh": _chain(lambda f, a: call("sinh", a)),
    "asinh": _chain(lambda f, a: inverse(call("sqrt", add(mul(a, a), 1.0)))),
    "acosh": _chain(lambda f, a: inverse(call("sqrt", sub(mul(a, a), 1.0)))),
    "atanh": _chain(lambda f, a: inverse(sub(1.0, mul(a, a)))),
    "tanh": _chain(lambda f, a: sub(1.0, mul(f, f))), "abs": _chain(lambda f, a: select(compare("lt", a, 0.0), -1.0, 1.0)),
}
_MADE: dict[str, Callable[..., Node]] = {"add": add, "sub": sub, "mul": mul, "inverse": inverse, "pow": power}


def remade(op: str, args: Sequence[Node]) -> Node:
    """The operation of other arguments; it folds again."""
    if op in _MADE:
        return _MADE[op](*args)
    if op == "select":
        return select(*args)
    return compare(op, *args) if op in ("lt", "le", "eq") else logic(op, *args) if op in CONDITIONS else call(op, *args)


def substituted(one: Node, values: Mapping[str, Given], memo: Memo) -> Node:
    """With other formulas in the place of symbols.  A condition is decided before its branches are looked at: what is not
    chosen need not have a value."""
    return _worked_out(one, memo, lambda of: _needs(of, memo), lambda of: _substituted(of, values, memo))


def _needs(one: Node, memo: Memo) -> Sequence[Node]:
    if one.op != "select":
        return () if one.op in ("constant", "symbol") else one.args
    condition = memo.get(id(one.args[0]))
    if condition is None:
        return one.args[:1]
    return [one.args[1 if condition.value else 2]] if condition.is_constant else one.args


def _substituted(one: Node, values: Mapping[str, Given], memo: Memo) -> Node:
    if one.op == "constant":
        return one
    if one.op == "symbol":
        return node(values.get(one.args[0], one))
    if one.op == "select" and memo[id(one.args[0])].is_constant:
        return memo[id(one.args[1 if memo[id(one.args[0])].value else 2])]
    return remade(one.op, [memo[id(a)] for a in one.args])


def less(one: Node, term: Node) -> Node:
    """one - term; where `term` is added in one, it is left out: of x + v dt it is v dt, whose bits x + v dt - x loses."""
    found = without(one, term)
    return sub(one, term) if found is None else found


def without(one: Node, term: Node) -> Optional[Node]:
    """None: one is no sum with this term"""
    memo: dict[int, Optional[Node]] = {}
    return _worked_out(one, memo, lambda of: () if of is term else _TERMS.get(of.op, lambda args: ())(of.args), lambda of: _less(of, term, memo))


_TERMS: dict[str, Callable[..., Sequence[Node]]] = {"select": lambda args: args[1:], "add": lambda args: args,
                                                    "sub": lambda args: args[:1]}


def _less(one: Node, term: Node, memo: Mapping[int, Optional[Node]]) -> Optional[Node]:
    if one is term:
        return constant(0)
    found = [memo[id(a)] for a in _TERMS.get(one.op, lambda args: ())(one.args)]
    if one.op == "select":
        yes, no = found
        return None if yes is None or no is None else select(one.args[0], yes, no)
    for k, part in enumerate(found):
        if part is not None:
            return remade(one.op, [*one.args[:k], part, *one.args[k + 1:]])
    return None
