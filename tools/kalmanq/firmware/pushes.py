"""What the emulators do not know of an instruction: how it moves the stack pointer."""

from __future__ import annotations

import re

from kalmanq.firmware.elf import Instruction

REGISTERS = {"sb": 9, "sl": 10, "fp": 11, "ip": 12, "sp": 13, "lr": 14, "pc": 15}


def registers(operands: str) -> list[str]:
    """The names in a list such as {r4, r5-r7, lr}, ranges as they are."""
    found = re.search(r"\{(.*?)\}", operands)
    return [part.strip() for part in found[1].split(",")] if found else []


def number(register: str) -> int:
    return REGISTERS[register] if register in REGISTERS else int(register[1:])


def words(operands: str) -> int:
    """32-bit words of a list of registers."""
    total = 0
    for part in registers(operands):
        first, _, last = part.partition("-")
        count = number(last.strip()) - number(first.strip()) + 1 if last else 1
        total += count * (2 if part.startswith("d") else 1)
    return total


def arm_push(i: Instruction) -> int | None:
    """Bytes by which the stack grows; None: it changes by a number that is not in the text."""
    name, parts = i.mnemonic, i.parts
    if name in ("push", "vpush") or (name.startswith(("stmdb", "vstmdb")) and parts[0] == "sp!"):
        return 4 * words(i.operands)
    if name.startswith("str") and re.search(r"\[sp, #-\d+\]!", i.operands):
        return -constant(i.operands)
    if parts[0] != "sp" or not name.startswith(("sub", "add", "mov")):
        return 0
    if "#" not in i.operands:
        return None
    return constant(i.operands) if name.startswith("sub") else 0


def constant(operands: str) -> int:
    found = re.search(r"#(-?\d+)", operands)
    return int(found[1]) if found else 0


def riscv_push(i: Instruction) -> int | None:
    parts = i.parts
    if parts[0] != "sp" or not i.mnemonic.startswith(("add", "sub", "mv")):
        return 0
    if i.mnemonic != "addi" and not re.fullmatch(r"-?\d+", parts[-1]):
        return None
    return max(0, -int(parts[-1]))


PUSH = {"arm": arm_push, "riscv": riscv_push}
