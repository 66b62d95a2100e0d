"""One example in one way on one board: what kalmanq writes of it, the program, what board and host say."""
from __future__ import annotations

import os
import re
import shlex
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from data import drawn
from examples import HERE, Example, Way
from texts import as_compiled, as_first, fraction, recording, run, table

ROOT = HERE.parents[2]
STRICT = ("-std=c11", "-O2", "-ffp-contract=off", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wdouble-promotion",
          "-Wshadow", "-Werror")
BUILT: dict[tuple[str, str], list[str]] = {}  # the library's objects, by core and arithmetic, of this process
LIBRARY = r"kq_((filter|nonlinear|range_error)_{}|status)[.]c"


@dataclass(eq=False)
class Job:
    name: str
    example: Example
    way: str
    core: str
    kalmanq: list[str]
    folder: Path
    described: dict[str, list[str]] = field(default_factory=dict)
    header: str = ""  # that kalmanq has written

    @property
    def given(self) -> Way:
        return self.example.ways[self.way]

    @property
    def T(self) -> str:
        return self.given.arithmetic or self.example.arithmetic

    @property
    def title(self) -> str:
        return f"{self.name} on {self.core}, {self.way}"

    @property
    def data(self) -> Path:
        """The recording"""
        return HERE / self.name / self.example.data if self.example.data else self.folder / "data.csv"

    def prepare(self) -> None:
        """data.csv, NAME.c, NAME.h and recording.h"""
        self.folder.mkdir(parents=True, exist_ok=True)
        if not self.example.data:
            self.data.write_text(drawn(self.name, self.kalmanq), encoding="utf-8")
        self.described = described(self.core)
        command, *options = self.given.make
        model, data = self.example.model_of(self.name), self.data
        arguments = [*self.kalmanq, command, str(model), "--arith", self.T, *options]
        if command == "design":
            self.source.parent.mkdir(exist_ok=True)
            run([*arguments, "--core", counted_as(self.core), "--data", str(data), "--flash", "1000", "--ram", "1000", "--name", self.name,
                 "-o", str(self.source.parent)])
        else:
            run([*arguments, "-o", str(self.source)])
        self._adapt()
        text = recording(self.name, self.T == "q31", self.header, table(data))
        (self.folder / "recording.h").write_text(text, encoding="utf-8")

    def _adapt(self) -> None:
        """Of a way that main.c is not written for: NAME.h with the calls that it has"""
        way, first = self.given, next(iter(self.example.ways.values()))
        made, text = self.source.with_suffix(".h"), ""
        self.header = made.read_text(encoding="utf-8")
        if way.is_design:
            text = f'#include "design/{self.name}.h"\n' + (as_compiled(self.header, self.name, self.T) if first.is_compiled else "")
        elif way != first:
            own = f"{self.name}_filter.h"
            made.rename(made.with_name(own))
            self.source.write_text(self.source.read_text(encoding="utf-8").replace(f'"{made.name}"', f'"{own}"'), encoding="utf-8")
            text = f'#include "{own}"\n' + as_first(self.header, way.is_compiled, first.is_compiled)
        if text:
            (self.folder / f"{self.name}.h").write_text(text, encoding="utf-8")

    @property
    def source(self) -> Path:
        return self.folder / ("design" if self.given.is_design else "") / f"{self.name}.c"

    def library(self) -> list[Path]:
        """Its files that a program may need"""
        pattern = LIBRARY.format(self.T)
        return [ROOT / "src" / one for one in self.described["sources"] if re.fullmatch(pattern, one)] if not self.given.is_compiled else []

    def program(self) -> Path:
        say, port = self.described, self.described["port"] if self.T == "q31" else []
        includes = [f"-I{self.folder}", f"-I{HERE}", f"-I{ROOT / 'src' / 'fixed_size'}", *(f"-I{ROOT / 'port' / one}" for one in port), *say["include"]]
        own = [one for one in STRICT if not (say["port"] == ["avr"] and one == "-Wdouble-promotion")]  # a double is a float there

        def compiled(source: Path, *flags: str) -> str:
            made = str(self.folder / f"{source.stem}_{source.parent.name}.o")
            run([*say["compiler"], *flags, *includes, "-c", str(source), "-o", made])
            return made

        objects = [compiled(source, *own, *say["user_profile"]) for source in (HERE / self.name / "main.c", self.source)]
        if self.library() and (self.core, self.T) not in BUILT:
            BUILT[self.core, self.T] = [compiled(source, *STRICT[:3], *say["profile"]) for source in self.library()]
        objects += BUILT[self.core, self.T] if self.library() else []
        target = self.folder / "program"
        run([*say["linker"], *objects, *say["libraries"], "-o", str(target)])
        return target

    def printed(self) -> np.ndarray:
        """The numbers that the board has printed, rows x shown"""
        environment = {**os.environ, "KQ_TIME_LIMIT": os.environ.get("KQ_TIME_LIMIT") or "120"}
        if self.core.startswith("atmega"):
            voltages = self.folder / "voltages"
            millivolts = table(self.data)["millivolts"]
            voltages.write_text("".join(f"{one:.0f}\n" for one in millivolts), encoding="utf-8")
            environment |= {"KQ_AVR_EMULATOR": str(self._avr_emulator()), "KQ_AVR_VOLTAGES": str(voltages)}
        text = run(["sh", str(ROOT / "tests/target/run.sh"), self.core, str(self.program())], environment)
        rows = [line.split() for line in text.replace("\r", "").splitlines() if re.fullmatch(r"([0-9a-f]{8} )+", line)]
        words = np.array([[int(one, 16) for one in row] for row in rows], np.uint32)
        return words.view(np.float32 if self.T == "f32" else np.int32).astype(float)

    def _avr_emulator(self) -> Path:
        target = self.folder / "avr_emulator"
        if not target.exists():
            run(["cc", "-O2", str(ROOT / "port/boards/avr_emulator.c"), "-lsimavr", "-o", str(target)])
        return target

    def host(self) -> dict[str, np.ndarray]:
        out = self.folder / "host.csv"
        run([*self.kalmanq, "run", str(self.example.model_of(self.name)), str(self.data), "--arith", self.T,
             *self.given.host, "--digits", "17", "--out", str(out)])
        return table(out)

    def scales(self) -> np.ndarray:
        """What the last bit of each shown number is, in q31"""
        names = [re.sub("(_mean|_smoothed)?(_sigma)?$", "", one) for one in self.example.shown]
        return np.array([2.0**-fraction(self.header, f"{self.name}_{one}") for one in names])


def described(core: str) -> dict[str, list[str]]:
    """What cores.sh says of a board"""
    lines = run(["sh", str(ROOT / "tests/target/cores.sh"), "describe", core]).splitlines()
    return {name: shlex.split(value) for name, value in (line.split("=", 1) for line in lines if "=" in line)}


def counted_as(core: str) -> str:
    """As tools/cost and kalmanq design call it"""
    return {"atmega328p": "avr", "m0-4k": "m0"}.get(core, core)
