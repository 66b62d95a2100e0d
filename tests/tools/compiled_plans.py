"""compiled_plans.py FOLDER: filters whose cost is measured, in FOLDER/fit what estimates are fitted to, in
FOLDER/check what they are compared with: models that were not fitted.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Iterator

import numpy as np
from compiled_models import CORRELATED, five, kinematic, random_model
from five import FIVE
from library import cc, written
from products import PRODUCTS

from kalmanq import Model
from kalmanq.compiler.given.request import Options
from kalmanq.compiler.report import costs
from kalmanq.compiler.text.product import compiled
from kalmanq.errors import KalmanqError
from kalmanq.model import Gaps

AXES = ((1, 1), (1, 2), (1, 3), (2, 2), (3, 2), (2, 3), (3, 3), (3, 1))  # and order
STEP = 0.25  # not that of the five
FITTED, SMALL, CHECKED = range(100, 140), range(200, 250), range(10)


def kinematics() -> Iterator[tuple[str, Model]]:
    for axes, order in AXES:
        for name, mixing in (("mixed", CORRELATED), ("apart", np.eye(3)))[:1 if axes == 1 else 2]:
            yield f"{name}_{axes}_{order}", kinematic(axes, order, STEP, mixing, ranged=True, gaps=Gaps(2, 400))


def fitted(arithmetic: str) -> Iterator[tuple[str, Model]]:
    for model in (*five(True), *(make() for make in FIVE)):
        yield model.name, model
    for name, model in kinematics():
        yield name, model
    for seed in FITTED:
        yield f"random{seed}", random_model(seed, arithmetic == "q31")
    for seed in SMALL:
        model = random_model(seed, arithmetic == "q31")
        if model.n <= 2:
            yield f"random{seed}", model


def checked(arithmetic: str) -> Iterator[tuple[str, Model]]:
    for make in PRODUCTS:
        model = make()
        yield f"product_{model.name}", model
    for seed in CHECKED:
        yield f"random{seed}", random_model(seed, arithmetic == "q31")


def write(folder: Path, name: str, model: Model, arithmetic: str) -> bool:
    try:
        product = compiled(model, name, Options(arithmetic))
    except KalmanqError:
        return False
    if not costs.operations_of(product):
        return False
    told = {"name": name, "arithmetic": arithmetic, "n": model.n, "m": model.m, "l": model.l, "ram": product.ram,
            "calls": product.calls, "operations": costs.operations_of(product)}
    here = folder / f"{name}_{arithmetic}"
    written(here, {**product.sources(), "compiled.json": json.dumps(told)})
    cc("cc", "-std=c11", "-O1", "-Wconversion", "-Werror", "-c", here / f"{name}.c", "-o", "/dev/null")
    return True


def main() -> None:
    folder = Path(sys.argv[1])
    for which, models in (("fit", fitted), ("check", checked)):
        for arithmetic in costs.ARITHMETICS:
            made = [write(folder / which, name, model, arithmetic) for name, model in models(arithmetic)]
            print(f"{which}, {arithmetic}: {sum(made)} filters, {len(made) - sum(made)} refused", flush=True)


if __name__ == "__main__":
    main()
