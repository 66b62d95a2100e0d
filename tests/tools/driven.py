"""A filter of kalmanq compile, one call at a time: each call of its C, and each reading as a double."""

from __future__ import annotations

import ctypes
from dataclasses import replace
from pathlib import Path
from typing import Optional, Sequence

import numpy as np

from kalmanq import Model
from kalmanq.compiler import record
from kalmanq.compiler.host import build
from kalmanq.compiler.product import Product, compiled
from kalmanq.compiler.request import Options

WRAPPER = """\
#include <math.h>
#include "flt.h"
enum {{ M = {m}, L = {l} }};
static {type} v[M], w[L + 1];
static void take(const double *z, const double *u)
{{
    (void)w, (void)z, (void)u;
{takes}
}}
unsigned size(void) {{ return sizeof(flt_filter); }}
void start(flt_filter *f) {{ flt_start(f); }}
void start_at(flt_filter *f, const double *mean, const double *sigma)
{{
    {type} a[{n}], b[{n}];
    for (int i = 0; i < {n}; i++) a[i] = ({type})mean[i], b[i] = ({type})sigma[i];
    flt_start_at(f, a, b);
}}
void predict(flt_filter *f, const double *u) {{ take(0, u); flt_predict(f{u}); }}
unsigned update(flt_filter *f, const double *z) {{ take(z, 0); return flt_update(f, v); }}
unsigned update_some(flt_filter *f, const double *z, unsigned bits) {{ take(z, 0); (void)bits; return {some}; }}
unsigned step(flt_filter *f, const double *u, const double *z) {{ take(z, u); return flt_step(f{u}, v); }}
void mean(const flt_filter *p, double *x)
{{
    const flt_filter f = *p;
{means}
}}
void covariance(const flt_filter *p, double *P)
{{
    flt_filter f = *p;
    for (int i = 0; i < {n}; i++)
        for (int j = 0; j < {n}; j++) P[i * {n} + j] = {entry};
}}
unsigned events(flt_filter *f) {{ const unsigned was = f->events; f->events = 0; return was; }}
unsigned calls(const flt_filter *f) {{ return f->calls; }}
{nis}
"""
NIS = """\
double nis(const flt_filter *f) { return f->nis; }
double likelihood(const flt_filter *f, unsigned taken) { return flt_log_likelihood(f, taken); }
"""


def library(folder: Path, made, text: str, flags=()) -> ctypes.CDLL:
    for name, source in {**made.sources(), "more.c": text}.items():
        (folder / name).write_text(source, encoding="utf-8")
    return ctypes.CDLL(str(build(folder, ["flt.c", "more.c"], "flt.so", (*flags, "-shared", "-fPIC"))))


class Driven:
    """start(), predict(u), update(z), step(z, u); mean, covariance, events, calls, nis"""

    def __init__(self, model: Model, folder: Path, options: Options = Options(), flags: Sequence[str] = ()):
        self.product = compiled(model, "flt", options)
        folder.mkdir(parents=True, exist_ok=True)
        texts = {**self.product.sources(), "wrapper.c": wrapper(self.product)}
        for name, text in texts.items():
            (folder / name).write_text(text, encoding="utf-8")
        self.library = ctypes.CDLL(str(build(folder, ["flt.c", "wrapper.c"], "flt.so", ("-shared", "-fPIC", *flags))))
        self.filter = ctypes.create_string_buffer(self.library.size())
        self.of, self.all = self.product.given.of, self.product.given.all
        if options.nis:
            self.library.nis.restype = self.library.likelihood.restype = ctypes.c_double
        self.library.start(self.filter)

    def start(self) -> None:
        self.library.start(self.filter)

    def start_at(self, mean: Sequence[float], sigma: Sequence[float]) -> None:
        self.library.start_at(self.filter, doubles(mean), doubles(sigma))

    def predict(self, u: Optional[Sequence[float]] = None) -> None:
        self.library.predict(self.filter, self._controls(u))

    def update(self, z: Sequence[float], present: Optional[int] = None) -> int:
        if present is None or self.of.m == 1:
            return int(self.library.update(self.filter, doubles(z)))
        return int(self.library.update_some(self.filter, doubles(z), present))

    def step(self, z: Sequence[float], u: Optional[Sequence[float]] = None) -> int:
        return int(self.library.step(self.filter, self._controls(u), doubles(z)))

    def _controls(self, u: Optional[Sequence[float]]) -> ctypes.Array:
        return doubles(np.zeros(max(self.of.l, 1)) if u is None else u)

    @property
    def mean(self) -> np.ndarray:
        made = np.zeros(self.of.n)
        self.library.mean(self.filter, ctypes.c_void_p(made.ctypes.data))
        return made

    @property
    def covariance(self) -> np.ndarray:
        made = np.zeros((self.of.n, self.of.n))
        self.library.covariance(self.filter, ctypes.c_void_p(made.ctypes.data))
        return made

    @property
    def bits(self) -> bytes:
        return bytes(self.filter)

    @property
    def events(self) -> int:
        """They are cleared."""
        return int(self.library.events(self.filter))

    @property
    def is_settled(self) -> bool:
        steady = self.product.steady
        return steady is not None and self.library.calls(self.filter) >= 2 * steady.samples

    @property
    def nis(self) -> float:
        return float(self.library.nis(self.filter))

    def likelihood(self, taken: int) -> float:
        return float(self.library.likelihood(self.filter, taken))


def doubles(values: Sequence[float]) -> ctypes.Array:
    made = np.atleast_1d(np.asarray(values, float))
    return (ctypes.c_double * len(made))(*made)


def wrapper(product: Product) -> str:
    given, a = product.given, product.arithmetic
    of = given.of
    takes = [f"    if (z) v[{j}] = {a.from_double('measurements', j, f'z[{j}]')};" for j in range(of.m)]
    takes += [f"    if (u) w[{k}] = {a.from_double('controls', k, f'u[{k}]')};" for k in range(of.l)]
    entry = a.covariance_double("i", "j").replace(given.name, "flt")
    return WRAPPER.format(type=a.type, n=of.n, m=of.m, l=of.l, u=", w" if of.l else "", takes="\n".join(takes),
                          some="flt_update_some(f, v, bits)" if of.m > 1 else "flt_update(f, v)",
                          means="\n".join(f"    x[{i}] = {a.mean_double(i)};" for i in range(of.n)), entry=entry,
                          nis=NIS if given.options.nis else "")


def in_words(product: Product, given: record.Record) -> record.Record:
    """What the filter is given of it: in fixed point rounded to words"""
    a = product.arithmetic
    if product.given.options.arithmetic != "q31":
        return given

    def rounded(which: str, values: np.ndarray) -> np.ndarray:
        words = [[np.ldexp(a.raw(which, k, value), -a.fraction(which, k)) for k, value in enumerate(row)] for row in values]
        return np.array(words).reshape(values.shape)
    return replace(given, z=rounded("measurements", given.z), u=rounded("controls", given.u))
