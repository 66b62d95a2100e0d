"""f32 and f64: UD and a mean in two numbers a state, as lines of C over the locals x0, l0, ..., u0_1, d0, ...

The mean of a state is x + l: an update adds to l, so a small correction of a large state is not lost.
"""

from __future__ import annotations

from functools import reduce
from typing import Any, Callable, Iterable, Mapping, Optional, Sequence

import numpy as np

from kalmanq.compiler.algorithm import double_words, ud
from kalmanq.compiler.algorithm.arithmetic import Arithmetic
from kalmanq.compiler.algorithm.coefficients import Constant, coefficients
from kalmanq.compiler.algorithm.facts import entries_of, facts
from kalmanq.compiler.algorithm.ud import carried
from kalmanq.compiler.given import far, growth, slow
from kalmanq.compiler.given.enclosure import Settled
from kalmanq.compiler.given.request import RUN, STUDENT_STEPS, Request
from kalmanq.formulas.graph import Node, constant, dot, inverse, make, node, symbol
from kalmanq.formulas.printing import Body, Floats, Target, indented

MOST = {"float": 1e18, "double": 1e150}  # of what has no range: its square is a number, and what comes of it
LEAST = {"float": ud.LEAST, "double": 1e-280}  # a D below this is 0: its inverse would overflow
LATE = 8192  # samples until it has settled, above which roundings of a float add up
SMALLEST, LARGEST = 1e-30, 1e37  # of a square that a float holds with all its digits
FEW = 24  # entries of a factor
Mean = list[tuple[Node, Node]]
Place = tuple[str, str, str]


