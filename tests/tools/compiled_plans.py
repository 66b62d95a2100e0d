"""compiled_plans.py FOLDER FORM: filters whose cost is measured, in FOLDER/fit what estimates are fitted to, in
FOLDER/check what they are compared with: models that were not fitted.

FORM: covariance, without its proof: what that says has nothing to do with the cost; factor: what kalmanq compile writes.
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
from five import FIVE
from products import PRODUCTS

from kalmanq import Model
from kalmanq.compiler import costs, exact
from kalmanq.compiler.product import compiled
from kalmanq.compiler.proven import forms
from kalmanq.compiler.proven.costs import operations
from kalmanq.compiler.proven.header import header
from kalmanq.compiler.proven.product import Maker, Wanted, ram_of
from kalmanq.compiler.proven.refusals import refuse
from kalmanq.compiler.proven.roots import Root
from kalmanq.compiler.proven.text import code
from kalmanq.compiler.request import Options
from kalmanq.errors import KalmanqError
from kalmanq.model import Gaps

FITTED, CHECKED = range(100, 160), range(25)  # seeds of random models
FITTED_DOORS, CHECKED_DOORS = range(160, 176), range(25, 33)  # of those in f32 that have ranges, as all in q31 have
ROOTS = 4  # each fourth of them as a square root, too
AXES = ((1, 1), (1, 2), (1, 3), (2, 2), (3, 2), (2, 3), (3, 3), (3, 1))  # and order
STEPS = (0.1, 0.25, 0.4)  # not that of the five
FACTOR_FITTED, FACTOR_SMALL, FACTOR_CHECKED = range(100, 140), range(200, 250), range(10)


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
    return written(folder / f"{name}_{arithmetic}", name, files)


def written(here: Path, name: str, files: dict[str, str]) -> bool:
    here.mkdir(parents=True)
    for file, text in files.items():
        (here / file).write_text(text, encoding="utf-8")
    done = subprocess.run(["cc", "-std=c11", "-O1", "-Wconversion", "-Werror", "-c", str(here / f"{name}.c"), "-o",
                           "/dev/null"],
                          capture_output=True)
    if done.returncode:  # words that overflow: the proof would have said so
        for file in files:
            (here / file).unlink()
        here.rmdir()
    return not done.returncode


# ------------------------------------------------------------------------------ the factor


def factor_fitted(arithmetic: str) -> Iterator[tuple[str, Model]]:
    for model in (*five(True), *(make() for make in FIVE)):
        yield model.name, model
    for name, model in kinematics(STEPS[1], True):
        yield name, model
    for seed in FACTOR_FITTED:
        yield f"random{seed}", random_model(seed, arithmetic == "q31")
    for seed in FACTOR_SMALL:
        model = random_model(seed, arithmetic == "q31")
        if model.n <= 2:
            yield f"random{seed}", model


def factor_checked(arithmetic: str) -> Iterator[tuple[str, Model]]:
    for make in PRODUCTS:
        model = make()
        yield f"product_{model.name}", model
    for seed in FACTOR_CHECKED:
        yield f"random{seed}", random_model(seed, arithmetic == "q31")


def write_factor(folder: Path, name: str, model: Model, arithmetic: str) -> bool:
    try:
        product = compiled(model, name, Options(arithmetic))
    except KalmanqError:
        return False
    if not costs.operations_of(product):
        return False
    told = {"name": name, "arithmetic": arithmetic, "n": model.n, "m": model.m, "l": model.l, "ram": product.ram,
            "calls": product.calls, "operations": costs.operations_of(product)}
    return written(folder / f"{name}_{arithmetic}", name, {**product.sources(), "compiled.json": json.dumps(told)})


def main() -> None:
    folder, form = Path(sys.argv[1]), sys.argv[2]
    for which, models, others in (("fit", fitted, factor_fitted), ("check", checked, factor_checked)):
        for arithmetic in ("f32", "q31") if form == "covariance" else costs.ARITHMETICS:
            made = [write(folder / which, name, model, arithmetic, one) for name, model, one in models(arithmetic)] \
                if form == "covariance" else \
                [write_factor(folder / which, name, model, arithmetic) for name, model in others(arithmetic)]
            print(f"{which}, {arithmetic}: {sum(made)} filters, {len(made) - sum(made)} refused", flush=True)


if __name__ == "__main__":
    main()
