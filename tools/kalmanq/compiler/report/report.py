"""NAME_report.txt: what is known of a compiled filter, and how it was tried; of constant matrices, what was found."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol, Sequence

import numpy as np

from kalmanq.compiler.given.request import GAP
from kalmanq.compiler.report import costs
from kalmanq.compiler.run.host import Host
from kalmanq.compiler.run.record import tried
from kalmanq.compiler.templates.engine import rendered
from kalmanq.compiler.text.product import Product, settling
from kalmanq.model import Model
from kalmanq.run.resolution import told_of

ROWS, LONGEST, WORK = 2000, 20_000, 500_000  # of a record: at least, at most, and over n^2
SEEDS = (1, 2, 3)
MEAN, COVARIANCE = 1.5e-4, {"f32": 1e-4, "f64": 1e-4, "q31": 2e-4}  # sigma, sigma_i sigma_j: told above; others see twice the mean's
WITH_COSTS = ("constant", "equations")  # kinds; what is over the library has its costs from kalmanq design


class Found(Protocol):
    """What trying a filter found"""

    def names(self, product: Product) -> dict[str, Any]:
        """What report.txt.j2 is given: `kind`, and numbers and names beside what all have"""


def lines(product: Product, found: Found, test: str = "") -> list[str]:
    """test: NAME_test.c, whose rows the costs of a nonlinear filter are of"""
    names = _names(product, found)
    return rendered("report.txt.j2", {**names, "costs": costs.lines(product, test) if names["kind"] in WITH_COSTS else []}).splitlines()


def warned(product: Product, found: Found) -> list[str]:
    """Of those what needs a look"""
    return rendered("report.txt.j2", _names(product, found), "warned").strip().splitlines()


def files(product: Product, test: str, told: Sequence[str], source: str) -> dict[str, str]:
    """test: NAME_test.c; told: the lines of the report; source: those about the model's file"""
    name = product.given.name
    return {**product.sources(), f"{name}_test.c": test, f"{name}_report.txt": "\n".join([source, "", *told]) + "\n"}


def _names(product: Product, found: Found) -> dict[str, Any]:
    given = product.given
    return {"product": product, "given": given, "a": product.arithmetic, "name": given.name, "arithmetic": given.options.arithmetic,
            "found": found, **found.names(product)}


# ------------------------------------------------------------------------------ constant matrices


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

    def coarse(self, product: Product) -> str:
        """What errors above those that do no harm come of; empty: they are not"""
        arithmetic = product.given.options.arithmetic
        most = COVARIANCE[arithmetic]
        times = max(self.mean / MEAN, self.covariance / most)
        return f"{arithmetic} is coarse for this model: of these errors no more than {MEAN:g} sigma and {most:g} sigma_i sigma_j would do no " \
               f"harm. {product.arithmetic.finer(times)}" if times > 1 else ""

    def names(self, product: Product) -> dict[str, Any]:
        given, model, a = product.given, product.given.model, product.arithmetic
        sigma, groups = np.sqrt(np.diag(given.of.P0).astype(float)), [group for group in set(given.together) if group & (group - 1)]
        unknown = [(one.name, f"{one.name} {sigma[i]:.3g}") for i, one in enumerate(model.states) if model.unknown[i]]
        return {"kind": "constant", "errors": self.coarse(product), "seeds": len(SEEDS), "settling": settling(given, product.steady, product.cycle),
                "coarse": resolution_of(product), "unresolved": [model.states[i].name for i in sorted(a.unresolved)], "chosen": _chosen(product),
                "unknown": [name for name, _ in unknown], "wide": [wide for _, wide in unknown], "correlated": [", ".join(
                    one.name for j, one in enumerate(model.measurements) if group >> j & 1) for group in groups]}


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


def resolution_of(product: Product) -> str:
    """Of measurements that are coarse beside their noise"""
    arithmetic, model = product.given.options.arithmetic, product.given.model
    return told_of(product.arithmetic.model if arithmetic == "q31" else model, arithmetic) if isinstance(model, Model) else ""


def _chosen(product: Product) -> list[str]:
    """Ranges of q31 that the model does not declare"""
    declared, ranged = product.given.model, product.arithmetic.model
    return [f"{after.name} {after.range:.4g} {after.unit}".rstrip() for which in ("states", "measurements", "controls")
            for before, after in zip(getattr(declared, which), getattr(ranged, which)) if before.range is None
            and after.range is not None]
