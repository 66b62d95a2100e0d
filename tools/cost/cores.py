"""The processors of the package, and what compiles the library for each (tests/target/cores.sh knows)."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from pathlib import Path
from typing import Sequence

from errors import TIME_LIMIT, UserError  # and where the package is
from kalmanq.firmware import cores
from kalmanq.firmware.cores import Core

ROOT = Path(__file__).resolve().parents[2]
ASK = 'root=$0; . "$root/tests/target/cores.sh"; core_select "$1" "$2"; printf "%s\\n" '
KNOWN_AS = {"avr": "atmega1284p"}  # to cores.sh, where it is not the name
run = partial(cores.run, hint="bash -c '. tools/setup.sh && kq_setup cost' installs it", limit=TIME_LIMIT)


@dataclass(frozen=True)
class Toolchain:
    compiler: list[str]
    linker: list[str]  # gcc's
    profile: list[str]  # the library's own flags
    user_profile: list[str]  # and those for functions of compile-time sizes
    port: str  # folder of port/ whose headers replace the portable ones, if there is one


# What does not fit is measured, too, on a part that executes the same (avr_count.c)
LARGE = "-Wl,--defsym=__DATA_REGION_LENGTH__=0xFF00,--defsym=__stack=0xFFFF"
CORES = tuple(replace(core, link_flags=(LARGE,)) if core.family == "avr" else core for core in cores.CORES)
BY_NAME = {core.name: core for core in CORES}


# ---- compilers and the like ------------------------------------------------------------------


@lru_cache(maxsize=None)
def toolchain(core: Core, compiler: str) -> Toolchain:
    *commands, port = ask(core, compiler, "compiler", "gcc", "profile", "user_profile", "port")
    return Toolchain(*(command.split() for command in commands), port)


def ask(core: Core, compiler: str, *variables: str) -> list[str]:
    """What cores.sh sets these to."""
    script = ASK + " ".join(f'"${variable}"' for variable in variables)
    return run(["sh", "-c", script, str(ROOT), KNOWN_AS.get(core.name, core.name), compiler]).splitlines()


def compilers(cores: Sequence[Core] = CORES, with_clang: bool = True) -> tuple[str, ...]:
    """The first line that each compiler says of itself."""
    names = [toolchain(core, "gcc").compiler[0] for core in cores]
    names += [toolchain(CORES[0], "clang").compiler[0]] if with_clang else []
    return tuple(run([name, "--version"]).splitlines()[0] for name in dict.fromkeys(names))


def incomparable(versions: Sequence[str], cores: Sequence[Core] = CORES, with_clang: bool = True) -> str:
    """Why figures of compilers of these versions are not compared with what is measured here, in a line that has CTest skip the test:
    a compiler is missing, or is of another major version.  Empty if they are"""
    known = dict(map(major, versions))
    try:
        others = [one for one in compilers(cores, with_clang) if major(one) not in known.items()]
    except UserError as problem:
        return f"skipped: figures are of cross compilers: {problem}"
    return f"skipped: figures are of {', '.join(known.get(major(one)[0], 'none') for one in others)}, not of {', '.join(others)}" if others else ""


def major(line: str) -> tuple[str, str]:
    """A compiler and its major version, of what it says of itself"""
    name = "clang" if "clang" in line else line.split()[0]
    return name, f"{name} {(re.search(r'(?<![.:-])(?<![0-9])([0-9]+)[.][0-9]+[.][0-9]+', line) or ['', '?'])[1]}"
