#!/usr/bin/env python3
"""search.py: the dearest predict, update and step that a search finds, beside those of the table's hard inputs.

Inputs are drawn by a text of genes (target/found.inc): model, covariances, means and measurements, from ordinary to absurd.  For each
function a climb changes genes of the dearest so far, and begins anew where nothing has come of it for a while; seeds are fixed.  Fails
where a call is dearer than the dearest of the table's hard inputs, among which is what was found before (target/found.h).
search.py --write SEED goes on from there, with another seed, and writes it."""

from __future__ import annotations

import ctypes
import random
import re
import sys
import tempfile
from dataclasses import dataclass
from functools import partial
from multiprocessing import get_context
from pathlib import Path

import build
import emulators
import unicorn
from build import TARGET, Place
from cases import FILTER, GCC, HARD, RUNTIME, SIZES, Program
from cores import BY_NAME, ROOT, run
from emulators import Emulator

FUNCTIONS = ("predict", "update", "step")
ON = (("m4f", "f32"), ("m4f", "q31"), ("m0", "f32"), ("m0", "q31"))
LETTERS = "0123456789abcdefghijklmnopqrstuv"
GENES = 58
TRIES = {1: 1200, 2: 1600, 3: 1600, 4: 1200, 6: 800, 9: 600}  # of each function
PATIENCE = 150
BLOCKS = 8  # UC_HOOK_BLOCK
FOUND = TARGET / "found.h"
MAIN = f"char searched[{GENES + 1}];\n"


class Counter(ctypes.Structure):
    """As target/counter.c has it"""

    _fields_ = [("most", ctypes.c_uint64 * 3), ("now", ctypes.c_uint64), ("entry", ctypes.c_uint32 * 3), ("mark", ctypes.c_uint32),
                ("own", ctypes.c_uint32 * 4), ("base", ctypes.c_uint32), ("is_announced", ctypes.c_uint32), ("inside", ctypes.c_int32),
                ("before", ctypes.c_void_p)]


@dataclass(frozen=True)
class Task:
    core: str
    arithmetic: str
    n: int
    m: int

    @property
    def program(self) -> Program:
        return Program(self.core, self.arithmetic, RUNTIME, GCC, SIZES, FILTER)


# ---- one call --------------------------------------------------------------------------------


