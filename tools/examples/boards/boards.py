#!/usr/bin/env python3
"""Runs the examples for boards: writes the filter, builds it, runs the recording on the emulated board, compares.

    boards.py run [NAME...]       each row that the board prints beside the row of `kalmanq run`; --ways: in every way;
                                  --pictures: draws NAME/picture.png of what the board has printed
    boards.py costs [NAME...]     what each way costs; --check: that the pages say so, --write: writes it there

--kalmanq COMMAND: how to call it, "kalmanq" if left out; --work FOLDER: for what is made, kept; NAME: a folder here.
"""
from __future__ import annotations

import argparse
import os
import re
import shlex
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Optional, Sequence

import numpy as np

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[2]
MODELS = ROOT / "tools" / "kalmanq" / "examples"
STRICT = ("-std=c11", "-O2", "-ffp-contract=off", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wdouble-promotion",
          "-Wshadow", "-Werror")
LIBRARY = r"kq_((filter|nonlinear|range_error)_{}|status)[.]c"
LAST_BIT = 0.5 + 1e-9


class BoardError(Exception):
    """Told in one line"""


# ------------------------------------------------------------------------------ the examples


@dataclass(frozen=True)
class Way:
    """make: of kalmanq, which writes NAME.c and NAME.h; host: of `kalmanq run`, which comes to the same numbers; near: or to
    numbers so near, in sigma"""

    make: tuple[str, ...]
    host: tuple[str, ...]
    arithmetic: str = ""  # where it is another one than the example's
    near: float = 0.0

    @property
    def is_design(self) -> bool:
        return self.make[0] == "design"

    @property
    def is_compiled(self) -> bool:
        return self.make[0] == "compile" and "--library" not in self.make


@dataclass(frozen=True)
class Example:
    """boards: as cores.sh calls them; ways: the first one is what main.c is written for; shown: columns of `kalmanq run` that
    main.c shows; first: rows of a second from which on both know the same"""

    boards: tuple[str, ...]
    arithmetic: str
    ways: dict[str, Way]
    shown: tuple[str, ...]
    first: tuple[int, int] = (0, 1)  # rows t with t % second >= first are compared
    model: str = "model.toml"
    data: str = "data.csv"

    def model_of(self, name: str) -> Path:
        return HERE / name / self.model

    def data_of(self, name: str) -> Path:
        return HERE / name / self.data


def means(*states: str) -> tuple[str, ...]:
    return tuple(f"{state}_mean" for state in states)


NEAR = 1e-3
COMPILED = Way(("compile",), ("--compiled",))
DEVICE = Way(("compile", "--library"), ("--compiled",))
DEVICE_F32 = Way(("compile", "--library"), (), "f32", NEAR)  # kalmanq run has the functions in double
GATED = Way(("compile", "--gate", "3.8906"), ("--robust", "gate"), near=NEAR)  # of the library: 0.9999 of good samples pass


def designed(way: str, near: float = 0.0) -> Way:
    return Way(("design", "--way", way), ("--as", way), near=near)


def smoothed(way: str) -> Way:
    return Way(("design", "--way", way), ("--smooth",))


SMALL = {"compiled": COMPILED, "lean": designed("lean")}
EXAMPLES = {
    "adc": Example(("atmega328p", "m0-4k"), "q31", SMALL, means("level")),
    "altitude": Example(("m4f",), "f32", {"compiled": GATED}, means("altitude", "climb", "offset")),
    "wheel": Example(("rv32",), "q31", {**SMALL, "sizes": designed("sizes")}, means("speed", "acceleration")),
    "battery": Example(("m3",), "q31", {"library": DEVICE, "library f32": DEVICE_F32, "compiled f32": replace(COMPILED, arithmetic="f32", near=NEAR)},
                       means("charge", "polarisation"), model="../../../kalmanq/examples/battery.py",
                       data="../../../kalmanq/examples/battery.csv"),
    "attitude": Example(("m4f",), "f32", {"compiled": replace(COMPILED, near=NEAR), "library": replace(DEVICE, near=NEAR)},
                        means("q_w", "q_x", "q_y", "q_z"), model="../../../kalmanq/examples/attitude.py"),
    "rocket": Example(("m7",), "f32", {"init": smoothed("init"), "tables": smoothed("tables"), "sizes": smoothed("sizes")},
                      tuple(f"{state}_smoothed{end}" for end in ("", "_sigma") for state in ("altitude", "speed", "acceleration"))),
    "room": Example(("m3",), "q31", {**SMALL, "sizes": designed("sizes")}, means("level", "slope", "day", "day_turned", "half_day", "half_day_turned")),
    "gps": Example(("m33",), "f32", {"init": designed("init", NEAR), "tables": designed("tables", NEAR)}, (*means("position", "speed"), "position_sigma", "speed_sigma"), first=(15, 50)),
}


