"""Compiles and links the programs for the targets."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Sequence

from cases import (
    CALLS, EVEN, FIXED, FIXED_DENSE, GCC, LEAN, MODULES, NONLINEAR, REGIONS, ROOTS, RUNTIME, TEXTBOOK,
    Program,
)
from cores import BY_NAME, ROOT, Core, run, toolchain
from kalmanq.firmware.measured import MARKS

TARGET = Path(__file__).resolve().parent / "target"
TEXTBOOKS = ROOT / "tests" / "reference"

FLAGS = ("-std=c11", "-ffp-contract=fast", "-Wall", "-Wextra")  # beside the library's own
HOST_FLAGS = ("-std=c11", "-O0", "-ffp-contract=off")
# of the library's functions; what is not there is called as it is in the table
CALLED = {
    "lean": "step", "hard_lean": "step", "dearest": "step", "smooth": "smooth_step", "hard_predict": "predict", "hard_update": "update", "hard_step": "step", "hard_smooth": "smooth_step",
    "steady": "steady_step", "settling": "step", "gated": "update_robust", "huber": "update_robust",
    "student": "update_robust", "jump": "update_robust", "delayed": "update_delayed",
    "continuous": "process_init_continuous", "correlated": "process_init_correlated",
    "extended_predict": "predict_extended", "extended_update": "update"}
PARTS = ("filter", "steady", "adaptation", "nonlinear")  # of an arithmetic
SAMPLES = ("lag", "lag_states", "point", "adapted")  # functions of target/user.c
STEPS = ("changed", "extended", "points")  # and of target/nonlinear.inc
TEXTS = {MODULES: "modules.inc", NONLINEAR: "nonlinear.inc", EVEN: "even.inc"}  # beside the filter's
OPTIONS = {FIXED: "KQ_FIXED_UPPER|KQ_FIXED_BARE", FIXED_DENSE: "KQ_FIXED_BARE"}
PRINTER = ("prepare_q31", "filter_f64", "steady_f64", "status")  # what target/model.c needs of the library
TEXTBOOK_PREFIX = {"textbook-f32": "textbook", "textbook-q16": "q16"}
NUMBERS = {"textbook-f32": "f32", "textbook-q16": "q16"}


@dataclass(frozen=True)
class Place:
    """The library that is measured, and where what is built goes."""

    source: Path  # holds src, include and port
    work: Path

    @property
    def model(self) -> Path:
        return self.work / "model"

    @property
    def avr_counter(self) -> Path:
        return self.work / "avr_count"


# ---- what is built once ----------------------------------------------------------------------


def model_printer(place: Place) -> None:
    """The host's program that prints the models."""
    sources = [str(place.source / "src" / f"kq_{name}.c") for name in PRINTER]
    includes = f"-I{place.source / 'include'}"
    run(["cc", *HOST_FLAGS, includes, str(TARGET / "model.c"), *sources, "-lm"] + ["-o", str(place.model)])


def avr_counter(place: Place) -> None:
    """The host's program that runs the AVR's emulator."""
    source = str(ROOT / "port" / "boards" / "avr_count.c")
    run(["cc", "-std=gnu11", "-O2", source, "-lsimavr", "-o", str(place.avr_counter)])


def library_folder(place: Place, key: tuple[str, str, str]) -> Path:
    return place.work / "-".join(("library", *key))


def library_key(wanted: Program) -> tuple[str, str, str]:
    """Core, arithmetic and profile of the objects that a program shares with others."""
    return wanted.core, wanted.arithmetic, wanted.profile


def library(place: Place, key: tuple[str, str, str]) -> None:
    """The objects that are not of one program."""
    core, arithmetic, profile = key
    folder = library_folder(place, key)
    folder.mkdir(parents=True)
    for source in library_sources(place, arithmetic):
        compiled(place, BY_NAME[core], profile, source, folder / f"{source.stem}.o")
    if arithmetic not in TEXTBOOK:
        flags = (f"-DKQ_COST_{arithmetic}", "-DKQ_COST_MODULES")
        compiled(place, BY_NAME[core], profile, TARGET / "user.c", folder / "samples.o", flags)


def library_sources(place: Place, arithmetic: str, parts: Sequence[str] = PARTS) -> list[Path]:
    """The library, but for the other arithmetics and for what only a host needs."""
    if arithmetic in TEXTBOOK:
        return [TEXTBOOKS / f"{TEXTBOOK_PREFIX[arithmetic]}_filter.c"]
    return [
        path
        for path in sorted((place.source / "src").glob("*.c"))
        if path.name in (f"kq_{part}_{arithmetic}.c" for part in parts)
        or path.name in ("kq_status.c", "kq_range_error_q31.c")
    ]


# ---- a program -------------------------------------------------------------------------------


def program(place: Place, wanted: Program) -> Path:
    """Builds the program that calls everything, ready for the emulator."""
    core = BY_NAME[wanted.core]
    folder = place.work / wanted.name
    folder.mkdir(parents=True)
    text = folder / "program.c"
    text.write_text(program_text(place, wanted), encoding="utf-8")
    compiled(place, core, wanted.profile, text, folder / "program.o", defined(wanted))
    compiled(place, core, GCC, MARKS, folder / "marks.o")
    for n, m in wanted.dimensions if wanted.sizes != RUNTIME else ():
        user(place, wanted, n, m)
    return linked(core, objects(place, wanted), folder / "program.elf")


