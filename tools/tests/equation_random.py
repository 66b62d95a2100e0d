"""Random nonlinear models, many in one library: small compositions of smooth functions, sensors sharp down to R / S = 1e-12.

    equation_random.py COUNT [FIRST]     how many stay positive, and which are wrong without a word
"""

from __future__ import annotations

import ctypes
import re
import sys
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Callable, Optional, Sequence

import numpy as np

from kalmanq.compiler.given.request import Options
from kalmanq.compiler.run.building import build
from kalmanq.compiler.run.host import driver, numbered
from kalmanq.compiler.text.emit import PREDICTS, UPDATES
from kalmanq.compiler.text.equation_product import compiled_equations
from kalmanq.compiler.text.product import Product
from kalmanq.data.files import own_folder
from kalmanq.nonlinear import NonlinearModel

ROWS = 40
TOGETHER = 50  # models of a library
LOUD = 3.0  # sigma: a mean farther off than this is wrong
COARSE = 2.0**-20  # of a state: without noise its sigma goes to 0, and no float follows it
ASTRAY = 6.0  # sigma: so far off the truth a filter is inconsistent
OFTEN = 0.1  # share of the rows in which it is
ONE = {"sin": np.sin, "cos": np.cos, "tanh": np.tanh, "atan": np.arctan, "bell": lambda a: np.exp(-a * a),
       "root": lambda a: np.sqrt(1 + a * a), "share": lambda a: 1 / (1 + a * a), "logistic": lambda a: 1 / (1 + np.exp(-a)),
       "log": lambda a: np.log(2 + a * a), "abs": abs, "square": lambda a: a * a, "cube": lambda a: a**3}
TWO = {"sum": lambda a, b: a + b, "difference": lambda a, b: a - b, "product": lambda a, b: a * b,
       "range": lambda a, b: np.sqrt(a * a + b * b + 0.01), "angle": lambda a, b: np.arctan2(a, 2 + b * b),
       "ratio": lambda a, b: a / (1 + b * b), "greater": lambda a, b: a if a > b else b}
BOUNDED = ("sin", "cos", "tanh", "atan", "bell", "share", "logistic")


@dataclass(frozen=True)
class Composed:
    """A function of x, and how it reads"""

    value: Callable[[np.ndarray], float]
    text: str


def composed(random: np.random.Generator, n: int, depth: int) -> Composed:
    if depth == 0 or random.random() < 0.15:
        k, scale, shift = int(random.integers(n)), round(float(random.uniform(0.3, 2)), 2), round(float(random.normal()), 2)
        return Composed(lambda x: scale * x[k] + shift, f"({scale} x{k} + {shift})")
    if random.random() < 0.5:
        name = str(random.choice(list(ONE)))
        a = composed(random, n, depth - 1)
        return Composed(lambda x: ONE[name](a.value(x)), f"{name}{a.text}")
    name, a, b = str(random.choice(list(TWO))), composed(random, n, depth - 1), composed(random, n, depth - 1)
    return Composed(lambda x: TWO[name](a.value(x), b.value(x)), f"{name}({a.text}, {b.text})")


def random_model(seed: int) -> NonlinearModel:
    random = np.random.default_rng(seed)
    n = int(random.integers(1, 6))
    m = int(random.integers(1, min(n, 3) + 1))
    fade, push = random.uniform(0.5, 1.0, n), random.uniform(0.0, 0.5, n)
    moved = [composed(random, n, 2) for _ in range(n)]
    outer = [str(random.choice(BOUNDED)) for _ in range(n)]
    seen = [composed(random, n, int(random.integers(1, 4))) for _ in range(m)]
    x0, P0 = random.normal(size=n), 10 ** random.uniform(-6, 1, n)
    Q = np.where(random.random(n) < 0.2, 0.0, 10 ** random.uniform(-10, -1, n))

    def f(x):  # type: ignore[no-untyped-def]
        return [a * x[i] + b * ONE[name](of.value(x)) for i, (a, b, name, of) in enumerate(zip(fade, push, outer, moved))]

    def h(x):  # type: ignore[no-untyped-def]
        return [of.value(x) for of in seen]

    about = x0 + np.sqrt(P0) * random.normal(size=(20, n))
    spread = np.maximum(np.var([h(x) for x in about], axis=0), 1e-6)
    sharp = 10 ** random.uniform(-12, 0, m)
    name = f"{seed}: f {'; '.join(f'{o}{one.text}' for o, one in zip(outer, moved))}; h {'; '.join(one.text for one in seen)}"
    return NonlinearModel(f, h, x0=x0, P0=P0, Q=Q, R=spread * sharp, name=name)


