"""What is measured: the rows of the table, grouped into programs that are built and run as one."""

from __future__ import annotations

from dataclasses import dataclass, replace

from cores import BY_NAME, CORES, Core
from errors import UserError
from table import Row

ROOTS = "roots"  # step, of a program that begins from the roots of Q and P0
LEAN = "lean"  # step by a lean sensor, of a program that begins from roots and has no other sensor
FILTER = ("predict", "update", "step", ROOTS, LEAN, "smooth")
MODULES = (
    "steady", "settling", "gated", "huber", "student", "jump", "lag", "lag_states", "point",
    "delayed", "adapted", "continuous", "correlated",
)
NONLINEAR = ("changed", "extended", "extended_predict", "extended_update", "points")
EVEN = ("dearest",)  # of 500 settled steps
FLOAT_ONLY = ("continuous", "correlated", "points")
WHAT = (*FILTER, *MODULES, *NONLINEAR, *EVEN)
# the worst of these, over hard inputs; and whole programs, for their stack
HARD = {"predict": "hard_predict", "update": "hard_update", "step": "hard_step", ROOTS: "hard_step", "smooth": "hard_smooth", LEAN: "hard_lean"}
CALLS = {"step": "filter_calls", ROOTS: "root_calls", LEAN: "lean_calls", "smooth": "smoother_calls"}
HIDDEN = (*dict.fromkeys(HARD.values()), *CALLS.values())
COUNTED = tuple(what for what in WHAT if what != ROOTS)
REGIONS = (*COUNTED, *HIDDEN)  # the order of COST_... in target/program.h
MOST = 16  # states, components, controls
SIZES = ((1, 1), (2, 1), (3, 1), (4, 2), (6, 3), (9, 3))
TEXTBOOK = ("textbook-f32", "textbook-q16")
RUNTIME, FIXED, FIXED_DENSE = "runtime", "fixed", "fixed-dense"
KINDS = (RUNTIME, FIXED, FIXED_DENSE)
# with the library's own flags (CMakeLists.txt); the third for what is promised of nonlinear models
GCC, CLANG, SMALL = "gcc-O2", "clang-Oz", "gcc-Os"
PROFILES = (GCC, CLANG, SMALL)

# Fixed sizes where one would choose them: float where there is an FPU for it, q31 where there is
# none, and not in an AVR's flash.
FIXED_ON = {"f32": ("m4f", "m7", "m33"), "f64": ("m7",), "q31": ("m3",)}
# What is beside the filter, on one core of each kind.
MODULES_ON = {"f32": ("m4f",), "f64": ("m7",), "q31": ("m0", "m3", "rv32")}
NONLINEAR_ON = EVEN_ON = {"f32": ("m4f",), "q31": ("m3",)}


# ---- programs --------------------------------------------------------------------------------


@dataclass(frozen=True)
class Program:
    """One program for a target: every `what` of its group at each of its sizes."""

    core: str
    arithmetic: str
    sizes: str
    profile: str
    dimensions: tuple[tuple[int, int], ...]  # (n, m)
    group: tuple[str, ...] = FILTER  # or another: so the filter's program is what it always was
    controls: int = 0

    @property
    def name(self) -> str:
        n_m = "_".join(f"{n}_{m}" for n, m in self.dimensions)
        parts = (self.core, self.arithmetic, self.sizes, self.profile, self.group[0], n_m)
        return "-".join(parts)

    def what(self, n: int) -> tuple[str, ...]:
        """What is called at n states; `smooths` says where smooth is no row."""
        if self.group == FILTER:
            every = FILTER[:3] if self.arithmetic in TEXTBOOK else FILTER
            return tuple(what for what in every if self.has(what))
        if self.sizes != RUNTIME:
            return MODULES[:1]
        return tuple(w for w in self.group if self.arithmetic != "q31" or w not in FLOAT_ONLY)

    def has(self, what: str) -> bool:
        """A program that begins otherwise; q31's tables are roots always."""
        if what not in (ROOTS, LEAN):
            return True
        if what == ROOTS and self.arithmetic == "q31":
            return False
        return self.sizes == RUNTIME and self.group == FILTER

    def regions(self, n: int) -> tuple[str, ...]:
        """What is counted at n states."""
        own = tuple(what for what in self.what(n) if what != ROOTS)
        if self.group != FILTER or self.arithmetic in TEXTBOOK:
            return own
        left_out = tuple(CALLS[what] for what in (ROOTS, LEAN) if not self.has(what))
        left_out += () if self.has(LEAN) else (HARD[LEAN],)
        return own + tuple(each for each in HIDDEN if each not in left_out)

    def smooths(self, n: int) -> bool:
        """Not at compile-time sizes where the smoother's unrolled code is no sensible size."""
        return self.sizes == RUNTIME or (self.arithmetic != "q31" and n <= 6)


