"""What compiling a model would cost on a core, without the proof: for kalmanq design and report."""

from __future__ import annotations

import decimal
from dataclasses import dataclass
from typing import Optional

from kalmanq.compiler import costs, exact
from kalmanq.compiler.product import planned, ram_of
from kalmanq.errors import KalmanqError
from kalmanq.model import Model


@dataclass(frozen=True)
class Offer:
    """cost, ram (bytes): about; refused: why there are none"""

    arithmetic: str
    cost: Optional[costs.Cost] = None
    ram: int = 0
    refused: str = ""

    @property
    def said(self) -> str:
        if self.cost is None:
            return f"compiled in {self.arithmetic} (kalmanq compile): {self.refused}"
        return f"compiled in {self.arithmetic} (kalmanq compile): about {self.cost.two_calls} instructions a row, " \
               f"{self.cost.step_settled} once settled, {self.cost.flash} bytes of flash, {self.ram} of RAM; its " \
               "error is proven when it is compiled"


def offers(model: Model, core: str) -> list[Offer]:
    """In the arithmetics that were measured on the core"""
    return [_offer(model, core, arithmetic) for arithmetic in ("f32", "q31") if costs.is_measured(core, arithmetic)]


def _offer(model: Model, core: str, arithmetic: str) -> Offer:
    try:
        plan = planned(model, arithmetic)
    except KalmanqError as problem:
        return Offer(arithmetic, refused=str(problem))
    with decimal.localcontext(exact.DIGITS):
        return Offer(arithmetic, costs.estimate(plan, core, "O2"), ram_of(plan))
