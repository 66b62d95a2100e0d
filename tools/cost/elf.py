"""What an ELF file says: symbols, bytes to load, bytes in flash."""

from __future__ import annotations

import bisect
from pathlib import Path
from typing import Iterator

from elftools.elf.elffile import ELFFile
from elftools.elf.sections import SymbolTableSection

from errors import CostError

WRITABLE, ALLOCATED, WITHOUT_BYTES = 1, 2, "SHT_NOBITS"


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
            raise CostError(f"{self.path.name}: has no function {name}")
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
