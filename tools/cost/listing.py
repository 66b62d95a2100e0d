"""The instructions of a program, as objdump lists them."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from commands import run

LINE = re.compile(r"^\s*([0-9a-f]+):\t([0-9a-f ]+?)\s*\t(\S+)(?:\s+(.*))?$")


@dataclass(frozen=True)
class Instruction:
    size: int  # bytes
    mnemonic: str  # without the width of its encoding: ldr, not ldr.w
    operands: str

    @property
    def parts(self) -> list[str]:
        return [part.strip() for part in self.operands.split(",")]


def instructions(objdump: str, program: Path) -> dict[int, Instruction]:
    """By address."""
    text = run([objdump, "-d", str(program)]).splitlines()
    matches = (LINE.match(line) for line in text)
    return {int(match[1], 16): decoded(match) for match in matches if match}


def decoded(match: re.Match[str]) -> Instruction:
    size = len(match[2].replace(" ", "")) // 2
    mnemonic = re.sub(r"\.[nw]$", "", match[3])
    operands = re.split(r"\s*[;@#]\s*0x|\s+[;<@]", match[4] or "")[0]
    return Instruction(size, mnemonic, operands.strip())
