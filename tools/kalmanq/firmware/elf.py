"""What a program's ELF file says: symbols, bytes to load, bytes in flash; and the instructions in
it, as objdump lists them."""

from __future__ import annotations

import bisect
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Iterator

from elftools.elf.elffile import ELFFile
from elftools.elf.sections import SymbolTableSection

from kalmanq.firmware.cores import NotMeasured, run

WRITABLE, ALLOCATED, WITHOUT_BYTES = 1, 2, "SHT_NOBITS"
LINE = re.compile(r"^ *([0-9a-f]+):\t([0-9a-f ]+?) *\t(\S+)(?:[ \t]+(.*))?$", re.MULTILINE)
WIDTH = re.compile(r"\.[nw]$")
REMARK = re.compile(r"\s*[;@#]\s*0x|\s+[;<@]")


class Elf:
    def __init__(self, path: Path):
        self.path = path
        with open(path, "rb") as file:
            elf = ELFFile(file)
            arm = elf["e_machine"] == "EM_ARM"
            self.entry: int = elf["e_entry"]
            self.segments = list(segments(elf))
            self.symbols, functions = symbols(elf, ~1 if arm else ~0)
        self.functions = sorted(functions)

    def address(self, name: str) -> int:
        if name not in self.symbols:
            raise NotMeasured(f"{self.path.name}: has no function {name}")
        return self.symbols[name]

    def function_at(self, address: int) -> str:
        index = bisect.bisect_right(self.functions, (address, "\x7f")) - 1
        return self.functions[index][1] if index >= 0 else "?"


def segments(elf: ELFFile) -> Iterator[tuple[int, bytes]]:
    for segment in elf.iter_segments():
        if segment["p_type"] == "PT_LOAD" and segment["p_filesz"]:
            yield segment["p_vaddr"], segment.data()


def flash_and_ram(path: Path) -> tuple[int, int]:
    """Code, constants and the initial values of variables; the variables."""
    with open(path, "rb") as file:
        sections = [s for s in ELFFile(file).iter_sections() if s["sh_flags"] & ALLOCATED]
        flash = sum(s["sh_size"] for s in sections if s["sh_type"] != WITHOUT_BYTES)
        return flash, sum(s["sh_size"] for s in sections if s["sh_flags"] & WRITABLE)


def symbols(elf: ELFFile, mask: int) -> tuple[dict[str, int], set[tuple[int, str]]]:
    """Addresses by name, and the functions; the mask takes Thumb's bit away."""
    found: dict[str, int] = {}
    functions = set()
    table = elf.get_section_by_name(".symtab")
    for symbol in table.iter_symbols() if isinstance(table, SymbolTableSection) else ():
        kind = symbol["st_info"]["type"]
        if symbol.name and symbol["st_shndx"] != "SHN_UNDEF":
            found.setdefault(symbol.name, symbol["st_value"] & mask)
            if is_code(symbol.name, kind):
                functions.add((symbol["st_value"] & mask, symbol.name))
    return found, functions


def is_code(name: str, kind: str) -> bool:
    """Helpers written in assembler are often without a type; $t and the like are not names."""
    return kind == "STT_FUNC" or (kind == "STT_NOTYPE" and not name.startswith(("$", ".L")))


# ---- instructions ----------------------------------------------------------------------------


@dataclass(frozen=True)
class Instruction:
    size: int  # bytes
    mnemonic: str  # without the width of its encoding: ldr, not ldr.w
    operands: str

    @property
    def parts(self) -> list[str]:
        return [part.strip() for part in self.operands.split(",")]


class Listing:
    """By address; most of a program is never looked at, so decoded late."""

    def __init__(self, objdump: str, program: Path):
        text = run([objdump, "-d", str(program)])
        self.lines = {int(match[1], 16): match for match in LINE.finditer(text)}
        self.known: dict[int, Instruction] = {}

    def __contains__(self, address: int) -> bool:
        return address in self.lines

    def __getitem__(self, address: int) -> Instruction:
        if address not in self.known:
            self.known[address] = decoded(self.lines[address])
        return self.known[address]

    def with_operand(self, text: str) -> dict[int, Instruction]:
        found = (at for at, match in self.lines.items() if (match[4] or "").startswith(text))
        return {address: self[address] for address in found}


def decoded(match: re.Match[str]) -> Instruction:
    size = len(match[2].replace(" ", "")) // 2
    return Instruction(size, WIDTH.sub("", match[3]), REMARK.split(match[4] or "")[0].strip())
