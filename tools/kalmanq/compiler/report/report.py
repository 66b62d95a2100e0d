"""NAME_report.txt: what is known of a compiled filter, and how it was tried."""

from __future__ import annotations

import textwrap
from dataclasses import dataclass
from typing import Sequence

import numpy as np

from kalmanq.compiler.given.request import GAP
from kalmanq.compiler.report import costs
from kalmanq.compiler.run.host import Host
from kalmanq.compiler.run.record import Accuracy, tried
from kalmanq.compiler.run.trial import trial
from kalmanq.compiler.text.product import Product, settling
from kalmanq.model import Model
from kalmanq.run.resolution import told_of

ROWS = 2000
SEEDS = (1, 2, 3)
COARSE = 1e-3  # sigma: an error above is said first


@dataclass(frozen=True)
class Findings:
    """Over records of so many rows with gaps, samples in part and second updates, compared with long double"""

    mean: float
    covariance: float
    taken: float
    longest_gap: int


def findings(product: Product, host: Host) -> Findings:
    longest = 2 * max(product.given.model.gaps.max_gap, GAP)
    made: list[Accuracy] = [tried(product.given, host, ROWS, seed, longest) for seed in SEEDS]
    return Findings(max(one.mean for one in made), max(one.covariance for one in made), min(one.taken for one in made),
                    longest)


def files(product: Product, host: Host, found: Findings, source: str) -> dict[str, str]:
    name = product.given.name
    return {**product.sources(), f"{name}_test.c": trial(product, host),
            f"{name}_report.txt": "\n".join([source, "", *lines(product, found)]) + "\n"}


def lines(product: Product, found: Findings) -> list[str]:
    return [*_what(product), *_settles(product), *costs.lines(product), *_accuracy(found), *_coarse(found, product.given.options.arithmetic), *_resolution(product),
            *_unresolved(product), *_chosen(product), *_unknown(product), *_correlated(product),
            *product.told_late]


def _what(product: Product) -> list[str]:
    given = product.given
    return [f"{given.name}: {given.options.arithmetic}, {product.ram} bytes of RAM, {len(product.arithmetic.live)} entries of the "
            "covariance's factor",
            "  The covariance is carried as a factor, so it cannot lose positive definiteness. Any number of samples may be",
            "  missing, in whole or in part, and an update may be repeated."]


def _settles(product: Product) -> list[str]:
    steady, turn = product.steady, product.cycle
    if turn is not None:
        return [f"  {line}" for line in settling(product.given, steady, turn)]
    if steady is None:
        return ["  There is no steady state that every start leads to (kalmanq check says why): no fast path."]
    if not product.given.options.settles:
        return ["  With --robust student or --tunable the gain is worked out in each row: no fast path."]
    rests = ", ".join(map(str, steady.after_gap[:4]))
    return [f"  After {steady.samples} full samples the gain is constant. This is a bound over every past: each variance is then",
            f"  within {steady.tolerance:.0e} of the steady one, relative. After a gap of 1, 2, 3, 4 samples that began settled:",
            f"  {rests} full samples."]


def _accuracy(found: Findings) -> list[str]:
    return [f"  Observed in {len(SEEDS)} records of {ROWS} rows, with gaps of up to {found.longest_gap} rows, samples in part and second",
            f"  updates, compared with long double: means within {found.mean:.1e} sigma, covariances within {found.covariance:.1e}",
            f"  sigma_i sigma_j. {100 * (1 - found.taken):.0f} % of the measurements were refused as out of range."]


def _coarse(found: Findings, arithmetic: str) -> list[str]:
    if found.mean <= COARSE and found.covariance <= COARSE:
        return []
    cure = "Use a smaller P0, or a larger R, where you can." if arithmetic == "f64" else "--arith f64 is finer there."
    return [f"  The error is above {COARSE:g}: the first variance (P0) is very far above what it settles to, or R is very",
            f"  small beside it. {cure}"]


def resolution_of(product: Product) -> str:
    """Of measurements that are coarse beside their noise"""
    arithmetic, model = product.given.options.arithmetic, product.given.model
    return told_of(product.arithmetic.model if arithmetic == "q31" else model, arithmetic) if isinstance(model, Model) else ""


def _resolution(product: Product) -> list[str]:
    coarse = resolution_of(product)
    return textwrap.wrap(f"Measurements are coarse in {product.given.options.arithmetic}: {coarse}. The errors above do not count it, as both sides "
                         "take rounded measurements.", 112, initial_indent="  ", subsequent_indent="  ") if coarse else []


def _unresolved(product: Product) -> list[str]:
    """What rounding keeps from its sigma"""
    states, of = product.given.model.states, product.arithmetic.unresolved
    if not of:
        return []
    names = ", ".join(states[i].name for i in sorted(of))
    return [f"  From about {min(of.values())} rows on the sigma of {names} moves by less than {product.given.options.arithmetic} resolves,",
            "  and may be wrong by more than 1 %. --arith f64 follows it."]


def _chosen(product: Product) -> list[str]:
    """Ranges of q31 that the model does not declare"""
    declared, ranged = product.given.model, product.arithmetic.model
    made = [f"{after.name} {after.range:.4g} {after.unit}".rstrip() for which in ("states", "measurements", "controls")
            for before, after in zip(getattr(declared, which), getattr(ranged, which)) if before.range is None
            and after.range is not None]
    return [f"  Ranges that the model does not declare were chosen: {', '.join(made)}. Declare them where you know better."] \
        if made else []


def _unknown(product: Product) -> list[str]:
    model = product.given.model
    names = [one.name for one, is_unknown in zip(model.states, model.unknown) if is_unknown]
    if not names:
        return []
    sigma = np.sqrt(np.diag(product.given.of.P0).astype(float))
    said = ", ".join(f"{one.name} {sigma[i]:.3g}" for i, one in enumerate(model.states) if model.unknown[i])
    return [f"  Nothing is known at first of {', '.join(names)}: the filter starts with a wide sigma ({said})."]


def _correlated(product: Product) -> list[str]:
    groups = [group for group in set(product.given.together) if group & (group - 1)]
    return ["  Measurements with correlated noises are taken together or not at all: " +
            "; ".join(", ".join(one.name for j, one in enumerate(product.given.model.measurements) if group >> j & 1)
                      for group in groups)] if groups else []


def warned(product: Product, found: Findings) -> Sequence[str]:
    return [line.strip() for line in [*_coarse(found, product.given.options.arithmetic), *_resolution(product)]]
