"""compiled_table.py FOLDER [few]: the five models compiled in both arithmetics, with what each may cost at most.

f32 without ranges; q31 with a range of 64.
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Sequence

from compiled_models import VARIANCES, five, kinematic
from equations import NAMES, WITH_ERRORS, path_of

from kalmanq import Model
from kalmanq.model import model_file
from kalmanq.model import Sensor

# Core, and of n instructions in two calls, of a step, and of a settled step
PROMISED = {"f32": ("m4f", {2: (89, 90, 35), 3: (157, 156, 48), 4: (271, 270, 69), 6: (640, 639, 114), 9: (1663, 1662, 156)}),
          "q31": ("m3", {2: (379, 376, 45), 3: (683, 678, 61), 4: (1364, 1361, 124), 6: (3119, 3116, 245), 9: (6723, 6720, 365)})}
EVERY_DAY = ("unicycle", "glucose")
EXACT = ("glucose",)  # no function of math.h: the same bits on every core
FEW = (2, 4)  # n of the models for every day
# Of words, each on every core; with variances so small they settle within the rows of NAME_test
SETTLES = (0.01, 0.01)
OPTIONS = {"lag": ("--lag", "3"), "every": ("--every", "1,2"),
           "student": ("--robust", "student=4", "--nis"), "loops": ("--loops", "--robust", "gate=4")}


def write(folder: Path, model: Model, arithmetic: str, name: str, must: dict, options: Sequence[str] = ()) -> None:
    here = folder / f"{name}_{arithmetic}"
    here.mkdir(parents=True)
    (here / "model.toml").write_text(model_file.text_of(model), encoding="utf-8")
    done = subprocess.run([sys.executable, "-m", "kalmanq.command_line", "compile", str(here / "model.toml"), "-o",
                           str(here / f"{name}.c"), "--arith", arithmetic, "--json", *options],
                          capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(done.stderr)
    (here / "compiled.json").write_text(json.dumps({**json.loads(done.stdout), "must": must}), encoding="utf-8")


def write_equations(folder: Path, few: bool) -> None:
    """Nonlinear models, in f32; those for every day: one of two sensors, one of which tells late, too, and one without functions of math.h"""
    late = folder.parent / "late.py"
    late.write_text(path_of("unicycle").read_text(encoding="utf-8") + "\ndelays = {\"gps\": 3}\n", encoding="utf-8")
    for name in (*(EVERY_DAY if few else (*NAMES, *WITH_ERRORS)), "late"):
        path = late if name == "late" else path_of(name)
        here = folder / f"{'exact' if name in EXACT else 'equations'}_{name}_f32"
        here.mkdir(parents=True)
        done = subprocess.run([sys.executable, "-m", "kalmanq.command_line", "compile", str(path), "-o",
                               str(here / f"{here.name.removesuffix('_f32')}.c"), "--json"], capture_output=True, text=True)
        if done.returncode:
            raise SystemExit(done.stderr)
        (here / "compiled.json").write_text(done.stdout, encoding="utf-8")


def write_linear(folder: Path, few: bool) -> None:
    for arithmetic, (core, promised) in PROMISED.items():
        for model in five(arithmetic == "q31"):
            if not few or model.n in FEW:
                must = dict(zip(("two_calls", "step", "step_settled"), promised[model.n]))
                write(folder, model, arithmetic, f"linear_{model.name}", {f"{core} O2": must})
    for name, options in OPTIONS.items():
        if not few or name == "student":
            write(folder, kinematic(2, 2, ranged=True, variances=(SETTLES if name in ("lag", "every") else VARIANCES)), "q31",
                  f"linear_{name}", {}, options)
    for arithmetic in ("q31",) if few else ("f32", "q31"):
        write(folder, late(), arithmetic, "linear_late", {})


def late() -> Model:
    """Of two sensors the second tells its measurements two steps late"""
    made = kinematic(2, 2, ranged=True)
    quick, slow = made.measurements
    made.sensors = (Sensor("quick", (quick.name,)), Sensor("slow", (slow.name,), 2.0))
    return made


def main() -> None:
    folder = Path(sys.argv[1])
    write_linear(folder, "few" in sys.argv[2:])
    write_equations(folder, "few" in sys.argv[2:])


if __name__ == "__main__":
    main()
