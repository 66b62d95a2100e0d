"""The counter of tools/cost.py against QEMU's: f32 on the M4F at -O2.

usage: agreement.py WORK

QEMU counts 2000 times predict and update with the loop around them (tests/target/pair_cost.c), to a
tick of 40 instructions; the loop takes about ten instructions each time.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT / "tools" / "cost"), str(ROOT / "tools")]

from cases import GCC, Choice, programs
from cores import BY_NAME, ask
from measure import measure_all
from errors import TIME_LIMIT

FLAGS = "-std=c11 -O2 -ffp-contract=fast -Iinclude tests/target/pair_cost.c src/kq_filter_f32.c"
LOOP = range(5, 20)  # instructions of the loop, give or take rounding


def main(work: str) -> int:
    theirs = counted_by_qemu(Path(work) / "agreement.elf")
    ours = counted_here()
    print(" n   QEMU's  ours  loop")
    for n, count in theirs.items():
        print(f"{n:2d} {count:8d} {ours[n]:5d} {count - ours[n]:5d}")
    bad = [n for n, count in theirs.items() if count - ours[n] not in LOOP]
    if len(theirs) != 6 or bad:
        print(f"do not agree at n = {bad}" if bad else "a size is missing")
        return 1
    return 0


def counted_by_qemu(program: Path) -> dict[int, int]:
    linker, profile, libraries, emulator = (
        answer.split()
        for answer in ask(BY_NAME["m4f"], "gcc", "linker", "profile", "libraries", "emulator")
    )
    build = [*linker, *profile, *FLAGS.split(), *libraries, "-o", str(program)]
    subprocess.run(build, cwd=ROOT, check=True, capture_output=True)
    counting = [*emulator, str(program), "-icount", "shift=0"]
    done = subprocess.run(counting, check=True, capture_output=True, text=True, timeout=TIME_LIMIT)
    rows = (list(map(int, line.split())) for line in done.stdout.splitlines())
    return {n: count for n, _, count in rows}


def counted_here() -> dict[int, int]:
    choice = Choice(("m4f",), ("f32",), ("runtime",), (GCC,), what=("predict", "update"))
    total: dict[int, int] = {}
    for row in measure_all(ROOT, programs(choice))[0].rows:
        if choice.takes_row(row):
            total[row.n] = total.get(row.n, 0) + row.instructions
    return total


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
