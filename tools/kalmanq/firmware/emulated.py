"""Counts what an Arm or a RISC-V core executes within a call, with Unicorn.

The program runs at full speed until it announces a region (target/marks.c) and then enters the
function that the region is about; from there to its return every basic block is counted.  A region
without a function lasts until the next mark.  A block's instructions all count: an instruction of
an IT block whose condition fails takes its turn, too, on the hardware.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Callable

import unicorn
from unicorn import arm_const, riscv_const

from kalmanq.firmware.cores import Core, NotMeasured
from kalmanq.firmware.elf import Elf, Listing
from kalmanq.firmware.pushes import PUSH

MEMORY = (0, 0x1000_0000, 0x2000_0000)  # where the linkers put code and data
MEMORY_SIZE = 0x0400_0000
STACK = MEMORY_SIZE - 0x100  # at the end of the first
NOWHERE = MEMORY_SIZE - 4
CONTROL_SPACE, CONTROL_SIZE = 0xE000_0000, 0x0010_0000
COPROCESSORS = 0xE000_ED88  # CPACR: enables the FPU
FPU_ACCESS = 0xF << 20


@dataclass
class Counted:
    """jumps: how often it went on elsewhere than at the next address; by_address: how often each instruction was executed"""

    instructions: int = 0
    stack: int = 0
    jumps: int = 0
    by_address: Counter[int] = field(default_factory=Counter)


def most(calls: list[Counted]) -> Counted:
    """Of calls of the same region: the one with most instructions, and the deepest stack of all."""
    longest = max(calls, key=lambda call: call.instructions)
    return replace(longest, stack=max(call.stack for call in calls))


@dataclass(frozen=True)
class Registers:
    pc: int
    sp: int
    link: int
    argument: int

ARM = Registers(arm_const.UC_ARM_REG_PC, arm_const.UC_ARM_REG_SP, arm_const.UC_ARM_REG_LR, arm_const.UC_ARM_REG_R0)
RISCV = Registers(
    riscv_const.UC_RISCV_REG_PC, riscv_const.UC_RISCV_REG_SP, riscv_const.UC_RISCV_REG_RA, riscv_const.UC_RISCV_REG_A0)


class Emulator:
    def __init__(self, core: Core, program: Path):
        self.core = core
        self.elf = Elf(program)
        self.code = Listing(f"{core.prefix}objdump", program)
        self.blocks: dict[tuple[int, int], Block] = {}  # by address and size
        self.unknown_pushes = unknown_pushes(core, self.code)
        self.thumb = int(core.family == "arm")
        self.registers = ARM if core.family == "arm" else RISCV
        self.uc = machine(core)
        for place in MEMORY:
            self.uc.mem_map(place, MEMORY_SIZE)
        for address, data in self.elf.segments:
            self.uc.mem_write(address, data)
        self.uc.reg_write(self.registers.sp, STACK)
        if core.family == "arm":
            self.enable_fpu()
        elif "__global_pointer$" in self.elf.symbols:
            pointer = self.elf.symbols["__global_pointer$"]
            self.uc.reg_write(riscv_const.UC_RISCV_REG_GP, pointer)

    def enable_fpu(self) -> None:
        """As the start-up code of an M core, or of the A core that stands for one."""
        self.uc.mem_map(CONTROL_SPACE, CONTROL_SIZE)
        self.uc.mem_write(COPROCESSORS, FPU_ACCESS.to_bytes(4, "little"))
        self.uc.reg_write(arm_const.UC_ARM_REG_C1_C0_2, FPU_ACCESS)
        self.uc.reg_write(arm_const.UC_ARM_REG_FPEXC, 0x4000_0000)

    def count_regions(self, functions: dict[int, str]) -> dict[int, Counted]:
        found: dict[int, list[Counted]] = {}
        marks = {name: self.elf.address(f"cost_{name}") for name in ("region", "failed", "end")}
        places = list(marks.values())
        pc = self.run_to(self.elf.address("main"), places)
        while pc == marks["region"]:
            region = self.uc.reg_read(self.registers.argument)
            call = Counted()
            found.setdefault(region, []).append(call)
            if region in functions:
                pc = self.run_to(pc, [self.elf.address(functions[region])])
                pc = self.run_to(self.count(pc, self.run_back, call), places)
            else:
                pc = self.run_to(pc, [self.back()])
                pc = self.count(pc, lambda pc: self.run_to(pc, places), call)
        if pc == marks["failed"]:
            answer = signed(self.uc.reg_read(self.registers.argument))
            raise NotMeasured(f"{self.elf.path.name}: a call answered {answer}")
        return {region: most(calls) for region, calls in found.items()}

    # ---- running -----------------------------------------------------------------------------

    def run_to(self, pc: int, places: list[int]) -> int:
        stop = [
            self.uc.hook_add(unicorn.UC_HOOK_CODE, lambda uc, *_: uc.emu_stop(), None, place, place)
            for place in places
            if place != pc
        ]
        reached = self.run(pc, NOWHERE)
        for hook in stop:
            self.uc.hook_del(hook)
        if reached not in places:
            raise NotMeasured(f"{self.elf.path.name}: stopped in {self.elf.function_at(reached)}")
        return reached

    def run(self, pc: int, until: int) -> int:
        for address, data in self.elf.segments:  # or code that was translated before would miss the hooks
            self.uc.ctl_remove_cache(address, address + len(data))
        try:
            self.uc.emu_start(pc | self.thumb, until)
        except unicorn.UcError as problem:
            where = self.elf.function_at(self.uc.reg_read(self.registers.pc))
            raise NotMeasured(f"{self.elf.path.name}: {problem} in {where}") from problem
        return self.uc.reg_read(self.registers.pc)

    # ---- counting ----------------------------------------------------------------------------

    def back(self) -> int:
        """Where the function that has just been entered returns to."""
        return self.uc.reg_read(self.registers.link) & ~1

    def run_back(self, pc: int) -> int:
        """From a function's first instruction to its return."""
        back = self.back()
        if self.run(pc, back) != back:
            raise NotMeasured(f"{self.elf.path.name}: no return from {self.elf.function_at(pc)}")
        return back

    def count(self, pc: int, run: Callable[[int], int], counted: Counted) -> int:
        """What `run` executes, which answers where it has ended."""
        blocks = Blocks(self)
        hook = self.uc.hook_add(unicorn.UC_HOOK_BLOCK, blocks.enter)
        others = [
            self.uc.hook_add(unicorn.UC_HOOK_CODE, blocks.look, None, place, place)
            for place in self.unknown_pushes
        ]
        reached = run(pc)
        for each in (hook, *others):
            self.uc.hook_del(each)
        blocks.add_up(counted)
        return reached

    def block(self, address: int, size: int) -> Block:
        """What is known of a basic block, learnt once."""
        if (address, size) not in self.blocks:
            self.blocks[address, size] = self.learnt(address, address + size)
        return self.blocks[address, size]

    def learnt(self, address: int, end: int) -> Block:
        push = PUSH[self.core.family]
        block = Block(end)
        while address < end:
            if address not in self.code:
                raise NotMeasured(f"{self.elf.path.name}: no instruction listed at {address:#x}")
            instruction = self.code[address]
            block.addresses.append(address)
            block.push += push(instruction) or 0
            address += instruction.size
        return block


