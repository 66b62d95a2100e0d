"""Compiles and links the programs for the targets."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from cases import FIXED, FIXED_DENSE, MODULES, RUNTIME, TEXTBOOK, WHAT, Program
from commands import run
from cores import BY_NAME, Core

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
TARGET = HERE / "target"
TEXTBOOKS = ROOT / "tests" / "cost"

FLAGS = (
    "-std=c11",
    "-ffp-contract=fast",
    "-fno-math-errno",
    "-ffunction-sections",
    "-fdata-sections",
    "-Wall",
    "-Wextra",
)
HOST_FLAGS = ("-std=c11", "-O0", "-ffp-contract=off")
TAPE_ON_AVR = 6  # steps: 8 kB of memory hold no more
MODULE_HEADERS = ("adaptation.h", "em.h", "lag.h", "point.h", "robust.h", "steady.h")
# of the library's functions; what is not there is called as it is in the table
CALLED = {
    "smooth": "smooth_step",
    "steady": "steady_step",
    "switch": "switch_step",
    "gated": "update_gated",
    "huber": "update_huber",
    "student": "update_student",
    "jump": "update_jump",
    "em": "em_iterate",
    "em_state": "em_iterate",
}
SAMPLES = ("lag", "lag_states", "point", "adapted")  # functions of target/samples.c
OPTIONS = {FIXED: "KQ_UPPER|KQ_BARE", FIXED_DENSE: "KQ_BARE"}
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

    def fixed_header(self, arithmetic: str) -> Path:
        """What a user includes to have functions of fixed sizes."""
        return self.source / "src" / f"kq_fixed_{arithmetic}.h"

    @property
    def has_modules(self) -> bool:
        folder = self.source / "include" / "kalmanq"
        return all((folder / name).exists() for name in MODULE_HEADERS)

    def has(self, wanted: Program) -> bool:
        if wanted.group == MODULES and not self.has_modules:
            return False
        return wanted.sizes == RUNTIME or self.fixed_header(wanted.arithmetic).exists()


# ---- what is built once ----------------------------------------------------------------------


def model_printer(place: Place) -> None:
    """The host's program that prints the models."""
    sources = [str(path) for path in sorted((place.source / "src").glob("*.c"))]
    run(
        [
            "cc",
            *HOST_FLAGS,
            f"-I{place.source / 'include'}",
            str(TARGET / "model.c"),
            *sources,
            "-lm",
            "-o",
            str(place.model),
        ]
    )


def library_folder(place: Place, key: tuple[str, str, str]) -> Path:
    return place.work / "-".join(("library", *key))


def library_key(wanted: Program) -> tuple[str, str, str]:
    """Core, arithmetic and level of the objects that a program shares with others."""
    level = wanted.optimisation if wanted.sizes == RUNTIME else "O2"
    return wanted.core, wanted.arithmetic, level


def library(place: Place, key: tuple[str, str, str]) -> None:
    """The objects that are not of one program."""
    core, arithmetic, level = key
    folder = library_folder(place, key)
    folder.mkdir(parents=True)
    for source in library_sources(place, arithmetic):
        compiled(place, BY_NAME[core], level, source, folder / f"{source.stem}.o")
    if arithmetic not in TEXTBOOK and place.has_modules:
        flags = (f"-DKQ_COST_{arithmetic}",)
        compiled(place, BY_NAME[core], level, TARGET / "samples.c", folder / "samples.o", flags)


def library_sources(place: Place, arithmetic: str) -> list[Path]:
    """The library, but for the other arithmetics and for what only a host needs."""
    if arithmetic in TEXTBOOK:
        return [TEXTBOOKS / f"{TEXTBOOK_PREFIX[arithmetic]}_filter.c"]
    return [
        path
        for path in sorted((place.source / "src").glob("*.c"))
        if path.name in (f"kq_{part}{arithmetic}.c" for part in ("", "steady_", "adaptation_", "em_"))
        or not path.name.startswith(("kq_", "prepare_"))
    ]


# ---- a program -------------------------------------------------------------------------------


def program(place: Place, wanted: Program) -> Path:
    """Builds the program that calls everything, ready for the emulator."""
    core = BY_NAME[wanted.core]
    folder = place.work / wanted.name
    folder.mkdir(parents=True)
    text = folder / "program.c"
    text.write_text(program_text(place, wanted), encoding="utf-8")
    own = [
        compiled(place, core, "O2", text, folder / "program.o", tape_flags(core)),
        compiled(place, core, "O2", TARGET / "marks.c", folder / "marks.o"),
    ]
    users = [user(place, wanted, n, m) for n, m in wanted.dimensions if wanted.sizes != RUNTIME]
    return linked(core, [*own, *users, *shared(place, wanted)], folder / "program.elf")


