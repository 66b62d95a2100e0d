"""The processors: how each is emulated, and what compiles for it (tests/target/cores.sh knows)."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Sequence

from errors import UserError, one_line, run_program

ROOT = Path(__file__).resolve().parents[2]
ASK = 'root=$0; . "$root/tests/target/cores.sh"; core_select "$1" "$2"; printf "%s\\n" '
HINT = "bash -c '. tools/setup.sh && kq_setup cost' installs it"
TELLING = ("error: ", "undefined reference", "cannot find", "will not fit")


@dataclass(frozen=True)
class Core:
    name: str
    description: str
    family: str  # arm, riscv or avr: which emulator and which timing
    arithmetics: tuple[str, ...] = ("f32", "f64", "q31")  # of the library, at run-time sizes
    model: str = ""  # of the emulator
    link_flags: tuple[str, ...] = ()
    known_as: str = ""  # to cores.sh, if it is not the name


@dataclass(frozen=True)
class Toolchain:
    compiler: list[str]
    linker: list[str]  # gcc's
    profile: list[str]  # the library's own flags
    user_profile: list[str]  # and those for functions of compile-time sizes
    port: str  # folder of port/ whose headers replace the portable ones, if there is one

    @property
    def prefix(self) -> str:
        return self.linker[0].removesuffix("gcc")

NANO = ("--specs=nano.specs",)  # of newlib: what firmware for small parts is linked with

CORES = (
    Core("m0", "Cortex-M0", "arm", model="CORTEX_M0", link_flags=NANO),
    Core("m3", "Cortex-M3", "arm", model="CORTEX_M3", link_flags=NANO),
    Core("m4f", "Cortex-M4F", "arm", model="CORTEX_M4", link_flags=NANO),
    # Unicorn's M7 has no double: the largest A core executes the same instructions
    Core("m7", "Cortex-M7, double FPU", "arm", model="MAX", link_flags=NANO),
    Core("m33", "Cortex-M33, FPU", "arm", model="CORTEX_M33", link_flags=NANO),
    Core(
        "rv32",
        "RISC-V RV32IMAC",
        "riscv",
        # picolibc's default is a small board
        link_flags=("-Wl,--defsym=__ram_size=0x1000000", "-Wl,--defsym=__flash_size=0x400000"),
    ),
    Core(
        "avr",
        "ATmega328P",
        "avr",
        arithmetics=("f32", "q31"),  # its double is a float
        # what does not fit is measured, too, on one that executes the same (avr_count.c)
        link_flags=("-Wl,--defsym=__DATA_REGION_LENGTH__=0xFF00,--defsym=__stack=0xFFFF",),
        known_as="atmega1284p",
    ),
)

BY_NAME = {core.name: core for core in CORES}


# ---- compilers and the like ------------------------------------------------------------------


@lru_cache(maxsize=None)
def toolchain(core: Core, compiler: str) -> Toolchain:
    *commands, port = ask(core, compiler, "compiler", "gcc", "profile", "user_profile", "port")
    return Toolchain(*(command.split() for command in commands), port)


def ask(core: Core, compiler: str, *variables: str) -> list[str]:
    """What cores.sh sets these to."""
    script = ASK + " ".join(f'"${variable}"' for variable in variables)
    return run(["sh", "-c", script, str(ROOT), core.known_as or core.name, compiler]).splitlines()


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


def run(command: Sequence[str]) -> str:
    """What the command prints, or a UserError with the first line of its complaint."""
    done = run_program(command, HINT)
    if done.returncode:
        raise UserError(f"{command[0]}: {complaint(done.stderr or done.stdout)}")
    return done.stdout


def complaint(text: str) -> str:
    lines = [line for line in text.splitlines() if line.strip()] or ["failed"]
    errors = [line for line in lines if any(word in line for word in TELLING)]
    return one_line((errors or lines)[0].strip(), 300)
