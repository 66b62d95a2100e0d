"""A filter of the shared library, by ctypes: sizes and lengths are asked for, no struct is known.

    shared.py LIBRARY
"""

import ctypes
import sys

library = ctypes.CDLL(sys.argv[1])
TYPES = {"f32": ctypes.c_float, "f64": ctypes.c_double}


PROCESS, SENSOR, FILTER, HISTORY, LAG, CONSISTENCY = 0, 1, 2, 3, 4, 8  # kq_object


def length_of(arithmetic: str, thing: int, n: int = 0, m: int = 0, k: int = 0, l: int = 0) -> int:
    function = getattr(library, f"kq_length_{arithmetic}")
    function.restype = ctypes.c_uint64
    return function(thing, n, m, ctypes.c_size_t(k), ctypes.c_size_t(l))


def size_of(arithmetic: str, thing: int) -> int:
    function = getattr(library, f"kq_object_size_{arithmetic}")
    function.restype = ctypes.c_size_t
    return function(thing)


def level(arithmetic: str) -> float:
    """The mean of a level after two measurements"""
    number = TYPES[arithmetic]

    def call(name: str, *arguments: object) -> None:
        status = getattr(library, f"kq_{name}_{arithmetic}")(*arguments)
        if status:
            sys.exit(f"{name}_{arithmetic}: {status}")

    def made(name: str, kind: int, *sizes: int) -> object:
        thing = ctypes.create_string_buffer(size_of(arithmetic, kind))
        length = length_of(arithmetic, kind, *sizes)
        memory = (number * length)()
        kept.append(memory)
        call(f"{name}_assign", thing, *sizes, memory, ctypes.c_size_t(length))
        return thing

    kept: list[object] = []
    one = (number * 1)(1)
    four, zero, hundred = (number * 1)(4), (number * 1)(0), (number * 1)(100)
    process, sensor, filter_ = made("process", PROCESS, 1, 0), made("sensor", SENSOR, 1, 1), made("filter", FILTER, 1)
    call("process_init", process, one, None, one)
    call("sensor_init", sensor, one, four)
    call("filter_init", filter_, zero, hundred)
    for z in (3.0, 5.0):
        call("update", filter_, sensor, (number * 1)(z))
        call("predict", filter_, process, None)
    mean = getattr(library, f"kq_mean_{arithmetic}")
    mean.restype = number
    return mean(filter_, 0)


def exact() -> float:
    x, P = 0.0, 100.0
    for z in (3.0, 5.0):
        K = P / (P + 4)
        x, P = x + K * (z - x), (1 - K) * P + 1
    return x


for arithmetic, limit in (("f32", 1e-6), ("f64", 1e-14)):
    if not abs(level(arithmetic) - exact()) < limit:
        sys.exit(f"{arithmetic}: {level(arithmetic)!r}, not {exact()!r}")
wrong = [arguments for arguments in (("f32", FILTER, 0), ("q31", FILTER, 17), ("f64", HISTORY, 2, 0, 1),
                                     ("q31", CONSISTENCY, 0, 1, 40000)) if length_of(*arguments) != 0]
if wrong:
    sys.exit(f"a size that is none has a length: {wrong}")
if length_of("f32", FILTER, 4) != 18 or length_of("f32", LAG, 4, 2, 10) * 4 != 2912:
    sys.exit("lengths are not those of size.h")
print("the shared library is called by sizes and lengths alone")
