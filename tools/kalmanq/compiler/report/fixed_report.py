"""For NAME_report.txt of a device in q31: where its formats are from, and how it was tried."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Sequence

import numpy as np

from kalmanq.compiler.algorithm.fixed.device import EVENTS, FixedDevice
from kalmanq.compiler.algorithm.fixed.tables import fraction_of
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

WRONG = 0.3  # sigma: an error above, which no event tells, is no estimate
STEP = 1e-3  # of the least sigma of a state: a step of its raw values that does no harm


@dataclass
class Tried:
    """Beside the filter in double: the largest error of a mean in sigma, ratios of sigmas, rows with a call that was refused, and
    with events; least: sigma of each state"""

    mean: float = 0.0
    ratios: tuple[float, float] = (1.0, 1.0)
    refused: int = 0
    events: dict[str, int] = field(default_factory=dict)
    lossy: Sequence[Lossy] = ()
    why_not: str = ""
    least: np.ndarray = field(default_factory=lambda: np.zeros(0))

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

    def causes(self, device: FixedDevice) -> str:
        return " ".join(_steps(device, self)) or "--arith f32 is finer."

    def add(self, model: NonlinearModel, ran: Ran, exact: Ran) -> None:
        fixed, double = (np.sqrt(np.einsum("tii->ti", one.covariance)) for one in (ran, exact))
        with np.errstate(divide="ignore", invalid="ignore"):
            errors = np.array([model.minus(*pair) for pair in zip(ran.mean, exact.mean)])
            apart, ratio = np.abs(errors) / double, fixed / double
        self.mean = max(self.mean, float(np.nanmax(apart)))
        least = np.nanmin(np.where(double > 0, double, np.inf), axis=0)
        self.least = np.minimum(self.least, least) if self.least.size else least
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
                record = in_whole_groups(drawn(model, ROWS, seed), product.given.together)
                ran = exact.run_record(record)
                made.add(model, FixedRun(product.arithmetic).run(record), ran)
                visited.append((ran.mean, np.sqrt(np.einsum("tii->ti", ran.covariance)), record.now, record.clock))
        made.lossy = lossy_formulas(model, product.arithmetic, visited)
    except KalmanqError as problem:
        made.why_not = str(problem)
    return made


def refuse_wrong(product: Product, found: Tried) -> None:
    """What the chip would not tell"""
    if found.mean > WRONG and not found.events and not found.refused:
        causes = _steps(product.arithmetic, found) or ["fixed point is too coarse for it: use --arith f32"]
        raise KalmanqError(f"q31: in simulated rows means are off by {found.mean:.2g} sigma, and no event says so: {' '.join(causes)}")


def _steps(device: FixedDevice, found: Tried) -> list[str]:
    """States and measurements of which a sigma has few steps, and what gives it more"""
    of = device.nonlinear
    noise = np.sqrt(np.concatenate([np.diag(np.atleast_2d(device.noise(one))) for one in device.sensors]).astype(float))
    given = [] if device.has_errors else [*zip(device.carried, of.carried, found.least)]
    made = []
    for one, declared, sigma in [*given, *zip(device.taken, of.measurements, noise)]:
        step = 2.0 ** -fraction_of(one)
        if step > STEP * sigma:
            how = "its innovations" if one in device.taken and not device.is_plain(device.taken.index(one)) else "it"
            made.append(f"{one.name}: a range of {one.range or 0:.3g} ({'declared' if declared.range else 'from the records'}) has steps of {step:.2g}, "
                        f"and sigma is {sigma:.2g} at least: declare a range of at most {2.0**31 * STEP * sigma:.2g}, if {how} may stop there, or "
                        "use --arith f32.")
    return made
