"""For NAME_report.txt of a device in q31: where its formats are from, and how it was tried."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Sequence

import numpy as np

from kalmanq.compiler.algorithm.fixed.device import EVENTS, FixedDevice
from kalmanq.compiler.algorithm.fixed.values import MARGIN
from kalmanq.compiler.given.request import Options
from kalmanq.compiler.report.equation_report import COARSE, ROWS, SEEDS
from kalmanq.compiler.run.equation_records import MISSING, drawn
from kalmanq.compiler.run.fixed_lint import lossy_formulas
from kalmanq.compiler.run.fixed_run import LIBRARY, FixedRun
from kalmanq.compiler.run.host import Host, Ran
from kalmanq.compiler.run.lint import Lossy
from kalmanq.compiler.run.record import in_whole_groups
from kalmanq.compiler.text.equation_product import compiled_equations
from kalmanq.compiler.text.product import Product
from kalmanq.core import names_of
from kalmanq.errors import KalmanqError
from kalmanq.nonlinear import NonlinearModel


@dataclass
class Tried:
    """Beside the filter in double: the largest error of a mean in sigma, ratios of sigmas, rows with a call that was refused, and
    with events"""

    mean: float = 0.0
    ratios: tuple[float, float] = (1.0, 1.0)
    refused: int = 0
    events: dict[str, int] = field(default_factory=dict)
    lossy: Sequence[Lossy] = ()
    why_not: str = ""

    limit = COARSE

    def names(self, product: Product) -> dict[str, Any]:
        """For report.txt.j2"""
        device: FixedDevice = product.arithmetic
        model = device.nonlinear
        pairs = ((device.carried, model.carried), (device.controls, model.controls), (device.taken, model.measurements))
        return {"kind": "fixed", "rows": ROWS, "seeds": len(SEEDS), "missing": MISSING, "margin": MARGIN,
                "lacks": [(device.taken[j], bits) for j, bits in device.lacks.items()],
                "reached": [(one, device.seen.largest("x", i)) for i, one in enumerate(device.carried)],
                "chosen": [f"{one.name} {one.range:.3g}" for pair in pairs for one, declared in zip(*pair) if declared.range is None]}

    def add(self, model: NonlinearModel, ran: Ran, exact: Ran) -> None:
        fixed, double = (np.sqrt(np.einsum("tii->ti", one.covariance)) for one in (ran, exact))
        with np.errstate(divide="ignore", invalid="ignore"):
            errors = np.array([model.minus(*pair) for pair in zip(ran.mean, exact.mean)])
            apart, ratio = np.abs(errors) / double, fixed / double
        self.mean = max(self.mean, float(np.nanmax(apart)))
        self.ratios = min(self.ratios[0], float(np.nanmin(ratio))), max(self.ratios[1], float(np.nanmax(ratio)))
        self.refused += int(np.count_nonzero(ran.taken != exact.taken))
        for row in ran.events:
            for name in event_names(int(row)):
                self.events[name] = self.events.get(name, 0) + 1


def event_names(events: int) -> list[str]:
    own = [name for bit, (name, _) in enumerate(EVENTS) if events >> bit & 1]
    return own + [f"the library's {name}" for name in names_of(events >> LIBRARY)]


def tried(model: NonlinearModel, product: Product) -> Tried:
    made, visited = Tried(), []
    try:
        with Host(compiled_equations(model, "exact", Options("f64"))) as exact:
            for seed in SEEDS:
                record = in_whole_groups(drawn(model, ROWS, seed)[0], product.given.together)
                ran = exact.run_record(record)
                made.add(model, FixedRun(product.arithmetic).run(record), ran)
                visited.append((ran.mean, np.sqrt(np.einsum("tii->ti", ran.covariance)), record.now, record.clock))
        made.lossy = lossy_formulas(model, product.arithmetic, visited)
    except KalmanqError as problem:
        made.why_not = str(problem)
    return made
