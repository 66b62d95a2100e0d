"""kalmanq doctor: what is installed, what is missing, which commands want it, and how to get it."""

from __future__ import annotations

import importlib.util
import os
import platform
import re
import shutil
import subprocess
from dataclasses import dataclass
from importlib import metadata
from typing import Optional, Sequence

from rich.console import Console

from kalmanq.commands.messages import EXTRAS, print_json, table
from kalmanq.commands.options import JSON, command_of
from kalmanq.compiler.run.building import NoCompiler, compiler
from kalmanq.errors import KalmanqError
from kalmanq.tune import emitted
from kalmanq.tune.page import CORE


@dataclass(frozen=True)
class Options:
    json: bool = JSON


@dataclass(frozen=True)
class Found:
    """version: None where it is missing; serves: what wants it"""

    name: str
    version: Optional[str]
    serves: str
    cure: str

    @property
    def state(self) -> str:
        return "missing" if self.version is None else self.version


LOGS = {"gpxpy": "GPX", "pymap3d": "metres of latitude and longitude", "pynmea2": "NMEA", "pyubx2": "UBX", "pyulog": "ULog", "can": "CAN logs", "cantools": "CAN logs",
        "openpyxl": "Excel", "pyarrow": "Parquet, Feather"}
MODULES = {"kalmanq": "all commands", "numpy": "all commands", "scipy": "fit, design, report, compare, simulate --runs", "joblib": "simulate --runs, study", "pandas": "Excel, Parquet, dates such as 31.05.2026", **LOGS, "matplotlib": "--plot, report",
           "PIL": "--plot, report", "jinja2": "the C of compile, check, design, tune and --compiled", "unicorn": "costs of compile, design, report, tune",
           "elftools": "costs of compile, design, report, tune"}
SOURCES = {"can": "python-can", "PIL": "pillow", "elftools": "pyelftools"}
PROGRAMS = (  # what serves the C that design and compile write: on a chip, and on an emulated one
    ("arm-none-eabi-gcc", "C for Cortex-M, and its costs", "gcc-arm-none-eabi libnewlib-arm-none-eabi"),
    ("riscv64-unknown-elf-gcc", "C for RISC-V, and its costs", "gcc-riscv64-unknown-elf picolibc-riscv64-unknown-elf"),
    ("avr-gcc", "C for AVR", "gcc-avr avr-libc"),
    ("qemu-system-arm", "running it on an emulated Cortex-M", "qemu-system-arm"),
    ("qemu-system-riscv32", "running it on an emulated RISC-V", "qemu-system-misc"),
    ("simavr", "running it on an emulated AVR", "simavr"))


def look() -> list[Found]:
    modules = [Found(name, _module(name), serves, _cure(name)) for name, serves in MODULES.items()]
    programs = [Found(name, _program([name]), serves, f"apt install {packages}") for name, serves, packages in PROGRAMS]
    return [Found("python", platform.python_version(), "all commands", ""), *modules, _host_compiler(), _webassembly(), _clang(), *programs]


def _module(name: str) -> Optional[str]:
    if importlib.util.find_spec(name) is None:
        return None
    try:
        return metadata.version(SOURCES.get(name, name))
    except metadata.PackageNotFoundError:
        return "found"


def _cure(name: str) -> str:
    return f"pip install './tools[{EXTRAS[name]}]'" if name in EXTRAS else "pip install ./tools"


def _host_compiler() -> Found:
    serves = "compile, design, fit of nonlinear models, --compiled"
    try:
        name = compiler()
    except NoCompiler:
        return Found("C compiler", None, serves, "apt install gcc, or set CC")
    return Found(f"C compiler ({name})", _program([name]), serves, "apt install gcc, or set CC")


def _webassembly() -> Found:
    return Found("the library in WebAssembly", "found" if CORE.exists() else None, "tune", "apt install clang lld, then install kalmanq again")


def _clang() -> Found:
    try:
        return Found("clang and wasm-ld", _program([emitted.tools()[0]]), "tune of nonlinear models", "apt install clang lld")
    except KalmanqError:
        return Found("clang and wasm-ld", None, "tune of nonlinear models", "apt install clang lld")


def _program(words: Sequence[str]) -> Optional[str]:
    """Of the first line that it says of itself; "found" if it says none"""
    if shutil.which(words[0]) is None:
        return None
    try:
        done = subprocess.run([*words, "--version"], capture_output=True, text=True, timeout=20, env={**os.environ, "LC_ALL": "C"})
    except (OSError, subprocess.TimeoutExpired):
        return "found, but it does not run"
    numbers = re.findall(r"\d+\.\d+(?:\.\d+)?", re.sub(r"\(.*?\)", "", done.stdout.split("\n")[0]))
    return numbers[0] if numbers and done.returncode == 0 else "found"


def tell(options: Options, console: Console) -> None:
    found = look()
    if options.json:
        return print_json([{"name": one.name, "version": one.version, "serves": one.serves, "cure": one.cure} for one in found])
    made = table("what", "version", "for", "if missing", title="kalmanq doctor")
    for one in found:
        made.add_row(one.name, one.state, one.serves, one.cure if one.version is None else "")
    console.print(made)
    missing = sum(one.version is None for one in found)
    console.print(f"{missing} missing; each is for the commands of its row alone" if missing else "nothing is missing")


command = command_of(Options, tell)
