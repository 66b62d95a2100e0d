"""The factor of a large model in loops: a kilobyte in the place of tens, for more instructions.

The same UD algorithms as in ud.py, over arrays: Thornton's predict and Bierman's update.  The mean stays in straight
lines, because A and H are sparse.
"""

from __future__ import annotations

from typing import Callable, Iterable

import numpy as np

from kalmanq.compiler import slow, ud
from kalmanq.compiler.floats import LEAST, FloatFilter
from kalmanq.compiler.printing import Body
from kalmanq.compiler.request import RUN
from kalmanq.formulas.graph import symbol

PREDICT = """\
/* U D U' becomes A U D U' A' + G q G' (Thornton): the rows of [A U, G] are made orthogonal, from the last one on. */
static void predict_factor({type} *restrict P{low})
{{
    {type} W[{n}][{columns}], weight[{columns}];
    for (int c = 0; c < {n}; c++) weight[c] = P[c * (c + 1) / 2 + c];
    for (int c = 0; c < {r}; c++) weight[{n} + c] = {q}[c];
    for (int i = 0; i < {n}; i++) {{
        for (int c = 0; c < {columns}; c++) W[i][c] = c < {n} ? {zero} : noise[i][c - {n}];
        for (int a = a_first[i]; a < a_first[i + 1]; a++) {{
            const int k = a_column[a];
            W[i][k] += a_value[a];
            for (int c = k + 1; c < {n}; c++) W[i][c] += a_value[a] * P[c * (c + 1) / 2 + k];
        }}
    }}
    for (int l = {n} - 1; l >= 0; l--) {{
        {type} d = {zero}, v[{columns}];
        for (int c = 0; c < {columns}; c++) {{
            v[c] = weight[c] * W[l][c];
            {others}d += v[c] * W[l][c];
        }}
{adds}        const {type} over = d < {least} ? {zero} : {one} / d;
        P[l * (l + 1) / 2 + l] = d;
        for (int i = 0; i < l; i++) {{
            {type} u = {zero};
            for (int c = 0; c < {columns}; c++) u += v[c] * W[i][c];
            u *= over;
            P[l * (l + 1) / 2 + i] = u;
            for (int c = 0; c < {columns}; c++) W[i][c] -= u * W[l][c];
        }}
    }}
}}
"""
SPREAD = """\
/* H P H' of a row of H */
static {type} spread(const {type} *restrict P, const {type} *restrict h)
{{
    {type} sum = {zero};
    for (int c = 0; c < {n}; c++) {{
        {type} f = h[c];
        for (int i = 0; i < c; i++) f += h[i] * P[c * (c + 1) / 2 + i];
        sum += f * f * P[c * (c + 1) / 2 + c];
    }}
    return sum;
}}
"""
UPDATE = """\
/* Takes a component with the row h of H and the variance r (Bierman).  b: P H'.  Returns 1 / (H P H' + r). */
static {type} update_factor({type} *restrict P, const {type} *restrict h, {type} r, {type} *restrict b{low})
{{
    {type} variance = r, before = {one} / r;
    for (int c = 0; c < {n}; c++) {{
        {type} *const u = &P[c * (c + 1) / 2];
        {type} f = h[c];
        for (int i = 0; i < c; i++) f += h[i] * u[i];
        const {type} v = u[c] * f, total = variance + f * v, weight = {one} / total, share = f * before;
        {shrinks}
        for (int i = 0; i < c; i++) {{
            const {type} old = u[i];
            u[i] = old - share * b[i];
            b[i] += old * v;
        }}
        b[c] = v;
        variance = total;
        before = weight;
    }}
    return before;
}}
"""


ADDS = """\
        if (at[l] < {n}) {{ /* in two numbers */
            const {type} change = low[at[l]] + d + (W[l][l] - {one}) * (W[l][l] + {one}) * weight[l];
            d = weight[l] + change;
            low[at[l]] = change - (d - weight[l]);
        }}
"""
SHRINKS = """\
const {type} ratio = variance * weight, d = u[c];
        u[c] = d * ratio;
        if (at[c] < {n}) low[at[c]] = ratio * (d - u[c] - v * (v * weight) + low[at[c]]);"""


