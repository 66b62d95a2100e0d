#!/usr/bin/env python3
"""Fits what the C of nonlinear models costs to what was measured: equation_costs.csv of tools/kalmanq/compiler.

    equation_fit.py [--models 60] [--first 1] [--core m4f ...] -o equation_costs.csv

Measured: the model files of tests/tools/equations and as many random models.  Every third model is not fitted, but
checked.  Printed: how far off the sums are for those that were fitted and for the others, with the worst one's name.
"""

from __future__ import annotations

import json
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import typer
from build import Place, avr_counter
from compiled import measured, updating
from cores import BY_NAME, ROOT
from errors import told_in_one_line
from outputs import csv_text, write
from scipy.optimize import nnls

sys.path[:0] = [str(ROOT / "tools"), str(ROOT / "tests/tools")]

import equation_random  # noqa: E402
import equations  # noqa: E402

from kalmanq.commands.compile_equations import described  # noqa: E402
from kalmanq.compiler.given.request import Options  # noqa: E402
from kalmanq.compiler.report.equation_costs import KINDS, calls_of  # noqa: E402
from kalmanq.compiler.run.equation_records import drawn  # noqa: E402
from kalmanq.compiler.run.host import Host  # noqa: E402
from kalmanq.compiler.run.trial import ROWS, trial  # noqa: E402
from kalmanq.compiler.text.equation_product import compiled_equations  # noqa: E402
from kalmanq.errors import KalmanqError  # noqa: E402

CORES = ("m0", "m3", "m4f", "rv32")
CHECKED = 3  # every third


def written(name: str, model: Any, folder: Path) -> dict[str, dict[str, int]]:
    """The operations of its calls"""
    product = compiled_equations(model, name, Options("f32"))
    record, _ = drawn(model, ROWS, 1)
    with Host(product) as host:
        texts = {**product.sources(), f"{name}_test.c": trial(product, host, record)}
    folder.mkdir()
    for file, text in {**texts, f"{name}.json": json.dumps(described(product))}.items():
        (folder / file).write_text(text, encoding="utf-8")
    return calls_of(product.code, name)


def models_of(count: int, first: int) -> dict[str, Any]:
    made = {name: equations.model_of(name) for name in equations.NAMES}
    return {**made, **{f"random_{seed}": equation_random.random_model(seed) for seed in range(first, first + count)}}


def fitted(X: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Least relative differences, no factor negative"""
    return np.array([float(f"{one:.3g}") for one in nnls(X / y[:, None], np.ones(len(y)))[0]])


def row_of(core: str, rows: list[tuple[str, dict[str, int], int]]) -> list[str]:
    X, y = np.array([[of[kind] for kind in KINDS] for _, of, _ in rows], float), np.array([count for *_, count in rows], float)
    models = list(dict.fromkeys(name.split(".")[0] for name, *_ in rows))
    others = np.array([models.index(name.split(".")[0]) % CHECKED == 0 for name, *_ in rows])
    factor = fitted(X[~others], y[~others])
    off = X @ factor / y - 1
    worst, rms = int(np.argmax(np.where(others, np.abs(off), 0))), np.sqrt(np.mean(off[others]**2))
    print(f"{core}: {np.sum(~others)} calls fitted, {100 * np.abs(off[~others]).max():.1f} % off at most; {np.sum(others)} checked, "
          f"{100 * rms:.1f} % rms, {100 * off[worst]:+.1f} % at most ({rows[worst][0]})", flush=True)
    return [core, *(f"{np.ceil(100 * one) / 100:.2f}" for one in (rms, np.abs(off).max())), *(f"{one:g}" if one else "" for one in factor)]


def main(models: int = 60, first: int = 1, core: list[str] = typer.Option(CORES, "--core"), out: Path = typer.Option(..., "-o")) -> None:
    rows: dict[str, list[tuple[str, dict[str, int], int]]] = {one: [] for one in core}
    with tempfile.TemporaryDirectory(prefix="kalmanq-equations-") as work:
        place = Place(ROOT, Path(work))
        if "avr" in core:
            avr_counter(place)
        for name, model in models_of(models, first).items():
            folder = Path(work) / name
            try:
                calls = written(name, model, folder)
            except KalmanqError as problem:
                print(f"{name}: {problem}")
                continue
            sensors = json.loads((folder / f"{name}.json").read_text())["sensors"]
            for one in core:
                found = measured(place, BY_NAME[one], folder, "O2")
                rows[one] += [(f"{name}.{call}", calls[call], found[call]) for call in ("predict", *map(updating, sensors))]
    table = [("core", "rms", "off", *KINDS), *(row_of(one, rows[one]) for one in core)]
    write(out, "# factors of operations in calls of nonlinear filters (tools/cost/equation_fit.py)\n" + csv_text(table))


if __name__ == "__main__":
    with told_in_one_line("equation_fit"):
        typer.run(main)
