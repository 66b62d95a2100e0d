"""A filter of the shared library, by ctypes: sizes and lengths are asked for, no struct is known.

    shared.py LIBRARY
"""

import ctypes
import sys

library = ctypes.CDLL(sys.argv[1])
TYPES = {"f32": ctypes.c_float, "f64": ctypes.c_double}


def size(name: str, *arguments: int) -> int:
    function = getattr(library, f"kq_{name}")
    function.restype = ctypes.c_uint64 if "_length_" in name else ctypes.c_size_t
    return function(*arguments)


def level(arithmetic: str) -> float:
    """The mean of a level after two measurements"""
    number = TYPES[arithmetic]

    def call(name: str, *arguments: object) -> None:
        status = getattr(library, f"kq_{name}_{arithmetic}")(*arguments)
        if status:
            sys.exit(f"{name}_{arithmetic}: {status}")

    def made(name: str, *sizes: int) -> object:
        thing = ctypes.create_string_buffer(size(f"{name}_size_{arithmetic}"))
        length = size(f"{name}_length_{arithmetic}", sizes[0] if name == "filter" else sizes[-1])
        if name == "process":
            length = size(f"process_length_{arithmetic}", sizes[0])
        memory = (number * length)()
        kept.append(memory)
        call(f"{name}_assign", thing, *sizes, memory, ctypes.c_size_t(length))
        return thing

    kept: list[object] = []
    one = (number * 1)(1)
    four, zero, hundred = (number * 1)(4), (number * 1)(0), (number * 1)(100)
    process, sensor, filter_ = made("process", 1, 0), made("sensor", 1, 1), made("filter", 1)
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
wrong = [name for name, arguments in (
    ("filter_length_f32", (0,)), ("filter_length_q31", (17,)), ("history_length_f64", (2, 0, 1, 0)),
    ("consistency_length_q31", (1, 40000))) if size(name, *arguments) != 0]
if wrong:
    sys.exit(f"a size that is none has a length: {', '.join(wrong)}")
if size("filter_length_f32", 4) != 18 or size("lag_length_f32", 4, 2, 10) * 4 != 3232:
    sys.exit("lengths are not those of size.h")
print("the shared library is called by sizes and lengths alone")
