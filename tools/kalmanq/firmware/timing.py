"""What the emulators do not know of an instruction: cycles, and how it moves the stack pointer.

The cycles are an ESTIMATE for zero wait states, from the timing tables that the makers publish:

    m0          Cortex-M0 TRM: load, store 2, multiple 1 + N; 1-cycle multiplier; taken branch 3
    m3, m4f     Cortex-M3, M4 TRM: load 2, store 1, multiple 1 + N; 32 x 32 -> 64 bits 4 and 5 on
                m3, 1 on m4f; divisions 7 (2 to 12); vfma 3, vdiv and vsqrt 14; a taken branch 3
    m33         as m4f, with 2 for a taken branch (its own table is not published)
    m7          one instruction a cycle; double fma, add, multiply 2, divisions and roots 14 or
                28: an upper bound, for it issues two where it can
    rv32        Ibex, single-cycle multiplier: load, store 2, mul 1, mulh 2, div 37, taken branch 3,
                jump 2

A conditional instruction counts as if its condition held.  AVR's cycles are simavr's, exact.
"""

from __future__ import annotations

import re
from typing import Callable

from kalmanq.firmware.elf import Instruction

# cycles of an instruction, and what a change of the program counter adds
Timing = tuple[Callable[[Instruction], int], int]


# ---- Arm -------------------------------------------------------------------------------------

WIDE_PRODUCTS = ("umull", "smull", "umlal", "smlal", "umaal")
FUSED = ("vfma", "vfms", "vmla", "vmls", "vfnm", "vnml")
ROOTS = ("vdiv", "vsqrt")
MULTIPLE = ("push", "pop", "vpush", "vpop", "ldm", "stm", "vldm", "vstm")
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


def is_double(i: Instruction) -> bool:
    return ".f64" in i.mnemonic or i.operands.startswith("d")


def m0_cycles(i: Instruction) -> int:
    if i.mnemonic.startswith(MULTIPLE):
        return 1 + words(i.operands) + ("pc" in registers(i.operands))
    return 2 if i.mnemonic.startswith(("ldr", "str")) or i.mnemonic == "bl" else 1


def m3_cycles(i: Instruction) -> int:
    if i.mnemonic.startswith(WIDE_PRODUCTS):
        return 4 if i.mnemonic in ("umull", "smull") else 5
    return 2 if i.mnemonic.startswith(("mla", "mls")) else m4_cycles(i)


def m4_cycles(i: Instruction) -> int:
    name = i.mnemonic
    if name.startswith(MULTIPLE):
        return 1 + words(i.operands)
    if name.startswith(("vldr", "vstr")):
        return 3 if is_double(i) else 2
    if name.startswith(("ldrd", "strd")):
        return 3
    if name.startswith(ROOTS):
        return 14
    if name.startswith(FUSED):
        return 3
    if name.startswith(("sdiv", "udiv")):
        return 7
    return 2 if name.startswith(("ldr", "tbb", "tbh")) else 1


def m7_cycles(i: Instruction) -> int:
    name = i.mnemonic
    if name.startswith(MULTIPLE):
        return (words(i.operands) + 1) // 2
    if name.startswith(ROOTS):
        return 28 if is_double(i) else 14
    if name.startswith(("sdiv", "udiv")):
        return 7
    slow = is_double(i) and name.startswith((*FUSED, "vadd", "vsub", "vmul"))
    return 2 if slow else 1


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


# ---- RISC-V ----------------------------------------------------------------------------------


def rv32_cycles(i: Instruction) -> int:
    if i.mnemonic.startswith(("div", "rem")):
        return 37
    memory = i.mnemonic in ("lw", "lh", "lhu", "lb", "lbu", "sw", "sh", "sb")
    return 2 if memory or i.mnemonic.startswith("mulh") else 1


def riscv_push(i: Instruction) -> int | None:
    parts = i.parts
    if parts[0] != "sp" or not i.mnemonic.startswith(("add", "sub", "mv")):
        return 0
    if i.mnemonic != "addi" and not re.fullmatch(r"-?\d+", parts[-1]):
        return None
    return max(0, -int(parts[-1]))


TIMING: dict[str, Timing] = {
    "m0": (m0_cycles, 2), "m3": (m3_cycles, 2), "m4f": (m4_cycles, 2), "m7": (m7_cycles, 1), "m33": (m4_cycles, 1),
    "rv32": (rv32_cycles, 2)}
PUSH = {"arm": arm_push, "riscv": riscv_push}
