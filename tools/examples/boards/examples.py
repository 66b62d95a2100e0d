"""The examples: their boards, and the ways in which each filter is written."""
from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

HERE = Path(__file__).resolve().parent
BOARDS = {"atmega328p": "Arduino Uno (ATmega328P)", "m0-4k": "Cortex-M0, 32 kB and 4 kB", "m3": "Cortex-M3", "m4f": "Cortex-M4F", "m7": "Cortex-M7",
          "m33": "Cortex-M33", "rv32": "RISC-V RV32IMAC"}
NAMED = {"compiled": "compiled", "lean": "library, lean", "init": "library", "library": "library",
         "sizes": "library, compile-time sizes"}


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
    data: str = ""  # a recording that the package has; the others are drawn

    def model_of(self, name: str) -> Path:
        return HERE / name / self.model


def means(*states: str) -> tuple[str, ...]:
    return tuple(f"{state}_mean" for state in states)


NEAR = 1e-3
COMPILED = Way(("compile",), ("--compiled",))
DEVICE = Way(("compile", "--library"), ("--compiled",))
DEVICE_F32 = Way(("compile", "--library"), (), "f32", NEAR)  # kalmanq run has the functions in double
GATED = Way(("compile", "--robust", "gate"), ("--robust", "gate"), near=NEAR)  # of the library: 0.9999 of good samples pass


def designed(way: str) -> Way:
    return Way(("design", "--way", way), ("--as", way))


def smoothed(way: str) -> Way:
    return Way(("design", "--way", way), ("--smooth",))


SMALL = {"compiled": COMPILED, "lean": designed("lean")}
EXAMPLES = {
    "adc": Example(("atmega328p", "m0-4k"), "q31", SMALL, means("level")),
    "altitude": Example(("m4f",), "f32", {"compiled": GATED, "lean without a gate": designed("lean"),
                                          "sizes without a gate": designed("sizes")}, means("altitude", "climb", "offset")),
    "wheel": Example(("rv32",), "q31", {**SMALL, "sizes": designed("sizes")}, means("speed", "acceleration")),
    "battery": Example(("m3",), "q31", {"library": DEVICE, "library f32": DEVICE_F32,
                                        "compiled f32": replace(COMPILED, arithmetic="f32", near=NEAR)}, means("charge", "polarisation"), model="../../../kalmanq/examples/battery.py",
                       data="../../../kalmanq/examples/battery.csv"),
    "attitude": Example(("m4f",), "f32", {"compiled": replace(COMPILED, near=NEAR), "library": replace(DEVICE, near=NEAR)},
                        means("q_w", "q_x", "q_y", "q_z"), model="../../../kalmanq/examples/attitude.py"),
    "rocket": Example(("m7",), "f32", {"lean": smoothed("lean"), "init": smoothed("init"), "sizes": smoothed("sizes")},
                      tuple(f"{state}_smoothed{end}" for end in ("", "_sigma") for state in ("altitude", "speed", "acceleration"))),
    "room": Example(("m3",), "q31", {**SMALL, "sizes": designed("sizes")},
                    means("level", "slope", "day", "day_turned", "half_day", "half_day_turned")),
    "gps": Example(("m33",), "f32", {**SMALL, "sizes": designed("sizes")}, (*means("position", "speed"), "position_sigma"), first=(15, 50)),
}