# ------------------------------------------------------------------------------ its parts


@dataclass(eq=False)
class Job:
    """One example in one way on one board"""

    name: str
    example: Example
    way: str
    core: str
    kalmanq: list[str]
    folder: Path
    described: dict[str, list[str]] = field(default_factory=dict)

    @property
    def T(self) -> str:
        return self.example.ways[self.way].arithmetic or self.example.arithmetic

    @property
    def title(self) -> str:
        return f"{self.name} on {self.core}, {self.way}"

    def prepare(self) -> None:
        """NAME.c, NAME.h and recording.h"""
        self.folder.mkdir(parents=True, exist_ok=True)
        self.described = described(self.core)
        way, T = self.example.ways[self.way], self.T
        command, *options = way.make
        arguments = [command, str(self.example.model_of(self.name)), "--arith", T, *options]
        if command == "design":
            own = self.folder / "design"
            own.mkdir(exist_ok=True)
            run([*self.kalmanq, *arguments, "--core", counted_as(self.core), "--data", str(self.example.data_of(self.name)), "--flash", "1000",
                 "--ram", "1000", "--name", self.name, "-o", str(own)])
        else:
            run([*self.kalmanq, *arguments, "-o", str(self.folder / f"{self.name}.c")])
        header = self._adapt()
        (self.folder / "recording.h").write_text(recording(self, header), encoding="utf-8")

    def _adapt(self) -> str:
        """Of a way that main.c is not written for: NAME.h with the calls that it has; answers what kalmanq has written"""
        way, first = self.example.ways[self.way], next(iter(self.example.ways.values()))
        made = self.folder / ("design" if way.is_design else "") / f"{self.name}.h"
        header = made.read_text(encoding="utf-8")
        text = None
        if way.is_design:
            text = '#include "design/{0}.h"\n' + (as_compiled(header, self.name, self.T) if first.is_compiled else "")
        elif way != first:
            made.rename(made.with_name(f"{self.name}_filter.h"))
            source = self.folder / f"{self.name}.c"
            source.write_text(source.read_text(encoding="utf-8").replace(f'"{self.name}.h"', f'"{self.name}_filter.h"'), encoding="utf-8")
            text = '#include "{0}_filter.h"\n' + as_first(header, way.is_compiled, first.is_compiled)
        if text:
            (self.folder / f"{self.name}.h").write_text(text.replace("{0}", self.name), encoding="utf-8")
        return header

    @property
    def source(self) -> Path:
        return self.folder / ("design" if self.example.ways[self.way].is_design else "") / f"{self.name}.c"

    @property
    def is_library(self) -> bool:
        return not self.example.ways[self.way].is_compiled

    def sources(self) -> list[Path]:
        """Of the library"""
        pattern = LIBRARY.format(self.T)
        return [ROOT / "src" / one for one in self.described["sources"] if re.fullmatch(pattern, one)] if self.is_library else []

    def program(self) -> Path:
        say, objects = self.described, []
        for source in (HERE / self.name / "main.c", self.source, *self.sources()):
            own = source.parent.name == "src"
            flags = say["profile"] if own else say["user_profile"]
            strict = STRICT if not own else STRICT[:3]
            includes = [f"-I{self.folder}", f"-I{HERE}", f"-I{ROOT / 'src' / 'fixed_size'}", *say["include"]]
            if say["core"] == ["avr"] or self.core.startswith("atmega"):
                strict = tuple(one for one in strict if one != "-Wdouble-promotion")  # a double is a float there
            objects.append(self.folder / f"{source.stem}_{source.parent.name}.o")
            run([*say["compiler"], *strict, *flags, *includes, "-c", str(source), "-o", str(objects[-1])])
        target = self.folder / "program"
        run([*say["linker"], *map(str, objects), *say["libraries"], "-o", str(target)])
        return target

    def printed(self) -> np.ndarray:
        """The numbers that the board has printed, rows x shown"""
        environment = {**os.environ, "KQ_TIME_LIMIT": os.environ.get("KQ_TIME_LIMIT", "120")}
        columns = table(self.example.data_of(self.name))
        if self.core.startswith("atmega"):
            environment["KQ_AVR_EMULATOR"] = os.environ.get("KQ_AVR_EMULATOR") or str(avr_emulator(self.folder))
            voltages = self.folder / "voltages"
            voltages.write_text("\n".join(f"{one:.0f}" for one in columns["millivolts"]) + "\n", encoding="utf-8")
            environment["KQ_AVR_VOLTAGES"] = str(voltages)
        text = run(["sh", str(ROOT / "tests/target/run.sh"), self.core, str(self.program())], environment)
        rows = [line.split() for line in text.replace("\r", "").splitlines() if re.fullmatch(r"([0-9a-f]{8} )+", line)]
        words = np.array([[int(one, 16) for one in row] for row in rows], np.uint32)
        return words.view(np.float32).astype(float) if self.T == "f32" else words.view(np.int32).astype(float)

    def host(self) -> dict[str, np.ndarray]:
        out = self.folder / "host.csv"
        run([*self.kalmanq, "run", str(self.example.model_of(self.name)), str(self.example.data_of(self.name)), "--arith",
             self.T, *self.example.ways[self.way].host, "--out", str(out)])
        return table(out)

    def scales(self) -> np.ndarray:
        """What the last bit of each shown number is, in q31"""
        header = (self.source.parent / (f"{self.name}_filter.h" if (self.source.parent / f"{self.name}_filter.h").exists()
                                        else f"{self.name}.h")).read_text(encoding="utf-8")
        return np.array([2.0**-fraction(header, f"{self.name}_{re.sub('(_mean|_smoothed)?(_sigma)?$', '', one)}")
                         for one in self.example.shown])


