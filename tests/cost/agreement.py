"""The counter of tools/cost.py against QEMU's: f32 on the M4F at -O2.

usage: agreement.py WORK

QEMU counts 2000 times predict and update with the loop around them (tests/target/pair_cost.c), to a
tick of 40 instructions; the loop takes about ten instructions each time.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools" / "cost"))

from cases import GCC, Choice, programs
from run_all import run_all

COMPILE = (
    "arm-none-eabi-gcc -mthumb -mcpu=cortex-m4 -mfloat-abi=hard -mfpu=fpv4-sp-d16 -std=c11 -O2 "
    "-ffp-contract=fast -fno-math-errno -fno-tree-loop-distribute-patterns -Iinclude "
    "tests/target/pair_cost.c port/boards/cortex_m.c "
    "src/kq_filter_f32.c --specs=rdimon.specs -nostartfiles -Lport/boards -T port/boards/mps2.ld -lm -o"
)
EMULATE = "qemu-system-arm -M mps2-an386 -nographic -semihosting -icount shift=0 -kernel"
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
    subprocess.run([*COMPILE.split(), str(program)], cwd=ROOT, check=True, capture_output=True)
    done = subprocess.run(
        [*EMULATE.split(), str(program)], check=True, capture_output=True, text=True,
        timeout=float(os.environ.get("KQ_TIME_LIMIT", "1800")),
    )
    rows = (list(map(int, line.split())) for line in done.stdout.splitlines())
    return {n: count for n, _, count in rows}


def counted_here() -> dict[int, int]:
    choice = Choice(("m4f",), ("f32",), ("runtime",), (GCC,), what=("predict", "update"))
    total: dict[int, int] = {}
    for row in run_all(ROOT, programs(choice))[0].rows:
        if choice.takes_row(row):
            total[row.n] = total.get(row.n, 0) + row.instructions
    return total


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
