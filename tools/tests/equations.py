"""The nonlinear models of equations/, compiled: run over arrays, or called function by function."""

from __future__ import annotations

import ctypes
import warnings
from functools import lru_cache
from pathlib import Path
from typing import Any, Optional, Sequence

import numpy as np
from driven import Called

from kalmanq.compiler.given.request import Options
from kalmanq.compiler.run.equation_records import drawn
from kalmanq.compiler.run.host import Host, Ran
from kalmanq.compiler.run.record import Record, in_whole_groups
from kalmanq.compiler.text.equation_product import compiled_equations
from kalmanq.compiler.text.product import Product
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


def rows_of(product: Product, model: NonlinearModel, rows: int, seed: int) -> Record:
    """With missing components; those whose noises are correlated are there together or not at all, as the C takes them"""
    return in_whole_groups(drawn(model, rows, seed), product.given.together)


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


class Bare(Called):
    """One filter, whose functions are called as a firmware calls them"""

    def _given(self, arguments: str, z: Any, u: Any, t: float) -> list[Any]:
        made = [self.numbers(one) for name, one in (("z", z), ("u", u)) if f" {name}[" in arguments]
        return made + ([self.type(t)] if arguments.endswith(" t") else [])

    def predict(self, u: Any = None, t: float = 0.0) -> None:
        self.call("predict", *self._given(self.product.text.predict_arguments(), None, u, t))

    def update(self, z: Any, u: Any = None, t: float = 0.0, sensor: int = 0, present: Optional[int] = None) -> int:
        one = self.product.arithmetic.sensors[sensor]
        given = self._given(self.product.text.update_arguments(one), z, u, t)
        return self.call(f"update{one.suffix}" + ("" if present is None else "_some"), *given,
                         *([] if present is None else [ctypes.c_uint(present)]))

    @property
    def events(self) -> set[str]:
        bits = self.library.events(self.f)
        return {one for k, one in enumerate(self.product.events) if bits >> k & 1}

    def clear(self) -> None:
        self.library.clear(self.f)

    @property
    def bytes(self) -> bytes:
        """Of the filter, without its events"""
        copy = ctypes.create_string_buffer(self.f.raw, len(self.f))
        self.library.clear(copy)
        return copy.raw


def wrong_lines(done: Any) -> Sequence[str]:
    return [line for line in done.stderr.splitlines() if line.strip()]