def described(core: str) -> dict[str, list[str]]:
    """What cores.sh says of a board; its port comes first, if the arithmetic is fixed point"""
    lines = run(["sh", str(ROOT / "tests/target/cores.sh"), "describe", core]).splitlines()
    return {name: shlex.split(value) for name, value in (line.split("=", 1) for line in lines if "=" in line)}


def run(command: Sequence[str], environment: Optional[dict[str, str]] = None) -> str:
    try:
        done = subprocess.run(command, capture_output=True, text=True, env=environment)
    except FileNotFoundError:
        raise BoardError(f"{command[0]}: is not there; boards.py --kalmanq COMMAND, and `kalmanq doctor` says what is missing") from None
    if done.returncode:
        said = [line for line in (done.stderr.strip() or done.stdout).splitlines() if line.strip()] or ["no message"]
        told = [line for line in said if "error: " in line] or said[-1:]
        raise BoardError(f"{' '.join(map(str, command[:4]))} ...: {told[0].strip()}")
    return done.stdout


def avr_emulator(folder: Path) -> Path:
    target = folder / "avr_emulator"
    if not target.exists():
        run(["cc", "-O2", str(ROOT / "port/boards/avr_emulator.c"), "-lsimavr", "-o", str(target)])
    return target


# ------------------------------------------------------------------------------ texts for C


def table(path: Path) -> dict[str, np.ndarray]:
    lines = [line.split(",") for line in path.read_text(encoding="utf-8").splitlines() if line and not line.startswith("#")]
    return {name: np.array([float(line[k]) if line[k] else np.nan for line in lines[1:]]) for k, name in enumerate(lines[0])}


def fraction(header: str, name: str) -> int:
    found = re.search(rf"\b{name.upper()}_FRACTION = (\d+)", header)
    if not found:
        raise BoardError(f"{name.upper()}_FRACTION: is not in the header that kalmanq has written")
    return int(found[1])


def quantities(header: str, kind: str) -> list[str]:
    """Names of measurements or controls, from the header's table"""
    return re.findall(rf"^ \*  +{kind} \d+  +(\S+)", header, re.M)