@dataclass
class Block:
    end: int
    addresses: list[int] = field(default_factory=list)
    push: int = 0  # bytes


class Blocks:
    """The basic blocks of one call, as they are entered."""

    def __init__(self, emulator: Emulator):
        self.emulator = emulator
        self.sp = emulator.registers.sp
        self.top = self.lowest = emulator.uc.reg_read(self.sp)
        self.times: Counter[tuple[int, int]] = Counter()  # by address and size
        self.expected = 0
        self.jumps = -1  # the first block follows nothing

    def enter(self, uc: unicorn.Uc, address: int, size: int, _: object) -> None:
        block = self.emulator.block(address, size)
        self.times[address, size] += 1
        if address != self.expected:
            self.jumps += 1
        self.expected = block.end
        if block.push:
            self.lowest = min(self.lowest, uc.reg_read(self.sp) - block.push)

    def look(self, uc: unicorn.Uc, *_: object) -> None:
        self.lowest = min(self.lowest, uc.reg_read(self.sp))

    def add_up(self, counted: Counted) -> None:
        counted.stack, counted.jumps = self.top - self.lowest, self.jumps
        for key, times in self.times.items():
            block = self.emulator.block(*key)
            counted.instructions += times * len(block.addresses)
            for address in block.addresses:
                counted.by_address[address] += times


def machine(core: Core) -> unicorn.Uc:
    if core.family == "riscv":
        return unicorn.Uc(unicorn.UC_ARCH_RISCV, unicorn.UC_MODE_RISCV32)
    profile = unicorn.UC_MODE_MCLASS if core.model.startswith("CORTEX_M") else 0
    uc = unicorn.Uc(unicorn.UC_ARCH_ARM, unicorn.UC_MODE_THUMB | profile)
    uc.ctl_set_cpu_model(getattr(arm_const, f"UC_CPU_ARM_{core.model}"))
    return uc


def unknown_pushes(core: Core, code: Listing) -> list[int]:
    """Where to look, for the text does not say how far the stack pointer has moved."""
    push = PUSH[core.family]
    changes = code.with_operand("sp,")
    return [address + i.size for address, i in changes.items() if push(i) is None]


def signed(word: int) -> int:
    return word - (1 << 32) if word >> 31 else word
