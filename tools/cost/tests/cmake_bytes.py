"""The library as CMake builds it for a core, by the preset `cross`, beside the cost table.

    cmake_bytes.py WORK

A program that links CMake's own library takes the bytes that the tool's flags give, and what the table says of it, if its gcc is of the
same major version.
"""

from __future__ import annotations

import shutil
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT / "tools" / "cost"), str(ROOT / "tools")]

import build
import table
from build import Place
from cases import FILTER, GCC, LEAN, RUNTIME, Program
from cores import BY_NAME, incomparable, run
from kalmanq.firmware.elf import flash_and_ram

CORE, SIZE = "m4f", (4, 2)  # of the preset
WHAT = ("step", LEAN, "smooth")
TOLERANCE = 0.03  # of the table, as --check has it


def flash(parts: list[Path], folder: Path, what: str) -> int:
    """Of a program that does this, beside one that does nothing."""
    names = (f"use_{each}_{SIZE[0]}_{SIZE[1]}" for each in (what, "nothing"))
    made = [flash_and_ram(build.linked(BY_NAME[CORE], parts, folder / f"{name}.elf", entry=name))[0] for name in names]
    return made[0] - made[1]


def compared(place: Place, arithmetic: str, library: Path) -> int:
    """How many of its programs are not what they have to be."""
    wanted = Program(CORE, arithmetic, RUNTIME, GCC, (SIZE,), FILTER)
    build.library(place, build.library_key(wanted))
    build.program(place, wanted)
    own = sorted((place.work / wanted.name).glob("*.o"))
    rows = {row.key: row.flash_program for row in table.read(ROOT / "tools" / "cost.csv").rows}
    wrong = 0
    for what in WHAT:
        by_cmake = flash([*own, library], place.work / wanted.name, what)
        by_tool = flash(build.objects(place, wanted), place.work / wanted.name, what)
        published = rows[CORE, arithmetic, *SIZE, RUNTIME, GCC, what]
        is_right = by_cmake == by_tool and abs(by_cmake - published) <= TOLERANCE * published
        wrong += not is_right
        print(f"{CORE} {arithmetic} {SIZE} {what}: {by_cmake} bytes by CMake, {by_tool} by the tool's flags, {published} "
              f"in the table{'' if is_right else '  WRONG'}")
    return wrong


def main(work: Path) -> int:
    if reason := incomparable(table.read(ROOT / "tools" / "cost.csv").versions, [BY_NAME[CORE]], with_clang=False):
        print(reason)
        return 0
    shutil.rmtree(work, ignore_errors=True)
    run(["cmake", "--preset", "cross", "-S", str(ROOT), "-B", str(work)])
    run(["cmake", "--build", str(work)])
    with tempfile.TemporaryDirectory(prefix="kalmanq-cost-") as folder:
        place = Place(ROOT, Path(folder))
        build.model_printer(place)
        return sum(compared(place, arithmetic, work / "libkalmanq.a") for arithmetic in ("f32", "q31"))


if __name__ == "__main__":
    sys.exit(1 if main(Path(sys.argv[1])) else 0)