def recording(job: Job, header: str) -> str:
    name, columns = job.name, table(job.example.data_of(job.name))
    z, u = (quantities(header, kind) for kind in ("measurement", "control"))
    fixed = job.T == "q31"

    def words(names: list[str], letter: str) -> np.ndarray:
        values = np.column_stack([np.nan_to_num(columns[one]) for one in names])
        scales = [2.0 ** fraction(header, f"{name}_{letter}_{one}") for one in names] if fixed else 1.0
        return np.rint(values * scales).astype(np.int64) if fixed else values.astype(np.float32)

    def cells(row: np.ndarray) -> str:
        return f"{{{', '.join(str(int(one)) if fixed else f'{float(one):.9g}f' if '.' in f'{float(one):.9g}' or 'e' in f'{float(one):.9g}' else f'{float(one):.9g}.0f' for one in row)}}}"

    present = [sum(1 << j for j, one in enumerate(z) if np.isfinite(columns[one][t])) for t in range(len(columns[z[0]]))]
    parts = [words(z, "Z"), *([words(u, "U")] if u else [])]
    rows = ["    {" + ", ".join([*(cells(one[t]) for one in parts), str(bits)]) + "}," for t, bits in enumerate(present)]
    fields = f"number z[{len(z)}];{f' number u[{len(u)}];' if u else ''} uint8_t present; /* a bit for each of z */"
    return "\n".join([f"/* {name}: written by boards.py of data.csv */", f"typedef {'int32_t' if fixed else 'float'} number;",
                      f"enum {{ ROWS = {len(present)} }};", "static const struct {", f"    {fields}", "} recording[ROWS] = {", *rows, "};", ""])


def as_compiled(header: str, name: str, T: str) -> str:
    """The calls of `kalmanq compile` by those of `kalmanq design`"""
    upper = name.upper()
    states = re.search(rf"enum {{\n((?:    {upper}_\w+,\n)+)    {upper}_STATES\n", header)
    if not states:
        raise BoardError(f"{name}.h: has no states")
    lines = [f"static inline kq_filter_{T} *{name}_object(void) {{ return {name}_filter(); }}",
             f"typedef struct {{ int events; kq_filter_{T} object; }} {name}_shown;",
             f"#define {name}_filter {name}_shown",
             f"#define {name}_start(f) ((f)->events = {name}_init() != KQ_OK)",
             f"#define {name}_predict(f) ((f)->events |= ({name}_predict)() != KQ_OK)",
             *(f"#define {name}_{call}(f, z) ((f)->events |= ({name}_{call})(z, {upper}_ALL) != KQ_OK)" for call in ("update", "step"))]
    lines += [f"#define {name}_mean_{one[len(name) + 1:].lower()}(f) ((void)(f), kq_mean_{T}({name}_object(), {one}))"
              for one in re.findall(r"\w+", states[1])]
    return "\n".join([*lines, ""])


def as_first(header: str, is_compiled: bool, first_is_compiled: bool) -> str:
    """The calls of a nonlinear way by those of the first one: a filter's answer components, a device's statuses"""
    found = re.search(r"^\} (\w+)_(filter|device);", header, re.M)
    if not found:
        raise BoardError("the header that kalmanq has written has no filter")
    name, have = found.groups()
    lines = ["#ifndef KALMANQ_STATUS_H", "typedef int kq_status;", "#endif"] if is_compiled else []
    lines += [f"typedef struct {{ {name}_{have} own; int events; }} {name}_wrapped;",
              f"#define {name}_{'filter' if first_is_compiled else 'device'} {name}_wrapped"]
    for answer, call, given in re.findall(rf"^(\w+) {name}_((?:start|predict|update)\w*)\((.*)\);", header, re.M):
        if call in ("start_at", "update_some"):
            continue
        args = [re.sub(r"\[.*\]", "", one).split()[-1].lstrip("*") for one in given.split(",")]
        made = f"({name}_{call})({', '.join(['&(f)->own', *args[1:]])})"
        failed = f"({made}, 0)" if answer == "void" else f"!{made}" if is_compiled else f"({made} != 0)"
        lines.append(f"#define {name}_{call}({', '.join(args)}) " + (f"((f)->events |= {failed})" if first_is_compiled else failed))
    lines += [f"#define {one}(f) ({one})(&(f)->own)" for one in re.findall(rf"static inline \w+ ({name}_mean_\w+)\(", header)]
    return "\n".join([*lines, ""])


# ------------------------------------------------------------------------------ the comparison


def compared(job: Job) -> tuple[np.ndarray, str]:
    """What the board has printed, in units, and a line about it; a BoardError where it is something else"""
    example, way, host = job.example, job.example.ways[job.way], job.host()
    missing = [one for one in example.shown if one not in host]
    if missing:
        raise BoardError(f"{job.title}: kalmanq run has no {', '.join(missing)}")
    wanted, shown = np.column_stack([host[one] for one in example.shown]), job.printed()
    if shown.shape != wanted.shape:
        raise BoardError(f"{job.title}: the board has printed {shown.shape} numbers, the host {wanted.shape}")
    if job.T == "q31":
        shown = shown * job.scales()
        last = np.broadcast_to(job.scales(), shown.shape)
    else:
        last = np.spacing(np.abs(wanted).astype(np.float32)).astype(float)
    apart = np.abs(shown - wanted)
    same = int(np.sum(apart <= LAST_BIT * last))
    first, second = example.first
    rows = np.arange(len(wanted)) % second >= first
    worst = float((apart / sigmas(host, example.shown))[rows].max())
    line = f"{job.title}: {rows.sum()} rows, {same} of {wanted.size} numbers equal, worst {worst:.1e} sigma"
    if not np.isfinite(shown).all() or (worst > way.near if way.near else same != wanted.size):
        raise BoardError(f"{line}: not what kalmanq run says")
    return shown, line


