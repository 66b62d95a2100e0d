"""A model compiled, as one of the ways to run it: what it costs on a core, how exact it is, whether it settles.
For kalmanq design and report, which write no file of it unless they are told to."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, field
from typing import Any, Iterator, Mapping, Optional, Sequence

import numpy as np

from kalmanq.compiler.given.request import Options
from kalmanq.compiler.report import report
from kalmanq.compiler.report.costs import USUAL, Cost, costs_of
from kalmanq.compiler.run.building import NoCompiler
from kalmanq.compiler.run.host import Host
from kalmanq.compiler.run.simulation import CompiledFilter
from kalmanq.compiler.text.product import Product, compiled
from kalmanq.core import lib
from kalmanq.errors import KalmanqError, KalmanqWarning
from kalmanq.firmware import costs as library
from kalmanq.firmware.designs import Designs, Way, cause_of, trial_of
from kalmanq.firmware.reach import Record
from kalmanq.model import Model
from kalmanq.run.filters import Filter
from kalmanq.run.results import Run

ARITHMETICS = ("f32", "q31")
WAY = "compiled"
SAID = "C for this model alone, in straight lines: --out writes what kalmanq compile writes"
COLUMNS = ("arithmetic", "two calls", "settled", "settled step", "settles in", "flash", "RAM", "stack",
           "mean error", "P error")
EXPLAINED = "instructions of a row in two calls before the gain is constant and after, and of one step after; full samples " \
            "until then; bytes; errors in sigma and in sigma_i sigma_j; -: not measured"


@dataclass(frozen=True)
class Offer:
    """costs: by core; samples: full ones, after which it has settled; mean, covariance: the largest errors, in
    sigma and in sigma_i sigma_j; remark: what it warns of, or why there is no product"""

    arithmetic: str
    costs: Mapping[str, Cost] = field(default_factory=dict)
    ram: Optional[int] = None
    samples: Optional[int] = None
    mean: Optional[float] = None
    covariance: Optional[float] = None
    product: Optional[Product] = None
    remark: str = ""

    def cells(self, core: str) -> list[str]:
        """Under COLUMNS"""
        cost = self.costs.get(core)
        two, settled, step, flash, stack = [(cost or Cost({})).cell(one) if self.product else "" for one in
                                            ("two_calls", "two_calls_settled", "step_settled", "flash", "stack")]
        after = "" if self.ram is None else str(self.samples) if self.samples else "never"
        errors = ["" if one is None else f"{one:.1e}" for one in (self.mean, self.covariance)]
        return [self.arithmetic, two, settled, step, after, flash, "" if self.ram is None else str(self.ram),
                stack, *errors]

    def told(self, core: str) -> dict[str, Any]:
        """For machines"""
        return {"arithmetic": self.arithmetic,
                **(self.costs[core].of if core in self.costs else {}), "ram": self.ram, "samples": self.samples,
                "mean": self.mean, "covariance": self.covariance, "remark": self.remark}


def offers(model: Model, ranged: Optional[Model] = None, name: str = "filter", cores: Sequence[str] = USUAL,
           arithmetics: Sequence[str] = ARITHMETICS) -> list[Offer]:
    """ranged: the same with ranges that were chosen for it, which q31 takes"""
    return [_offer(ranged if ranged is not None and arithmetic == "q31" else model, arithmetic, name, cores) for arithmetic in arithmetics]


def _offer(model: Model, arithmetic: str, name: str, cores: Sequence[str]) -> Offer:
    try:
        product = compiled(model, name, Options(arithmetic))
    except KalmanqError as problem:
        return Offer(arithmetic, remark=f"refused: {problem}")
    samples = product.steady.samples if product.steady else None
    made = dict(arithmetic=arithmetic, costs=costs_of(product, cores), ram=product.ram_delayed or product.ram, samples=samples, product=product)
    try:
        with Host(product) as host:
            found = report.findings(product, host)
    except NoCompiler as problem:
        return Offer(**made, remark=f"not tried: {problem}")
    except KalmanqError as problem:
        return Offer(arithmetic, remark=f"refused: {problem}")
    return Offer(**made, mean=found.mean, covariance=found.covariance, remark=" ".join(report.warned(product, found)))


# ------------------------------------------------------------------------------ among the library's ways


def add_ways(made: Designs, found: Sequence[Offer], records: Sequence[Record]) -> None:
    """Beside the library's ways: its cost is of a row in two calls that has not settled; unknown where it was not measured."""
    exact = [Filter(made.model, "f64").run(one.z, one.u) for one in records] if any(one.product for one in found) else []
    for one in found:
        if one.product:
            of, why_not = one.costs[made.part.core].of, one.costs[made.part.core].why_not
            cost = library.Cost(of["two_calls"], of["program"], one.ram or 0, of["stack"]) if of else library.Cost()
            trial = trial_of(f"{WAY} in {one.arithmetic}", made.model.n, _tried(one, records, exact))
            trial.cause = cause_of(made.model, one.arithmetic, records, trial)
            made.ways.append(Way(one.arithmetic, WAY, cost, why_not, made.part.holds(cost), trial))


def _tried(one: Offer, records: Sequence[Record], exact: Sequence[Run]) -> Iterator[tuple[Run, Run, Optional[Run]]]:
    """Runs of its C on this machine over the records, in double, and in double with the wide sigmas that it starts with"""
    assert one.product
    model = one.product.given.model
    bounded = model.changed(P0=one.product.given.of.doubles().P0, unknown=[]) if np.any(model.unknown) else None
    with CompiledFilter(model, one.arithmetic, one.product) as host:
        for record, double in zip(records, exact):
            host.restart()
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", KalmanqWarning)  # told of the trial
                run = host.run(record.z, record.u)
            run.events = lib.KQ_EVENT_SATURATED if host.events else 0
            yield run, double, Filter(bounded, "f64").run(record.z, record.u) if bounded else None
