"""Cycles of what the package's emulator has counted.

They are an ESTIMATE for zero wait states, from the timing tables that the makers publish:

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

from typing import Callable

from kalmanq.firmware.elf import Instruction, Listing
from kalmanq.firmware.emulated import Counted
from kalmanq.firmware.pushes import registers, words

# cycles of an instruction, and what a change of the program counter adds
Timing = tuple[Callable[[Instruction], int], int]


# ---- Arm -------------------------------------------------------------------------------------

WIDE_PRODUCTS = ("umull", "smull", "umlal", "smlal", "umaal")
FUSED = ("vfma", "vfms", "vmla", "vmls", "vfnm", "vnml")
ROOTS = ("vdiv", "vsqrt")
MULTIPLE = ("push", "pop", "vpush", "vpop", "ldm", "stm", "vldm", "vstm")


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


# ---- RISC-V ----------------------------------------------------------------------------------


def rv32_cycles(i: Instruction) -> int:
    if i.mnemonic.startswith(("div", "rem")):
        return 37
    memory = i.mnemonic in ("lw", "lh", "lhu", "lb", "lbu", "sw", "sh", "sb")
    return 2 if memory or i.mnemonic.startswith("mulh") else 1


TIMING: dict[str, Timing] = {
    "m0": (m0_cycles, 2), "m3": (m3_cycles, 2), "m4f": (m4_cycles, 2), "m7": (m7_cycles, 1), "m33": (m4_cycles, 1),
    "rv32": (rv32_cycles, 2)}


def cycles(core: str, code: Listing, counted: Counted) -> int:
    of, refill = TIMING[core]
    return refill * (counted.jumps + 1) + sum(times * of(code[address]) for address, times in counted.by_address.items())  # and the return