def programs(choice: Choice) -> list[Program]:
    """The programs for all rows that the choice takes."""
    dimensions = tuple(size for size in SIZES if choice.takes("n", size[0]))
    every = [
        Program(core.name, arithmetic, sizes, profile, dimensions, group)
        for core in CORES
        for arithmetic in (*core.arithmetics, *TEXTBOOK)
        for sizes in sizes_of(core, arithmetic)
        for profile in profiles_of(core, arithmetic, sizes)
        for group in groups_of(core, arithmetic, sizes, profile)
        if any(choice.takes("what", what) for what in group)
    ]
    names = ("core", "arithmetic", "sizes", "profile")
    return [p for p in every if all(choice.takes(name, getattr(p, name)) for name in names)]


def groups_of(core: Core, arithmetic: str, sizes: str, profile: str) -> tuple[tuple[str, ...], ...]:
    groups = (FILTER,) if profile != SMALL else ()
    if profile == GCC and core.name in MODULES_ON.get(arithmetic, ()):
        groups += (MODULES,)
    if sizes == RUNTIME and profile != CLANG and core.name in NONLINEAR_ON.get(arithmetic, ()):
        groups += (NONLINEAR,)
    if sizes == RUNTIME and profile == GCC and core.name in EVEN_ON.get(arithmetic, ()):
        groups += (EVEN,)
    return groups


def profiles_of(core: Core, arithmetic: str, sizes: str) -> tuple[str, ...]:
    """clang beside gcc for what is on the card; its AVR code crashes."""
    on_card = sizes == RUNTIME and arithmetic in ("f32", "q31") and core.family != "avr"
    return PROFILES if on_card else (GCC,)


def sizes_of(core: Core, arithmetic: str) -> tuple[str, ...]:
    chosen = core.name in FIXED_ON.get(arithmetic, ())
    return (RUNTIME, FIXED, FIXED_DENSE) if chosen else (RUNTIME,)


# ---- what the command line asks for ----------------------------------------------------------


@dataclass(frozen=True)
class Choice:
    """Filters of the command line; an empty one lets everything through."""

    core: tuple[str, ...] = ()
    arithmetic: tuple[str, ...] = ()
    sizes: tuple[str, ...] = ()
    profile: tuple[str, ...] = ()
    n: tuple[int, ...] = ()
    what: tuple[str, ...] = ()

    def check(self) -> None:
        for name, known in KNOWN.items():
            for value in getattr(self, name):
                if value not in known:
                    raise UserError(f"--{name} {value}: must be one of {', '.join(map(str, known))}")

    def takes(self, name: str, value: object) -> bool:
        wanted = getattr(self, name)
        return not wanted or value in wanted

    def takes_row(self, row: Row) -> bool:
        return all(self.takes(name, getattr(row, name)) for name in KNOWN)

KNOWN: dict[str, tuple[object, ...]] = {
    "core": tuple(BY_NAME), "arithmetic": ("f32", "f64", "q31", *TEXTBOOK), "sizes": KINDS, "profile": PROFILES,
    "n": tuple(n for n, _ in SIZES), "what": WHAT}


@dataclass(frozen=True)
class Own:
    """A user's own size."""

    states: int
    components: int
    controls: int

    def check(self) -> None:
        for name, value in vars(self).items():
            least = 0 if name == "controls" else 1
            if not least <= value <= MOST:
                raise UserError(f"--{name} {value}: must be from {least} to {MOST}")


def own_programs(choice: Choice, own: Own) -> list[Program]:
    every = programs(replace(choice, sizes=(RUNTIME,), profile=(), what=FILTER, n=()))
    return [
        replace(program, dimensions=((own.states, own.components),), controls=own.controls)
        for program in every
        if program.arithmetic in ("f32", "q31")
    ]