def user(place: Place, wanted: Program, n: int, m: int) -> None:
    flags = (
        *defined(wanted), f"-DUSER_N={n}", f"-DUSER_M={m}", f"-DOPTIONS={OPTIONS[wanted.sizes]}",
        f"-DSMOOTHS={int(wanted.smooths(n))}", f"-I{place.source / 'src'}")
    target = place.work / wanted.name / f"user_{n}_{m}.o"
    core = BY_NAME[wanted.core]
    compiled(place, core, wanted.profile, TARGET / "user.c", target, flags, is_user=True)


def objects(place: Place, wanted: Program) -> list[Path]:
    folders = (place.work / wanted.name, library_folder(place, library_key(wanted)))
    return [path for folder in folders for path in sorted(folder.glob("*.o"))]


def program_text(place: Place, wanted: Program) -> str:
    """C that includes everything once for each size."""
    subject = "textbook" if wanted.arithmetic in TEXTBOOK else "library"
    own = f'#include "{TEXTS.get(wanted.group, "run.inc")}"'
    lines = ['#include "program.h"', *[own] * (wanted.group == MODULES)]
    for index, (n, m) in enumerate(wanted.dimensions):
        lines += [
            f"#define N {n}",
            f"#define M {m}",
            f"#define FIRST ({', '.join(map(str, range(n)))})",  # A is upper triangular, H selects (target/model.c)
            f"#define SELECTS ({', '.join(str(c + 1 if c < n else 0) for c in range(m))})",
            f"#define REGION (COST_KINDS * {index})",
            run([str(place.model), numbers(wanted), *map(str, (n, m, wanted.controls))]),
            f'#include "{subject}.inc"',
            '#include "use.inc"',
            own,
            *(f"#undef {name}" for name in ("N", "M", "FIRST", "SELECTS", "REGION")),
        ]
    calls = "".join(f" run_{n}_{m}();" for n, m in wanted.dimensions)
    return "\n".join([*lines, f"int main(void) {{{calls} cost_end(); return 0; }}", ""])


def numbers(wanted: Program) -> str:
    """What the model is printed as."""
    return NUMBERS.get(wanted.arithmetic, wanted.arithmetic)


def defined(wanted: Program) -> list[str]:
    """What target/program.h and the texts after it ask for."""
    asked = {
        f"KQ_COST_{numbers(wanted)}": True, "KQ_COST_TEXTBOOK": wanted.arithmetic in TEXTBOOK,
        "KQ_COST_FIXED": wanted.sizes != RUNTIME, "KQ_COST_MODULES": wanted.group == MODULES,
        "KQ_COST_NONLINEAR": wanted.group == NONLINEAR, "KQ_COST_EVEN": wanted.group == EVEN, "KQ_COST_ROOTS": wanted.has(ROOTS),
        "KQ_COST_LEAN": wanted.has(LEAN), "KQ_COST_FOUND": wanted.profile == GCC and wanted.sizes == RUNTIME}
    names = [name for name, is_so in asked.items() if is_so]
    return [f"-DCONTROLS={wanted.controls}", *(f"-D{name}" for name in names)]


def regions(wanted: Program) -> dict[int, str]:
    """The function of every region that is about one (target/program.h)."""
    return {
        region(what, index): function(wanted, what, n, m)
        for index, (n, m) in enumerate(wanted.dimensions)
        for what in wanted.regions(n)
        if what not in CALLS.values()
    }


def region(what: str, index: int) -> int:
    return len(REGIONS) * index + REGIONS.index(what)


def function(wanted: Program, what: str, n: int, m: int) -> str:
    name = CALLED.get(what, what)
    if what in SAMPLES:
        return f"user_{name}_{wanted.arithmetic}"
    if wanted.sizes != RUNTIME or what in STEPS:
        return f"user_{name}_{n}_{m}"
    if wanted.arithmetic in TEXTBOOK:
        return f"{TEXTBOOK_PREFIX[wanted.arithmetic]}_{name}"
    return f"kq_{name}_{wanted.arithmetic}"


def program_of(place: Place, wanted: Program, what: str, n: int, m: int) -> Path:
    """Links nothing but a user's program that does `what` (target/use.inc): it is the entry, and
    the linker drops the rest."""
    name = f"use_{what}_{n}_{m}"
    target = place.work / wanted.name / f"{name}.elf"
    if not target.exists():  # "nothing" is asked for again and again
        linked(BY_NAME[wanted.core], objects(place, wanted), target, entry=name)
    return target


# ---- compiler and linker ---------------------------------------------------------------------


def compiled(place: Place, core: Core, profile: str, source: Path, target: Path, flags: Sequence[str] = (),
             is_user: bool = False) -> None:
    name, level = profile.split("-")
    tools = toolchain(core, name)
    includes = [place.source / "include", TARGET, TEXTBOOKS]
    if tools.port and (place.source / "port" / tools.port).is_dir():
        includes.insert(0, place.source / "port" / tools.port)
    own = [*FLAGS, f"-{level}", *(tools.user_profile if is_user else tools.profile), *flags]
    if name == "clang":
        own.append("-mno-global-merge")  # or no variable would be dropped alone
    own += [f"-I{path}" for path in includes]
    run([*tools.compiler, *own, "-c", str(source), "-o", str(target)])


def linked(core: Core, parts: list[Path], target: Path, entry: str | None = None) -> Path:
    """A whole program, or what one function needs."""
    flags = [*core.link_flags, "-Wl,--gc-sections"]
    if entry is None:
        flags.append("-Wl,-u,cost_failed")  # not called by what cannot fail
    if entry or core.family != "avr":  # whose start-up code copies the variables
        flags += ["-nostartfiles", f"-Wl,-e,{entry or 'main'}"]
    run([*toolchain(core, "gcc").linker, *flags, *map(str, parts), "-lm", "-o", str(target)])
    return target
