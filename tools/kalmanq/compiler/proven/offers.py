"""The proven covariance form of a model: what it costs on a core and how exact it is, or why there is none."""

from __future__ import annotations

import decimal
from dataclasses import dataclass, field
from typing import Mapping, Optional

from kalmanq.compiler import exact
from kalmanq.compiler.proven.costs import Cost, estimates
from kalmanq.compiler.proven.plan import Plan
from kalmanq.compiler.proven.product import FORMS, MARGIN, Maker, NotSearched, Product, Wanted, compiled
from kalmanq.compiler.proven.proof_file import warnings
from kalmanq.compiler.proven.refusals import refuse
from kalmanq.errors import KalmanqError
from kalmanq.model import Model

MOST = 30_000  # covariances that are searched: some seconds; counted, so that the answer is the same everywhere
NOT_TRIED = "not tried"  # it may be refused


@dataclass(frozen=True)
class Error:
    """mean: over records with gaps, damped and not, in sigma; covariance: what the proof promises, in sigma_i sigma_j; rounding: of a
    settled mean at most, in sigma, and ends: of means over records, at the ends of ranges"""

    mean: float
    covariance: float
    rounding: float
    ends: Optional[float]


@dataclass(frozen=True)
class Offer:
    """plan: of the form that was proven, which kalmanq compile writes; costs: by core, at -O2; remark: why there is
    none"""

    arithmetic: str
    plan: Optional[Plan] = None
    costs: Mapping[str, Cost] = field(default_factory=dict)
    error: Optional[Error] = None
    remark: str = ""


def offer(model: Model, arithmetic: str) -> Offer:
    try:
        product = compiled(model, Wanted(arithmetic, "filter"), MOST)
    except NotSearched as problem:
        return Offer(arithmetic, remark=f"{NOT_TRIED}: {problem}")
    except KalmanqError as problem:
        return Offer(arithmetic, remark=f"refused: {problem}")
    return Offer(arithmetic, product.plan, _costs(product.plan), _error(product), "; ".join(warnings(product)))


def searched(model: Model, arithmetic: str) -> Mapping[str, Cost]:
    """By core, at -O2, what the form costs if its search closes: a hint, not yet a proof"""
    try:
        with decimal.localcontext(exact.DIGITS):
            refuse(model, arithmetic)
            return _costs(Maker(model, Wanted(arithmetic, "filter")).searched(FORMS[arithmetic][0](), MOST))
    except KalmanqError:
        return {}


def _error(product: Product) -> Error:
    proof = product.proof
    return Error(proof.mean.worst, MARGIN[product.wanted.arithmetic] * proof.worst.error, proof.rounding,
                 proof.ends.worst if proof.ends else None)


def _costs(plan: Plan) -> dict[str, Cost]:
    with decimal.localcontext(exact.DIGITS):
        return {core: cost for (core, level), cost in estimates(plan).items() if level == "O2"}
