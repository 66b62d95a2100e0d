"""NAME_move: A, B and Q of a tunable filter for a step of another length, of a model in continuous time.

As kalmanq.model.continuous: a series over dt / 2^k, and k doublings.  Where a power of F is 0 the series ends, and k is 0.
"""

from __future__ import annotations

from typing import Callable, Sequence

import numpy as np

from kalmanq.compiler.request import Request
from kalmanq.model.continuous import Continuous

SHORT, TERMS = 0.25, {"float": 8, "double": 14}  # of a series: h |F| at most, and its terms
LONGEST = 20  # doublings at most


def declared(given: Request, of: Continuous, type_: str) -> list[str]:
    said = "" if of.ends else f", or above {longest(of):.3g}"
    return [f"/** From the next predict on a step takes dt: A, {'B, ' if given.of.l else ''}and Q are worked out for it.  Start with",
            f" *  {of.dt:g} {of.unit}.  Returns 0 and changes nothing where dt is not above 0{said}. */",
            f"int {given.name}_move({given.type} *f, {type_} dt);", ""]


def longest(of: Continuous) -> float:
    """The longest step that is taken"""
    return np.inf if of.ends else SHORT * 2.0**LONGEST / of.norm


def function(given: Request, of: Continuous, type_: str, number: Callable[[float], str],
             stores: Sequence[tuple[str, str]]) -> list[str]:
    """stores: fields, and what they get: entries of A, and sums over S B"""
    n, zero = given.of.n, number(0)
    size, terms = n * n, n if of.ends else TERMS[type_]
    table = ", ".join(number(float(value)) for value in of.F.ravel())
    noise = ", ".join(number(float(value)) for value in of.Qc.ravel())
    halves = [] if of.ends else [
        "int doublings = 0;", f"for (; h * {number(of.norm)} > {number(SHORT)}; doublings++) h *= {number(0.5)};"]
    doubled = [] if of.ends else [
        "for (; doublings; doublings--) {", "    times(next, A, noise, 0);", "    times(term, next, A, 1);",
        f"    for (int i = 0; i < {size}; i++) Q[i] += term[i];", "    times(term, A, S, 0);",
        f"    for (int i = 0; i < {size}; i++) S[i] += term[i];", "    times(term, A, A, 0);",
        f"    for (int i = 0; i < {size}; i++) A[i] = term[i], noise[i] = Q[i];", "}"]
    most = [] if of.ends else [f" && dt <= {number(longest(of))}"]
    lines = [
        f"static const {type_} F[{size}] = {{{table}}};", f"static const {type_} density[{size}] = {{{noise}}};",
        f"{type_} A[{size}], Q[{size}], S[{size}], term[{size}], noise[{size}], next[{size}], h = dt;",
        f"if (!(dt > {zero} && dt - dt <= {zero}{''.join(most)})) return 0;", *halves,
        f"for (int i = 0; i < {size}; i++) {{", f"    A[i] = term[i] = i % {n + 1} ? {zero} : {number(1)};",
        "    Q[i] = noise[i] = h * density[i];", "    S[i] = h * A[i];", "}",
        f"for (int k = 1; k < {terms + n}; k++) {{", f"    const {type_} a = h / ({type_})k, b = h / ({type_})(k + 1);",
        "    times(next, F, term, 0);", f"    for (int i = 0; i < {size}; i++) {{", "        term[i] = a * next[i];",
        "        A[i] += term[i];", "        S[i] += b * term[i];", "    }", "    times(next, F, noise, 0);",
        f"    for (int i = 0; i < {n}; i++)", f"        for (int j = 0; j < {n}; j++)",
        f"            noise[{n} * i + j] = b * (next[{n} * i + j] + next[{n} * j + i]); /* F Q + Q F' */",
        f"    for (int i = 0; i < {size}; i++) Q[i] += noise[i];", "}",
        *([] if of.ends else [f"for (int i = 0; i < {size}; i++) noise[i] = Q[i];"]), *doubled,
        f"if (!{given.name}_noise(f, Q)) return 0;", *(f"{field} = {value};" for field, value in stores), "return 1;"]
    return [*_times(n, type_, zero), f"int {given.name}_move({given.type} *restrict f, {type_} dt)", "{",
            *(f"    {line}" for line in lines), "}", ""]


def _times(n: int, type_: str, zero: str) -> list[str]:
    return ["/* a b, or a b' */",
            f"static void times({type_} *restrict to, const {type_} *a, const {type_} *b, int is_transposed)", "{",
            f"    for (int i = 0; i < {n}; i++)", f"        for (int j = 0; j < {n}; j++) {{", f"            {type_} sum = {zero};",
            f"            for (int k = 0; k < {n}; k++) sum += a[{n} * i + k] * b[is_transposed ? {n} * j + k : {n} * k + j];",
            f"            to[{n} * i + j] = sum;", "        }", "}", ""]
