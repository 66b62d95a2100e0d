"""compiled_plans.py FOLDER: filters whose cost is measured, in FOLDER/fit what estimates are fitted to, in FOLDER/check
what they are compared with: the five models, and random ones that were not fitted.

Each is what kalmanq compile would write, without its proof: what that says has nothing to do with the cost.
"""

from __future__ import annotations

import decimal
import json
import subprocess
import sys
from pathlib import Path
from typing import Any, Iterable, Iterator

import numpy as np
from compiled_models import CORRELATED, five, kinematic, random_model

from kalmanq import Model
from kalmanq.compiler import exact
from kalmanq.compiler.proven import forms
from kalmanq.compiler.proven.header import header
from kalmanq.compiler.proven.operations import operations
from kalmanq.compiler.proven.product import Maker, Wanted, ram_of
from kalmanq.compiler.proven.refusals import refuse
from kalmanq.compiler.proven.roots import Root
from kalmanq.compiler.proven.text import code
from kalmanq.errors import KalmanqError
from kalmanq.model import Gaps

FITTED, CHECKED = range(100, 160), range(25)  # seeds of random models
FITTED_DOORS, CHECKED_DOORS = range(160, 176), range(25, 33)  # of those in f32 that have ranges, as all in q31 have
ROOTS = 4  # each fourth of them as a square root, too
AXES = ((1, 1), (1, 2), (1, 3), (2, 2), (3, 2), (2, 3), (3, 3), (3, 1))  # and order
STEPS = (0.1, 0.25, 0.4)  # not that of the five


def fitted(arithmetic: str) -> Iterator[tuple[str, Model, Any]]:
    for step in STEPS:
        for name, model in kinematics(step, arithmetic == "q31"):
            yield f"{name}_{round(100 * step)}", model, forms.Covariance()
    yield from random_ones(arithmetic, FITTED)
    if arithmetic == "f32":
        yield from with_doors(kinematics(STEPS[1], True), FITTED_DOORS)


def checked(arithmetic: str) -> Iterator[tuple[str, Model, Any]]:
    for model in five(arithmetic == "q31"):
        yield model.name, model, forms.Covariance()
    yield from random_ones(arithmetic, CHECKED)
    if arithmetic == "f32":
        yield from with_doors(((model.name, model) for model in five(True)), CHECKED_DOORS)


def kinematics(step: float, ranged: bool) -> Iterator[tuple[str, Model]]:
    for axes, order in AXES:
        for name, mixing in (("mixed", CORRELATED), ("apart", np.eye(3)))[:1 if axes == 1 else 2]:
            yield f"{name}_{axes}_{order}", kinematic(axes, order, step, mixing, ranged=ranged, gaps=Gaps(2, 400))


def with_doors(models: Iterable[tuple[str, Model]], seeds: range) -> Iterator[tuple[str, Model, Any]]:
    for name, model in models:
        yield f"{name}_doors", model, forms.Covariance()
    for seed in seeds:
        yield f"random{seed}_doors", random_model(seed, True), forms.Covariance()


def random_ones(arithmetic: str, seeds: range) -> Iterator[tuple[str, Model, Any]]:
    for seed in seeds:
        model = random_model(seed, arithmetic == "q31")
        yield model.name, model, forms.Covariance()
        if arithmetic == "f32" and seed % ROOTS == 0:
            yield f"root{seed}", model, Root()


def write(folder: Path, name: str, model: Model, arithmetic: str, form: Any) -> bool:
    """False: it cannot be compiled"""
    try:
        with decimal.localcontext(exact.DIGITS):
            refuse(model, arithmetic)
            maker = Maker(model, Wanted(arithmetic, name))
            plan = maker.plan(form, maker.subject)
            text = code(plan)
            told = {"name": name, "arithmetic": arithmetic, "n": model.n, "m": model.m, "l": model.l,
                    "rows": plan.rows, "ram": ram_of(plan),
                    "operations": operations(text, name, plan.subject.words.is_fixed)}
            files = {f"{name}.c": text, f"{name}.h": header(plan), "compiled.json": json.dumps(told)}
    except KalmanqError:
        return False
    here = folder / f"{name}_{arithmetic}"
    here.mkdir(parents=True)
    for file, written in files.items():
        (here / file).write_text(written, encoding="utf-8")
    done = subprocess.run(["cc", "-std=c11", "-O1", "-Wconversion", "-Werror", "-c", str(here / f"{name}.c"), "-o",
                           "/dev/null"],
                          capture_output=True)
    if done.returncode:  # words that overflow: the proof would have said so
        for file in files:
            (here / file).unlink()
        here.rmdir()
    return not done.returncode


def main() -> None:
    for which, models in (("fit", fitted), ("check", checked)):
        for arithmetic in ("f32", "q31"):
            made = [write(Path(sys.argv[1]) / which, name, model, arithmetic, form)
                    for name, model, form in models(arithmetic)]
            print(f"{which}, {arithmetic}: {sum(made)} filters, {len(made) - sum(made)} refused", flush=True)


if __name__ == "__main__":
    main()
