"""The emitted C on this machine: compiled, loaded and run over arrays.  So a simulation is of the firmware itself."""

from __future__ import annotations

import ctypes
from contextlib import ExitStack
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, Optional, Sequence

import numpy as np

from kalmanq.compiler.run.building import build, compiler, folder_of
from kalmanq.compiler.templates.engine import rendered
from kalmanq.compiler.text.emit import PREDICTS, UPDATES, Row
from kalmanq.compiler.text.product import Product
from kalmanq.data.files import telling_where


def numbered(rows: int, first: int = 0) -> np.ndarray:
    """The clock of rows without times"""
    t = first + np.arange(rows, dtype=float)
    return np.column_stack([t - 1, np.full(rows, np.nan), t])


@dataclass(frozen=True)
class Ran:
    """rows x n (or as many as there are nominal numbers), the same, rows x n x n; bits of the components taken and of events, of each row"""

    mean: np.ndarray
    reading: np.ndarray  # rows x n, as NAME_mean_... gives it
    covariance: np.ndarray
    taken: np.ndarray
    events: np.ndarray
    digest: int = 0  # of the bits of the filter's fields


class Host:
    """A context: the filter's C as a library in a folder that ends with it."""

    def __init__(self, product: Product, flags: Sequence[str] = ()):
        self.product, self.flags = product, flags

    def __enter__(self) -> Host:
        texts = {**self.product.sources(), "driver.c": driver(self.product)}
        made = _built(tuple(texts.items()), (f"{self.product.given.name}.c", "driver.c"), tuple(self.flags), compiler())
        with ExitStack() as own:
            library = own.enter_context(folder_of({})) / "filter.so"  # of its own, and so are its statics
            with telling_where(library.parent):
                library.write_bytes(made)
            self._library = ctypes.CDLL(str(library))
            self._run = self._library.run
            self._own = own.pop_all()
        return self

    def __exit__(self, *_: object) -> None:
        self._own.close()

    def run(self, z: np.ndarray, u: Optional[np.ndarray] = None, present: Optional[np.ndarray] = None,
            what: Optional[np.ndarray] = None, goes_on: bool = False, now: Optional[np.ndarray] = None, clock: Optional[np.ndarray] = None) -> Ran:
        """z: rows x m, NaN where missing unless `present` has bits; u: rows x l, of the step that leads to the row; now: of
        the row itself; what: PREDICTS and UPDATES of each row, by default both, the first row no predict; goes_on: from the
        last row of the call before; clock: as of Record"""
        of, rows = self.product.given.of, len(z)
        z = np.asarray(z, float).reshape(rows, of.m)
        if present is None:
            present = (~np.isnan(z)) @ (1 << np.arange(of.m))
        if what is None:
            what = PREDICTS * (goes_on | (np.arange(rows) > 0)) + UPDATES * (present > 0)
        given = [np.ascontiguousarray(what, np.uint8), np.ascontiguousarray(present, np.uint32),
                 np.ascontiguousarray(z), *(np.ascontiguousarray(np.zeros((rows, of.l)) if one is None else one, np.float64)
                                            for one in (u, now))]
        given.append(np.ascontiguousarray(numbered(rows) if clock is None else clock, np.float64))
        size = len(self.product.given.carried)
        made = Ran(np.zeros((rows, size)), np.zeros((rows, size)), np.zeros((rows, of.n, of.n)), np.zeros(rows, np.uint32),
                   np.zeros(rows, np.uint32))
        arrays = [*given, made.mean, made.reading, made.covariance, made.taken, made.events, np.zeros(1, np.uint32)]
        self._run(rows, int(goes_on), *(ctypes.c_void_p(one.ctypes.data) for one in arrays))
        return replace(made, digest=int(arrays[-1][0]))

    def run_record(self, record: Any) -> Ran:
        begins_settled = record.mean is not None
        if begins_settled:
            self._library.settle(ctypes.c_void_p(np.ascontiguousarray(record.mean, np.float64).ctypes.data))
        return self.run(record.z, record.u, record.present, record.what, begins_settled, record.now, record.clock)

    def smoothed(self, what: np.ndarray) -> Smoothed:
        """Backwards over the rows of the last call, whose `what` it was, as far as --smooth holds them"""
        n, size, rows = self.product.given.of.n, len(self.product.given.carried), len(what)
        made = Smoothed(*(np.full(shape, np.nan) for shape in ((rows, size), (rows, n, n), (rows, size))))
        predicts = np.ascontiguousarray(np.asarray(what) & PREDICTS, np.uint8)
        self._library.smooth(rows, *(ctypes.c_void_p(one.ctypes.data) for one in (predicts, made.mean, made.covariance, made.lagged)))
        return made

    def steps_back(self, what: np.ndarray) -> np.ndarray:
        """Smoothed means 1, 2, ... steps before the last one of such rows"""
        predicts = np.flatnonzero(np.asarray(what) & PREDICTS)[::-1]
        return self.smoothed(what).mean[predicts[:self.product.given.options.smooth] - 1]


@lru_cache(maxsize=8)
def _built(texts: tuple[tuple[str, str], ...], sources: tuple[str, ...], flags: tuple[str, ...], by: str) -> bytes:
    """by: the compiler.  What is optimised takes longer than it saves, and has the same bits"""
    with folder_of(dict(texts)) as folder:
        return build(folder, sources, "filter.so", ("-O0", *flags, "-shared", "-fPIC")).read_bytes()


@dataclass(frozen=True)
class Smoothed:
    """Of each row given all rows, by NAME_smooth, and the mean by NAME_lagged; NaN where no step is recorded"""

    mean: np.ndarray
    covariance: np.ndarray
    lagged: np.ndarray


def driver(product: Product) -> str:
    given, a, l = product.given, product.arithmetic, product.given.of.l
    return rendered("driver.c.j2", {
        **product.text.names(), "l": l, "calls": product.calls, "measured": [a.from_double("measurements", j, f"z[{j}]") for j in range(given.of.m)],
        "begun": [a.from_double("states", i, f"mean[{i}]") for i in range(len(given.carried))],
        "controls": [a.from_double("controls", k, f"u[{k}]") for k in range(l)],
        "controls_now": [a.from_double("controls", k, f"now[{k}]") for k in range(l)],
        "row": product.text.row(Row("what[t]", "present[t]", "v", "w", "at", "clock[0]", "clock[1]", "clock[2]", "taken[t]")),
        "fields": a.arrays, "means": [a.mean_double(i) for i in range(len(given.carried))], "entry": a.covariance_double("i", "j")})
