"""A model compiled, as one of the ways to run it: what it costs on a core and how exact it is, or why it is refused.
For kalmanq design and report, which write no file of it."""

from __future__ import annotations

import decimal
from dataclasses import asdict, dataclass, field
from typing import Any, Mapping, Optional

from kalmanq.compiler import exact
from kalmanq.compiler.proven.costs import Cost, estimates
from kalmanq.compiler.proven.plan import Plan
from kalmanq.compiler.proven.product import MARGIN, NotSearched, Product, Wanted, compiled, ram_of
from kalmanq.compiler.proven.proof_file import no_less, warnings
from kalmanq.errors import KalmanqError
from kalmanq.model import Model

MOST = 30_000  # covariances that are searched: some seconds; counted, so that the answer is the same everywhere
NOT_TRIED = "not tried"  # it may be refused
COLUMNS = ("arithmetic", "form", "instructions in two calls", "of a settled step", "flash", "RAM", "mean, sigma",
           "P, sigma_i sigma_j")


@dataclass(frozen=True)
class Error:
    """mean: over records with gaps, damped and not, in sigma; covariance: what the proof promises, in sigma_i sigma_j; rounding: of a
    settled mean at most, in sigma, and ends: of means over records, at the ends of ranges"""

    mean: float
    covariance: float
    rounding: float
    ends: Optional[float]

    @property
    def cells(self) -> list[str]:
        return [f"{self.mean:.1e}", no_less(self.covariance)]


@dataclass(frozen=True)
class Offer:
    """plan: of the form that was proven, which kalmanq compile writes; costs: by core, at -O2; remark: why there is
    none"""

    arithmetic: str
    plan: Optional[Plan] = None
    costs: Mapping[str, Cost] = field(default_factory=dict)
    error: Optional[Error] = None
    remark: str = ""

    @property
    def state(self) -> str:
        """Its form, or that there is none"""
        return self.plan.form.name if self.plan else NOT_TRIED if self.remark.startswith(NOT_TRIED) else "refused"

    def cells(self, core: str) -> list[str]:
        """Under COLUMNS"""
        paid = self.costs[core].cells if core in self.costs else [""] * 3
        known = self.error.cells if self.error else [""] * 2
        return [self.arithmetic, self.state, *paid, str(ram_of(self.plan)) if self.plan else "", *known]

    def told(self, core: str) -> dict[str, Any]:
        """For machines"""
        return {"form": self.state, **(asdict(self.costs[core]) if core in self.costs else {}),
                **({"ram": ram_of(self.plan)} if self.plan else {}),
                **(asdict(self.error) if self.error else {}), "remark": self.remark}


def offers(model: Model, ranged: Optional[Model] = None) -> list[Offer]:
    """ranged: the same with ranges that were chosen for it, which q31 takes"""
    made = [_offer(model, "f32")]
    chosen = ranged is not None and any(one.range is None for which in (model.measurements, model.controls)
                                        for one in which)
    if not chosen:
        return [*made, _offer(model, "q31")]
    assert ranged is not None
    return [*made, _offer(ranged, "q31", "with the chosen ranges in the model file")]


def _offer(model: Model, arithmetic: str, condition: str = "") -> Offer:
    try:
        product = compiled(model, Wanted(arithmetic, "filter"), MOST)
    except NotSearched as problem:
        said = f"{NOT_TRIED}: {problem}; run kalmanq compile"
        return Offer(arithmetic, remark=f"{said} {condition}".rstrip())
    except KalmanqError as problem:
        return Offer(arithmetic, remark=f"refused: {problem}")
    remark = "; ".join(filter(None, (condition, *warnings(product))))
    return Offer(arithmetic, product.plan, _costs(product.plan), _error(product), remark)


def _error(product: Product) -> Error:
    proof = product.proof
    return Error(proof.mean.worst, MARGIN[product.wanted.arithmetic] * proof.worst.error, proof.rounding,
                 proof.ends.worst if proof.ends else None)


def _costs(plan: Plan) -> dict[str, Cost]:
    with decimal.localcontext(exact.DIGITS):
        return {core: cost for (core, level), cost in estimates(plan).items() if level == "O2"}
