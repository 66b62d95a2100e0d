"""Is a nonlinear model fit for a filter: are its Jacobians right, do its functions agree, do its ranges fit?"""

from __future__ import annotations

import warnings
from typing import Optional

import numpy as np

from kalmanq.errors import KalmanqError, KalmanqWarning
from kalmanq.formulas.tracing import Untraced
from kalmanq.nonlinear import jacobians
from kalmanq.nonlinear.angles import turn_of
from kalmanq.nonlinear.calls import Instant
from kalmanq.nonlinear.filters import NonlinearFilter
from kalmanq.nonlinear.model import NonlinearModel
from kalmanq.nonlinear.simulation import simulate
from kalmanq.run.checks import Finding, note, prior_finding, ranges_refused, resolution_finding

DRAWN, SEED = 50, 1  # rows of a simulated run, where there are no data
Rows = tuple[np.ndarray, np.ndarray, Optional[np.ndarray]]  # z, u, times


def findings(model: NonlinearModel, rows: Optional[Rows] = None, arithmetic: Optional[str] = None) -> list[Finding]:
    """rows: measurements and controls to run through; otherwise simulated ones"""
    where, given = "along the data" if rows else f"along {DRAWN} simulated rows", rows
    try:
        if rows is None:
            _, *drawn = simulate(model, DRAWN, SEED)
            rows = drawn[0], drawn[1], None
        states = _moved(model, *rows[1:]) if model.has_errors else _run(_without_jacobians(model), rows, "f64").mean
        at = _instants(model, rows[2], len(states))
        points = jacobians.prior_points(model, at[0]) + jacobians.points_along(states, rows[1], at)
    except KalmanqError as problem:
        return [Finding(False, "run", f"{where}: {problem}")]
    made = [_jacobian(model, which, points, f"over the prior and {where}") for which in ("A", "H")]
    made.append(_formulas(model, points, f"over the prior and {where}"))
    for name, find in (("increment", jacobians.unlike_increment), ("innovation", jacobians.unlike_innovation)):
        if name in model.given and (name != "increment" or "f" in model.given):
            unlike = find(model, points)
            made.append(Finding(not unlike, name, unlike or "as f or h has it"))
    if model.takes_step and np.any(model.frame.Q) and not any("dt" in of.takes for key, of in model.given.items() if key in ("Q", "G")):
        made.append(note("Q", "takes no dt: a long step has no more noise than a short one"))
    made += [*_angles(model), resolution_finding(model, [arithmetic or "f32"], given and given[0])]
    if any(one.range for one in model.states) and not model.has_errors:
        made += [_ranges(model, rows, where), prior_finding(model.frame)]
    return made


def _instants(model: NonlinearModel, times: Optional[np.ndarray], rows: int) -> list[float]:
    """Of rows whose last one has the step before it, too"""
    at = model.instants(rows, times)
    return at if times is None or rows < 2 else [*at[:-1], Instant(times[-1], times[-1] - times[-2])]


def _moved(model: NonlinearModel, u: np.ndarray, times: Optional[np.ndarray]) -> np.ndarray:
    """Nominal numbers as f moves them"""
    made = [model.x0]
    for t, of in zip(model.instants(len(u), times), u[:-1]):
        made.append(model.moved(made[-1], t, of))
    return np.array(made)


def _without_jacobians(model: NonlinearModel) -> NonlinearModel:
    """So that wrong ones do not lead the run; the model itself, where they cannot be derived"""
    bare = model.without_jacobians()
    try:
        bare.formulas.derived_transition, bare.formulas.derived_measurement
    except Untraced:
        return model
    return bare


def _run(model: NonlinearModel, rows: Rows, arithmetic: str):  # type: ignore[no-untyped-def]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", KalmanqWarning)
        return NonlinearFilter(model, arithmetic).run(rows[0], rows[1] if model.l else None, times=rows[2])


def _jacobian(model: NonlinearModel, which: str, points: list[jacobians.Point], where: str) -> Finding:
    try:
        worst = jacobians.worst_entry(model, which, points)
    except Untraced as problem:
        return note(which, f"not compared: {problem}")
    if worst is None:
        return Finding(True, which, "not given; derived from the formulas")
    if worst.is_wrong:
        return Finding(False, which, str(worst))
    return Finding(True, which, f"as its function has it {where}, {len(points)} points; worst entry "
                   f"{which}[{worst.row}, {worst.column}], by {worst.share:.1e} of its row")


def _formulas(model: NonlinearModel, points: list[jacobians.Point], where: str) -> Finding:
    try:
        unlike = jacobians.unlike_formula(model, points)
    except Untraced as problem:
        return note("formulas", f"none, so kalmanq compile does not take the model: {problem}")
    return Finding(not unlike, "formulas", unlike or f"as the functions have it {where}: kalmanq compile takes the model")


def _angles(model: NonlinearModel) -> list[Finding]:
    return [note(f"angle {one.name}", f"is in {one.unit} and not among angles: where it passes half a turn its innovation jumps")
            for c, one in enumerate(model.measurements) if c not in model.angles and "innovation" not in model.given and turn_of(one.unit)]


def _ranges(model: NonlinearModel, rows: Rows, where: str) -> Finding:
    try:
        run = _run(model, rows, "q31")
    except KalmanqError as problem:
        return ranges_refused(model, f"{where}: {problem}")
    parts = NonlinearFilter(model, "q31").parts
    formats = ", ".join(f"{what}{one.name} Q{31 - bits}.{bits}" for which, what in (("states", ""), ("measurements", "innovation of "))
                        for one, bits in zip(getattr(model, which), parts.fractions(which)))
    if "saturated" in run.event_names:
        return Finding(False, "ranges", f"{where} a state saturated: {formats}")
    return Finding(True, "ranges", f"fit {where}: {formats}")