class LoopedFilter(FloatFilter):
    """As FloatFilter; all entries of the factor are carried."""

    def _find_entries(self) -> None:
        self.form, self.live = ud.UD(), ud.keys(self.of.n)
        self.facts = {key: key for key in self.live}

    def _adds_to(self, key: ud.Key) -> bool:
        return key[0] == key[1] and slow.change(self._predicted(self.form, self.entries)[key], self.entries[key]) is not None

    @property
    def _low(self) -> str:
        return ", f->P_low" if self.slow else ""

    def predict_factor(self) -> list[str]:
        return [f"predict_factor(f->P{self._low});"]

    def update(self, j: int) -> list[str]:
        options, n = self.given.options, self.of.n
        body = Body(self.words)
        y = body.text(self.innovation(self.mean, j, symbol(f"z{j}")))
        lines = [f"const {self.type} y = {y};"]
        r = self.number(self.of.R[j])
        if options.student or options.gate is not None or options.nis:
            lines.append(f"const {self.type} s = spread(f->P, H[{j}]);")
        if options.student:
            made = Body(self.words)
            text = made.assign([("r", self._student(symbol("y"), symbol("s"), j))])
            lines += [*text[:-1], f"const {self.type} {text[-1]}"]
            r = "r"
        taken = [f"{self.type} b[{n}];", f"const {self.type} moved = y * update_factor(f->P, H[{j}], {r}, b{self._low});",
                 *(f"l{i} += b[{self.order.index(i)}] * moved;" for i in range(n))]
        if options.nis:
            taken += [f"f->s[{j}] = s + {self.number(self.of.R[j])};", f"f->nis += y * y / f->s[{j}];"]
        if options.gate is None:
            return [*lines, *taken]
        return [*lines, f"const int is_near = y * y <= {self.number(options.gate**2)} * (s + {r});",
                f"if (is_near || f->rejected[{j}] >= {RUN}) {{",
                *(f"    {line}" for line in (*taken, f"if (is_near) f->rejected[{j}] = 0;")), "} else {",
                f"    f->rejected[{j}]++;", f"    f->events |= {self.given.upper}_GATED;", f"    taken &= ~{1 << j}u;", "}"]

    def routines(self, text: str) -> str:
        given = dict(type=self.type, n=self.of.n, zero=self.number(0), one=self.number(1), least=self.number(LEAST[self.type]))
        two = dict(low=f", {self.type} *restrict low", others=f"if (c != l || at[l] == {self.of.n}) ", adds=ADDS.format(**given),
                   shrinks=SHRINKS.format(**given)) if self.slow else dict(low="", others="", adds="", shrinks="u[c] *= variance * weight;")
        parts = [*self._matrices(), self._predict({**given, **two})]
        parts += [SPREAD.format(**given)] if "spread(f->P" in text else []
        return "\n".join([*parts, UPDATE.format(**given, **two), ""])

    def _predict(self, given: dict) -> str:
        r = len(self.coefficients.noise())
        text = PREDICT.format(columns=self.of.n + r, r=r, q="q", **given)
        return text

    def _matrices(self) -> list[str]:
        """A by its entries that are not 0, the factor of Q, H"""
        of, noise = self.of, self.coefficients.noise(self.order)
        A, at = self._in_order(of.A), [str(self.slow.index((k, k)) if (k, k) in self.slow else of.n) for k in range(of.n)]
        weights = [one.weight.value for one in noise] or [0]
        entries = [[one.entries[i].value for one in noise] or [0] for i in range(of.n)]
        return [*sparse(A, self.type, lambda i, k: self.number(A[i, k])), *(table("uint8_t", "at", [at]) if self.slow else []),
                *table(self.type, "q", [map(self.number, weights)]),
                *table(self.type, "noise", [map(self.number, row) for row in entries], True),
                *table(self.type, "H", [map(self.number, self.row(j)) for j in range(of.m)], True), ""]


def table(type_: str, name: str, rows: Iterable[Iterable[str]], is_matrix: bool = False) -> list[str]:
    """A constant array, of one row or as a matrix"""
    made = [list(row) for row in rows]
    texts = [f"{{{', '.join(row)}}}" for row in made]
    if not is_matrix:
        return [f"static const {type_} {name}[{len(made[0])}] = {texts[0]};"]
    return [f"static const {type_} {name}[{len(made)}][{len(made[0])}] = {{", *(f"    {text}," for text in texts), "};"]


def sparse(A: np.ndarray, type_: str, value: Callable[[int, int], str]) -> list[str]:
    """A by its entries that are not 0, as value() writes them"""
    places = [(i, k) for i, row in enumerate(A) for k, one in enumerate(row) if one]
    first = [str(sum(i < row for i, _ in places)) for row in range(len(A) + 1)]
    return [*table("int16_t", "a_first", [first]), *table("uint8_t", "a_column", [[str(k) for _, k in places]]),
            *table(type_, "a_value", [[value(i, k) for i, k in places]])]
