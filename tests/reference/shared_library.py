"""kalmanq as a shared library, of one arithmetic, called from Python."""

from __future__ import annotations

import ctypes

import numpy as np


class Library:
    """kalmanq of one arithmetic; objects are bytes, numbers are arrays"""

    def __init__(self, path, arithmetic):
        self.all, self.suffix = ctypes.CDLL(path), "_" + arithmetic
        self.type = {"f32": np.float32, "f64": np.float64, "q31": np.int32}[arithmetic]
        self.number = {"f32": ctypes.c_float, "f64": ctypes.c_double, "q31": ctypes.c_int32}[arithmetic]
        numbers = ctypes.POINTER(self.number)
        self.function = ctypes.CFUNCTYPE(None, ctypes.c_void_p, numbers, numbers)
        self.kept = []

    def answer(self, name, *arguments):
        """The status, or another int"""
        return getattr(self.all, "kq_" + name + self.suffix)(*[self.argument(a) for a in arguments])

    def call(self, name, *arguments):
        status = self.answer(name, *arguments)
        if status:
            raise SystemExit(f"kq_{name}{self.suffix} answers {status}")

    def read(self, name, *arguments):
        function = getattr(self.all, "kq_" + name + self.suffix)
        function.restype = self.number
        return float(function(*[self.argument(a) for a in arguments]))

    def argument(self, a):
        if isinstance(a, np.ndarray):
            return a.ctypes.data_as(ctypes.c_void_p)
        return ctypes.c_size_t(a) if isinstance(a, int) else a

    def numbers(self, a):
        self.kept.append(np.ascontiguousarray(np.real(a), dtype=self.type))
        return self.kept[-1]

    def words(self, count):
        self.kept.append(np.zeros(count, dtype=self.type))
        return self.kept[-1]

    def made(self, name, *sizes, words=4096):
        self.kept.append(np.zeros(512, dtype=np.uint8))
        item, memory = self.kept[-1], self.words(words)
        self.call(name + "_assign", item, *sizes, memory, words)
        return item

    def callback(self, function, rows, n):
        def called(_, x, y):
            values = np.real(function(np.array(x[:n], dtype=np.float64)))
            for c in range(rows):
                y[c] = values[c]
        return self.function(called)
