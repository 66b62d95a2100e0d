#!/usr/bin/env python3
"""What the steady-state filter's step costs at n, m = 4, 2: instructions, cycles, stack and flash.

  tools/cost/steady.py [--check]     --check: fails where a goal is missed

As tools/cost.py, gcc -O2, with its emulators (tools/setup.sh: kq_setup cost).  The kinematic A is
that of tools/cost/README.md, the dense one has no 0, and neither has its H.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

sys.dont_write_bytecode = True
HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

import build
from build import Place
from cores import BY_NAME
from elf import flash_bytes
from emulator import Emulator

CASES = (("m4f", "f32"), ("m33", "f32"), ("m7", "f64"))
CASES += (("m3", "q31"), ("m0", "q31"), ("rv32", "q31"))
GOALS = {("m4f", "f32"): 90, ("m3", "q31"): 500}  # of the form for known sizes, A upper triangular
STATE_RANGES, MEASURED_RANGES = (1000.0, 1000.0, 100.0, 100.0), (1000.0, 1000.0)

DT = 0.1
A_KINEMATIC = [[float(i == j) + DT * (j == i + 2) for j in range(4)] for i in range(4)]
A_FULL = [[0.9 * (i == j) + 0.05 + 0.01 * (i - j) for j in range(4)] for i in range(4)]
H_KINEMATIC = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0]]
H_FULL = [[1.0, 0.1, 0.2, 0.3], [0.3, 1.0, 0.1, 0.2]]
GAIN = [[0.33, 0.01], [0.01, 0.33], [0.19, 0.005], [0.005, 0.19]]
Q = [[0.02 if i == j else 0.001 for j in range(4)] for i in range(4)]
MATRICES = {"A_kinematic": A_KINEMATIC, "A_full": A_FULL, "H_kinematic": H_KINEMATIC,
            "H_full": H_FULL, "K": GAIN}  # fmt: skip


def floating(type_name: str) -> str:
    """The model as C arrays."""
    lines = [
        f"static const {type_name} {name}[] = {{{', '.join(f'{a!r}' for row in M for a in row)}}};"
        for name, M in {**MATRICES, "Q": Q, "R": [[0.5, 0.5]], "z": [[1.0, 2.0]]}.items()
    ]
    return "\n".join(lines) + "\n"


def fraction_of(limit: float) -> int:
    fraction = 31
    while limit * 2.0**fraction >= 2**31:
        fraction -= 1
    return fraction


def scaled(value: float) -> str:
    if value == 0:
        return "{0, 0}"
    exponent = 0
    while abs(value) * 2.0**-exponent >= 2**31 - 0.5:
        exponent += 1
    while abs(value) * 2.0**-exponent < 2**30:
        exponent -= 1
    return f"{{{round(value * 2.0**-exponent)}, {exponent}}}"


def fixed_point() -> str:
    state = [fraction_of(limit) for limit in STATE_RANGES]
    measured = [fraction_of(limit) for limit in MEASURED_RANGES]
    units = {"A": (state, state), "H": (measured, state), "K": (state, measured)}
    lines = []
    for name, M in MATRICES.items():
        rows, columns = units[name[0]]
        entries = [
            scaled(a * 2.0 ** (rows[i] - columns[j]))
            for i, row in enumerate(M)
            for j, a in enumerate(row)
        ]
        lines.append(f"static const kq_scaled_q31 {name}[] = {{{', '.join(entries)}}};")
    for name, limits, fractions in (
        ("state", STATE_RANGES, state),
        ("measured", MEASURED_RANGES, measured),
    ):
        formats = [f"{{{int(a * 2.0**f)}, {f}}}" for a, f in zip(limits, fractions)]
        lines.append(f"static const kq_format_q31 {name}[] = {{{', '.join(formats)}}};")
    words = [int(a * 2.0**f) for a, f in zip((1.0, 2.0), measured)]
    noise = ", ".join(scaled(0.5 * 4.0**f) for f in measured)
    lines += [
        f"static const int32_t z[] = {{{words[0]}, {words[1]}}};",
        f"static const kq_scaled_q31 R[] = {{{noise}}};",
        "static const int32_t G[KQ_ROOT_LEN_Q31(4)] = {0};",
    ]
    return "\n".join(lines) + "\n"


def measure(place: Place, core_name: str, arithmetic: str) -> list[tuple[int, int, int, int]]:
    """Instructions, cycles, stack and flash of each region."""
    core, folder = BY_NAME[core_name], place.work / f"{core_name}-{arithmetic}"
    folder.mkdir()
    key = (core_name, arithmetic, "O2")
    build.library(place, key)
    text = {"f32": floating("float"), "f64": floating("double")}.get(arithmetic) or fixed_point()
    (folder / "steady_model.h").write_text(text, encoding="utf-8")
    flags = (f"-DKQ_COST_{arithmetic}", f"-I{place.source / 'src'}", f"-I{folder}")
    steady = build.TARGET / "steady.c"
    objects = [
        build.compiled(place, core, "O2", steady, folder / "steady.o", flags),
        build.compiled(place, core, "O2", build.TARGET / "marks.c", folder / "marks.o"),
        *sorted(build.library_folder(place, key).glob("*.o")),
    ]
    program = build.linked(core, objects, folder / "steady.elf")
    names = [f"kq_steady_step_{arithmetic}"] * 2 + ["fixed_upper", "fixed_dense"]
    counted = Emulator(core, program).count(dict(enumerate(names)))
    rows = []
    for region, name in enumerate(names):
        alone = build.linked(core, objects, folder / f"{name}.elf", entry=name)
        call = counted[region]
        rows.append((call.instructions, call.cycles, call.stack, flash_bytes(alone)))
    return rows


def main() -> None:
    missed = False
    print("core arithmetic form                 instructions cycles stack flash")
    with tempfile.TemporaryDirectory(prefix="kalmanq-steady-") as work:
        place = Place(HERE.parents[1], Path(work))
        for case in CASES:
            forms = ("run-time, kinematic", "run-time, dense", "fixed, KQ_UPPER", "fixed, dense")
            for form, row in zip(forms, measure(place, *case)):
                goal = GOALS.get(case) if form == "fixed, KQ_UPPER" else None
                note = f"   goal {goal}" if goal else ""
                figures = f"{row[0]:12} {row[1]:6} {row[2]:5} {row[3]:5}"
                print(f"{case[0]:4} {case[1]:10} {form:20} {figures}{note}")
                missed |= goal is not None and row[0] > goal
    sys.exit("a goal is missed" if missed and "--check" in sys.argv[1:] else 0)


if __name__ == "__main__":
    main()
