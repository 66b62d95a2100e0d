"""wheel_build.py BUILD: what makes the wheel take long, in its build folder: nothing is compiled at -O3, and what is
unrolled is of sizes that the compiler knows."""

import re
import subprocess
import sys
from pathlib import Path

LARGEST = 20_000  # bytes of a function; the largest of the library at all sizes has some 10,000

build = Path(sys.argv[1])
text = (build / "build.ninja").read_text(encoding="utf-8")
made = re.findall(r"^build (\S+\.o): C_COMPILER.*?^  FLAGS = (.*?)$", text, re.M | re.S)
levels = {Path(name).name: re.findall(r"-O(\S)", flags)[-1] for name, flags in made}
slow = sorted(name for name, level in levels.items() if level not in "02")
print(f"{len(levels)} files, {len(slow)} of them at more than -O2 {' '.join(slow)}")
[module] = build.glob("_core*.so")
listed = subprocess.run(["nm", "-S", "--size-sort", str(module)], check=True, capture_output=True, text=True).stdout
sizes = {line.split()[3]: int(line.split()[1], 16) for line in listed.splitlines() if line.split()[2] in "tT"}
large = {name: size for name, size in sizes.items() if size > LARGEST}
print(f"largest functions: {sorted(sizes.items(), key=lambda one: -one[1])[:3]}")
sys.exit(bool(slow or large) or len(levels) < 20)