def record(model: NonlinearModel, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """x, and z in floats"""
    random = np.random.default_rng(seed)
    truth, z = np.zeros((ROWS, model.n)), np.zeros((ROWS, model.m))
    x = model.x0 + np.sqrt(np.diag(model.P0)) * random.normal(size=model.n)
    for t in range(ROWS):
        if t:
            x = np.array(model.given["f"].function(x)) + np.sqrt(np.diag(model.Q)) * random.normal(size=model.n)
        truth[t] = x
        z[t] = model.given["h"].function(x) + np.sqrt(np.diag(model.R)) * random.normal(size=model.m)
    z[random.random(z.shape) < 0.1] = np.nan
    return truth, z.astype(np.float32).astype(float)


@dataclass(frozen=True)
class Of:
    """rows: of a model, in f32 and f64: means, covariances, least D, events by name"""

    mean: np.ndarray
    covariance: np.ndarray
    least: np.ndarray
    events: set[str]

    @property
    def is_sound(self) -> bool:
        """Positive and finite, or an event says otherwise"""
        variances = np.einsum("tii->ti", self.covariance)
        fine = np.all(np.isfinite(self.mean)) and np.all(np.isfinite(self.covariance)) and np.all(variances >= 0)
        return bool(self.events & {"OVERFLOW", "NOT_FINITE"}) or bool(fine and np.all(np.isfinite(self.least)) and np.all(self.least >= 0))


class Library:
    """Many filters in one translation unit, each under other names"""

    def __init__(self, products: Sequence[Product], folder: Path):
        self.products = products
        text = "\n".join(["#include <math.h>", "#include <stdint.h>", *map(_own, products)])
        (folder / "all.c").write_text(text, encoding="utf-8")
        self.library = ctypes.CDLL(str(build(folder, ["all.c"], "all.so", ("-O0", "-shared", "-fPIC"))))

    def run(self, k: int, z: np.ndarray) -> Of:
        of, rows = self.products[k].given.of, len(z)
        present = (~np.isnan(z)) @ (1 << np.arange(of.m))
        what = PREDICTS * (np.arange(rows) > 0) + UPDATES * (present > 0)
        mean, least, covariance = np.zeros((rows, of.n)), np.zeros((rows, of.n)), np.zeros((rows, of.n, of.n))
        taken, events, digest = np.zeros(rows, np.uint32), np.zeros(rows, np.uint32), np.zeros(1, np.uint32)
        given = [what.astype(np.uint8), present.astype(np.uint32), np.nan_to_num(z), np.zeros(1), np.zeros(1), numbered(rows)]
        arrays = [*given, mean, least, covariance, taken, events, digest]
        getattr(self.library, f"{self.products[k].given.name}_run")(
            rows, 0, *(ctypes.c_void_p(one.ctypes.data) for one in arrays))
        bits = int(np.bitwise_or.reduce(events))
        return Of(mean, covariance, least, {one for b, one in enumerate(self.products[k].events) if bits >> b & 1})


def _own(product: Product) -> str:
    """Its C and its driver, with D in the place of readings"""
    name, a = product.given.name, product.arithmetic
    text = driver(product)
    for i, state in enumerate(product.given.states):
        fact = a.facts[i, i]
        value = f"(double)f.P[{list(a.live).index(fact)}]" if isinstance(fact, tuple) else repr(float(fact))
        text = text.replace(f"(double){name}_mean_{state}(&f);", f"{value};")
    statics = ("take", "control", "hold", "run", "hash", "f")
    whole = product.header + re.sub(r'#include "[^"]*"', "", product.code + text)
    return "\n".join([*(f"#define {one} {name}_{one}" for one in statics), whole, *(f"#undef {one}" for one in statics), ""])


@dataclass(frozen=True)
class Tried:
    seed: int
    name: str
    single: Of
    double: Of
    off: float  # share of the rows whose means in float are wrong
    worst: float  # sigma
    astray: float  # share of the rows in which double is off what is true

    @property
    def is_wrong(self) -> bool:
        """In float, though the filter follows the truth in double: one that does not is chaotic in any arithmetic"""
        return self.off > OFTEN and self.astray <= OFTEN


def tried(seeds: Sequence[int]) -> list[Tried]:
    made: list[Tried] = []
    for first in range(0, len(seeds), TOGETHER):
        made += _tried(seeds[first:first + TOGETHER])
    return made


def _tried(seeds: Sequence[int]) -> list[Tried]:
    models = [random_model(seed) for seed in seeds]
    products = [compiled_equations(model, f"k{arithmetic}_{seed}", Options(arithmetic)) for seed, model in zip(seeds, models)
                for arithmetic in ("f32", "f64")]
    with own_folder("kalmanq-random-") as folder, warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        library, made = Library(products, folder), []
        for k, (seed, model) in enumerate(zip(seeds, models)):
            x, z = record(model, seed)
            single, double = library.run(2 * k, z), library.run(2 * k + 1, z)
            sigma = np.sqrt(np.einsum("tii->ti", double.covariance) + (COARSE * np.abs(double.mean))**2).clip(1e-300)
            off, astray = (np.abs(one - double.mean) / sigma for one in (single.mean, x))
            made.append(Tried(seed, model.name, single, double, float((~(off <= LOUD)).any(axis=1).mean()), float(off.max()),
                              float((~(astray <= ASTRAY)).any(axis=1).mean())))
        return made


def main(count: int, first: int = 0) -> Optional[int]:
    made = tried(range(first, first + count))
    unsound = [one for one in made if not (one.single.is_sound and one.double.is_sound)]
    wrong = [one for one in made if one.is_wrong]
    silent = [one for one in wrong if not one.single.events]
    zero = [one for one in made if (one.single.least == 0).any()]
    print(f"{count} models: {len(unsound)} unsound, {len(zero)} with a D of 0, {sum(bool(one.single.events) for one in made)} with events, "
          f"{sum(one.astray > OFTEN for one in made)} astray in double "
          f"({sum(one.astray > OFTEN < one.off for one in made)} of them unlike it in float), {len(wrong)} others wrong in float, {len(silent)} of them without an event", flush=True)
    for one in [*unsound, *silent]:
        print(f"  {one.name[:150]}: off in {100 * one.off:.0f} % of the rows, worst {one.worst:.1e} sigma")
    return bool(unsound)


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:])))
