"""For NAME_report.txt of a nonlinear model: how the C was tried, and what float does to the model's own formulas."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Sequence

import numpy as np

from kalmanq.compiler.algorithm.equation_device import Device
from kalmanq.compiler.given.request import Options
from kalmanq.compiler.run import trial
from kalmanq.compiler.run.equation_records import MISSING, drawn, irregular
from kalmanq.compiler.run.host import Host, Ran
from kalmanq.compiler.run.lint import Lossy, lossy_formulas
from kalmanq.compiler.run.record import Record, in_whole_groups, times_of
from kalmanq.compiler.text.equation_product import compiled_equations
from kalmanq.compiler.text.product import Product
from kalmanq.errors import KalmanqError
from kalmanq.nonlinear import NonlinearFilter, NonlinearModel, prior_points, simulate, wrong_entries
from kalmanq.nonlinear.jacobians import points_along, unlike_increment
from kalmanq.run.resolution import told_of

ROWS = 400
SEEDS = (1, 2, 3)
COARSE = 1e-2  # sigma: an error above is said first
FAINT = 0.05  # sigma: an error of a formula above is told


@dataclass(frozen=True)
class Findings:
    """Over simulated rows with missing components, beside the same C in double: errors of means in sigma and of covariances
    in sigma_i sigma_j; beside: of the C in double beside the library's filter; least: R / S of a component; lost: rows
    whose functions were not finite; first: error of means in as many rows as NAME_test.c has; coarse: what is said of measurements
    beside their noise"""

    mean: float
    covariance: float
    beside: float
    least: float
    lost: int
    lossy: Sequence[Lossy]
    why_not: str = ""
    first: float = 0.0
    coarse: str = ""

    @property
    def is_coarse(self) -> bool:
        return self.mean > COARSE

    @property
    def worst(self) -> list[Lossy]:
        return [one for one in self.lossy if one.error > FAINT]

    def names(self, product: Product) -> dict[str, Any]:
        """For report.txt.j2"""
        given, a = product.given, product.arithmetic
        tried = {"rows": ROWS, "seeds": len(SEEDS), "missing": MISSING, "is_compared": _is_compared(bool(given.nominal), given.options)}
        if isinstance(a, Device):
            return {"kind": "device", **tried}
        return {"kind": "equations", **tried, "smoother": product.text.smoother,
                "calls": [f"{given.name}_update{one.suffix}" for one in a.sensors], "watched": [given.measurements[j] for j in a.watched]}


def findings(model: NonlinearModel, product: Product, host: Host) -> Findings:
    """Where no record can be drawn, `why_not` says it."""
    try:
        return _findings(model, product, host)
    except KalmanqError as problem:
        return Findings(np.nan, np.nan, np.nan, np.nan, 0, (), str(problem))


def _findings(model: NonlinearModel, product: Product, host: Host) -> Findings:
    options, tried, points = product.given.options, [], []
    exact = compiled_equations(model, product.given.name, Options(**{**vars(options), "arithmetic": "f64"}))
    with Host(exact) as reference:
        for seed in SEEDS:
            record = in_whole_groups(drawn(model, ROWS, seed), product.given.together)
            runs = [one.run_record(record) for one in (host, reference)]
            tried.append((*_apart(model, *runs), float(_errors(model, *runs)[:trial.ROWS].max()), _lost(product, runs[0]),
                          *_library(model, options, record, runs[1])))
            points.append((runs[1].mean, _sigma(runs[1]), record.now, record.clock))
    mean, covariance, first, lost, beside, least = (np.array(column) for column in zip(*tried))
    return Findings(float(mean.max()), float(covariance.max()), float(beside.max()), float(least.min()), int(lost.sum()),
                    lossy_formulas(model, points) if options.arithmetic == "f32" else (), first=float(first.max()),
                    coarse=told_of(model, options.arithmetic))


def _sigma(ran: Ran) -> np.ndarray:
    return np.sqrt(np.einsum("tii->ti", ran.covariance).clip(1e-300))


def _lost(product: Product, ran: Ran) -> int:
    """Rows in which a call left mean and covariance as they were"""
    return int(np.sum(ran.events >> list(product.events).index("NOT_FINITE") & 1))


def _apart(model: NonlinearModel, ran: Ran, exact: Ran) -> tuple[float, float]:
    sigma = _sigma(exact)
    spread = np.abs(ran.covariance - exact.covariance) / (sigma[:, :, None] * sigma[:, None, :])
    return float(_errors(model, ran, exact).max()), float(spread.max())


def _errors(model: NonlinearModel, ran: Ran, exact: Ran) -> np.ndarray:
    """Of means, in sigma"""
    return np.abs([model.minus(*pair) for pair in zip(ran.mean, exact.mean)]) / _sigma(exact)


def _is_compared(has_errors: bool, options: Options) -> bool:
    """Is the library's filter the same?"""
    return not has_errors and options.gate is None and options.student is None


def _library(model: NonlinearModel, options: Options, record: Record, exact: Ran) -> tuple[float, float]:
    """How far the library's filter is off, in sigma, and the least R / S that it met"""
    if model.has_errors:
        return 0.0, np.nan
    method = "iterated" if options.iterate > 1 else "extended"
    run = NonlinearFilter(model, "f64", method, options.iterate).run(record.measured, record.now if model.l else None, times=times_of(record))
    R = np.diag(model.R) if model.R is not None else np.array([np.diag(model.measurement_noise(x, t, u)) for x, t, u in zip(
        run.mean, model.instants(len(record.z), times_of(record)), record.now)])
    shares = R / run.innovation_sigma**2
    off = float((np.abs(run.mean - exact.mean) / _sigma(exact)).max()) if _is_compared(model.has_errors, options) else 0.0
    return off, float(np.nanmin(shares, initial=1))


def refuse_wrong(model: NonlinearModel) -> None:
    """Jacobians of the model's own that are not those of its functions"""
    times = irregular(model, 50, SEEDS[0])
    x, _, u = simulate(model, 50, SEEDS[0], times=times)
    for one in wrong_entries(model, prior_points(model) + points_along(x, u, model.instants(len(x), times))):
        raise KalmanqError(f"{one}: correct it, or leave {one.which} out, and it is derived")
    both = {"f", "increment"} <= model.given.keys() and not model.has_errors
    if unlike := unlike_increment(model, prior_points(model)) if both else None:
        raise KalmanqError(f"increment: {unlike}: correct the one or leave the other out")
