"""A filter of kalmanq compile, one call at a time: each call of its C, and each reading as a double."""

from __future__ import annotations

import ctypes
from pathlib import Path
from typing import Any, Optional, Sequence

import numpy as np
from library import written

from kalmanq import Model
from kalmanq.compiler.given.request import Options

from kalmanq.compiler.run.building import build
from kalmanq.compiler.text.product import Product, compiled

ACCESS = """\
#include <math.h>
#include "{name}.h"
unsigned size(void) {{ return sizeof({name}_{struct}); }}
unsigned events(const {name}_{struct} *p) {{ return {now}.events; }}
void clear({name}_{struct} *p) {{ {now}.events = 0; }}
void read(const {name}_{struct} *p, double *mean, double *covariance)
{{
    const {name}_filter f = {now};
{means}
    for (int i = 0; i < {n}; i++)
        for (int j = 0; j < {n}; j++) covariance[i * {n} + j] = {entry};
}}
"""
NIS = "double nis(const {name}_filter *f) {{ return (double)f->nis; }}\n"
LIKELIHOOD = "double likelihood({name}_filter *f, unsigned taken) {{ return (double){name}_log_likelihood(f, taken); }}\n"
WORDS = {"f32": ctypes.c_float, "f64": ctypes.c_double, "q31": ctypes.c_int32}


def library(folder: Path, made: Product, text: str, flags: Sequence[str] = ()) -> ctypes.CDLL:
    """With more C around it"""
    written(folder, {**made.sources(), "more.c": text})
    name = made.given.name
    return ctypes.CDLL(str(build(folder, [f"{name}.c", "more.c"], f"{name}.so", (*flags, "-shared", "-fPIC"))))


class Called:
    """Its struct and its functions: call(NAME, ...)"""

    STRUCT, NOW, MORE, FLAGS = "filter", "(*p)", "", ()  # the struct at p; the filter in it; more C

    def __init__(self, product: Product, folder: Path, flags: Sequence[str] = ()):
        self.product, self.of, a = product, product.given.of, product.arithmetic
        options, sizes = product.given.options, {"name": product.given.name, "struct": self.STRUCT, "now": self.NOW, "n": self.of.n}
        self.type = WORDS[options.arithmetic]
        means = "\n".join(f"    mean[{i}] = {a.mean_double(i)};" for i in range(self.of.n))
        texts = [ACCESS.format(**sizes, means=means, entry=a.covariance_double("i", "j")), self.MORE.format(**sizes)]
        texts += [one.format(**sizes) for one in (NIS, LIKELIHOOD)[:1 + (options.arithmetic != "q31")] if options.nis]
        self.library = library(folder, product, "\n".join(texts), (*self.FLAGS, *flags))
        if options.nis:
            self.library.nis.restype = ctypes.c_double
        if options.nis and options.arithmetic != "q31":
            self.library.likelihood.restype = ctypes.c_double
        self.f = ctypes.create_string_buffer(self.library.size())
        self.start()

    def call(self, what: str, *given: Any) -> int:
        return getattr(self.library, f"{self.product.given.name}_{what}")(self.f, *given)

    def start(self) -> None:
        self.call("start")

    def numbers(self, values: Any) -> ctypes.Array:
        array = np.ravel(np.asarray(values, float))
        return (self.type * len(array))(*array)

    def words(self, which: str, values: Any) -> ctypes.Array:
        """Of measurements or controls, in fixed point rounded"""
        raw = [self.product.arithmetic.raw(which, k, float(one)) for k, one in enumerate(np.atleast_1d(values))]
        return (self.type * len(raw))(*raw)

    def controls(self, u: Optional[Sequence[float]]) -> list[ctypes.Array]:
        count = self.product.given.inputs
        return [self.words("controls", np.zeros(count) if u is None else u)] if count else []

    def read(self) -> tuple[np.ndarray, np.ndarray]:
        made = np.zeros(self.of.n), np.zeros((self.of.n, self.of.n))
        self.library.read(self.f, *(ctypes.c_void_p(one.ctypes.data) for one in made))
        return made

    @property
    def mean(self) -> np.ndarray:
        return self.read()[0]

    @property
    def covariance(self) -> np.ndarray:
        return self.read()[1]

    @property
    def nis(self) -> float:
        return float(self.library.nis(self.f))

    def likelihood(self, taken: int) -> float:
        return float(self.library.likelihood(self.f, taken))


class Driven(Called):
    """start(), predict(u), update(z), step(z, u); mean, covariance, events, nis"""

    MORE = "unsigned calls(const {name}_filter *f) {{ return f->calls; }}"

    def __init__(self, model: Model, folder: Path, options: Options = Options(), flags: Sequence[str] = ()):
        super().__init__(compiled(model, "flt", options), folder, flags)

    def start_at(self, mean: Sequence[float], sigma: Sequence[float]) -> int:
        return self.call("start_at", self.numbers(mean), self.numbers(sigma))

    def predict(self, u: Optional[Sequence[float]] = None) -> None:
        self.call("predict", *self.controls(u))

    def update(self, z: Sequence[float], present: Optional[int] = None) -> int:
        given = self.words("measurements", z)
        if present is None or self.of.m == 1:
            return self.call("update", given)
        return self.call("update_some", given, ctypes.c_uint(present))

    def step(self, z: Sequence[float], u: Optional[Sequence[float]] = None) -> int:
        return self.call("step", *self.controls(u), self.words("measurements", z))

    @property
    def bits(self) -> bytes:
        return bytes(self.f)

    @property
    def events(self) -> int:
        """They are cleared."""
        was = self.library.events(self.f)
        self.library.clear(self.f)
        return int(was)

    @property
    def is_settled(self) -> bool:
        steady = self.product.steady
        return steady is not None and self.library.calls(self.f) >= 2 * steady.samples


def doubles(values: Sequence[float]) -> ctypes.Array:
    made = np.atleast_1d(np.asarray(values, float))
    return (ctypes.c_double * len(made))(*made)
