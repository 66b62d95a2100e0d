#!/usr/bin/env python3
"""Writes designs of many kinds of models, for designs.py to measure: what costs.csv is made from.

    design_models.py FOLDER [--count N] [--seed S]
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Iterator, Optional

import numpy as np
import typer

from kalmanq import KalmanqError, Model
from kalmanq.data.rows import present_of
from kalmanq.compiler.text.over_library import source, ways_of
from kalmanq.firmware.costs import shape
from kalmanq.firmware.ranges import with_ranges
from kalmanq.firmware.reach import Record, draw
from kalmanq.model import Gaps, Quantity
from kalmanq.run.filters import Filter
from kalmanq.run.parts import Parts

ROWS, COUNTED = 32, 8
SIZES = ((1, 1), (2, 1), (2, 2), (3, 1), (3, 3), (4, 1), (4, 2), (5, 2), (6, 1), (6, 3), (7, 2), (8, 4), (9, 3), (10, 1))
AXES = ((2, 1), (3, 1), (2, 2), (4, 1), (3, 2), (2, 3), (5, 1), (4, 2), (3, 3), (6, 1))  # how many, of how many states


def kinematic(random: np.random.Generator, n: int) -> np.ndarray:
    """Axes of position, velocity, acceleration: nothing below the diagonal"""
    A, dt, i = np.eye(n), 0.1, 0
    while i < n:
        order = int(random.integers(1, 4))
        for a in range(i, min(i + order, n)):
            for b in range(a + 1, min(i + order, n)):
                A[a, b] = dt ** (b - a) / (1 if b - a == 1 else 2)
        i += order
    return A


def dense(random: np.random.Generator, n: int) -> np.ndarray:
    turn, _ = np.linalg.qr(random.standard_normal((n, n)))
    return 0.95 * turn


def companion(random: np.random.Generator, n: int) -> np.ndarray:
    A = np.eye(n, k=1)
    A[:, 0] = np.poly(random.uniform(-0.8, 0.8, n))[1:] * -1
    return A


def random_model(random: np.random.Generator, n: int, m: int) -> Model:
    A = (kinematic, dense, companion)[int(random.integers(3))](random, n)
    H = random.standard_normal((m, n)) if random.random() < 0.4 else np.eye(n)[random.permutation(n)[:m] if m <= n else
                                                                               random.integers(0, n, m)]
    G = random.standard_normal((n, n)) * 0.1
    if random.random() < 0.5:
        G = np.diag(np.diag(G)) + 0.01 * np.eye(n)
    R = np.diag(random.uniform(0.5, 2, m))
    if m > 1 and random.random() < 0.2:
        R = R + 0.3
    l = int(random.integers(1, 3)) if random.random() < 0.3 else 0
    unknown = [int(random.integers(n))] if random.random() < 0.2 else []
    return Model(A, H=H, R=R, Q=G @ G.T, B=random.standard_normal((n, l)) * 0.1 if l else None, P0=np.ones(n),
                 unknown=unknown, controls=[f"u{k}" for k in range(l)] if l else None, gaps=Gaps(0, 1))


def axes(random: np.random.Generator, count: int, order: int) -> Model:
    """Axes that know nothing of each other"""
    A = np.kron(np.eye(count), np.eye(order) + 0.1 * np.eye(order, k=1))
    G = np.kron(np.eye(count), random.standard_normal((order, order)) * 0.1)
    H = np.kron(np.eye(count), np.eye(1, order))
    l = count if random.random() < 0.5 else 0
    return Model(A, H=H, R=random.uniform(0.5, 2, count), Q=G @ G.T, P0=np.ones(count * order),
                 B=np.kron(np.eye(count), np.ones((order, 1))) * 0.1 if l else None)


def write(folder: Path, name: str, parts: Parts, way: str, record: Record, extra: Optional[dict] = None) -> Path:
    """NAME.h, NAME.c, design.h and design.json in a folder of that name."""
    model, T = parts.model, parts.arithmetic.name
    parts = Parts(model, T, way)
    is_fixed = parts.arithmetic.is_fixed
    made = source(parts, way, name)
    place = folder / made.name
    place.mkdir(parents=True)
    (place / f"{made.name}.h").write_text(made.header, encoding="utf-8")
    (place / f"{made.name}.c").write_text(made.text, encoding="utf-8")
    z, u = record.z[:ROWS], None if record.u is None else record.u[:ROWS]
    run = Filter(model, T, parts=parts).run(z, u)
    word = "int32_t" if is_fixed else "float"

    def cells(array: np.ndarray) -> str:
        return ", ".join(str(int(v)) if is_fixed else "NAN" if np.isnan(v) else f"{np.float32(v)!s}f" for v in np.ravel(array))

    def rows(array: np.ndarray) -> str:
        return ", ".join(f"{{{cells(row)}}}" for row in array)

    pushes, formats = len(model.inputs), parts.formats["measurements"] if is_fixed else None
    measured = parts.arithmetic.words(np.nan_to_num(z), model.measurements, formats, "measurements")
    given = "controls[(t) - 1], " if pushes else ""
    first = "controls[0], " if pushes else ""
    lines = [f'#include "{made.name}.h"', "#include <math.h>", f"typedef {word} word;", f"#define DESIGN(name) {made.name}_##name",
             f"#define ALL {made.name.upper()}_ALL", f"#define MEAN kq_mean_{T}", f"#define SIGMA kq_sigma_{T}",
             f"#define IS_KNOWN(mean) {'1' if is_fixed else '!isnan(mean)'}",
             f"#define STEP(t) DESIGN(step)({given}rows[t], present[t])", f"#define STEP_OF(z) DESIGN(step)({first}z, ALL)",
             f"enum {{ N = {model.n}, M = {model.m}, ROWS = {len(z)}, COUNTED = {COUNTED} }};",
             f"static const word rows[ROWS][M] = {{{rows(measured)}}};",
             f"static const uint32_t present[ROWS] = {{{', '.join(f'0x{bits:x}' for bits in present_of(z))}}};",
             f"static const word expected[ROWS][N] = {{{rows(run.words['mean'])}}};"]
    if pushes:
        lines.append(f"static const word controls[ROWS][{pushes}] = {{{rows(parts.words(u, 'controls')[:, :pushes])}}};")
    (place / "design.h").write_text("\n".join(lines) + "\n", encoding="utf-8")
    what = {"name": made.name, "arithmetic": T, "way": way, **shape(model), **(extra or {})}
    (place / "design.json").write_text(json.dumps(what, indent=1), encoding="utf-8")
    return place


def models(count: int, seed: int) -> Iterator[Model]:
    random = np.random.default_rng(seed)
    for k in range(count):
        yield random_model(random, *SIZES[k % len(SIZES)])
    for k in range(count // 2):
        yield axes(random, *AXES[k % len(AXES)])


def main(folder: Path, count: int = 42, seed: int = 1) -> None:
    for k, model in enumerate(models(count, seed)):
        bounded = model.changed(controls=[Quantity(one.name, range=1.0) for one in model.controls]) if model.l else model
        record = draw(bounded, ROWS, [k])[0]
        for arithmetic in ("f32", "q31"):
            try:
                write_ways(folder, f"d{k}", model, arithmetic, record)
            except KalmanqError as problem:
                print(f"{k} {arithmetic}: {problem}")


def write_ways(folder: Path, name: str, model: Model, arithmetic: str, record: Record) -> None:
    parts = Parts(model if arithmetic == "f32" else with_ranges(model, [record])[0], arithmetic)
    for way in ways_of(parts.model):
        if way != "sizes" or model.n <= 6:
            write(folder, f"{name}_{arithmetic}_{way}", parts, way, record)


if __name__ == "__main__":
    typer.run(main)
