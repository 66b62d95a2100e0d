"""The instructions of a program, as objdump lists them."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from commands import run

LINE = re.compile(r"^ *([0-9a-f]+):\t([0-9a-f ]+?) *\t(\S+)(?:[ \t]+(.*))?$", re.MULTILINE)
WIDTH = re.compile(r"\.[nw]$")
REMARK = re.compile(r"\s*[;@#]\s*0x|\s+[;<@]")


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
        """Those whose first operand is this."""
        found = (at for at, match in self.lines.items() if (match[4] or "").startswith(text))
        return {address: self[address] for address in found}


def decoded(match: re.Match[str]) -> Instruction:
    size = len(match[2].replace(" ", "")) // 2
    return Instruction(size, WIDTH.sub("", match[3]), REMARK.split(match[4] or "")[0].strip())
