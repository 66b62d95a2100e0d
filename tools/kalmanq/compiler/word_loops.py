"""q31: the factor of a large model in loops, as loops.py has it for floats: fewer bytes, for more instructions.

The same reflections and rotations as in word_factor.py, over arrays; what is 0 in a row is left out as the program runs.
The mean stays in straight lines.
"""

from __future__ import annotations

import math
from typing import Optional, Sequence

from kalmanq.compiler.loops import sparse, table
from kalmanq.compiler.word_factor import Factor, Key, keys
from kalmanq.compiler.word_formats import BITS, down, root_of, variance_word
from kalmanq.compiler.word_mean import word_of
from kalmanq.compiler.word_text import Lines, Value
from kalmanq.compiler.words import WordFilter

PREDICT = """\
/* S becomes the root of A S S' A' + G G': the columns of [G, A S] are made triangular, from the last row on.  Not 0: a
   sigma is beyond its format, and S stays. */
static int predict_factor(int32_t *restrict P)
{{
    int32_t W[{n}][{columns}], turns[{columns}];
    for (int i = 0; i < {n}; i++) {{
        for (int c = 0; c < {r}; c++) W[i][c] = noise[i][c];
        for (int c = 0; c < {n}; c++) {{
            int64_t sum = 0;
            for (int a = a_first[i]; a < a_first[i + 1]; a++)
                if (a_column[a] <= c) sum += product(a_value[a], P[c * (c + 1) / 2 + a_column[a]]);
            W[i][{r} + c] = (int32_t)shifted(sum, a_digits[i]);
        }}
    }}
    for (int l = {n} - 1; l >= 0; l--) {{
        const int pivot = {r} + l;
        uint8_t at[{columns}];
        int used = 0;
        uint64_t square = (uint64_t)product(W[l][pivot], W[l][pivot]);
        for (int c = 0; c < pivot; c++)
            if (W[l][c]) {{
                square += (uint64_t)product(W[l][c], W[l][c]);
                at[used++] = (uint8_t)c;
            }}
        if (!used) continue;
        const reciprocal root = inverse_root(square);
        for (int k = 0; k < used; k++) turns[k] = fraction(W[l][at[k]], root);
        const int32_t first = fraction(W[l][pivot], root), weight = inverse(first), signed_ = first < 0 ? -weight : weight;
        for (int i = 0; i < l; i++) {{
            int64_t sum = product(first, W[i][pivot]);
            for (int k = 0; k < used; k++) sum += product(turns[k], W[i][at[k]]);
            const int32_t made = part(sum), half = half_part(product(made, weight) + product(W[i][pivot], signed_));
            for (int k = 0; k < used; k++) W[i][at[k]] -= twice_part(product(turns[k], half));
            W[i][pivot] = made;
        }}
        W[l][pivot] = word(root);
    }}
    for (int i = 0; i < {n}; i++) {{
        uint64_t square = 0;
        for (int c = i; c < {n}; c++) square += (uint64_t)product(W[i][{r} + c], W[i][{r} + c]);
        if (square >> top[i]) return 1;
    }}
    for (int c = 0; c < {n}; c++)
        for (int i = 0; i <= c; i++) P[c * (c + 1) / 2 + i] = W[i][{r} + c];
    return 0;
}}
"""
SEEN = """\
/* f becomes h S; returns f f' */
static uint64_t seen(const int32_t *restrict P, const int32_t *restrict h, int digits, int32_t *restrict f)
{{
    uint64_t square = 0;
    for (int c = 0; c < {n}; c++) {{
        int64_t sum = 0;
        for (int i = 0; i <= c; i++) sum += product(h[i], P[c * (c + 1) / 2 + i]);
        f[c] = (int32_t)shifted(sum, digits);
        square += (uint64_t)product(f[c], f[c]);
    }}
    return square;
}}
"""
UPDATE = """\
/* Takes a component whose row of H S is f, and whose variance is t, with its root.  b: gain times sigma */
static void update_factor(int32_t *restrict P, const int32_t *restrict f, uint64_t t, int32_t root, int half,
                          int32_t *restrict b)
{{
    for (int c = 0; c < {n}; c++) b[c] = 0;
    for (int c = 0; c < {n}; c++) {{
        if (!f[c]) continue;
        t += (uint64_t)product(f[c], f[c]);
        const reciprocal r = inverse_root(t);
        const int32_t u = fraction(f[c], r), k = ratio(root, half, r);
        int32_t *const s = &P[c * (c + 1) / 2];
        for (int i = 0; i <= c; i++) {{
            const int32_t old = s[i];
            s[i] = part(product(k, old) - product(u, b[i]));
            b[i] = part(product(k, b[i]) + product(u, old));
        }}
        root = r.root, half = r.half;
    }}
}}
"""


