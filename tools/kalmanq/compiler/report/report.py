"""NAME_report.txt: what is known of a compiled filter, and how it was tried."""

from __future__ import annotations

import textwrap
from dataclasses import dataclass
from typing import Sequence

import numpy as np

from kalmanq.compiler.given.request import GAP
from kalmanq.compiler.run.host import Host
from kalmanq.compiler.run.record import tried
from kalmanq.compiler.run.trial import trial
from kalmanq.compiler.text.product import Product, settling
from kalmanq.model import Model
from kalmanq.run.resolution import told_of

ROWS, LONGEST, WORK = 2000, 20_000, 500_000  # of a record: at least, at most, and over n^2
SEEDS = (1, 2, 3)
MEAN, COVARIANCE = 3e-4, {"f32": 1e-4, "f64": 1e-4, "q31": 2e-4}  # sigma, sigma_i sigma_j: an error above is told


@dataclass(frozen=True)
class Findings:
    """Over records with gaps, samples in part and second updates, compared with long double on the model's numbers.
    rows: of a record from the start; settled: of one that begins settled, 0: there is none"""

    mean: float
    covariance: float
    taken: float
    longest_gap: int
    rows: int = ROWS
    settled: int = 0


def findings(product: Product, host: Host) -> Findings:
    longest, rows = 2 * max(product.given.model.gaps.max_gap, GAP), _rows(product)
    made, settled = tried(product, host, rows, SEEDS, longest), 0
    if product.arithmetic.steady is not None:
        settled = ROWS
        made += tried(product, host, settled, SEEDS, longest, is_settled=True)
    return Findings(max(one.mean for one in made), max(one.covariance for one in made), min(one.taken for one in made),
                    longest, rows, settled)


def _rows(product: Product) -> int:
    """So many that it settles and goes on, as far as that is done in seconds"""
    steady, turn = product.steady, product.cycle
    least = steady.samples if steady else turn.cycles * len(turn.rows) if turn else LONGEST
    return max(ROWS, min(ROWS + least, LONGEST, WORK // product.given.of.n**2))


def files(product: Product, host: Host, found: Findings, source: str) -> dict[str, str]:
    name = product.given.name
    return {**product.sources(), f"{name}_test.c": trial(product, host),
            f"{name}_report.txt": "\n".join([source, "", *lines(product, found)]) + "\n"}


def lines(product: Product, found: Findings) -> list[str]:
    return [*_what(product), *_settles(product), *_accuracy(found), *_coarse(product, found), *_resolution(product),
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
            f"  {rests} full samples.",
            *(["  A full sample has all measurements. If they come at different rates, --every says so, and a cycle of rows settles."]
              if product.given.of.m > 1 else [])]


def _accuracy(found: Findings) -> list[str]:
    begun = f" and {len(SEEDS)} of {found.settled} rows that begin settled anywhere within the ranges" if found.settled else ""
    return textwrap.wrap(
        f"Observed in {len(SEEDS)} records of {found.rows} rows from the start{begun}, with gaps of up to {found.longest_gap} rows, samples "
        "in part and second updates; the states follow the model within their ranges. Compared with long double on the model's numbers: "
        f"means within {found.mean:.1e} sigma, covariances within {found.covariance:.1e} sigma_i sigma_j. "
        f"{100 * (1 - found.taken):.0f} % of the measurements were refused as out of range.", 112, initial_indent="  ", subsequent_indent="  ")


def _coarse(product: Product, found: Findings) -> list[str]:
    arithmetic = product.given.options.arithmetic
    most = COVARIANCE[arithmetic]
    times = max(found.mean / MEAN, found.covariance / most)
    if times <= 1:
        return []
    return textwrap.wrap(f"{arithmetic} is coarse for this model: of these errors no more than {MEAN:g} sigma and {most:g} sigma_i sigma_j "
                         f"would do no harm. {product.arithmetic.finer(times)}", 112, initial_indent="  ", subsequent_indent="  ")


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
    return [line.strip() for line in [*_coarse(product, found), *_resolution(product)]]
