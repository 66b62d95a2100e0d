"""The functions of formulas in fixed point for Python: their C (functions.py), which this machine's compiler has made."""

from __future__ import annotations

import ctypes
import re
from functools import lru_cache
from typing import Any, Callable, Mapping

from kalmanq.compiler.algorithm.fixed import functions as fixed_functions
from kalmanq.compiler.algorithm.fixed.functions import SATURATED, WORD
from kalmanq.compiler.run.building import build, folder_of

NAMES = ("absolute", "angle", "exponential", "held", "kept", "known", "large_phase", "logarithm", "narrowed", "nearest", "one_over", "over_root",
         "phase", "placed", "remainder_of", "root_of", "rounded", "scaled", "sine", "wide", "within")
HEAD = "#include <stdint.h>\ntypedef struct { int32_t mantissa, exponent; } kq_scaled_q31;\n"
SIGNATURE = re.compile(r"^static (?:inline )?(\w+) (\w+)\(([^)]*)\)", re.M)


def _struct(name: str, **fields: type) -> type[ctypes.Structure]:
    return type(name, (ctypes.Structure,), {"_fields_": list(fields.items())})


TYPES = {"int32_t": ctypes.c_int32, "int64_t": ctypes.c_int64, "uint32_t": ctypes.c_uint32, "int": ctypes.c_int,
         "uint32_t *": ctypes.POINTER(ctypes.c_uint32), "inverted": _struct("inverted", over=ctypes.c_int32, by=ctypes.c_int),
         "reciprocal": _struct("reciprocal", over=ctypes.c_int32, root=ctypes.c_int32, half=ctypes.c_int),
         "kq_scaled_q31": _struct("scaled", mantissa=ctypes.c_int32, exponent=ctypes.c_int32)}


class Far:
    """line: of the program, where it is watched; lacks: bits that a word had too few, by line"""

    def __init__(self) -> None:
        self.bits, self.line = 0, ""
        self.lacks: dict[str, int] = {}

    def add(self, bits: int, name: str, *given: int) -> None:
        self.bits |= bits
        if bits & SATURATED:
            self.lacks[self.line] = max(self.lacks.get(self.line, 0), _beyond(name, *given).bit_length() - WORD.bit_length() + 1)


def _beyond(name: str, a: int, by: int = 0) -> int:
    """What a function was to hold in a word; of an exponential, a number of as many bits"""
    if name == "exponential":
        k = (a + (1 << 31)) >> 32
        a, by = WORD - (a < k << 32), 30 - by - max(-200, min(200, k))
    return abs((a + (1 << by - 1)) >> by if by > 0 else a << min(-by, 64))


@lru_cache(maxsize=None)
def functions() -> Mapping[str, Callable[..., Any]]:
    """By name; the last argument of those that have a `far` is a Far"""
    text = fixed_functions.routines(" ".join(f"{name}(" for name in NAMES))
    found = {name: (type_, [one.rpartition("*" if "*" in one else " ") for one in given.split(", ")])
             for type_, name, given in SIGNATURE.findall(text) if name in NAMES}
    calls = [f"{type_} call_{name}({', '.join(map(''.join, given))}) {{ return {name}({', '.join(one for *_, one in given)}); }}"
             for name, (type_, given) in found.items()]
    with folder_of({"functions.c": "\n".join([HEAD, text, *calls, ""])}) as folder:
        library = ctypes.CDLL(str(build(folder, ["functions.c"], "functions.so", ("-shared", "-fPIC"))))
    made = {name: _called(name, library[f"call_{name}"], type_, [f"{of}{mark}".strip() for of, mark, _ in given])
            for name, (type_, given) in found.items()}
    return {**made, "product": lambda a, b: a * b, "INT64_C": int, "UINT32_C": int}


def _called(name: str, function: Any, type_: str, arguments: list[str]) -> Callable[..., Any]:
    function.restype, function.argtypes = TYPES[type_], [TYPES[one] for one in arguments]
    if arguments[-1] != "uint32_t *":
        return function

    def call(*given: Any) -> Any:
        *numbers, far = given
        bits = ctypes.c_uint32()
        answer = function(*numbers, bits)
        far.add(bits.value, name, *numbers)
        return answer

    return call