class Probe:
    """A program that draws a model of genes and calls it."""

    def __init__(self, place: Place, task: Task):
        entry = f"probe_{task.n}_{task.m}"
        target = place.work / f"{entry}-{task.core}-{task.arithmetic}.elf"
        build.linked(BY_NAME[task.core], build.objects(place, task.program), target, entry=entry)
        self.emulator = Emulator(BY_NAME[task.core], target)
        elf = self.emulator.elf
        self.start, self.end, self.genes = (elf.address(name) for name in (entry, "cost_end", "searched"))
        self.counter = Counter(mark=elf.address("cost_region"), inside=-1)
        self.counter.entry[:] = [elf.address(f"kq_{name}_{task.arithmetic}") for name in FUNCTIONS]
        self.counter.own[:] = [at for name in (entry, f"run_found_{task.n}_{task.m}") for at in self.extent(name)]
        self.number_instructions()
        self.library = ctypes.CDLL(str(place.work / "counter.so"))
        self.hang_in()

    def extent(self, name: str) -> tuple[int, int]:
        """Where a function begins and ends; one that is a part of another one is nowhere"""
        functions = self.emulator.elf.functions
        begin = self.emulator.elf.symbols.get(name, 0)
        return (begin, min((at for at, _ in functions if at > begin), default=begin)) if begin else (0, 0)

    def number_instructions(self) -> None:
        code = self.emulator.code
        addresses = sorted(code.lines)
        base, end = addresses[0], addresses[-1] + 8
        starts, count = set(addresses), 0
        self.before = (ctypes.c_uint32 * ((end - base) // 2 + 1))()
        for k in range(len(self.before)):
            self.before[k] = count
            count += base + 2 * k in starts
        self.counter.base, self.counter.before = base, ctypes.addressof(self.before)

    def hang_in(self) -> None:
        handle = ctypes.c_size_t()
        add = unicorn.unicorn_py3.unicorn.uclib.uc_hook_add
        status = add(self.emulator.uc._uch, ctypes.byref(handle), BLOCKS, ctypes.cast(self.library.entered, ctypes.c_void_p),
                     ctypes.byref(self.counter), ctypes.c_uint64(1), ctypes.c_uint64(0))
        assert status == 0, status

    def count(self, genes: str) -> tuple[int, ...]:
        """Instructions of each function, 0 of what was refused"""
        uc, counter = self.emulator.uc, self.counter
        counter.most[:] = [0, 0, 0]
        counter.is_announced, counter.inside = 0, -1
        uc.mem_write(self.genes, genes.encode() + b"\0")
        uc.reg_write(self.emulator.registers.sp, 0x0400_0000 - 0x100)
        uc.emu_start(self.start | self.emulator.thumb, self.end)
        return tuple(counter.most)


# ---- the search ------------------------------------------------------------------------------


def drawn(chance: random.Random) -> str:
    return "".join(chance.choice(LETTERS) for _ in range(GENES))


def changed(chance: random.Random, genes: str) -> str:
    """Some genes anew, or a little more or less of them"""
    now = list(genes)
    for _ in range(chance.choice((1, 1, 2, 3, 6))):
        k = chance.randrange(GENES)
        old = LETTERS.index(now[k])
        now[k] = chance.choice(LETTERS) if chance.random() < 0.5 else LETTERS[(old + chance.choice((-2, -1, 1, 2))) % 32]
    if chance.random() < 0.2:
        now[:3] = drawn(chance)[:3]
    return "".join(now)


def climb(probe: Probe, chance: random.Random, which: int, tries: int, best: dict[int, tuple[int, str]]) -> None:
    """Looks for a dearer call of a function; `best` has the dearest of each."""
    here, height, idle = best[which][1], best[which][0], 0
    for _ in range(tries):
        if idle > PATIENCE:
            fresh = [drawn(chance) for _ in range(8)]
            height, here, idle = *max((probe.count(genes)[which], genes) for genes in fresh), 0
        genes = changed(chance, here)
        counts = probe.count(genes)
        idle += 1
        if counts[which] >= height:
            idle = 0 if counts[which] > height else idle
            height, here = counts[which], genes
        for k, count in enumerate(counts):
            best[k] = max(best[k], (count, genes))


def known(arithmetic: str, n: int) -> list[str]:
    """What was found before"""
    first, second = FOUND.read_text().split("#else")
    part = first if arithmetic == "q31" else second
    return re.findall(rf'^    {{{n}, "(\w+)"}},$', part, re.M)


def search(place: Place, seed: str, task: Task) -> dict[int, tuple[int, str]]:
    """The dearest of each function; with a seed it goes on from what is known."""
    probe = Probe(place, task)
    chance = random.Random(f"{seed} {task}")
    starts = [drawn(chance) for _ in range(200)] + (known(task.arithmetic, task.n) if seed else [])
    best = {k: max((probe.count(genes)[k], genes) for genes in starts) for k in range(len(FUNCTIONS))}
    for which in range(len(FUNCTIONS)):
        climb(probe, chance, which, TRIES[task.n], best)
    return best


# ---- beside the table ------------------------------------------------------------------------


def stated(place: Place, wanted: Program) -> dict[tuple[int, str], int]:
    """The dearest hard input of each size and function, as the table counts it"""
    counted = emulators.count_program(BY_NAME[wanted.core], place.work / wanted.name / "program.elf", build.regions(wanted), place.avr_counter)
    return {(n, what): counted[build.region(HARD[what], index)].instructions
            for index, (n, _) in enumerate(wanted.dimensions) for what in FUNCTIONS}


def prepare(place: Place, wanted: Program) -> None:
    """The table's program, with a probe of each size beside it"""
    build.library(place, build.library_key(wanted))
    core, folder = BY_NAME[wanted.core], place.work / wanted.name
    folder.mkdir()
    text = folder / "program.c"
    text.write_text(build.program_text(place, wanted) + MAIN, encoding="utf-8")
    build.compiled(place, core, GCC, text, folder / "program.o", [*build.defined(wanted), "-DKQ_COST_SEARCH"])
    build.compiled(place, core, GCC, build.MARKS, folder / "marks.o")
    build.linked(core, build.objects(place, wanted), folder / "program.elf")


def main(seed: str) -> int:
    tasks = [Task(*on, n, m) for n, m in reversed(SIZES) for on in ON]
    programs = list(dict.fromkeys(task.program for task in tasks))
    with tempfile.TemporaryDirectory(prefix="kalmanq-search-") as folder:
        place = Place(ROOT, Path(folder))
        build.model_printer(place)
        run(["cc", "-O2", "-shared", "-fPIC", str(TARGET / "counter.c"), "-o", str(place.work / "counter.so")])
        with get_context("fork").Pool(2) as pool:
            pool.map(partial(prepare, place), programs, chunksize=1)
            limits = dict(zip(programs, pool.map(partial(stated, place), programs, chunksize=1)))
            found = dict(zip(tasks, pool.map(partial(search, place, seed), tasks, chunksize=1)))
    if seed:
        FOUND.write_text(text_of(found))
    return report(found, limits)


def text_of(found: dict[Task, dict[int, tuple[int, str]]]) -> str:
    """target/found.h, with the dearest of each core, size and function"""
    def lines(arithmetic: str) -> str:
        kept = dict.fromkeys((task.n, genes) for task, best in found.items() if task.arithmetic == arithmetic for _, genes in best.values())
        return "".join(f'    {{{n}, "{genes}"}},\n' for n, genes in sorted(kept))
    head, tail = FOUND.read_text().split("#ifdef KQ_COST_q31\n")[0], "#endif\n" + FOUND.read_text().split("#endif\n")[1]
    return f"{head}#ifdef KQ_COST_q31\n{lines('q31')}#else\n{lines('f32')}{tail}"


def report(found: dict[Task, dict[int, tuple[int, str]]], limits: dict[Program, dict[tuple[int, str], int]]) -> int:
    dearer = 0
    print("| core | | n, m | " + " | ".join(f"{name}: hard inputs, searched" for name in FUNCTIONS) + " |\n|---|---|---:" + "|---:" * 3 + "|")
    for task in sorted(found, key=lambda one: (ON.index((one.core, one.arithmetic)), one.n)):
        both = [(limits[task.program][task.n, name], found[task][k][0]) for k, name in enumerate(FUNCTIONS)]
        dearer += sum(count > most for most, count in both)
        print(f"| {task.core} | {task.arithmetic} | {task.n}, {task.m} | " + " | ".join(f"{most}, {count}" for most, count in both) + " |")
    print(f"\n{dearer} calls dearer than any hard input of the table" + (": tools/cost/search.py --write SEED, then renew.sh" if dearer else ""))
    return bool(dearer)


if __name__ == "__main__":
    sys.exit(main(sys.argv[2] if sys.argv[1:2] == ["--write"] else ""))
