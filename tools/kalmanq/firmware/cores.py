"""The processors: what compiles for each, and how it is emulated; and how its tools are run."""

from __future__ import annotations

import subprocess
from dataclasses import dataclass
from typing import Optional, Sequence

HINT = "`kalmanq doctor` says how to get it"
TELLING = ("error: ", "undefined reference", "cannot find", "will not fit")


class NotMeasured(Exception):
    """Why there is no figure: one line, which says what would give it."""


@dataclass(frozen=True)
class Core:
    name: str
    description: str
    family: str  # arm, riscv or avr: which emulator
    gcc: tuple[str, ...]  # with the flags of the core (tests/target/cores.sh has them, too)
    link_flags: tuple[str, ...]
    model: str = ""  # of the emulator
    has_fpu: bool = False
    arithmetics: tuple[str, ...] = ("f32", "f64", "q31")  # of the library, at run-time sizes

    @property
    def prefix(self) -> str:
        return self.gcc[0].removesuffix("gcc")


def _cortex(name: str, description: str, machine: str, model: str) -> Core:
    """newlib-nano is what firmware for small parts is linked with"""
    return Core(name, description, "arm", ("arm-none-eabi-gcc", "-mthumb", *machine.split()), ("--specs=nano.specs",), model, "-mfpu" in machine)


CORES = (
    _cortex("m0", "Cortex-M0", "-mcpu=cortex-m0", "CORTEX_M0"),
    _cortex("m3", "Cortex-M3", "-mcpu=cortex-m3", "CORTEX_M3"),
    _cortex("m4f", "Cortex-M4F", "-mcpu=cortex-m4 -mfloat-abi=hard -mfpu=fpv4-sp-d16", "CORTEX_M4"),
    # Unicorn's M7 has no double: the largest A core executes the same instructions
    _cortex("m7", "Cortex-M7, double FPU", "-mcpu=cortex-m7 -mfloat-abi=hard -mfpu=fpv5-d16", "MAX"),
    _cortex("m33", "Cortex-M33, FPU", "-mcpu=cortex-m33 -mfloat-abi=hard -mfpu=fpv5-sp-d16", "CORTEX_M33"),
    Core("rv32", "RISC-V RV32IMAC", "riscv", ("riscv64-unknown-elf-gcc", "--specs=picolibc.specs", "-march=rv32imac", "-mabi=ilp32"),
         ("-Wl,--defsym=__ram_size=0x1000000", "-Wl,--defsym=__flash_size=0x400000")),  # picolibc's default is a small board
    Core("avr", "ATmega328P", "avr", ("avr-gcc", "-mmcu=atmega328p"), (), arithmetics=("f32", "q31")),  # its double is a float
)
BY_NAME = {core.name: core for core in CORES}


def run(command: Sequence[str], hint: str = HINT, limit: Optional[float] = None) -> str:
    """What the command prints, or NotMeasured with the first line of its complaint.  limit: seconds"""
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=limit, check=False)
    except OSError as problem:
        raise NotMeasured(f"{command[0]}: {problem.strerror}; {hint}") from problem
    except subprocess.TimeoutExpired as problem:
        raise NotMeasured(f"{command[0]}: no answer within {limit:g} s") from problem
    if done.returncode:
        raise NotMeasured(f"{command[0]}: {complaint(done.stderr or done.stdout)}")
    return done.stdout


def complaint(text: str) -> str:
    lines = [line for line in text.splitlines() if line.strip()] or ["failed"]
    errors = [line for line in lines if any(word in line for word in TELLING)]
    return one_line((errors or lines)[0].strip(), 300)


def one_line(text: str, longest: int = 200) -> str:
    """The text without line breaks and other control characters, and not too long."""
    shown = "".join(c if c.isprintable() else "?" for c in text)
    return shown if len(shown) <= longest else shown[: longest - 3] + "..."