def user(place: Place, wanted: Program, n: int, m: int) -> Path:
    """A user's file with functions of one size."""
    flags = (
        f"-DKQ_COST_{wanted.arithmetic}",
        f"-DUSER_N={n}",
        f"-DUSER_M={m}",
        f"-DOPTIONS={OPTIONS[wanted.sizes]}",
        f"-DSMOOTHS={int(wanted.smooths(n))}",
        *["-DSTEADY_ONLY"] * (wanted.group == MODULES),
        f"-I{place.source / 'src'}",
    )
    target = place.work / wanted.name / f"user_{n}_{m}.o"
    core = BY_NAME[wanted.core]
    return compiled(place, core, wanted.optimisation, TARGET / "user.c", target, flags)


def shared(place: Place, wanted: Program) -> list[Path]:
    """The library's objects."""
    return sorted(library_folder(place, library_key(wanted)).glob("*.o"))


def program_text(place: Place, wanted: Program) -> str:
    """C that includes everything once for each size."""
    subject = "textbook" if wanted.arithmetic in TEXTBOOK else "library"
    numbers = NUMBERS.get(wanted.arithmetic, wanted.arithmetic)
    lines = [
        f"#define KQ_COST_{numbers}",
        *["#define KQ_COST_FIXED"] * (wanted.sizes != RUNTIME),
        *["#define KQ_COST_MODULES"] * (wanted.group == MODULES),
        f'#include "{subject}.h"',
        *['#include "modules.h"'] * (wanted.group == MODULES),
    ]
    for index, (n, m) in enumerate(wanted.dimensions):
        lines += [
            f"#define N {n}",
            f"#define M {m}",
            f"#define REGION (COST_KINDS * {index})",
            run([str(place.model), numbers, str(n), str(m)]),
            f'#include "{subject}.inc"',
            '#include "modules.inc"' if wanted.group == MODULES else '#include "run.inc"',
            *(f"#undef {name}" for name in ("N", "M", "REGION")),
        ]
    calls = "".join(f" run_{n}_{m}();" for n, m in wanted.dimensions)
    return "\n".join([*lines, f"int main(void) {{{calls} cost_end(); return 0; }}", ""])


def regions(wanted: Program) -> dict[int, str]:
    """The function of every region (target/marks.h)."""
    return {
        len(WHAT) * index + WHAT.index(what): function(wanted, what, n, m)
        for index, (n, m) in enumerate(wanted.dimensions)
        for what in wanted.what(n)
    }


def function(wanted: Program, what: str, n: int, m: int) -> str:
    name = CALLED.get(what, what)
    if what in SAMPLES:
        return f"user_{name}_{wanted.arithmetic}"
    if wanted.sizes != RUNTIME:
        return f"user_{name}_{n}_{m}"
    if wanted.arithmetic in TEXTBOOK:
        return f"{TEXTBOOK_PREFIX[wanted.arithmetic]}_{name}"
    return f"kq_{name}_{wanted.arithmetic}"


def flash_program(place: Place, wanted: Program, name: str) -> Path:
    """Links nothing but one function and what it needs: it is the entry, and the linker drops the
    rest."""
    folder = place.work / wanted.name
    objects = [*folder.glob("user_*.o"), *shared(place, wanted)]
    return linked(BY_NAME[wanted.core], objects, folder / f"{name}.elf", entry=name)


# ---- compiler and linker ---------------------------------------------------------------------


def compiled(
    place: Place, core: Core, level: str, source: Path, target: Path, flags: tuple[str, ...] = ()
) -> Path:
    includes = [place.source / "include", TARGET, TEXTBOOKS]
    if core.port and (place.source / "port" / core.port).is_dir():
        includes.insert(0, place.source / "port" / core.port)
    run(
        [
            f"{core.prefix}gcc",
            *core.flags,
            *FLAGS,
            f"-{level}",
            *flags,
            *(f"-I{path}" for path in includes),
            "-c",
            str(source),
            "-o",
            str(target),
        ]
    )
    return target


def linked(core: Core, objects: list[Path], target: Path, entry: str | None = None) -> Path:
    """A whole program, or what one function needs."""
    flags = [*core.flags, *core.link_flags, "-Wl,--gc-sections"]
    if entry is None:
        flags.append("-Wl,-u,cost_failed")  # not called by what cannot fail
    if entry or core.family != "avr":  # whose start-up code copies the variables
        flags += ["-nostartfiles", f"-Wl,-e,{entry or 'main'}"]
    run([f"{core.prefix}gcc", *flags, *map(str, objects), "-lm", "-o", str(target)])
    return target


def tape_flags(core: Core) -> tuple[str, ...]:
    return (f"-DTAPE_STEPS={TAPE_ON_AVR}",) if core.family == "avr" else ()