def sigmas(host: dict[str, np.ndarray], shown: Sequence[str]) -> np.ndarray:
    """Of each number; where a number has none (of a quaternion), the least of the row"""
    every = np.column_stack([values for name, values in host.items() if name.endswith("_sigma")])
    least = every.min(axis=1)
    names = [re.sub("(_mean|_smoothed)?(_sigma)?$", "", one) for one in shown]
    return np.column_stack([host.get(f"{name}_smoothed_sigma", host.get(f"{name}_sigma", least)) for name in names])


# ------------------------------------------------------------------------------ what it costs


@dataclass(frozen=True)
class Cost:
    """Bytes more than a program without a filter; instructions: of all calls, over the rows"""

    flash: int
    ram: int
    stack: int
    instructions: int


def cost_of(job: Job, libraries: dict[tuple[str, str], list[Path]]) -> Cost:
    sys.path.insert(0, str(ROOT / "tools" / "cost"))
    import build
    from cores import BY_NAME
    from elf import flash_and_ram
    from emulators import Emulator, count_avr

    place, core = build.Place(ROOT, job.folder), BY_NAME[counted_as(job.core)]
    includes = (f"-I{job.folder}", f"-I{HERE}", f"-I{ROOT / 'src' / 'fixed_size'}", "-ffp-contract=off", "-DCOUNTED")
    made = {}
    for name, source, more in (("main", HERE / job.name / "main.c", ("-Dmain=example",)), ("filter", job.source, ()), ("nothing", HERE / "nothing.c", ()),
                               ("counted", HERE / "counted.c", ()), ("marks", build.TARGET / "marks.c", ())):
        made[name] = job.folder / f"cost_{name}.o"
        build.compiled(place, core, build.GCC, source, made[name], (*includes, *more), is_user=True)
    key = (core.name, job.T)
    if job.is_library and key not in libraries:
        folder = job.folder / "library"
        folder.mkdir(exist_ok=True)
        libraries[key] = [folder / f"{source.stem}.o" for source in job.sources()]
        for source, target in zip(job.sources(), libraries[key]):
            build.compiled(place, core, build.GCC, source, target, ("-ffp-contract=off",))
    own = [made["main"], made["filter"], *(libraries[key] if job.is_library else [])]
    program = build.linked(core, [*own, made["counted"], made["marks"]], job.folder / "cost.elf")
    if core.family == "avr":
        build.avr_counter(place)
        counted = count_avr(place.avr_counter, program, {0: "example"})[0]
    else:
        counted = Emulator(core, program).count_regions({0: "example"})[0]
    with_it, without = (flash_and_ram(build.linked(core, parts, job.folder / f"{name}.elf", entry="example"))
                        for name, parts in (("with", own), ("without", [made["nothing"]])))
    rows = len(next(iter(table(job.example.data_of(job.name)).values())))
    return Cost(with_it[0] - without[0], with_it[1] - without[1], counted.stack, round(counted.instructions / rows))


BEGIN, END = "<!-- costs: written by boards.py costs --write -->\n", "<!-- end of costs -->\n"
BOARDS = {"atmega328p": "Arduino Uno (ATmega328P)", "m0-4k": "Cortex-M0, 32 kB and 4 kB", "m3": "Cortex-M3", "m4f": "Cortex-M4F", "m7": "Cortex-M7",
          "m33": "Cortex-M33", "rv32": "RISC-V RV32IMAC"}
NAMED = {"compiled": "compiled", "lean": "library, lean", "tables": "library, tables", "init": "library", "library": "library",
         "sizes": "library, compile-time sizes"}


def page_of(costs: dict[Job, Cost]) -> str:
    """The table of an example's page"""
    lines = ["| board | filter | flash | RAM | stack | instructions a row |", "|---|---|--:|--:|--:|--:|"]
    for job, cost in costs.items():
        lines.append(f"| {BOARDS[job.core]} | {NAMED[job.way.split()[0]]}, {job.T} | {cost.flash} | {cost.ram} | {cost.stack} | {cost.instructions} |")
    return "\n".join([*lines, ""])


