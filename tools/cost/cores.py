"""The processors: how to compile for each, and how to emulate it.  The one place to add another."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Core:
    name: str
    description: str
    family: str  # arm, riscv or avr: which emulator and which timing
    prefix: str  # of the compiler and its binutils
    flags: tuple[str, ...]
    arithmetics: tuple[str, ...]  # of the library, at run-time sizes
    port: str | None = None  # folder of port/ whose headers replace the portable ones, if it exists
    model: str = ""  # of the emulator
    link_flags: tuple[str, ...] = ()


def arm(
    name: str, description: str, flags: tuple[str, ...], port: str, model: str | None = None
) -> Core:
    return Core(
        name,
        description,
        family="arm",
        prefix="arm-none-eabi-",
        flags=("-mthumb", *flags),
        arithmetics=("f32", "f64", "q31"),
        port=port,
        model=model or f"CORTEX_{name.upper()}",
    )


M4F = ("-mcpu=cortex-m4", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16")
M7 = ("-mcpu=cortex-m7", "-mfloat-abi=hard", "-mfpu=fpv5-d16")
M33 = ("-mcpu=cortex-m33", "-mfloat-abi=hard", "-mfpu=fpv5-sp-d16")

CORES = (
    arm("m0", "Cortex-M0", ("-mcpu=cortex-m0",), "armv6m"),
    arm("m3", "Cortex-M3", ("-mcpu=cortex-m3",), "armv7m"),
    arm("m4f", "Cortex-M4F", M4F, "armv7m", model="CORTEX_M4"),
    # Unicorn's M7 has no double: the largest A core executes the same instructions
    arm("m7", "Cortex-M7, double FPU", M7, "armv7m", model="MAX"),
    arm("m33", "Cortex-M33, FPU", M33, "armv7m"),
    Core(
        "rv32",
        "RISC-V RV32IMAC",
        family="riscv",
        prefix="riscv64-unknown-elf-",
        flags=("-march=rv32imac", "-mabi=ilp32", "--specs=picolibc.specs"),
        arithmetics=("f32", "f64", "q31"),
        # picolibc's default is a small board
        link_flags=("-Wl,--defsym=__ram_size=0x1000000", "-Wl,--defsym=__flash_size=0x400000"),
    ),
    Core(
        "avr",
        "AVR ATmega2560",
        family="avr",
        prefix="avr-",
        flags=("-mmcu=atmega2560",),
        arithmetics=("f32", "q31"),  # its double is a float
        port="avr",
    ),
)

BY_NAME = {core.name: core for core in CORES}