class LoopedWords(WordFilter):
    """As WordFilter; all entries of the factor are carried."""

    def _orders(self) -> list[tuple[int, ...]]:
        return [tuple(range(self.of.n))]

    def _in_order(self, order: Sequence[int]) -> tuple[Factor, list[Key], int]:
        factor, self.there, cost = super()._in_order(order)
        return factor, keys(self.of.n), cost

    def predict_factor(self) -> list[str]:
        return [f"if (predict_factor(f->P)) {self.event('SIGMA_SATURATED')}"]

    def _spread(self, lines: Lines, j: int) -> str:
        text = f"seen(f->P, H[{j}], {self._seen()[j][1]}, f{j})"
        if text not in lines.known:
            lines.lines.append(f"int32_t f{j}[{self.of.n}];")
        return lines.let("q", text, "uint64_t")

    def _updated(self, lines: Lines, j: int, weight: Value) -> tuple[list[Value], Optional[str], list[str], list[str]]:
        n, f, there = self.of.n, f"f{j}", {key: "s" for key in self.there}
        moves = [one is not None for one in self.factor.update(Lines(), there, j)[1]]
        if not any(moves):
            return [], None, [], []
        spread, square = self._spread(lines, j), variance_word(self.formats.least[j], 2 * self.formats.row[j])
        if weight is not None:
            lines.lines.append(f"for (int c = 0; c < {n}; c++) {f}[c] = part(product({weight}, {f}[c]));")
            spread = f"16 * (uint64_t)wide({weight}, wide({weight}, (int64_t){spread}))"
        last = lines.root(f"UINT64_C({square}) + {spread}")
        root, half = root_of(square)
        return [f"b[{i}]" if moves[i] else None for i in range(n)], last, [
            f"int32_t b[{n}];", f"update_factor(f->P, {f}, UINT64_C({square}), {root}, {half}, b);"], []

    def routines(self, text: str) -> str:
        given = dict(n=self.of.n, r=len(self.factor.noise), columns=self.of.n + len(self.factor.noise))
        made = "\n".join([*self._tables(), PREDICT.format(**given), SEEN.format(**given), UPDATE.format(**given), ""])
        return super().routines(made + text) + made

    def _seen(self) -> list[tuple[list[float], int]]:
        """Rows of H between words, and the digits of their words"""
        factor, f = self.factor, self.formats
        rows = [[math.ldexp(h, e - a) for h, e in zip(row, factor.exponent)] for row, a in zip(self.of.H, f.row)]
        return [(row, digits(row)) for row in rows]

    def _tables(self) -> list[str]:
        """A by its entries that are not 0, the root of Q, H, and the length of a row that is too long"""
        n, factor = range(self.of.n), self.factor
        A = [[factor.scaled(self.of.A[i, k], k, i) for k in n] for i in n]
        by = [digits(row) for row in A]
        top = [2 * (BITS - e + held) for e, held in zip(factor.exponent, factor.held)]
        return [*sparse(self.of.A, "int32_t", lambda i, k: str(word_of(A[i][k], by[i]))),
                *table("uint8_t", "a_digits", [map(str, by)]), *table("uint8_t", "top", [map(str, top)]),
                *table("int32_t", "noise", [[str(one.entries[i] or 0) for one in factor.noise] or ["0"] for i in n], True),
                *table("int32_t", "H", [[str(word_of(h, by)) for h in row] for row, by in self._seen()], True), ""]


def digits(row: Sequence[float]) -> int:
    """Of the words of a row's coefficients"""
    most = max(map(abs, row))
    return min(30 - down(most), 60) if most else 30
