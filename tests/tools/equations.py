"""The nonlinear models of equations/, compiled: run over arrays, or called function by function."""

from __future__ import annotations

import ctypes
import warnings
from functools import lru_cache
from pathlib import Path
from typing import Any, Optional, Sequence

import numpy as np

from kalmanq.compiler.equation_product import compiled_equations
from kalmanq.compiler.equation_report import drawn
from kalmanq.compiler.host import Host, Ran, build
from kalmanq.compiler.product import Product
from kalmanq.compiler.request import Options
from kalmanq.model import model_file
from kalmanq.nonlinear import NonlinearFilter, NonlinearModel, read

FOLDER, EXAMPLES = Path(__file__).parent / "equations", Path(model_file.__file__).parents[1] / "examples"
HELPERS = ("planar", "rotations")
WITH_ERRORS = ("attitude", "strapdown")  # of error states: test_error_states.py
NAMES = sorted(["gps_imu", *(one.stem for one in FOLDER.glob("*.py") if one.stem not in (*HELPERS, *WITH_ERRORS))])
STRICT = ("-std=c11", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wdouble-promotion", "-Wshadow", "-Werror")


def path_of(name: str) -> Path:
    return next(one for folder in (FOLDER, EXAMPLES) if (one := folder / f"{name}.py").exists())


@lru_cache(None)
def model_of(name: str) -> NonlinearModel:
    return read(path_of(name))


@lru_cache(None)
def product_of(name: str, arithmetic: str, **options: Any) -> Product:
    return compiled_equations(model_of(name), "kf", Options(arithmetic, **options))


def rows_of(product: Product, model: NonlinearModel, rows: int, seed: int) -> tuple[Any, np.ndarray]:
    """A record with missing components, and its measurements as the C takes them: components whose noises are correlated
    are there together or not at all."""
    record, z = drawn(model, rows, seed)
    for j, group in enumerate(product.given.together):
        members = [k for k in range(model.m) if group >> k & 1]
        z[np.isnan(z[:, members]).any(axis=1), j] = np.nan
    return record, z


def ran(host: Host, record: Any) -> Ran:
    return host.run_record(record)


def by_library(model: NonlinearModel, z: np.ndarray, now: np.ndarray, iterate: int = 1) -> Any:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        method = ("iterated", iterate) if iterate > 1 else ("extended",)
        return NonlinearFilter(model, "f64", *method).run(z, now if model.l else None, covariance=True)


def apart(one: Any, other: Any) -> tuple[float, float]:
    """Of means in sigma of the other, of covariances in sigma_i sigma_j of it"""
    sigma = np.sqrt(np.einsum("tii->ti", other.covariance))
    spread = np.abs(one.covariance - other.covariance) / (sigma[:, :, None] * sigma[:, None, :])
    return float((np.abs(one.mean - other.mean) / sigma).max()), float(spread.max())


class Bare:
    """One filter, whose functions are called as a firmware calls them"""

    def __init__(self, product: Product, folder: Path):
        self.product, name = product, product.given.name
        self.type = ctypes.c_float if product.given.options.arithmetic == "f32" else ctypes.c_double
        accessors = [f'#include "{name}.h"', "unsigned size(void);", "void *part(int, void *);",
                     f"unsigned size(void) {{ return sizeof({name}_filter); }}",
                     f"void *part(int which, void *p) {{ {name}_filter *f = p; return which == 0 ? (void *)&f->events : "
                     f"{'which == 1 ? (void *)&f->nis : ' if product.given.options.nis else ''}(void *)f->x; }}"]
        if product.given.options.nis:
            accessors += [f"{product.arithmetic.type} likelihood({name}_filter *f, unsigned t);",
                          f"{product.arithmetic.type} likelihood({name}_filter *f, unsigned t) {{ return {name}_log_likelihood(f, t); }}"]
        for file, text in {**product.sources(), "accessors.c": "\n".join([*accessors, ""])}.items():
            (folder / file).write_text(text, encoding="utf-8")
        self.library = ctypes.CDLL(str(build(folder, [f"{name}.c", "accessors.c"], "bare.so", ("-shared", "-fPIC"))))
        self.f = ctypes.create_string_buffer(self.library.size())
        self.library.part.restype = ctypes.c_void_p
        getattr(self.library, f"{name}_covariance").restype = self.type
        self.call("start")

    def call(self, what: str, *given: Any) -> int:
        made = getattr(self.library, f"{self.product.given.name}_{what}")
        return made(ctypes.byref(self.f), *given)

    def _given(self, arguments: str, z: Any, u: Any, t: float) -> list[Any]:
        made = [self.numbers(one) for name, one in (("z", z), ("u", u)) if f" {name}[" in arguments]
        return made + ([self.type(t)] if arguments.endswith(" t") else [])

    def numbers(self, given: Any) -> Any:
        array = np.ravel(np.asarray(given, float))
        return (self.type * len(array))(*array)

    def predict(self, u: Any = None, t: float = 0.0) -> None:
        self.call("predict", *self._given(self.product.text.predict_arguments(), None, u, t))

    def update(self, z: Any, u: Any = None, t: float = 0.0, sensor: int = 0, present: Optional[int] = None) -> int:
        one = self.product.arithmetic.sensors[sensor]
        given = self._given(self.product.text.update_arguments(one), z, u, t)
        return self.call(f"update{one.suffix}" + ("" if present is None else "_some"), *given,
                         *([] if present is None else [ctypes.c_uint(present)]))

    def _part(self, which: int, type_: Any) -> Any:
        return type_.from_address(self.library.part(which, ctypes.byref(self.f)))

    @property
    def events(self) -> set[str]:
        bits = self._part(0, ctypes.c_uint16).value
        return {one for k, one in enumerate(self.product.events) if bits >> k & 1}

    def clear(self) -> None:
        self._part(0, ctypes.c_uint16).value = 0

    @property
    def nis(self) -> float:
        return self._part(1, self.type).value

    def likelihood(self, taken: int) -> float:
        self.library.likelihood.restype = self.type
        return self.library.likelihood(ctypes.byref(self.f), ctypes.c_uint(taken))

    @property
    def bytes(self) -> bytes:
        """Of the filter, without its events"""
        at = self.library.part(0, ctypes.byref(self.f)) - ctypes.addressof(self.f)
        return self.f.raw[:at] + self.f.raw[at + 2:]

    @property
    def mean(self) -> np.ndarray:
        n = self.product.given.of.n
        x = (self.type * (2 * n)).from_address(self.library.part(2, ctypes.byref(self.f)))
        return np.array(x[:n]) + np.array(x[n:])

    @property
    def covariance(self) -> np.ndarray:
        n = self.product.given.of.n
        return np.array([[self.call("covariance", i, j) for j in range(n)] for i in range(n)])


def wrong_lines(done: Any) -> Sequence[str]:
    return [line for line in done.stderr.splitlines() if line.strip()]
