"""What a design costs on a core, from designs that were measured there (costs.csv, tools/cost/README.md)."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from functools import lru_cache
from importlib import resources
from typing import Any, Mapping

import numpy as np

from kalmanq.model import SIZE_MAX, Model
from kalmanq.run.parts import is_diagonal

CORES = {
    "m0": "Cortex-M0", "m3": "Cortex-M3", "m4f": "Cortex-M4F", "m7": "Cortex-M7, double FPU",
    "m33": "Cortex-M33, FPU", "rv32": "RISC-V RV32IMAC", "avr": "ATmega328P",
}
# What costs.csv was measured with (tests/target/cores.sh): other flags, or q31 without its port, cost more
FLAGS = "-ffp-contract=off -ffunction-sections -fdata-sections -fno-math-errno -fno-tree-loop-distribute-patterns"
COMPACT = "--param=max-inline-insns-single=15"  # not of files of compile-time sizes
PORTS = {"m0": "armv6m", "m3": "armv7m", "m4f": "armv7m", "m7": "armv7m", "m33": "armv7m", "avr": "avr"}
SUMS = ("instructions", "flash", "ram")  # what is estimated as one; the stack is the deepest that was measured


@dataclass(frozen=True)
class Cost:
    """Instructions of a settled step, bytes of flash and RAM beside a program without a filter, and of the stack
    at its deepest, hard measurements included."""

    instructions: int
    flash: int
    ram: int
    stack: int


def flags(core: str) -> str:
    """gcc's, of the library and of the design; the library's files have COMPACT, too"""
    return f"{'-Os -mcall-prologues' if core == 'avr' else '-O2'} {FLAGS}"


def include_path(core: str, way: str) -> str:
    folders = [f"port/{PORTS[core]}"] if core in PORTS else []
    return " ".join(f"-I{one}" for one in [*folders, "include", *(["src/known_sizes"] if way == "sizes" else [])])


def shape(model: Model) -> dict[str, int]:
    """What of a model its costs depend on."""
    begins = [int(np.flatnonzero(row)[0]) if np.any(row) else model.n for row in model.A]
    first = np.minimum.accumulate(begins[::-1])[::-1]  # rows from here on have nothing left of it
    lengths = model.n - first
    selecting = sum(np.count_nonzero(row) == 1 and np.any(row == 1) for row in model.H)
    blocks = coupled(model)
    return {
        "n": model.n, "m": model.m, "l": model.l, "upper": int(not np.any(np.tril(model.A, -1))),
        "transition": int(np.sum(lengths * (lengths + 1) // 2)), "mixing": model.m - int(selecting),
        "pairs": sum(len(block) ** 2 for block in blocks), "triples": sum(len(block) ** 3 for block in blocks),
        "correlated": int(not is_diagonal(model.R)), "unknown": int(np.any(model.unknown))}


def coupled(model: Model) -> list[np.ndarray]:
    """The states in groups that know nothing of each other: the root is 0 between them."""
    from scipy.sparse.csgraph import connected_components

    P0 = model.P0 * np.outer(~model.unknown, ~model.unknown)
    seen = np.abs(model.H).T @ (np.abs(model.R) > 0) @ np.abs(model.H)
    _, group = connected_components((model.A != 0) | (model.Q != 0) | (seen != 0) | (P0 != 0), directed=False)
    return [np.flatnonzero(group == k) for k in range(group.max() + 1)]


def terms(measure: str, of: Mapping[str, int]) -> np.ndarray:
    """What a cost is a sum of, with factors that are not negative."""
    n, m, l, upper, pairs, triples = (of[name] for name in ("n", "m", "l", "upper", "pairs", "triples"))
    if measure == "instructions":
        dense = 1 - upper
        return np.array([
            1, n, n * n, n**3, pairs, triples, m / n * pairs, dense * n, dense * n * n, dense * n**3, of["transition"], l, l * n, m, m * n, m * n * n,
            of["mixing"] * n, of["mixing"] * n * n, of["correlated"] * m * m, of["unknown"]], float)
    code = (n**3, (1 - upper) * n, (1 - upper) * n * n) if measure == "flash" else ()
    return np.array([1, n, n * n, *code, m, m * n, l, l * n, l > 0, of["correlated"],
                     of["correlated"] * m * m, of["unknown"], of["unknown"] * n, of["unknown"] * n * n], float)


@lru_cache(maxsize=None)
def measured() -> tuple[dict[str, Any], ...]:
    text = resources.files("kalmanq.firmware").joinpath("costs.csv").read_text(encoding="utf-8")
    rows = csv.DictReader(line for line in text.splitlines() if not line.startswith("#"))
    return tuple({key: int(value) if value.lstrip("-").isdigit() else value for key, value in row.items()}
                 for row in rows)


@lru_cache(maxsize=None)
def factors(core: str, arithmetic: str, way: str, measure: str) -> np.ndarray:
    """Of its terms, so that the relative errors of what was measured are least."""
    from scipy.optimize import nnls

    rows = [row for row in measured() if (row["core"], row["arithmetic"], row["way"]) == (core, arithmetic, way)]
    design = np.array([terms(measure, row) for row in rows])
    found = np.array([row[measure] for row in rows], float)
    scale = np.maximum(np.abs(design).max(axis=0), 1e-9)
    solution, _ = nnls(design / scale / found[:, None], np.ones(len(rows)))
    return solution / scale


def deepest(core: str, arithmetic: str, way: str, of: Mapping[str, int]) -> int:
    """The stack of the deepest design up to the next size that was measured: never less than is needed."""
    rows = [row for row in measured() if (row["core"], row["arithmetic"], row["way"]) == (core, arithmetic, way)]
    size = min((row["n"] for row in rows if row["n"] >= of["n"]), default=SIZE_MAX)
    return max(row["stack"] for row in rows if row["n"] <= size and
               all(row[name] <= of[name] for name in ("correlated", "unknown")))


def estimate(model: Model, core: str, arithmetic: str, way: str) -> Cost:
    of = shape(model)
    sums = (int(round(float(factors(core, arithmetic, way, measure) @ terms(measure, of)))) for measure in SUMS)
    return Cost(*sums, deepest(core, arithmetic, way, of))


def is_measured(core: str, arithmetic: str, way: str) -> bool:
    return any((row["core"], row["arithmetic"], row["way"]) == (core, arithmetic, way) for row in measured())