def overview(costs: dict[Job, Cost]) -> str:
    """Of the way that each example is written for"""
    lines = ["| example | board | filter | flash | RAM | instructions a row | picture |", "|---|---|---|--:|--:|--:|---|"]
    for job, cost in costs.items():
        if job.way == next(iter(job.example.ways)):
            lines.append(f"| [{job.name}]({job.name}/README.md) | {BOARDS[job.core]} | {NAMED[job.way]}, {job.T} | {cost.flash} | {cost.ram} | "
                         f"{cost.instructions} | [picture]({job.name}/picture.png) |")
    return "\n".join([*lines, ""])


def settle(page: Path, made: str, given: argparse.Namespace) -> None:
    """Writes the table to its page, or finds that it is there"""
    text = page.read_text(encoding="utf-8")
    begin, end = text.find(BEGIN) + len(BEGIN), text.find(END)
    if end < begin:
        raise BoardError(f"{page}: has no place for the costs: {BEGIN.strip()}")
    if given.check and text[begin:end] != made:
        raise BoardError(f"{page}: says other costs than are measured now: boards.py costs --write")
    if given.write:
        page.write_text(text[:begin] + made + text[end:], encoding="utf-8")


def costs(given: argparse.Namespace, work: Path) -> None:
    libraries: dict[tuple[str, str], list[Path]] = {}
    every: dict[Job, Cost] = {}
    for name in given.names or EXAMPLES:
        made = {}
        for job in jobs([name], given, work):
            job.prepare()
            made[job] = cost_of(job, libraries)
        print(page_of(made), flush=True)
        settle(HERE / name / "README.md", page_of(made), given)
        every.update(made)
    if not given.names:
        settle(HERE / "README.md", overview(every), given)


def counted_as(core: str) -> str:
    """As tools/cost calls it"""
    return {"atmega328p": "avr", "m0-4k": "m0"}.get(core, core)


# ------------------------------------------------------------------------------ the command line


def drawn(job: Job, shown: np.ndarray) -> None:
    from pictures import draw

    example, path = job.example, HERE / job.name / "picture.png"
    host = table(job.folder / "host.csv")
    if job.name == "gps":  # what happens to those who do not say that it is late
        host["position_in_time"] = in_time(job)
    named = {one.replace("_mean", "").replace("_smoothed", ""): shown[:, k] for k, one in enumerate(example.shown)}
    draw(job.name, named, host, table(example.data_of(job.name)), path)
    print(f"{path.relative_to(ROOT)}: {path.stat().st_size} bytes")


def in_time(job: Job) -> np.ndarray:
    model, out = job.folder / "in_time.toml", job.folder / "in_time.csv"
    model.write_text(re.sub("^delay = .*$", "", job.example.model_of(job.name).read_text(encoding="utf-8"), flags=re.M), encoding="utf-8")
    run([*job.kalmanq, "run", str(model), str(job.example.data_of(job.name)), "--arith", job.T, "--out", str(out)])
    return table(out)["position_mean"]


def jobs(names: Sequence[str], given: argparse.Namespace, work: Path) -> list[Job]:
    made = []
    for name in names or EXAMPLES:
        if name not in EXAMPLES:
            raise BoardError(f"{name}: is none of {', '.join(EXAMPLES)}")
        example = EXAMPLES[name]
        ways = list(example.ways) if given.ways or given.what == "costs" else list(example.ways)[:1]
        for core in example.boards:
            made += [Job(name, example, way, core, shlex.split(given.kalmanq), work / name / f"{core}-{way}") for way in ways]
    return made


def runs(given: argparse.Namespace, work: Path) -> None:
    for job in jobs(given.names, given, work):
        job.prepare()
        shown, line = compared(job)
        print(line, flush=True)
        if given.pictures:
            drawn(job, shown)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("run", "costs"))
    parser.add_argument("names", nargs="*", metavar="NAME")
    parser.add_argument("--kalmanq", default="kalmanq")
    parser.add_argument("--work", type=Path)
    for flag in ("--ways", "--pictures", "--check", "--write"):
        parser.add_argument(flag, action="store_true")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="kalmanq-boards-") as own:
        try:
            (runs if given.what == "run" else costs)(given, given.work or Path(own))
        except BoardError as problem:
            sys.exit(f"boards: {problem}")


if __name__ == "__main__":
    main()