class FloatFilter(Arithmetic):
    """In float or double"""

    most_operations = 4000  # about 20 kB
    may_be_slow = predicts_at_once = True
    refused_start = "NaN, infinite or too large, or a sigma is negative: then nothing has changed"

    def __init__(self, given: Request, steady: Optional[Settled]):
        self.given, self.of = given, given.of.doubles()
        self.type = self.mean_type = self.covariance_type = "float" if given.options.arithmetic == "f32" else "double"
        self.zero, self.model = "0.0f" if self.type == "float" else "0.0", given.model
        self.includes = ["#include <math.h>"]
        self.words = Floats(self.type)
        self.steady = steady
        self.coefficients = self.made_coefficients()
        self.growth = self._what_grows()
        may_be_far = self.type == "float" and self.may_be_slow and not given.options.tunable
        self.far = far.far_rows(given, steady) if may_be_far else ([], [])
        self._choose_order()
        self.events = (growth.EVENT,) if self.growth else ()

    def made_coefficients(self) -> Constant:
        return coefficients(self.given, self.type, self.number)

    # ---- the order of states in the factor, and which entries there are

    def _choose_order(self) -> None:
        """The model's, or one in which predict adds to each entry that a float would lose from"""
        own, best = tuple(range(self.of.n)), None
        is_late = self.steady is None or self.steady.samples > LATE
        may_be = self.type == "float" and self.may_be_slow and is_late and not self.given.options.every
        for order in self._orders() if may_be else ():
            lost = slow.slow_entries(self.given, order)
            self._take_order(order)
            lost = {key: one for key, one in lost.items() if self.facts[key] == key}
            carried = [key for key in lost if self._adds_to(key)]
            left = {order[key[1]]: one.rows for key, one in lost.items() if one.counts and not (key in carried and one.is_small)}
            if best is None or len(left) < best[0]:
                best = len(left), order, carried, left
            if not left:
                break
        self._take_order(best[1] if best else own)
        if best:
            self.slow, self.unresolved = best[2:]

    def _orders(self) -> Iterable[tuple[int, ...]]:
        own = tuple(range(self.of.n))
        return [own] if self.growth or self.given.options.tunable else slow.orders(self.of.n, slow.slow_states(self.given))

    def _take_order(self, order: Sequence[int]) -> None:
        self.order, self.slow, self.first = tuple(order), [], ud.factor(self.given.of.P0[np.ix_(order, order)])
        self._find_entries()

    def _in_order(self, matrix: np.ndarray) -> np.ndarray:
        return matrix[np.ix_(self.order, self.order)]

    def _adds_to(self, key: ud.Key) -> bool:
        """Is it carried, and is predict a sum with it?"""
        return self.facts[key] == key and slow.change(self._predicted(self.form, self.entries)[key], self.entries[key]) is not None

    def _find_entries(self) -> None:
        self.form = self._shorter()
        self.facts = facts(self.first, self._transfers(self.form), self._rounded)
        self.live: list[ud.Key] = sorted({fact for fact in self.facts.values() if isinstance(fact, tuple)},
                                         key=lambda key: (key[1], key[0]))

    @property
    def operations(self) -> int:
        """Of the factor, in a predict and an update of all components"""
        P = self.entries
        updates = [self.form.update(self.row(j), self._variance(j), P)[2] for j in range(self.of.m)]
        return sum(self._size(one) for one in (self._predicted(self.form, P), *updates))

    def _rounded(self, value: float) -> float:
        return float(np.float32(value)) if self.type == "float" else value

    def _shorter(self) -> ud.UD:
        """Of the two ways to predict the one with fewer operations"""
        least = min(min(ud.factor_of_noise(self._in_order(self.given.of.Q))[i, i], self.first[i, i]) for i in range(self.of.n))
        guards = least <= 0 or self.given.options.tunable
        forms = [ud.UD(rotates, guards, LEAST[self.type], bool(self.far[0])) for rotates in (True, False)]
        P = {key: symbol(entry(key)) for key in self.first}
        return min(forms, key=lambda form: self._size(self._predicted(form, P)))

    def _size(self, P: ud.Entries) -> int:
        body = Body(self.words)
        body.assign([(entry(key), one) for key, one in P.items()])
        return body.count

    def _predicted(self, form: ud.UD, P: ud.Entries) -> ud.Entries:
        A = [[self.coefficients.A[i][k] for k in self.order] for i in self.order]
        return form.predict(A, self.coefficients.noise(self.order), dict(P))

    def _transfers(self, form: ud.UD) -> list[Callable[[ud.Entries], ud.Entries]]:
        return [lambda P: self._predicted(form, P),
                *(lambda P, j=j: form.update(self.row(j), self._variance(j), dict(P))[2] for j in range(self.of.m))]

    def slot(self, j: int) -> int:
        """Of component j in a sample"""
        return j

    def row(self, j: int) -> ud.Row:
        """Of H, in the order of the factor"""
        return self.of.H[j, list(self.order)]

    def _variance(self, j: int) -> Node:
        return symbol("r") if self.given.options.student else self.coefficients.R[j]

    @property
    def entries(self) -> ud.Entries:
        return entries_of(self.facts, entry)

    # ---- fields and locals

    @property
    def fields(self) -> list[str]:
        n = len(self.given.carried)
        return [f"{self.type} x[{n}], low[{n}]; /* mean = x + low */",
                f"{self.type} P[{max(len(self.live), 1)}]; /* U and D of the covariance U D U' */", *self._low_fields(), *self.coefficients.fields]

    def _low_fields(self) -> list[str]:
        names = ", ".join(entry(key) for key in self.slow)
        return [f"{self.type} P_low[{len(self.slow)}]; /* what a float does not hold of {names} */"] if self.slow else []

    @property
    def first_mean(self) -> Sequence[float]:
        return self.of.x0

    def start(self) -> list[str]:
        return [*(f"f->x[{i}] = {self.number(value)};" for i, value in enumerate(self.first_mean)),
                *(f"f->low[{i}] = {self.number(self._low_of(value))};" for i, value in enumerate(self.first_mean)),
                *(f"f->P[{slot}] = {self.number(self.first[key])};" for slot, key in enumerate(self.live)),
                *self.first_low(), *self.coefficients.start]

    def finer(self, times: float) -> str:
        return "--arith f64 is finer." if self.type == "float" else \
            "Give states as what is left after a value that is known (an operating point), or a smaller P0 where more is known at first."

    def _low_of(self, value: float) -> float:
        return float(value) - self._rounded(float(value))

    def first_low(self) -> list[str]:
        return [f"f->P_low[{slot}] = {self.number(0)};" for slot in range(len(self.slow))]

    def start_at(self) -> list[str]:
        """From mean[n] and sigma[n], whose squares are numbers; of states that share a variance the largest sigma is taken."""
        lines, counts = [], {"mean": len(self.given.carried), "sigma": self.of.n}
        squares = {name: f"{name}[i] * {name}[i]" for name in counts}
        if len(set(counts.values())) == 1:
            counts, squares = {"sigma": self.of.n}, {"sigma": " + ".join(squares.values())}
        for name, count in counts.items():
            negative = f"sigma[i] < {self.number(0)} || " if name == "sigma" else ""
            lines += [f"for (int i = 0; i < {count}; i++)", f"    if ({negative}!({squares[name]} <= {self.number(MOST[self.type]**2)})) return 0;"]
        lines += [f"for (int i = 0; i < {len(self.given.carried)}; i++) {{", "    f->x[i] = mean[i];", f"    f->low[i] = {self.number(0)};", "}"]
        for slot, (i, j) in enumerate(self.live):
            shared = [key[0] for key, fact in self.facts.items() if fact == (i, j)] if i == j else []
            text = f"sigma[{self.order[shared[0]]}]" if shared else self.number(0)
            for k in (self.order[one] for one in shared[1:]):
                text = f"({text} > sigma[{k}] ? {text} : sigma[{k}])"
            lines.append(f"f->P[{slot}] = {f'{text} * {text}' if shared else text};")
        return [*lines, *self.first_low(), *self.coefficients.start]

    def number(self, value: float) -> str:
        return self.words.number(float(value))

    def places(self, mean: bool = True, factor: bool = True) -> list[Place]:
        """Type, local and field of what a function takes from the filter"""
        made = [(self.type, f"{local}{i}", f"f->{field}[{i}]") for i in range(len(self.given.carried))
                for local, field in (("x", "x"), ("l", "low"))] if mean else []
        made += [(self.type, entry(key), f"f->P[{slot}]") for slot, key in enumerate(self.live)] if factor else []
        return made + ([(self.type, low(key), f"f->P_low[{slot}]") for slot, key in enumerate(self.slow)] if factor else [])

    def places_of_entries(self) -> tuple[list[int], list[float]]:
        """Column after column: the field P[k], or what follows them, the constants; empty: all are fields, in this order"""
        constants = sorted({fact for fact in self.facts.values() if not isinstance(fact, tuple)})
        slots = {key: slot for slot, key in enumerate(self.live)}
        made = [slots[fact] if isinstance(fact, tuple) else len(slots) + constants.index(fact)
                for fact in (self.facts[key] for key in ud.keys(self.of.n))]
        return made if constants or made != list(range(len(made))) else [], constants

    def factor_literals(self, P: np.ndarray) -> list[str]:
        made = ud.factor(self._in_order(P))
        return [self.number(made[key]) for key in self.live]

    # ---- what is done

    @property
    def mean(self) -> Mean:
        return [(symbol(f"x{i}"), symbol(f"l{i}")) for i in range(len(self.given.carried))]

    def _moved(self, x: Mean) -> Mean:
        """A x + B u: the change in the low part, then the low part goes over to x as far as it can."""
        return [double_words.moved(self.given, x, i) if i in self.far[0] else carried(high, self._change(x, i)) for i, (high, _) in enumerate(x)]

    def _change(self, x: Mean, i: int) -> Node:
        sums = [high + low for high, low in x]
        change = dot(((self.coefficients.A_less_one[i][k], sums[k]) for k in range(self.of.n)), x[i][1])
        return dot(((self.coefficients.B[i][k], symbol(f"u{k}")) for k in range(self.of.l)), change)

    def innovation(self, x: Mean, j: int) -> Node:
        if j in self.far[1]:
            return double_words.innovation(self.given, x, j)
        z = symbol(f"z{j}")
        for part in (0, 1):
            for h, one in zip(self.of.H[j], x):
                z = z - node(h) * one[part]
        return z

    def _written(self, x: Mean) -> list[Target]:
        return [one for i, (high, low) in enumerate(x) for one in ((f"x{i}", high), (f"l{i}", low))]

    def predict_mean(self) -> list[str]:
        return Body(self.words).assign(self._written(self._moved(self.mean)))

    def predict_factor(self) -> list[str]:
        P = self.entries
        after, lows = self._predicted(self.form, P), {}
        for key in self.slow:
            after[key], lows[key] = carried(P[key], symbol(low(key)) + slow.change(after[key], P[key]))
        at = {local: field for _, local, field in self.places(mean=False)}
        targets = [*((entry(key), after[key]) for key in self.live), *((low(key), one) for key, one in lows.items())]
        return Body(self.words, fields=at).store([(at[name], one) for name, one in reversed(targets)])

    def update(self, j: int, refused: Sequence[str] = ()) -> list[str]:
        """Component j, whose value is z<j>.  refused: where its variance is not finite"""
        options, P = self.given.options, self.entries
        y = self.measured(j)
        spread = self._spread(j, P)
        r = self._student(y, spread, j) if options.student else self.coefficients.R[j]
        lows = {key: symbol(low(key)) for key in self.slow}
        at = self.at_once(j)
        added, weight, after = self.form.update(self.row(j), r, P, y, lows, all(name == field for name, field in at.items()))
        factor = [*((entry(key), after[key]) for key in self.live), *((low(key), one) for key, one in lows.items())]
        mean = self.corrected([added[self.order.index(i)] for i in range(self.of.n)], j)
        targets = [(at.get(name, name), one) for name, one in ([*factor, *mean] if at else [*mean, *factor])]
        nominal = inverse(spread + self.coefficients.R[j]) if options.student else weight
        if options.nis:
            targets += [("f->nis", symbol("f->nis") + y * y * nominal), (f"f->s[{self.slot(j)}]", inverse(nominal))]
        body = Body(self.words, hints={id(y): "y", id(r): "r"} if options.student else {id(y): "y"}, fields=at)
        within = y * y * weight <= (options.gate or 0)**2
        body.hints[id(within)] = "is_near"
        made = [*(one for _, one in targets), weight, *([within] if options.gate else [])]
        check = self._unless_positive(body, made, weight, refused)
        if options.gate is None:
            lines = body.store(targets) if at else body.assign(targets)
        else:
            passes = make("or", within, symbol(f"f->rejected[{j}] >= {RUN}"))
            lines = body.assign(targets, passes, [f"if (is_near) f->rejected[{j}] = 0;"], [
                f"f->rejected[{j}]++;", f"f->events |= {self.given.upper}_GATED;", f"taken &= ~{1 << self.slot(j)}u;"])
        goes_on = refused and not refused[-1].startswith("return")
        return [*check[:-1], "} else {", *indented(lines), "}"] if goes_on else [*check, *lines]

    def _unless_positive(self, body: Body, made: Sequence[Node], weight: Node, refused: Sequence[str]) -> list[str]:
        """What comes before the writes: with `refused`, where the variance of the innovation is no number.  made: all formulas"""
        if not refused:
            return []
        body.expect(made)
        body.name_shared([weight] if body.fields else made)
        lines = [*body.lines, f"if (!({body.text(weight)} > {self.zero})) {{", *indented(refused), "}"]
        body.lines = []
        return lines

    def at_once(self, j: int) -> dict[str, str]:
        """Fields that component j's update reads where it needs them and writes as soon as it can, by their locals, or these"""
        return {local: field if self.updates_at_once else local for _, local, field in self.places()}

    @property
    def updates_at_once(self) -> bool:
        """Are there more entries than registers hold from one component to the next?"""
        return self.of.m == 1 or len(self.live) > FEW

    def measured(self, j: int) -> Node:
        """The innovation of component j, given the components before it"""
        return self.innovation(self.mean, j)

    def corrected(self, corrections: Sequence[Node], j: int) -> list[Target]:
        """The mean, moved by an update"""
        return self._written([(high, low + one) for (high, low), one in zip(self.mean, corrections)])

    def _spread(self, j: int, P: ud.Entries) -> Node:
        """H P H'"""
        h = self.row(j)
        parts = [node(h[c]) + dot((h[i], P[i, c]) for i in range(c)) for c in range(self.of.n)]
        return dot((f, P[c, c] * f) for c, f in enumerate(parts))

    def _student(self, y: Node, spread: Node, j: int) -> Node:
        """The variance that a measurement with the noise of Student is taken with (Lange, Little and Taylor 1989)"""
        nu, r = float(self.given.options.student or 0), self.coefficients.R[j]
        made = r
        for _ in range(STUDENT_STEPS):
            share = made * inverse(spread + made)
            residual = y * share
            made = r * (nu / (nu + 1)) + (residual * residual + spread * share) * (1 / (nu + 1))
        return made

    # ---- what grows without end

    def _what_grows(self) -> Optional[growth.Growth]:
        is_free = not all(one.is_constant for row in self.coefficients.A for one in row)
        return growth.growth(self.given, self.steady, self.type, is_free)

    def within_numbers(self) -> list[str]:
        """One comparison: what is looked at, each over its limit"""
        found, terms = self.growth, []
        if not found:
            return []
        for i, most in found.looked_at.items():
            fact = self.facts[i, i]
            if isinstance(fact, tuple):
                terms.append((1 / most, f"f->P[{self.live.index(fact)}]"))
            if found.by_itself or not isinstance(fact, tuple):
                terms.append((1 / growth.LARGEST[self.type], f"f->x[{i}] * f->x[{i}]"))
        if len(terms) == 1:
            return [f"if (!({terms[0][1]} <= {self.number(1 / terms[0][0])})) hold(f);"]
        weighed = dict((text, weight) for weight, text in terms)  # states that share a variance look at it once
        return [f"if (!({' + '.join(f'{self.number(weight)} * {text}' for text, weight in weighed.items())} <= {self.number(1)})) hold(f);"]

    def hold(self) -> Optional[dict[str, Any]]:
        return self._hold(self.growth.most) if self.growth else None

    def _hold(self, most: Sequence[float], first: Sequence[float] = ()) -> dict[str, Any]:
        place, _ = self.places_of_entries()
        return {**growth.hold(self.given, self.number, most, len(self.live), place, first), "largest": self.number(growth.LARGEST[self.type])}

    # ---- settled

    def settled(self, predicts: bool, then: Sequence[str]) -> list[str]:
        """The mean by the constant gain, from z0, z1, ..., and `then`; predicts: A x + B u before.  With gates nothing
        is done where a component is beyond its gate."""
        x = self._moved(self.mean) if predicts else self.mean
        y = [self.innovation(x, j) for j in range(self.of.m)]
        targets = self._written([(high, dot(zip(row, y), low)) for (high, low), row in zip(x, self.steady.gain_that_moves)])
        body = Body(self.words, hints={id(one): f"y{j}" for j, one in enumerate(y)})
        apart, variances = self._apart(y), self.steady.variances.astype(float)
        if self.given.options.nis:
            targets += [("f->nis", dot((one * one, 1 / s) for one, s in zip(apart, variances)))]
            targets += [(f"f->s[{self.slot(j)}]", constant(s)) for j, s in enumerate(variances)]
        if self.given.options.lag:
            targets += [(f"f->y[{j}]", one) for j, one in enumerate(y)]
        if self.given.options.gate is None:
            return [*body.assign(targets), *then]
        passes = [one * one <= self.given.options.gate**2 * s for one, s in zip(apart, variances)]
        return body.assign(targets, reduce(lambda one, other: make("and", one, other), passes), then)

    # ---- constant gains in a table

    def gain_literals(self, gains: Sequence[np.ndarray]) -> list[list[str]]:
        return [[self.number(one) for one in table.ravel()] for table in gains]

    def gained(self, i: int, gains: Sequence[np.ndarray], at: str, y: str) -> str:
        m = self.of.m
        return " + ".join(f"{at.format(i * m + j)} * {y.format(j)}" for j in range(m) if any(one[i, j] for one in gains))

    def innovation_text(self, j: int) -> tuple[Sequence[str], str]:
        body, made = Body(self.words, stem=f"y{j}_"), self.innovation(self.mean, j)
        body.name_shared([made])
        return body.lines, body.text(made)

    def moved(self, added: Mapping[int, str]) -> list[str]:
        return [f"l{i} += {text};" for i, text in added.items()]

    def whole_mean(self, i: int) -> str:
        return self.mean_text(i)

    def _apart(self, y: Sequence[Node]) -> list[Node]:
        """Each innovation given the components before it"""
        lower, made = self.steady.lower.astype(float), []
        for j, one in enumerate(y):
            made.append(one - dot((lower[j, k], made[k]) for k in range(j)))
        return made

    # ---- what is given and read

    def accepts(self, j: int) -> str:
        return self._within(f"z[{j}]", self.given.model.measurements[j].range or MOST[self.type])

    def accepts_all(self) -> str:
        if any(one.range for one in self.given.model.measurements):
            return super().accepts_all()
        return self.all_within(self.of.m)

    def all_within(self, m: int) -> str:
        """z[0] to z[m - 1] of any size: in float by the sum of their squares"""
        if self.type == "double":
            return " && ".join(self._within(f"z[{j}]", MOST[self.type]) for j in range(m))
        return f"{' + '.join(f'z[{j}] * z[{j}]' for j in range(m))} <= {self.number(MOST[self.type]**2)}"

    def _within(self, text: str, most: float) -> str:
        square = most * most
        if SMALLEST < square < LARGEST:
            return f"{text} * {text} <= {self.number(square)}"
        return f"{text} >= {self.number(-most)} && {text} <= {self.number(most)}"

    def ends_of_control(self, k: int) -> tuple[str, str]:
        one = self.given.model.controls[k]
        least, most = one.ends or (-(one.range or MOST[self.type]), one.range or MOST[self.type])
        return self.number(least), self.number(most)

    def mixed(self, j: int) -> str:
        """What is taken of component j: where noises are correlated, less what the components before it say of it"""
        mixing = self.given.mixing
        terms = [f" {'-' if mixing[j, k] < 0 else '+'} {self.number(abs(mixing[j, k]))} * z[{k}]" for k in range(j)
                 if self.given.together[j] >> k & 1 and mixing[j, k]]
        if d := float(self.given.offsets[j]):
            terms.append(f" {'-' if d > 0 else '+'} {self.number(abs(d))}")
        return f"z[{j}]{''.join(terms)}"

    @property
    def one(self) -> str:
        return self.number(1)

    def mean_text(self, i: int) -> str:
        return f"f->x[{i}] + f->low[{i}]"

    def covariance(self) -> dict[str, Any]:
        """Its entries: those that are carried, and those that are constant; row: of a state, in U"""
        n, (place, constants) = self.of.n, self.places_of_entries()
        return {"row": [] if self.order == tuple(range(n)) else [self.order.index(i) for i in range(n)], "live": len(self.live),
                "place": place, "constants": [*map(self.number, constants)], "one": self.one}

    def size(self) -> int:
        """Bytes of its fields"""
        m, options = self.of.m, self.given.options
        words = 2 * len(self.given.carried) + max(len(self.live), 1) + len(self.slow) + len(self.coefficients.start)
        words += (self.slots + 1 if options.nis else 0) + (m if options.lag else 0)
        return (4 if self.type == "float" else 8) * words

    def enumerators(self) -> list[str]:
        return self.coefficients.enumerators()

    def tunable(self) -> dict[str, Any]:
        return self.coefficients.tunable()

    def nis_fields(self) -> list[str]:
        return [f"{self.type} nis;",
                f"{self.type} s[{self.slots}]; /* variance of each innovation, given the components before it */"]

    def likelihood(self) -> dict[str, str]:
        return {"constant": self.number(np.log(2 * np.pi)), "factor": self.number(-0.5),
                "log": "(float)logf" if self.type == "float" else "log"}  # AVR's logf may be log

    # ---- for programs on the host

    @property
    def arrays(self) -> list[str]:
        """Fields, each an array without padding"""
        return ["x", "low", "P", *(["P_low"] if self.slow else [])]

    def raw(self, which: str, k: int, value: float) -> float:
        return value

    def literal(self, value: float) -> str:
        return self.number(value)

    def from_double(self, which: str, k: int, text: str) -> str:
        return f"({self.type}){text}"

    def mean_double(self, i: int) -> str:
        return f"(double)f.x[{i}] + (double)f.low[{i}]"

    def covariance_double(self, i: str, j: str) -> str:
        return f"(double){self.given.name}_covariance(&f, {i}, {j})"


def entry(key: ud.Key) -> str:
    """d1, or u0_1: never the name of a control, u1"""
    i, j = key
    return f"d{j}" if i == j else f"u{i}_{j}"


def low(key: ud.Key) -> str:
    """What an entry in two numbers is beside the first"""
    return f"{entry(key)}_low"
