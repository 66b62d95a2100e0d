"""What a design costs on a core: its C and the library's, compiled for the core and run there emulated.

Needs what measured.py needs; on AVR the cross compiler and pyelftools give flash and RAM, and nothing else.
"""

from __future__ import annotations

import os
import tempfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Callable, Mapping, Optional, Sequence, TypeVar

from kalmanq.firmware import cores, measured
from kalmanq.firmware.cores import Core, NotMeasured, run
from kalmanq.firmware.measured import MARKS, TARGET

CORES = {core.name: core.description for core in cores.CORES}
FLAGS = "-ffp-contract=off -ffunction-sections -fdata-sections -fno-math-errno -fno-tree-loop-distribute-patterns"
COMPACT = "--param=max-inline-insns-single=15"  # of the library's files
PORTS = {"m0": "armv6m", "m3": "armv7m", "m4f": "armv7m", "m7": "armv7m", "m33": "armv7m", "avr": "avr"}
PARTS = ("kq_filter_{}", "kq_status", "kq_range_error_q31")  # of the library: what a design calls
COUNTED = 8  # settled steps, of which instructions are the mean


@dataclass(frozen=True)
class Cost:
    """Instructions of a settled step, bytes of flash and RAM beside a program without a filter, and of the stack
    at its deepest, low-noise measurements included; None: not measured."""

    instructions: Optional[int] = None
    flash: Optional[int] = None
    ram: Optional[int] = None
    stack: Optional[int] = None


@dataclass(frozen=True)
class Design:
    """texts: NAME.h, NAME.c, and cost-calls.h, which target/design.c takes (compiler/report/design_costs.py)"""

    name: str
    arithmetic: str
    way: str
    texts: Mapping[str, str]
    late: str = ""  # the update of what comes late, if there is one


def flags(core: str) -> str:
    """gcc's, of the library and of the design; the library's files have COMPACT, too (tests/target/cores.sh)"""
    return f"{'-Os -mcall-prologues' if core == 'avr' else '-O2'} {FLAGS}"


def folders(core: str, way: str) -> list[str]:
    """Of the library, first to last on the include path"""
    return [*([f"port/{PORTS[core]}"] if core in PORTS else []), "include", *(["src/fixed_size"] if way == "sizes" else [])]


def include_path(core: str, way: str) -> str:
    return " ".join(f"-I{one}" for one in folders(core, way))


def is_offered(core: str, arithmetic: str, way: str) -> bool:
    """Compile-time sizes where one would take them: float where there is an FPU, q31 where there is flash"""
    return way != "sizes" or (cores.BY_NAME[core].has_fpu if arithmetic == "f32" else core not in ("m0", "avr"))


def library() -> Path:
    """Its sources, which an installed package has; or the tree that the package is in"""
    package = Path(__file__).resolve().parents[1]
    return package / "library" if (package / "library").is_dir() else package.parents[1]


# ------------------------------------------------------------------------------ measured


def why_not(core: Core) -> str:
    """What keeps this machine from measuring; empty: nothing"""
    if not (library() / "src" / "kq_status.c").exists():
        return f"the library's sources are not in {library()}: install kalmanq again"
    return measured.missing(core, ("elftools",) if core.family == "avr" else measured.MODULES)


def costs(core: Core, designs: Sequence[Design]) -> list[tuple[Cost, str]]:
    """Of each, and why there is nothing, or not all of it.  The library is compiled once, by all processors at once"""
    if reason := why_not(core):
        return [(Cost(), reason)] * len(designs)
    try:
        with tempfile.TemporaryDirectory(prefix="kalmanq-costs-") as folder, ThreadPoolExecutor(os.cpu_count()) as pool:
            work = Path(folder)
            arithmetics = sorted({one.arithmetic for one in designs})
            objects = dict(zip(arithmetics, pool.map(partial(compiled_library, core, work), arithmetics)))
            built = list(pool.map(lambda one: _tried(lambda: Programs(core, work, one, objects[one.arithmetic])), designs))
            return [_cost(core, *one) for one in built]
    except (NotMeasured, OSError) as problem:
        return [(Cost(), measured.said(problem))] * len(designs)


T = TypeVar("T")


def _tried(task: Callable[[], T]) -> tuple[Optional[T], str]:
    try:
        return task(), ""
    except (NotMeasured, OSError) as problem:
        return None, measured.said(problem)


def _cost(core: Core, programs: Optional[Programs], reason: str) -> tuple[Cost, str]:
    cost, reason = _tried(programs.cost) if programs else (None, reason)
    return cost or Cost(), reason or (measured.NO_EMULATOR if core.family == "avr" else "")


def compiled_library(core: Core, work: Path, arithmetic: str) -> list[Path]:
    (place := work / arithmetic).mkdir()
    made = []
    for part in dict.fromkeys(one.format(arithmetic) for one in PARTS):
        made.append(place / f"{part}.o")
        compiled(core, library() / "src" / f"{part}.c", made[-1], COMPACT)
    return made


def compiled(core: Core, source: Path, target: Path, *more: str) -> None:
    include = (f"-I{library() / one}" for one in folders(core.name, "sizes"))
    run([*core.gcc, "-std=c11", *flags(core.name).split(), *more, *include, "-w", "-c", str(source), "-o", str(target)])


class Programs:
    """A design, and target/design.c, which calls it"""

    def __init__(self, core: Core, work: Path, design: Design, objects: Sequence[Path]):
        self.core, self.design, self.work = core, design, work / f"{design.arithmetic}-{design.way}"
        self.work.mkdir()
        for name, text in design.texts.items():
            (self.work / name).write_text(text, encoding="utf-8")
        own = {"written": self.work / f"{design.name}.c", "main": TARGET / "design.c", "marks": MARKS}
        for name, source in own.items():
            compiled(core, source, self.work / f"{name}.o", f"-I{self.work}", f"-DCOUNTED={COUNTED}")
        self.objects = [*(self.work / f"{name}.o" for name in own), *objects]
        self.used, self.unused = self.linked("use_design"), self.linked("use_nothing")

    def linked(self, entry: str) -> Path:
        """What that function needs"""
        target = self.work / f"{entry}.elf"
        starts = () if (self.core.family, entry) == ("avr", "main") else ("-nostartfiles", f"-Wl,-e,{entry}")
        run([*self.core.gcc, *self.core.link_flags, *starts, "-Wl,--gc-sections", *(["-Wl,-u,cost_failed"] if entry == "main" else []),
             *map(str, self.objects), "-lm", "-o", str(target)])
        return target

    def cost(self) -> Cost:
        from kalmanq.firmware.elf import flash_and_ram

        flash, ram = (one - other for one, other in zip(flash_and_ram(self.used), flash_and_ram(self.unused)))
        if self.core.family == "avr":
            return Cost(flash=flash, ram=ram)
        from kalmanq.firmware.emulated import Emulator

        counted = Emulator(self.core, self.linked("main")).count_regions(regions(self.design))
        instructions = sum(counted[region].instructions for region in range(COUNTED)) // COUNTED
        return Cost(instructions, flash, ram, max(one.stack for one in counted.values()))


def regions(design: Design) -> dict[int, str]:
    """The function of each (target/design.c)"""
    calls = ["step"] * COUNTED + ["init", "update", "step", *([design.late] if design.late else [])]
    return {region: f"{design.name}_{call}" for region, call in enumerate(calls)}
