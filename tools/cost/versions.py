"""Which compilers made the figures."""

from __future__ import annotations

from commands import run
from cores import CORES, toolchain


def compilers() -> tuple[str, ...]:
    """The first line that each compiler says of itself."""
    names = [toolchain(core, "gcc").compiler[0] for core in CORES]
    names.append(toolchain(CORES[0], "clang").compiler[0])
    return tuple(run([name, "--version"]).splitlines()[0] for name in dict.fromkeys(names))
