"""Functions of Python that the C core calls: the f and h of sigma points."""

from __future__ import annotations

from typing import Any, Callable, Optional

import numpy as np

from kalmanq.core import Arithmetic, ffi, lib, require


class Answer:
    """g as a kq_function.  What it raises ends the call of C as a number that is none, and is raised after it."""

    def __init__(self, arithmetic: Arithmetic, n: int, rows: int, g: Callable[[np.ndarray], np.ndarray]):
        self.arithmetic, self.n, self.rows, self.g = arithmetic, n, rows, g
        self.problem: Optional[BaseException] = None
        self.function = getattr(lib, f"kalmanq_answer_{arithmetic.name}")
        self.context = ffi.new_handle(self)

    def write(self, x: Any, y: Any) -> None:
        size = self.arithmetic.number.itemsize
        out = np.frombuffer(ffi.buffer(y, self.rows * size), self.arithmetic.number)
        out[:] = np.nan
        if self.problem is not None:
            return
        try:
            point = np.frombuffer(ffi.buffer(x, self.n * size), self.arithmetic.number).astype(np.float64)
            with np.errstate(over="ignore"):
                out[:] = self.g(point)
        except BaseException as problem:  # of any kind: C is between here and who can handle it
            self.problem = problem

    def require(self, status: int, what: str) -> None:
        """As core.require, what g raised before what C makes of it."""
        if self.problem is not None:
            raise self.problem
        require(status, what)


@ffi.def_extern()
def kalmanq_answer_f32(context: Any, x: Any, y: Any) -> None:
    ffi.from_handle(context).write(x, y)


@ffi.def_extern()
def kalmanq_answer_f64(context: Any, x: Any, y: Any) -> None:
    ffi.from_handle(context).write(x, y)
