"""What a design costs on a core: sums whose factors were fitted to designs that were measured there (costs.csv), and the
deepest of their stacks (stacks.csv).  tools/cost/README.md says how both files are made."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from functools import lru_cache
from importlib import resources
from typing import Mapping

import numpy as np

from kalmanq.firmware import cores
from kalmanq.model import Model
from kalmanq.run.parts import is_diagonal

CORES = {core.name: core.description for core in cores.CORES}
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
    return " ".join(f"-I{one}" for one in [*folders, "include", *(["src/fixed_size"] if way == "sizes" else [])])


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


def terms(measure: str, of: Mapping[str, int]) -> dict[str, float]:
    """What a cost is a sum of, with factors that are not negative."""
    n, m, l, upper, pairs, triples = (of[name] for name in ("n", "m", "l", "upper", "pairs", "triples"))
    dense, correlated, unknown = 1 - upper, of["correlated"], of["unknown"]
    if measure == "instructions":
        return {"1": 1, "n": n, "n2": n * n, "n3": n**3, "pairs": pairs, "triples": triples, "m_pairs/n": m / n * pairs,
                "dense_n": dense * n, "dense_n2": dense * n * n, "dense_n3": dense * n**3, "transition": of["transition"],
                "l": l, "ln": l * n, "m": m, "mn": m * n, "mn2": m * n * n, "mixing_n": of["mixing"] * n,
                "mixing_n2": of["mixing"] * n * n, "correlated_m2": correlated * m * m, "unknown": unknown}
    code = {"n3": n**3, "dense_n": dense * n, "dense_n2": dense * n * n} if measure == "flash" else {}
    return {"1": 1, "n": n, "n2": n * n, **code, "m": m, "mn": m * n, "l": l, "ln": l * n, "any_l": l > 0,
            "correlated": correlated, "correlated_m2": correlated * m * m, "unknown": unknown, "unknown_n": unknown * n,
            "unknown_n2": unknown * n * n}


Key = tuple[str, str, str]  # core, arithmetic, way


def table(name: str, package: str = __package__) -> csv.DictReader:
    text = resources.files(package).joinpath(name).read_text(encoding="utf-8")
    return csv.DictReader(line for line in text.splitlines() if not line.startswith("#"))


@dataclass(frozen=True)
class Factors:
    of: Mapping[str, float]  # by terms
    off: float  # the most that the sum was off, of the designs that were measured

    def sum(self, terms: Mapping[str, float]) -> float:
        return sum(factor * terms[name] for name, factor in self.of.items())


@lru_cache(maxsize=None)
def factors() -> Mapping[tuple[str, str, str, str], Factors]:
    fixed = ("core", "arithmetic", "way", "measure")
    return {(row["core"], row["arithmetic"], row["way"], row["measure"]): Factors(
        {name: float(value) for name, value in row.items() if value and name not in (*fixed, "off")},
        float(row["off"])) for row in table("costs.csv")}


@lru_cache(maxsize=None)
def stacks() -> Mapping[Key, list[dict[str, int]]]:
    """For R correlated or not, states unknown or not: the deepest stack, by the number of states up to which it is"""
    made: dict[Key, list[dict[str, int]]] = {}
    for row in table("stacks.csv"):
        key = row.pop("core"), row.pop("arithmetic"), row.pop("way")
        made.setdefault(key, []).append({name: int(value or 0) for name, value in row.items()})
    return made


def deepest(core: str, arithmetic: str, way: str, of: Mapping[str, int]) -> int:
    """The stack of the deepest design up to the next size that was measured: never less than is needed."""
    rows = stacks()[core, arithmetic, way]
    sizes = [int(name) for name in rows[0] if name.isdigit()]
    size = min((one for one in sizes if one >= of["n"]), default=sizes[-1])
    return max(row[str(size)] for row in rows if all(row[name] <= of[name] for name in ("correlated", "unknown")))


def estimate(model: Model, core: str, arithmetic: str, way: str) -> Cost:
    of = shape(model)
    sums = (round(factors()[core, arithmetic, way, measure].sum(terms(measure, of))) for measure in SUMS)
    return Cost(*sums, deepest(core, arithmetic, way, of))


def is_measured(core: str, arithmetic: str, way: str) -> bool:
    return (core, arithmetic, way) in stacks()
