"""compiled_table.py FOLDER [others | few]: the five models compiled in both arithmetics, with what each may cost at most.

The factor form, and the covariance form that is proven.

f32 without ranges; q31 with a range of 64.  Where `others` is given, too, the same with a
step of 0.1, axes that have nothing to do with each other, a constant gain, the options, and a square root.
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Sequence

import numpy as np
from compiled_models import five, kinematic
from equations import NAMES, WITH_ERRORS, path_of

from kalmanq import Model
from kalmanq.model import model_file
from kalmanq.model import Gaps, Sensor

MUST = {  # of n: M4F f32 two calls, a settled step, bytes at -Os; M3 q31 two calls, a settled step; M0 the same
    2: (75, 35, 590, 110, 38, 600, 155), 3: (120, 47, 890, 210, 60, 1150, 290), 4: (183, 67, 1360, 420, 80, 2050, 435),
    6: (352, 117, 2700, 1120, 145, 4750, 840), 9: (930, 160, 6600, 2500, 280, 10800, 1450)}

# Of the factor form: core, and of n instructions in two calls and of a settled step
FACTOR = {"f32": ("m4f", {2: (102, 35), 3: (177, 49), 4: (300, 72), 6: (745, 122), 9: (2081, 164)}),
          "q31": ("m3", {2: (385, 45), 3: (686, 61), 4: (1367, 127), 6: (3132, 243), 9: (6771, 365)})}
EVERY_DAY = ("unicycle", "glucose")
EXACT = ("glucose",)  # no function of math.h: the same bits on every core
FEW = (2, 4)  # n of the models for every day
# Of words, each on every core; they settle within the rows of NAME_test
OPTIONS = {"lag": ("--lag", "3", "--settle", "1e-2"), "every": ("--every", "1,2", "--settle", "1e-2"),
           "student": ("--student", "4", "--nis"), "loops": ("--loops", "--gate", "4")}


def promises(n: int, arithmetic: str) -> dict[str, dict[str, int]]:
    f32, f32_settled, flash, m3, m3_settled, m0, m0_settled = MUST[n]
    if arithmetic == "f32":
        return {"m4f O2": {"two_calls": f32, "two_calls_settled": f32, "step_settled": f32_settled},
                "m4f Os": {"flash": flash}}
    return {"m3 O2": {"two_calls": m3, "two_calls_settled": m3, "step_settled": m3_settled},
            "m0 O2": {"two_calls": m0, "two_calls_settled": m0, "step_settled": m0_settled}}


def write(folder: Path, model: Model, arithmetic: str, name: str, must: dict, options: Sequence[str] = ()) -> None:
    here = folder / f"{name}_{arithmetic}"
    form = () if name.startswith("factor_") or "--form" in options else ("--form", "covariance")
    here.mkdir(parents=True)
    (here / "model.toml").write_text(model_file.text_of(model), encoding="utf-8")
    done = subprocess.run([sys.executable, "-m", "kalmanq.command_line", "compile", str(here / "model.toml"), "-o",
                           str(here / f"{name}.c"), "--arith", arithmetic, "--json", *form, *options],
                          capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(done.stderr)
    told = json.loads(done.stdout)
    if must and "proof" in told:
        judge(told)
    if "rows" not in told:  # after so many it has settled
        told["rows"] = (told["settles"] or {"samples": 0})["samples"]
    (here / "compiled.json").write_text(json.dumps({**told, "must": must}), encoding="utf-8")


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


def judge(told: dict) -> None:
    """Errors of means in sigma, of covariances in sigma_i sigma_j"""
    most = {"damped": 5e-6, "covariance": 1e-5, **({"damped_settled": 2e-7} if told["fractions"] else {})}
    made = told["means"]
    print(told["name"], told["arithmetic"], *(f"{which} {value}" for which, value in made.items()))
    for which, limit in most.items():
        if not made[which] <= limit:
            raise SystemExit(f"{told['name']} in {told['arithmetic']}: {which} {made[which]}, at most {limit}")


def write_others(folder: Path, arithmetic: str) -> None:
    ranged = arithmetic == "q31"
    for model in five(ranged, 0.1)[:4]:
        write(folder, model, arithmetic, f"tenth_{model.name}", {})
    for name, axes, order, variances in (("apart", 2, 2, (1.0, 1.5)), ("alike", 3, 3, (1.0, 1.0, 1.0))):
        one = kinematic(axes, order, mixing=np.eye(3), variances=variances, ranged=ranged)
        write(folder, one, arithmetic, name, {})
    few = kinematic(2, 2, ranged=True, gaps=Gaps(2, 40))
    write(folder, few, arithmetic, "gain", {}, ("--form", "gain", "--nis", "--lag", "2"))
    write(folder, few, arithmetic, "options", {}, ("--nis", "--lag", "3", "--partial"))
    if not ranged:
        write(folder, kinematic(1, 2).changed(R=0.01, P0=[100, 100]), arithmetic, "root", {})


def write_factors(folder: Path, few: bool) -> None:
    for arithmetic, (core, promised) in FACTOR.items():
        for model in five(arithmetic == "q31"):
            two_calls, settled = promised[model.n]
            if not few or model.n in FEW:
                write(folder, model, arithmetic, f"factor_{model.name}",
                      {f"{core} O2": {"two_calls": two_calls, "step_settled": settled}})
    for name, options in OPTIONS.items():
        if not few or name == "student":
            write(folder, kinematic(2, 2, ranged=True), "q31", f"factor_{name}", {}, options)
    for arithmetic in ("q31",) if few else ("f32", "q31"):
        write(folder, late(), arithmetic, "factor_late", {})


def late() -> Model:
    """Of two sensors the second tells its measurements two steps late"""
    made = kinematic(2, 2, ranged=True)
    quick, slow = made.measurements
    made.sensors = (Sensor("quick", (quick.name,)), Sensor("slow", (slow.name,), 2.0))
    return made


def main() -> None:
    folder = Path(sys.argv[1])
    write_factors(folder, "few" in sys.argv[2:])
    write_equations(folder, "few" in sys.argv[2:])
    for arithmetic in () if "few" in sys.argv[2:] else ("f32", "q31"):
        for model in five(arithmetic == "q31"):
            write(folder, model, arithmetic, model.name, promises(model.n, arithmetic))
        if "others" in sys.argv[2:]:
            write_others(folder, arithmetic)


if __name__ == "__main__":
    main()
